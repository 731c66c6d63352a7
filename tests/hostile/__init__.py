"""Tests with hundreds of invalid and unusual inputs, each with the expected message to the user."""
