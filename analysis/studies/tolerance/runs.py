"""Runs of one impact on one packing by its imperfections, with means over their seeds."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from functools import cached_property
from typing import Any

import pandas as pd

from granwave.analysis import statistics
from granwave.analysis.studies.runs import FinishedRun, all_but, bottom_label, impact_title
from granwave.analysis.studies.tolerance.quantities import (
    AXES,
    BY_FRICTION,
    BY_YIELDING,
    IDEAL,
    Setting,
    ToleranceQuantity,
)
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random

Means = dict[Setting, statistics.Estimate]


@dataclasses.dataclass(frozen=True, eq=False)
class PackingRuns:
    """All runs of one impact on one packing, ideal and imperfect.

    Attributes
    ----------
    runs
        By setting, in rising order; of each the replicates in the order of their seeds, a single
        run where nothing is random.
    name
        Of its study.
    title
        The packing and the impact, in words.
    label
        Words that distinguish it from other packings of a report; empty for a single packing.
    """

    runs: dict[Setting, list[FinishedRun]]
    name: str = ""
    title: str = ""
    label: str = ""

    @property
    def case(self) -> Case:
        """Case of its least imperfect run."""
        return self.assembly.case

    @property
    def assembly(self) -> Assembly:
        """All bodies of its least imperfect run."""
        replicates = next(iter(self.runs.values()))
        return replicates[0].assembly

    @cached_property
    def axes(self) -> list[ToleranceQuantity]:
        """Imperfections that any setting has."""
        return [axis for axis in AXES if any(map(axis.of, self.runs))]

    @property
    def suffix(self) -> str:
        """End of a caption: the packing, if there are several."""
        return f" ({self.label})" if self.label else ""

    def along(self, axis: ToleranceQuantity) -> dict[Setting, list[Setting]]:
        """Settings of several values of one imperfection, by the setting without it; all in rising
        order.
        """
        lines: dict[Setting, list[Setting]] = {}
        for setting in self.runs:
            base = setting._replace(**{axis.name: 0.0})
            lines.setdefault(base, []).append(setting)
        return {base: lines[base] for base in sorted(lines) if len(lines[base]) > 1}

    def random(self, setting: Setting) -> bool:
        """True if values differ from seed to seed."""
        return is_random(self.runs[setting][0].case)

    def values(self, quantity: ToleranceQuantity, setting: Setting) -> list[float]:
        """Finite values of the replicates, SI, in the order of the seeds."""
        values = [run.value(quantity.name) for run in self.runs[setting]]
        return [value for value in values if math.isfinite(value)]

    def means(self, quantity: ToleranceQuantity) -> Means:
        """Estimates, SI, of the settings that have a value."""
        means = {}
        for setting in self.runs:
            values = self.values(quantity, setting)
            if not values:
                continue
            if self.random(setting):
                means[setting] = statistics.estimate(values)
            else:
                means[setting] = statistics.exactly(values[0])
        return means

    def over_ideal(self, quantity: ToleranceQuantity) -> Means:
        """Ratios to the ideal packing's value; empty if this value is random, zero or not known."""
        means = self.means(quantity)
        ideal = means.get(IDEAL)
        if not ideal or not ideal.exact or not ideal.mean:
            return {}
        return {setting: mean.over(ideal.mean) for setting, mean in means.items()}

    def left(self, quantity: ToleranceQuantity) -> Means:
        """Fractions of the ideal packing's performance; for a force that should be small, the ideal
        value divided by the actual value.
        """
        shares = self.over_ideal(quantity)
        if quantity.better != "less":
            return shares
        return {setting: _inverse(share) for setting, share in shares.items() if share.mean}

    def shown(
        self, quantities: Sequence[ToleranceQuantity], settings: Sequence[Setting] = ()
    ) -> list[ToleranceQuantity]:
        """Quantities that have a value anywhere; without friction all is dissipated by yielding."""
        settings = settings or list(self.runs)
        has_friction = any(setting.friction for setting in settings)
        shown = []
        for quantity in quantities:
            if quantity in (BY_YIELDING, BY_FRICTION) and not has_friction:
                continue
            if any(self.values(quantity, setting) for setting in settings):
                shown.append(quantity)
        return shown


