"""One run: LAMMPS driven from case to figures."""
