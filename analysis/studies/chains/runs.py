"""Finished runs of chains, with their arrays in the order of the chain."""

from __future__ import annotations

from collections.abc import Iterable

from granwave.analysis.measures.chains.record import ChainRecord
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.material import Material


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


def elastic_constants(own: Material) -> tuple[float, float, float]:
    """Young's modulus (Pa), Poisson's ratio and density (kg/m^3)."""
    return own.youngs_modulus, own.poisson_ratio, own.density
