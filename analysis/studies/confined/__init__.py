"""Confined rows: beads with rings of small spheres in a tube (thesis chapter 6)."""
