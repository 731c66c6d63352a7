"""Scripts and formulas of a few bodies in contact."""