def _inverse(share: statistics.Estimate) -> statistics.Estimate:
    """Return the estimate of the inverse of a value, to first order in its deviation."""
    return statistics.Estimate(
        share.n,
        1 / share.mean,
        share.deviation / share.mean**2,
        share.half_width / share.mean**2,
    )


def select(runs: Sequence[FinishedRun]) -> list[PackingRuns]:
    """Packings that were run with at least two settings, each with its name and label; of equal
    runs only the longest counts.
    """
    groups = [runs for runs in _runs_by_packing(runs) if len(runs) > 1]
    titles = [_title(PackingRuns(runs)) for runs in groups]
    labels = _labels(titles)
    packings = []
    for number, runs_of_packing in enumerate(groups, start=1):
        packing = PackingRuns(
            runs_of_packing,
            name="tolerances" if number == 1 else f"tolerances-{number}",
            title=titles[number - 1],
            label=labels[number - 1] if len(groups) > 1 else "",
        )
        packings.append(packing)
    return packings


def _runs_by_packing(runs: Sequence[FinishedRun]) -> list[dict[Setting, list[FinishedRun]]]:
    """Impacts on packings by their imperfections, a dictionary for each packing."""
    impacts = [
        run for run in runs if run.case.load.gives_velocity and not run.case.packing.rule.is_chain
    ]
    table = pd.DataFrame(
        [{**imperfections(run.case), "end": run.value("end_time_s"), "run": run} for run in impacts]
    )
    if table.empty:
        return []
    table["what"] = pd.factorize(table["what"])[0]
    place = ["what", "setting", "seed"]
    by_length = table.sort_values("end", ascending=False, kind="stable")
    longest = by_length.drop_duplicates(place).sort_values(place)
    return [
        group.groupby("setting")["run"].agg(list).to_dict() for _, group in longest.groupby("what")
    ]


def _title(packing: PackingRuns) -> str:
    return f"{impact_title(packing.assembly)}, {bottom_label(packing.case)}"


def _labels(titles: Sequence[str]) -> list[str]:
    """Return the parts of each title that not all titles have, numbered where they are equal."""
    parts = [title.split(", ") for title in titles]
    shared = set.intersection(*map(set, parts)) if parts else set()
    own = []
    for words in parts:
        own.append(", ".join(part for part in words if part not in shared))
    labels = []
    for number, label in enumerate(own):
        if own.count(label) > 1:
            labels.append(f"{label or 'packing'} ({own[:number].count(label) + 1})")
        else:
            labels.append(label)
    return labels


def imperfections(case: Case) -> dict[str, Any]:
    """Return packing and impact without the imperfections, as text, the imperfections, and the
    seed, 0 if nothing is random.
    """
    packing = case.packing
    left_out = ["packing.diameter_scatter", "packing.seed", "contact.friction"]
    vacancies = 0.0
    if not isinstance(packing.vacancies, tuple):
        vacancies = packing.vacancies
        left_out.append("packing.vacancies")
    if case.boundary.friction == case.contact.friction:  # the default
        left_out.append("boundary.friction")
    setting = Setting(
        scatter=_without_rounding(packing.diameter_scatter),
        friction=_without_rounding(case.contact.friction),
        vacancies=_without_rounding(vacancies),
    )
    seed = DEFAULT_SEED if packing.seed is None else packing.seed
    return {
        "what": all_but(case, *left_out),
        "setting": setting,
        "seed": seed if is_random(case) else 0,
    }


def _without_rounding(value: float) -> float:
    return float(f"{value:.12g}")
