"""Tolerances: what is left of an ideal performance where spheres scatter in size, are missing, or
have friction.

Runs that differ in nothing but how imperfect their packing is are put together; their means by
imperfection are the rows of the tables and the points of the figures.
"""

from __future__ import annotations

import bisect
import dataclasses
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np
import pandas as pd

from granwave.analysis import statistics
from granwave.analysis.document.model import BLANK, Cell, DocumentTable, TableColumn
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.figures.scales import not_to_scale, numbered_map, spread_scales, ticks_at
from granwave.analysis.figures.series import COLOURS, label, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.measures.target import reached
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, all_but, bottom_label, impact_title
from granwave.analysis.studies.study import Picture, numeric, span, table_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random

TEXT = (
    "Means over the seeds and their 95 % confidence intervals (Student). Values without an interval are of "
    "packings in which nothing is random, or of a single seed. With a diameter scatter, diameters lie between the "
    "nominal one and so much less. A lower peak force and a larger dissipated share protect better."
)
KEPT = 0.9  # of the ideal packing's performance: how large may a tolerance be?
_SAME = 0.005
_PRECISE = 0.1  # of the mean: the half-width that a number of seeds is told for
_LATE = 0.05  # of a run
_MARKERS = "os^DvP*"
_ACROSS = 2  # panels
_WIDTH = 7.0  # inches: two columns of a journal
_FEWEST_SEEDS = 4  # whose convergence is worth a figure
_FEWEST_SHOWN = 3  # the interval of two is thirteen standard deviations wide
_TICKS = (3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 50, 100)


class Setting(NamedTuple):
    """Imperfections of a packing: scatter of the diameters (m), coefficient of friction, share of
    left out spheres.
    """

    scatter: float = 0.0
    friction: float = 0.0
    vacancies: float = 0.0


IDEAL = Setting()


@dataclasses.dataclass(frozen=True)
class ToleranceQuantity:
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

    def of(self, setting: Setting) -> float:
        """Value of an imperfection in a setting, in `unit`."""
        return float(f"{getattr(setting, self.name) / self.scale:.12g}")

    def show(self, value: float) -> str:
        """A value in `unit`, with it."""
        return f"{value:.3g} {self.unit}".rstrip()


AXES = (
    ToleranceQuantity(
        "scatter",
        "diameter scatter",
        "µm",
        1e-6,
        "",
        "diameter_scatter_m",
        "packing.diameter_scatter",
    ),
    ToleranceQuantity(
        "friction", "friction coefficient", "", 1.0, "", "friction", "contact.friction"
    ),
    ToleranceQuantity("vacancies", "vacancies", "%", 0.01, "", "vacancies", "packing.vacancies"),
)
FORCE = ToleranceQuantity("wall_peak_force_N", "peak force on the bottom", "N", better="less")
DISSIPATED = ToleranceQuantity(
    "dissipated_fraction", "dissipated share of the energy", better="more"
)
_REDUCTION = ToleranceQuantity(
    "peak_reduction", "peak force without the packing over that with it", better="more"
)
_PLASTIC = ToleranceQuantity("plastic_fraction", "share dissipated by yielding", better="more")
_FRICTION = ToleranceQuantity("friction_fraction", "share dissipated by friction")
_SPHERES = ToleranceQuantity("n_plastic_spheres", "yielded spheres")
_ARRIVAL = ToleranceQuantity("base_arrival_s", "arrival at the bottom", "µs", 1e-6)
_ALL = (
    FORCE, _REDUCTION, DISSIPATED, _PLASTIC, _FRICTION, ToleranceQuantity("n_plastic_contacts", "yielded contacts"), _SPHERES,
    ToleranceQuantity("plastic_zone_volume_m3", "plastic volume", "cm³", 1e-6),
    ToleranceQuantity("plastic_zone_depth_m", "plastic depth", "mm", 1e-3), _ARRIVAL,
)  # fmt: skip
_PERFORMANCE = (FORCE, DISSIPATED, _PLASTIC)  # how much of it is left is told
_PANELS = (FORCE, DISSIPATED, _PLASTIC, _FRICTION, _SPHERES, _ARRIVAL)

