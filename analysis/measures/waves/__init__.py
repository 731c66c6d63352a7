"""Waves in packings: fronts, directions, speeds, pulses along lines of grains."""
