"""A packing hit several times: each run starts from the dents that the one before left (its result.h5).

The runs tell by themselves: ``contact.initial_overlap`` of a second hit is the path of the first one's result.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.document.model import Table
from granwave.analysis.figures.style import BLUE, GREEN, Drawing, new_figure
from granwave.analysis.studies.precompression import quantities
from granwave.analysis.studies.precompression.runs import DentedRun, past_runs, released_energy_note
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import Quantity, columns_of, values_table
from granwave.analysis.studies.titles import packing_title
from granwave.lammps_inputs.contact.initial_dents import earlier_result

Series = list[DentedRun]


def select(runs: Sequence[FinishedRun]) -> list[Series]:
    """Runs by hit; where several start from the same one, each series is one of its own."""
    chosen = past_runs(runs)
    at = {run.directory.resolve(): run for run in chosen}
    before = {run: at.get(left.resolve().parent) for run in chosen if (left := earlier_result(run.case))}
    found = []
    for run in chosen:
        if before.get(run) is None or run in before.values():
            continue  # a first hit, or one that others go on from
        series = [run]
        while (earlier := before.get(series[0])) is not None and earlier not in series:
            series.insert(0, earlier)
        found.append(series)
    return found


def title(series: Series) -> str:
    """By number of hits and packing."""
    return f"Hit {len(series)} times: {packing_title(series[0].case)}"


def text(series: Series) -> str:
    """Describe where each run starts."""
    return (
        "Each run starts with the spheres in their first places and with the dents that the run before left."
        + released_energy_note(series)
    )


def tables(series: Series) -> list[Table]:
    """Hit by hit."""
    return [values_table("Hit by hit", series, _quantities(series))]


def verdict(series: Series) -> list[str]:
    """The first hit beside the last."""
    first, last = series[0], series[-1]
    return [
        f"Hit {len(series)} times, the packing dissipates {100 * last.dissipated:.3g} % of the last impact "
        f"({100 * first.dissipated:.3g} % of the first) and hands on {last.transmitted:.4g} N "
        f"({first.transmitted:.4g} N)." + released_energy_note((first, last))
    ]


def pictures(series: Series) -> Iterator[Picture]:
    """Dissipation and transmitted force."""
    figure = new_figure(2.3, 5.6)
    left, right = figure.subplots(1, 2)
    hit = range(1, len(series) + 1)
    left.bar(hit, quantities.DISSIPATED.shown(series), color=GREEN, width=0.6)
    left.set(xlabel="Hit", ylabel=quantities.DISSIPATED.axis, xticks=hit)
    right.bar(hit, quantities.TRANSMITTED.shown(series), color=BLUE, width=0.6)
    right.set(xlabel="Hit", ylabel="Force at the bottom (N)", xticks=hit)
    drawing = Drawing(figure, columns_of(series, _quantities(series)))
    yield Picture("", "Dissipation and transmitted force by number of the hit", drawing)


def _quantities(series: Series) -> tuple[Quantity, ...]:
    hit = Quantity("hit", "Hit", "", lambda run: series.index(run) + 1)
    return (
        hit, quantities.IMPACT, quantities.DISSIPATED, quantities.GREW, quantities.PEAK_FORCE, quantities.TRANSMITTED,
        quantities.ARRIVAL,
    )  # fmt: skip