Means = dict[Setting, statistics.Estimate]


@dataclasses.dataclass(frozen=True, eq=False)
class PackingRuns:
    """All runs of one impact on one packing, ideal and not.

    Attributes
    ----------
    runs
        By setting, in rising order; of each the replicates in the order of their seeds, of what is
        not random one.
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
        return self.assembly.case

    @property
    def assembly(self) -> Assembly:
        """All bodies of its least imperfect run."""
        return next(iter(self.runs.values()))[0].assembly

    @cached_property
    def axes(self) -> list[ToleranceQuantity]:
        """Imperfections that any setting has."""
        return [axis for axis in AXES if any(axis.of(setting) for setting in self.runs)]

    @property
    def suffix(self) -> str:
        """End of a caption: the packing, where there are several."""
        return f" ({self.label})" if self.label else ""

    def along(self, axis: ToleranceQuantity) -> dict[Setting, list[Setting]]:
        """Settings of several values of one imperfection, by that of the others; all in rising
        order.
        """
        lines: dict[Setting, list[Setting]] = {}
        for setting in self.runs:
            lines.setdefault(setting._replace(**{axis.name: 0.0}), []).append(setting)
        return {base: lines[base] for base in sorted(lines) if len(lines[base]) > 1}

    def random(self, setting: Setting) -> bool:
        """Values differ from seed to seed."""
        return is_random(self.runs[setting][0].case)

    def values(self, quantity: ToleranceQuantity, setting: Setting) -> list[float]:
        """Values of the replicates that have one, SI, in the order of the seeds."""
        return [
            value for run in self.runs[setting] if math.isfinite(value := run.value(quantity.name))
        ]

    def means(self, quantity: ToleranceQuantity) -> Means:
        """Estimates, SI, of the settings that have a value."""
        found = {
            setting: values for setting in self.runs if (values := self.values(quantity, setting))
        }
        return {
            s: statistics.estimate(values) if self.random(s) else statistics.exactly(values[0])
            for s, values in found.items()
        }

    def over_ideal(self, quantity: ToleranceQuantity) -> Means:
        """Ratios to the ideal packing's value; nothing where that is random, zero or not known."""
        means = self.means(quantity)
        ideal = means.get(IDEAL)
        return (
            {s: one.over(ideal.mean) for s, one in means.items()}
            if ideal and ideal.exact and ideal.mean
            else {}
        )

    def left(self, quantity: ToleranceQuantity) -> Means:
        """Shares of the ideal packing's performance: of a force that shall be small its value over
        the present one.
        """
        shares = self.over_ideal(quantity)
        if quantity.better != "less":
            return shares
        return {
            setting: statistics.Estimate(
                one.n, 1 / one.mean, one.deviation / one.mean**2, one.half_width / one.mean**2
            )
            for setting, one in shares.items()
            if one.mean
        }

    def shown(
        self, quantities: Sequence[ToleranceQuantity], settings: Sequence[Setting] = ()
    ) -> list[ToleranceQuantity]:
        """Quantities that have a value anywhere; without friction all is dissipated by yielding."""
        settings = settings or list(self.runs)
        has_friction = any(setting.friction for setting in settings)
        there = [
            one for one in quantities if any(self.values(one, setting) for setting in settings)
        ]
        return [one for one in there if has_friction or one not in (_PLASTIC, _FRICTION)]


def select(runs: Sequence[FinishedRun]) -> list[PackingRuns]:
    """Packings that were run with two settings at least, named and told apart; of equal runs the
    longest counts.
    """
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
    longest = (
        table.sort_values("end", ascending=False, kind="stable")
        .drop_duplicates(place)
        .sort_values(place)
    )
    groups = [
        group.groupby("setting")["run"].agg(list).to_dict() for _, group in longest.groupby("what")
    ]
    found = [PackingRuns(group) for group in groups if len(group) > 1]
    titles = [
        f"{impact_title(packing.assembly)}, {bottom_label(packing.case)}" for packing in found
    ]
    parts = [title.split(", ") for title in titles]
    own = [
        ", ".join(part for part in words if not all(part in other for other in parts))
        for words in parts
    ]
    labels = [f"{words or 'packing'} ({own[:n].count(words) + 1})" if own.count(words) > 1 else words
              for n, words in enumerate(own)]  # fmt: skip
    return [
        PackingRuns(
            packing.runs,
            "tolerances" + (f"-{n}" if n > 1 else ""),
            title,
            name if len(found) > 1 else "",
        )
        for n, (packing, title, name) in enumerate(zip(found, titles, labels, strict=True), start=1)
    ]


