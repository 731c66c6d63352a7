"""The packing: where its spheres, strikers, walls and bars are."""
