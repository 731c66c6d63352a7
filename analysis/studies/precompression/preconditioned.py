"""Spheres that were pressed before: dents that keep contacts elastic up to the force they were pressed with.

A contact that once bore F_p unloads and reloads on one curve and loses nothing up to F_p (thesis 1.1, 2.1). Dents leave
gaps between spheres at nominal places; a small static load closes them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import legend_outside, one_panel
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.precompression.runs import (
    DISSIPATED,
    GREW,
    IMPACT,
    PEAK_FORCE,
    TRANSMITTED,
    DentedRun,
    past_runs,
    released_energy_note,
)  # fmt: skip
from granwave.analysis.studies.runs import FinishedRun, grouped, rising
from granwave.analysis.studies.study import Picture, Row
from granwave.analysis.studies.tables import Quantity, values_table
from granwave.analysis.studies.titles import packing_title
from granwave.lammps_inputs.case.sections import Dents

Runs = Sequence[DentedRun]

_VARYING = ("contact.initial_overlap", "load.velocity")
_ELASTIC = 1e-9  # share of the input: nothing is dissipated
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_REACHED = 1e-3  # of the largest force along the chain: the pulse has come to a contact


def select(runs: Sequence[FinishedRun]) -> list[list[DentedRun]]:
    """Each chain and packing that was struck with dents of one size everywhere, and without, by level and velocity."""
    chosen = [run for run in past_runs(runs) if run.case.contact.yields and np.isfinite(level_of(run))]
    groups = [group for group in grouped(chosen, *_VARYING) if any(map(level_of, group))]
    return [sorted(group, key=lambda run: (level_of(run), run.case.load.velocity)) for group in groups]


def level_of(run: DentedRun) -> float:
    """Force up to which the contacts were pressed before, N; 0: never; NaN where it is not the same for all."""
    given = run.case.contact.initial_overlap
    if isinstance(given, str):
        return np.nan
    if not isinstance(given, tuple):
        given = (Dents(overlap=given),)
    if len(given) != 1 or given[0].low is not None or given[0].high is not None:
        return np.nan
    if given[0].force is not None:
        return given[0].force
    return float(run.law.loading_force(np.array([given[0].overlap or 0.0]))[0])


def title(runs: Runs) -> str:
    """By packing."""
    return f"Preconditioned: {packing_title(runs[0].case)}"


def text(runs: Runs) -> str:
    """Describe the runs: effect of dents, and whether their gaps are closed."""
    closed = "are closed by a static load, which stays on."
    gaps = closed if runs[0].case.precompression else "are there at the impact."
    return (
        "Contacts that have dents from the start, of one force everywhere: they shall stay elastic up to that force. "
        f"The gaps that dents leave between spheres at their nominal places {gaps}{released_energy_note(runs)}"
    )


def rows(runs: Runs) -> Iterator[Row]:
    """How far the contacts stay elastic, and what is dissipated just beyond."""
    for level, series in _by_level(runs):
        elastic = [run for run in series if run.dissipated < _ELASTIC]
        losing = [run for run in series if run.dissipated >= _ELASTIC]
        for found, which, choose in ((elastic, "Largest force without", max), (losing, "Smallest force with", min)):
            if found and level:
                force = choose(map(PEAK_FORCE.value, found))
                quantity = f"{which} dissipation over that of the preconditioning, {level:g} N"
                remark = f"Theory: the two are on either side of 1; of {len(series)} impacts."
                yield Row(quantity, "", None, force / level, "thesis 1.1", remark, 1.0)


def tables(runs: Runs) -> list[Table]:
    """All impacts; without what arrives at the bottom where nothing does."""
    quantities = [
        Quantity("level_N", "Preconditioned to", "N", level_of),
        IMPACT,
        dataclasses.replace(PEAK_FORCE, heading="Largest force"),
        DISSIPATED,
        GREW,
    ]
    if any(run.transmitted for run in runs):
        quantities.append(TRANSMITTED)
    return [values_table("Impacts with and without preconditioning", runs, quantities)]


def verdict(runs: Runs) -> Iterator[str]:
    """Fresh contacts beside those of the highest level."""
    series = _one_velocity(runs)
    fresh, best = series[0], series[-1]
    if level_of(fresh) == 0 and best is not fresh:
        yield (
            f"Impact at {fresh.case.load.velocity:g} m/s: fresh contacts dissipate {100 * fresh.dissipated:.3g} %, "
            f"those preconditioned to {level_of(best):g} N {100 * best.dissipated:.3g} %."
            + released_energy_note((fresh, best))
        )


def pictures(runs: Runs) -> Iterator[Picture]:
    """Dissipation, and in chains the largest force along them."""
    yield Picture("_dissipation", "Dissipation against the largest force, by preconditioning", _draw_dissipation(runs))
    fastest = _one_velocity(runs) if runs[0].case.packing.kind == "chain" else []
    if len(fastest) > 1:
        caption = f"Largest force along the chain, impact at {fastest[0].case.load.velocity:g} m/s"
        yield Picture("_pulse", caption, _draw_pulses(fastest))


def _by_level(runs: Runs) -> list[tuple[float, list[DentedRun]]]:
    return [(level, [run for run in runs if level_of(run) == level]) for level in sorted(set(map(level_of, runs)))]


def _one_velocity(runs: Runs) -> list[DentedRun]:
    """Runs by level at the velocity that most levels have, the largest of such."""
    same = max(grouped(runs, "contact.initial_overlap"), key=lambda one: (len(one), one[0].case.load.velocity))
    return rising(same, level_of)


def _draw_dissipation(runs: Runs) -> Drawing:
    figure, axes = one_panel(2.7, "Largest contact force (N)", "Dissipated (% of input)")
    columns: dict[str, np.ndarray] = {}
    for place, (level, series) in enumerate(_by_level(runs)):
        force, share = (np.array([one.value(run) for run in series]) for one in (PEAK_FORCE, DISSIPATED))
        colour, label = _look(place, level)
        axes.semilogx(force, 100 * share, "o-", color=colour, markersize=3, label=label)
        if level:
            axes.axvline(level, color=colour, linestyle=":", linewidth=0.8)
        columns |= {f"level_{level:g}_N_peak_force_N": force, f"level_{level:g}_N_dissipated_percent": 100 * share}
    axes.set_ylim(-2, max(105.0, 105 * max(run.dissipated for run in runs)))
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    legend_outside(figure, title="Preconditioned to")
    return Drawing(figure, columns)


def _draw_pulses(runs: Runs) -> Drawing:
    figure, axes = one_panel(2.5, "Contact", "Largest force (N)")
    columns: dict[str, np.ndarray] = {}
    for place, run in enumerate(runs):
        peaks, level = run.seen_as(ChainRun).of_contacts("peak_force"), level_of(run)
        contact = np.arange(1, len(peaks) + 1)
        colour, label = _look(place, level)
        axes.semilogy(contact, np.where(peaks > _REACHED * peaks.max(), peaks, np.nan), color=colour, label=label)
        columns |= {"contact": contact, f"level_{level:g}_N_peak_force_N": peaks}
    axes.set_xlim(left=0)
    legend_outside(figure, title="Preconditioned to")
    return Drawing(figure, columns)


def _look(place: int, level: float) -> tuple[str, str]:
    """Colour and label of a level."""
    return (_COLOURS[place % len(_COLOURS)], f"{level:g} N") if level else (GREY, "fresh")
