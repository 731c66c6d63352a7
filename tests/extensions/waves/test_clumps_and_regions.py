"""Clumps and walls of regions, which small waves do not support."""

from __future__ import annotations

from typing import Any

import pytest

from granwave.extensions.waves.spectra.cells import unit_cell
from granwave.extensions.waves.spectra.finite import refuse_parts
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble

DIMER = "x,y,z,diameter,clump\n0,0,0,0.01,1\n0.006,0,0,0.01,1\n0,0,-0.02,0.01,0\n"


@pytest.mark.parametrize(
    ("tables", "fault"),
    [
        ({}, "found clump 1 of 2 grains, expected single grains"),
        ({"wall": [{"region": "sphere 0 0 0 0.1"}]}, "wall.1: found a region wall"),
    ],
)
def test_small_waves_refuse_them(tables: dict[str, Any], fault: str) -> None:
    grains = DIMER.replace(",1\n", ",0\n").replace("0.006", "0.016") if tables else DIMER
    packing = {"kind": "file", "grains": grains}
    case = {"name": "a", "packing": packing, "material": "brass", "boundary": {"bottom": "free"}}
    assembly = assemble(case_from_dict(case | tables))
    for use in (unit_cell, refuse_parts):
        with pytest.raises(InputError, match=fault):
            use(assembly)
