"""Complete searches whose runs are replaced by formulas with a known optimum."""

from __future__ import annotations

import itertools
import json
import math
import random

import numpy as np
import pytest

from granwave.extensions.design.search import driver, study
from granwave.extensions.design.search.design_file import load_problem
from granwave.extensions.design.search.points import Ended
from granwave.extensions.design.search.search import front

pytest.importorskip("sklearn")

CHAIN = """
name = "chain"
material = "stainless-steel"
packing = {kind = "chain", size = 6, diameter = 0.010}
load = {velocity = 2.0}
contact = {law = "hertz"}
run = {end_time = 6e-5, frames = 2}
"""
PACKING = """
name = "packing"
material = "steel"
packing = {kind = "fcc", size = [4, 4, 4], diameter = 0.006}
load = {velocity = 2.0}
run = {end_time = 1e-4}
"""
FORCE = {"minimise": ["target_peak_force_N"]}


class Killed(BaseException):
    """The process ends between two lines."""


@pytest.fixture
def search(monkeypatch, tmp_path):
    """Function that makes a search of a formula: the tables of a case give the force, or None."""
    chance = random.Random(1)
    state = {"killed": 0.0}

    class Formulas:
        def __init__(self, folder, ranks):
            self.folder = folder
            self.waiting = {}

        def __len__(self):
            return len(self.waiting)

        def start(self, name, tables):
            self._dies()
            self.waiting[name] = tables

        def wait(self):
            self._dies()
            name, tables = self.waiting.popitem()
            summary = {"target_peak_force_N": state["force"](tables)}
            (self.folder / name).mkdir(parents=True, exist_ok=True)
            (self.folder / name / "summary.json").write_text(json.dumps(summary))
            self._dies()
            return [Ended(name, summary, "", False, 0.0)]

        def _dies(self):
            if chance.random() < state["killed"]:
                raise Killed

    monkeypatch.setattr(driver, "Points", Formulas)
    monkeypatch.setattr(driver, "load", lambda: None)
    monkeypatch.setattr(driver, "check_best", lambda *_, **__: [])
    monkeypatch.setattr(study, "write_report", lambda *_: None)
    (tmp_path / "chain.toml").write_text(CHAIN)
    (tmp_path / "packing.toml").write_text(PACKING)

    def searched(
        force,
        variables,
        *,
        base="chain.toml",
        name="found",
        resume=False,
        killed=0.0,
        objective=FORCE,
        **more,
    ):
        state.update(force=force, killed=killed)
        tables = {
            "base": str(tmp_path / base),
            "variables": variables,
            "objective": objective,
            **more,
        }
        tables["search"] = {"guards": False, **more.get("search", {})}
        driver.run_design(load_problem(tables), tmp_path / name, jobs=1, resume=resume)
        return json.loads((tmp_path / name / "design.json").read_text())

    searched.folder = tmp_path
    return searched


def best_of(found):
    return found["best"]["objective"]["target_peak_force_N"]


KINDS = {"fcc": (0.5, 0.8), "hcp": (0.4, 0.2), "bcc": (0.2, 0.5), "sc": (0.0, 0.4)}
STIFF = {"steel": 1.0, "aluminium": 0.0, "brass": 0.6}


def of_packing(tables):
    kind, best = KINDS[tables["packing"]["kind"]]
    stiff = STIFF[tables["material"]]
    share = tables["packing"]["diameter"] / 0.004 - 1
    layers = tables["packing"]["size"][2]
    return 300 * math.exp(
        kind + stiff + 1.5 * (share - best) ** 2 - 0.1 * layers * (1 - kind) * (1.2 - stiff)
    )


MIXED = {
    "packing.kind": list(KINDS),
    "material": [*STIFF, "ptfe"],  # which has no yield strength, so that there is no such packing
    "packing.size.2": {"low": 3, "high": 12, "integer": True},
    "packing.diameter": {"low": 0.004, "high": 0.008},
}


@pytest.mark.validation
def test_words_integers_and_a_range_some_of_which_are_no_packings(search):
    found = search(of_packing, MIXED, base="packing.toml", search={"evaluations": 40})
    size = {"kind": "sc", "size": [4, 4, 12], "diameter": 0.0056}
    assert best_of(found) == pytest.approx(
        of_packing({"packing": size, "material": "aluminium"}), rel=0.01
    )
    assert (
        found["evaluations"] == 40
    )  # what cannot be is learnt, so that the search does not end on it


