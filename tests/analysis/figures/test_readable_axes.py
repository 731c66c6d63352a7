"""Axes and legends that show what their curves and colours mean."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from granwave.analysis.figures.chains import force_histories
from granwave.analysis.figures.colouring import Colouring, colour_bar, disc_colours
from granwave.analysis.figures.histories import impactor_velocity
from granwave.analysis.figures.lines import line_diagram
from granwave.analysis.figures.regions import force_at_depths
from granwave.analysis.figures.series import are_relative, drawn_over, panels, scale_by_peaks
from granwave.analysis.figures.style import style
from granwave.analysis.measures.fronts import line_motions
from granwave.analysis.result.reader import Result
from granwave.workflows import load_case, run_case


def chain_of_40(directory, end_time):
    case = {"packing.size": 40, "packing.diameter": 0.01, "run.end_time": end_time}
    run_case(load_case("homogeneous-chain", case), directory, figures=False)
    return Result(directory)


@pytest.fixture(scope="module")
def elastic(tmp_path_factory):
    """A chain that the wave has passed twice before the end of the run."""
    with chain_of_40(tmp_path_factory.mktemp("elastic"), 3e-3) as result:
        yield result


@pytest.mark.parametrize(("smallest", "text"), [(0.0, "Force (N) (white: 0)"), (0.5, "Force (N)")])
def test_colour_bar_explains_white_grains(smallest, text):
    """Only if there are any."""
    values = np.array([smallest, 0.5, 10.0])
    colouring = Colouring(values, "Force (N)", "force_N", "viridis", 1.0, 10.0)
    with style():
        figure, axes = panels(2.0)
        colour_bar(figure, [axes], colouring, values)
    assert figure.axes[-1].get_xlabel() == text


def test_only_grains_without_a_value_are_white():
    """Their outline is visible on white, and in grey prints no colour of the map is white."""
    values = np.array([0.0, 1e-3, 1.0, 1e3])
    colouring = Colouring(values, "", "", "viridis", 0.1, 10.0)
    faces, edges = disc_colours(values, colouring)
    white = to_rgba("white")
    assert [tuple(face) == white for face in faces] == [True, False, False, False]
    assert tuple(edges[0]) != white
    assert faces[1:, :3].mean(axis=1).max() < 0.75


@pytest.mark.parametrize(
    ("peaks", "scale"),
    [([1.0, 20.0], "linear"), ([1.0, 40.0], "log"), ([1.0, 40.0, 1e-9], "log"), ([], "linear")],
)
def test_axis_is_logarithmic_if_low_curves_could_not_be_seen(peaks, scale):
    """Curves that the wave has not reached do not count."""
    with style():
        _, axes = panels(2.0)
        scale_by_peaks(axes, peaks)
    assert axes.get_yscale() == scale
    if scale == "log":
        low, high = axes.get_ylim()
        assert low < 1.0 < 40.0 < high and high / low < 1e3


@pytest.mark.parametrize(
    ("peaks", "expected"),
    [([1.0, 3.0], False), ([1.0, 5.0], True), ([2.0, 3.0, 1e-9], False), ([], False)],
)
def test_curves_of_different_heights_are_relative_to_their_peaks(peaks, expected):
    """Curves that the wave has not reached do not count; two runs have a common axis."""
    assert are_relative(peaks) is expected
    with drawn_over():
        assert not are_relative(peaks)


def test_forces_of_a_decaying_chain_are_relative_to_their_peaks(tmp_path):
    """The legend gives the peaks; contacts that the wave has not reached are not drawn."""
    case = {
        "material": "brass", "contact.law": "elastoplastic", "packing.size": 30,
        "run.end_time": 2.4e-4, "load.velocity": 5.0,
    }  # fmt: skip
    run_case(load_case("homogeneous-chain", case), tmp_path, figures=False)
    with style(), Result(tmp_path) as result:
        histories = force_histories(result).figure.axes[0]
        depths = force_at_depths(result).figure.axes[0]
        peaks = result["chain/contact_force"].max(axis=0)
    for axes in (histories, depths):
        for line in axes.lines:
            is_reached = not line.get_label().endswith(": not reached")
            assert line.get_ydata().max() == pytest.approx(float(is_reached), abs=1e-4)
        assert axes.get_ylabel().endswith("/ its peak")
    assert depths.lines[-1].get_label() == "bottom: not reached"
    texts = [text.get_text() for text in histories.get_legend().get_texts()]
    first, *_, last = (float(text.split(": ")[1].split()[0]) for text in texts)
    assert first == pytest.approx(peaks[0], rel=1e-3)
    assert last > 1e-4 * first
    assert int(texts[-1].split("-")[0]) <= np.flatnonzero(peaks > 1e-4 * peaks.max())[-1] + 1


def test_forces_of_an_elastic_chain_have_a_linear_axis(elastic):
    """Its solitary wave keeps its height."""
    with style():
        drawing = force_histories(elastic)
    assert drawing.figure.axes[0].get_yscale() == "linear"


def test_velocity_of_the_impactor_is_shown_while_it_changes(elastic, tmp_path):
    """The axis ends at three times the last change of 1 % of the range; the file has all values.

    After the return of the wave the velocity changes again: the axis is that of the whole run.
    """
    with style(), chain_of_40(tmp_path, 6e-4) as result:
        drawing = impactor_velocity(result)
        whole = impactor_velocity(elastic)
    end = drawing.figure.axes[0].get_xlim()[1] * 1e-6
    time = drawing.columns["time_s"]
    velocity = drawing.columns["velocity_m_s"]
    change = np.abs(velocity - velocity[-1])
    least = 0.01 * np.ptp(velocity)
    assert change[time > end / 3 * (1 + 1e-9)].max() <= least
    assert end < 0.5 * time[-1] == pytest.approx(3e-4, rel=1e-3)
    assert whole.figure.axes[0].get_xlim()[1] == pytest.approx(3e3, rel=1e-3)


def test_diagram_of_a_line_ends_after_the_wave(elastic):
    """At twice its arrival at the last grain, with few enough marks to see the fitted line."""
    motion = line_motions(elastic, elastic.origin, np.array([0.0, 0.0, 1.0]))[0]
    last = float(np.nanmax(motion.arrival))
    with style():
        drawing = line_diagram(elastic)
    axes = drawing.figure.axes[0]
    assert axes.get_ylim()[1] == pytest.approx(2 * last * 1e6, rel=1e-6)
    fronts = next(line for line in axes.lines if line.get_label() == "front at a grain")
    assert len(fronts.get_xdata()) / (fronts.get_markevery() or 1) <= 50
