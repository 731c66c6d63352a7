"""Appearance of the figures of a scan: labels without overlap inside the figure, curves of one
kind, data with zeros only.
"""

from __future__ import annotations

import csv
import itertools
import json

import numpy as np
import pytest
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from pandas import DataFrame, concat

from granwave.analysis.figures.scales import plain_powers
from granwave.analysis.figures.style import BLUE, style
from granwave.analysis.measures.zone_size import Mark
from granwave.analysis.scans.drawing import (
    _HATCHES,
    _scale_abscissae,
    draw_bars,
    draw_curves,
    draw_map,
)
from granwave.analysis.scans.figures import draw_scan_figures, drawings
from granwave.analysis.scans.keys import key_of
from granwave.analysis.scans.means import means_of
from granwave.analysis.scans.result import ScanResult
from tests.helpers.made_up.synthetic_scan import grid, write_json, write_scan

BOTTOMS = [
    "wall",
    '{"plate": {"mass": 0.05, "stiffness": 5000000000.0}}',
    '{"half_space": {}, "material": {"name": "concrete", "youngs_modulus": 31000000000.0, "density": 2447}}',
    '{"bar": {"length": 0.5, "area": 0.0125}, "material": "steel"}',
]


@pytest.fixture(autouse=True)
def as_drawn():
    """Font size of the figures."""
    with style():
        yield


def points(x, values=None, n_curves=1):
    """Table of the points of curves, each a row of the scan."""
    mean = np.linspace(1, 2, len(x)) if values is None else values
    table = DataFrame(
        {
            "x": np.array(x, float),
            "mean": mean,
            "deviation": np.nan,
            "half_width": np.nan,
            "count": 1,
        }
    )
    return concat(
        [table.assign(mark=0, curve=n, row=n) for n in range(n_curves)], ignore_index=True
    )


def shown_labels(figure: Figure) -> list[list[tuple[str, Bbox]]]:
    """Visible tick labels and their positions, by axis."""
    figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    found = []
    for axes in figure.axes:
        for n, axis in enumerate((axes.xaxis, axes.yaxis)):
            low, high = sorted(axis.get_view_interval())
            labels = [
                label
                for label in axis.get_ticklabels()
                if label.get_text() and low <= label.get_position()[n] <= high
            ]
            found.append(
                [(label.get_text(), label.get_window_extent(renderer)) for label in labels]
            )
    return found


def touching(figure: Figure) -> list[tuple[str, str]]:
    """Labels of an axis that overlap."""
    pairs = itertools.chain.from_iterable(map(itertools.pairwise, shown_labels(figure)))
    return [(a, b) for (a, first), (b, second) in pairs if first.overlaps(second)]


def outside(figure: Figure) -> list[str]:
    """Texts that are cut off by the edge of the figure."""
    boxes = list(itertools.chain.from_iterable(shown_labels(figure)))
    renderer = figure.canvas.get_renderer()
    whole = figure.bbox
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    boxes += [
        (text.get_text(), text.get_window_extent(renderer))
        for legend in legends
        for text in legend.get_texts()
    ]
    return [
        text
        for text, box in boxes
        if box.x0 < whole.x0 - 1 or box.x1 > whole.x1 + 1 or box.y1 > whole.y1 + 1
    ]


@pytest.mark.parametrize(
    "x",
    [
        [1.3e-5, 9e-5, 6.2e-4, 0.0042, 0.011],
        [2000, 5000, 10000, 20000, 100000, 200000, 500000],
        [2e-7, 1e-6, 1e-5, 2e-5, 1e-4],
        [1, 2, 5, 10, 20, 40],
        [10000, 20000, 40000, 80000, 160000, 320000, 640000, 1280000],
        [0, 1, 2, 5],
        [30, 31, 32, 33, 50],
        [0.03, 0.3, 3, 30, 100],
    ],
)
def test_labels_of_an_axis_do_not_run_together(x):
    for n_curves, others in ((1, []), (12, [key_of("load.velocity", list(range(1, 13)))])):
        drawing = draw_curves(points(x, n_curves=n_curves), "x", "y", others, ("x", "y"))
        plain_powers(drawing.figure)  # as where it is saved
        assert touching(drawing.figure) == []
        labels = [label.get_text() for label in drawing.figure.axes[0].get_xticklabels()]
        assert sum(map(bool, labels)) >= 2


