"""Figures of small waves: bands, curves over a plane, modes, transmission."""
