"""Bands, modes and transmission: computed, and written to a directory."""
