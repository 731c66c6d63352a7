"""Elastic bars, and chains that end on them."""
