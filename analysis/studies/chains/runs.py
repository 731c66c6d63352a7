"""Finished runs of chains, with their arrays in the order of the chain."""

from __future__ import annotations

import math
from collections.abc import Iterable

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.material import Material

#: E (Pa), nu, rho (kg/m^3), D (m) and sigma_y (Pa) of the beads of thesis chapters 2 to 4.
_BRASS = (115e9, 0.30, 8500.0, 9.52e-3, 550e6)


class ChainRun(FinishedRun, ChainRecord):
    """A finished run of a chain."""


def chain_runs(runs: Iterable[FinishedRun]) -> list[ChainRun]:
    """Runs of chains of two beads and more; none with a past, such as precompression."""
    return [
        run.seen_as(ChainRun)
        for run in runs
        if run.case.packing.kind == "chain" and run.assembly.lattice.n_spheres > 1 and not run.case.has_initial_dents
    ]


def uniform(runs: Iterable[FinishedRun], law: str) -> list[ChainRun]:
    """Recorded chains of like beads under one law, without bars and strikers."""
    return [
        run for run in chain_runs(runs) if run.case.contact.law == law and run.assembly.plain and run.recorded
    ]  # fmt: skip


def from_thesis(run: ChainRecord, *, yielding: bool = False) -> bool:
    """The beads are those of thesis chapters 2 to 4; where they yield, with their yield strength too."""
    ours = [*elastic_constants(run.case.material), run.case.packing.diameter]
    if yielding:
        ours.append(run.case.material.yield_strength or math.inf)
    return all(math.isclose(a, b, rel_tol=1e-3) for a, b in zip(ours, _BRASS, strict=False))


def elastic_constants(own: Material) -> tuple[float, float, float]:
    """Young's modulus (Pa), Poisson's ratio and density (kg/m^3)."""
    return own.youngs_modulus, own.poisson_ratio, own.density
