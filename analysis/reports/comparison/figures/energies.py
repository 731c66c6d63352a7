"""Kinetic, elastic and dissipated energy of several runs against time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from granwave.analysis.figures.series import against_time, column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.figures.user_axes import SCALED_TEXT
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    FORMS,
    SampledCurve,
    energy_shares,
    numerical_shares,
)
from granwave.analysis.reports.comparison.figures.axes import (
    are_times_logarithmic,
    end_notes,
    first_change,
    is_in_a_row,
    label_lowest,
    last_change,
    legend_above,
    mark_start,
    run_panels,
    run_styles,
    show_times_up_to,
    start_notes,
)
from granwave.analysis.reports.comparison.figures.figure import ComparisonFigure
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.subjects import ComparedRun, LackingError
from granwave.analysis.reports.sentences import share

_KINETIC = "kinetic"
_WITH_PUNCH = "Kinetic,\nwith punch"
_BLOCK_KEY = "energy_kinetic_J"
_PUNCH_KEY = "energy_punch_J"
_SIDE_BY_SIDE = 2.5  # inches
_NO_CHANGE = "no energy changes by more than 1 % of the input"
_NOTHING = 1e-9  # fraction of the input: energy that is due to rounding


def draw_energies(
    curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw kinetic, elastic and dissipated energy divided by the input against time, a panel each.

    A form of energy that is zero in every run has no panel.
    """
    forms = [form for form in FORMS if _has_energy(curves, form)]
    figure, *stack = run_panels(len(curves), len(forms), 1.0 + 0.9 * len(forms), _SIDE_BY_SIDE)
    columns: dict[str, Array] = {}
    colours: dict[ComparedRun, str] = {}
    for run, look in run_styles(list(curves)).items():
        colours[run] = look["color"]
        linestyle = look.pop("linestyle")
        for axes, form in zip(stack, forms, strict=True):
            curve = curves[run][form]
            against_time(axes, curve.x, curve.y, linestyle, **look)
            name = column_name(run.label)
            columns |= {f"{name}_time_s": curve.x, f"{name}_{form}_over_input": curve.y}
    times = _Times.of(curves)
    for axes, form in zip(stack, forms, strict=True):
        of_input = " / input" if is_in_a_row(len(curves)) else ""
        label(axes, y=f"{_title(form, curves)}{of_input}")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        show_times_up_to(axes, times.ends, times.first_changes, times.last_change)
        if are_times_logarithmic(times.ends):
            for run, colour in colours.items():
                mark_start(axes, float(curves[run][form].y[0]), colour)
    label_lowest(stack, len(curves), "Time (µs)")
    if not is_in_a_row(len(curves)):
        figure.supylabel("Energy / input", fontsize=8).set_label(SCALED_TEXT)
    legend_above(figure)
    return Drawing(figure, columns)


@dataclass(frozen=True)
class _Times:
    """Times of the curves of energy: ends of the runs, their first changes, and the last change of
    all; s.
    """

    ends: dict[ComparedRun, float]
    first_changes: dict[ComparedRun, float]
    last_change: float

    @classmethod
    def of(cls, curves: Mapping[ComparedRun, Mapping[str, SampledCurve]]) -> _Times:
        """Return the times of runs; energies are divided by the input."""
        forms = {run: list(shares.values()) for run, shares in curves.items()}
        ends = {run: float(shares[0].x[-1]) for run, shares in forms.items()}
        first = {run: min(map(first_change, shares)) for run, shares in forms.items()}
        every = chain.from_iterable(forms.values())
        return cls(ends, first, max(last_change(curve, 1.0) for curve in every))


def _title(form: str, runs: Iterable[ComparedRun]) -> str:
    """Return the title of the panel of a form of energy."""
    if form == _KINETIC and any(run.run.number(_PUNCH_KEY) is not None for run in runs):
        return _WITH_PUNCH
    return form.capitalize()


def _has_energy(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], form: str) -> bool:
    return any(np.abs(shares[form].y).max() > _NOTHING for shares in curves.values())


def energy_notes(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]]) -> str:
    """Return sentences on the dissipated energy, on energies that are in no panel, and on the axis
    of time.
    """
    times = _Times.of(curves)
    notes = [
        _notes_on_energies(curves),
        start_notes(times.ends, times.first_changes),
        end_notes(times.ends, times.last_change, _NO_CHANGE),
    ]
    return " ".join(filter(None, notes))


def _notes_on_energies(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]]) -> str:
    """Return sentences on the dissipated energy, and on energies that are in no panel."""
    blocks = [run for run in curves if not run.has_spheres]
    if not blocks:
        return "A constant dissipated energy shows that no contact dissipates any more."
    first = "A constant dissipated energy shows that no contact and no element dissipates any more."
    kinetic = [text for run in blocks if (text := _kinetic_text(run))]
    if kinetic:
        first = (
            f"{first} The kinetic energy includes the impactor of a packing and the punch on a "
            f"block: {'; '.join(kinetic)}."
        )
    parts = [text for run in blocks if (text := _numerical_text(run))]
    if not parts:
        return first
    return (
        f"{first} The dissipated energy of a continuum run is its plastic dissipation, as in the "
        f"dissipated fraction. Energies of its numerical method are in no panel: "
        f"{'; '.join(parts)}."
    )


def _kinetic_text(run: ComparedRun) -> str:
    """Return the kinetic energies of a block and of the punch at the end, in words; empty for a run
    without a punch.
    """
    block, punch = [run.run.number(key) for key in (_BLOCK_KEY, _PUNCH_KEY)]
    if block is None or punch is None:
        return ""
    parts = f"{quantity_in(block, 'J')} in the block and {quantity_in(punch, 'J')} in the punch"
    return f"{parts} at the end ({run.name})"


def _numerical_text(run: ComparedRun) -> str:
    """Return the energies of the numerical method of a run in words, the largest first; empty
    without them.
    """
    try:
        shares = numerical_shares(run)
    except LackingError:
        return f"not readable ({run.name})"
    named = sorted(shares.items(), key=lambda entry: -abs(entry[1]))
    parts = [f"{name} {share(part)}" for name, part in named if abs(part) > _NOTHING]
    return f"{', '.join(parts)} of the input at the end ({run.name})" if parts else ""


ENERGIES = ComparisonFigure(
    "Kinetic, elastic and dissipated energy against time, relative to the input",
    energy_shares,
    draw_energies,
    notes=energy_notes,
    values=("dissipated_fraction",),
)
