"""Plastic zones that reach a boundary: warnings before a run, at its end, in scans, figures and
reports.
"""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from matplotlib.colors import to_hex

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.figures.plastic_zone import draw_zone_size
from granwave.analysis.figures.style import style
from granwave.analysis.measures.zone_size import (
    LABELS,
    Mark,
    bounds_in_words,
    mark_of,
    zone_marks,
    zone_warning,
)
from granwave.analysis.scans.figures import drawings
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.scans.table import read_scan, write_scan_table
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.cost import expected_zone
from granwave.workflows.cli.main import main
from granwave.workflows.cli.tables.zone import expected_cut
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.synthetic_report import blocks, build, notes, table, write_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan

CUT = {
    "zone_cut": ["bottom", "sides"],
    "wave_returned": ["bottom"],
    "wave_return_s": 2e-4,
    "wave_return_share": 0.002,
}
WAVE = {
    "zone_cut": [],
    "wave_returned": ["sides"],
    "wave_return_s": 2e-5,
    "wave_return_share": 0.018,
}
FREE = {"zone_cut": [], "wave_returned": ["sides"], "wave_return_s": 5e-4, "wave_return_share": 0.0}
SIZES = {
    **{f"zone_depth_{n}_m": 0.01 * (n / 50) for n in (50, 90, 99)},
    **{f"zone_radius_{n}_m": 0.008 * (n / 50) for n in (50, 90, 99)},
    **{f"zone_volume_{n}_m3": 1e-6 * (n / 50) for n in (50, 90, 99)},
}


def sizes_of(n):
    """Return the sizes of the zone of the n-th point, which is one per cent larger than the
    previous point.
    """
    return {name: value * (1 + 0.01 * n) for name, value in SIZES.items()}


def make(size, kind="fcc", velocity=5.0, **tables):
    packing = {"kind": kind, "size": size, "diameter": 0.01}
    return case_from_dict(
        {"name": "zone", "material": "brass", "packing": packing, "load": {"velocity": velocity}}
        | tables
    )


# ---------------------------------------------------------------------- marks and words


def test_marks():
    found = [
        mark_of(summary)
        for summary in (CUT, WAVE, FREE, {}, {"zone_cut": None, "wave_return_share": None})
    ]
    assert found == [Mark.CUT, Mark.WAVE, Mark.NONE, Mark.NONE, Mark.NONE]
    assert [bounds_in_words(bounds) for bounds in (["bottom", "sides"], [], None)] == [
        "bottom, sides",
        "none",
        "",
    ]


def test_warnings_tell_what_and_what_to_do():
    cut = zone_warning({"name": "x"} | CUT)
    assert (
        "reaches the bottom and the sides of the packing" in cut and "Use a larger packing" in cut
    )
    wave = zone_warning(WAVE, "block")
    assert "1.8 %" in wave and "the sides" in wave and "20 µs" in wave and "block" in wave
    assert zone_warning(FREE) == ""
    assert (
        zone_warning({"n_spheres": 2} | CUT) == ""
    )  # a collision of two, which no size would change
    assert mark_of({"n_spheres": 2} | CUT) is Mark.NONE
    chain = (
        {"n_spheres": 50}
        | CUT
        | SIZES
        | dict.fromkeys([name for name in SIZES if "radius" in name])
    )
    assert zone_warning(chain) == ""  # a pulse goes from end to end
    assert mark_of(chain) is Mark.CUT
    assert zone_warning({"n_spheres": 50} | CUT | SIZES) == cut
    both = zone_warning(WAVE | {"zone_cut": CUT["zone_cut"]})
    assert "reaches the bottom" in both and "1.8 %" in both and "\n" not in both


def test_periodic_sides_are_called_images():
    periodic = {"sides_periodic": True}
    cut = zone_warning(CUT | periodic)
    assert "reaches the bottom and the periodic images of the packing" in cut
    assert "a wave from the periodic images arrived" in zone_warning(WAVE | periodic)
    text = summary_table({"name": "x", "plastic_zone_radius_m": 0.1} | SIZES | CUT | periodic)
    assert text.splitlines()[-1].endswith("bottom, periodic images")
    sides = {"boundary": {"sides": "periodic"}}
    expected = expected_cut(expected_zone(assemble(make([8, 8, 12], velocity=20, **sides))))
    assert "the periodic images" in expected and "the sides" not in expected


