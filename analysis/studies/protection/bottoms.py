"""What the bottom changes: the same impact on the same packing, on a rigid wall, plates, half-spaces and bars."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing, new_figure
from granwave.analysis.formatting.numbers import number
from granwave.analysis.studies.protection import tables
from granwave.analysis.studies.protection.runs import TargetRun, names, slug
from granwave.analysis.studies.protection.spectrum import spectra
from granwave.analysis.studies.study import Picture, Study
from granwave.analysis.studies.titles import impact_words

_STYLES = [(colour, line) for line in ("-", "--", ":") for colour in ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)]
_PANELS = (("force", "Force (N)", 1.0), ("impulse", "Impulse (mN s)", 1e-3), ("energy", "Energy (mJ)", 1e-3))
_UNITS = {"force": "N", "impulse": "Ns", "energy": "J"}
_MICRO = 1e6
_MOST = 12  # curves of a figure
_COLUMNS = (
    tables.FORCE, tables.LOCAL, tables.UNPROTECTED, tables.REDUCTION, tables.GROUND, tables.GROUND_REDUCTION,
    tables.IMPULSE, tables.MOMENTUM, tables.ENERGY, tables.MOVED,
)  # fmt: skip


def bottoms(runs: Sequence[TargetRun], suffix: str) -> Iterator[Study]:
    """One study of the height with most bottoms, two at least."""
    shown_apart = {run for one in spectra(runs) for run in one.runs}
    chosen = _one_height([run for run in runs if run.assembly.lattice.n_spheres > 1 and run not in shown_apart])
    if len({run.bottom for run in chosen}) < 2:
        return
    plain = [run for run in chosen if run.friction == min(one.friction for one in chosen)][:_MOST]
    layers = f"{chosen[0].layers} layers" if chosen[0].layers > 1 else "a single layer"
    caption = f"Force, impulse and energy that reach the target through {layers}, friction {plain[0].friction:g}"
    yield Study(
        f"protected-bottoms{suffix}",
        f"Protected target, by bottom: {impact_words(chosen[0].case)}",
        f"The same impact through {layers} on each bottom. Reduction: the peak force of the same impact directly on "
        "the target over that on the target below the packing. Impulse: of the last layer on the target, up to the end "
        "of the run. Energy: the work that it has done on the target, at most. A rigid wall takes none.",
        pictures=(Picture(f"protected_bottoms{suffix.replace('-', '_')}", caption, _draw(plain)),),
        tables=(tables.table("What reaches the target, by bottom", chosen, _COLUMNS),),
        verdict=tuple(_verdict(plain)),
    )


def _one_height(runs: Sequence[TargetRun]) -> list[TargetRun]:
    heights = {run.layers for run in runs}
    best = max(heights, key=lambda n: (len({run.bottom for run in runs if run.layers == n}), n), default=0)
    return [run for run in runs if run.layers == best]


def _verdict(runs: Sequence[TargetRun]) -> Iterator[str]:
    known = [run for run in runs if math.isfinite(run.value("peak_reduction"))]
    if known:
        yield from _of_forces(known)
    gained = [tables.MOMENTUM.value(run) for run in runs]
    if all(map(math.isfinite, gained)):
        yield (
            f"The impulse on the target is {number(min(gained))} to {number(max(gained))} times the "
            "impactor's momentum: a packing spreads it in space and time, it does not take it away, and spheres that "
            "rebound add to it."
        )
    moving = [run for run in runs if run.moves]
    if moving:
        most = max(moving, key=tables.ENERGY.value)
        share = number(100 * tables.ENERGY.value(most))
        yield f"Of the energy at most {share} % reach the target ({most.bottom})."


def _of_forces(runs: Sequence[TargetRun]) -> Iterator[str]:
    """Of runs with a known reduction: that of the force, and the force of a single sphere."""
    most, least = (pick(runs, key=lambda run: run.value("peak_reduction")) for pick in (max, min))
    mass, height = (number(most.value(key)) for key in ("packing_mass_kg", "packing_height_m"))
    layers = f"{most.layers} layer{'s' if most.layers > 1 else ''}"
    yield (
        f"{layers} ({mass} kg, {height} m) cut the peak force on the target {_times(least)} times "
        f"({_forces(least)}: {least.bottom}) to {_times(most)} times ({_forces(most)}: {most.bottom})."
    )
    shares = {run: run.largest_of_one / run.value("unprotected_peak_force_N") for run in runs}
    worst = max(runs, key=lambda run: shares[run])
    if math.isfinite(shares[worst]):
        yield (
            "It is spread over many spheres: a single one presses on the target with at most "
            f"{number(100 * shares[worst])} % of the force without the packing ({worst.bottom})."
        )


def _times(run: TargetRun) -> str:
    return number(run.value("peak_reduction"))


def _forces(run: TargetRun) -> str:
    before, after = run.value("unprotected_peak_force_N"), run.value("wall_peak_force_N")
    return f"{number(before)} to {number(after)} N"


def _draw(runs: Sequence[TargetRun]) -> Drawing:
    figure = new_figure(5.6, 4.6)
    panels = figure.subplots(3, 1, sharex=True)
    columns: dict[str, NDArray[np.float64]] = {}
    for run, name, (colour, line) in zip(runs, names(runs), _STYLES, strict=False):
        word, reached, (ledger, energy) = slug(name), run.reached, run.energy
        found = {
            "force": (reached.time, reached.force),
            "impulse": (reached.time, reached.impulse),
            "energy": (ledger, energy),
        }
        columns |= {f"{word}_time_s": reached.time, f"{word}_energy_time_s": ledger}
        for axes, (what, label, scale) in zip(panels, _PANELS, strict=True):
            time, values = found[what]
            axes.plot(_MICRO * time, values / scale, line, color=colour, linewidth=1.0, label=name)
            axes.set_ylabel(label)
            columns[f"{word}_{what}_{_UNITS[what]}"] = values
    panels[-1].set_xlabel("Time (µs)")
    panels[-1].set_xlim(0, _MICRO * max(run.reached.time[-1] for run in runs))
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=2, fontsize=7)
    return Drawing(figure, columns)
