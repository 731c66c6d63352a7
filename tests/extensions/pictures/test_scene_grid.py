"""Grid of the page of a run: k3d counts its numbers from the lower corner."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from granwave.extensions.pictures.view import scene
from granwave.extensions.pictures.view.scene import round_grid


@pytest.mark.parametrize(
    ("size", "steps"),
    [((70.0, 64.0, 41.0), (10, 10, 10)), ((690.0, 620.0, 230.0), (100, 100, 100)),
     ((9.3, 3.0, 0.0), (1, 1, 0.2)), ((95.0, 90.0, 12.0), (20, 20, 20))],
)  # fmt: skip
def test_numbers_along_the_axes_are_round(size, steps):
    place = np.array([[-0.43, -0.51, 0.0], [0.57, 0.49, 1.0]]) * np.array(size)
    margin = 0.5 if max(size) < 10 else 5.0
    grid = round_grid(place, margin)
    low = grid[:3]
    high = grid[3:]
    assert (low <= place.min(axis=0) - margin).all()
    np.testing.assert_allclose(high, place.max(axis=0) + margin)
    places = low / np.array(steps)
    np.testing.assert_allclose(places, places.round(), atol=1e-9)


def test_the_camera_sees_the_grid_of_a_packing():
    """A sphere around the grid is within the field of view, which is centred on it."""
    grid = np.array([-70.0, -60.0, -10.0, 80.0, 60.0, 70.0])
    places = np.array([[-65.0, -55.0, -5.0], [75.0, 55.0, 65.0]])
    case = SimpleNamespace(packing=SimpleNamespace(rule=SimpleNamespace(is_chain=False)))
    camera = np.array(scene._camera(SimpleNamespace(case=case), places, grid))
    distance = np.linalg.norm(camera[:3] - camera[3:6])
    assert camera[3:6] == pytest.approx((grid[:3] + grid[3:]) / 2)
    reach = distance * math.sin(math.radians(scene._FIELD_OF_VIEW / 2))
    assert reach > np.linalg.norm(grid[3:] - grid[:3]) / 2
