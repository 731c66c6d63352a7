"""Searches to the best design: results, resumption, two objectives, uncertainty, Python."""

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

import granwave as gw
from granwave.extensions.design.search.driver import _Search
from granwave.extensions.design.search.guards import (
    has_passed,
    of_neighbours,
    target_force,
)
from granwave.extensions.design.search.study import Design, DesignStudy
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.result_directory import ResultDirectory
from tests.conftest import PLAIN
from tests.extensions.design.chain_search import CHAIN, MATERIALS, TABLES, problem_of
from tests.helpers.programs.slurm_cluster import slurm  # noqa: F401

pytest.importorskip("sklearn")
pytestmark = pytest.mark.xdist_group("design")  # its results are shared


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
    """A run is continued if the force has not fallen to a tenth at the end time of the file."""
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
    assert "with --resume to continue" in text
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


@pytest.mark.validation
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
    """Designs are compared by the same runs: a better design is not discarded because of its fast
    first impact.
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
    """A search with few, coarse runs: ranking and best case come from full runs, in the same
    directories.
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
    assert found["neighbours"].text.startswith(
        "2 neighbours of the best design were not run and may be better"
    )


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
    (warned,) = [one for one in caplog.messages if "is rejected even without other changes" in one]
    assert (
        "replace.1-16.material and 2 more" in warned
        and '{preset = "ptfe", yield_strength = (Pa)}' in warned
    )
    problem_of(folder, variables={"material": ["steel", "aluminum"]})
    assert "did you mean aluminium" in caplog.text


@pytest.mark.validation
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


@pytest.mark.validation
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
