"""Checks of the best design, and their findings."""

from __future__ import annotations

import pytest

from granwave.extensions.design.report import limit_in_heading, range_under_checks, ranking_of
from granwave.extensions.design.search.guards import (
    changes_of,
    finding_of,
    findings_without_runs,
    further_runs,
    has_come,
    has_passed,
    late_impulse,
)
from granwave.extensions.design.search.problem import DesignLimit
from granwave.extensions.design.search.study import Design
from tests.extensions.design.chain_search import problem_of

pytest.importorskip("sklearn")
pytestmark = pytest.mark.xdist_group("design")  # its results are shared


def test_guards_change_one_thing():
    tables = {
        "packing": {"kind": "fcc", "size": [8, 8, 5], "diameter": 0.01},
        "boundary": {"bottom": {"plate": {"stiffness": 1e6}}},
        "run": {"end_time": 1e-3},
    }
    assert {name: changes for name, _, changes in changes_of(tables, random=False)} == {
        "wider": {"packing.size": [12, 12, 5]},
        "longer": {"run.end_time": pytest.approx(1.5e-3)},
        "finer": {"run.energy_tolerance": pytest.approx(1.5e-6)},
        "tolerance": {"packing.diameter_scatter": pytest.approx(5e-6)},
        "stiffer": {"boundary.bottom.plate.stiffness": 4e6},
    }


def test_what_the_run_of_the_best_tells(folder, tmp_path):
    """Overlaps beyond the law, beads that fly away, an impulse that has not ended, and an end of a
    range are reported.
    """
    import h5py
    import numpy as np

    ranges = {"packing.diameter": {"low": 0.004, "high": 0.012}}
    problem = problem_of(
        folder, base="fcc-small", variables=ranges, set={"packing.size": [4, 4, 4]}
    )
    time_ = np.linspace(0.0, 1.0, 101)
    still = np.ones(101)
    past = np.exp(-(((time_ - 0.3) / 0.1) ** 2))
    bad = (5, 1.0, 0.5, still, 0.012, "not fallen")
    good = (0, 1.0, 0.1, past, 0.008, "")

    def warned(beyond, given, kinetic, force, diameter, note):
        with h5py.File(tmp_path / "result.h5", "w") as file:
            file["walls/bottom/time"] = time_
            file["walls/bottom/force"] = force
        summary = {
            "contacts_beyond_law": beyond,
            "energy_input_J": given,
            "energy_kinetic_J": kinetic,
        }
        best = Design(1, {"packing.diameter": diameter}, "complete", runs={"1": {"note": note}})
        return {
            one.name
            for one in findings_without_runs(problem, best, summary, tmp_path)
            if one.warning
        }

    assert warned(*good) == set()
    names = ("law", "", "flight", "impulse", "edge", "end")
    for place, name in enumerate(names):
        if name:
            assert warned(*(bad[n] if n == place else good[n] for n in range(6))) == {name}


def test_what_changes_by_more_than_five_per_cent_is_said_first(folder):
    problem = problem_of(folder, limits={"wall_impulse_Ns": 1.0})
    before = {"target_peak_force_N": 100.0, "wall_impulse_Ns": 0.9}
    for force, impulse, warning, text in (
        (104.0, 0.9, False, "peak force on the target 104 N (+4.0 %)"),
        (94.0, 0.9, True, "94 N (-6.0 %)"),
        (100.001, 0.9, False, "100 N (unchanged)"),
        (100.04, 0.9, False, "100 N (unchanged)"),  # the value of the best design
        (101.0, 1.1, True, "beyond a limit: wall_impulse_Ns 1.1, at most 1"),
        (None, 0.9, True, "no value"),
    ):
        after = {"target_peak_force_N": force, "wall_impulse_Ns": impulse}
        found = finding_of("wider", "a wider packing", problem, before, after)
        assert (found.warning, text in found.text) == (warning, True)


