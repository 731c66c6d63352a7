"""Functions of time of forces and displacements, and points that give one.

With amplitude A, duration T and frequency f:

    half-sine      A sin(pi t / T) up to T
    rectangle      A up to T
    harmonic       A sin(2 pi f t), risen over a ramp R by sin^2(pi t / 2R) if there is one
    burst          A sin^2(pi t / T) sin(2 pi f t) up to T = n/f: n cycles under a window (Hann)
    up-and-down    A (1 - |2t/T - 1|) sin(2 pi f t) up to T
    sweep          A sin(2 pi (f t + (f_last - f) t^2 / 2T)) up to T, with a ramp at either end
    noise          sines at all multiples of 1/T from f to f_last, alike in size, of random phase,
                   with the root mean square A; up to T, with a ramp at either end
    table          linear interpolation between points; a force is zero before and after, a
                   displacement begins at 0 and keeps its last value
"""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.schema import ValidationError, show
from granwave.lammps_inputs.files import read_number, read_text

Points = tuple[tuple[float, float], ...]

#: Keys that a shape needs, and those that it may have.
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
_POINTS_FORM = "rows [time in s, value], at least two, times rising from 0 on"


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
    """Read the two columns of the file of ``load.file``; raise ValueError with the fault."""
    form = f"two columns of numbers, {_POINTS_FORM}"
    rows = []
    try:
        text = read_text(path)
    except ValueError as error:
        raise ValueError(f"{error}; expected {form}") from None
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            time, value = words
            rows.append([read_number(time), read_number(value)])
        except ValueError:
            found = show(" ".join(words))
            raise ValueError(f"found {found} in line {number}; expected {form}") from None
    try:
        return POINTS.read(rows)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise ValueError(f"found {show(rows)}, expected {error}") from None
