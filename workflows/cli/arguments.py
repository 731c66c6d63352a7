"""Arguments of the command line: conversion of texts to values, with one-line errors."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.hints import POSSIBLE
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.directories import output_path
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number

BENCH_PARTS = ("styles", "lists", "sizes", "ranks", "study")
# largest overlap / overlap at first yield; the size of spheres limits it to about 1e4
_LARGEST_OVERLAP = 1e6
_SHORTEST, _LONGEST = POSSIBLE["m"]


def output_name(text: str) -> Path:
    """Return the path of a file or directory to be written."""
    try:
        return output_path(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def input_name(text: str) -> Path:
    """Return the path of a file or directory that is read."""
    if not text:
        raise argparse.ArgumentTypeError('found the empty name "" (. is the current directory)')
    return Path(text)


def number(text: str) -> float:
    """Read a number."""
    try:
        return read_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text or 'nothing'}, expected a number") from None


def number_that(
    expected: str, accepts: Callable[[float], bool], kind: Callable[[float], Any] = float
) -> Callable[[str], Any]:
    """Make a function that reads a number and checks whether it is accepted.

    Parameters
    ----------
    expected
        Accepted numbers, in words.
    accepts
        Function that returns True for them.
    kind
        Type of the result.
    """

    def read(text: str) -> Any:
        if not accepts(value := number(text)):
            raise argparse.ArgumentTypeError(f"found {text}, expected {expected}")
        return kind(value)

    return read


def number_of(parse: Callable[[float], float]) -> Callable[[str], float]:
    """Make a function that reads a number of a key with the parser of its values."""

    def read(text: str) -> float:
        try:
            return parse(number(text))
        except ValidationError as error:
            raise argparse.ArgumentTypeError(f"found {text}, expected {error}") from None

    return read


positive = number_that(
    "a whole number, 1 or more", lambda value: value.is_integer() and value >= 1, int
)
count = number_that(
    "a whole number, 0 or more", lambda value: value.is_integer() and value >= 0, int
)
seconds = number_that("a number above 0 (s)", lambda value: 0 < value < math.inf)
speed = number_that("a number above 0 (m/s)", lambda value: 0 < value < math.inf)
finite = number_that("a finite number", math.isfinite)
factor = number_that(
    "a finite number other than 0", lambda value: value != 0 and math.isfinite(value)
)
#: An overlap / overlap at first yield.
overlap = number_that(
    f"a number above 0 and at most {_LARGEST_OVERLAP:g}",
    lambda value: 0 < value <= _LARGEST_OVERLAP,
)
#: A radius, m; infinite: a plane, if the command allows one.
radius = number_that(
    f"a length from {_SHORTEST:g} to {_LONGEST:g} m",
    lambda value: _SHORTEST <= value <= _LONGEST or value == math.inf,
)


def words(text: str) -> tuple[str, ...]:
    """Read names separated by commas."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found):
        raise argparse.ArgumentTypeError(f'found an empty name in "{text}"')
    return found


def whole_numbers(text: str) -> tuple[int, ...]:
    """Read whole numbers from 1 up and ranges of them, such as ``1,5,10-20``."""
    found: list[int] = []
    for word in words(text):
        first, dash, last = word.partition("-")
        numbers = range(positive(first), 1 + positive(last if dash else first))
        if not numbers:
            raise argparse.ArgumentTypeError(f"found {word}, expected the smaller number first")
        found.extend(numbers)
    return tuple(found)


def bounds(text: str) -> tuple[float, float]:
    """Read a lower and an upper bound, with a comma between them."""
    found = tuple(number(word) for word in words(text))
    if len(found) != 2 or not found[0] <= found[1]:
        raise argparse.ArgumentTypeError(
            f"found {text}, expected a lower and an upper bound, such as 0.01,0.02"
        )
    return found[0], found[1]


def bench_parts(text: str) -> tuple[str, ...]:
    """Read names of parts of the bench."""
    found = words(text)
    if unknown := [name for name in found if name not in BENCH_PARTS]:
        raise argparse.ArgumentTypeError(
            f"found {unknown[0]}, expected some of {','.join(BENCH_PARTS)}"
        )
    return found
