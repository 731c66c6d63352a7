"""Packings of spheres that differ in size, settled before the impact, beside the same ones as they were placed.

Placed on the sites of a lattice, spheres smaller than nominal have gaps all around. Settled without friction they stand
on as few contacts as can hold them: as many as there are directions in which they can move, three for each sphere,
those with walls among them. A larger load closes more.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Cell, Column, Table, Tone
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing, new_figure
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate, can_be_told_apart, estimate, exactly
from granwave.analysis.studies.precompression.runs import PastRun, freed_words, groups
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import load_words, packing_words
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random

_VARYING = ("packing.diameter_scatter", "packing.scatter_distribution", "packing.seed", "precompression")
_ENOUGH = 1e-3  # of the static force: the residual up to which a packing is settled


@dataclasses.dataclass(frozen=True)
class State:
    """Packings made alike but for their seeds."""

    words: str
    runs: tuple[PastRun, ...]

    def of(self, values: Sequence[float]) -> Estimate | None:
        """Mean over the seeds; None where something is not known."""
        if not np.isfinite(values).all():
            return None
        return estimate(values) if is_random(self.runs[0].case) else exactly(float(values[0]))


def settled_packings(runs: Sequence[PastRun]) -> Iterator[Study]:
    """One study of each packing with a diameter scatter that was run settled and as placed."""
    chosen = [run for run in runs if run.case.packing.kind != "chain" and not run.case.contact.initial_overlap]
    number = 0
    for group in groups(chosen, *_VARYING):
        for band in sorted({_band(run.case) for run in group if run.case.packing.diameter_scatter}):
            with_ideal = [run for run in group if run.case.packing.diameter_scatter == 0 or _band(run.case) == band]
            states = _states(with_ideal)
            scattered = [state for state in states if state.runs[0].case.packing.diameter_scatter]
            if any(state.runs[0].case.precompression for state in scattered):
                number += 1
                yield _study(states, number)


def _band(case: Case) -> tuple[float, str]:
    return case.packing.diameter_scatter, case.packing.scatter_distribution


def _states(runs: Sequence[PastRun]) -> list[State]:
    """The ideal packing first, then as placed, then settled by rising load."""
    found: dict[str, dict[int, PastRun]] = {}

    def order(run: PastRun) -> tuple[bool, bool, float]:
        case = run.case
        return bool(case.packing.diameter_scatter), case.precompression is not None, run.static_force

    for run in sorted(runs, key=order):
        seed = run.case.packing.seed if run.case.packing.seed is not None else DEFAULT_SEED
        found.setdefault(_words(run.case), {}).setdefault(seed, run)
    return [State(words, tuple(by_seed[seed] for seed in sorted(by_seed))) for words, by_seed in found.items()]


def _words(case: Case) -> str:
    stage = case.precompression
    first = "like spheres" if not case.packing.diameter_scatter else "scattered"
    if stage is None:
        return f"{first}, as placed"
    if stage.kind == "gravity":
        many = stage.acceleration / 9.81
        return f"{first}, settled under gravity" + (f" times {many:.3g}" if abs(many - 1) > 0.01 else "")
    size = f"{1e-3 * stage.pressure:.4g} kPa" if stage.pressure is not None else f"{stage.force:.3g} N a sphere"
    return f"{first}, settled under {size} on {'top' if stage.kind == 'uniaxial' else 'all sides'}"


def _study(states: Sequence[State], number: int) -> Study:
    case = next(state.runs[0].case for state in states if state.runs[0].case.packing.diameter_scatter)
    scatter = f"{1e6 * case.packing.diameter_scatter:g} µm"
    name = "settled-packing" + (f"-{number}" if number > 1 else "")
    text = (
        f"{packing_words(case)} whose diameters are up to {scatter} smaller ({case.packing.scatter_distribution}), "
        f"struck at {load_words(case)}: as placed with gaps, and settled without friction by a static load that stays "
        "on. Means over seeds with 95 % confidence intervals. Contacts that bear force: of two spheres, at the start; "
        "standing without friction takes three for each sphere, those with walls counted. Residual: largest net force "
        "left on a sphere over the largest static force of a contact."
        + freed_words(run for state in states for run in state.runs)
    )
    picture = Picture(name.replace("-", "_"), "Force at the bottom: settled, as placed, and of like spheres",
                      _draw(states))  # fmt: skip
    return Study(
        name,
        f"Settled packings, scatter of {scatter}",
        text,
        pictures=(picture,),
        tables=(_table(states),),
        verdict=tuple(_verdict(states)),
    )


def _table(states: Sequence[State]) -> Table:
    columns = (
        Column("Packing", key=True),
        Column("Seeds", numeric=True),
        Column("Contacts that bear force", "a sphere", numeric=True),
        Column("Residual", numeric=True),
        Column("Arrival at the bottom", "µs", numeric=True),
        Column("Largest force added there", "N", numeric=True),
        Column("Dissipated", "% of input", numeric=True),
    )
    return Table("Settled and as placed", columns, tuple(_cells(state) for state in states), sortable=True)


def _cells(state: State) -> tuple[Cell, ...]:
    residual = max(run.of_prestage("residual") for run in state.runs)
    tone: Tone = "bad" if residual > _ENOUGH else ""
    return (
        Cell(state.words, state.words),
        Cell(str(len(state.runs)), len(state.runs)),
        _with_interval(state.of([contacts_a_sphere(run) for run in state.runs])),
        Cell(f"{residual:.2g}", residual, tone) if np.isfinite(residual) else Cell(BLANK),
        _with_interval(state.of([1e6 * run.arrival for run in state.runs])),
        _with_interval(state.of([run.transmitted for run in state.runs])),
        _with_interval(state.of([100 * run.dissipated for run in state.runs])),
    )


def contacts_a_sphere(run: PastRun) -> float:
    """Contacts of two spheres that bear force at the start, over the number of spheres; 0 in a packing as placed."""
    if run.case.precompression is None:
        return 0.0
    return run.of_prestage("contacts") / run.assembly.n_spheres


def _with_interval(found: Estimate | None) -> Cell:
    if found is None:
        return Cell(BLANK)
    if not found.half_width > 0:  # of what is not random, or of a single seed
        return Cell(f"{found.mean:.4g}", found.mean)
    return Cell(with_interval(found), found.mean)


def _verdict(states: Sequence[State]) -> Iterator[str]:
    scattered = [state for state in states if state.runs[0].case.packing.diameter_scatter]
    placed = next((state for state in scattered if state.runs[0].case.precompression is None), None)
    for state in scattered:
        if state.runs[0].case.precompression is None:
            continue
        force = state.of([run.transmitted for run in state.runs])
        if force is None:
            continue
        sentence = (
            f"Packing {state.words.removeprefix('scattered, ')}: {with_interval(force, unit='N')} arrive at the bottom"
        )
        other = placed.of([run.transmitted for run in placed.runs]) if placed else None
        if other is not None and other.mean:
            sentence += (
                f", {force.mean / other.mean:.3g} times what arrives as placed ({with_interval(other, unit='N')}"
            )
            sentence += ", not to be told from it)" if can_be_told_apart(force, other) is False else ")"
        yield f"{sentence}."


def _draw(states: Sequence[State]) -> Drawing:
    figure = new_figure(3.2)
    axes = figure.subplots()
    columns: dict[str, np.ndarray] = {}
    shades = iter((ORANGE, "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#F0E442"))
    for number, state in enumerate(states, start=1):
        case = state.runs[0].case
        colour = "black"
        if case.packing.diameter_scatter:
            colour = BLUE if case.precompression is None else next(shades, "0.5")
        for place, run in enumerate(state.runs):
            time, force = run.bottom
            line = ":" if colour == "black" else "-"  # over the others
            label = "" if place else state.words
            axes.plot(1e6 * time, force, line, color=colour, linewidth=1.0, label=label, zorder=3 if line == ":" else 2)
            columns |= {f"time_{number}_{place + 1}_s": time, f"force_{number}_{place + 1}_N": force}
    axes.set_xlabel("Time (µs)")
    axes.set_ylabel("Force added at the bottom (N)")
    axes.set_xlim(left=0)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left")
    return Drawing(figure, columns)
