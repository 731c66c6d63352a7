"""Runs that differ in nothing but how imperfect their packing is, and their means by imperfection."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, Literal, NamedTuple

import pandas as pd

from granwave.analysis.statistics import Estimate, estimate, exactly
from granwave.analysis.studies.runs import FinishedRun, all_but, bottom_label, impact_title
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random


class Setting(NamedTuple):
    """Imperfections of a packing: scatter of the diameters (m), coefficient of friction, share of left out spheres."""

    scatter: float = 0.0
    friction: float = 0.0
    vacancies: float = 0.0


IDEAL = Setting()


@dataclasses.dataclass(frozen=True)
class Quantity:
    """A number of a run, or an imperfection.

    Attributes
    ----------
    name
        In the summary, with the unit in SI at the end; of an imperfection, its field of `Setting`.
    words
        In the middle of a sentence.
    unit, scale
        As shown, and its size in SI.
    better
        Which way protects better; empty where neither does.
    column, key
        Of an imperfection: column of a CSV file, in SI, and key of a case file.
    """

    name: str
    words: str
    unit: str = ""
    scale: float = 1.0
    better: Literal["more", "less", ""] = ""
    column: str = ""
    key: str = ""

    @property
    def title(self) -> str:
        """Title of an axis of a figure."""
        return f"{self.words.capitalize()} ({self.unit})" if self.unit else self.words.capitalize()

    @property
    def worse(self) -> str:
        """Side on which a value protects less."""
        return "higher" if self.better == "less" else "lower"

    def of(self, setting: Setting) -> float:
        """Value of an imperfection in a setting, in `unit`."""
        return float(f"{getattr(setting, self.name) / self.scale:.12g}")

    def show(self, value: float) -> str:
        """A value in `unit`, with it."""
        return f"{value:.3g} {self.unit}".rstrip()


AXES = (
    Quantity("scatter", "diameter scatter", "µm", 1e-6, "", "diameter_scatter_m", "packing.diameter_scatter"),
    Quantity("friction", "friction coefficient", "", 1.0, "", "friction", "contact.friction"),
    Quantity("vacancies", "vacancies", "%", 0.01, "", "vacancies", "packing.vacancies"),
)
FORCE = Quantity("wall_peak_force_N", "peak force on the bottom", "N", better="less")
REDUCTION = Quantity("peak_reduction", "peak force without the packing over that with it", better="more")
DISSIPATED = Quantity("dissipated_fraction", "dissipated share of the energy", better="more")
PLASTIC = Quantity("plastic_fraction", "share dissipated by yielding", better="more")
FRICTION = Quantity("friction_fraction", "share dissipated by friction")
CONTACTS = Quantity("n_plastic_contacts", "yielded contacts")
SPHERES = Quantity("n_plastic_spheres", "yielded spheres")
VOLUME = Quantity("plastic_zone_volume_m3", "plastic volume", "cm³", 1e-6)
DEPTH = Quantity("plastic_zone_depth_m", "plastic depth", "mm", 1e-3)
ARRIVAL = Quantity("base_arrival_s", "arrival at the bottom", "µs", 1e-6)

Means = dict[Setting, Estimate]


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

    runs: dict[Setting, list[FinishedRun]]
    name: str = ""
    title: str = ""
    label: str = ""

    @property
    def case(self) -> Case:
        """Case of its least imperfect run."""
        return next(iter(self.runs.values()))[0].case

    @property
    def axes(self) -> list[Quantity]:
        """Imperfections that any setting has."""
        return [axis for axis in AXES if any(axis.of(setting) for setting in self.runs)]

    @property
    def suffix(self) -> str:
        """End of a caption: the packing, where there are several."""
        return f" ({self.label})" if self.label else ""

    def along(self, axis: Quantity) -> dict[Setting, list[Setting]]:
        """Settings of several values of one imperfection, by that of the others; all in rising order."""
        lines: dict[Setting, list[Setting]] = {}
        for setting in self.runs:
            lines.setdefault(setting._replace(**{axis.name: 0.0}), []).append(setting)
        return {base: lines[base] for base in sorted(lines) if len(lines[base]) > 1}

    def random(self, setting: Setting) -> bool:
        """Values differ from seed to seed."""
        return is_random(self.runs[setting][0].case)

    def values(self, quantity: Quantity, setting: Setting) -> list[float]:
        """Values of the replicates that have one, SI, in the order of the seeds."""
        return [value for run in self.runs[setting] if math.isfinite(value := run.value(quantity.name))]

    def means(self, quantity: Quantity) -> Means:
        """Estimates, SI, of the settings that have a value."""
        found = {setting: values for setting in self.runs if (values := self.values(quantity, setting))}
        return {s: estimate(values) if self.random(s) else exactly(values[0]) for s, values in found.items()}

    def over_ideal(self, quantity: Quantity) -> Means:
        """Ratios to the ideal packing's value; nothing where that is random, zero or not known."""
        means = self.means(quantity)
        ideal = means.get(IDEAL)
        return {s: one.over(ideal.mean) for s, one in means.items()} if ideal and ideal.exact and ideal.mean else {}

    def left(self, quantity: Quantity) -> Means:
        """Shares of the ideal packing's performance: of a force that shall be small its value over the present one."""
        shares = self.over_ideal(quantity)
        if quantity.better != "less":
            return shares
        return {
            setting: Estimate(one.n, 1 / one.mean, one.deviation / one.mean**2, one.half_width / one.mean**2)
            for setting, one in shares.items()
            if one.mean
        }

    def shown(self, quantities: Sequence[Quantity], settings: Sequence[Setting] = ()) -> list[Quantity]:
        """Quantities that have a value anywhere; without friction all is dissipated by yielding."""
        settings = settings or list(self.runs)
        has_friction = any(setting.friction for setting in settings)
        there = [one for one in quantities if any(self.values(one, setting) for setting in settings)]
        return [one for one in there if has_friction or one not in (PLASTIC, FRICTION)]


