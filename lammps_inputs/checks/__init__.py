"""Checks that concern several tables of a case, and warnings."""
