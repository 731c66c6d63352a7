"""Functions of time of forces and displacements, and tables of points.

With amplitude A, duration T and frequency f:

    half-sine      A sin(pi t / T) up to T
    rectangle      A up to T
    harmonic       A sin(2 pi f t), multiplied by sin^2(pi t / 2R) during an optional ramp R
    burst          A sin^2(pi t / T) sin(2 pi f t) up to T = n/f: n cycles under a window (Hann)
    up-and-down    A (1 - |2t/T - 1|) sin(2 pi f t) up to T
    sweep          A sin(2 pi (f t + (f_last - f) t^2 / 2T)) up to T, with a ramp at either end
    noise          sines at all multiples of 1/T from f to f_last, with equal amplitudes and random
                   phases, with the root mean square A; up to T, with a ramp at either end
    table          linear interpolation between points; a force is zero before and after, a
                   displacement begins at 0 and keeps its last value
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.schema import ValidationError, show
from granwave.lammps_inputs.files import read_number, read_text
from granwave.lammps_inputs.tables.encoding import decoded_table
from granwave.lammps_inputs.tables.layout import is_number, layout_of
from granwave.lammps_inputs.tables.units import in_si, split_unit, unit_of

Points = tuple[tuple[float, float], ...]

_N_OF_COLUMNS = 2  # time, and force or displacement
_MOST_HEADS = 2  # rows above the numbers: names and units
#: Units in the names of the columns of ``load.file``: powers of ten of the SI unit.
_UNITS = {"s": 0, "ms": -3, "us": -6, "ns": -9, "N": 0, "kN": 3, "m": 0, "mm": -3, "um": -6}

#: Keys that a shape requires, and optional keys.
SHAPES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "half-sine": (("amplitude", "duration"), ()),
    "rectangle": (("amplitude", "duration"), ()),
    "harmonic": (("amplitude", "frequency"), ("ramp",)),
    "burst": (("amplitude", "frequency", "cycles"), ()),
    "up-and-down": (("amplitude", "frequency", "duration"), ()),
    "sweep": (("amplitude", "frequency", "last_frequency", "duration"), ("ramp",)),
    "noise": (("amplitude", "frequency", "last_frequency", "duration"), ("ramp", "seed")),
    "table": (("table",), ()),
}
#: Keys of any shape.
SHAPE_KEYS = (
    "amplitude",
    "duration",
    "frequency",
    "last_frequency",
    "cycles",
    "ramp",
    "seed",
    "table",
)
_POINTS_FORM = "at least two rows [time in s, value], with times that increase from 0"


def _checked_points(points: Points) -> Points:
    """Return points whose times rise; raise `ValidationError` if they do not."""
    rising = all(earlier[0] < later[0] for earlier, later in pairwise(points))
    schema.refuse_if(points[0][0] < 0 or not rising, _POINTS_FORM)
    if expected := hints.impossible([time for time, _ in points], "s"):
        raise ValidationError(f"times of {expected}")
    schema.refuse_if(not any(size for _, size in points), "a value other than zero")
    return points


#: Type of the value of ``load.table``.
POINTS = schema.ListType(
    item=schema.vector_type(2, _POINTS_FORM),
    expected=_POINTS_FORM,
    at_least=2,
    finish=_checked_points,
)


def read_points(path: Path) -> Points:
    """Read the two columns of the file of ``load.file``; raise ValueError with the fault.

    The first line may have names with units: ``time (us); force (kN)``, or the units may be in the
    next line.
    """
    form = f"two columns of numbers, {_POINTS_FORM}"
    try:
        layout = layout_of(read_text(path, decoded_table))
    except ValueError as error:
        raise ValueError(f"{error}; expected {form}") from None
    powers = [0] * _N_OF_COLUMNS
    rows: list[list[float]] = []
    for row, line in enumerate(layout.numbers):
        cells = layout.cells(row)
        if not rows and row < _MOST_HEADS and _are_words(cells):
            powers = [
                power or _power(cell, line, is_unit=row > 0)
                for power, cell in zip(powers, cells, strict=True)
            ]
            continue
        try:
            pairs = zip(cells, powers, strict=True)
            time, value = (in_si(read_number(cell), power) for cell, power in pairs)
        except ValueError:
            found = show(" ".join(cells))
            raise ValueError(f"found {found} in line {line}; expected {form}") from None
        _refuse_point(time, value, rows, line, form)
        rows.append([time, value])
    try:
        return POINTS.read(rows)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise ValueError(f"found {show(rows)}, expected {error}") from None


def _refuse_point(
    time: float, value: float, before: Sequence[Sequence[float]], line: int, form: str
) -> None:
    """Raise ValueError, with the line, if a point is not finite or does not follow the points
    before it.
    """
    for number in (time, value):
        if not math.isfinite(number):
            raise ValueError(f"found {number} in line {line}; expected {form}, all finite")
    if before and time <= before[-1][0]:
        raise ValueError(
            f"found the time {time:g} s in line {line} after {before[-1][0]:g} s; expected {form}"
        )


def _are_words(cells: Sequence[str]) -> bool:
    """Return True for two cells without numbers."""
    return len(cells) == _N_OF_COLUMNS and not any(map(is_number, cells))


def _power(head: str, line: int, *, is_unit: bool) -> int:
    """Return the power of ten of the unit in the name of a column, or of the unit itself; 0 without
    a unit.
    """
    unit = unit_of(head) if is_unit else split_unit(head)[1]
    joined = head.rpartition("_")[2]  # time_us
    if joined in _UNITS:
        unit = joined
    if unit and unit not in _UNITS:
        expected = ", ".join(_UNITS)
        raise ValueError(f"line {line}: found the unit {show(unit)}, expected one of {expected}")
    return _UNITS[unit] if unit else 0
