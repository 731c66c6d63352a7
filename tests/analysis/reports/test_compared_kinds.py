"""Runs of different kinds side by side: listed keys, and one colour for each run."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from granwave.analysis.figures.series import COLOURS
from granwave.analysis.reports.comparison.figures import _styles
from granwave.analysis.reports.comparison.subjects import (
    ComparedRun,
    by_reason,
    comparable_keys,
    spread_first,
)


def runs():
    """Two packings and a block, of the same material."""
    cases = (
        ("spheres", {"material.name": "brass", "packing.kind": "fcc", "contact.friction": 0}),
        ("spheres", {"material.name": "brass", "packing.kind": "hcp", "contact.friction": 0}),
        ("block", {"material.name": "steel", "mesh.size": 1}),
    )
    return [SimpleNamespace(kind=kind, case=case) for kind, case in cases]


def test_keys_of_all_kinds_and_those_that_differ_within_a_kind():
    """The lattices of two packings are listed together with a block; keys of a single kind are
    not.
    """
    keys = ["material.name", "packing.kind", "contact.friction", "mesh.size"]
    assert comparable_keys(keys, runs()) == ["material.name", "packing.kind"]


def test_a_run_has_one_colour_in_all_figures():
    """A figure without the second run does not change the colour of the third."""
    compared = [ComparedRun(run, f"run {n}", n, look=n) for n, run in enumerate(runs())]
    drawn = _styles([compared[0], compared[2]])
    assert [look["color"] for look in drawn.values()] == [COLOURS[0], COLOURS[2]]


def test_runs_beyond_those_drawn_are_spread_evenly():
    """The first and the last run are drawn, and each drawn run has a distinct style."""
    places = spread_first(24, 12)
    assert sorted(places) == list(range(24))
    assert min(places[:12]) == 0
    assert max(places[:12]) == 23
    assert np.diff(sorted(places[:12])).max() <= 3
    assert spread_first(3, 12) == [0, 1, 2]


def test_runs_are_listed_by_the_reason():
    """Each reason is stated once; consecutive runs are written as a range."""
    names = [SimpleNamespace(label=f"a #{n}") for n in range(5)]
    compared = [ComparedRun(run, run.label, n, look=n) for n, run in enumerate(names)]
    lacking = {run: "few rows" for run in compared[:3]} | {compared[4]: "a block"}
    assert by_reason(lacking) == "a #0 to a #2 (few rows); a #4 (a block)"
