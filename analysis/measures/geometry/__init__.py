"""Planes, directions and places in packings."""
