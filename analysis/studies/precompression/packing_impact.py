"""Impacts on precompressed packings: what arrives, and what is dissipated, against the static pressure."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.document.model import Table
from granwave.analysis.figures.style import BLUE, GREEN, GREY, Drawing, new_figure
from granwave.analysis.studies.precompression import packing_speed, quantities
from granwave.analysis.studies.precompression.runs import DentedRun, past_runs, released_energy_note
from granwave.analysis.studies.runs import FinishedRun, grouped, rising
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import columns_of, values_table
from granwave.analysis.studies.titles import contact_label, load_label, packing_title

_FEWEST = 2  # runs, one of them precompressed
_OF_YIELDING = (
    dataclasses.replace(quantities.DISSIPATED, heading="Dissipated by the impact"),
    dataclasses.replace(quantities.GREW, heading="Contacts that yielded in it"),
)
_QUANTITIES = (
    quantities.PRESSURE,
    quantities.STATIC_FORCE,
    quantities.TRANSMITTED,
    quantities.ARRIVAL,
    *_OF_YIELDING,
    dataclasses.replace(quantities.PEAK_FORCE, heading="Largest contact force, the static one in it"),
)


@dataclasses.dataclass(frozen=True)
class Series:
    """One impact on one packing, by rising pressure of a kind."""

    number: int
    kind: str
    runs: tuple[DentedRun, ...]


def select(runs: Sequence[FinishedRun]) -> list[Series]:
    """Each impact on a packing that was run at several pressures, or at one and without."""
    chosen = [run for run in past_runs(runs) if _fits(run)]
    found: list[Series] = []
    for kind in sorted({stage.kind for run in chosen if (stage := run.case.precompression)}):
        same = [run for run in chosen if not (stage := run.case.precompression) or stage.kind == kind]
        for group in grouped(same, "precompression"):
            series = rising(group, lambda run: run.static_force)
            if len(series) >= _FEWEST:
                found.append(Series(len(found) + 1, kind, tuple(series)))
    return found


def name(series: Series) -> str:
    """``precompressed-impact-1``."""
    return f"precompressed-impact-{series.number}"


def title(series: Series) -> str:
    """By pressure and impact."""
    return f"Impact on a packing under {series.kind} pressure, {series.runs[0].case.load.velocity:g} m/s"


def text(series: Series) -> str:
    """The packing and its load."""
    first = series.runs[0].case
    sides = {"free": "free", "periodic": "periodic", "wall": "walled"}[first.boundary.sides]
    return (
        f"{packing_title(first)}, {sides} sides, {contact_label(first)}, struck at {load_label(first)} under "
        f"{series.kind} static pressure, which stays on. What the static load made yield is not counted."
        + released_energy_note(series.runs)
    )


def tables(series: Series) -> list[Table]:
    """The impact at each pressure, without what yielding does where nothing yields."""
    shown = [one for one in _QUANTITIES if one not in _OF_YIELDING or any(map(one.value, series.runs))]
    return [values_table("The impact against static pressure", series.runs, shown)]


def verdict(series: Series) -> list[str]:
    """The lowest pressure beside the highest."""
    first, last = series.runs[0], series.runs[-1]
    start = "without a static load" if not first.static_force else f"at {first.pressure:.3g} Pa"
    sentence = (
        f"Under {series.kind} pressure of {last.pressure:.3g} Pa the impact adds {last.transmitted:.4g} N "
        f"at the bottom ({first.transmitted:.4g} N {start})"
    )
    if any(run.dissipated for run in series.runs):
        sentence += f" and dissipates {100 * last.dissipated:.3g} % ({100 * first.dissipated:.3g} %)"
    return [f"{sentence}.{released_energy_note((first, last))}"]


def pictures(series: Series) -> Iterator[Picture]:
    """Compare the arriving force and, where contacts yield, the dissipated energy."""
    shown = [(quantities.TRANSMITTED, BLUE)]
    if any(run.dissipated for run in series.runs):
        shown.append((quantities.DISSIPATED, GREEN))
    figure = new_figure(2.5, 3.3 * len(shown))
    pressure = quantities.PRESSURE.shown(series.runs)
    loaded = pressure > 0
    panels = figure.subplots(1, len(shown), squeeze=False)[0]
    for axes, (quantity, colour) in zip(panels, shown, strict=True):
        values = quantity.shown(series.runs)
        axes.set(
            xlabel=quantities.PRESSURE.axis, ylabel=quantity.axis, xscale="log", ylim=(0, 1.25 * np.nanmax(values))
        )
        axes.set_xlim(pressure[loaded].min() / 2, 2 * pressure[loaded].max())
        axes.plot(pressure[loaded], values[loaded], "o-", color=colour, markersize=4)
        if not loaded.all():
            axes.axhline(values[0], color=GREY, linestyle="--", label="without static load")
            axes.legend()
    drawing = Drawing(figure, columns_of(series.runs, _QUANTITIES))
    yield Picture("", "Transmitted force and dissipation against static pressure", drawing)


def _fits(run: DentedRun) -> bool:
    """A packing of like spheres without dents, of its nominal size, that is not hit by a small wave only."""
    case = run.case
    if case.packing.kind == "chain" or not run.assembly.plain or case.contact.initial_overlap:
        return False
    if case.precompression is not None and case.precompression.kind == "gravity":
        return False
    return not packing_speed.fits(run)
