"""Rows of beads with rings of small spheres in a tube (thesis chapter 6): geometry, motion, asymptotics."""
