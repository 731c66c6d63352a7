"""Tests of small waves about a static state."""
