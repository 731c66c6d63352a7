"""Files of a search: keys, layers, limits that are known before a run, rejected input, and the
plan.
"""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator

from granwave.extensions.design.search.problem import with_values
from granwave.extensions.design.search.study import DesignStudy, first_design, new_design
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.keys.json_schema import schema_of
from tests.extensions.design.chain_search import CHAIN, MATERIALS, problem_of

pytest.importorskip("sklearn")
pytestmark = pytest.mark.xdist_group("design")  # its results are shared

PTFE = {"index": 7, "material": "ptfe"}


def test_a_design_without_variables_does_not_fit_the_schema():
    assert not Draft202012Validator(schema_of("design")).is_valid({"base": "fcc-small"})


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
            "none of 200 random designs, or of all designs, meets them; the nearest is",
        ),
        (
            {"variables": {"packing.diametr": [0.01]}},
            "is not a key of a case; did you mean packing.diameter?",
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
        ({"limits": {"mass": 1.0}}, "limits.mass: is not a value of summary.json"),
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
            "found together with packing.size",
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
