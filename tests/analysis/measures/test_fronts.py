"""Motion of lines of grains, arrivals, and the line through them."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.measures.fronts import AXIS, Front, line_motions
from granwave.analysis.measures.waves import wave_speed_of
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic

DOWN = np.array([0.0, 0.0, 1.0])
SPEED = 1000.0  # m/s, of the made-up runs


def test_a_line_goes_through_its_arrivals():
    place = np.array([0.0, 0.01, 0.03, 0.06])
    front = Front(2e-6 + place / 640.0, place)
    assert front.speed == pytest.approx(640.0)
    assert front.when(place) == pytest.approx(front.time)


@pytest.mark.parametrize(("kind", "size"), [("chain", 20), ("sc", (3, 3, 16))])
def test_arrivals_of_a_made_up_run_lie_on_the_line(tmp_path, kind, size):
    """Contacts at the distance d were first loaded at d / (1000 m/s); along an axis of simple cubic
    spheres as in a chain.
    """
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(kind, size)))
    with Result(tmp_path) as result:
        (motion,) = line_motions(result, result.origin, DOWN)
        assert motion.name == AXIS
        assert motion.place == pytest.approx(synthetic.DIAMETER * np.arange(len(motion.ids)))
        assert motion.front.speed == pytest.approx(SPEED, rel=1e-9)
        late = (motion.arrival - motion.front.when(motion.place))[1:]
        reached = np.isfinite(late)  # up to 1e-4 of the largest force
        assert reached.sum() == 8
        assert np.abs(late[reached]).max() < 1e-9 * motion.arrival[8]


def test_the_axis_has_one_grain_of_each_layer(tmp_path):
    """In FCC every third grain is on the axis, the others are 0.58 diameters away from it."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(size=(9, 9, 7))))
    with Result(tmp_path) as result:
        (motion,) = line_motions(result, result.origin, DOWN)
        position = result["spheres/position"][result.rows(motion.ids)]
        beside = np.linalg.norm((position - result.origin)[:, :2], axis=1) / synthetic.DIAMETER
        assert beside == pytest.approx(np.where(np.arange(7) % 3, 1 / np.sqrt(3), 0.0), abs=1e-6)
        assert np.diff(motion.place) == pytest.approx(synthetic.DIAMETER * np.sqrt(2 / 3))
        velocity = result.frame(2, "velocity")[result.rows(motion.ids)]
        assert np.array_equal(motion.velocity[2], velocity[:, 2])


def test_the_axis_of_a_load_from_the_side(tmp_path):
    """The line is a row of a square layer."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("square", (7, 5))))
    with Result(tmp_path) as result:
        (motion,) = line_motions(result, result.origin, np.array([1.0, 0.0, 0.0]))
        position = result["spheres/position"][result.rows(motion.ids)]
        assert len(motion.ids) == 7
        assert np.ptp(position[:, 1]) == 0


@pytest.mark.parametrize(("force", "tolerance"), [(None, 1e-9), (20.0, 0.01)])
def test_speed_of_a_chain_is_that_of_the_summary(tmp_path, force, tolerance):
    """Under a static load the front follows from the velocity on a line, and from the force
    elsewhere.
    """
    pressed = {"precompression": {"kind": "uniaxial", "force": force}} if force else {}
    case = synthetic.make_case(
        "chain",
        24,
        law="hertz",
        load={"velocity": 0.1},
        boundary={"bottom": "free"},
        run={"end_time": 4e-4, "frames": 3},
        output={"history": 800},
        **pressed,
    )
    run_case(case, tmp_path, figures=False)
    with Result(tmp_path) as result:
        (motion,) = line_motions(result, result.origin, DOWN)
        assert motion.front.speed == pytest.approx(wave_speed_of(result), rel=tolerance)
        used = motion.place >= motion.front.place[0]
        used &= np.isfinite(motion.arrival)
        late = motion.arrival[used] - motion.front.when(motion.place[used])
        assert np.abs(late).max() < 0.05 * synthetic.DIAMETER / motion.front.speed
