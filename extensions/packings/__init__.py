"""Disordered packings that LAMMPS pours or compresses, and statistics of packings."""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="packings",
    title="poured and compressed packings, and their statistics",
    folder=Path(__file__).parent,
    commands="granwave.extensions.packings.commands:COMMANDS",
    packings="granwave.extensions.packings.makers:MAKERS",
)
