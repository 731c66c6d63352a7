"""Impacts on packings and on blocks in one report: each other's scaling, and side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from granwave.analysis.document.cells import show
from granwave.analysis.document.model import Note, Table
from granwave.analysis.studies.packing_and_block import blocks, forces, packings, sides, zone
from granwave.analysis.studies.packing_and_block.impacts import Impacts, collect, energy_unit
from granwave.analysis.studies.runs import ContinuumRun, FinishedRun
from granwave.analysis.studies.study import Sketch

TITLE = "Comparison"
_PARTS = (sides, zone, packings, forces, blocks)


def select(runs: Sequence[FinishedRun | ContinuumRun]) -> list[Impacts]:
    """All that can be compared, as one group."""
    impacts = collect(runs)
    return [impacts] if impacts.granular or impacts.continuum else []


def text(impacts: Impacts) -> str:
    """The references, the units of energy, and the time that it took."""
    parts = []
    if impacts.reference:
        first, many = impacts.reference[0], len(impacts.reference)
        size = " x ".join(map(str, first.case.packing.size))
        parts.append(
            f"Granular reference: {first.case.packing.kind} {size}, D = {show(1e3 * first.diameter)} mm, "
            f"{first.case.material.name or 'one material'}, {many} {'velocities' if many > 1 else 'velocity'}; "
            f"energies are normalised by F_y alpha_y = {show(first.law.yield_force * first.law.yield_overlap)} J."
        )
    if impacts.continuum_reference:
        case = impacts.continuum_reference[0].case
        parts.append(
            f"Continuum reference: a punch of {show(1e3 * case.punch.diameter)} mm and {show(case.punch.mass)} kg on "
            f"{case.material.name or 'one material'}, {case.run.elements} elements; energies are normalised by "
            f"sigma_y^2 D^3/E = {show(energy_unit(case.material, case.punch.diameter))} J."
        )
    summaries = [run.summary for run in impacts.granular] + [run.summary for run in impacts.continuum]
    seconds = sum(float(summary.get("wall_time_s") or 0) for summary in summaries)
    if seconds >= 1:
        who = f"All {len(summaries)} runs" if len(summaries) > 1 else "The run"
        parts.append(f"{who} took {show(round(seconds))} s of computing.")
    return " ".join(parts)


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Pictures of all parts."""
    for part in _PARTS:
        yield from part.pictures(impacts)


def tables(impacts: Impacts) -> Iterator[Table | Note]:
    """Tables of all parts, with notes on them."""
    for part in _PARTS:
        yield from part.tables(impacts)
