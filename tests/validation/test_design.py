"""Searches for a design compared with complete small spaces, and with random search."""

from __future__ import annotations

import numpy as np
import pytest

import granwave as gw
from granwave.extensions.design.search.design_file import load_problem
from granwave.extensions.design.search.search import TriedDesign, n_first, ordered

pytestmark = pytest.mark.validation
pytest.importorskip("sklearn")

SEEDS = range(1, 21)
HERTZ = {"law": "hertz"}
BEADS = {"kind": "chain", "size": 6, "diameter": 0.010}
CHAIN = {
    "material": "stainless-steel",
    "packing": BEADS,
    "contact": HERTZ,
    "load": {"velocity": 2.0},
}
CHAIN["run"] = {"end_time": 6e-4, "frames": 2}
PLATE = {"plate": {"mass": 0.5, "stiffness": 2e7}, "material": "steel"}
PACKING = {
    "material": "brass",
    "packing": {"kind": "fcc", "size": [8, 8, 5], "diameter": 0.010},
    "load": {"velocity": 5.0},
}
PACKING |= {"boundary": {"bottom": PLATE}, "run": {"end_time": 8e-4, "frames": 2}}
SPACES = {
    "chains": (CHAIN, {f"replace.{n}.material": ["stainless-steel", "ptfe"] for n in range(1, 7)}),
    "packings": (
        PACKING,
        {
            "packing.kind": ["fcc", "hcp", "bcc", "sc"],
            "packing.size.2": {"low": 3, "high": 7, "integer": True},
            "material": ["steel", "aluminium", "brass"],
        },
    ),
}
TARGET = {"minimise": ["target_peak_force_N"]}


def problem(folder, name, base, variables, **search):
    import tomli_w

    (folder / f"{name}.toml").write_text(tomli_w.dumps({"name": name, **base}))
    tables = {"base": str(folder / f"{name}.toml"), "variables": variables, "objective": TARGET}
    return tables | {"search": {"guards": False, **search}}


@pytest.mark.parametrize("name", SPACES)
def test_the_best_of_all_in_a_third_of_the_evaluations(name, tmp_path):
    base, variables = SPACES[name]
    tables = problem(tmp_path, name, base, variables, evaluations=1000)
    found = gw.design(tables, directory=tmp_path / "all", progress=False)
    space = load_problem(tables).space
    assert len(found.table) == space.size
    forces = {}
    for _, row in found.table.iterrows():
        values = {
            one.key: next(c for c in one.choices if str(c) == str(row[one.key]))
            for one in space.variables
        }
        forces[repr(values)] = row["target_peak_force_N"]
    best = min(forces.values())
    third = int(space.size) // 3
    solved = 0
    for seed in SEEDS:
        known = []
        for _ in range(third):
            values = next(ordered(space, known, seed, guided=len(known) >= n_first(space, third)))
            known.append(TriedDesign(values, (forces[repr(values)],), {}))
        solved += best in [one.losses[0] for one in known]
    print(f"{name}: the best of {int(space.size)} in {third} evaluations with {solved} of 20 seeds")
    assert solved >= 18


def test_better_than_random_search(tmp_path):
    """Diameters of a tapered chain of eight beads, within a length."""
    chain = {**CHAIN, "packing": {**BEADS, "size": 8}, "load": {"velocity": 3.0}}
    tables = problem(
        tmp_path, "taper", chain, {"layers": {"diameters": [0.4, 1.2]}}, evaluations=40
    )
    tables["limits"] = {"height_m": 0.07}
    medians = {}
    for sampler in ("model", "random"):
        best = []
        for seed in (1, 2, 3):
            tables["search"] |= {"sampler": sampler, "seed": seed}
            found = gw.design(tables, directory=tmp_path / f"{sampler}-{seed}", progress=False)
            best.append(found.best["objective"]["target_peak_force_N"])
        medians[sampler] = float(np.median(best))
    print(f"smallest force after 40 evaluations: {medians}")
    assert medians["model"] < 0.85 * medians["random"]
