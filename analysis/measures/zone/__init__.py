"""Size of the plastic zone, and what cuts it."""