@pytest.mark.parametrize("values", [[1.0, 2.0, 3.0, 4.0], [1.0, 1e3, 1e5, 1e6]])
def test_bars_of_long_names_lie_and_cut_nothing_off(values):
    key = key_of("boundary.bottom", BOTTOMS)
    ticks = [key.tick(row) for row in range(4)]
    assert ticks[1] == "plate mass=0.05 stiffness=5e9"
    drawing = draw_bars(points(range(4), values, 2), ticks, "Bottom", "y", [key], ("bottom", "y"))
    axes = drawing.figure.axes[0]
    assert axes.get_ylabel() == "Bottom" and axes.get_xlabel() == "y"
    assert touching(drawing.figure) == [] and outside(drawing.figure) == []
    assert drawing.columns["bottom"].tolist() == ticks * 2


def test_bars_of_two_curves_are_distinguished_without_colours():
    """Neighbouring curves have different hatches; many curves differ in colour or hatch."""
    key = key_of("boundary.bottom", BOTTOMS)
    ticks = [key.tick(row) for row in range(4)]
    values = [1.0, 2.0, 3.0, 4.0]
    drawing = draw_bars(points(range(4), values, 2), ticks, "Bottom", "y", [key], ("bottom", "y"))
    hatches = [container[0].get_hatch() for container in drawing.figure.axes[0].containers]
    assert len(set(hatches)) == 2


def test_marked_bars_keep_their_colour_and_zero_is_named():
    """An open bar looked like the legend's box, and a bar of length zero like a missing one."""
    ticks = ["fcc", "hcp", "bcc", "sc"]
    table = points(range(4), [1.0, 2.0, 3.0, 0.0]).assign(mark=int(Mark.CUT))
    drawing = draw_bars(table, ticks, "Packing", "y", [], ("packing", "y"))
    (axes,) = drawing.figure.axes
    (bars,) = axes.containers
    assert {bar.get_facecolor() for bar in bars} == {to_rgba(BLUE)}
    (marks,) = [line for line in axes.lines if line.get_marker() == "o"]
    assert marks.get_xdata().tolist() == [1.0, 2.0, 3.0, 0.0]
    assert [text.get_text() for text in axes.texts] == ["0"]
    (legend,) = drawing.figure.legends
    (handle,) = legend.legend_handles
    assert handle.get_marker() == "o"


def test_bars_of_many_short_names():
    ticks = [str(n) for n in range(1, 31)]
    drawing = draw_bars(points(range(30)), ticks, "n", "y", [], ("n", "y"))
    shown = [label.get_text() for label in drawing.figure.axes[0].get_yticklabels()]
    assert shown == ticks and touching(drawing.figure) == [] and outside(drawing.figure) == []


def test_legends_cut_nothing_off():
    key = key_of("boundary.bottom", BOTTOMS)
    friction = key_of("contact.friction", [0.1, 0.2, 0.3, 0.4])
    size = key_of("packing.size", ["[4, 4, 5]", "[4, 4, 6]", "[4, 4, 7]", "[4, 4, 8]"])
    assert (
        outside(
            draw_curves(
                points([1, 2], n_curves=4), "x", "y", [key, friction, size], ("x", "y")
            ).figure
        )
        == []
    )


def test_columns_of_a_map_do_not_run_together():
    x = key_of("load.velocity", [0.000123 * n for n in range(1, 9)])
    y = key_of("contact.friction", [0.1, 0.2])
    drawing = draw_map(np.ones((2, 8)), (list(x.values), list(y.values)), (x, y), "title", "column")
    assert touching(drawing.figure) == []


