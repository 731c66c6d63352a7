"""Captions and colours of figures that depend on the run."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.chains import (
    along_chain,
    bars,
    words_along_chain,
    words_on_bars,
)
from granwave.analysis.figures.histories import bottom_force
from granwave.analysis.figures.run_figures import draw_figures, run_figures
from granwave.analysis.figures.sections import reached_by_front, wave_front
from granwave.analysis.figures.style import style
from granwave.analysis.measures.waves import front_arrivals, stays_in_layer
from granwave.analysis.notebook.run import Run
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.outline import build_report
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY
from granwave.workflows import load_case, run_case

SMALL = {"packing.size": [14, 14, 8], "load.velocity": 3.0, "run.end_time": 1.2e-4}


@pytest.fixture(scope="module")
def packing(tmp_path_factory):
    """A small fcc packing."""
    directory = tmp_path_factory.mktemp("fcc")
    run_case(load_case("fcc-small", SMALL), directory, figures=False)
    return directory


@pytest.fixture(scope="module")
def layer(tmp_path_factory):
    """A layer of spheres with an impact in its plane."""
    directory = tmp_path_factory.mktemp("layer") / "run"
    run_case(load_case("square-in-plane", {"run.frames": 5}), directory, figures=False)
    draw_figures(directory, names=("packing_3d", "energies"))
    return directory


def test_edge_of_the_colours_is_the_front(packing):
    """The deepest layer with a coloured sphere is the layer that the front has reached; ahead of
    it, forces are not zero.
    """
    with style(), Result(packing) as result:
        depth, arrival = front_arrivals(result)
        columns = wave_front(result).columns
        down = result["spheres/position"][:, 2] - result.origin[2]
        force = next(values for name, values in columns.items() if name.startswith("force_over"))
        rows = result.rows(columns["id"])
        for time in np.unique(columns["time_s"]):
            coloured = (columns["time_s"] == time) & (force > 0)
            deepest = depth[arrival <= time].max()
            assert down[rows[coloured]].max() <= deepest + 1e-9
            (behind,) = reached_by_front(result, [float(time)])
            assert down[behind].max() == pytest.approx(deepest)


def test_axis_of_each_curve_names_its_line(packing):
    """In grey prints; without a second axis the label has no style."""
    with style(), Result(packing) as result:
        first, second = bottom_force(result).figure.axes
    assert first.get_ylabel() == "Force on the bottom (N), solid"
    assert second.get_ylabel().endswith(", dashed")
    assert first.lines[0].get_linestyle() == "-" and second.lines[0].get_linestyle() == "--"
    run = Run(packing)
    assert run.figure("bottom_force", against=run).get_ylabel() == "Force on the bottom (N)"


def test_caption_of_forces_against_depth_names_what_is_drawn(packing):
    figure = run_figures()["peak_force_depth"]
    assert "oscillating" not in figure.caption
    draw_figures(packing, names=("peak_force_depth",))
    table = packing / FIGURES_DIRECTORY / "peak_force_depth.csv"
    with Result(packing) as result:
        caption, look = figure.words(result, table)
        assert caption == "Peak contact force of the first wave against depth, excluding walls"
        assert "Circles" in look and len(look) <= 130
        rows = [line.split(",") for line in table.read_text(encoding="utf-8").splitlines()]
        kept = [k for k, name in enumerate(rows[0]) if not name.startswith("direction_")]
        bare = "\n".join(",".join(map(row.__getitem__, kept)) for row in rows)
        table.write_text(bare, encoding="utf-8")
        assert "Circles" not in figure.words(result, table)[1]


@pytest.mark.needs_extension("pictures")
def test_impact_in_the_plane_of_a_layer(layer):
    """Nothing is cut away, and the wave never reaches the bottom."""
    with Result(layer) as result:
        assert stays_in_layer(result)
    figure = run_figures()["packing_3d"]
    with Result(layer) as result:
        caption, look = figure.words(result, layer)
    assert caption.startswith("Packing of one layer, ") and "cut" not in f"{caption} {look}"
    report = str(build_report(read_inputs([layer], layer.parent)))
    assert "does not reach the bottom" not in report
    assert "quarter is cut away" not in report


@pytest.fixture(scope="module")
def short_chain(tmp_path_factory):
    """An elastic chain in front of a bar, with forces of a few newtons and energies of nJ."""
    bar = {"length": 0.6, "elements": 100, "area": 28e-6, "material": "aluminium"}
    case = {
        "name": "short", "material": "aluminium", "bar": bar, "load": {"velocity": 0.05},
        "contact": {"law": "hertz"}, "packing": {"kind": "chain", "size": 6, "diameter": 6e-3},
        "run": {"end_time": 2e-4},
    }  # fmt: skip
    directory = tmp_path_factory.mktemp("short")
    run_case(case_from_dict(case), directory, figures=False)
    return directory


def test_units_of_bars_follow_the_values_and_the_caption_the_bar(short_chain):
    with style(), Result(short_chain) as result:
        drawing = bars(result)
        upper, lower = drawing.figure.axes
        caption, look = words_on_bars(result, short_chain)
        speed = result.assembly.bars[0].wave_speed
    assert upper.get_ylabel().endswith("(N)")
    assert lower.get_ylabel() == "Energy in the bar (nJ)"
    columns = drawing.columns
    np.testing.assert_allclose(
        upper.lines[0].get_ydata().max(), columns["bar_contact_force_N"].max()
    )
    np.testing.assert_allclose(
        lower.lines[0].get_ydata().max(), 1e9 * columns["bar_energy_J"].max()
    )
    assert caption == "Bars: contact force and energy"
    assert f"returns from the far end after {1.2 / speed * 1e6:.0f} µs (bar)" in look


def test_caption_along_a_chain_names_only_what_is_drawn(short_chain):
    """Without a static load and without dissipation."""
    with style(), Result(short_chain) as result:
        drawing = along_chain(result)
        caption, look = words_along_chain(result, short_chain)
    names = drawing.figure.axes[0].get_legend_handles_labels()[1]
    assert len(drawing.figure.axes) == 1
    assert "static" not in caption and "dissipation" not in caption
    assert ("crosses" in caption) == ("largest of the run" in names)
    assert ("Open circles" in look) == ("larger pulse may follow" in names)