def test_a_limit_that_the_best_stands_at(search):
    """The force decreases with the diameter, until six beads reach the mass limit."""
    variables = {
        "packing.diameter": {"low": 0.002, "high": 0.03},
        "load.velocity": {"low": 1.0, "high": 5.0},
    }
    found = search(
        lambda tables: (
            (1 + (tables["load"]["velocity"] - 2.2) ** 2) / tables["packing"]["diameter"]
        ),
        variables,
        limits={"mass_kg": 0.05},
        search={"evaluations": 20},
    )
    assert best_of(found) == pytest.approx((math.pi * 7925.0 / 0.05) ** (1 / 3), rel=0.005)
    assert found["best"]["mass_kg"] <= 0.05


def test_a_range_in_the_logarithm(search):
    variables = {"packing.diameter": {"low": 1e-4, "high": 1.0, "log": True}}
    found = search(
        lambda tables: 1 + math.log10(tables["packing"]["diameter"] / 0.0037) ** 2,
        variables,
        search={"evaluations": 12},
    )
    assert best_of(found) == pytest.approx(1.0, abs=1e-3)


def test_the_place_of_an_intruder(search):
    def force(tables):
        return 50 + abs(tables["replace"][0]["index"] - 31) ** 1.3

    found = search(
        force,
        {"replace.7.index": {"low": 1, "high": 60, "integer": True}},
        set={"packing.size": 60, "replace": [{"index": 7, "material": "ptfe"}]},
        search={"evaluations": 15},
    )
    assert best_of(found) == 50


def test_designs_without_a_value_are_left(search):
    """No force beyond 60 % of the range, towards which it falls."""

    def force(tables):
        share = (tables["packing"]["diameter"] - 0.004) / 0.008
        return None if share > 0.6 else 100 - 60 * share

    found = search(
        force, {"packing.diameter": {"low": 0.004, "high": 0.012}}, search={"evaluations": 20}
    )
    assert best_of(found) == pytest.approx(64, rel=0.01)
    assert found["states"]["failed"] > 0


def test_an_objective_that_nothing_changes(search):
    found = search(
        lambda tables: 5.0, {"material": ["steel", "ptfe", "brass"]}, search={"evaluations": 3}
    )
    assert best_of(found) == 5
    assert found["states"] == {"complete": 3}


@pytest.mark.validation
def test_the_front_of_all_rows(search):
    """Force and mass of chains of three materials: 60 of 243 designs find most of the front."""
    soft = {"stainless-steel": 1.0, "ptfe": 0.1, "aluminium": 0.5}

    def force(materials):
        steps = sum(a != b for a, b in itertools.pairwise(materials))
        return (
            100
            * math.prod(soft[one] ** (0.2 + 0.1 * n) for n, one in enumerate(materials))
            * math.exp(-0.2 * steps)
        )

    def of_tables(tables):
        return force(
            [one["material"] for one in sorted(tables["replace"], key=lambda one: one["index"])]
        )

    variables = {f"replace.{n}.material": list(soft) for n in range(1, 6)}
    found = search(
        of_tables,
        variables,
        set={"packing.size": 5},
        objective={"minimise": ["target_peak_force_N"], "maximise": ["mass_kg"]},
        search={"evaluations": 60},
    )
    density = {"stainless-steel": 7925.0, "ptfe": 1870.0, "aluminium": 2700.0}
    rows = list(itertools.product(soft, repeat=5))
    losses = [(force(row), -sum(density[one] for one in row)) for row in rows]
    best = {round(losses[n][0], 9) for n in front(losses)}
    ours = {round(one["objective"]["target_peak_force_N"], 9) for one in found["front"]}
    assert len(best & ours) >= 0.6 * len(best)


@pytest.mark.validation
def test_killed_again_and_again_it_finds_the_same(search):
    """Several runs of each design, some pruned; coarse runs first; designs next to the best design;
    limits.
    """
    more = {
        "base": "packing.toml",
        "limits": {"mass_kg": 0.05},
        "uncertainty": {"velocity": [1.5, 2.5], "replicates": 2, "statistic": "worst"},
        "search": {
            "evaluations": 10,
            "seed": 4,
            "guards": True,
            "neighbours": 4,
            "tolerance": 3e-5,
        },
    }

    def force(tables):
        return of_packing(tables) * tables["load"]["velocity"]

    search(force, MIXED, name="once", **more)
    killed = 0
    while True:
        try:
            search(force, MIXED, name="killed", resume=killed > 0, killed=0.1, **more)
            break
        except Killed:
            killed += 1
    assert killed > 3
    once, often = (
        (search.folder / name / "designs.csv").read_text() for name in ("once", "killed")
    )
    assert often == once
    assert "neighbour of design" in once
    assert np.all([name in once for name in ("pruned", "complete", "refused")])