def imperfections(case: Case) -> dict[str, Any]:
    """Return all that is hit but for its imperfections, as text, these, and the seed, 0 where
    nothing is random.
    """
    packing = case.packing
    left_out = ["packing.diameter_scatter", "packing.seed", "contact.friction"]
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


def name(packing: PackingRuns) -> str:
    """``tolerances``, ``tolerances-2``."""
    return packing.name


def title(packing: PackingRuns) -> str:
    """Title with packing and impact."""
    return f"Tolerances: {packing.title}" + (
        "" if packing.label in packing.title else packing.suffix
    )


def verdict(packing: PackingRuns) -> Iterator[str]:
    """Say between which values performance lies, and how many runs ended too early; the tables tell
    the rest.
    """
    for quantity in packing.shown(_PERFORMANCE):
        if len(packing.left(quantity)) > 1:
            means = {
                _told(s): one.over(quantity.scale) for s, one in packing.means(quantity).items()
            }
            ideal = with_interval(means[_told(IDEAL)], unit=quantity.unit)
            yield span(
                f"{quantity.words.capitalize()}, {ideal} in the ideal packing", means, quantity.unit
            )
    if short := sum(_cut_short(run) for runs in packing.runs.values() for run in runs):
        yield (
            f"In {short} runs the force on the bottom was largest at their very end, so that it may have grown on: "
            "follow them longer (run.end_time)."
        )


