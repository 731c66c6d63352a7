"""Variables of a design file: values, coordinates, neighbours, and rejected input."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.extensions.design.search.variables import Space, read_variable
from granwave.lammps_inputs.case.schema import ValidationError

CHOICES = read_variable("packing.kind", ["fcc", "hcp", "bcc"])
NUMBERS = read_variable("packing.size.2", [8, 4, 6])
WHOLE = read_variable("packing.size.2", {"low": 4, "high": 8, "integer": True})
STEPS = read_variable("load.velocity", {"low": 1.0, "high": 2.0, "step": 0.25})
LOG = read_variable("packing.diameter", {"low": 0.001, "high": 0.1, "log": True})


def test_values_at_shares_of_the_range():
    assert [CHOICES.value(share) for share in (0.0, 0.5, 0.99)] == ["fcc", "hcp", "bcc"]
    assert NUMBERS.choices == (4, 6, 8)  # in order
    assert WHOLE.choices == (4, 5, 6, 7, 8)
    assert all(isinstance(value, int) for value in WHOLE.choices)
    assert STEPS.choices == (1.0, 1.25, 1.5, 1.75, 2.0)
    assert LOG.value(0.5) == pytest.approx(0.01)


def test_coordinates_and_neighbours():
    assert LOG.features(0.01) == pytest.approx([0.5])
    different = np.subtract(CHOICES.features("fcc"), CHOICES.features("bcc"))
    assert np.linalg.norm(different) == pytest.approx(
        1.0
    )  # words are as far apart as the ends of a range
    assert WHOLE.neighbours(4) == [5]
    assert CHOICES.neighbours("hcp") == ["fcc", "bcc"]
    assert LOG.edge(0.1) == "high"
    assert not CHOICES.edge("fcc")


def test_changes_stay_in_the_range():
    rng = np.random.default_rng(1)
    for variable in (CHOICES, NUMBERS, WHOLE, STEPS, LOG):
        value = variable.value(0.9)
        for _ in range(50):
            value = variable.changed(value, rng)
            assert (
                value in variable.choices
                if variable.choices
                else variable.low <= value <= variable.high
            )


def test_size_of_a_space():
    assert Space((CHOICES, WHOLE)).size == 15
    assert len(list(Space((CHOICES, WHOLE)).all())) == 15
    assert Space((CHOICES, LOG)).size == float("inf")


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ([], "at least one choice"),
        (5, "a list of choices, or a range"),
        ({"low": 1}, "a list of choices, or a range"),
        ({"low": 2.0, "high": 1.0}, "whose high (1) is above its low (2)"),
        ({"low": 0.0, "high": 1.0, "log": True}, "positive numbers"),
        ({"low": 1.5, "high": 3, "integer": True}, "a range"),
        ({"low": 0.0, "high": 1.0, "step": -0.1}, "steps above 0"),
        ({"low": 0.0, "high": 1.0, "steps": 3}, "a list of choices, or a range"),
        ({"low": "a", "high": 1.0}, "a list of choices, or a range"),
    ],
)
def test_refused(value, expected):
    with pytest.raises(ValidationError) as error:
        read_variable("packing.diameter", value)
    assert expected in str(error.value)
