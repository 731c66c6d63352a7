"""Formatting of numbers, units and values of a case for readers."""
