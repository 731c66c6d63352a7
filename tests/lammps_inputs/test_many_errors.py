"""Very many errors in one file: the first errors and the number of the others are shown."""

from __future__ import annotations

import pickle

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict

TABLES = {"material": "brass", "packing": {"kind": "chain", "size": 10, "diameter": 0.01}}


def errors_of(**tables: object) -> list[str]:
    with pytest.raises(InputError) as caught:
        case_from_dict({"name": "many", **TABLES, **tables})
    return caught.value.errors


@pytest.mark.parametrize("number", [3, 20, 21])
def test_each_of_some_unknown_keys_has_a_line(number: int) -> None:
    errors = errors_of(**{f"k{n}": 1 for n in range(number)})
    assert len(errors) == number
    assert all("unknown key; " in error for error in errors)


def test_of_many_unknown_keys_the_last_line_has_the_number() -> None:
    errors = errors_of(**{f"k{n}": 1 for n in range(100_000)})
    assert len(errors) == 21
    assert errors[-1].endswith("k20: unknown key, as are 99979 more after it")


def test_of_many_errors_the_last_line_has_the_number() -> None:
    errors = errors_of(replace=[{"index": 0}] * 5000)
    assert len(errors) == 101
    assert errors[-1] == "and 4900 more errors; correct these first"
    again = pickle.loads(pickle.dumps(InputError(errors)))
    assert again.errors == errors
