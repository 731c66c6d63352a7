"""Comparisons of random packings: sets of replicates, their means, labels and figures."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from granwave.analysis.reports.comparison import replicates
from granwave.analysis.reports.comparison.compared_value import ComparedValue
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.comparison.figures.figure import (
    ComparisonFigure,
    FigureData,
    read_figure,
)
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.comparison.scatter import scatter_sentence
from granwave.analysis.reports.comparison.subjects import ComparedRun, compared_runs
from granwave.analysis.reports.comparison.values import shown_values

SCATTER = "packing.diameter_scatter"
SEED = "packing.seed"


class Kind:
    """Stand-in for the kind of a run of spheres."""

    result_kind = "run"
    of_spheres = True


def run_of(label: str, scatter: float, friction: float, seed: int, force: float) -> Any:
    """Return a stand-in for a run, with the force on its bottom."""
    case = {SCATTER: scatter, "contact.friction": friction, SEED: seed}
    return SimpleNamespace(
        label=label,
        case=case,
        kind=Kind,
        directory=scatter,
        summary={},
        number={"wall_peak_force_N": force}.get,
    )


@pytest.fixture
def runs(monkeypatch) -> list[ComparedRun]:
    """A regular packing and three replicates of two scatters, with two frictions."""
    monkeypatch.setattr(replicates, "has_random_packing", bool)
    found = []
    for friction in (0.0, 0.3):
        found.append((0.0, friction, 1, 1800 - 1000 * friction))
        found += [(5e-6, friction, seed, 1150 + 100 * seed) for seed in (1, 2, 3)]
        found += [(10e-6, friction, seed, 900 + 100 * seed) for seed in (1, 2, 3)]
    return compared_runs([run_of(f"scatter #{n}", *one) for n, one in enumerate(found, start=1)])


def test_replicates_differ_in_the_seed_only(runs):
    assert [run.set_number for run in runs] == [0, 1, 1, 1, 4, 4, 4, 7, 8, 8, 8, 11, 11, 11]
    assert [run.is_random for run in runs] == ([False] + 6 * [True]) * 2


def test_drawn_runs_have_distinct_labels_and_styles(runs):
    """One of each set is drawn, so that no two labels differ in their numbers only."""
    drawn = [run for run in runs if not run.is_repeated]
    texts = [run.label.partition(": ")[2] for run in drawn]
    assert [run.name for run in drawn] == [f"scatter #{n}" for n in (1, 2, 5, 8, 9, 12)]
    assert len(set(texts)) == len(texts) and not any("…" in text for text in texts)
    assert texts[-1] == "diameter scatter 10 µm, friction 0.3"
    assert sorted(run.look for run in drawn) == list(range(6))


def test_figures_leave_out_further_replicates(runs):
    data = read_figure(ComparisonFigure("A figure", lambda run: run.number, lambda *_: None), runs)
    assert list(data.present) == [run for run in runs if not run.is_repeated]
    assert set(data.lacking.values()) == {"one of each set of replicates is drawn"}


def test_means_of_replicates_are_stated_with_their_intervals(runs):
    """(1000, 1100, 1200) N have a standard deviation of 100 N: 4.303 * 100 / sqrt(3) = 248 N."""
    sentence = scatter_sentence(runs)
    assert "from 1.10 ± 0.25 kN (#5: diameter scatter 10 µm, seed 1, 3 replicates)" in sentence
    assert "to 1.8 kN (#1: " in sentence
    assert sentence.endswith("This difference exceeds their combined interval.")
    alike = scatter_sentence([run for run in runs if run.is_random])  # 1.10 and 1.35 kN
    assert alike.endswith("This difference is within their combined interval.")


def test_single_random_packings_are_named_as_such(runs):
    assert scatter_sentence([runs[0], runs[1]]) == ""  # a single random packing
    single = [run_of("a", 5e-6, 0, 1, 900.0), run_of("b", 10e-6, 0, 1, 800.0)]
    assert scatter_sentence(compared_runs(single)).startswith("Each random packing was run once")
    same = [run_of("a", 5e-6, 0, 1, 900.0), run_of("b", 5e-6, 0.3, 1, 800.0)]
    assert scatter_sentence(compared_runs(same)) == ""  # the same packing


def test_the_reason_for_no_figure_is_of_a_figure_that_is_drawn(runs):
    """No run has a record of its bottom; the last run is beyond those drawn."""
    comparison = Comparison(runs)
    without = FigureData({}, dict.fromkeys(runs, "the force on its bottom is not recorded"))
    for name in FIGURES:
        comparison._data[name] = without
    present = dict.fromkeys(runs[:-1], 1.0)
    comparison._data["energies"] = FigureData(present, {runs[-1]: "only 13 runs are drawn"})
    assert comparison._undrawn() == ["In no figure: scatter #14 (only 13 runs are drawn)."]


def test_equal_values_are_not_among_the_largest_differences():
    equal = ComparedValue("n_plastic_contacts", (1.0,) * 8, "Yielded contacts", "")
    other = ComparedValue("peak_force_N", (1.0,) * 7 + (2.0,), "Peak force", "N")
    assert shown_values([other, equal], 10, asked=False) == [other]
    assert shown_values([other, equal], 10, asked=True) == [other, equal]


def test_the_table_has_the_values_that_sentences_state():
    """The table shows the interpolated sizes of the zone, as the sentences do."""
    depth = ComparedValue("zone_depth_90_m", (2.0, 3.0), "90 % depth", "m")
    between = ComparedValue("zone_depth_90_interpolated_m", (1.8, 2.1), "interpolated", "m")
    others = [ComparedValue(f"value_{n}", (1.0, 9.0), "Other", "") for n in range(12)]
    values = [*others, depth, between]
    shown = shown_values(values, 10, asked=False, stated=[between.name, depth.name])
    assert shown == [*others[:9], between]
    assert shown_values([depth], 10, asked=False) == [depth]  # of results of 1.0
