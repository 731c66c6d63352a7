"""Arguments of the command line: texts to values, with one-line errors."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

from granwave.lammps_inputs.case.hints import POSSIBLE
from granwave.lammps_inputs.directories import output_path
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import bench

_LARGEST_OVERLAP = 1e6  # over the overlap at first yield; the size of spheres limits it to some 1e4


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


def positive(text: str) -> int:
    """Read a whole number from 1 up."""
    value = number(text)
    if not value.is_integer() or value < 1:
        raise argparse.ArgumentTypeError(f"found {text}, expected a whole number, 1 or more")
    return int(value)


def bench_parts(text: str) -> tuple[str, ...]:
    """Read names of parts of the bench."""
    found = words(text)
    if unknown := [name for name in found if name not in bench.PARTS]:
        raise argparse.ArgumentTypeError(f"found {unknown[0]}, expected some of {','.join(bench.PARTS)}")
    return found


def radius(text: str) -> float:
    """Read a radius, m."""
    value = number(text)
    low, high = POSSIBLE["m"]
    if not (low <= value <= high or value == math.inf):  # infinite: a plane, if the command allows one
        raise argparse.ArgumentTypeError(f"found {text}, expected a length from {low:g} to {high:g} m")
    return value


def overlap(text: str) -> float:
    """Read an overlap over that at first yield."""
    value = number(text)
    if not 0 < value <= _LARGEST_OVERLAP:
        raise argparse.ArgumentTypeError(f"found {text}, expected a number above 0 and at most {_LARGEST_OVERLAP:g}")
    return value


def seconds(text: str) -> float:
    """Read a time above 0, s."""
    value = number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"found {text}, expected a number above 0 (s)")
    return value


def number(text: str) -> float:
    """Read a number."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"found {text or 'nothing'}, expected a number") from None


def words(text: str) -> tuple[str, ...]:
    """Read names with commas between them."""
    found = tuple(name.strip() for name in text.split(","))
    if not all(found):
        raise argparse.ArgumentTypeError(f'found an empty name in "{text}"')
    return found


def hertz(text: str) -> float:
    """Read a frequency above 0, Hz."""
    value = number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"found {text}, expected a number above 0 (Hz)")
    return value


def count(text: str) -> int:
    """Read a whole number from 0 up."""
    value = number(text)
    if not value.is_integer() or value < 0:
        raise argparse.ArgumentTypeError(f"found {text}, expected a whole number, 0 or more")
    return int(value)


def shares(text: str) -> tuple[float, ...]:
    """Read shares, 0 or from 1e-12 to 10, with commas between them."""
    found = tuple(number(word) for word in words(text))
    if not all(value == 0 or 1e-12 <= value <= 10 for value in found):
        raise argparse.ArgumentTypeError(f"found {text}, expected 0, or shares from 1e-12 to 10, such as 0.05 for 5 %")
    return found