def missing(packing: PackingRuns, undone: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Say that the ideal packing has not finished, where a point of a scan asked for it."""
    fixed = imperfections(packing.case)["setting"]
    asked = (
        not any(labels.get(axis.key, getattr(fixed, axis.name)) for axis in AXES)
        for labels in undone
    )
    if IDEAL not in packing.runs and any(asked):
        yield (
            "The ideal packing (no scatter, no friction) has not finished, so that it cannot be said how much of its "
            "performance is left."
        )


def tables(packing: PackingRuns) -> Iterator[DocumentTable]:
    """Means of all settings, those of performance against the ideal packing, largest tolerances,
    and doubts.
    """
    axes = numeric(*((axis.words.capitalize(), axis.unit) for axis in packing.axes), key=True)

    def by_setting(
        caption: str, columns: Mapping[Any, Mapping[Setting, Cell]], settings: Sequence[Setting]
    ) -> DocumentTable:
        rows = [
            (
                *(Cell(f"{axis.of(s):g}", axis.of(s)) for axis in packing.axes),
                Cell(_seeds(packing, s), len(packing.runs[s]) if packing.random(s) else 0),
                *(cells.get(s, Cell(BLANK)) for cells in columns.values()),
            )
            for s in settings
        ]
        return table_of(
            caption + packing.suffix, (*axes, *numeric("Seeds", *columns)), rows, sortable=True
        )

    means: dict[Any, dict[Setting, Cell]] = {
        (one.words.capitalize(), one.unit): {
            s: Cell(with_interval(mean, one.scale), mean.mean)
            for s, mean in packing.means(one).items()
        }
        for one in packing.shown(_ALL)
    }
    scattered = {
        s: one
        for s, one in packing.means(FORCE).items()
        if one.n > 1 and one.mean and one.deviation > 0
    }
    if scattered:
        needed = {
            s: statistics.seeds_needed(one.deviation, _PRECISE * abs(one.mean))
            for s, one in scattered.items()
        }
        means[f"Seeds for the force to ± {100 * _PRECISE:.0f} %"] = {
            s: Cell(str(n), n) for s, n in needed.items()
        }
    if means:
        yield by_setting("Mean and 95 % confidence interval", means, list(packing.runs))
    against = {
        (one.words.capitalize(), "% of the ideal's"): {
            s: _share_cell(share) for s, share in shares.items()
        }
        for one in packing.shown(_PERFORMANCE)
        if (shares := packing.over_ideal(one)) and packing.left(one)
    }
    if against:
        yield by_setting(
            "Against the ideal packing", against, [s for s in packing.runs if s != IDEAL]
        )
    for caption, heads, rows in (
        (
            f"How large each imperfection may be for {100 * KEPT:.0f} % of the ideal packing's performance or more: a "
            f"force of at most {100 / KEPT:.0f} %",
            ("Imperfection", "Quantity", "Ideal", "Largest tried", "There", "Of the ideal's", "Seeds", "Kept up to",
             "With confidence up to"),
            _kept(packing),
        ),
        (
            "Neighbouring settings whose means may be equal, with the seeds there are",
            ("Imperfection", "Quantity", "From", "To", "At"),
            _alike(packing),
        ),
    ):  # fmt: skip
        if found := list(rows):
            yield table_of(
                caption + packing.suffix,
                [TableColumn(head, key=n < 2) for n, head in enumerate(heads)],
                found,
            )


def pictures(packing: PackingRuns) -> Iterator[Picture]:
    """Quantities against each imperfection, maps of two, and the confidence that the seeds give."""
    for axis in packing.axes:
        if drawing := _against(packing, axis):
            random = any(
                packing.random(setting)
                for along in packing.along(axis).values()
                for setting in along
            )
            what = (
                "means, 95 % confidence bands, and single runs as dots"
                if random
                else "nothing is random here"
            )
            seen = "An imperfection matters from where a band leaves the value at 0, which is the ideal packing's"
            yield Picture(
                f"_{axis.name}", f"Against {axis.words}: {what}{packing.suffix}. {seen}", drawing
            )
    for across, up in itertools.combinations(packing.axes, 2):
        if drawing := _left_of_ideal(packing, across, up):
            caption = f"{across.words.capitalize()} and {up.words} together, in per cent of the ideal packing's"
            seen = "Numbers that change along rows and columns alike tell that both imperfections matter"
            yield Picture(
                f"_{across.name}_{up.name}", f"{caption}{packing.suffix}. {seen}", drawing
            )
    seeded = [setting for setting in packing.runs if packing.random(setting)]
    most = max(seeded, key=lambda one: (len(packing.runs[one]), one), default=IDEAL)
    if seeded and (drawing := _convergence(packing, most)):
        caption = "Confidence of the mean of the first n seeds, and what the scatter of all of them makes of n"
        seen = (
            "Where the curves have fallen to the precision that is wanted, there are seeds enough"
        )
        yield Picture("_seeds", f"{caption}{packing.suffix}. {seen}", drawing)


def _told(setting: Setting) -> str:
    """Return a setting in words, such as ``diameter scatter 5 µm, friction coefficient 0.1``."""
    parts = [f"{axis.words} {axis.show(axis.of(setting))}" for axis in AXES if axis.of(setting)]
    return ", ".join(parts) or "ideal"


def _seeds(packing: PackingRuns, setting: Setting) -> str:
    return str(len(packing.runs[setting])) if packing.random(setting) else "not random"


def _share_cell(share: statistics.Estimate) -> Cell:
    alike = (
        not share.exact and statistics.differ_significantly(statistics.exactly(1.0), share) is False
    )
    return Cell(
        with_interval(share.over(0.01)) + (", not to be told from it" if alike else ""),
        100 * share.mean,
    )


def _kept(packing: PackingRuns) -> Iterator[tuple[str, ...]]:
    """Values without and with most of each imperfection, and up to which nearly all performance is
    kept.
    """
    for axis in packing.axes:
        along = packing.along(axis).get(IDEAL, []) if IDEAL in packing.runs else []
        for quantity in packing.shown(_PERFORMANCE, along) if along else []:
            means = packing.means(quantity)
            left = packing.left(quantity)
            if len(left) < 2:
                continue
            last = [setting for setting in along if setting in means][-1]
            known = {axis.of(setting): left[setting] for setting in along if setting in left}
            sure = {x: one.low for x, one in known.items() if math.isfinite(one.half_width)}
            place = statistics.crossing(list(known), [one.mean for one in known.values()], KEPT)
            surely = statistics.crossing(list(sure), list(sure.values()), KEPT)
            kept = "every value tried"
            if place is not None:
                after = bisect.bisect_right(tried := [axis.of(setting) for setting in along], place)
                kept = f"about {axis.show(place)} (between {tried[after - 1]:g} and {axis.show(tried[after])})"
            less = surely is not None and (place is None or surely < place * (1 - _SAME))
            yield (
                axis.words.capitalize(), quantity.words.capitalize(),
                with_interval(means[IDEAL], quantity.scale, quantity.unit), axis.show(axis.of(last)),
                with_interval(means[last], quantity.scale, quantity.unit),
                with_interval(packing.over_ideal(quantity)[last].over(0.01), unit="%"), _seeds(packing, last), kept,
                axis.show(surely) if less and surely is not None else BLANK,
            )  # fmt: skip


def _alike(packing: PackingRuns) -> Iterator[tuple[str, ...]]:
    """Neighbouring settings whose means may be equal."""
    for axis, quantity in itertools.product(packing.axes, (FORCE, DISSIPATED)):
        means = packing.means(quantity)
        for base, along in packing.along(axis).items():
            for first, second in itertools.pairwise(
                setting for setting in along if setting in means
            ):
                if statistics.differ_significantly(means[first], means[second]) is False:
                    ends = (axis.show(axis.of(setting)) for setting in (first, second))
                    at = _told(base) if base != IDEAL else ""
                    yield axis.words.capitalize(), quantity.words.capitalize(), *ends, at


def _cut_short(run: FinishedRun) -> bool:
    """True if the force on the bottom was largest in the last part of the run, so that it may have
    grown on.
    """
    try:
        with Result(run.directory) as result:
            found = reached(result)
    except (MissingOutputError, OutputFormatError):  # only the summary was kept
        return False
    return found is not None and bool(
        found.time[found.force.argmax()] > (1 - _LATE) * found.time[-1]
    )


def _against(packing: PackingRuns, axis: ToleranceQuantity) -> Drawing | None:
    """Every quantity against one imperfection, a curve for each setting of the others; None without
    two values.
    """
    lines = packing.along(axis)
    settings = [setting for along in lines.values() for setting in along]
    quantities = packing.shown(_PANELS, settings) if lines else []
    if not quantities:
        return None
    rows = -(-len(quantities) // _ACROSS)
    figure, *grid = panels(
        1.75 * rows + 0.35 * (len(lines) > 1), _ACROSS, rows, width=_WIDTH, sharex=True
    )
    others = [one for one in packing.axes if one is not axis]
    points = []
    for axes, quantity in zip(grid, quantities, strict=False):
        means = packing.means(quantity)
        for n, (base, along) in enumerate(lines.items()):
            colour = COLOURS[n % len(COLOURS)]
            found = {s: means[s] for s in along if s in means}
            x = np.array([axis.of(setting) for setting in found])
            mean = np.array([one.mean for one in found.values()]) / quantity.scale
            half = np.nan_to_num([one.half_width for one in found.values()]) / quantity.scale
            axes.fill_between(x, mean - half, mean + half, color=colour, alpha=0.2, linewidth=0)
            called = ", ".join(f"{other.words} {other.show(other.of(base))}" for other in others)
            axes.plot(
                x,
                mean,
                color=colour,
                marker=_MARKERS[n % len(_MARKERS)],
                markersize=3.5,
                label=called,
            )
            for place, setting in zip(x, found, strict=True):
                single = np.array(packing.values(quantity, setting)) / quantity.scale
                if packing.random(setting):
                    axes.plot(
                        np.full(len(single), place),
                        single,
                        ".",
                        color=colour,
                        markersize=3.5,
                        alpha=0.6,
                    )
            points += [
                (quantity.name, *s, one.n, one.mean, one.low, one.high) for s, one in found.items()
            ]
        scale = spread_scales(axes, [axis.of(setting) for setting in settings])
        axes.set_ylabel(quantity.title, fontsize=7)
    for axes in grid[len(quantities) :]:
        axes.set_axis_off()
    for axes in grid[max(0, len(quantities) - _ACROSS) : len(quantities)]:
        axes.set_xlabel(axis.title + scale)
        axes.tick_params(labelbottom=True)
    if len(lines) > 1:
        legend_outside(figure, min(len(lines), 4), fontsize=7)
    heads = ("quantity", *(one.column for one in AXES), "n", "mean", "low_95", "high_95")
    return Drawing(figure, dict(zip(heads, map(np.array, zip(*points, strict=True)), strict=True)))


def _left_of_ideal(
    packing: PackingRuns, across: ToleranceQuantity, up: ToleranceQuantity
) -> Drawing | None:
    """Maps of what is left by two imperfections; None where they do not fill a grid."""
    fixed = [axis for axis in AXES if axis not in (across, up)]
    settings = [setting for setting in packing.runs if not any(axis.of(setting) for axis in fixed)]
    columns, lines = (sorted({axis.of(setting) for setting in settings}) for axis in (across, up))
    shown = [one for one in (FORCE, DISSIPATED) if packing.left(one)]
    if min(len(columns), len(lines)) < 2 or len(settings) != len(columns) * len(lines) or not shown:
        return None
    figure, *row = panels(0.32 * len(lines) + 1.25, len(shown), width=_WIDTH, sharey=True)
    names = [[f"{value:g}" for value in values] for values in (columns, lines)]
    table = {
        axis.column: np.array([getattr(setting, axis.name) for setting in settings])
        for axis in (across, up)
    }
    for axes, quantity in zip(row, shown, strict=True):
        found = packing.over_ideal(quantity)
        shares = np.array(
            [100 * found[setting].mean if setting in found else np.nan for setting in settings]
        )
        ends = 0.0, max(100.0, float(np.nanmax(shares)))
        table_of_shares = shares.reshape(len(columns), len(lines)).T
        numbered_map(axes, table_of_shares, ends, "% of the ideal packing's", names, ".0f")
        axes.set(xlabel=across.title + not_to_scale(columns), title=quantity.words.capitalize())
        table[f"{quantity.name}_over_ideal"] = shares / 100
    row[0].set_ylabel(up.title + not_to_scale(lines))
    return Drawing(figure, table)


def _convergence(packing: PackingRuns, setting: Setting) -> Drawing | None:
    """Half-width of the confidence interval of the first n seeds; None for few of them, or where
    nothing is random.
    """
    figure, axes = panels(3.0)
    label(axes, "Seeds", "95 % half-width (% of the mean)", log="xy")
    columns: dict[str, Any] = {}
    looks = {FORCE: ("black", "o"), DISSIPATED: (BLUE, "s"), _SPHERES: (ORANGE, "^")}
    for quantity, (colour, marker) in looks.items():
        values = packing.values(quantity, setting)
        if len(values) < _FEWEST_SEEDS or not np.std(values):
            continue
        found = statistics.growing(values)[_FEWEST_SHOWN - 2 :]
        mean = found[-1].mean
        seeds = np.array([one.n for one in found])
        half = np.array([one.half_width for one in found])
        expected = np.array([statistics.half_width(found[-1].deviation, int(n)) for n in seeds])
        axes.plot(
            seeds, 100 * half / mean, marker, color=colour, markersize=4, label=quantity.words
        )
        axes.plot(seeds, 100 * expected / mean, color=colour, linewidth=0.8)
        root = np.sqrt(seeds[-1] / seeds) * expected[-1]
        axes.plot(seeds, 100 * root / mean, color=colour, linewidth=0.8, linestyle=":")
        columns |= {
            "n": seeds,
            f"{quantity.name}_half_width": half,
            f"{quantity.name}_expected": expected,
        }
    if not columns:
        return None
    axes.plot([], [], color=GREY, linewidth=0.8, label=r"$t_{n-1} s/\sqrt{n}$, $s$ of all seeds")
    axes.plot([], [], color=GREY, linewidth=0.8, linestyle=":", label=r"$1/\sqrt{n}$")
    ticks_at(axes.xaxis, [n for n in _TICKS if n <= len(packing.runs[setting])])
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title(_told(setting), fontsize=7)
    legend_outside(figure, 2, fontsize=6.5)
    return Drawing(figure, columns)
