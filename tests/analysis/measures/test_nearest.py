"""Nearest places: by comparison of all, and by a tree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from granwave.analysis.measures import geometry as module
from granwave.analysis.measures.geometry import nearest


@pytest.mark.parametrize("by_tree", [0, 10**9])
@pytest.mark.parametrize("n_places", [1, 3, 700])
def test_as_a_tree(monkeypatch, by_tree, n_places):
    monkeypatch.setattr(module, "_BY_TREE", by_tree)
    monkeypatch.setattr(module, "_BLOCK", 1000)  # several blocks
    generator = np.random.default_rng(5)
    points, places = generator.normal(size=(430, 3)), generator.normal(size=(n_places, 3))
    distance, row = nearest(points, places)
    expected, rows = cKDTree(places).query(points)
    assert distance == pytest.approx(expected, rel=1e-14) and np.array_equal(row, rows)


def test_of_equal_distances_the_first():
    """Struck spheres lie in symmetric groups: a sphere between them belongs to the first, with a tree or without."""
    _, row = nearest(np.zeros((2, 3)), np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]))
    assert row.tolist() == [0, 0]
