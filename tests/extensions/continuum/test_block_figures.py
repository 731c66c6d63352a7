"""Figures of a block show the event, however long the run continues after it."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.punch.figures import (
    ContinuumResult,
    plastic_strain,
    plastic_zone,
    punch,
    von_mises,
)
from granwave.extensions.continuum.punch.run import run_continuum
from granwave.extensions.continuum.punch.snapshots import (
    MOST,
    MOST_OF_EVENT,
    Snapshot,
    StressSnapshots,
)

YIELD = 550e6


def light_punch(directory, velocity):
    """Run of 0.3 ms after a contact of 5 us."""
    tables = {
        "name": "light",
        "material": "brass",
        "punch": {"mass": 0.00445, "velocity": velocity},
        "run": {"elements": 2000, "end_time": 3e-4},
    }
    run_continuum(ContinuumCase.from_dict(tables), directory, figures=False)
    return ContinuumResult(directory)


@pytest.fixture(scope="module")
def yielding(tmp_path_factory):
    return light_punch(tmp_path_factory.mktemp("yielding"), 20.0)


@pytest.fixture(scope="module")
def elastic(tmp_path_factory):
    return light_punch(tmp_path_factory.mktemp("elastic"), 1.0)


def test_snapshots_resolve_the_contact(yielding):
    times = yielding["fields/time"]
    contact = yielding["punch/time"][yielding["punch/force"] > 0]
    assert np.all(np.diff(times) > 0)
    assert np.count_nonzero(times <= contact[-1]) >= MOST_OF_EVENT // 2
    assert len(times) <= MOST + MOST_OF_EVENT + 3


def test_stress_is_drawn_at_the_largest_zone(yielding):
    drawing = von_mises(yielding)
    stress = np.asarray(drawing.columns["von_mises_Pa"])
    at_yield = stress >= 0.99 * YIELD
    volume = yielding["element_volume"][at_yield].sum()
    assert volume == pytest.approx(yielding.summary["plastic_zone_volume_m3"], rel=1e-9)
    (axes, *_) = drawing.figure.axes
    assert axes.get_title().endswith("largest plastic zone")


def test_stress_of_an_elastic_block_is_drawn_at_its_largest(elastic):
    drawing = von_mises(elastic)
    stress = elastic["fields/von_mises"]
    assert max(drawing.columns["von_mises_Pa"]) == stress.max() > 0
    (axes, *_) = drawing.figure.axes
    assert axes.get_title().endswith("largest stress")


def test_zone_is_drawn_while_it_grows(yielding):
    """Panels differ, begin at the first yield, and end with a zone at rest."""
    drawing = plastic_zone(yielding)
    states = [
        np.asarray(column) for name, column in drawing.columns.items() if name.startswith("state_")
    ]
    assert len(states) >= 4
    yielded = [np.count_nonzero(state) for state in states]
    assert yielded[0] > 0
    assert yielded == sorted(yielded)
    assert yielded[-1] == np.count_nonzero(yielding["fields/ever_yielded"])
    assert not np.any(states[-1] == 2)
    # the zone of a few elements fills a part of its panel
    (axes, *_) = drawing.figure.axes
    left, right = axes.get_xlim()
    zone = yielding.summary["plastic_zone_depth_m"] * 1e3
    assert abs(right - left) < 10 * zone


def test_nothing_is_drawn_of_a_zone_that_is_none(elastic):
    assert plastic_zone(elastic) is None
    assert plastic_strain(elastic) is None


def test_axis_of_the_punch_is_that_of_the_contact(yielding):
    drawing = punch(yielding)
    upper, *_ = drawing.figure.axes
    contact = 1e6 * yielding["punch/time"][yielding["punch/force"] > 0][-1]
    line = upper.lines[0].get_xdata()
    assert contact < max(line) < 2 * contact
    assert "300 µs" in upper.get_title()
    assert len(drawing.columns["time_s"]) == len(yielding["punch/time"])


def test_number_of_snapshots_is_limited():
    snapshots = StressSnapshots(1.0)
    for n in range(1000):
        snapshot = Snapshot(float(n), np.zeros(1, np.float32))
        if snapshots.is_due(snapshot.time):
            snapshots.add(snapshot)
        snapshots.add_to_event(snapshot, 1.0 if n == 333 else 0.5)
    times = [snapshot.time for snapshot in snapshots.in_order]
    assert times == sorted(set(times))
    assert 333.0 in times
    assert MOST_OF_EVENT / 2 < len(times) <= MOST + MOST_OF_EVENT + 1
