"""Cases and networks of springs for tests of small waves."""

from __future__ import annotations

from typing import Any

import numpy as np

from granwave.extensions.waves.spectra.network import Network, Springs
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.statics.bodies import across, joined


def endless(kind: str, size: Any, load: dict[str, Any], **tables: Any) -> Case:
    """A Hertzian brass packing of spheres of 10 mm under a static load."""
    packing = {"kind": kind, "size": size, "diameter": 0.01} | tables.pop("packing", {})
    given = {"name": kind, "material": "brass", "packing": packing, "contact": {"law": "hertz"}}
    bottom = "free" if load["kind"] == "uniform" else "wall"
    return case_from_dict(given | {"precompression": load, "boundary": {"bottom": bottom}} | tables)


def network(
    mass: list[float],
    pairs: list[tuple[int, int, int, tuple[float, float, float], float]],
    moves: list[str],
    period: float,
    ground: list[tuple[int, tuple[float, float, float], float]] = (),
) -> Network:
    """A chain of springs along z without static force: (first, second, cells between, normal,
    stiffness).
    """
    first, second, image, normal, stiffness = (np.array(one) for one in zip(*pairs, strict=True))
    n = len(first)
    springs = Springs(
        first, second, image[:, None], normal.astype(float), np.full(n, period), np.zeros(n), stiffness, np.zeros(n),
        np.full((n, 2), period / 2), across(normal),
    )  # fmt: skip
    rows = np.array([one[0] for one in ground], dtype=np.int64)
    vectors = np.array([one[1] for one in ground], dtype=float).reshape(-1, 3)
    m = len(rows)
    none = np.zeros(len(rows))
    supports = Springs(
        rows, np.full(m, -1), np.zeros((m, 1), dtype=int), vectors, np.full(m, np.inf), none,
        np.array([one[2] for one in ground]), none, np.zeros((m, 2)), np.zeros((m, 3, 3)),
    )  # fmt: skip
    free = np.array([[axis in one for axis in "xyz"] + [False] * 3 for one in moves])
    masses = np.array(mass)
    places = np.zeros((len(mass), 3))
    periods = np.array([[0.0, 0.0, period]])
    return Network(
        np.arange(1, len(mass) + 1),
        places,
        masses,
        masses,
        free,
        periods,
        joined([springs, supports]),
    )
