"""Continuum references: a punch on a block and the contact of two spheres by finite elements, fits
of the contact law, and comparison of packings with blocks.
"""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="continuum",
    title="finite-element references, fits of the contact law, comparison of packing and block",
    packages={"skfem": "scikit-fem", "numba": "numba"},
    extra="continuum",
    folder=Path(__file__).parent,
    result_kinds="granwave.extensions.continuum.files:RESULT_KINDS",
    case_keys="granwave.extensions.continuum.case_keys:CASE_KEYS",
    quantities="granwave.extensions.continuum.quantities:QUANTITIES",
    studies={"sphere-contact": "granwave.extensions.continuum.sphere_contact.study"},
    comparisons={"comparison": "granwave.extensions.continuum.packing_and_block.study"},
    report="granwave.extensions.continuum.report:REPORT_KINDS",
    case_kinds="granwave.extensions.continuum.kinds:CASE_KINDS",
    file_kinds="granwave.extensions.continuum.kinds:FILE_KINDS",
    commands="granwave.extensions.continuum.commands:COMMANDS",
    check="granwave.extensions.continuum.counterpart:check",
)
