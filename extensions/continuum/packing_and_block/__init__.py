"""Comparison of packings with each other and with the continuum, over many runs."""
