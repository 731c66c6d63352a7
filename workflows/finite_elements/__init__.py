"""The finite-element references: a punch on a block, and two spheres pressed together."""
