"""The LAMMPS input script and its files: input script and data file."""
