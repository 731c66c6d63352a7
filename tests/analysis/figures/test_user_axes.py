"""Figures in axes of the user, other planes, and curves of another run."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib import colormaps, pyplot, rc_context
from matplotlib.text import Text

from granwave.analysis import analyse
from granwave.analysis.errors import MissingDataError
from granwave.analysis.figures import regions
from granwave.analysis.figures.colouring import peak_force_colouring
from granwave.analysis.figures.legends import covers_curve
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.figures.series import drawn_over, end_of_axis
from granwave.analysis.figures.style import DISSIPATION_MAP
from granwave.analysis.figures.titles import in_lines
from granwave.analysis.notebook.run import Run
from granwave.lammps_inputs.errors import InputError
from tests.helpers.made_up import synthetic


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two synthetic runs of FCC."""
    made = []
    for name, velocity in (("slow", 2.0), ("fast", 5.0)):
        case = synthetic.make_case(size=(6, 6, 4), load={"velocity": velocity})
        directory = synthetic.write_run(tmp_path_factory.mktemp(name), case)
        analyse(directory, figures=False)
        made.append(Run(directory))
    return made


@pytest.fixture
def axes():
    """Two pairs of axes of a figure, which is closed at the end."""
    figure, pair = pyplot.subplots(1, 2, layout="constrained")
    yield list(pair)
    pyplot.close(figure)


def test_a_figure_is_drawn_into_axes(runs, axes):
    before = pyplot.get_fignums()
    assert runs[0].figure("peak_force_depth", ax=axes[0]) is axes[0]
    assert axes[0].get_xlabel() == "Depth (mm)" and axes[0].lines
    assert not axes[1].lines
    axes[0].clear()
    assert runs[0].figure("energies", ax=axes) == axes
    assert axes[1].get_xlabel() == "Time (µs)"
    assert pyplot.get_fignums() == before


def test_axes_that_do_not_suit(runs, axes):
    with pytest.raises(InputError, match=r"ax: found 1 axes; the figure needs a list of 2$"):
        runs[0].figure("energies", ax=axes[0])
    with pytest.raises(
        InputError, match="ax: found 2 axes; the figure needs 1, as it has one panel"
    ):
        runs[0].figure("force_distribution", ax=axes)
    with pytest.raises(InputError, match="projection='polar'"):
        runs[0].figure("directions", ax=axes)


def test_a_plane_holds_for_one_figure(runs, axes):
    """The plane is given as text, as a normal, and as a table."""
    for plane in ("y", (0, 1, 0), {"normal": [0.0, 1.0, 0.0]}):
        axes[0].clear()
        runs[0].figure("peak_force_section", ax=axes[0], plane=plane)
        assert len(axes[0].collections[0].get_offsets()) > 8
    with pytest.raises(MissingDataError, match="does not apply"):
        runs[0].figure("peak_force_section", ax=axes[0])
    with pytest.raises(InputError, match=r"figures\.plane"):
        runs[0].figure("peak_force_section", ax=axes[0], plane="q")


def test_second_axes_have_the_text_sizes_of_the_user(runs, axes):
    axes[0].xaxis.label.set_size(17)
    force, impulse = runs[0].figure("bottom_force", ax=axes[0])
    assert force is axes[0] and len(impulse.lines) == 1
    assert impulse.yaxis.label.get_size() == 17


def test_curves_of_another_run(runs, axes):
    slow, fast = runs
    force = slow.figure("bottom_force", ax=axes[0], against=fast)
    assert force is axes[0]
    assert len(force.get_figure().axes) == len(axes)  # without the second axes of the impulse
    own, other = force.lines
    assert other.get_linestyle() == "--"
    expected = fast.walls.query("wall == 'bottom'")["force"].to_numpy()
    assert np.asarray(other.get_ydata()) == pytest.approx(expected)
    assert force.get_ylim()[1] >= max(own.get_ydata().max(), expected.max())
    legend = [text.get_text() for text in force.get_legend().get_texts()]
    assert legend == [slow.directory.name, fast.directory.name]
    with pytest.raises(MissingDataError, match="has no curves"):
        slow.figure("peak_force_principal", ax=axes[1], against=fast)


