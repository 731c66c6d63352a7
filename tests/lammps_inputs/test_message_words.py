"""Numbers of things in words."""

from __future__ import annotations

import pytest

from granwave.lammps_inputs.message_words import counted
from granwave.workflows.cli.tables.grain_file_values import grain_file_rows


@pytest.mark.parametrize(
    ("n", "words"), [(0, "0 contacts"), (1, "1 contact"), (2, "2 contacts"), (11, "11 contacts")]
)
def test_a_single_thing_is_singular(n: int, words: str) -> None:
    assert counted(n, "contact") == words


def test_a_file_of_one_grain() -> None:
    values = {"n_grains": 1, "file": "one.csv", "format": "csv"}
    assert next(grain_file_rows(values)) == ("read", "1 grain of one.csv (csv)")
