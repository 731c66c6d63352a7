"""Small packings with disorder, and the gaps in them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.lattices import KINDS, is_plane_crystal
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.packing import Packing

LATTICES = [kind for kind in KINDS if kind != "chain"]  # those that can be periodic

D = 0.01
SIZES = {"fcc": (7, 8, 6), "hcp": (6, 8, 5), "bcc": (6, 7, 8), "sc": (5, 6, 7), "square": (9, 8), "chain": (12,)}
ANY_SIZE = (6, 8, 7)  # of other kinds
INNER = 200  # sphere (3, 4, 3) of the fcc packing
BALL = {"index": INNER, "diameter": (2 * math.sqrt(2) - 1) * D}  # in fcc without its neighbors: touches the six next


def case_of(kind: str = "fcc", size: tuple[int, ...] | None = None, **tables: Any) -> Case:
    size = size or SIZES.get(kind, ANY_SIZE[: len(KINDS[kind].axes)])
    equal = is_plane_crystal(kind) and tables.get("boundary", {}).get("sides") == "periodic"
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
    return assemble(case or case_of()).lattice.neighbours(sphere)


def all_gaps(packing: Packing) -> np.ndarray:
    """Gaps between the surfaces of all pairs of spheres, with the nearest image: (n, n), m; infinite on the diagonal."""
    step = packing.positions[None] - packing.positions[:, None]
    if packing.lattice.periodic:
        for axis, length in enumerate(packing.lattice.lengths):
            step[..., axis] -= length * np.round(step[..., axis] / length)
    diameter = packing.atoms.get_array("diameters")
    gaps = np.linalg.norm(step, axis=2) - (diameter[None] + diameter[:, None]) / 2
    np.fill_diagonal(gaps, np.inf)
    return gaps