def test_terminal_tells_the_sizes_and_the_bounds():
    text = summary_table({"name": "x", "plastic_zone_radius_m": 0.1} | SIZES | CUT)
    assert "depth 0.01, 0.018, 0.0198 m" in text
    assert "volume 1e-06, 1.8e-06, 1.98e-06 m3" in text
    assert text.splitlines()[-1].split() == ["reaches", "boundaries", "bottom,", "sides"]
    assert "none" in summary_table({"name": "x", "plastic_zone_radius_m": 0.1} | SIZES | FREE)
    growing = summary_table({"name": "x", "plastic_zone_depth_m": 0.1, "zone_growing": ["depth"]})
    assert growing.endswith("0.1 m, still growing at the end")
    hertz = dict.fromkeys([*SIZES, *CUT, "plastic_zone_radius_m"])
    assert summary_table({"name": "x"} | hertz) == "case  x"


# ---------------------------------------------------------------------- before a run


@pytest.mark.parametrize(
    ("size", "velocity", "reaches"),
    [([24, 24, 12], 0.3, ()), ([72, 72, 36], 5.0, ()), ([40, 40, 6], 3.0, ("bottom",)), ([8, 8, 30], 3.0, ("sides",)),
     ([4, 4, 3], 5.0, ("bottom", "sides"))],
)  # fmt: skip
def test_estimate_against_the_room(size, velocity, reaches):
    zone = expected_zone(assemble(make(size, velocity=velocity)))
    assert zone is not None
    assert zone.reaches == reaches
    assert set(zone.may_reach).isdisjoint(reaches)


def test_estimate_is_one_of_the_normalised_energy():
    """Spheres with half the diameter, twice the stiffness and a quarter of the density have the
    same zone in diameters.
    """
    one = expected_zone(assemble(make([24, 24, 12])))
    law = {
        "youngs_modulus": 230e9,
        "poisson_ratio": 0.3,
        "density": 8500 / 4,
        "yield_strength": 1100e6,
    }
    case = case_from_dict(
        {"name": "x", "material": law, "packing": {"kind": "fcc", "size": [24, 24, 12], "diameter": 0.005},
         "load": {"velocity": 5.0 * np.sqrt(2 * 4)}}
    )  # fmt: skip
    other = expected_zone(assemble(case))
    assert one is not None and other is not None
    assert other.depth == pytest.approx(one.depth / 2, rel=1e-9)
    assert other.room["bottom"] == pytest.approx(one.room["bottom"] / 2, rel=1e-9)


#: Outermost yield of brass spheres in sufficiently large packings and sufficiently long runs: kind, velocity (m/s),
#: struck spheres, depth and radius in diameters.
MEASURED = [
    ("fcc", 0.2, 1, 2.45, 1.73), ("fcc", 0.3, 1, 3.27, 2.31), ("fcc", 0.6, 1, 4.08, 2.89), ("fcc", 1, 1, 5.72, 4.04),
    ("fcc", 2, 1, 8.98, 6.03), ("fcc", 3, 1, 10.61, 7.55), ("fcc", 6, 1, 14.70, 15.72), ("fcc", 10, 1, 17.96, 19.00),
    ("fcc", 20, 1, 21.23, 23.58), ("fcc", 2, 7, 16.33, 10.69), ("hcp", 0.6, 1, 4.08, 2.52), ("hcp", 3, 1, 10.61, 7.94),
    ("bcc", 0.2, 1, 2.89, 4.08), ("bcc", 0.6, 1, 6.35, 8.98), ("bcc", 1.2, 1, 9.24, 10.61), ("bcc", 2, 1, 13.28, 14.26),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "velocity", "spheres", "depth", "radius"), MEASURED)