def test_what_is_zero_everywhere_has_no_figure(tmp_path):
    """Without yielding there are no curves, bars or maps of dissipation; one yielding point is
    sufficient for them.
    """
    points = grid(load__velocity=[1, 2], packing__diameter=[0.005, 0.01], contact__law=["hertz"])
    elastic = write_scan(tmp_path / "elastic", points)
    assert {path.stem.partition("_vs_")[0] for path in draw_scan_figures(elastic, pdf=False)} == {
        "peak_force",
        "wave_speed",
    }
    bars = write_scan(tmp_path / "bars", grid(packing__kind=["fcc", "hcp"], contact__law=["hertz"]))
    assert "dissipated_fraction_vs_packing_kind" not in {
        path.stem for path in draw_scan_figures(bars, pdf=False)
    }
    both = write_scan(
        tmp_path / "both", grid(load__velocity=[1, 2], contact__law=["hertz", "elastoplastic"])
    )
    assert "dissipated_fraction_vs_load_velocity" in {
        path.stem for path in draw_scan_figures(both, pdf=False)
    }


def change_summaries(directory, values_of):
    """Change values of the summaries of a scan; the function returns them by labels of a point."""
    for point in ScanResult(directory).points:
        path = point.directory / "summary.json"
        write_json(path, json.loads(path.read_text()) | values_of(point.labels))


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_key_that_sorts_the_points_tells_the_curves_apart(tmp_path):
    """Curves are drawn although each velocity occurs with only one number of impacted spheres."""
    points = [
        {"load.velocity": v, "load.spheres": n}
        for n, speeds in ((1, (1, 4, 9)), (3, (2, 5, 8)))
        for v in speeds
    ]
    scan = write_scan(tmp_path, points)
    draw_scan_figures(scan, pdf=False)
    rows = rows_of(tmp_path / "figures" / "peak_force_vs_load_velocity.csv")
    assert [row["load.spheres"] for row in rows] == ["1"] * 3 + ["3"] * 3
    axes = drawings(ScanResult(scan))["peak_force_vs_load_velocity"].figure.axes[0]
    assert [len(line.get_xdata()) for line in axes.lines if line.get_linestyle() != "None"] == [
        3,
        3,
    ]


@pytest.mark.parametrize(
    ("diameters", "joined"), [([0.004, 0.006, 0.008], True), ([0.008, 0.004, 0.006], False)]
)
def test_points_are_joined_where_all_that_varies_goes_one_way(tmp_path, diameters, joined):
    points = [
        {"load.velocity": v, "packing.diameter": d}
        for v, d in zip((1, 2, 3), diameters, strict=True)
    ]
    figure = drawings(ScanResult(write_scan(tmp_path, points)))[
        "peak_force_vs_load_velocity"
    ].figure
    assert (figure.axes[0].lines[0].get_linestyle() != "None") == joined


def test_run_times_that_follow_other_keys_are_no_abscissa(tmp_path):
    points = grid(load__velocity=[1, 2], packing__kind=["fcc", "hcp"])
    for n, point in enumerate(points):
        point["run.end_time"] = 1e-3 * (n + 1)
    names = {
        path.stem.partition("_vs_")[2]
        for path in draw_scan_figures(write_scan(tmp_path, points), pdf=False)
    }
    assert names == {"load_velocity"}
    study = write_scan(tmp_path / "study", grid(run__end_time=[1e-3, 2e-3]))
    change_summaries(study, lambda labels: {"peak_force_N": 1e4 * labels["run.end_time"]})
    assert "peak_force_vs_run_end_time" in {
        path.stem for path in draw_scan_figures(study, pdf=False)
    }


