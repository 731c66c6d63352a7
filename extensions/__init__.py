"""Features outside the core, a folder each; `granwave.lammps_inputs.extensions` finds them."""
