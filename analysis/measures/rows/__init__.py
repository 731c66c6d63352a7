"""Rows of spheres with cylinders beside them."""
