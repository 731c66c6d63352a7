"""Influence of the bottom: the same impact on a rigid wall, plates, half-spaces and bars.

The packing is the same on all bottoms.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.figures.series import column_name, legend_outside, panels
from granwave.analysis.figures.style import BLUE, GREEN, GREY, ORANGE, PURPLE, SKY, Drawing
from granwave.analysis.measures.signals import Array
from granwave.analysis.studies.protection.runs import TargetRun, impacts, names, spans, table
from granwave.analysis.studies.runs import FinishedRun, impact_title
from granwave.analysis.studies.study import Picture

NEEDS = "the same packing and impact on at least two different bottoms"
_MOST = 12  # largest number of curves in a figure
_STYLES = tuple(product(("-", "--", ":"), ("black", BLUE, ORANGE, GREEN, PURPLE, SKY, GREY)))
_MICRO = 1e6


def select(runs: Sequence[FinishedRun]) -> list[list[TargetRun]]:
    """Packings of the height with the largest number of bottoms, at least two, for each impact."""
    groups = []
    for impact in impacts(runs):
        packings = [run for run in impact if run.assembly.lattice.n_spheres > 1]
        group = _one_height(packings)
        if _n_bottoms(group) > 1:
            groups.append(group)
    return groups


def _n_bottoms(runs: Sequence[TargetRun]) -> int:
    """Number of different bottoms."""
    return len({run.bottom for run in runs})


def title(runs: Sequence[TargetRun]) -> str:
    """Title with packing and impact."""
    return f"Protected target, by bottom: {impact_title(runs[0].assembly)}"


def text(runs: Sequence[TargetRun]) -> str:
    """Describe the comparison."""
    return (
        f"The same impact hits {_layers(runs)} on each bottom. The reduction is the peak "
        "force of the same impact directly on the target, divided by the peak force on the "
        "target below the packing. The impulse is the impulse of the last layer on the target, "
        "up to the end of the run. A packing spreads the impulse in space and time but does "
        "not reduce it, and rebounding spheres increase it. The energy is the largest work on "
        "the target; a rigid wall absorbs no energy."
    )


def tables(runs: Sequence[TargetRun]) -> list[DocumentTable]:
    """All runs."""
    return [table("Force, impulse and energy at the target, by bottom", runs, "B")]


def pictures(runs: Sequence[TargetRun]) -> Iterator[Picture]:
    """Force, impulse and energy against time at the lowest friction."""
    plain = _plain(runs)
    figure, *stack = panels(5.6, rows=3, width=4.6, sharex=True)
    columns: dict[str, Array] = {}
    for run, name, (line, colour) in zip(plain, names(plain), _STYLES, strict=False):
        word = column_name(name)
        reached = run.reached
        energy_time, energy = run.energy
        columns |= {f"{word}_time_s": reached.time, f"{word}_energy_time_s": energy_time}
        shown = (
            ("Force (N)", reached.time, reached.force, 1.0, "force_N"),
            ("Impulse (mN s)", reached.time, reached.impulse, 1e-3, "impulse_Ns"),
            ("Energy (mJ)", energy_time, energy, 1e-3, "energy_J"),
        )
        for axes, (label, time, values, unit, column) in zip(stack, shown, strict=True):
            axes.plot(_MICRO * time, values / unit, line, color=colour, linewidth=1.0, label=name)
            axes.set_ylabel(label)
            columns[f"{word}_{column}"] = values
    stack[-1].set(xlabel="Time (µs)", xlim=(0, _MICRO * max(run.reached.time[-1] for run in plain)))
    legend_outside(figure, 2, fontsize=7)
    through = f"{_layers(runs)}, friction {plain[0].friction:g}"
    caption = (
        f"Force, impulse and energy that reach the target through {through}, against time. A "
        "lower peak force means better protection of the target; the impulse is spread in "
        "time, not reduced"
    )
    yield Picture("", caption, Drawing(figure, columns))


def verdict(runs: Sequence[TargetRun]) -> Iterator[str]:
    """Reduction, impulse and energy at the lowest friction."""
    yield from spans(_plain(runs), "peak_reduction", "impulse_over_momentum", "energy_over_input")


def _one_height(runs: Sequence[TargetRun]) -> list[TargetRun]:
    """Runs of the height with most bottoms, the largest of several."""
    groups: dict[int, list[TargetRun]] = {}
    for run in runs:
        groups.setdefault(run.layers, []).append(run)
    return max(groups.values(), key=lambda group: (_n_bottoms(group), group[0].layers), default=[])


def _layers(runs: Sequence[TargetRun]) -> str:
    return f"{runs[0].layers} layers" if runs[0].layers > 1 else "a single layer"


def _plain(runs: Sequence[TargetRun]) -> list[TargetRun]:
    """Select the runs with the lowest friction, as many as a figure can show."""
    least = min(run.friction for run in runs)
    return [run for run in runs if run.friction == least][:_MOST]
