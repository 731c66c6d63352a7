"""Contact forces from measured grains."""

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="inference",
    title="contact forces from measured grains",
    packages={"clarabel": "clarabel"},
    extra="inference",
)
