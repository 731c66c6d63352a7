"""Chains whose run ends between two pulses on the bottom, and before the plastic zone is
complete.
"""

from __future__ import annotations

import re

import pytest

from granwave.analysis.measures.target_record import rising_force_warning
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.comparison.ends import growing_names
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import run_case
from tests.analysis.reports.comparison.runs import compared

pytestmark = pytest.mark.xdist_group("ends between pulses")  # its fixture is made once

ENDS = {"start": 6e-4, "gap": 1.14e-3, "later": 1.16e-3, "full": 1.5e-3, "long": 4e-3}
BEADS = {"s": "stainless-steel-316", "b": "brass"}
CHAIN = {
    "packing": {"kind": "chain", "size": 40, "diameter": 0.00952},
    "load": {"velocity": 1},
}


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Chains of two materials, whose pulses reach the bottom at about 1.1 and 1.3 ms."""
    folder = tmp_path_factory.mktemp("pulses")
    for name, end in ENDS.items():
        for letter, material in BEADS.items():
            table = CHAIN | {"material": material, "run": {"end_time": end}}
            run_case(case_from_dict(table), folder / f"{letter}-{name}", figures=False)
    return folder


@pytest.mark.parametrize("name", ["gap", "later"])
def test_a_chain_is_not_ranked_before_most_of_the_momentum_has_arrived(place, name):
    """The second pulse on the bottom of brass beads is 1.5 times as large as the first one."""
    comparison = compared(place, f"s-{name}", f"b-{name}")
    assert not any("bottom" in text for text in comparison.paragraphs)
    (note,) = [note for note in comparison.notes if "a later pulse may be larger" in note]
    assert "of the impact's momentum has reached the bottom" in note and f"b-{name}" in note
    assert comparison.without_ratio["wall_peak_force_N"] == "truncated"
    (run, *_) = comparison.runs[1:]
    words = "only 1[56] % of the impact's momentum has reached the bottom by the end of the run"
    assert re.search(words, in_words(run.run))
    assert "Increase run.end_time" in rising_force_warning(place / f"b-{name}")


def test_the_order_of_complete_runs_is_the_same_at_later_ends(place):
    for name in ("full", "long"):
        comparison = compared(place, f"s-{name}", f"b-{name}")
        assert f"in s-{name}, compared with" in comparison.protection[0]
        assert not any("later pulse" in note for note in comparison.notes)
        assert rising_force_warning(place / f"b-{name}") == ""


def test_an_impulse_that_still_grows_has_no_ratio(place):
    """At 1.5 ms the order of the impulses is the opposite of their order at the end."""
    early = compared(place, "s-full", "b-full")
    assert early.without_ratio["wall_impulse_Ns"] == "still growing"
    assert "impulse" not in early.sentence
    assert early.table.loc["wall_impulse_Ns", ["s-full", "b-full"]].is_monotonic_decreasing
    final = compared(place, "s-long", "b-long").table.loc["wall_impulse_Ns"]
    assert final["ratio"] > 1.1


def test_a_growing_zone_has_no_sizes_and_no_counts(place):
    """Volume and depth of the zone of a chain are the same measure."""
    comparison = compared(place, "s-start", "b-start")
    names = ("zone_volume_90_m3", "zone_depth_90_interpolated_m", "n_plastic_contacts")
    assert {comparison.without_ratio[name] for name in names} == {"still growing"}
    assert "zone" not in comparison.sentence and "yielded" not in comparison.sentence
    assert growing_names(names, compared(place, "s-long", "b-long").runs) == set()
