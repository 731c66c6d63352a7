"""Runs with and without walls at their end, and runs that cannot dissipate energy."""

from __future__ import annotations

import pytest

from granwave.workflows import load_case, run_case
from granwave.workflows.cli.compare import text_of
from tests.analysis.reports.comparison.runs import compared, in_one_line

CHAIN = {
    "packing.size": 20,
    "packing.diameter": 0.006,
    "material": "aluminium",
    "load.velocity": 0.4,
    "boundary.bottom": "wall",
}
RUNS = {
    "wall": {"contact.law": "hertz", "run.end_time": 2.8e-4},
    "free": {"contact.law": "hertz", "boundary.bottom": "free", "run.end_time": 6e-4},
    "yielding": {"contact.law": "elastoplastic", "run.end_time": 2.8e-4},
}
WITH_WALLS = "peak_force_with_walls_N"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("ends")
    for name, changes in RUNS.items():
        run_case(load_case("homogeneous-chain", CHAIN | changes), folder / name, figures=False)
    return folder


def test_forces_on_walls_of_some_runs_are_not_compared(folder):
    """The force on a rigid wall is twice the force between beads."""
    comparison = compared(folder, "wall", "free")
    assert comparison.without_ratio[WITH_WALLS] == "defined differently"
    assert "including walls" not in comparison.sentence
    assert any(
        "touches a wall, so that it has no ratio: free." in note for note in comparison.notes
    )
    asked = compared(folder, "wall", "free", quantities=[WITH_WALLS])
    assert "packings with and without walls define it differently" in in_one_line(text_of(asked))
    both = compared(folder, "wall", "yielding")
    assert WITH_WALLS not in both.without_ratio


def test_a_free_end_has_no_bottom(folder):
    comparison = compared(folder, "wall", "free")
    notes = " ".join(comparison.notes)
    assert "Not ranked by the force on the bottom, since there is no bottom: free." in notes
    assert "not recorded" not in notes


def test_an_elastic_chain_has_dissipated_nothing_at_any_end(folder):
    """Its zero is complete; the value of the chain that yields depends on its end."""
    comparison = compared(folder, "wall", "yielding", "free")
    for name in ("dissipated_fraction", "energy_dissipated_J"):
        assert [run.name for run in comparison.truncated[name]] == ["yielding"]
        assert comparison.without_ratio.get(name) != "truncated"
