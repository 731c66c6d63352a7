"""Confined rows that yield, pushed twice alike: what the first pulse leaves of the wave and of its decay."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from functools import cached_property

import numpy as np

from granwave.analysis.document.cells import percent
from granwave.analysis.figures.chains import confined as figures
from granwave.analysis.formatting.numbers import number
from granwave.analysis.measures.driven.two_pushes import largest_of_pulses, push_starts
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.confined.runs import ConfinedRun, row_of
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture, Row
from granwave.lammps_inputs.contact.law import pair_contact

TITLE = "Confined rows that yield: two equal pulses"
TEXT = (
    "Beyond the source, whose rows are elastic: a bead is pushed twice alike. The first pulse dents the contacts, "
    "among beads and in the rings; the second "
    "finds them stiffer, and some of them with gaps. Peak forces of contacts of beads, of the first pulse and of the "
    "second, "
    "of a row that yields and of an elastic one, where the second runs into what still swings behind the first. "
    "Decay: over the contacts named."
)
_PROBE = re.compile(r"probes/contact_(\d+)_(\d+)_force")
_COMPARED = (25, 45, 65)  # contacts
_DECAY = (35, 65)


class PushedRun(ConfinedRun):
    """A finished run of a row pushed twice."""

    @property
    def apart(self) -> float:
        """Time between the two pushes, s."""
        starts = push_starts(self.case.load.table)
        return starts[1] - starts[0]

    @cached_property
    def pulses(self) -> tuple[Array, Array, Array]:
        """Contacts that were recorded, and the largest force of each pulse there, N."""
        found = []
        place = {int(bead) + 1: k for k, bead in enumerate(self.beads, start=1)}
        with Result(self.directory) as result:
            time = result["probes/time"]
            for name in result.names("probes"):
                match = _PROBE.fullmatch(f"probes/{name}")
                if match and place.get(int(match[2]), 0) - place.get(int(match[1]), 0) == 1:
                    both = largest_of_pulses(time, result[f"probes/{name}"], self.apart)
                    found.append((place[int(match[1])], *both))
        contacts, first, second = np.array(sorted(found), dtype=float).T
        return contacts, first, second

    def decay_of_pulse(self, number: int) -> float:
        """Decay per contact of the first or second pulse; NaN if too little was recorded."""
        contacts, force = self.pulses[0], self.pulses[number]
        chosen = (contacts >= _DECAY[0]) & (contacts <= _DECAY[1]) & (force > 0)
        return -float(np.polyfit(contacts[chosen], np.log(force[chosen]), 1)[0]) if chosen.sum() > 1 else math.nan

    @property
    def yields(self) -> bool:
        """The law of the contacts yields."""
        return self.case.contact.yields

    @property
    def words(self) -> str:
        """``yielding, a = 4.8e-4``."""
        return f"{'yielding' if self.yields else 'elastic'}, a = {self.a:.3g}"


def select(runs: Sequence[FinishedRun]) -> list[list[PushedRun]]:
    """Rows pushed twice, elastic ones and others, by rising a."""
    found = [
        run.seen_as(PushedRun)
        for run in runs
        if run.case.load.kind == "force" and len(push_starts(run.case.load.table)) == 2 and row_of(run.case) is not None
        and any(probe.contact for probe in run.case.output.probes)
    ]  # fmt: skip
    found.sort(key=lambda run: (run.a, run.yields))
    return [found] if any(run.yields for run in found) else []


def rows(runs: Sequence[PushedRun]) -> Iterator[Row]:
    """Peak forces, decay, and how much is dissipated."""
    own = runs[0]
    bead = int(own.beads[0]) + 1
    if own.case.material.yield_strength:
        law = pair_contact(next(run for run in runs if run.yields).case, bead, bead + 1)
        yield Row("Force at which a contact of beads yields", "N", None, law.yield_force, "ours")
    for run in runs:
        contacts, *pulses = run.pulses
        for which, force in zip(("First", "Second"), pulses, strict=True):
            for contact in _COMPARED:
                if contact in contacts:
                    ours = float(force[contacts == contact][0])
                    yield Row(f"{which} pulse at contact {contact}, {run.words}", "N", None, ours, "ours", digits=4)
            decay = run.decay_of_pulse(1 if which == "First" else 2)
            if math.isfinite(decay):
                what = (
                    f"Decay per contact of the {which.lower()} pulse, contacts {_DECAY[0]} to {_DECAY[1]}, {run.words}"
                )
                yield Row(what, "", None, decay, "ours", digits=2)
        if run.yields:
            share = 100 * run.value("dissipated_fraction")
            yield Row(f"Energy dissipated, {run.words}", "%", None, share, "ours", digits=3)


def verdict(runs: Sequence[PushedRun]) -> Iterator[str]:
    """Say what yielding leaves."""
    last = _COMPARED[-1]
    for run in runs:
        twin = next((one for one in runs if not one.yields and one.a == run.a), None)
        if not run.yields or twin is None or any(last not in one.pulses[0] for one in (run, twin)):
            continue
        (mine, theirs) = ([float(force[one.pulses[0] == last][0]) for force in one.pulses[1:]] for one in (run, twin))
        if not theirs[0]:
            continue  # the runs ended before the pulse
        yield (
            f"a = {run.a:.2g}: at contact {last} yielding leaves {percent(100 * mine[0] / theirs[0]).lstrip('+')} of "
            "the first pulse "
            f"({number(mine[0])} N) and {number(mine[1])} N of the second, after {number(theirs[0])} N in the "
            "elastic row."
        )


def pictures(runs: Sequence[PushedRun]) -> Iterator[Picture]:
    """Peak force of both pulses along the rows."""
    curves = []
    for run in runs:
        contacts, first, second = run.pulses
        curves += [(f"{run.words}, first", contacts, first), (f"{run.words}, second", contacts, second)]
    caption = "Peak forces of two equal pulses along elastic rows and rows that yield"
    yield Picture("", caption, figures.two_pulses(curves))
