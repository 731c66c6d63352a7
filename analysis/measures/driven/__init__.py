"""Rows of grains under a load that oscillates, or that pushes them once or twice."""
