"""The LAMMPS deck: input script and data file."""
