"""Figures of packings, several runs together."""
