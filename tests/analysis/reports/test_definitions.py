"""Comparisons of runs whose values are defined differently: static loads, kinds, hidden curves."""

from __future__ import annotations

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.figures.style import style
from granwave.analysis.measures.dynamic_force import dynamic_peak_forces
from granwave.analysis.measures.impact import peak_force_by_depth
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.curves import (
    SampledCurve,
    force_at_bottom,
    peaks_by_depth,
    static_force_at_bottom,
)
from granwave.analysis.reports.comparison.deviations import deviation
from granwave.analysis.reports.comparison.figures.bottom_force import draw_bottom_force
from granwave.analysis.reports.comparison.measured_curve import read_measured
from granwave.analysis.reports.comparison.measured_words import closest_sentence
from granwave.analysis.reports.comparison.protection import protection_sentences
from granwave.analysis.reports.comparison.subjects import compared_runs, value_text
from granwave.analysis.reports.inputs import read_inputs
from granwave.workflows import load_case, run_case
from tests.helpers.made_up.synthetic_report import write_run

pytestmark = pytest.mark.xdist_group("definitions of a comparison")  # its fixture is made once

SMALL = {"packing.size": [6, 6, 4], "run.end_time": 1e-4, "boundary.sides": "periodic"}
PRESSED = {"precompression": {"kind": "uniaxial", "pressure": 1e5}}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A packing under a static load, and the same packing without it."""
    folder = tmp_path_factory.mktemp("static")
    for name, changes in (("pressed", SMALL | PRESSED), ("loose", SMALL)):
        run_case(load_case("fcc-small", changes), folder / name, figures=False)
    return folder


@pytest.fixture(scope="module")
def comparison(place):
    """Both runs compared."""
    inputs = read_inputs([place / name for name in ("pressed", "loose")], place)
    return compare_runs(list(inputs.results()))


def test_dynamic_forces_of_contacts(place):
    """Peak less static force of each contact, by an independent loop over contacts."""
    result = gw.load(place / "pressed").result
    rise = result["contacts/peak_force"] - result["contacts/initial_force"]
    expected = np.zeros(result.n_spheres)
    for (first, second), force in zip(result.ends.tolist(), rise.tolist(), strict=True):
        expected[first] = max(expected[first], force)
        expected[second] = max(expected[second], force)
    assert dynamic_peak_forces(result) == pytest.approx(expected)
    assert np.all(dynamic_peak_forces(result) <= result["spheres/peak_force"])
    total = peak_force_by_depth(result)[1]
    dynamic = peak_force_by_depth(result, dynamic=True)[1]
    assert np.all(dynamic < total)


def test_without_static_load_forces_are_peak_forces(place):
    result = gw.load(place / "loose").result
    assert np.array_equal(dynamic_peak_forces(result), result["spheres/peak_force"])


def test_static_force_is_pressure_times_area(comparison):
    """Uniaxial pressure on periodic sides: 36 cells of sqrt(3)/2 D^2."""
    pressed, loose = comparison.runs
    assert static_force_at_bottom(pressed) == pytest.approx(
        1e5 * 36 * np.sqrt(3) / 2 * 0.01**2, rel=1e-4
    )
    assert static_force_at_bottom(loose) == 0


def test_protection_is_ranked_by_dynamic_forces(comparison):
    """The total peak force of the preloaded packing is larger, and a note states that it contains
    the static force.
    """
    pressed, loose = (force_at_bottom(run).y for run in comparison.runs)
    rises = {"pressed": pressed.max() - pressed[0], "loose": loose.max()}
    best = min(rises, key=lambda name: rises[name])
    assert comparison.protection[0].startswith(f"{best} protects the bottom better: its peak dyna")
    notes = " ".join(comparison.notes)
    assert "include static forces; on the bottom, before the impact: 311.8 N in pressed." in notes
    assert "Forces above the static force" in comparison.caption("peak_force_depth")
    caption = comparison.caption("bottom_force")
    assert "include the static force before the impact: 311.8 N (pressed)" in caption


def test_a_value_that_repeats_another_has_no_row(comparison):
    names = [value.name for value in comparison.values]
    assert "wall_peak_force_N" in names
    assert "ground_peak_force_N" not in names


def test_requested_values_that_are_equal_are_not_all_results(place):
    inputs = read_inputs([place / name for name in ("pressed", "loose")], place)
    alone = compare_runs(list(inputs.results()), ["n_spheres"])
    assert alone.sentence.startswith("The requested values do not differ between pressed and loose")


def test_inputs_and_zones(tmp_path):
    """Energy inputs that differ, and zones that a boundary limits, are named."""
    write_run(tmp_path / "a", energy_input_J=1.0, zone_cut=["bottom", "sides"])
    write_run(tmp_path / "b", energy_input_J=2.0, zone_cut=[], zone_growing=["depth"])
    inputs = read_inputs([tmp_path / "a", tmp_path / "b"], tmp_path)
    notes = " ".join(compare_runs(list(inputs.results())).notes)
    assert "Inputs differ: 1 J (80 g at 5 m/s) in a, 2 J (160 g at 5 m/s) in b." in notes
    assert "reaches a boundary, which limits its size: bottom and sides in a." in notes
    assert "still grows at the end of the run: depth in b." in notes
    runs = compared_runs(list(inputs.results()))
    assert not any("dynamic" in text for text in protection_sentences(runs, ["a", "b"]))


def test_heights_that_differ_are_named(tmp_path):
    """A higher packing has the lower force; equal heights, within 1 %, have no note."""
    for name, height in (("low", 0.065), ("high", 0.082), ("equal", 0.0652)):
        write_run(tmp_path / name, wall_peak_force_N=10.0, packing_height_m=height)

    def noted(*names):
        inputs = read_inputs([tmp_path / name for name in names], tmp_path)
        return [note for note in compare_runs(list(inputs.results())).notes if "height" in note]

    (note,) = noted("low", "high")
    assert note.startswith("Packings differ in height: 65 mm in low, 82 mm in high.")
    assert noted("low", "equal") == []


@pytest.mark.parametrize(("ratio", "scale"), [(5.0, "linear"), (10.0, "log"), (100.0, "log")])
def test_a_small_force_is_not_hidden(comparison, ratio, scale):
    time = np.linspace(0, 1e-4, 50)
    small = SampledCurve(time, np.sin(np.pi * time / 1e-4))
    large = SampledCurve(time, ratio * small.y)
    with style():
        drawing = draw_bottom_force(dict(zip(comparison.runs, (small, large), strict=True)), [])
    assert drawing.figure.axes[0].get_yscale() == scale


def test_a_run_without_force_in_the_measured_range(tmp_path):
    """A rise by rounding is no peak."""
    (tmp_path / "m.csv").write_text("time_us,force_N\n0,0\n10,50\n20,5\n")
    measured = read_measured(tmp_path / "m.csv", ("s", "N"))
    curve = SampledCurve(np.array([0.0, 2e-5, 4e-5]), np.array([0.0, 1e-6, 60.0]))
    difference = deviation(measured, curve)
    text = closest_sentence(measured, {"a": difference}, ("s", "N"), alone=False)
    assert text.endswith("it is zero in the measured range, the measured peak is 50 N at 10 µs.")


def test_a_table_of_grains_is_counted():
    grains = "x,y,z,diameter\n0,0,0,0.01\n0,0,0.01,0.01\n"
    assert value_text("packing.grains", {"packing.grains": grains}) == "table of 2 rows"


def test_replaced_beads_in_words():
    replaced = [{"index": [20], "material": {"name": "aluminium"}}, {"index": 3, "diameter": 0.006}]
    text = value_text("replace", {"replace": replaced})
    assert text == "aluminium at 20, 6 mm at 3"


def test_layers_that_the_wave_has_just_reached_are_left_out(tmp_path):
    """The precursor of the front would span decades of the axis."""
    changes = {"packing.size": 60, "run.end_time": 4e-4}
    run_case(load_case("elastic-impact", changes), tmp_path / "short", figures=False)
    inputs = read_inputs([tmp_path / "short"], tmp_path)
    peaks = peaks_by_depth(compared_runs(list(inputs.results()))[0])
    assert peaks.n_unknown > 0
    assert peaks.largest.min() > 0.5 * peaks.largest.max()
