"""Blocks of ``run.end_time = "auto"``: they contain the collision."""

from __future__ import annotations

import json

import pytest

import granwave as gw
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.blocks import BLOCK_TIME, block_time, collision_time
from granwave.lammps_inputs.planning.plan import plan
from granwave.workflows import library
from granwave.workflows.run.driver import run_case

SLOW = {"load.velocity": 0.05}
ELASTIC = {"contact.law": "hertz"}


def two_spheres(changes):
    return load_case(library.find("two-spheres"), changes)


def test_usual_collisions_are_shorter_than_a_block():
    assert block_time(assemble(two_spheres({}))) == BLOCK_TIME


@pytest.mark.parametrize("diameter", [0.01, 0.05])
def test_the_collision_time_is_the_time_until_the_bodies_separate(diameter, tmp_path):
    """Within the sampling of the run, for two elastic spheres."""
    case = two_spheres(SLOW | ELASTIC | {"packing.diameter": diameter, "run.end_time": 1e-3})
    elastic = gw.run(case, directory=tmp_path / "run").energies["elastic"]
    last = elastic.index[elastic > 1e-9 * elastic.max()].max()
    assert collision_time(assemble(case)) == pytest.approx(last, rel=0.02)


@pytest.mark.parametrize("diameter", [0.01, 0.05])
def test_a_slow_impact_ends_after_its_collision(diameter, tmp_path):
    """It stays elastic: restitution is 1."""
    case = two_spheres(SLOW | {"packing.diameter": diameter})
    summary = run_case(case, tmp_path / "run", figures=False).summary
    assert json.loads((tmp_path / "run" / "run.json").read_text())["end_reason"] == "settled"
    assert summary["restitution"] == pytest.approx(1.0, abs=1e-4)


def test_large_spheres_dissipate_as_small_ones(tmp_path):
    """Times are proportional to the diameter at given velocity."""
    found = []
    for diameter in (0.01, 0.1):
        size = {"packing.size": [6, 6, 3], "packing.diameter": diameter, "load.velocity": 0.5}
        case = load_case(library.find("fcc-small"), size | {"run.end_time": "auto"})
        found.append(run_case(case, tmp_path / str(diameter), figures=False).summary)
    shares = [summary["dissipated_fraction"] for summary in found]
    assert shares[1] == pytest.approx(shares[0], rel=1e-3)
    assert shares[0] > 0.3


def test_collisions_that_the_limit_cuts_are_named(caplog):
    plan(assemble(two_spheres({"load.velocity": 1e-4, "packing.diameter": 0.5})))
    (text,) = [text for text in caplog.messages if "run.end_time" in text]
    assert "5 ms at most" in text and "set run.end_time" in text
