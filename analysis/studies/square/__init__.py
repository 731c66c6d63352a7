"""Packings struck by spheres: where the energy goes, and the waves in the chains of a square packing."""
