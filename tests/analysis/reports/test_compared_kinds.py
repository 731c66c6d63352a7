"""Runs of different kinds side by side: listed keys, and one colour for each run."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from granwave.analysis.figures.series import COLOURS
from granwave.analysis.reports.comparison.curves import GrowthCurves
from granwave.analysis.reports.comparison.figures.axes import log_if_wide, run_styles
from granwave.analysis.reports.comparison.figures.fronts import speed_notes
from granwave.analysis.reports.comparison.figures.zone_growth import growth_notes
from granwave.analysis.reports.comparison.grain_ids import short_ids
from granwave.analysis.reports.comparison.subjects import (
    ComparedRun,
    by_reason,
    comparable_keys,
    compared_runs,
    spread_first,
)
from granwave.analysis.reports.inputs import read_inputs
from tests.helpers.made_up.synthetic_report import write_run


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
    drawn = run_styles([compared[0], compared[2]])
    assert [look["color"] for look in drawn.values()] == [COLOURS[0], COLOURS[2]]


def test_runs_are_distinguished_without_colours():
    """Six runs have six line styles; a solid line is never drawn over a broken line."""
    compared = [ComparedRun(run, f"run {n}", n, look=n) for n, run in enumerate(looks(12))]
    drawn = list(run_styles(compared).values())
    assert len({str(look["linestyle"]) for look in drawn[:6]}) == 6
    assert len({(look["color"], str(look["linestyle"])) for look in drawn}) == 12
    lowest = min(drawn, key=lambda look: look["zorder"])
    assert lowest["linestyle"] == "-"
    assert ":" not in [look["linestyle"] for look in drawn]


def looks(number):
    """Runs that differ in their names only."""
    return [SimpleNamespace(label=f"run {n}") for n in range(number)]


def test_equal_depths_and_missing_speeds_are_stated():
    """Runs of equal largest depths are named, and so are runs without a speed of the front."""
    speeds = (400.0, None, None)
    ran = [SimpleNamespace(label=f"r{n}", number=lambda _, v=v: v) for n, v in enumerate(speeds)]
    compared = [ComparedRun(run, run.label, n, look=n) for n, run in enumerate(ran)]
    depths = (0.03266, 0.03266, 0.0392)
    zones = {
        run: GrowthCurves(np.zeros(1), np.zeros(1), np.array([depth]))
        for run, depth in zip(compared, depths, strict=True)
    }
    note = growth_notes(zones)
    assert note == "Equal largest depths: 32.66 mm in r0, r1."
    text = speed_notes(dict.fromkeys(compared))
    assert "400 m/s (r0)" in text and text.endswith(
        "which requires nine layers that the wave reached: r1, r2."
    )


@pytest.mark.parametrize(("largest", "labels"), [(15.0, {"1", "2", "5", "10"}), (900.0, set())])
def test_labels_of_logarithmic_axes(largest, labels):
    """Within two decades they are plain numbers; no label has the form 2×10¹."""
    figure, axes = plt.subplots()
    axes.plot([0.0, 1.0], [1.0, largest])
    log_if_wide(axes)
    figure.draw_without_rendering()
    low, high = axes.get_ylim()
    ticks = zip(axes.yaxis.get_majorticklocs(), axes.yaxis.get_majorticklabels(), strict=True)
    shown = {text.get_text() for place, text in ticks if low <= place <= high}
    minor = {text.get_text() for text in axes.yaxis.get_minorticklabels()}
    plt.close(figure)
    assert labels <= shown
    assert minor <= {""}


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


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        ([4], "at 4"),
        ([3, 4, 5, 9], "at 3 to 5, 9"),
        (range(2, 21, 2), "every 2nd"),
        ([1, 3, 7, 12], "at 4 positions"),
    ],
)
def test_ids_in_a_label(ids, words):
    assert short_ids(ids) == words


def replaced(tmp_path, **entries):
    """Labels of synthetic runs with replaced grains, by their names."""
    directories = [write_run(tmp_path / name, figures=False) for name in entries]
    runs = [
        dataclasses.replace(run, case=run.case | {"replace": entries[run.label]})
        for run in read_inputs(directories, tmp_path).runs
    ]
    return [run.label for run in compared_runs(runs)]


def test_legends_name_replaced_grains(tmp_path):
    """A plain chain, a mix and a chain with a defect; entries that all runs have are left out."""
    mix = [{"index": {"first": 2, "last": 20, "step": 2}, "material": "aluminium"}]
    heavy = [{"index": [5], "material": "steel"}]
    large = [{"index": 10, "diameter": 0.015}]
    assert replaced(tmp_path / "a", plain=[], mix=mix, large=large) == [
        "plain: none replaced", "mix: aluminium every 2nd", "large: 15 mm at 10"
    ]  # fmt: skip
    both = replaced(tmp_path / "b", mix=mix, more=mix + heavy)
    assert both == ["mix: no others replaced", "more: steel at 5"]
    many = [{"index": n, "material": "stainless-steel-316"} for n in (3, 9)]
    labels = replaced(tmp_path / "c", a=[], b=many)
    assert labels[1] == "b: stainless-steel-316 at 3 and 1 more"
