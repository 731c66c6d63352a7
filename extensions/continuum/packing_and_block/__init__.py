"""Packings against each other and against the continuum: what many runs say together."""
