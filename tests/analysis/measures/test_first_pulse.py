"""Arrivals at the first pulse: one front has one speed, whatever follows it."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis.measures.first_pulse import contact_arrivals, first_pulse_ends
from granwave.analysis.measures.fronts import line_motions
from granwave.analysis.measures.signals import arrival, first_peak
from granwave.analysis.measures.waves import front_arrivals, wave_speed_of
from granwave.analysis.result.reader import Result
from granwave.workflows import load_case, run_case
from tests.helpers.selection import with_every_test

DOWN = np.array([0.0, 0.0, 1.0])
#: Aluminium beads that yield: a larger pulse follows, and the reflection is larger than both.
CHAIN = {
    "material": "aluminium",
    "contact.law": "elastoplastic",
    "packing.size": 30,
    "packing.diameter": 0.006,
    "load.velocity": 0.4,
    "boundary.bottom": {"material": "steel"},
}
CHANGES = {
    "elastoplastic": {},
    "hertz": {"contact.law": "hertz"},
    "static": {
        "contact.law": "hertz",
        "precompression": {"kind": "uniaxial", "force": 2.0},
    },
    "dashpot": {"contact.loss": {"dashpot": 0.2}},
    "free": {"boundary.bottom": "free"},
}
PACKING = {"packing.size": [7, 7, 14], "load.velocity": 5.0, "run.frames": 2}


def run(directory, name, changes):
    run_case(load_case(name, changes), directory, figures=False)
    return Result(directory)


@pytest.mark.parametrize("name", with_every_test(CHANGES, ("elastoplastic", "static")))
def test_a_front_along_a_chain_has_one_speed(tmp_path, name):
    """All ends are after the first pulse at the last contact."""
    speeds = []
    for end in (5e-4, 6e-4, 1.2e-3):
        changes = CHAIN | CHANGES[name] | {"run.end_time": end}
        with run(tmp_path / str(end), "homogeneous-chain", changes) as result:
            speeds.append(wave_speed_of(result))
            depth, when = front_arrivals(result)
            (motion,) = line_motions(result, result.origin, DOWN)
        assert motion.front.speed == pytest.approx(speeds[-1], rel=1e-9)
        assert len(depth) == CHAIN["packing.size"]
        assert np.all(np.diff(when[1:]) > 0)
    assert speeds == pytest.approx([speeds[0]] * len(speeds), rel=3e-4)


@pytest.mark.parametrize(("kind", "law"), [("fcc", "elastoplastic"), ("sc", "hertz")])
def test_a_front_in_a_packing_has_one_speed(tmp_path, kind, law):
    """The ends are after the arrival at the last layer, and after the reflection."""
    speeds = []
    for end in (3e-4, 6e-4):
        changes = PACKING | {"packing.kind": kind, "contact.law": law, "run.end_time": end}
        with run(tmp_path / str(end), "fcc-small", changes) as result:
            speeds.append(wave_speed_of(result))
    assert speeds[1] == pytest.approx(speeds[0], rel=3e-4)


def test_arrivals_are_at_a_tenth_of_the_first_pulse(tmp_path):
    """Also where the largest force of the run is of a later pulse; within the interpolation of the
    record.
    """
    with run(tmp_path, "homogeneous-chain", CHAIN | {"run.end_time": 7e-4}) as result:
        found = contact_arrivals(result)
        time = result["chain/time"]
        forces = result["chain/contact_force"].T
        latest = result.along_chain("time_peak")
    peaks = [first_peak(time, force, floor=1e-3) for force in forces]
    expected = [
        arrival(time, force, 0.1 * peak) for force, (_, peak) in zip(forces, peaks, strict=True)
    ]
    assert found == pytest.approx(expected, abs=0.05 * (time[1] - time[0]) + 3e-8)
    assert np.count_nonzero(latest > 1.3 * np.array([when for when, _ in peaks])) > 10


def test_speed_does_not_need_a_dense_record(tmp_path):
    """Contacts have the time of their arrival, which is used where records are far apart."""
    speeds = []
    for n_records in (12, 900):
        changes = CHAIN | CHANGES["hertz"] | {"run.end_time": 6e-4, "output.history": n_records}
        with run(tmp_path / str(n_records), "homogeneous-chain", changes) as result:
            speeds.append(wave_speed_of(result))
    assert speeds[0] == pytest.approx(speeds[1], rel=1e-3)


def test_ends_of_pulses():
    """A ripple below the limit is no pulse; a force that only rises has none yet."""
    time = np.linspace(0.0, 1.0, 201)
    pulse = np.maximum(np.sin(4 * np.pi * time), 0.0)
    larger = pulse * np.where(time < 0.5, 1.0, 3.0)
    ripple = np.where(time < 0.05, 0.01 * np.sin(20 * np.pi * time), 0.0)
    late = np.where(time < 0.5, np.maximum(ripple, 0.0), pulse)
    rise = np.stack([pulse, larger, late, time], axis=1)
    ends = first_pulse_ends(rise, 0.02)
    peak = int(pulse.argmax())
    assert ends[0] == ends[1]
    assert peak < ends[0] < peak + 5
    assert ends[2] == ends[0] + 100
    assert ends[3] == len(time)
