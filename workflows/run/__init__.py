"""One run from case to figures, with LAMMPS."""
