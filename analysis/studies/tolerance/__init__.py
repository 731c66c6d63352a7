"""Tolerances: performance of packings whose spheres scatter in size and have friction."""
