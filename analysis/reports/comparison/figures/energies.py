"""Kinetic, elastic and dissipated energy of several runs against time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from granwave.analysis.figures.series import against_time, column_name, label
from granwave.analysis.figures.style import Drawing
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.reports.comparison.curves import (
    FORMS,
    SampledCurve,
    energy_shares,
    numerical_shares,
)
from granwave.analysis.reports.comparison.figures.axes import (
    is_in_a_row,
    label_lowest,
    legend_above,
    run_panels,
    run_styles,
    show_times_up_to,
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
_NOTHING = 1e-9  # fraction of the input: energy that is due to rounding


def draw_energies(
    curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], measured: Sequence[MeasuredCurve]
) -> Drawing:
    """Draw kinetic, elastic and dissipated energy divided by the input against time, a panel each.

    A form of energy that is zero in every run has no panel.
    """
    forms = [form for form in FORMS if _has_energy(curves, form)]
    figure, *stack = run_panels(len(curves), len(forms), 1.0 + 1.1 * len(forms), _SIDE_BY_SIDE)
    columns: dict[str, Array] = {}
    ends: dict[ComparedRun, float] = {}
    for run, look in run_styles(list(curves)).items():
        linestyle = look.pop("linestyle")
        for axes, form in zip(stack, forms, strict=True):
            curve = curves[run][form]
            against_time(axes, curve.x, curve.y, linestyle, **look)
            name = column_name(run.label)
            columns |= {f"{name}_time_s": curve.x, f"{name}_{form}_over_input": curve.y}
        ends[run] = float(curves[run][forms[0]].x[-1])
    for axes, form in zip(stack, forms, strict=True):
        of_input = " / input" if is_in_a_row(len(curves)) else ""
        label(axes, y=f"{_title(form, curves)}{of_input}")
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        show_times_up_to(axes, ends)
    label_lowest(stack, len(curves), "Time (µs)")
    if not is_in_a_row(len(curves)):
        figure.supylabel("Energy / input", fontsize=8)
    legend_above(figure)
    return Drawing(figure, columns)


def _title(form: str, runs: Iterable[ComparedRun]) -> str:
    """Return the title of the panel of a form of energy."""
    if form == _KINETIC and any(run.run.number(_PUNCH_KEY) is not None for run in runs):
        return _WITH_PUNCH
    return form.capitalize()


def _has_energy(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]], form: str) -> bool:
    return any(np.abs(shares[form].y).max() > _NOTHING for shares in curves.values())


def energy_notes(curves: Mapping[ComparedRun, Mapping[str, SampledCurve]]) -> str:
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