def test_estimate_is_as_certain_as_it_says(kind, velocity, spheres, depth, radius):
    zone = expected_zone(
        assemble(make([24, 24, 12], kind, load={"velocity": velocity, "spheres": spheres}))
    )
    assert zone is not None
    for expected, found in ((zone.depth / 0.01, depth), (zone.radius / 0.01, radius)):
        assert 1 / zone.spread < found / expected < zone.spread


def test_no_estimate_where_there_is_no_zone_to_speak_of():
    assert expected_zone(assemble(make([24, 24, 12], contact={"law": "hertz"}))) is None
    assert expected_zone(assemble(make([20, 20], "square"))) is None
    assert expected_zone(assemble(make([24, 24, 12], velocity=0.05))) is None
    assert expected_cut(None) == ""


def test_estimate_holds_for_a_run(tmp_path):
    case = make([20, 20, 10], velocity=0.6, run={"end_time": 2.5e-4})
    zone = expected_zone(assemble(case))
    assert zone is not None and zone.reaches == ()
    summary = run_case(case, tmp_path, figures=False).summary
    assert summary["zone_cut"] == []
    for name, size in (("depth", zone.depth), ("radius", zone.radius)):
        assert 1 / zone.spread < summary[f"plastic_zone_{name}_m"] / size < zone.spread
    assert (
        0
        < summary["zone_depth_50_m"]
        <= summary["zone_depth_90_m"]
        <= summary["zone_depth_99_m"]
        < zone.depth
    )


def test_check_warns_of_a_packing_that_is_too_small(capfd):
    assert main(["check", "fcc-small", "--set", "packing.size=[8,8,4]"]) == 0
    told = capfd.readouterr()
    assert "plastic zone" in told.out
    assert (
        "packing.size: the plastic zone is expected to reach the bottom" in told.err
        and "the sides" in told.err
    )
    assert main(["check", "fcc-small", "--set", "load.velocity=0.3"]) == 0
    assert "plastic zone" not in capfd.readouterr().err


def test_plan_of_a_scan_counts_the_points_that_are_cut(capfd, tmp_path):
    assert main(["scan", "velocity-hcp", "--plan", "-o", str(tmp_path / "x")]) == 0
    assert (
        "plastic zone   expected to reach a boundary of the packing in 4 of 7 points"
        in capfd.readouterr().out
    )


def test_run_says_that_its_zone_is_cut(capfd, tmp_path):
    words = [
        "run",
        "fcc-small",
        "-o",
        str(tmp_path),
        "--no-figures",
        "--set",
        "packing.size=[4,4,3]",
    ]
    assert main([*words, "--set", "run.end_time=1e-4"]) == 0
    told = capfd.readouterr()
    assert re.search(r"reaches boundaries +bottom, sides\n", told.out)
    assert "the plastic zone reaches the bottom and the sides" in told.err


# ---------------------------------------------------------------------- scans


@pytest.fixture
def scan(tmp_path):
    """Scan of five velocities; the zone of the fourth reaches a boundary, a reflected wave returned
    in the third.
    """
    write_scan(tmp_path, grid(load__velocity=[1, 2, 5, 10, 20]))
    result = ScanResult(tmp_path)
    changes_of_points = (FREE, FREE, WAVE, CUT, {})
    for n, (point, changes) in enumerate(zip(result.points, changes_of_points, strict=True)):
        path = point.directory / "summary.json"
        path.write_text(
            json.dumps(json.loads(path.read_text()) | (sizes_of(n) | changes if changes else {}))
        )
    return tmp_path