def test_points_of_another_run_stay_points(runs, axes):
    """Caps of error bars are not counted as curves; each label occurs once."""
    slow, fast = runs
    force = slow.figure("peak_force_depth", ax=axes[0], against=fast)
    added = [line for line in force.lines if fast.directory.name in str(line.get_label())]
    labels = [str(line.get_label()) for line in added]
    assert len(set(labels)) == len(labels)
    points = [line for line in added if "preferred directions" in str(line.get_label())]
    assert [line.get_linestyle() for line in points] == ["None"] * len(points)


def test_the_legend_of_two_runs_leaves_the_axes_their_size(runs):
    """The figure grows by a legend above the axes, which is no wider than the figure; steps stay
    steps.
    """
    slow, fast = runs
    alone = slow.figure("peak_force_depth")
    figure = alone.get_figure()
    figure.draw_without_rendering()
    height = alone.bbox.height
    both = slow.figure("peak_force_depth", against=fast)
    figure = both.get_figure()
    figure.draw_without_rendering()
    box = both.get_legend().get_window_extent()
    assert box.x0 >= 0 and box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height
    assert both.bbox.height == pytest.approx(height, rel=0.05)
    texts = [text.get_text() for text in both.get_legend().get_texts()]
    assert not any("\n" in text for text in texts if fast.directory.name in text)
    zone = slow.figure("plastic_zone_size", against=fast)
    steps = [line for line in zone.lines if str(line.get_label()).startswith(("depth", "radius"))]
    assert len(steps) == 4 and {line.get_drawstyle() for line in steps} == {"steps-post"}


def test_a_plane_for_a_figure_with_its_own(runs):
    with pytest.raises(InputError, match=r"use peak_force_section"):
        runs[0].figure("peak_force_principal", plane=[0, 1, 0])


@pytest.mark.filterwarnings("error:constrained_layout not applied")
def test_titles_and_legends_fit_small_axes(runs):
    """Axes keep their room; titles are no longer than their axes, also of figures that were drawn
    before the layout changed.
    """
    slow, fast = runs
    figure, panels = pyplot.subplots(2, 2, figsize=(6, 5), layout="constrained")
    slow.figure("bottom_force", ax=panels[0, 0], against=fast)
    slow.figure("peak_force_depth", ax=panels[0, 1])
    slow.figure("peak_force_section", ax=panels[1, 0], plane="y")
    slow.figure("impactor_velocity", ax=panels[1, 1])
    figure.draw_without_rendering()
    for axes in panels.flat:
        assert axes.bbox.width > 0.2 * figure.bbox.width
        assert axes.xaxis.label.get_window_extent().width <= axes.bbox.width
        assert axes.yaxis.label.get_window_extent().height <= axes.bbox.height
        legend = axes.get_legend()
        if legend is not None:
            assert legend.get_window_extent().width <= axes.bbox.width
            assert not covers_curve(axes, legend)
    assert "\n" in panels[1, 0].get_xlabel()
    pyplot.close(figure)


def test_the_legend_of_wide_axes_covers_no_curve(runs):
    slow, fast = runs
    figure, axes = pyplot.subplots(figsize=(10, 3), layout="constrained")
    slow.figure("bottom_force", ax=axes, against=fast)
    figure.draw_without_rendering()
    assert not covers_curve(axes, axes.get_legend())
    pyplot.close(figure)


