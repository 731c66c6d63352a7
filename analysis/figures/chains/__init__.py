"""Figures of chains, several runs together."""
