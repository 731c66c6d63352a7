"""Disordered packings that LAMMPS makes: poured under gravity, or compressed; and their statistics."""

from pathlib import Path

from granwave.lammps_inputs.extensions import Extension

extension = Extension(
    name="packings",
    title="poured and compressed packings, and statistics of packings",
    folder=Path(__file__).parent,
    packings="granwave.extensions.packings.makers:MAKERS",
)
