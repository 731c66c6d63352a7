"""Bands beside sources, closed forms and simulated waves."""
