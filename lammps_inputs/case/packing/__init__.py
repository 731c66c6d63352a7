"""``[packing]``: a lattice, grains of a file, or grains that an extension makes.

    packing        keys of the table, and the sizes of lattices
    values         types of the values of these keys
    reading        the table with its grains: from a file, the table itself or a restart file
    grain_file     keys for reading ``packing.file``
    grains         grains of a file: position, diameter, material, velocity
    contact_ways   start of contacts that overlap or nearly touch
    springs        tangential springs of a settled bed
    made_packing   packings that extensions make before the case is read

Lattices are in `granwave.lammps_inputs.lattices`, formats of files in
`granwave.lammps_inputs.readers`.
"""