def test_figures_of_zones_have_open_marks(scan):
    found = drawings(ScanResult(scan))
    assert {f"zone_{name}_90_vs_load_velocity" for name in ("depth", "radius", "volume")} <= set(
        found
    )
    for name in ("plastic_zone_depth", "plastic_spheres", "zone_depth_90", "zone_volume_90"):
        figure = found[f"{name}_vs_load_velocity"].figure
        lines = {tuple(line.get_xdata()): line for line in figure.axes[0].lines}
        assert to_hex(lines[10.0,].get_markerfacecolor()) == "#ffffff"
        assert lines[5.0,].get_fillstyle() == "left"
        (legend,) = figure.legends
        expected = [LABELS[mark] for mark in (Mark.CUT, Mark.WAVE)]
        assert [text.get_text() for text in legend.get_texts()] == expected
    assert not found["peak_force_vs_load_velocity"].figure.legends
    columns = found["zone_depth_90_vs_load_velocity"].columns
    assert columns["zone_reaches_a_boundary"].tolist() == [0, 0, 0, 1]
    assert columns["reflected_wave_came_back"].tolist() == [0, 0, 1, 0]
    assert columns["zone_depth_90_over_diameter"].tolist() == pytest.approx(
        [1.8 * (1 + 0.01 * n) for n in range(4)]
    )


def test_a_point_has_all_its_marks(tmp_path):
    """The zone of the last point reaches a boundary, a wave returned to it, and it still grew at
    the end: the marker is open below its cross, and the data have all three marks.
    """
    write_scan(tmp_path, grid(load__velocity=[1, 2, 5]))
    unfinished = CUT | {"wave_return_share": 0.05, "incomplete_values": ["n_plastic_spheres"]}
    for n, changes in enumerate((FREE, FREE, unfinished)):
        path = ScanResult(tmp_path).points[n].directory / "summary.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | sizes_of(n) | changes))
    assert zone_marks(unfinished) == Mark.CUT | Mark.WAVE and mark_of(unfinished) is Mark.CUT
    drawing = drawings(ScanResult(tmp_path))["plastic_spheres_vs_load_velocity"]
    marks = [line for line in drawing.figure.axes[0].lines if tuple(line.get_xdata()) == (5.0,)]
    assert [line.get_marker() for line in marks] == ["o", "x"]
    assert to_hex(marks[0].get_markerfacecolor()) == "#ffffff"
    labels = [LABELS[Mark.CUT], LABELS[Mark.END]]
    assert [text.get_text() for text in drawing.figure.legends[0].get_texts()] == labels
    for mark in (Mark.CUT, Mark.WAVE, Mark.END):
        assert drawing.columns[LABELS[mark].replace(" ", "_")].tolist() == [0, 0, 1]


def test_bars_of_cut_zones_have_an_open_circle(tmp_path):
    """The circle is at the end of the bar, which keeps its colour."""
    write_scan(tmp_path, grid(packing__kind=["fcc", "hcp"]))
    for n, changes in enumerate((FREE, CUT)):
        path = ScanResult(tmp_path).points[n].directory / "summary.json"
        path.write_text(json.dumps(json.loads(path.read_text()) | sizes_of(n) | changes))
    figure = drawings(ScanResult(tmp_path))["zone_depth_90_vs_packing_kind"].figure
    bars = figure.axes[0].patches
    assert bars[0].get_facecolor() == bars[1].get_facecolor()
    (mark,) = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert to_hex(mark.get_markerfacecolor()) == "#ffffff"
    assert mark.get_xdata() == pytest.approx([bars[1].get_width()])
    assert mark.get_ydata() == pytest.approx([bars[1].get_y() + bars[1].get_height() / 2])
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [LABELS[Mark.CUT]]


def test_table_of_a_scan_has_the_bounds_in_words(scan):
    text = write_scan_table(scan).read_text()
    assert '"bottom, sides"' in text
    data = read_scan(scan)
    assert data["zone_cut"].tolist() == ["none", "none", "none", "bottom, sides", ""]
    assert data.unit("zone_depth_90_m") == "m"
    assert data.unit("zone_volume_90_m3") == "m^3"
    assert data.unit("wave_return_s") == "s"


# ---------------------------------------------------------------------- figures and reports of runs


def test_figure_of_the_size_shows_what_lies_farther_out():
    depth = np.array([0.0, 1.0, 1.0, 2.0, 3.0])
    energy = np.array([50.0, 30.0, 15.0, 4.0, 1.0])
    drawing = draw_zone_size(energy, {"depth": depth}, 1.0, "D", {"bottom": 3.0})
    assert drawing is not None
    assert drawing.columns["depth_m"].tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(
        drawing.columns["share_beyond_depth"], [0.5, 0.05, 0.01, 0], atol=1e-12
    )
    assert drawing.columns["depth_holding_m"] == [0.0, 1.0, 2.0]
    names = drawing.figure.axes[0].get_legend().get_texts()
    assert "zone reaches the bottom" in [name.get_text() for name in names]
    assert draw_zone_size(0 * energy, {"depth": depth}, 1.0, "D", {}) is None


