"""Quantities that are measured on a run: planes, plastic zone, waves, targets, sensors."""
