"""Contact forces inferred from measured grains."""
