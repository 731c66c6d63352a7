"""Spheres that were pressed before: dents that keep contacts elastic up to the force they were pressed with.

A contact that once bore F_p unloads and reloads on one curve and loses nothing up to F_p (thesis 1.1, 2.1). Dents leave
gaps between spheres at nominal places; a small static load closes them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from itertools import groupby

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.chains.preconditioned import dissipation_by_level, forces_by_level
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression import quantities
from granwave.analysis.studies.precompression.runs import DentedRun, past_runs, released_energy_note
from granwave.analysis.studies.runs import FinishedRun, grouped, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import values_table
from granwave.analysis.studies.titles import packing_title

Runs = Sequence[DentedRun]

_VARYING = ("contact.initial_overlap", "load.velocity")
_ELASTIC = 1e-9  # share of the input: nothing is dissipated


def select(runs: Sequence[FinishedRun]) -> list[list[DentedRun]]:
    """Each chain and packing that was struck with dents of one size everywhere, and without, by level and velocity."""
    chosen = [run for run in past_runs(runs) if run.case.contact.yields and np.isfinite(run.level)]
    groups = [group for group in grouped(chosen, *_VARYING) if any(run.level for run in group)]
    return [sorted(group, key=lambda run: (run.level, run.case.load.velocity)) for group in groups]


def title(runs: Runs) -> str:
    """By packing."""
    return f"Preconditioned: {packing_title(runs[0].case)}"


def text(runs: Runs) -> str:
    """Describe the runs: effect of dents, and whether their gaps are closed."""
    closed = "are closed by a static load, which stays on."
    gaps = closed if runs[0].case.precompression else "are there at the impact."
    return (
        "Contacts that have dents from the start, of one force everywhere: they shall stay elastic up to that force. "
        f"The gaps that dents leave between spheres at their nominal places {gaps}{released_energy_note(runs)}"
    )


def rows(runs: Runs) -> Iterator[Row]:
    """Range in which contacts stay elastic, and dissipation just beyond."""
    for level, series in _by_level(runs):
        elastic = [run for run in series if run.dissipated < _ELASTIC]
        losing = [run for run in series if run.dissipated >= _ELASTIC]
        for found, which, choose in ((elastic, "Largest force without", max), (losing, "Smallest force with", min)):
            if found and level:
                force = choose(map(quantities.PEAK_FORCE.value, found))
                quantity = f"{which} dissipation over that of the preconditioning, {level:g} N"
                remark = f"Theory: the two are on either side of 1; of {len(series)} impacts."
                yield Row(quantity, "", None, force / level, "thesis 1.1", remark, 1.0)


def tables(runs: Runs) -> list[Table]:
    """All impacts; without what arrives at the bottom where nothing does."""
    largest = dataclasses.replace(quantities.PEAK_FORCE, heading="Largest force")
    shown = [quantities.LEVEL, quantities.IMPACT, largest, quantities.DISSIPATED, quantities.GREW]
    if any(run.transmitted for run in runs):
        shown.append(quantities.TRANSMITTED)
    return [values_table("Impacts with and without preconditioning", runs, shown)]


def verdict(runs: Runs) -> Iterator[str]:
    """Fresh contacts beside those of the highest level."""
    series = _one_velocity(runs)
    fresh, best = series[0], series[-1]
    if fresh.level == 0 and best is not fresh:
        yield (
            f"Impact at {fresh.case.load.velocity:g} m/s: fresh contacts dissipate {100 * fresh.dissipated:.3g} %, "
            f"those preconditioned to {best.level:g} N {100 * best.dissipated:.3g} %."
            + released_energy_note((fresh, best))
        )


def pictures(runs: Runs) -> Iterator[Picture]:
    """Dissipation, and in chains the largest force along them."""
    levels = [
        (level, quantities.PEAK_FORCE.shown(series), quantities.DISSIPATED.shown(series))
        for level, series in _by_level(runs)
    ]
    caption = "Dissipation against the largest force, by preconditioning"
    yield Picture("_dissipation", caption, dissipation_by_level(levels))
    fastest = _one_velocity(runs) if runs[0].case.packing.kind == "chain" else []
    if len(fastest) > 1:
        caption = f"Largest force along the chain, impact at {fastest[0].case.load.velocity:g} m/s"
        pulses = [(run.level, run.seen_as(ChainRun).of_contacts("peak_force")) for run in fastest]
        yield Picture("_pulse", caption, forces_by_level(pulses))


def _by_level(runs: Runs) -> list[tuple[float, list[DentedRun]]]:
    return [(level, list(series)) for level, series in groupby(runs, key=lambda run: run.level)]


def _one_velocity(runs: Runs) -> list[DentedRun]:
    """Runs by level at the velocity that most levels have, the largest of such."""
    same = max(grouped(runs, "contact.initial_overlap"), key=lambda one: (len(one), one[0].case.load.velocity))
    return rising(same, lambda run: run.level)
