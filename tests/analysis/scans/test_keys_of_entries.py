"""Keys of scans that are entries of lists, vectors along one axis, and run times that follow from others."""

from __future__ import annotations

import pytest

from granwave.analysis.scans.keys import key_of
from granwave.analysis.scans.table import physical


def test_vectors_along_one_axis_are_numbers():
    key = key_of("striker.2.velocity", ["[0.5, 0, 0]", "[2, 0, 0]", "[0, 0, 0]"])
    assert key.numeric and key.values == (0.5, 2.0, 0.0)
    assert key.naming.label == "Velocity of the striker along x" and key.naming.unit == "m/s"
    assert key.labels == ("[0.5, 0, 0]", "[2, 0, 0]", "[0, 0, 0]")  # tables of data keep them


@pytest.mark.parametrize("labels", [["[0, 0, 1]", "[0, 1, 0]"], ["[0, 0, 0]"], ["[0, 1]", "[0, 2]"], ["a", "b"]])
def test_other_vectors_are_words(labels):
    assert not key_of("striker.2.velocity", labels).numeric


def test_names_of_replaced_spheres():
    density = key_of("replace.1.material.density", [4000.0, 8000.0]).naming
    assert (density.label, density.unit) == ("Density of replaced spheres", "kg/m³")
    diameter = key_of("replace.2.diameter", [0.01, 0.02])
    assert diameter.naming.label == "Diameter of replaced spheres" and diameter.values == (10.0, 20.0)
    assert key_of("replace.1.index", [3, 4]).naming.label == "Place of replaced spheres"
    assert key_of("replace.first", [1]).naming.label == "replace.first"


def test_run_times_that_follow_are_left_out():
    times = {"run.end_time": [1e-3, 5e-4, 5e-4]}
    assert list(physical({"load.velocity": [1, 2, 3], **times})) == ["load.velocity"]
    assert list(physical({"load.velocity": [1, 2, 2], "run.end_time": [1, 2, 3]})) == ["load.velocity", "run.end_time"]
    assert list(physical(times)) == ["run.end_time"]
