"""Finite-element references: a punch on a block, and the contact of two spheres."""
