"""Checks of a case as a whole, and warnings."""
