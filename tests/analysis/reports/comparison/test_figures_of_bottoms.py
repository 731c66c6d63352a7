"""Figures of the force on the bottom of several runs: runs that are omitted, axes of the user, and
measured points.
"""

from __future__ import annotations

import pytest
from matplotlib import pyplot

from granwave.analysis.figures.style import style
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_case, run_case
from tests.analysis.reports.comparison.runs import SMALL, compared

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


@pytest.fixture
def axes():
    """Three pairs of axes of a figure, which is closed at the end."""
    figure, panels = pyplot.subplots(1, 3, figsize=(9, 3), layout="constrained")
    yield list(panels)
    pyplot.close(figure)


def test_a_run_that_ends_before_the_wave_arrives_is_not_drawn(place, tmp_path):
    """Its force of 1e-10 of the other peaks would make the axis logarithmic."""
    case = load_case("fcc-small", SMALL | {"run.end_time": 1e-5})
    run_case(case, tmp_path / "short", figures=False)
    (tmp_path / "fcc").symlink_to(place / "fcc")
    comparison = compared(tmp_path, "short", "fcc")
    assert [run.name for run in comparison.data("bottom_force").present] == ["fcc"]
    with style():
        (panel,) = comparison.drawing("bottom_force").figure.axes
    assert panel.get_yscale() == "linear"
    assert comparison.caption("bottom_force").endswith(
        "Not drawn: short (the wave does not reach its bottom before its end)."
    )


def test_a_comparison_is_drawn_into_axes(place, axes):
    """As the figures of a run, in one panel or several; the figure keeps its size."""
    comparison = compared(place, "fcc", "hcp")
    before = pyplot.get_fignums()
    assert comparison.figure("bottom_force", ax=axes[0]) is axes[0]
    names = [text.get_text() for text in axes[0].get_legend().get_texts()]
    assert names == ["fcc", "hcp"]
    assert axes[0].get_xlabel() == "Time (µs)" and not axes[1].lines
    axes[0].clear()
    assert comparison.figure("energies", ax=axes) == axes
    assert list(axes[0].get_figure().get_size_inches()) == [9, 3]
    assert pyplot.get_fignums() == before
    with pytest.raises(InputError, match="found 2 axes; the figure needs 1"):
        comparison.figure("bottom_force", ax=axes[:2])


def test_few_measured_points_have_markers(place, tmp_path, axes):
    """A dotted line of five points hardly shows them; 50 points would hide the line."""
    path = tmp_path / "measured.csv"
    for number, marker in ((5, "x"), (50, "")):
        rows = [f"{90 * n / number},{n}" for n in range(number)]
        path.write_text("\n".join(["time_us,force_N", *rows]))
        axes[0].clear()
        comparison = compared(place, "fcc", "hcp", measured=path)
        comparison.figure("bottom_force", ax=axes[0])
        (line,) = [line for line in axes[0].lines if line.get_label() == "measured"]
        assert line.get_marker() == marker