def test_luck_is_another_seed_of_what_is_random_and_a_tolerance_of_what_is_not(folder):
    variables = {"load.velocity": [1.0, 2.0]}
    base = {"base": "fcc-small", "variables": variables, "set": {"packing.size": [4, 4, 4]}}
    best = Design(1, {"load.velocity": 1.0}, "complete")
    plain = {name for name, *_ in further_runs(problem_of(folder, **base), best, 1)}
    random = problem_of(folder, **base, uncertainty={"tolerance": 5e-6, "replicates": 2})
    assert plain == {"wider", "longer", "finer", "tolerance"}
    assert {name for name, *_ in further_runs(random, best, 1)} == {
        "wider",
        "longer",
        "finer",
        "seed",
    }


def test_passed_forces_and_late_impulses():
    import numpy as np

    time_ = np.linspace(0.0, 1.0, 1001)
    pulse = np.exp(-(((time_ - 0.5) / 0.1) ** 2))
    assert has_passed(pulse)
    assert not has_passed(pulse[:550])
    assert has_come(pulse[:550])
    assert not has_come(pulse[:450])
    assert not has_come(np.zeros(5))
    assert late_impulse(time_, np.ones_like(time_)) == pytest.approx(0.1, rel=0.02)


def test_range_under_checks_is_of_further_runs_of_the_best_design():
    """Neighbours are different designs; if a further run gives no change, the value remains at the
    end of its range.
    """
    changes = {"wider": -0.61, "longer": 0.0, "stiffer": 1.29, "neighbour-1": 7.0, "moved": -0.9}
    name = "target_peak_force_N"
    guards = [{"name": check, "changes": {name: change}} for check, change in changes.items()]
    best = {"objective": {name: 100.0}, "guards": [*guards, {"name": "flight", "changes": {}}]}
    assert range_under_checks(best, name) == "39 N to 229 N in its checks"
    several = range_under_checks(best | {"runs": 3}, name)
    assert several == "changed by -61 % to +129 % in its checks"
    assert range_under_checks(best | {"guards": guards[3:]}, name) == ""


@pytest.mark.parametrize(
    ("statistic", "runs", "words"),
    [
        ("mean", 1, "ranked by one run each"),
        ("mean", 3, "by the mean of 3 runs"),
        ("worst", 5, "by the worst of 5 runs"),
        (0.9, 10, "by the 0.9 quantile of 10 runs"),
    ],
)
def test_the_report_says_by_what_designs_are_ranked(statistic, runs, words):
    best = {"runs": runs} if runs > 1 else {}
    assert words in ranking_of({"statistic": statistic, "best": best})
    assert ranking_of({"best": best}) == ""


def test_limits_in_headings_have_their_unit():
    """The values below a heading may be in mm, and the limit in m."""
    assert limit_in_heading("height_m", {"high": 0.05}) == ", at most 50 mm"
    assert (
        limit_in_heading("mass_kg", {"low": 0.1, "high": 0.5})
        == ", at least 0.1 kg, at most 0.5 kg"
    )
    assert limit_in_heading("height_m", {}) == ""


def test_a_value_that_equals_a_limit_is_within_it():
    """Five layers of 8 mm are 0.04000000000000001 m high."""
    height = DesignLimit("height_m", None, 0.04)
    assert height.fault(5 * 0.008 * (1 + 2e-16)) == ""
    assert height.margin(5 * 0.008 * (1 + 2e-16)) == 0.0
    assert height.fault(0.041) == "height_m 0.041, at most 0.04"
    assert height.margin(0.041) == pytest.approx(0.025)
    fraction = DesignLimit("dissipated_fraction", 0.5, None)
    assert fraction.fault(0.5 - 1e-12) == ""
    assert fraction.fault(0.4) == "dissipated_fraction 0.4, at least 0.5"
    assert DesignLimit("n_spheres", None, None).margin(5.0) == 0.0