@pytest.mark.parametrize("size", [(3.4, 2.4), pytest.param((7, 3), marks=pytest.mark.validation)])
@pytest.mark.parametrize("layout", ["constrained", None])
@pytest.mark.parametrize(
    ("name", "n_panels"),
    [
        ("peak_force_depth", 1), ("plastic_zone_size", 1), ("force_distribution", 1),
        ("dissipation_cumulated", 1), ("bottom_force", 1), ("energies", 2),
        ("plastic_zone_growth", 2), ("peak_force_principal", 1),
    ],
)  # fmt: skip
def test_a_column_of_a_journal(runs, name, n_panels, layout, size):
    """Axes keep their height, labels and legends are inside the figure, and time axes line up."""
    figure, panels = pyplot.subplots(
        n_panels, 1, figsize=size, layout=layout, dpi=100, squeeze=False
    )
    panels = list(panels.ravel())
    runs[1].figure(name, ax=panels)
    figure.draw_without_rendering()
    assert sum(axes.bbox.height for axes in panels) > 0.38 * figure.bbox.height
    for axes in figure.axes:
        artists = [axes.xaxis.label, axes.yaxis.label, axes.get_legend()]
        for artist in artists:
            if artist is None:
                continue
            box = artist.get_window_extent()
            inside = figure.bbox.padded(0.5)
            assert box.x0 >= inside.x0 and box.x1 <= inside.x1
            assert box.y0 >= inside.y0 and box.y1 <= inside.y1
        legend = axes.get_legend()
        assert legend is None or not covers_curve(axes, legend)
    for axes in panels[:-1]:
        assert axes.get_xlim() == panels[-1].get_xlim()
        assert axes.bbox.x0 == pytest.approx(panels[-1].bbox.x0, abs=0.5)
    assert layout is not None or figure.get_layout_engine() is None
    pyplot.close(figure)


def test_places_that_the_user_set_stay(runs):
    """Axes that were placed or adjusted by hand are not laid out."""
    figure, axes = pyplot.subplots()
    figure.subplots_adjust(left=0.3)
    before = axes.get_position().bounds
    runs[0].figure("bottom_force", ax=axes)
    assert axes.get_position().bounds == before
    placed = figure.add_axes((0.4, 0.4, 0.3, 0.3))
    runs[0].figure("impactor_velocity", ax=placed)
    assert placed.get_position().bounds == pytest.approx((0.4, 0.4, 0.3, 0.3))
    pyplot.close(figure)


def test_a_legend_above_is_above_the_title(runs):
    figure, panels = pyplot.subplots(2, 1, figsize=(3.4, 2.4), layout="constrained")
    runs[1].figure("plastic_zone_growth", ax=list(panels))
    figure.draw_without_rendering()
    for axes in panels:
        legend = axes.get_legend().get_window_extent()
        title = axes.title.get_window_extent()
        assert not axes.get_title() or not legend.overlaps(title)
    pyplot.close(figure)


def test_no_line_ends_with_a_sign_of_division():
    assert in_lines("Energy / input of all", 3) == "Energy\n/ input\nof all"


def test_formulas_are_not_broken():
    text = in_lines("Peak force $F / F_y$ of the layer", 3)
    assert text == "Peak force\n$F / F_y$ of\nthe layer"
    assert in_lines("$a b$", 2) == "$a b$"


@pytest.mark.parametrize("name", ["peak_force_depth", "peak_force_principal", "energies"])
def test_texts_have_one_font_and_a_readable_size(runs, name):
    """In a panel of a double column next to another, with a serif font of 8 points."""
    with rc_context({"font.family": "serif", "font.size": 8}):
        figure = pyplot.figure(figsize=(7.0, 2.6), layout="constrained")
        grid = figure.subplots(1, 3)
        panels = list(grid[:2]) if name == "energies" else grid[0]
        runs[0].figure(name, ax=panels)
        figure.draw_without_rendering()
    texts = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text()]
    assert {text.get_fontname() for text in texts} == {"DejaVu Serif"}
    assert min(text.get_fontsize() for text in texts) >= 6
    pyplot.close(figure)


_NAMES = ("bottom_force", "peak_force_depth", "plastic_zone_size", "impactor_velocity")


@pytest.mark.parametrize(
    ("shape", "size", "layout"),
    [((1, 2), (7, 2.6), None), ((1, 2), (9, 3.6), None), ((2, 2), (7, 5), "constrained")],
)
def test_texts_of_neighbouring_panels_do_not_overlap(runs, shape, size, layout):
    """Labels, second axes and legends have room of their own, and no unit is broken, in a figure
    that granwave draws panel by panel.
    """
    figure, panels = pyplot.subplots(*shape, figsize=size, layout=layout)
    for axes, name in zip(panels.flat, _NAMES, strict=False):
        runs[0].figure(name, ax=axes)
    figure.draw_without_rendering()
    boxes = []
    for axes in figure.axes:
        for title in (axes.xaxis.label, axes.yaxis.label):
            assert "(mN\n" not in title.get_text()
            boxes.append(title.get_window_extent())
        legend = axes.get_legend()
        if legend is not None:
            boxes.append(legend.get_window_extent())
    pyplot.close(figure)
    drawn = [box for box in boxes if box.width > 0]
    for number, box in enumerate(drawn):
        assert box.x0 > -1 and box.x1 < figure.bbox.width + 1
        assert box.y0 > -1 and box.y1 < figure.bbox.height + 1
        assert box.padded(-1).count_overlaps(drawn[number + 1 :]) == 0


