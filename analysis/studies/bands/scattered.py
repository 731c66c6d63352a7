"""Frequencies at which a packing of scattered diameters answers to a plane wave along z, from a piece of it.

The piece repeats in all directions. Each mode at a wave vector k holds a share of the plane wave, in which the spheres
move along z by exp(i k z). The line that a transform of the motion shows is at the mode of the largest share; the mean
of it and of those near to it, weighed by their shares, is taken.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.spectra.states import cell_state
from granwave.analysis.spectra.stiffness import Stiffness, stiffness_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict

_LAYERS = 12  # of the piece: a multiple of 2 and of 3
_WIDTH = 0.05  # of the frequency: modes around the largest share


def without_scatter(case: Case) -> Case:
    """Return the case with like spheres."""
    return _changed(case, {"diameter_scatter": 0.0}, {})


def scattered_line(case: Case, k: float) -> float:
    """Return the frequency of the plane longitudinal wave of the wave number k along z, rad/m, in Hz."""
    stiffness = _piece(case.to_toml())
    network = stiffness.network
    values, vectors = np.linalg.eigh(stiffness.dense(np.array([[0.0, 0.0, k]]))[0])
    grain, direction = network.freedoms
    # the phase between cells is that of their periods alone; within a cell it is that of the places
    wave = np.where(direction == 2, np.sqrt(network.masses) * np.exp(1j * k * network.position[grain, 2]), 0.0)
    share: Array = np.abs(wave.conj() @ vectors) ** 2
    frequency = np.sqrt(np.maximum(values, 0.0)) / (2 * math.pi)
    near = np.abs(frequency / frequency[int(np.argmax(share))] - 1) < _WIDTH
    return float(np.average(frequency[near], weights=share[near]))


@cache
def _piece(case: str) -> Stiffness:
    import tomllib

    whole = case_from_dict(tomllib.loads(case), "case")
    nx, ny, _ = whole.packing.size
    return stiffness_of(
        cell_state(_changed(whole, {"size": [nx, ny, _LAYERS]}, {"sides": "periodic", "bottom": "periodic"})).network
    )


def _changed(case: Case, packing: dict[str, object], boundary: dict[str, object]) -> Case:
    data = case.to_dict()
    keep = {name: data[name] for name in ("name", "material", "contact", "precompression") if name in data}
    return case_from_dict(
        keep | {"packing": data["packing"] | packing, "boundary": data.get("boundary", {}) | boundary}
    )
