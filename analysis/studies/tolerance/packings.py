"""Runs that differ in nothing but how imperfect their packing is, and their means by imperfection."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence

from granwave.analysis.statistics import Estimate, estimate, exactly
from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.analysis.studies.tolerance.quantities import FRICTION, PERFORMANCE, PLASTIC, QUANTITIES, Quantity
from granwave.analysis.studies.tolerance.settings import AXES, IDEAL, Axis, Setting, setting_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random


@dataclasses.dataclass(frozen=True, eq=False)
class Packing:
    """All runs of one impact on one packing, ideal and not.

    Attributes
    ----------
    runs
        By setting, in rising order; of each the replicates in the order of their seeds, of what is not random one.
    name
        Of its study.
    title
        The packing and the impact, in words.
    label
        What tells it from other packings of a report; empty for a single one.
    """

    runs: dict[Setting, tuple[FinishedRun, ...]]
    name: str = ""
    title: str = ""
    label: str = ""

    @property
    def case(self) -> Case:
        """Case of its least imperfect run."""
        return self.runs[self.settings[0]][0].case

    @property
    def settings(self) -> list[Setting]:
        """In rising order."""
        return list(self.runs)

    @property
    def axes(self) -> list[Axis]:
        """Axes along which a setting is imperfect."""
        return [axis for axis in AXES if any(axis.of(setting) for setting in self.runs)]

    def along(self, axis: Axis, base: Setting = IDEAL) -> list[Setting]:
        """Settings that differ from ``base`` in one imperfection alone, in rising order."""
        return [setting for setting in self.runs if axis.without(setting) == axis.without(base)]

    def bases(self, axis: Axis) -> list[Setting]:
        """Settings of the other imperfections along which there is more than one value of this."""
        found = {axis.without(setting) for setting in self.runs}
        return sorted(base for base in found if len(self.along(axis, base)) > 1)

    def tried(self, axis: Axis) -> list[Setting]:
        """All settings along which there is more than one value of an imperfection."""
        return [setting for base in self.bases(axis) for setting in self.along(axis, base)]

    def seeds(self, setting: Setting) -> int:
        """Number of replicates."""
        return len(self.runs[setting])

    def random(self, setting: Setting) -> bool:
        """Values differ from seed to seed."""
        return is_random(self.runs[setting][0].case)

    def values(self, quantity: Quantity, setting: Setting) -> list[float]:
        """Values of the replicates, SI, in the order of the seeds; without those that do not apply."""
        found = (run.value(quantity.name) for run in self.runs[setting])
        return [value for value in found if math.isfinite(value)]

    def of(self, quantity: Quantity, setting: Setting) -> Estimate | None:
        """The estimate, SI; None where there is no value."""
        found = self.values(quantity, setting)
        if not found:
            return None
        return estimate(found) if self.random(setting) else exactly(found[0])

    def left(self, quantity: Quantity, setting: Setting) -> Estimate | None:
        """Ratio to the ideal packing's performance: 1 is all of it, more is better than ideal.

        Of a force that shall be small that is the ideal's over the present one. None where either is not known, or the
        ideal one is random or zero.
        """
        share = self.over_ideal(quantity, setting)
        if share is None or quantity.better != "less":
            return share
        if not share.mean:
            return None
        return Estimate(share.n, 1 / share.mean, share.deviation / share.mean**2, share.half_width / share.mean**2)

    def over_ideal(self, quantity: Quantity, setting: Setting) -> Estimate | None:
        """Ratio to the ideal packing's value; None where either is not known, or the ideal one is random or zero."""
        ideal = self.of(quantity, IDEAL) if IDEAL in self.runs else None
        now = self.of(quantity, setting)
        return now.over(ideal.mean) if now and ideal and ideal.exact and ideal.mean else None

    def shown(
        self, quantities: Sequence[Quantity] = QUANTITIES, settings: Sequence[Setting] | None = None
    ) -> list[Quantity]:
        """The quantities that have a value anywhere; without friction all is dissipated by yielding.

        Parameters
        ----------
        settings
            Those that are shown; None: all of the packing.
        """
        settings = self.settings if settings is None else settings
        has_friction = any(setting.friction for setting in settings)
        there = [one for one in quantities if any(self.values(one, setting) for setting in settings)]
        return [one for one in there if has_friction or one not in (PLASTIC, FRICTION)]

    @property
    def performance(self) -> list[Quantity]:
        """Quantities of `PERFORMANCE` that are known."""
        return self.shown(PERFORMANCE)


def packings(runs: Iterable[FinishedRun]) -> list[Packing]:
    """Packings of which there are runs of two settings at least; of equal runs the longest counts."""
    groups: dict[str, dict[Setting, dict[int, FinishedRun]]] = {}
    for run in runs:
        if run.case.load.kind != "impact" or run.case.packing.kind == "chain":
            continue
        same = groups.setdefault(_what_is_hit(run.case), {}).setdefault(setting_of(run.case), {})
        seed = _seed(run.case)
        if seed not in same or run.value("end_time_s") > same[seed].value("end_time_s"):
            same[seed] = run
    return [
        Packing({setting: tuple(same[seed] for seed in sorted(same)) for setting, same in sorted(group.items())})
        for group in groups.values()
        if len(group) > 1
    ]


def _what_is_hit(case: Case) -> str:
    """Everything that is not an imperfection."""
    left_out = ["packing.diameter_scatter", "packing.seed", "contact.friction"]
    if not isinstance(case.packing.vacancies, tuple):
        left_out.append("packing.vacancies")
    if case.boundary.friction == case.contact.friction:  # as where it is left out
        left_out.append("boundary.friction")
    return all_but(case, *left_out)


def _seed(case: Case) -> int:
    """Seed of the random part of a packing; 0 where nothing is random."""
    if not is_random(case):
        return 0
    return DEFAULT_SEED if case.packing.seed is None else case.packing.seed
