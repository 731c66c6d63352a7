"""Beads of a chain with rings next to them: peak forces, speed, figure and first sentences."""

from __future__ import annotations

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.figures.peak_force_depth import peak_force_depth
from granwave.analysis.figures.style import style
from granwave.analysis.measures.bead_wave import beads_after_reflection, crest_speed
from granwave.analysis.measures.beads import bead_peaks, beads_on_axis
from granwave.analysis.measures.force_decay import ForceDecay, force_decay
from granwave.analysis.measures.layer_peaks import layer_peaks
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.result.reader import Result
from granwave.measures import GrainRow

N_BEADS = 64
STRUCK = 4
SHORT = {
    "packing.size": N_BEADS, "grains.1.repeat.times": N_BEADS - 1, "hold.1.index": [1, N_BEADS],
    "load.index": [STRUCK], "run.end_time": 1.1e-3,
}  # fmt: skip
NARROW = {"precompression": {"kind": "walls", "tube": 1.425e-5}, "run.end_time": 6e-4}


#: A short row, whose wave returns from its end before the run ends.
REFLECTED = {
    "packing.size": 30, "grains.1.repeat.times": 29, "hold.1.index": [1, 30],
    "run.end_time": 8e-4,
}  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs whose wave has not passed all beads: in a tube that touches, and in a narrower tube."""
    folder = tmp_path_factory.mktemp("rows")
    changes = {"wide": SHORT, "narrow": SHORT | NARROW}
    return {
        name: gw.run("confined-row", case, directory=folder / name, progress=False)
        for name, case in changes.items()
    }


@pytest.mark.parametrize("name", ["wide", "narrow"])
def test_layers_are_the_beads_alone(runs, name):
    """The forces are those of the contacts between two beads, above the static force."""
    row = GrainRow(runs[name])
    with Result(runs[name].directory) as result:
        is_bead = beads_on_axis(result)
        peaks = layer_peaks(result)
        forces = bead_peaks(result)
        static = np.zeros(N_BEADS - 1)
        if name == "narrow":
            static = result.of_pairs("initial_force", row.ids[:-1], row.ids[1:])
        speed = crest_speed(result)
    assert list(np.flatnonzero(is_bead) + 1) == list(row.ids)
    assert len(peaks.depth) == N_BEADS
    passed = slice(STRUCK - 1, row.passed)
    rise = row.of_contacts("peak_force") - static
    assert forces[passed] == pytest.approx(rise[passed], rel=1e-12)
    assert np.all(forces[: STRUCK - 1] == 0)
    assert peaks.largest[STRUCK : row.passed] == pytest.approx(
        np.maximum(rise[STRUCK - 1 : row.passed - 1], rise[STRUCK : row.passed]), rel=1e-12
    )
    assert peaks.is_known[row.passed - 2] and not peaks.is_known[-2:].any()
    when = row.of_contacts("time_peak")
    first = row.passed - 12
    last = row.passed - 2
    assert speed == pytest.approx((last - first) * 0.015 / (when[last] - when[first]), rel=0.03)


def test_decay_of_the_beads(runs):
    """The fit follows the beads, which have one material and one diameter."""
    with Result(runs["wide"].directory) as result:
        decay = force_decay(result)
    assert isinstance(decay, ForceDecay)
    assert decay.misfit < 0.02


def test_figure_has_beads_and_rings_and_nothing_that_the_wave_has_not_reached(runs):
    with style(), Result(runs["wide"].directory) as result:
        drawing = peak_force_depth(result)
    axes = drawing.figure.axes[0]
    labels = [line.get_label() for line in axes.lines]
    assert labels[0] == "between beads"
    assert "largest of the grains next to the beads" in labels
    low, high = axes.get_ylim()
    assert high / low < 100
    known = drawing.columns["bead_peak_is_known"].astype(bool)
    assert axes.lines[0].get_xdata() == pytest.approx(drawing.columns["bead_depth_m"][known] * 1e3)
    assert axes.get_xlim()[1] < 1.03e3 * drawing.columns["bead_depth_m"][-1]


def test_first_sentences_have_speed_and_decay_of_the_beads(runs):
    words = {
        name: in_words(read_inputs([run.directory], run.directory).runs[0])
        for name, run in runs.items()
    }
    assert words["wide"].startswith("The wave speed along the beads was ")
    assert "The peak force between beads decreases from " in words["wide"]
    assert "It falls exponentially with the depth, by " in words["wide"]
    assert words["narrow"].startswith("The speed of the wave crest along the beads was ")
    assert "The peak force between beads above the static force decreases from " in words["narrow"]


def test_forces_of_the_reflection_are_not_in_the_first_sentences(tmp_path):
    """The force is largest at the end of the row, where the wave is reflected."""
    run = gw.run("confined-row", REFLECTED, directory=tmp_path, progress=False)
    with Result(run.directory) as result:
        forces = bead_peaks(result)
        is_late = beads_after_reflection(result)
        speed = crest_speed(result)
    first = int(np.flatnonzero(is_late)[0])
    known = forces[forces > 0][: first - np.count_nonzero(forces == 0)]
    assert is_late[first:].all()
    assert np.all(np.diff(known) < 0)
    assert np.nanmax(forces) == forces[-1] > known[0]
    words = in_words(read_inputs([run.directory], run.directory).runs[0])
    assert "The peak force between beads decreases from " in words
    assert f"beyond contact {first}, the largest force came after the reflection" in words
    assert speed == pytest.approx(run.summary["wave_speed_m_s"], rel=0.03)
