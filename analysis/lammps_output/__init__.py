"""Readers of the files that LAMMPS writes."""
