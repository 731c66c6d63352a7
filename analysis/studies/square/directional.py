"""How directional waves stay: packings of any kind that strikers hit, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.measures.directions import AXIS_ANGLE
from granwave.analysis.studies.square.runs import PackingRun, squares
from granwave.analysis.studies.study import Row, Study
from granwave.analysis.studies.titles import law_words


def directional(runs: Sequence[PackingRun]) -> Iterator[Study]:
    """One study of all packings of like spheres; a row for each run and quantity."""
    alike = [run for run in runs if run.alike]
    chosen = [run for run in alike if run.case.packing.kind != "square"]
    for way in ("in-plane", "out-of-plane"):
        fastest = {run.law: run for run in squares(alike, way)}  # the last of each law
        chosen += fastest.values()
    rows = [row for run in chosen for row in _rows(run)]
    if rows:
        yield Study(
            "directional",
            "How directional the waves stay",
            "Share of the energy of the spheres, before the wave reaches an end, and of all dissipation, "
            f"within {AXIS_ANGLE:g} degrees of the directions of contacts from the struck spheres. Theory: an even "
            "spread. Square packings: the fastest impact. Each run's own map is its figure `directions`.",
            tuple(sorted(rows, key=lambda row: row.quantity)),
        )


def _rows(run: PackingRun) -> Iterator[Row]:
    words = f"{run.case.packing.kind}, {law_words(run.case)}, {run.speed:g} m/s"
    if run.case.packing.kind == "square":
        words += f", {run.way}"
    for what, one in zip(("Energy", "Dissipation"), run.spreads, strict=True):
        if one is not None:
            yield Row(f"{what} along contacts: {words}", "%", None, 100 * one.along, "ours alone", "", 100 * one.even)
