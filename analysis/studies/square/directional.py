"""Directionality of waves: packings of any kind that strikers hit, side by side."""

from __future__ import annotations

from collections.abc import Sequence

from granwave.analysis.measures.waves.directions import AXIS_ANGLE
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.square.runs import WAYS, PackingRun, packings, squares
from granwave.analysis.studies.study import Row
from granwave.analysis.studies.titles import law_label

TITLE = "How directional the waves stay"
TEXT = (
    "Share of the energy of the spheres, before the wave reaches an end, and of all dissipation, "
    f"within {AXIS_ANGLE:g} degrees of the directions of contacts from the struck spheres. Theory: an even "
    "spread. Square packings: the fastest impact. Each run's own map is its figure `directions`."
)


def select(runs: Sequence[FinishedRun]) -> list[list[PackingRun]]:
    """One group of all packings of like spheres, of square ones the fastest impact of each way and law."""
    chosen = [run for run in packings(runs) if run.case.packing.kind != "square" and run.alike]
    laws = dict.fromkeys(run.case.contact.law for run in packings(runs))
    chosen += [series[-1] for way in WAYS for law in laws if (series := squares(runs, way, law))]
    return [chosen] if any(one is not None for run in chosen for one in run.spreads) else []


def rows(runs: Sequence[PackingRun]) -> list[Row]:
    """A row for each run, of the energy and of dissipation."""
    found = [
        Row(f"{what} along contacts: {_words(run)}", "%", None, 100 * one.along, "ours alone", "", 100 * one.even)
        for run in runs
        for what, one in zip(("Energy", "Dissipation"), run.spreads, strict=True)
        if one is not None
    ]
    return sorted(found, key=lambda row: row.quantity)


def _words(run: PackingRun) -> str:
    kind = run.case.packing.kind
    return f"{kind}, {law_label(run.case)}, {run.speed:g} m/s" + (f", {run.way}" if kind == "square" else "")