def restitution_scan(directory):
    """Two spheres, and a sphere on a wall, at three velocities."""
    points = []
    for size, bottom in ((2, "free"), (1, "wall")):
        points += grid(
            load__velocity=[0.1, 1, 10],
            packing__size=[size],
            boundary__bottom=[bottom],
            packing__kind=["chain"],
        )
    scan = write_scan(directory, points)

    def values_of(labels):
        force = 10.0 * labels["load.velocity"]
        between = {2: force, 1: 0.0}[labels["packing.size"]]
        spheres = {"n_plastic_spheres": 2 * (between > 1), "plastic_zone_depth_m": None}
        return {"peak_force_N": between, "peak_force_with_walls_N": force} | spheres

    change_summaries(scan, values_of)
    return scan


def test_keys_of_two_values_and_constant_quantities_have_no_axis(tmp_path):
    """Only quantities that change with the velocity are drawn; curves that step from zero to one
    value are not.
    """
    names = {path.stem for path in draw_scan_figures(restitution_scan(tmp_path), pdf=False)}
    assert {"peak_force_vs_load_velocity", "dissipated_fraction_vs_load_velocity"} <= names
    assert not any("packing_size" in name or "map" in name for name in names)
    assert "plastic_spheres_vs_load_velocity" not in names


@pytest.mark.parametrize(
    ("velocities", "forces", "scales"),
    [
        ([1, 2, 5, 10, 20], [10, 22, 60, 130, 280], ("log", "log")),
        ([1, 2, 5, 10, 20], [10, 15, 30, 50, 80], ("log", "linear")),
        ([1, 2, 3, 4, 5], [10, 40, 90, 160, 250], ("linear", "linear")),
    ],
)
def test_values_over_a_decade_are_logarithmic_with_their_abscissae(velocities, forces, scales):
    table = points(velocities, np.array(forces, float))
    drawing = draw_curves(table, "Velocity (m/s)", "Force (N)", [], ("velocity", "force"))
    axes = drawing.figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == scales


def test_the_peak_force_on_the_bottom_is_drawn_in_newtons(tmp_path):
    scan = write_scan(tmp_path, grid(load__velocity=[1, 2, 4]))
    change_summaries(
        tmp_path, lambda labels: {"wall_peak_force_N": 100.0 * float(labels["load.velocity"])}
    )
    drawing = drawings(ScanResult(scan))["bottom_peak_force_vs_load_velocity"]
    assert drawing.columns["wall_peak_force_N"] == pytest.approx([100, 200, 400])
    assert drawing.figure.axes[0].get_ylabel() == "Peak force on the bottom (N)"


def test_a_sphere_on_a_wall_has_its_peak_force(tmp_path):
    """The contact of a sphere with a wall is no contact between spheres; curves are named by sizes
    and bottoms.
    """
    drawing = drawings(ScanResult(restitution_scan(tmp_path)))["peak_force_vs_load_velocity"]
    force = np.array(drawing.columns["peak_force_over_yield_force"])
    assert force[:3] == pytest.approx(force[3:])
    assert "including walls" in drawing.figure.axes[0].get_ylabel()
    labels = [text.get_text() for text in drawing.figure.legends[0].get_texts()]
    assert labels == ["$N$ = 1, wall", "$N$ = 2, free"]
    means = means_of(ScanResult(tmp_path))
    assert means.figures["peak_force"] == "peak_force_with_walls_N"


def test_a_quantity_that_its_scale_makes_constant_is_drawn_in_its_unit(tmp_path):
    """Forces proportional to the yield force show its growth with the diameter."""
    scan = write_scan(tmp_path, grid(packing__diameter=[0.005, 0.01, 0.02]))
    columns = drawings(ScanResult(scan))["peak_force_vs_packing_diameter"].columns
    force = np.array(columns["peak_force_N"])
    assert force[1:] / force[:-1] == pytest.approx(4.0)


