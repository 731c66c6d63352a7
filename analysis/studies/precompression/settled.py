"""Packings of spheres that differ in size, settled before the impact, beside the same ones as they were placed.

Placed on the sites of a lattice, spheres smaller than nominal have gaps all around. Settled without friction they stand
on as few contacts as can hold them: as many as there are directions in which they can move, three for each sphere,
those with walls among them. A larger load closes more.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from granwave.analysis.document.cells import BLANK
from granwave.analysis.document.model import Cell, Column, Table, Tone
from granwave.analysis.figures.series import legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, ORANGE, Drawing
from granwave.analysis.formatting.numbers import with_interval
from granwave.analysis.statistics import Estimate, differ_significantly, estimate, exactly
from granwave.analysis.studies.precompression.runs import DentedRun, past_runs, released_energy_note
from granwave.analysis.studies.runs import FinishedRun, grouped
from granwave.analysis.studies.study import Picture
from granwave.analysis.studies.tables import values_table
from granwave.analysis.studies.titles import load_label, packing_title, state_label
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.disorder import DEFAULT_SEED, is_random

_VARYING = ("packing.diameter_scatter", "packing.scatter_distribution", "packing.seed", "precompression")
_ENOUGH = 1e-3  # of the static force: the residual up to which a packing is settled
_SHADES = (ORANGE, "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#F0E442")


@dataclasses.dataclass(frozen=True)
class State:
    """Packings made alike but for their seeds."""

    words: str
    runs: tuple[DentedRun, ...]

    @property
    def case(self) -> Case:
        """Case of the first of them."""
        return self.runs[0].case

    @property
    def scattered(self) -> bool:
        """The spheres differ in size."""
        return bool(self.case.packing.diameter_scatter)

    def mean(self, value: Callable[[DentedRun], float]) -> Estimate | None:
        """Mean of a value over the seeds; None where it is not known."""
        values = [value(run) for run in self.runs]
        if not np.isfinite(values).all():
            return None
        return estimate(values) if is_random(self.case) else exactly(float(values[0]))


def select(runs: Sequence[FinishedRun]) -> list[list[State]]:
    """Each packing with a diameter scatter that was run settled and as placed: its states, the ideal packing first."""
    found = []
    for group in grouped(past_runs(runs), *_VARYING):
        if group[0].case.packing.kind == "chain" or group[0].case.contact.initial_overlap:
            continue
        for band in sorted({_band(run.case) for run in group if run.case.packing.diameter_scatter}):
            states = _states([run for run in group if not run.case.packing.diameter_scatter or _band(run.case) == band])
            if any(state.case.precompression for state in states if state.scattered):
                found.append(states)
    return found


def title(states: Sequence[State]) -> str:
    """By scatter."""
    return f"Settled packings, scatter of {_scatter(states)}"


def text(states: Sequence[State]) -> str:
    """The packing, how it is settled, and what the columns are."""
    case = _scattered_case(states)
    return (
        f"{packing_title(case)} whose diameters are up to {_scatter(states)} smaller "
        f"({case.packing.scatter_distribution}), "
        f"struck at {load_label(case)}: as placed with gaps, and settled without friction by a static load that stays "
        "on. Means over seeds with 95 % confidence intervals. Contacts that bear force: of two spheres, at the start; "
        "standing without friction takes three for each sphere, those with walls counted. Residual: largest net force "
        "left on a sphere over the largest static force of a contact."
        + released_energy_note(run for state in states for run in state.runs)
    )


def tables(states: Sequence[State]) -> list[Table]:
    """A row for each state."""
    return [values_table("Settled and as placed", states, (), _COLUMNS)]


def verdict(states: Sequence[State]) -> Iterator[str]:
    """Compare the arriving force with that in the packing as placed."""
    scattered = [state for state in states if state.scattered]
    placed = next((state.mean(_transmitted) for state in scattered if state.case.precompression is None), None)
    for state in scattered:
        force = state.mean(_transmitted)
        if state.case.precompression is None or force is None:
            continue
        words = state.words.removeprefix("scattered, ")
        sentence = f"Packing {words}: {with_interval(force, unit='N')} arrive at the bottom"
        if placed is not None and placed.mean:
            times, as_placed = f"{force.mean / placed.mean:.3g}", with_interval(placed, unit="N")
            sentence += f", {times} times what arrives as placed ({as_placed}"
            sentence += ", not to be told from it)" if differ_significantly(force, placed) is False else ")"
        yield f"{sentence}."


def pictures(states: Sequence[State]) -> Iterator[Picture]:
    """Force at the bottom of every run."""
    figure, axes = one_panel(3.2, "Time (µs)", "Force added at the bottom (N)")
    columns: dict[str, np.ndarray] = {}
    shades = iter(_SHADES)
    for number, state in enumerate(states, start=1):
        look: dict[str, Any] = {"color": "black", "linestyle": ":", "zorder": 3}  # over the others
        if state.scattered:
            colour = BLUE if state.case.precompression is None else next(shades, "0.5")
            look = {"color": colour, "linestyle": "-", "zorder": 2}
        for place, run in enumerate(state.runs):
            time, force = run.bottom
            axes.plot(1e6 * time, force, linewidth=1.0, label="" if place else state.words, **look)
            columns |= {f"time_{number}_{place + 1}_s": time, f"force_{number}_{place + 1}_N": force}
    axes.set_xlim(left=0)
    legend_outside(figure, 1, left=True)
    yield Picture("", "Force at the bottom: settled, as placed, and of like spheres", Drawing(figure, columns))


def contacts_a_sphere(run: DentedRun) -> float:
    """Contacts of two spheres that bear force at the start, over the number of spheres; 0 in a packing as placed."""
    if run.case.precompression is None:
        return 0.0
    return run.of_static_stage("contacts") / run.assembly.n_spheres


def _band(case: Case) -> tuple[float, str]:
    return case.packing.diameter_scatter, case.packing.scatter_distribution


def _scattered_case(states: Sequence[State]) -> Case:
    return next(state.case for state in states if state.scattered)


def _scatter(states: Sequence[State]) -> str:
    return f"{1e6 * _scattered_case(states).packing.diameter_scatter:g} µm"


def _transmitted(run: DentedRun) -> float:
    return run.transmitted


def _states(runs: Sequence[DentedRun]) -> list[State]:
    """The ideal packing first, then as placed, then settled by rising load."""
    found: dict[str, dict[int, DentedRun]] = {}

    def order(run: DentedRun) -> tuple[bool, bool, float]:
        case = run.case
        return bool(case.packing.diameter_scatter), case.precompression is not None, run.static_force

    for run in sorted(runs, key=order):
        seed = run.case.packing.seed if run.case.packing.seed is not None else DEFAULT_SEED
        found.setdefault(state_label(run.case), {}).setdefault(seed, run)
    return [State(words, tuple(by_seed[seed] for seed in sorted(by_seed))) for words, by_seed in found.items()]


def _residual(state: State) -> Cell:
    residual = max(run.of_static_stage("residual") for run in state.runs)
    tone: Tone = "bad" if residual > _ENOUGH else ""
    return Cell(f"{residual:.2g}", residual, tone) if np.isfinite(residual) else Cell(BLANK)


def _mean(value: Callable[[DentedRun], float]) -> Callable[[State], Cell]:
    return lambda state: _with_interval(state.mean(value))


def _with_interval(found: Estimate | None) -> Cell:
    if found is None:
        return Cell(BLANK)
    alone = not found.half_width > 0  # of what is not random, or of a single seed
    return Cell(f"{found.mean:.4g}" if alone else with_interval(found), found.mean)


_COLUMNS = (
    (Column("Packing", key=True), lambda state: Cell(state.words, state.words)),
    (Column("Seeds", numeric=True), lambda state: Cell(str(len(state.runs)), len(state.runs))),
    (Column("Contacts that bear force", "a sphere", numeric=True), _mean(contacts_a_sphere)),
    (Column("Residual", numeric=True), _residual),
    (Column("Arrival at the bottom", "µs", numeric=True), _mean(lambda run: 1e6 * run.arrival)),
    (Column("Largest force added there", "N", numeric=True), _mean(_transmitted)),
    (Column("Dissipated", "% of input", numeric=True), _mean(lambda run: 100 * run.dissipated)),
)