def select(runs: Sequence[FinishedRun]) -> list[Packing]:
    """Packings that were run with two settings at least, named and told apart; of equal runs the longest counts."""
    impacts = [run for run in runs if run.case.load.kind == "impact" and run.case.packing.kind != "chain"]
    table = pd.DataFrame([{**imperfections(run.case), "end": run.value("end_time_s"), "run": run} for run in impacts])
    if table.empty:
        return []
    table["what"] = pd.factorize(table["what"])[0]
    place = ["what", "setting", "seed"]
    longest = table.sort_values("end", ascending=False, kind="stable").drop_duplicates(place).sort_values(place)
    groups = [group.groupby("setting")["run"].agg(list).to_dict() for _, group in longest.groupby("what")]
    found = [Packing(group) for group in groups if len(group) > 1]
    titles = [f"{impact_title(packing.case)}, {bottom_label(packing.case)}" for packing in found]
    return [
        dataclasses.replace(packing, name="tolerances" + (f"-{n}" if n > 1 else ""), title=title, label=label)
        for n, (packing, title, label) in enumerate(zip(found, titles, _labels(titles), strict=True), start=1)
    ]


def imperfections(case: Case) -> dict[str, Any]:
    """Return all that is hit but for its imperfections, as text, these, and the seed, 0 where nothing is random."""
    packing, left_out = case.packing, ["packing.diameter_scatter", "packing.seed", "contact.friction"]
    listed = isinstance(packing.vacancies, tuple)
    left_out += [] if listed else ["packing.vacancies"]
    if case.boundary.friction == case.contact.friction:  # as where it is left out
        left_out.append("boundary.friction")
    values = packing.diameter_scatter, case.contact.friction, 0.0 if listed else packing.vacancies
    seed = DEFAULT_SEED if packing.seed is None else packing.seed
    return {
        "what": all_but(case, *left_out),
        "setting": Setting(*(float(f"{value:.12g}") for value in values)),
        "seed": seed if is_random(case) else 0,
    }


def _labels(titles: Sequence[str]) -> list[str]:
    """Label each of several packings for captions; empty for a single one."""
    if len(titles) < 2:
        return [""] * len(titles)
    parts = [title.split(", ") for title in titles]
    own = [", ".join(part for part in words if not all(part in other for other in parts)) for words in parts]
    if len(set(own)) < len(own):  # they differ in what no title says
        own = [", ".join(filter(None, (words, f"packing {n}"))) for n, words in enumerate(own, start=1)]
    return own
