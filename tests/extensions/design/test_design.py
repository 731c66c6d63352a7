"""Searches from a file to the best design: results, resumption, refusals, two objectives,
uncertainty, Python.
"""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tomllib

import pytest
import tomli_w
from jsonschema import Draft202012Validator

import granwave as gw
from granwave.extensions.design.search.design_file import load_problem
from granwave.extensions.design.search.driver import _Search
from granwave.extensions.design.search.guards import (
    changes_of,
    finding_of,
    findings_without_runs,
    further_runs,
    has_come,
    has_passed,
    late_impulse,
    of_neighbours,
    target_force,
)
from granwave.extensions.design.search.problem import with_values
from granwave.extensions.design.search.study import Design, DesignStudy, first_design, new_design
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.cli.json_schema import schema_of
from tests.conftest import PLAIN
from tests.helpers.slurm_cluster import slurm  # noqa: F401

pytest.importorskip("sklearn")
pytestmark = pytest.mark.xdist_group("design")  # its results are shared

CHAIN = """
name = "chain"
material = "stainless-steel"
[packing]
kind = "chain"
size = 3
diameter = 0.010
[load]
velocity = 2.0
[contact]
law = "hertz"
[run]
end_time = 6e-5
frames = 2
"""
MATERIALS = ["stainless-steel", "ptfe"]
TABLES = {
    "base": "chain.toml",
    "variables": {f"replace.{n}.material": MATERIALS for n in (1, 2, 3)},
    "objective": {"minimise": ["target_peak_force_N"]},
    "search": {"evaluations": 8, "seed": 2},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("design")
    (found / "chain.toml").write_text(CHAIN)
    (found / "beads.toml").write_text(tomli_w.dumps(TABLES))
    return found


@pytest.fixture(scope="module")
def searched(folder):
    """All eight chains of three beads, by the command line, one at a time."""
    command = [
        sys.executable,
        "-m",
        "granwave.workflows",
        "design",
        "beads.toml",
        "-o",
        "all",
        "--jobs",
        "1",
    ]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=600, env=PLAIN, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder / "all", done.stdout


def rows_of(directory):
    with (directory / "designs.csv").open() as file:
        return list(csv.DictReader(file))


def problem_of(folder, **changes):
    return load_problem({**TABLES, "base": str(folder / "chain.toml"), **changes})


def test_a_design_without_variables_does_not_fit_the_schema():
    assert not Draft202012Validator(schema_of("design")).is_valid({"base": "fcc-small"})


def test_all_designs_of_a_small_space(searched):
    directory, text = searched
    rows = rows_of(directory)
    assert len({tuple(row[f"replace.{n}.material"] for n in (1, 2, 3)) for row in rows}) == 8
    assert {row["state"] for row in rows} == {"complete"}
    forces = [float(row["target_peak_force_N"]) for row in rows]
    for row, force in zip(rows, forces, strict=True):
        summary = json.loads((directory / row["directory"] / "summary.json").read_text())
        assert force == summary["target_peak_force_N"] == summary["wall_peak_force_N"]
        assert float(row["mass_kg"]) == pytest.approx(summary["packing_mass_kg"], rel=1e-12)
        assert float(row["height_m"]) == pytest.approx(summary["packing_height_m"], rel=1e-9)
    found = json.loads((directory / "design.json").read_text())
    assert found["best"]["objective"]["target_peak_force_N"] == min(forces)
    assert found["evaluations"] == 8
    assert f"{min(forces):.5g}" in text
    for name in ("design.json", "study.json"):
        assert json.loads((directory / name).read_text())["versions"]["granwave"] == gw.__version__


def test_a_run_ends_after_the_peak(searched):
    """A run goes on where the force has not fallen to a tenth at the end of the file's time."""
    directory, _ = searched
    runs = [gw.load(directory / row["directory"]) for row in rows_of(directory)]
    assert all(has_passed(target_force(run.directory)[1]) for run in runs)
    assert max(run["end_time_s"] for run in runs) > 1e-4  # of 6e-5


def test_cases_of_the_best(searched, tmp_path):
    directory, _ = searched
    tables = tomllib.loads((directory / "best-1.toml").read_text())
    run = gw.run(tables, directory=tmp_path / "again", progress=False)
    best = json.loads((directory / "design.json").read_text())["best"]
    assert run["target_peak_force_N"] == best["objective"]["target_peak_force_N"]
    assert (directory / "best-8.toml").exists()
    assert not (directory / "best-9.toml").exists()


def test_checks_of_the_best(searched):
    directory, _ = searched
    guards = {
        one["name"]: one
        for one in json.loads((directory / "design.json").read_text())["best"]["guards"]
    }
    assert {"flight", "impulse", "longer", "finer", "tolerance", "neighbour-1"} <= set(guards)
    assert abs(guards["finer"]["changes"]["target_peak_force_N"]) < 1e-4
    assert not guards["longer"]["warning"]
    assert not guards["neighbour-1"]["warning"]  # all were tried
    page = (directory / "report.html").read_text()
    assert "Checks of the best" in page
    assert 'alt="Objective of each design' in page


def test_results_are_not_replaced(searched, granwave):
    directory, _ = searched
    done = granwave("design", "beads.toml", "-o", "all", cwd=directory.parent)
    assert done.returncode == 2
    assert "already holds results" in done.stderr
    done = granwave("run", "chain.toml", "-o", "all", cwd=directory.parent)
    assert done.returncode == 2
    assert "holds a search for a design" in done.stderr


@pytest.mark.validation
def test_a_killed_search_goes_on_to_the_same_designs(searched, folder):
    directory, _ = searched
    command = [
        sys.executable,
        "-m",
        "granwave.workflows",
        "design",
        "beads.toml",
        "-o",
        "killed",
        "--jobs",
        "1",
    ]
    killed = subprocess.Popen(
        command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=PLAIN
    )
    begin = time.monotonic()
    while not (folder / "killed/points/3/run.json").exists() and time.monotonic() < begin + 60:
        time.sleep(0.02)
    os.kill(killed.pid, signal.SIGKILL)
    killed.wait()
    assert len(rows_of(folder / "killed")) < 8
    done = subprocess.run(
        [*command, "--resume"], cwd=folder, capture_output=True, text=True, env=PLAIN, check=False
    )
    assert done.returncode == 0, done.stderr
    assert (folder / "killed/designs.csv").read_text() == (directory / "designs.csv").read_text()


@pytest.mark.validation
def test_ctrl_c_stops_a_search_that_goes_on_later(folder):
    search = {"evaluations": 4, "seed": 2, "guards": False}
    (folder / "few.toml").write_text(tomli_w.dumps(TABLES | {"search": search}))
    command = [sys.executable, "-m", "granwave.workflows", "design", "few.toml", "-o", "stopped"]
    stopped = subprocess.Popen(
        command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=PLAIN
    )
    begin = time.monotonic()
    while not (folder / "stopped/points/2").exists() and time.monotonic() < begin + 60:
        time.sleep(0.02)
    stopped.send_signal(signal.SIGINT)
    _, text = stopped.communicate(timeout=60)
    assert stopped.returncode == 130
    assert "--resume goes on" in text
    found = gw.design(
        folder / "few.toml", directory=folder / "stopped", resume=True, progress=False
    )
    assert len(found.table) >= 4


def test_what_differs_or_is_damaged_does_not_go_on(searched, folder):
    directory, _ = searched
    kept = (directory / "study.json").read_text()
    changed = {**problem_of(folder).tables, "name": "beads", "base": str(folder / "faster.toml")}
    (folder / "faster.toml").write_text(CHAIN.replace("velocity = 2.0", "velocity = 8.0"))
    other = {
        **TABLES,
        "base": str(folder / "chain.toml"),
        "name": "beads",
        "objective": {"minimise": ["wall_impulse_Ns"]},
    }
    for tables, differs in (
        (changed, r"base\.load\.velocity was 2\.0, is 8\.0"),
        (other, r"objective\.minimise was"),
    ):
        with pytest.raises(InputError, match=differs):
            gw.design(tables, directory=directory, resume=True)
    for text in ("garbage", "[1]", "{}", '{"problem": {}, "designs": [{"number": 1}]}'):
        (directory / "study.json").write_text(text)
        with pytest.raises(InputError, match="is damaged"):
            gw.design(folder / "beads.toml", directory=directory, resume=True)
    (directory / "study.json").write_text(kept)


def test_runs_that_are_gone_are_made_again(searched, folder):
    directory, _ = searched
    copy = shutil.copytree(directory, folder / "gone")
    before = (copy / "designs.csv").read_text()
    shutil.rmtree(copy / "points/3")
    gw.design(folder / "beads.toml", directory=copy, resume=True, progress=False)
    assert (copy / "designs.csv").read_text() == before
    assert (copy / "points/3/summary.json").exists()


def test_values_that_are_no_numbers_fail(folder):
    tables = {**problem_of(folder).tables, "objective": {"minimise": ["plastic_zone_depth_m"]}}
    tables |= {"search": {"evaluations": 2, "guards": False}}
    found = gw.design(tables, directory=folder / "words", progress=False)
    assert found.best is None
    assert set(found.table["reason"]) == {
        "plastic_zone_depth_m: null in summary.json, expected a number"
    }


def test_far_worse_designs_are_not_run_further(folder):
    """Designs are compared in the same runs: one that is better throughout is not lost for its fast
    first blow.
    """
    problem = problem_of(folder, uncertainty={"velocity": [0.5, 10.0], "replicates": 2})
    best = Design(1, {}, "complete", objectives={"target_peak_force_N": 50.0})
    best.runs = {
        "1-1": {"value": {"target_peak_force_N": 90.0}},
        "1-2": {"value": {"target_peak_force_N": 10.0}},
    }
    search = _Search(
        DesignStudy(problem, folder, [best]),
        ResultDirectory(folder),
        1,
        1,
        Interrupts(),
        show=False,
    )
    for force, lost in ((95.0, False), (200.0, True)):
        design = Design(2, {}, runs={"2-1": {"value": {"target_peak_force_N": force}}})
        assert search._is_lost(design) == lost


@pytest.mark.validation
def test_the_best_are_run_again_in_full_and_their_neighbours_too(folder):
    """A search of few, coarse runs: the ranking and the case of the best are of full ones, in the
    same directories.
    """
    tables = {
        **problem_of(folder).tables,
        "search": {"evaluations": 4, "seed": 3, "tolerance": 3e-5},
    }
    found = gw.design(tables, directory=folder / "coarse", jobs=1, progress=False)
    content = json.loads((folder / "coarse/study.json").read_text())["designs"]
    ran = [one for one in content if one["runs"]]
    in_full = {one["number"] for one in ran if one["full"]}
    ranked = sorted(ran, key=lambda one: one["objectives"]["target_peak_force_N"])
    assert {one["number"] for one in ranked[:3]} <= in_full
    assert len([one for one in ran if not one["next_to"]]) == found.outcome["evaluations"] == 4
    for one in ran:
        case = tomllib.loads((folder / f"coarse/points/{one['number']}/case.toml").read_text())
        assert case["run"].get("energy_tolerance", 3e-6) == (3e-6 if one["full"] else 3e-5)
    best = found.outcome["best"]
    tried = {tuple(one["values"].values()) for one in ran}
    for n in range(3):  # nothing next to the best is untried
        values = list(best["variables"].values())
        values[n] = next(one for one in MATERIALS if one != values[n])
        assert tuple(values) in tried
    assert best["number"] == ranked[0]["number"]
    before = (folder / "coarse/designs.csv").read_text()
    gw.design(tables, directory=folder / "coarse", jobs=1, resume=True, progress=False)
    assert (
        folder / "coarse/designs.csv"
    ).read_text() == before  # nothing more is found at another start


def test_moves_to_better_neighbours_are_said(folder):
    problem = problem_of(folder)
    values = {f"replace.{n}.material": "ptfe" for n in (1, 2, 3)}
    first = Design(1, values, "complete", objectives={"target_peak_force_N": 50.0})
    moved = {**values, "replace.2.material": "stainless-steel"}
    best = Design(2, moved, "complete", objectives={"target_peak_force_N": 40.0}, next_to=1)
    found = {one.name: one for one in of_neighbours(problem, best, [first, best])}
    assert found["moved"].warning
    assert "50 of design 1 became 40" in found["moved"].text
    assert "+25.0 %" in found["neighbour-2"].text
    assert found["neighbours"].text.startswith("next to the best, 2 not run that may be better")


def test_a_slow_packing_is_searched_with_a_coarse_tolerance(folder):
    assert problem_of(folder).tolerance == 0
    slow = {"packing": {"kind": "fcc", "size": [24, 24, 12]}, "run": {"end_time": 1e-3}}
    assert problem_of(folder, set=slow, variables={"load.velocity": [1.0, 2.0]}).tolerance == 3e-5
    problem = problem_of(folder, search={"tolerance": 1e-4})
    tables = problem.tables_of({f"replace.{n}.material": "ptfe" for n in (1, 2, 3)})
    assert problem.cheaply(tables)["run"]["energy_tolerance"] == 1e-4
    for run in ({"timestep": 1e-8}, {"energy_tolerance": 2e-4}):
        assert problem.cheaply({**tables, "run": run})["run"] == run


def test_what_is_refused_alone_is_warned_of_once(folder, caplog):
    packing = {"kind": "fcc", "size": [4, 4, 3], "diameter": 0.01}
    base = {"material": "steel", "packing": packing, "contact": {"law": "elastoplastic"}}
    problem_of(folder, set=base, variables={"layers": {"materials": ["steel", "ptfe"]}})
    (warned,) = [one for one in caplog.messages if "alone is refused" in one]
    assert (
        "replace.1-16.material and 2 more" in warned
        and '{preset = "ptfe", yield_strength = (Pa)}' in warned
    )
    problem_of(folder, variables={"material": ["steel", "aluminum"]})
    assert "did you mean aluminium" in caplog.text


def test_uncertainty_is_averaged(folder):
    tables = {**problem_of(folder).tables, "uncertainty": {"velocity": [1.0, 3.0], "replicates": 2}}
    tables |= {
        "variables": {"replace.1.material": MATERIALS},
        "search": {"evaluations": 2, "guards": False},
    }
    found = gw.design(tables, directory=folder / "mean", progress=False)
    assert set(found.table["state"]) <= {"complete", "pruned"}
    for _, row in found.table[found.table["state"] == "complete"].iterrows():
        low = row["target_peak_force_N_low"]
        high = row["target_peak_force_N_high"]
        assert row["target_peak_force_N"] == pytest.approx((low + high) / 2) and low < high
    cases = [
        tomllib.loads((path / "case.toml").read_text())
        for path in (folder / "mean/points").glob("1-*")
    ]
    assert sorted(case["load"]["velocity"] for case in cases) == [
        1.5,
        2.5,
    ]  # the middles of two halves
    for statistic, value in (("worst", 5.0), (0.5, 2.0)):
        problem = problem_of(folder, uncertainty={"statistic": statistic, "velocity": [1.0, 3.0]})
        assert problem.statistic_of(problem.objectives[0], [1.0, 5.0, 2.0]) == value


def test_limits_after_a_run(folder):
    tables = {
        **problem_of(folder).tables,
        "limits": {"wall_impulse_Ns": 1e-9, "overlap_over_radius": 0.5},
    }
    tables["search"] = {"evaluations": 2, "guards": False}
    found = gw.design(tables, directory=folder / "impossible", progress=False)
    assert found.best is None
    assert set(found.table["state"]) == {"refused"}
    assert "wall_impulse_Ns" in found.table["reason"][0]


PTFE = {"index": 7, "material": "ptfe"}


@pytest.mark.parametrize(
    ("entry", "values", "expected"),
    [
        ({"index": 5, "diameter": 0.01}, {"replace.5.material": "ptfe", "replace.7.material": "ptfe"},
         [{"index": 5, "diameter": 0.01, "material": "ptfe"}, PTFE]),
        # the diameter stays
        ({"index": {"first": 1, "last": 3}, "diameter": 0.009}, {"replace.2.material": "ptfe"},
         [{"index": {"first": 1, "last": 3}, "diameter": 0.009}, {"index": 2, "diameter": 0.009, "material": "ptfe"}]),
        ({"index": {"first": 3, "last": 5}, "diameter": 0.2}, {"replace.1-4.material": "ptfe"},
         [{"index": {"first": 3, "last": 5}, "diameter": 0.2}, {"index": {"first": 1, "last": 2}, "material": "ptfe"},
          {"index": {"first": 3, "last": 4}, "diameter": 0.2, "material": "ptfe"}]),
        (PTFE, {"replace.7.index": 3, "replace.7.diameter": 0.1}, [{"index": 3, "material": "ptfe", "diameter": 0.1}]),
    ],
)  # fmt: skip
def test_values_go_into_lists_and_grains(entry, values, expected):
    base = {"packing": {"size": [4, 4, 5]}, "material": "steel", "replace": [entry]}
    before = json.dumps(base)
    made = with_values(base, {"packing.size.2": 9, **values})
    assert made["packing"]["size"] == [4, 4, 9] and made["replace"] == expected
    assert json.dumps(base) == before


def test_keys_without_quotes(folder):
    nested = {
        "packing": {"diameter": [0.01]},
        "boundary": {"bottom": {"plate": {"mass": {"low": 1.0, "high": 2.0}}}},
    }
    base = {"boundary.bottom": {"plate": {"mass": 1.0, "stiffness": 1e6}}}
    keys = [one.key for one in problem_of(folder, variables=nested, set=base).space.variables]
    assert keys == ["packing.diameter", "boundary.bottom.plate.mass"]
    (folder / "plate.toml").write_text(
        CHAIN + "[boundary]\nbottom = {plate = {mass = 1.0, stiffness = 1e6}}\n"
    )
    for table in (
        {"boundary": {"bottom": {"plate": {"mass": 2.0}}}},
        {"boundary.bottom.plate.mass": 2.0},
    ):
        made = problem_of(folder, base=str(folder / "plate.toml"), set=table)
        assert made.base["boundary"]["bottom"] == {"plate": {"mass": 2.0, "stiffness": 1e6}}
    half_space = {"half_space": {}, "material": "steel"}
    made = problem_of(
        folder, base=str(folder / "plate.toml"), set={"boundary": {"bottom": half_space}}
    )
    assert made.base["boundary"]["bottom"] == half_space
    both = {"load": {"velocity": [1.0, 3.0]}, "replicates": 2}
    assert (
        problem_of(folder, uncertainty=both).samples
        == problem_of(folder, uncertainty={"load.velocity": [1.0, 3.0], "replicates": 2}).samples
    )
    plate = {"boundary": {"bottom": {"plate": {"mass": [1.0, 3.0]}}}, "replicates": 2}
    samples = problem_of(folder, base=str(folder / "plate.toml"), uncertainty=plate).samples
    assert sorted(one["boundary.bottom.plate.mass"] for one in samples) == [1.5, 2.5]


@pytest.mark.validation
def test_steps_of_a_job_of_slurm(folder, slurm):  # noqa: F811
    """In a job on two nodes each run is a step on one of them."""
    (folder / "job.sh").write_text(
        f"#!/bin/sh\n{sys.executable} -m granwave.workflows design beads.toml -o job --budget 4 --force\n"
    )
    command = [
        "sbatch",
        "--wait",
        "--partition=main",
        "--nodes=2",
        "--ntasks=2",
        "--ntasks-per-node=1",
    ]
    done = subprocess.run(
        [*command, "-o", "job.log", "job.sh"], cwd=folder, timeout=240, check=False
    )
    assert done.returncode == 0, (folder / "job.log").read_text()
    records = [
        json.loads(path.read_text()) for path in (folder / "job/points").glob("[0-9]/run.json")
    ]
    assert {node for record in records for node in record["nodes"]} == set(slurm)


def test_layers_are_variables_of_each_bead(folder):
    problem = problem_of(
        folder, variables={"layers": {"materials": MATERIALS, "diameters": [0.5, 1.0]}}
    )
    assert len(problem.space.variables) == 6
    sizes = [one for one in problem.space.variables if one.key == "replace.2.diameter"]
    assert (sizes[0].low, sizes[0].high) == (0.005, 0.01)


def test_layers_of_a_packing_and_those_that_are_tied(folder):
    base = {"base": "fcc-small", "set": {"packing.size": [4, 4, 4]}}
    for tied, keys in (
        ({}, ["1-16", "17-32", "33-48", "49-64"]),
        ({"tied": {"period": 2}}, ["1-16,33-48", "17-32,49-64"]),
        ({"tied": {"groups": 2}}, ["1-32", "33-64"]),
    ):
        problem = problem_of(
            folder, **base, variables={"layers": {"materials": ["steel", "aluminium"], **tied}}
        )
        assert [one.key for one in problem.space.variables] == [
            f"replace.{ids}.material" for ids in keys
        ]
        known = new_design(
            problem, 1, {one.key: "aluminium" for one in problem.space.variables}
        ).known
        light = new_design(
            problem_of(folder, **base, variables={"material": ["aluminium"]}),
            1,
            {"material": "aluminium"},
        )
        assert known["mass_kg"] == pytest.approx(light.known["mass_kg"])
    row = problem_of(folder, variables={"layers": {"diameters": [0.5, 1.0], "tied": {"period": 2}}})
    made = row.tables_of({"replace.1,3.diameter": 0.01, "replace.2.diameter": 0.005})
    assert made["replace"] == [
        {"index": {"first": 1, "last": 3, "step": 2}, "diameter": 0.01},
        {"index": 2, "diameter": 0.005},
    ]


def test_limits_known_before_a_run(folder):
    problem = problem_of(folder, limits={"mass_kg": 0.005, "n_spheres": {"low": 2}})
    steel = new_design(problem, 1, {f"replace.{n}.material": "stainless-steel" for n in (1, 2, 3)})
    assert steel.state == "refused"
    assert steel.reason.startswith("mass_kg 0.012")
    assert (
        new_design(problem, 1, {f"replace.{n}.material": "ptfe" for n in (1, 2, 3)}).state
        == "running"
    )


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {"limits": {"mass_kg": 1e-6}},
            "no design meets them, of 200 drawn or all that there are; the nearest is",
        ),
        (
            {"variables": {"packing.diametr": [0.01]}},
            "is no key of a case; did you mean packing.diameter?",
        ),
        (
            {"variables": {"packing.diameter": {"low": 2.0, "high": 1.0}}},
            "whose high (1) is above its low (2)",
        ),
        ({"variables": {"packing.size.2": [3, 4]}}, "packing.size.2: found 3 in the case"),
        ({"variables": {}}, "found none, expected a table of keys"),
        ({"objective": {"minimise": ["target_peak_force"]}}, "did you mean target_peak_force_N?"),
        ({"objective": {}}, "found 0 values, expected one"),
        ({"set": {"boundary.bottom": "free"}}, "target_peak_force_N: is null without a target"),
        ({"limits": {"mass": 1.0}}, "limits.mass: is no value of summary.json"),
        ({"limits": {"mass_kg": {"low": 2.0, "high": 1.0}}}, "a high that is not below the low"),
        ({"uncertainty": {"velocity": [3.0, 1.0]}}, "the largest not below the smallest"),
        ({"uncertainty": {"statistic": "median"}}, '"mean", "worst"'),
        ({"variables": {"packing.diameter": [0.01, float("inf")]}}, "numbers that are finite"),
        (
            {"variables": {"packing.diameter": [0.01], "packing": {"diameter": [0.01]}}},
            "is given twice",
        ),
        (
            {"variables": {"layers": {"materials": MATERIALS}, "replace.1.material": MATERIALS}},
            "is given twice",
        ),
        (
            {"variables": {"layers": {"materials": MATERIALS}, "packing.size": [3, 4]}},
            "found beside packing.size",
        ),
        (
            {"variables": {"layers": {"materials": MATERIALS, "tied": True}}},
            "layers.tied: found true, expected {period",
        ),
        ({"variables": {"layers": {}}}, "layers: found {}, expected"),
        (
            {"base": "fcc-small", "variables": {"layers": {"diameters": [0.5, 1.0]}}},
            'expected "chain": smaller spheres',
        ),
        (
            {"variables": {"packing.diameter": {"low": 0.01, "high": 0.02, "step": 0}}},
            "steps above 0",
        ),
        ({"variables": {"packing.kind": ["foo"]}}, "variables: packing.kind: found"),
        (
            {"objective": {"minimise": ["end_reason"]}},
            "expected the name of a number of summary.json",
        ),
        ({"serach": {}}, "did you mean search?"),
        ({"uncertainty": {"velocity": [1, 2], "load.velocity": [1, 2]}}, "is given twice"),
        ({"uncertainty": {"velocity": [-5, -3]}}, "uncertainty: load.velocity"),
        ({"search": {"evaluations": 0}}, "evaluations: found 0"),
        ({"search": {"evaluation": 5}}, "did you mean"),
        ({"base": "no-such-case"}, "neither a file nor a built-in case"),
        ({"variables": {"load.velocity": [-1.0, -2.0]}}, "load.velocity"),
    ],
)
def test_bad_files_are_refused_before_anything_is_run(folder, changes, expected):
    with pytest.raises(InputError) as error:
        problem = problem_of(folder, **changes)
        first_design(DesignStudy(problem, folder / "nowhere"))
    assert expected in str(error.value)


def test_check_plans_a_search(folder, granwave):
    done = granwave("check", "beads.toml", "--json", cwd=folder)
    found = json.loads(done.stdout)
    assert (found["n_designs"], found["evaluations"], found["share_within_limits"]) == (8, 8, 1.0)
    assert "granwave design beads.toml" in granwave("run", "beads.toml", cwd=folder).stderr


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
    """Overlaps beyond the law, beads that fly off, an impulse that still comes in, an end of a
    range: each is said.
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
            file["walls/bottom/time"], file["walls/bottom/force"] = time_, force
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
        (104.0, 0.9, False, "104 (+4.0 %)"),
        (94.0, 0.9, True, "94 (-6.0 %)"),
        (101.0, 1.1, True, "beyond a limit: wall_impulse_Ns 1.1, at most 1"),
        (None, 0.9, True, "gives no value"),
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