@pytest.mark.parametrize(("bounds", "is_open"), [({"bottom": 3.0}, True), ({}, False)])
def test_markers_of_the_size_are_open_if_the_zone_reaches_a_boundary(bounds, is_open):
    depth = np.array([0.0, 1.0, 2.0, 3.0])
    distances = {"depth": depth, "radius": depth}
    drawing = draw_zone_size(np.array([50.0, 30.0, 4.0, 1.0]), distances, 1.0, "D", bounds)
    assert drawing is not None
    lines = [line for line in drawing.figure.axes[0].lines if line.get_marker() in ("o", "s")]
    assert len(lines) == 3  # depth, radius and legend
    assert [line.get_markerfacecolor() == "white" for line in lines] == [is_open] * 3


def test_legend_of_the_size_leaves_room_for_the_curves():
    """The five entries with both boundaries reached are no wider than the figure."""
    depth = np.array([0.0, 1.0, 2.0, 3.0])
    bounds = {"bottom": 3.0, "sides": 2.0}
    distances = {"depth": depth, "radius": depth[::-1]}
    with style():
        drawing = draw_zone_size(np.array([50.0, 30.0, 4.0, 1.0]), distances, 1.0, "D", bounds)
        assert drawing is not None
        drawing.figure.canvas.draw()
        axes = drawing.figure.axes[0]
        assert axes.get_legend().get_window_extent().x0 >= 0
        assert axes.bbox.width > 0.6 * drawing.figure.bbox.width


def test_boundaries_at_one_distance_are_both_seen():
    """The dashes of one line fill the gaps of the other."""
    depth = np.array([0.0, 1.0, 2.0, 3.0])
    distances = {"depth": depth, "radius": depth}
    bounds = {"bottom": 3.0, "sides": 3.0}
    drawing = draw_zone_size(np.array([50.0, 30.0, 4.0, 1.0]), distances, 1.0, "D", bounds)
    assert drawing is not None
    lines = drawing.figure.axes[0].lines
    edges = [line for line in lines if str(line.get_label()).startswith("zone reaches")]
    assert [line.get_xdata()[0] for line in edges] == [3000.0, 3000.0]
    (first, dashes), (second, others) = (line._unscaled_dash_pattern for line in edges)
    assert tuple(dashes) == tuple(others) and second - first == dashes[0] == dashes[1]
    assert edges[0].get_color() != edges[1].get_color()


def test_report_notes_marks_and_explains(tmp_path, scan):
    cut = write_run(tmp_path / "small", figures=False, **SIZES, **CUT)
    whole = write_run(tmp_path / "large", figures=False, **SIZES, **FREE)
    report = build([cut, whole, scan], tmp_path)
    told = [note.text for note in notes(report, "short")]
    assert any(
        "reaches a boundary" in text and "bottom, sides (small, " in text and "large" not in text
        for text in told
    )
    assert any(
        "a reflection from a boundary could return" in text and "1.8 %" in text for text in told
    )
    rows = table(report, "results", "Runs")
    assert [row["Boundaries reached by the plastic zone"].text for row in rows] == [
        "bottom, sides",
        "none",
    ]
    assert [row["Plastic zone, 90 % depth"].tone for row in rows] == ["note", ""]
    assert [row["Plastic zone, 90 % depth"].value for row in rows] == pytest.approx([0.018, 0.018])
    explained = table(report, "results", "What these values mean")
    assert any(row["In summary.json"].text == "zone_depth_90_m" for row in explained)
    alone = build([scan], tmp_path)
    assert any(
        b.caption == "What these values mean"
        for b in blocks(alone, "results")
        if isinstance(b, DocumentTable)
    )
