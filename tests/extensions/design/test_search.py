"""Choice of designs: finds known optima in few evaluations, keeps to limits, and is repeatable."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from granwave.extensions.design.search.search import (
    TriedDesign,
    expected_random,
    front,
    importance,
    joined,
    n_first,
    ordered,
)
from granwave.extensions.design.search.variables import Space, read_variable

pytest.importorskip("sklearn")

BEADS = Space(tuple(read_variable(f"replace.{n}.material", ["steel", "ptfe"]) for n in range(1, 7)))
PACKINGS = Space(
    (
        read_variable("packing.kind", ["fcc", "hcp", "bcc", "sc"]),
        read_variable("packing.size.2", {"low": 3, "high": 7, "integer": True}),
        read_variable("material", ["steel", "aluminium", "brass"]),
    )
)
RANGES = Space(tuple(read_variable(f"x.{n}", {"low": 0.0, "high": 1.0}) for n in range(2)))


def of_beads(values):
    """Force behind beads: soft beads at the ends, stiff beads inside, and interfaces reduce it."""
    soft = [value == "ptfe" for value in values.values()]
    interfaces = sum(a != b for a, b in itertools.pairwise(soft))
    return 100 * math.exp(
        -0.6 * soft[0] - 0.8 * soft[-1] - 0.3 * interfaces + 0.25 * sum(soft[1:-1])
    )


def of_packings(values):
    kind = {"fcc": 0.5, "hcp": 0.4, "bcc": 0.2, "sc": 0.0}[values["packing.kind"]]
    material = {"steel": 1.0, "aluminium": 0.0, "brass": 0.6}[values["material"]]
    return 300 * math.exp(kind + material - 0.2 * values["packing.size.2"] * (1 - kind))


def of_ranges(values):
    x, y = values.values()
    return 1 + (x - 0.3) ** 2 + 2 * (y - 0.7) ** 2 + 0.5 * x * y


def search(space, loss, evaluations, seed, *, margin=None, guided=True):
    known = []
    while sum(one.losses is not None for one in known) < evaluations:
        ran = sum(one.losses is not None for one in known)
        try:
            values = next(
                ordered(space, known, seed, guided=guided and ran >= n_first(space, evaluations))
            )
        except StopIteration:
            break
        margins = {} if margin is None else {"mass_kg": margin(values)}
        beyond = bool(margins) and margins["mass_kg"] > 0
        known.append(TriedDesign(values, None if beyond else (loss(values),), margins))
    return known


@pytest.mark.parametrize(
    ("space", "loss"),
    [
        (BEADS, of_beads),
        pytest.param(PACKINGS, of_packings, marks=pytest.mark.validation),
    ],
)
def test_small_spaces_are_solved_in_a_third_of_the_evaluations(space, loss):
    best = min(map(loss, space.all()))
    third = int(space.size) // 3
    solved = [
        best in [one.losses[0] for one in search(space, loss, third, seed)] for seed in range(1, 9)
    ]
    assert sum(solved) >= 7


@pytest.mark.validation
def test_better_than_random():
    guided, drawn = (
        [
            min(one.losses[0] for one in search(RANGES, of_ranges, 18, seed, guided=way))
            for seed in range(5)
        ]
        for way in (True, False)
    )
    lowest = min(
        of_ranges({"x": x, "y": y}) for x, y in itertools.product(np.linspace(0, 1, 201), repeat=2)
    )
    assert np.median(guided) - lowest < 0.3 * (np.median(drawn) - lowest)


def test_limits_are_learnt():
    found = search(
        RANGES, of_ranges, 15, 1, margin=lambda values: values["x.0"] - 0.15
    )  # 15 % of all designs
    assert len(found) < 40  # at random some 100
    best = min(one.losses[0] for one in found if one.losses)
    assert best == pytest.approx(of_ranges({"x": 0.15, "y": 0.66}), rel=0.02)


def test_designs_in_work_are_not_chosen_again():
    known = search(BEADS, of_beads, 10, 1)
    pending = next(ordered(BEADS, known, 1, guided=True))
    following = next(
        ordered(BEADS, [*known, TriedDesign(pending, None, {}, in_work=True)], 1, guided=True)
    )
    assert following != pending


def test_importance_names_the_variable_that_matters():
    known = search(RANGES, lambda values: 1 + values["x.0"], 12, 1)
    shares = importance(RANGES, known)
    assert shares["x.0"] > 0.9
    assert shares["x.1"] < 0.05


def test_importance_of_effects_that_add():
    """Large values with a small variance; the fractions of x.0 and x.1 are equal: their sum is 1."""
    known = search(RANGES, lambda values: 20 + values["x.0"] + values["x.1"], 20, 1)
    shares = importance(RANGES, known)
    assert sum(shares.values()) <= 1 + 1e-12
    assert shares["x.0"] == pytest.approx(0.5, abs=0.03)
    assert shares["x.1"] == pytest.approx(0.5, abs=0.03)


def test_random_search_as_the_model_expects_it():
    known = search(RANGES, lambda values: 1 + values["x.0"], 14, 1)
    expected = expected_random(RANGES, known, [1, 3])
    assert expected == pytest.approx(
        [1.5, 1.25], rel=0.03
    )  # mean, and smallest of three, of even numbers


def test_front():
    assert front([(1, 5), (2, 2), (3, 3), (5, 1), (2, 2)]) == [0, 1, 3]


def test_values_that_are_to_be_large():
    """Losses of values to maximise are negative; their order stays in the logarithm."""
    losses = np.array([[-5.0], [-1.0], [-20.0]])
    assert list(np.argsort(joined(losses))) == [2, 0, 1]
    found = search(RANGES, lambda values: -1 / of_ranges(values), 15, 1)
    highest = max(-one.losses[0] for one in found)
    assert highest > 0.97 / min(of_ranges({"x": x, "y": 0.65}) for x in np.linspace(0, 1, 101))


def test_failed_designs_do_not_stop_the_search():
    known = search(RANGES, of_ranges, 8, 1)
    known = [TriedDesign(one.values, one.losses, {"failed": -1.0}) for one in known]
    failed = [TriedDesign(RANGES.at(at), None, {"failed": 1.0}) for at in ((0.9, 0.9), (0.95, 0.1))]
    chosen = next(ordered(RANGES, [*known, *failed], 1, guided=True))
    assert of_ranges(chosen) < 1.6  # not in the farthest corner