def test_units_stay_on_one_line():
    label = "Impulse (mN s), dashed"
    assert in_lines(label, 2) == "Impulse\n(mN s), dashed"
    assert in_lines("Impulse (mN s)", 4) == "Impulse\n(mN s)"


@pytest.mark.parametrize("name", ["energies", "plastic_zone_growth", "impactor_velocity"])
def test_figures_need_the_number_of_axes_in_the_documents(runs, name):
    number = run_figures()[name].n_axes
    figure, panels = pyplot.subplots(1, int(number), squeeze=False)
    runs[0].figure(name, ax=list(panels.flat))
    pyplot.close(figure)


def test_panels_side_by_side_have_the_common_label_each(runs, axes):
    """Panels that would be below each other share their last label; yours may be in a row."""
    runs[0].figure("plastic_zone_growth", ax=axes)
    assert [panel.get_xlabel() for panel in axes] == ["Time (µs)", "Time (µs)"]
    figure, stack = pyplot.subplots(2, 1)
    runs[0].figure("plastic_zone_growth", ax=list(stack))
    assert [panel.get_xlabel() for panel in stack] == ["", "Time (µs)"]
    pyplot.close(figure)


def test_sizes_of_depth_and_radius_have_the_mark_of_the_legend(runs):
    axes = runs[0].figure("plastic_zone_size")
    legend = axes.get_legend()
    marks = {
        text.get_text(): handle.get_marker()
        for text, handle in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }
    drawn = {line.get_marker() for line in axes.lines} - {"None"}
    assert drawn == {marks["contains 50, 90, 99 %"]}


def test_captions_say_where_an_axis_of_times_ends(runs, tmp_path):
    figure = run_figures()["impactor_velocity"]
    _, look = figure.words(runs[0].result, tmp_path)
    axes = runs[0].figure("impactor_velocity")
    last = 1e6 * runs[0].result["energy/time"][-1]
    assert ("The axis ends at" in look) == (axes.get_xlim()[1] < last)
    assert end_of_axis(80e-6, 300e-6) == "The axis ends at 80 µs of 300 µs."
    assert end_of_axis(300e-6, 300e-6) == ""


def test_the_largest_dissipation_differs_from_white():
    """Zero is white: in grey prints the end of the scale is darker, and lightness rises."""
    grey = colormaps[DISSIPATION_MAP](np.linspace(0, 1, 50))[:, :3] @ [0.299, 0.587, 0.114]
    assert np.all(np.diff(grey) > 0) and grey[-1] < 0.75


def test_peak_forces_have_one_scale(runs):
    """Sections and the cut packing have the scale of all spheres: none is outside."""
    colouring = peak_force_colouring(runs[0].result)
    values = colouring.values[colouring.values > 0]
    assert (
        colouring.low <= max(values.min(), colouring.high / 1e4) and values.max() <= colouring.high
    )


def test_curves_that_oscillate_are_shifted():
    time = np.linspace(0, 1, 400)
    waves = [np.sin(25 * (time - delay)) ** 2 for delay in (0.0, 0.1, 0.2, 0.3)]
    assert regions._shift(waves, 300.0) == pytest.approx(200.0)
    pulses = [np.exp(-((time - delay) ** 2) * 400) for delay in (0.2, 0.4, 0.6, 0.8)]
    assert regions._shift(pulses, 300.0) == 0
    with drawn_over():
        assert regions._shift(waves, 300.0) == 0
    assert regions._depth_name(-0.005) == "5 mm above" and regions._depth_name(0.045) == "45 mm"
