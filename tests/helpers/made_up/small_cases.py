"""Small cases: the smallest as tables and as a file, with changes and the faults that these have;
chains; packings with disorder.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.lattices import lattice_kinds
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.packing import Packing
from granwave.workflows import load_case

MINIMAL: dict[str, Any] = {
    "packing": {"kind": "fcc", "size": [12, 12, 6], "diameter": 0.01},
    "material": "brass",
}
TWO_SPHERES = load_case("two-spheres", ["run.frames=3"])
FILE = 'material = "brass"\n[packing]\nkind = "fcc"\nsize = [12, 12, 6]\ndiameter = 0.01\n'


def changed(**changes: Any) -> dict[str, Any]:
    return apply_overrides(
        MINIMAL, {key.replace("__", "."): value for key, value in changes.items()}
    )


def faults_of(**changes: Any) -> list[str]:
    with pytest.raises(InputError) as caught:
        case_from_dict(changed(**changes), "my.toml")
    return caught.value.errors


BRASS = {"youngs_modulus": 115e9, "poisson_ratio": 0.30, "density": 8500.0, "yield_strength": 550e6}
DIAMETER = 9.52e-3
PULSE = {"kind": "force", "shape": "half-sine", "amplitude": 4e3, "duration": 2e-5}


def case_of(size: int = 12, **tables: Any) -> Case:
    """A chain of brass beads, free at the bottom unless the tables set it otherwise."""
    tables = {
        "boundary": {"bottom": "free"},
        "contact": {"law": "elastoplastic"},
        "run": {"end_time": 1.5e-4},
    } | tables
    packing = {"kind": "chain", "size": size, "diameter": DIAMETER}
    return case_from_dict({"name": "chain", "material": BRASS, "packing": packing} | tables)


LATTICES = [kind for kind in lattice_kinds() if kind != "chain"]  # those that can be periodic
D = 0.01
SIZES = {
    "fcc": (7, 8, 6),
    "hcp": (6, 8, 5),
    "bcc": (6, 7, 8),
    "sc": (5, 6, 7),
    "square": (9, 8),
    "chain": (12,),
}
ANY_SIZE = (6, 8, 7)  # of other kinds
INNER = 200  # sphere (3, 4, 3) of the fcc packing
BALL = {
    "index": INNER,
    "diameter": (2 * math.sqrt(2) - 1) * D,
}  # in fcc without its neighbors: touches the six next


def packing_of(kind: str = "fcc", size: tuple[int, ...] | None = None, **tables: Any) -> Case:
    size = size or SIZES.get(kind, ANY_SIZE[: len(lattice_kinds()[kind].axes)])
    equal = (
        lattice_kinds()[kind].is_plane_crystal
        and tables.get("boundary", {}).get("sides") == "periodic"
    )
    packing = {
        "kind": kind,
        "size": list(size) if len(size) > 1 else size[0],
        "diameter": D,
        **({"top_row": "equal"} if equal else {}),
        **tables.pop("packing", {}),
    }
    return case_from_dict({"name": "test", "packing": packing, "material": "brass", **tables})


def diameters(case: Case) -> np.ndarray:
    return assemble(case).sphere_diameters()


def around(sphere: int, case: Case | None = None) -> list[int]:
    return assemble(case or packing_of()).lattice.neighbours(sphere)


def all_gaps(packing: Packing) -> np.ndarray:
    """Gaps between the surfaces of all pairs of spheres, with the nearest image: (n, n), m;
    infinite on the diagonal.
    """
    step = packing.positions[None] - packing.positions[:, None]
    if packing.lattice.periodic:
        for axis, length in enumerate(packing.lattice.lengths):
            step[..., axis] -= length * np.round(step[..., axis] / length)
    diameter = packing.atoms.get_array("diameters")
    gaps = np.linalg.norm(step, axis=2) - (diameter[None] + diameter[:, None]) / 2
    np.fill_diagonal(gaps, np.inf)
    return gaps


def grains_at(places: Any, *, diameter: float = D, groups: Any = None) -> dict[str, Any]:
    """Table [packing] of grains at positions (n, 3), m, optionally with the names of their
    groups.
    """
    rows = [",".join(map(repr, [*map(float, place), diameter])) for place in places]
    rows = [f"{row},{group}" for row, group in zip(rows, groups or [""] * len(rows), strict=True)]
    return {"kind": "file", "grains": "x,y,z,diameter,group\n" + "\n".join(rows)}
