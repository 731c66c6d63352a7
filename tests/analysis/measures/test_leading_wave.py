"""First wave of computed chains: its peak forces before the reflection, and speeds by material."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.figures.chains import along_chain, bead_velocities, words_along_chain
from granwave.analysis.figures.style import style
from granwave.analysis.measures.force_decay import (
    exponential_of_depth,
    force_decay,
    no_decay_reason,
)
from granwave.analysis.measures.fronts import line_motions
from granwave.analysis.measures.layer_peaks import layer_peaks
from granwave.analysis.measures.leading_wave import first_wave, leading_peaks, stretch_speeds
from granwave.analysis.measures.regions import WHOLE, stretches, usual_regions
from granwave.analysis.result.reader import Result
from granwave.analysis.summary import summarise
from granwave.workflows import load_case, run_case
from tests.helpers.selection import with_every_test

CHAIN = {
    "material": "steel",
    "packing.size": 40,
    "packing.diameter": 0.01,
    "load.velocity": 0.3,
    "boundary.bottom": "wall",
    "run.end_time": 1e-3,
}


def run(directory, changes=None):
    run_case(load_case("homogeneous-chain", CHAIN | (changes or {})), directory, figures=False)
    return Result(directory)


def test_peaks_of_the_first_wave_are_constant_up_to_the_wall(tmp_path):
    """The solitary wave keeps its height; the largest force of the last contact is of the
    reflection.
    """
    with run(tmp_path) as result:
        peaks = leading_peaks(result)
        largest = result.along_chain("peak_force")
        layers = layer_peaks(result)
    assert layers.n_left_out == layers.n_hidden > 0  # a uniform chain has no larger pulse behind
    known = np.isfinite(peaks)
    assert known[:35].all()
    assert not known[-1]
    assert peaks[25:35] == pytest.approx(np.full(10, peaks[30]), rel=1e-3)
    assert largest[-1] > 1.03 * peaks[30]


YIELDING = {"contact.law": "elastoplastic", "load.velocity": 0.8, "run.end_time": 1.6e-3}
TWINS = {
    "steel": {},
    "brass": {"material": "brass"},
    "aluminium": {"material": "aluminium", "load.velocity": 1.5},
    "free": {"boundary.bottom": "free"},
    "held": {"boundary.bottom": "fixed"},
    "fast": {"load.velocity": 3.0},
    "static": {"precompression": {"kind": "uniaxial", "force": 2.0}},
    "heavy": {"load.velocity": 0.4, "replace": [{"index": 1, "diameter": 0.02}]},
    "pulse": {
        "load": {"kind": "force", "shape": "half-sine", "amplitude": 500.0, "duration": 3e-4}
    },
    "hertz": {"contact.law": "hertz"},
    "damped": {"contact.law": "hertz", "contact.loss": {"dashpot": 0.2}},
    "short": {"run.end_time": 3.5e-4},
}
LIKE_STEEL = ("steel", "brass", "aluminium", "free", "held", "static", "hertz")
N_SHORT = 25
N_LONG = 110


def twins(directory, changes):
    """Return the known peaks of a chain, those of all contacts before the reflection, and the peaks
    of the same contacts of a chain whose end the wave has not reached, or where it arrives later.
    """
    with run(directory / "short", YIELDING | changes | {"packing.size": N_SHORT}) as result:
        known = leading_peaks(result)
        so_far = first_wave(result).peak
    same = {name: value for name, value in changes.items() if name != "run.end_time"}
    with run(directory / "long", YIELDING | same | {"packing.size": N_LONG}) as result:
        force = result["chain/contact_force"]
        rise = force - force[0] if "precompression" in changes else force
        until = first_wave(result).reflection or np.inf
        long = rise[result["chain/time"] <= until, : len(known)].max(axis=0)
    return known, so_far, long


@pytest.mark.parametrize("name", with_every_test(TWINS, ("steel", "free", "pulse")))
def test_known_peaks_are_those_of_a_long_chain(tmp_path, name):
    """A trailing pulse can be larger than the first one, and can come after the reflection."""
    known, _, long = twins(tmp_path, TWINS[name])
    is_known = known > 0
    assert np.count_nonzero(is_known) >= 12
    assert known[is_known] == pytest.approx(long[is_known], rel=0.01)


def test_a_trailing_pulse_is_not_cut(tmp_path):
    """Without the condition on later pulses, forces would be a third too small."""
    known, so_far, long = twins(tmp_path, {})
    contact = 19  # at a depth of 195 mm
    assert so_far[contact] < 0.75 * long[contact]
    assert np.isnan(known[contact])
    assert known[14] == pytest.approx(long[14], rel=0.01)


def test_fit_and_figure_leave_out_what_is_not_known(tmp_path):
    """The decay of 25 beads is that of the same depths of 110; open circles are not fitted."""
    chain = YIELDING | {"packing.size": N_SHORT}
    with run(tmp_path / "short", chain) as result, style():
        wave = first_wave(result)
        peaks = layer_peaks(result)
        decay = force_decay(result)
        axes = along_chain(result).figure.axes[0]
    with run(tmp_path / "long", chain | {"packing.size": N_LONG}) as result:
        long = layer_peaks(result)
    beads = np.flatnonzero(peaks.is_known)
    assert peaks.largest[beads] == pytest.approx(long.largest[beads], rel=1e-3)
    fitted = beads[beads > 0]
    assert decay.n_layers == len(fitted)
    same = exponential_of_depth(long.depth[fitted], long.largest[fitted])
    assert decay.rate == pytest.approx(same.rate, rel=1e-3)
    lines = {line.get_label(): line for line in axes.lines}
    passing = [
        lines[label]
        for label in ("larger pulse may follow", "larger force followed")
        if label in lines
    ]
    assert all(line.get_markerfacecolor() == "none" for line in passing)
    numbers = np.sort(np.concatenate([line.get_xdata() for line in passing]))
    assert numbers == pytest.approx(np.flatnonzero(wave.is_passing) + 1)
    assert lines["first wave"].get_xdata() == pytest.approx(np.flatnonzero(wave.is_known) + 1)


@pytest.mark.parametrize("name", with_every_test(LIKE_STEEL, ("steel", "static")))
def test_speed_of_the_front_is_that_of_a_long_chain(tmp_path, name):
    """Arrivals are at a tenth of the largest force of the run, which later pulses change."""
    changes = YIELDING | TWINS[name]
    fronts = []
    for n_beads in (N_SHORT, N_LONG):
        with run(tmp_path / str(n_beads), changes | {"packing.size": n_beads}) as result:
            motion = line_motions(result, result.origin, np.array([0.0, 0.0, 1.0]))[0]
        fronts.append(motion)
    short, long = fronts
    rows = np.isin(short.place.round(6), short.front.place.round(6))
    arrival = long.arrival[:N_SHORT][rows]
    assert short.front.time == pytest.approx(arrival, rel=0.02)
    slope = np.polyfit(arrival, short.place[rows], 1)[0]
    assert short.front.speed == pytest.approx(slope, rel=0.035)


def test_a_solitary_wave_has_no_decay(tmp_path):
    """Its force is constant behind the first beads; reflections at the wall are left out."""
    with run(tmp_path) as result:
        assert force_decay(result) is None
        assert no_decay_reason(result).startswith("the peak force is constant within 0.1 %")
        peaks = layer_peaks(result)
        assert peaks.of_first_wave and peaks.n_left_out > 0
        assert peaks.largest[peaks.is_known][1:].max() == pytest.approx(leading_peaks(result)[0])


def test_a_step_of_the_material_has_no_decay(tmp_path):
    """Both laws would be 50 % from the forces."""
    soft = [{"index": {"first": 21, "last": 40}, "material": "ptfe"}]
    with run(tmp_path, {"replace": soft, "run.end_time": 4e-3}) as result:
        assert force_decay(result) is None
        assert no_decay_reason(result) == "the material or the diameter changes with depth"


def test_a_damped_wave_decays(tmp_path):
    """Also where the wave has not passed the chain: beads ahead of it are left out."""
    rates = []
    for name, end in (("whole", 1e-3), ("part", 4e-4)):
        loss = {"contact.loss": {"dashpot": 0.05}, "run.end_time": end}
        with run(tmp_path / name, loss) as result:
            decay = force_decay(result)
            assert decay is not None and no_decay_reason(result) == ""
            assert decay.misfit < 0.05 and decay.explained > 0.95
            rates.append(layer_peaks(result).largest[5:15])
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)


def test_figure_along_a_chain_is_of_the_first_wave(tmp_path):
    """The figure shows the forces of the sentence; the reflection has marks of its own."""
    with run(tmp_path, {"precompression": {"kind": "uniaxial", "force": 5.0}}) as result, style():
        drawing = along_chain(result)
        first = leading_peaks(result)
        rise = result.along_chain("peak_force") - result["chain/contact_force"][0]
    lines = {line.get_label(): line for line in drawing.figure.axes[0].lines}
    later = lines["largest of the run"]
    wave = lines["first wave"]
    assert lines.keys() <= {"largest of the run", "first wave", "still rising"}
    known = np.nan_to_num(first) > 0
    assert wave.get_ydata() == pytest.approx(first[known])
    assert drawing.figure.axes[0].get_ylabel() == "Dynamic peak force (N)"
    assert len(later.get_xdata()) and rise[int(later.get_xdata()[-1]) - 1] == pytest.approx(
        later.get_ydata()[-1]
    )
    assert drawing.columns["first_wave_peak_force_N"] == pytest.approx(first, nan_ok=True)


def test_every_contact_that_the_wave_reached_has_a_mark_of_it(tmp_path):
    """Also the contacts whose force still rises when the reflection comes; a larger pulse "may"
    follow only where no larger force followed.
    """
    with run(tmp_path, YIELDING | {"packing.size": N_SHORT}) as result, style():
        drawing = along_chain(result)
        wave = first_wave(result)
        words = words_along_chain(result, tmp_path)[1]
    lines = {line.get_label(): line for line in drawing.figure.axes[0].lines}
    later = set(lines.pop("largest of the run").get_xdata())
    marked = np.sort(np.concatenate([line.get_xdata() for line in lines.values()]))
    assert marked.tolist() == list(range(1, len(wave.peak) + 1))
    assert wave.reflection is not None and "still rising" in lines
    assert "Triangles: the first wave still rose when the reflection came" in words
    assert set(lines["larger force followed"].get_xdata()) <= later
    if "larger pulse may follow" in lines:
        assert not later & set(lines["larger pulse may follow"].get_xdata())
    assert drawing.columns["first_wave_recorded_force_N"] == pytest.approx(wave.peak)


@pytest.mark.parametrize(("law", "n_beads"), [("elastoplastic", 25), ("hertz", 40)])
def test_velocities_are_at_instants_of_the_front(tmp_path, law, n_beads):
    """Also where the run lasts five times as long as the passage: each curve is largest, ahead of
    the later pulses, at the bead of its name, and without losses all have the same height.
    """
    long = YIELDING | {"contact.law": law, "packing.size": n_beads, "run.end_time": 2.5e-3}
    with run(tmp_path, long) as result, style():
        drawing = bead_velocities(result)
        end = first_wave(result).reflection
    curves = drawing.figure.axes[0].lines[:4]
    beads = [int(curve.get_label().split("bead ")[1]) for curve in curves]
    assert beads == sorted(set(beads)) and beads[-1] >= n_beads - 3
    heights = []
    for curve, bead in zip(curves, beads, strict=True):
        front = curve.get_ydata()[bead - 1 :]
        assert front.argmax() == 0
        heights.append(front[0])
    instants = [float(name.split("_")[2]) for name in drawing.columns if name != "bead"]
    assert instants == sorted(instants) and instants[-1] <= end
    if law == "hertz":
        assert heights[1:] == pytest.approx([heights[-1]] * 3, rel=0.01)
    else:
        assert heights == sorted(heights, reverse=True)


def test_velocities_of_equal_beads(tmp_path):
    """Rounding does not decide where the way of the front starts: all beads have one speed."""
    changes = {"run.end_time": 1e-3}
    run_case(load_case("preconditioned-chain", changes), tmp_path, figures=False)
    with Result(tmp_path) as result, style():
        curves = bead_velocities(result).figure.axes[0].lines[:4]
    beads = [int(curve.get_label().split("bead ")[1]) for curve in curves]
    assert beads == sorted(set(beads))


def test_speeds_of_two_materials(tmp_path):
    """Each stretch has its own speed; the speed of the summary is of the deeper half."""
    soft = [{"index": {"first": 21, "last": 40}, "material": "ptfe"}]
    with run(tmp_path, {"replace": soft, "run.end_time": 4e-3}) as result:
        speeds = stretch_speeds(result)
    assert list(speeds) == ["beads 1 to 20, steel", "beads 21 to 40, ptfe"]
    steel, ptfe = speeds.values()
    assert steel > 2 * ptfe
    assert summarise(tmp_path)["wave_speed_m_s"] == pytest.approx(ptfe, rel=0.02)
    with run(tmp_path / "uniform") as result:
        assert stretch_speeds(result) == {}


def test_stretches_of_one_material_and_two_diameters(tmp_path):
    """Diameters that scatter, or that all differ, make no stretches."""
    small = {"index": {"first": 21, "last": 40}, "diameter": 0.004}
    with run(tmp_path / "two", {"replace": [small], "run.end_time": 1e-4}) as result:
        names = list(stretches(result))
        assert names == ["beads 1 to 20, steel, 10 mm", "beads 21 to 40, steel, 4 mm"]
    scatter = {"packing.diameter_scatter": 1e-4, "packing.size": 5, "run.end_time": 1e-4}
    with run(tmp_path / "scatter", scatter) as result:
        assert stretches(result) == {}
    tapered = [{"index": n, "diameter": 0.01 - 2e-4 * n} for n in range(1, 41)]
    with run(tmp_path / "tapered", {"replace": tapered, "run.end_time": 1e-4}) as result:
        assert stretches(result) == {}


def test_a_bead_alone(tmp_path):
    """Its force on the wall is exact, and it is no region from 0 to 0 mm."""
    one = {"packing.size": 1, "load.velocity": 1.0, "run.end_time": 2e-4}
    with run(tmp_path, one) as result:
        assert list(usual_regions(result, np.array([0.0, 0.0, 1.0]))) == [WHOLE]
    summary = summarise(tmp_path)
    assert summary["wall_peak_force_N"] == summary["peak_force_with_walls_N"]
    assert summary["ground_peak_force_N"] == summary["wall_peak_force_N"]
    assert "wall_sample_s" not in summary
    assert summary["base_arrival_s"] == pytest.approx(4.13e-7, rel=0.01)
    assert summary["peak_overlap_m"] is None  # no two spheres are in contact
