"""Finished runs of chains, with their arrays in the order of the chain."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from granwave.analysis.measures.chain_record import ChainRecord
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.runs import FinishedRun


class ChainRun(FinishedRun, ChainRecord):
    """A finished run of a chain."""


def chain_runs(runs: Iterable[FinishedRun]) -> list[ChainRun]:
    """Runs of chains of two beads and more; none with a past, such as precompression."""
    return [
        run.seen_as(ChainRun)
        for run in runs
        if run.case.packing.kind == "chain" and run.assembly.lattice.n_spheres > 1 and not run.case.has_initial_dents
    ]


def uniform(runs: Sequence[ChainRun], law: str) -> list[ChainRun]:
    """Recorded runs of like beads under one law, without bars and strikers."""
    return [run for run in runs if run.case.contact.law == law and run.assembly.plain and run.recorded]


def columns(records: Sequence[Any], *names: str) -> list[Array]:
    """Attributes of records as arrays, one for each name: (n_records,)."""
    return [np.array([getattr(record, name) for record in records]) for name in names]


def clustered(records: Iterable[Any], key: str, share: float) -> list[list[Any]]:
    """Records together whose values of an attribute differ by less than a share, in its rising order."""
    groups: list[list[Any]] = []
    for record in sorted(records, key=lambda record: float(getattr(record, key))):
        if not groups or getattr(record, key) > (1 + share) * getattr(groups[-1][0], key):
            groups.append([])
        groups[-1].append(record)
    return groups
