"""A filter with yielding contacts, struck hard: what it leaves of a weak pulse before and after."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.figures.series import COLOURS, MARKS, column_name, panels
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.driven.two_pushes import largest_of_pulses, push_starts
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.rows.filter import FilterRun
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row

TITLE = "The filter after a strong pulse"
TEXT = (
    "Beyond the source, whose contacts are elastic: a sphere of the pressed row is pushed weakly, in a row that is "
    "whole, and in one through which a strong pulse has gone. Yielding takes from the weak pulse far more than the "
    "filter does; a strong pulse dents the contacts, which are then elastic up to larger forces, and slackens the "
    "walls. In the elastic row the weak pulse runs into what still swings behind the strong one, so that its peaks are "
    "those of both. Grains rattle in rows that yield: with other timesteps single peaks there change by up to a "
    "quarter, the decay by 2 %. Contact n is that of spheres n and n + 1; the decay is that of ln(peak force) over the "
    "contacts named."
)
_WHERE = "not in the source"
_PROBE = re.compile(r"contact_(\d+)_(\d+)_force")
_COMPARED, _DECAY = (26, 41, 61), (26, 61)  # contacts
_BEFORE = 2e-5  # s: what the walls bear is averaged over this time before the weak push


class PushedFilter(FilterRun):
    """A finished run of a row with cylinders, a sphere of which is pushed once or twice."""

    @property
    def starts(self) -> list[float]:
        """Times of the pushes, s."""
        return push_starts(self.case.load.table)

    @property
    def after(self) -> bool:
        """A strong push comes before the weak one."""
        return len(self.starts) == 2

    @cached_property
    def pulses(self) -> dict[int, tuple[float, float]]:
        """Largest force of the strong pulse, 0 if there is none, and of the weak one, N, by contact."""
        found = {}
        with Result(self.directory) as result:
            time = result["probes/time"]
            for name in result.names("probes"):
                match = _PROBE.fullmatch(name)
                if not match or int(match[2]) != int(match[1]) + 1 or int(match[2]) > self.n_spheres:
                    continue
                force = result[f"probes/{name}"]
                apart = self.starts[-1] - self.starts[0]
                both = largest_of_pulses(time, force, apart) if self.after else (0.0, float(force.max()))
                found[int(match[1])] = both
        return dict(sorted(found.items()))

    @property
    def weak(self) -> tuple[Array, Array]:
        """Contacts that were recorded, and the largest force of the weak pulse there, N."""
        return np.array(list(self.pulses), dtype=float), np.array([both[1] for both in self.pulses.values()])

    @property
    def weak_decay(self) -> float:
        """Decay of the weak pulse per contact; NaN if too little was recorded."""
        contacts, force = self.weak
        chosen = (contacts >= _DECAY[0]) & (contacts <= _DECAY[1]) & (force > 0)
        return -float(np.polyfit(contacts[chosen], np.log(force[chosen]), 1)[0]) if chosen.sum() > 1 else math.nan

    @cached_property
    def pressed(self) -> float:
        """Force on a wall just before the weak push over that at the start."""
        with Result(self.directory) as result:
            time, force = result["walls/xlo/time"], result["walls/xlo/force"]
        last = self.starts[-1]
        chosen = (time >= last - _BEFORE) & (time <= last)
        return float(force[chosen].mean() / force[0])

    @property
    def words(self) -> str:
        """``yielding, after a strong pulse``."""
        yields = "elastic" if self.law == "hertz" else "yielding"
        return f"{yields}, {'after a strong pulse' if self.after else 'whole'}"


def select(runs: Sequence[FinishedRun]) -> list[list[PushedFilter]]:
    """Rows pushed once or twice, elastic ones and others, if one of these is pushed twice."""
    found = []
    for run in runs:
        case = run.case
        probed = any(probe.contact for probe in case.output.probes)
        if case.load.kind != "force" or not probed or len(push_starts(case.load.table)) not in (1, 2):
            continue
        row = run.seen_as(PushedFilter)
        if row.n_cylinders and row.n_cylinders == 2 * (row.n_spheres - 1):
            found.append(row)
    found.sort(key=lambda run: (run.law != "hertz", run.after))
    return [found] if any(run.after and run.law != "hertz" for run in found) else []


def rows(runs: Sequence[PushedFilter]) -> Iterator[Row]:
    """Peak forces and decay of the weak pulse, and what is left of the precompression."""
    for run in runs:
        for contact in _COMPARED:
            if contact in run.pulses:
                strong, weak = run.pulses[contact]
                remark = f"Of the strong pulse before: {number(strong)} N." if run.after else ""
                digits = 4 if run.law == "hertz" else 2
                yield Row(f"Weak pulse at contact {contact}, {run.words}", "N", None, weak, _WHERE, remark,
                          digits=digits)  # fmt: skip
        if math.isfinite(run.weak_decay) and not (run.after and run.law == "hertz"):
            name = f"Decay per contact of the weak pulse, contacts {_DECAY[0]} to {_DECAY[1]}, {run.words}"
            yield Row(name, "", None, run.weak_decay, _WHERE, digits=3 if run.law == "hertz" else 2)
        if run.after:
            name = f"Force of a wall before the weak pulse over that at the start, {run.words}"
            remark = "" if run.law != "hertz" else "Spheres that still swing push the cylinders out."
            yield Row(name, "", None, run.pressed, _WHERE, remark, digits=3)
    by_words = {run.words: run for run in runs}
    whole, dented = by_words.get("yielding, whole"), by_words.get("yielding, after a strong pulse")
    if whole is not None and dented is not None:
        ratio = dented.weak_decay / whole.weak_decay
        if math.isfinite(ratio):
            name = "Decay of the weak pulse in the dented row over that in the whole one"
            yield Row(name, "", None, ratio, _WHERE, "What is left of the filter, with all that yielding takes.",
                      digits=2)  # fmt: skip


def verdict(runs: Sequence[PushedFilter]) -> Iterator[str]:
    """Say what the strong pulse leaves of the filter."""
    last = _COMPARED[-1]
    by_words = {run.words: run for run in runs if last in run.pulses}
    dented, whole = by_words.get("yielding, after a strong pulse"), by_words.get("yielding, whole")
    if dented is not None and whole is not None:
        yield (
            f"The strong pulse leaves {100 * dented.pressed:.0f} % of the force of the walls; at contact {last} the "
            f"weak pulse then has {number(dented.pulses[last][1])} N, after {number(whole.pulses[last][1])} N in the "
            "whole row."
        )


def pictures(runs: Sequence[PushedFilter]) -> Iterator[Picture]:
    """Peak force of the weak pulse along the rows."""
    figure, axes = panels(2.8)
    data: dict[str, Array] = {}
    for run, colour, mark in zip(runs, COLOURS, MARKS, strict=False):
        contacts, force = run.weak
        axes.semilogy(contacts, force, mark + "-", color=colour, markersize=3.5, label=run.words)
        data |= {"contact": contacts, f"{column_name(run.words)}_N": force}
    axes.set(xlabel="Contact", ylabel="Peak force (N)")
    axes.legend(fontsize=7)
    yield Picture("", "A weak pulse along rows with cylinders, whole and after a strong pulse", Drawing(figure, data))
