"""Quantities that are measured on a run: plastic zone, impact, waves, chains, driven rows, targets,
sensors.
"""
