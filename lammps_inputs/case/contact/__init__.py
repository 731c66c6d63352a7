"""``[contact]`` and ``[[pair]]``: contact law, friction, damping, cohesion and initial indentation.

    contact          keys of both tables
    tables           tables inside them: damping, resistances, cohesion, initial indentation
    law_parameters   keys that are parameters of contact laws, from the table of laws in C++
    law_file         a contact law from another file, ``law = "fit.toml"``

The forces of these laws are in `granwave.lammps_inputs.contact`.
"""
