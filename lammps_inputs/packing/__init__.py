"""The packing: positions of spheres, strikers, walls and bars."""
