"""A chain of like beads: if it is that of the thesis, what pushes it, and how far its wave has come."""

from __future__ import annotations

import math

import numpy as np

from granwave.analysis.studies.chains.runs import ChainRun
from granwave.lammps_inputs.case.material import material

_UNTOUCHED = 1e-3  # of the largest force, at the last contact
_BRASS = (115e9, 0.30, 8500.0, 9.52e-3)  # E (Pa), nu, rho (kg/m^3), diameter (m) of thesis chapters 2 to 4


def from_thesis(run: ChainRun) -> bool:
    """The beads are those of thesis chapters 2 to 4."""
    own = run.case.material
    ours = (own.youngs_modulus, own.poisson_ratio, own.density, run.case.packing.diameter)
    return all(math.isclose(a, b, rel_tol=1e-3) for a, b in zip(ours, _BRASS, strict=True))


def of_thesis(run: ChainRun) -> bool:
    """The beads are those of thesis chapters 2 to 4, with their yield strength."""
    own, brass = run.case.material.yield_strength or math.inf, material("brass").yield_strength or 0.0
    return from_thesis(run) and math.isclose(own, brass, rel_tol=1e-3)


def impulse_of(run: ChainRun) -> float:
    """Return the impulse that the load gives to the first bead, N s."""
    return run.mass * run.load.velocity if run.load.kind == "impact" else run.load.impulse


def is_pulse(run: ChainRun) -> bool:
    """One bead is hit, or pushed by a force of one sign for a time."""
    if run.load.kind == "impact":
        return run.load.spheres == 1
    return run.load.kind == "force" and run.load.shape in ("rectangle", "half-sine")


def undisturbed(run: ChainRun) -> bool:
    """The front has not come to the far end: the run is that of an endless chain."""
    largest = float(run.force.max(initial=0.0))
    return largest > 0 and float(run.force[:, -1].max()) < _UNTOUCHED * largest


def passed(run: ChainRun) -> int:
    """The last contact, from 1, that the crest of the leading wave has passed; 0: none."""
    crest = run.force.argmax(axis=0)
    over = np.flatnonzero((crest > 0) & (crest < len(run.time) - 2))
    return int(over[-1]) + 1 if len(over) else 0
