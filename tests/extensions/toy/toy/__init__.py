"""Example of an extension of granwave: a lattice, a load, a value, a figure and a command."""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="toy",
    title="simple hexagonal packings, falling spheres, participation of contacts",
    lattices="toy.lattices:LATTICES",
    loads="toy.loads:LOADS",
    summary="toy.results:summary_values",
    quantities="toy.results:QUANTITIES",
    figures={"ranked_forces": "toy.results:RANKED_FORCES"},
    commands="toy.commands:COMMANDS",
)
