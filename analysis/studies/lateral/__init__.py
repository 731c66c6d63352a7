"""Plane crystals of soft cylinders under a plate: what side walls do to a wave."""
