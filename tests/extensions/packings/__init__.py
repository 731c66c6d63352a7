"""Tests of poured and compressed packings."""
