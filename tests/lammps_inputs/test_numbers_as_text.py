"""Numbers in text: accepted forms, and the form written for LAMMPS."""

from __future__ import annotations

import math
import sys

import pytest

from granwave.lammps_inputs.files import read_number, read_whole
from granwave.lammps_inputs.script_words import num


@pytest.mark.parametrize("word", ["1", "-1.5", "+.5", "1.", "1e-3", " 2E+4 ", "1e400"])
def test_numbers(word: str) -> None:
    assert read_number(word) == float(word)


@pytest.mark.parametrize("word", ["nan", "-inf", "Infinity"])
def test_numbers_that_are_not_finite(word: str) -> None:
    assert not math.isfinite(read_number(word))


@pytest.mark.parametrize("word", ["1_0", "1_0.5", "\u0661", "", ".", "0x10", "1e", "1 2", "--1"])
def test_no_numbers(word: str) -> None:
    with pytest.raises(ValueError, match="expected a number"):
        read_number(word)


def test_whole_numbers() -> None:
    assert read_whole(" 12 ") == 12
    for word in ("1_2", "\u00b2", "1.0", ""):
        with pytest.raises(ValueError, match="expected a whole number"):
            read_whole(word)


def test_numbers_that_lammps_cannot_read_in_formulas_are_written_as_zero() -> None:
    least = sys.float_info.min
    assert num(least / 2) == num(-5e-324) == "0"
    assert float(num(least)) == least
    assert float(num(-1.5 * least)) == -1.5 * least
