"""A packing hit several times: each run starts from the dents that the one before left (its result.h5).

The runs tell by themselves: ``contact.initial_overlap`` of a second hit is the path of the first one's result.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from granwave.analysis.figures.style import BLUE, GREEN, Drawing, new_figure
from granwave.analysis.studies.precompression.runs import PastRun, freed_words, values_table
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import packing_words


def repeated_hits(runs: Sequence[PastRun]) -> Iterator[Study]:
    """One study of each series of runs of which every one starts from the dents of the one before."""
    for number, series in enumerate(series_of(runs), start=1):
        yield _study(series, number)


def series_of(runs: Sequence[PastRun]) -> list[list[PastRun]]:
    """Runs by hit; where several start from the same one, each series is one of its own."""
    at = {run.directory.resolve(): run for run in runs}
    before = {run.directory.resolve(): at.get(where) for run in runs if (where := _left_by(run)) is not None}
    found = []
    for run in runs:
        directory = run.directory.resolve()
        if before.get(directory) is None or run in before.values():
            continue  # a first hit, or one that others go on from
        series = [run]
        while (earlier := before.get(series[0].directory.resolve())) is not None and earlier not in series:
            series.insert(0, earlier)
        found.append(series)
    return found


def _left_by(run: PastRun) -> Path | None:
    """Directory of the run whose dents a run starts from."""
    given = run.case.contact.initial_overlap
    if not isinstance(given, str):
        return None
    path = Path(given).resolve()
    return path.parent if path.suffix else path


def _study(series: list[PastRun], number: int) -> Study:
    case = series[0].case
    columns: dict[str, list[float]] = {
        "hit": list(range(1, len(series) + 1)),
        "velocity_m_s": [run.case.load.velocity for run in series],
        "dissipated_share": [run.dissipated for run in series],
        "contacts_yielded": [run.summary["n_plastic_contacts"] for run in series],
        "peak_force_N": [run.summary["peak_force_N"] for run in series],
        "transmitted_force_N": [run.transmitted for run in series],
        "arrival_s": [run.arrival for run in series],
    }
    heads = (
        ("Hit", "", 1.0, "hit"),
        ("Impact", "m/s", 1.0, "velocity_m_s"),
        ("Dissipated", "% of input", 100.0, "dissipated_share"),
        ("Contacts whose dents grew", "", 1.0, "contacts_yielded"),
        ("Largest contact force", "N", 1.0, "peak_force_N"),
        ("Largest force added at the bottom", "N", 1.0, "transmitted_force_N"),
        ("Arrival there", "µs", 1e6, "arrival_s"),
    )
    name = "repeated-hits" + (f"-{number}" if number > 1 else "")
    first, last = series[0], series[-1]
    return Study(
        name,
        f"Hit {len(series)} times: {packing_words(case)}",
        "Each run starts with the spheres in their first places and with the dents that the run before left."
        + freed_words(series),
        pictures=(
            Picture(name.replace("-", "_"), "Dissipation and transmitted force by number of the hit", _draw(columns)),
        ),
        tables=(values_table("Hit by hit", heads, columns),),
        verdict=(
            f"Hit {len(series)} times, the packing dissipates {100 * last.dissipated:.3g} % of the last impact "
            f"({100 * first.dissipated:.3g} % of the first) and hands on {last.transmitted:.4g} N "
            f"({first.transmitted:.4g} N)." + freed_words((first, last)),
        ),
    )


def _draw(columns: dict[str, list[float]]) -> Drawing:
    figure = new_figure(2.3, 5.6)
    left, right = figure.subplots(1, 2)
    hit = columns["hit"]
    for axes, name, scale, colour, label in (
        (left, "dissipated_share", 100.0, GREEN, "Dissipated (% of input)"),
        (right, "transmitted_force_N", 1.0, BLUE, "Force at the bottom (N)"),
    ):
        values = scale * np.array(columns[name])
        axes.bar(hit, values, color=colour, width=0.6)
        axes.set_xlabel("Hit")
        axes.set_xticks(hit)
        axes.set_ylabel(label)
    return Drawing(figure, columns)
