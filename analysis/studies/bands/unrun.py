"""Bands of packings that need no run: square with friction, and FCC with scattered diameters, beside what is known."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from granwave.analysis.spectra.band_structure import long_wave_speeds
from granwave.analysis.spectra.states import cell_state
from granwave.analysis.spectra.stiffness import stiffness_of
from granwave.analysis.studies.study import Row
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict

_SCATTER = 1e-6  # m
_SEED = 1


def rows_of_square(like: Case) -> Iterator[Row]:
    """Edges at X of a square packing of such spheres with friction under pressure: closed forms, to rounding."""
    case = _case(like, {"kind": "square", "size": [4, 4]}, 1e5, {"bottom": "free"}, friction=0.3)
    network = cell_state(case).network
    springs, mass, inertia = network.springs, float(network.mass[0]), float(network.inertia[0])
    k, kt, f, d = (float(one[0]) for one in (springs.stiffness, springs.tangential, springs.force, springs.distance))
    lever = float(springs.lever[0, 0])
    at_edge = np.array([[math.pi / like.packing.diameter, 0.0, 0.0]])
    ours = np.sqrt(np.sort(np.linalg.eigvalsh(stiffness_of(network).dense(at_edge)[0]))) / (2 * math.pi)
    known = {
        "longitudinal, 4 k/m": 4 * k / mass,
        "transverse, 4 (k_t - F/d)/m": 4 * (kt - f / d) / mass,
        "rotational, 4 k_t l^2/I": 4 * kt * lever**2 / inertia,
    }
    order = np.argsort(list(known.values()))
    for place, number in enumerate(order.tolist()):
        name, square = list(known.items())[number]
        theory = math.sqrt(square) / (2 * math.pi)
        quantity = f"Square with friction, 1e+05 Pa, omega^2 at the edge of the zone: {name}"
        yield Row(quantity, "Hz", None, float(ours[place]), "", "", theory, True)


def rows_of_scatter(like: Case) -> Iterator[Row]:
    """Speeds of long waves along [111] in a cell of FCC with scattered diameters, beside like spheres."""
    boundary = {"sides": "periodic", "bottom": "periodic"}
    direction = np.array([[0.0, 0.0, 1.0]])
    speeds = []
    for scatter in ({}, {"diameter_scatter": _SCATTER, "seed": _SEED}):
        case = _case(like, {"kind": "fcc", "size": [6, 6, 6], **scatter}, 1e6, boundary)
        speeds.append(long_wave_speeds(stiffness_of(cell_state(case).network), direction)[0])
    for name, place in (("transverse", 0), ("longitudinal", -1)):
        yield Row(
            f"Speed of {name} waves along [111] of FCC, 1e+06 Pa from all sides, scatter of 1 um", "m/s", None,
            float(speeds[1][place]), "like spheres", "Smaller spheres bear less.", float(speeds[0][place]),
        )  # fmt: skip


def _case(
    like: Case, packing: dict[str, Any], pressure: float, boundary: dict[str, Any], friction: float = 0.0
) -> Case:
    """A case of spheres as those of another, under pressure from all sides."""
    material = like.to_dict()["material"]
    return case_from_dict(
        {
            "name": packing["kind"],
            "material": material,
            "packing": {"diameter": like.packing.diameter, **packing},
            "contact": {"law": "hertz", "friction": friction},
            "precompression": {"kind": "uniform", "pressure": pressure},
            "boundary": boundary,
        }
    )
