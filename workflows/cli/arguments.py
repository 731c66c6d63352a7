"""Arguments of the command line: texts to values, with one-line errors."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granwave.lammps_inputs.case.hints import POSSIBLE
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.directories import output_path
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number, read_whole

if TYPE_CHECKING:
    import numpy
    from numpy.typing import NDArray

#: Kinds of files that a user writes.
FILE_KINDS = (
    "case",
    "continuum",
    "sphere-contact",
    "scan",
    "suite",
    "profile",
    "inference",
    "design",
)
BENCH_PARTS = ("styles", "sizes", "ranks", "study")
_ID = re.compile("[0-9]+")
_MOST_FREQUENCIES = 1_000_000  # of START:END:COUNT
_LARGEST_OVERLAP = 1e6  # over the overlap at first yield; the size of spheres limits it to some 1e4
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
        raise argparse.ArgumentTypeError('found the empty name "" (. is the present directory)')
    return Path(text)


def number(text: str) -> float:
    """Read a number."""
    try:
        return read_number(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text or 'nothing'}, expected a number") from None


def _number(
    expected: str, accepts: Callable[[float], bool], kind: Callable[[float], Any] = float
) -> Callable[[str], Any]:
    """Make a function that reads a number of a kind."""

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


positive = _number(
    "a whole number, 1 or more", lambda value: value.is_integer() and value >= 1, int
)
count = _number("a whole number, 0 or more", lambda value: value.is_integer() and value >= 0, int)
seconds = _number("a number above 0 (s)", lambda value: 0 < value < math.inf)
hertz = _number("a number above 0 (Hz)", lambda value: 0 < value < math.inf)
speed = _number("a number above 0 (m/s)", lambda value: 0 < value < math.inf)
#: An overlap over that at first yield.
overlap = _number(
    f"a number above 0 and at most {_LARGEST_OVERLAP:g}",
    lambda value: 0 < value <= _LARGEST_OVERLAP,
)
#: A radius, m; infinite: a plane, if the command allows one.
radius = _number(
    f"a length from {_SHORTEST:g} to {_LONGEST:g} m",
    lambda value: _SHORTEST <= value <= _LONGEST or value == math.inf,
)


def words(text: str) -> tuple[str, ...]:
    """Read names with commas between them."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found):
        raise argparse.ArgumentTypeError(f'found an empty name in "{text}"')
    return found


def bench_parts(text: str) -> tuple[str, ...]:
    """Read names of parts of the bench."""
    found = words(text)
    if unknown := [name for name in found if name not in BENCH_PARTS]:
        raise argparse.ArgumentTypeError(
            f"found {unknown[0]}, expected some of {','.join(BENCH_PARTS)}"
        )
    return found


def shares(text: str) -> tuple[float, ...]:
    """Read shares, 0 or from 1e-12 to 10, with commas between them."""
    found = tuple(number(word) for word in words(text))
    if not all(value == 0 or 1e-12 <= value <= 10 for value in found):
        raise argparse.ArgumentTypeError(
            f"found {text}, expected 0, or shares from 1e-12 to 10, such as 0.05 for 5 %"
        )
    return found


def ids(text: str) -> list[int]:
    """Read ids with commas between them."""
    found = text.split(",")
    if not all(_ID.fullmatch(one.strip()) and int(one) > 0 for one in found):
        raise argparse.ArgumentTypeError(
            f"found {text or 'nothing'}, expected ids from 1 up with commas between them"
        )
    return [int(one) for one in found]


def frequencies(text: str) -> NDArray[numpy.float64]:
    """Read frequencies, Hz: numbers with commas between them, or START:END:COUNT."""
    import numpy

    try:
        if ":" in text:
            start, end, count = text.split(":")
            points = read_whole(count)
            if not 1 <= points <= _MOST_FREQUENCIES:
                raise ValueError
            values = numpy.linspace(read_number(start), read_number(end), points)
        else:
            values = numpy.array([read_number(one) for one in text.split(",")])
    except ValueError:
        values = numpy.empty(0)
    if not len(values) or not numpy.isfinite(values).all() or (values < 0).any():
        raise argparse.ArgumentTypeError(
            f"found {text or 'nothing'}, expected numbers from 0 up with commas between them (Hz), or START:END:COUNT "
            f"with a COUNT from 1 to {_MOST_FREQUENCIES}"
        )
    return values
