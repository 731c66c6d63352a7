"""Axes of the figures of a comparison: ends of axes of time, scales of forces, panels of medians,
and sections that are cropped to their packings.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.style import style
from granwave.analysis.reports.comparison.curves import FORMS, SampledCurve
from granwave.analysis.reports.comparison.figures.axes import first_change, last_change
from granwave.analysis.reports.comparison.figures.bottom_force import draw_bottom_force
from granwave.analysis.reports.comparison.figures.energies import draw_energies, energy_notes
from granwave.workflows import load_case, run_case
from tests.analysis.reports.comparison.runs import SMALL, compared

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


@pytest.fixture
def pair(place):
    """Two runs of packings."""
    return list(compared(place, "fcc", "hcp").runs)


def decaying(end: float, step: float, relaxation: float) -> dict[str, SampledCurve]:
    """Energies of a run, divided by the input: the kinetic energy becomes dissipation."""
    time = np.arange(0.0, end + step / 2, step)
    kinetic = np.exp(-time / relaxation)
    values = {"kinetic": kinetic, "elastic": 0.1 * kinetic, "dissipated": 1 - kinetic}
    return {form: SampledCurve(time, values[form]) for form in FORMS}


def test_a_logarithmic_axis_of_time_begins_at_the_first_output(pair):
    """A short impact lost a third of its energy between time 0 and its first output."""
    short = decaying(12e-6, 0.2e-6, 0.5e-6)
    curves = dict(zip(pair, [decaying(150e-6, 0.3e-6, 10e-6), short], strict=True))
    with style():
        panels = draw_energies(curves, []).figure.axes
    for axes, form in zip(panels, FORMS, strict=True):
        assert axes.get_xscale() == "log"
        assert axes.get_xlim()[0] == pytest.approx(0.2)
        starts = [line for line in axes.lines if line.get_label() == "_start"]
        values = [line.get_ydata()[0] for line in starts]
        assert values == [curves[run][form].y[0] for run in pair]
    assert "logarithmic from 200 ns on; triangles on the left edge" in energy_notes(curves)


def test_an_axis_of_energies_ends_after_the_last_change(pair):
    """After the last change by 1 % of the input, times 1.2; the caption states it."""
    curves = {run: decaying(250e-6, 0.1e-6, 5e-6) for run in pair}
    last = 5e-6 * np.log(100)
    with style():
        panels = draw_energies(curves, []).figure.axes
    assert panels[0].get_xlim() == pytest.approx((0, 1.2e6 * last), rel=0.01)
    expected = "The axis of time ends at 27.7 µs of 250 µs: no energy changes by more than 1 % of "
    assert expected in energy_notes(curves)


def test_an_axis_of_energies_shows_a_run_that_still_changes(pair):
    curves = {run: decaying(20e-6, 0.1e-6, 20e-6) for run in pair}
    with style():
        panels = draw_energies(curves, []).figure.axes
    assert panels[0].get_xlim() == pytest.approx((0, 20))
    assert "axis" not in energy_notes(curves)


def test_times_of_changes():
    """Curves that start to change late, stop to change, or never change."""
    time = np.arange(11.0)
    ramp = SampledCurve(time, np.clip(time - 4, 0, 3))
    assert first_change(ramp) == 4
    assert last_change(ramp, 3.0) == 7
    constant = SampledCurve(time, np.ones(11))
    assert first_change(constant) == np.inf
    assert last_change(constant, 1.0) == 0


@pytest.mark.parametrize(("ratio", "scale"), [(20.0, "log"), (5.0, "linear")])
def test_a_small_force_on_the_bottom_can_be_read(pair, ratio, scale):
    """A pulse of a twentieth of another is nearly flat on a linear axis."""
    time = np.linspace(0, 1e-4, 101)
    pulse = np.maximum(0.0, np.sin(2e5 * time))
    curves = {
        run: SampledCurve(time, peak * pulse) for run, peak in zip(pair, (1.0, ratio), strict=True)
    }
    with style():
        (axes,) = draw_bottom_force(curves, []).figure.axes
    assert axes.get_yscale() == scale


def test_medians_have_their_own_scale(place):
    """The largest forces of a layer are many times its median."""
    comparison = compared(place, "fcc", "hcp")
    with style():
        upper, lower = comparison.drawing("peak_force_depth").figure.axes
    medians = np.concatenate([line.get_ydata() for line in lower.lines])
    assert lower.get_ylim()[1] < 2 * np.nanmax(medians) < upper.get_ylim()[1]


def test_a_panel_without_any_median_is_left_out(tmp_path):
    """In a simple cubic packing only the chain below the impact carries a force."""
    for name in ("one", "two"):
        run_case(
            load_case("fcc-small", SMALL | {"packing.kind": "sc"}), tmp_path / name, figures=False
        )
    comparison = compared(tmp_path, "one", "two")
    with style():
        (axes,) = comparison.drawing("peak_force_depth").figure.axes
    assert len(axes.lines) >= 2
    assert "No panel of the medians: in every run" in comparison.caption("peak_force_depth")


def test_sections_of_unlike_size_are_cropped(place, tmp_path):
    """A high section in the same row leaves no empty depth below a flat one."""
    high = SMALL | {"packing.size": [6, 6, 14], "packing.diameter": 0.02}
    run_case(load_case("fcc-small", high), tmp_path / "high", figures=False)
    (tmp_path / "fcc").symlink_to(place / "fcc")
    comparison = compared(tmp_path, "fcc", "high")
    with style():
        panels = comparison.drawing("peak_force_field").figure.axes
    fields = comparison.data("peak_force_field").present.values()
    for axes, field in zip(panels, fields, strict=False):
        lowest = 1e3 * (float(field.cut.down.max()) + 1.5 * field.diameter)
        assert axes.get_ylim()[0] <= lowest
    assert "cropped to its packing" in comparison.caption("peak_force_field")


def test_planes_of_two_lattices_are_named(place):
    """The plane of fcc is inclined, the rows of hcp are projected: they share no axis of depths."""
    comparison = compared(place, "fcc", "hcp")
    with style():
        panels = comparison.drawing("peak_force_field").figure.axes
    labels = [axes.get_ylabel() for axes in panels[:2]]
    assert labels == ["Depth along the plane (mm)", "Depth (mm)"]
    caption = comparison.caption("peak_force_field")
    assert "inclined lattice plane of touching spheres (fcc)" in caption
    assert "zigzag rows of touching spheres, projected onto a vertical plane (hcp)" in caption
    alike = compared(place, "fcc", "fast")
    assert "Section: inclined lattice plane of touching spheres." in alike.caption(
        "peak_force_field"
    )
    with style():
        panels = alike.drawing("peak_force_field").figure.axes
    assert panels[0].get_ylabel() == ""