@pytest.mark.parametrize(
    ("materials", "column"),
    [(["brass", "aluminium"], "peak_force_N"), (["brass"], "peak_force_over_yield_force")],
)
def test_forces_are_in_newtons_where_the_yield_force_varies(tmp_path, materials, column):
    """Bars divided by different yield forces would be in another order than the forces."""
    scan = write_scan(tmp_path, grid(packing__kind=["fcc", "hcp", "sc"], material=materials))
    columns = drawings(ScanResult(scan))["peak_force_vs_packing_kind"].columns
    assert column in columns


def test_lengths_are_in_millimetres_where_the_diameter_varies(tmp_path):
    scan = write_scan(tmp_path, grid(packing__diameter=[0.005, 0.01, 0.02], load__velocity=[2, 5]))
    columns = drawings(ScanResult(scan))["plastic_zone_depth_vs_packing_diameter"].columns
    assert "plastic_zone_depth_mm" in columns


def test_a_constant_quantity_has_no_figure_on_normalised_axes(tmp_path):
    """All collisions of two spheres have two yielded spheres."""
    scan = write_scan(tmp_path, grid(load__velocity=[1, 2, 5], material=["brass", "aluminium"]))
    change_summaries(tmp_path, lambda labels: {"n_plastic_spheres": 2})
    drawn = drawings(ScanResult(scan))
    assert "collapse_dissipated_fraction" in drawn and "collapse_plastic_volume" not in drawn


def test_two_points_are_no_curve_on_normalised_axes(tmp_path):
    points = [
        {"load.velocity": 5.0, "material": "brass"},
        {"load.velocity": 10.0, "material": "steel"},
    ]
    assert not any(
        "collapse" in name for name in drawings(ScanResult(write_scan(tmp_path, points)))
    )


def test_points_of_categories_are_not_joined(tmp_path):
    points = [
        {"packing.kind": kind, "packing.size": f"[12, 12, {n}]"}
        for kind, n in (("fcc", 10), ("hcp", 12), ("bcc", 14))
    ]
    figure = drawings(ScanResult(write_scan(tmp_path, points)))["peak_force_vs_packing_size"].figure
    assert figure.axes[0].lines[0].get_linestyle() == "None"


@pytest.mark.parametrize(
    ("places", "ticks"),
    [([0, 10, 50], [0, 10, 50]), ([0.0, 0.1, 0.25], [0.0, 0.1, 0.25])],
)
def test_few_values_of_a_key_have_the_ticks(places, ticks):
    axes = Figure().subplots()
    axes.set_xlim(places[0], places[-1])
    _scale_abscissae(axes, np.array(places), chosen=True)
    assert axes.get_xticks().tolist() == ticks


def test_crowded_values_of_a_key_have_round_ticks():
    places = np.array([0, 1, 2, 3, 100])
    axes = Figure().subplots()
    axes.set_xlim(0, 100)
    _scale_abscissae(axes, places, chosen=True)
    assert 1 not in axes.get_xticks()


def test_bars_of_four_curves_differ_in_grey_prints():
    assert len(set(_HATCHES)) >= 6


def test_a_key_without_effect_has_one_bar(tmp_path):
    """The force on the bottom depends on the material, the peak force does not."""
    write_scan(tmp_path, grid(packing__kind=["fcc", "hcp"], material=["brass", "steel"]))
    for number, point in enumerate(ScanResult(tmp_path).points):
        path = point.directory / "summary.json"
        forces = {"peak_force_N": 50.0 + number // 2, "wall_peak_force_N": 10.0 + number}
        write_json(path, json.loads(path.read_text()) | forces)
    drawn = drawings(ScanResult(tmp_path))
    note = "the same at both values of material"
    without = drawn["peak_force_vs_packing_kind"]
    assert len(without.figure.axes[0].patches) == 2
    assert [text.get_text() for text in without.figure.legends[0].get_texts()] == [note]
    assert list(without.columns) == ["packing.kind", "peak_force_N"]
    figure = drawn["bottom_peak_force_vs_packing_kind"].figure
    assert len(figure.axes[0].patches) == 4
    assert note not in [text.get_text() for text in figure.legends[0].get_texts()]
