"""``[[absorb]]``: spheres that are damped, so that waves run out of the packing."""

from __future__ import annotations

import dataclasses
from typing import Any

from granwave.lammps_inputs.case.ids import parse_index
from granwave.lammps_inputs.case.schema import ValidationError, choice, count, custom, finite, number
from granwave.lammps_inputs.case.si_values import Usual

MATCHED = "matched"
_DIRECTIONS = ("+z", "-z", "+x", "-x", "+y", "-y", "none")
_RATE = Usual(1.0, 1e8)


def _parse_impedance(value: Any) -> float | str:
    expected = 'a number above 0, or "matched"'
    if value == MATCHED:
        return MATCHED
    found = finite(value, expected)
    if found <= 0:
        raise ValidationError(expected)
    return found


@dataclasses.dataclass(frozen=True, kw_only=True)
class Absorb:
    """``[[absorb]]``: spheres that are damped, so that waves run out of the packing.

    ``rate`` damps motion in all directions, and rotation, by m rate v: a layer that becomes stronger with depth
    reflects little over many frequencies. ``impedance`` is a dashpot along z on each sphere: the end of a row, without
    reflection where it is the impedance of the row.
    """

    index: tuple[int, ...] | None = custom("which spheres", parse_index, default=None)
    layers: int | None = count("the last layers of the packing; of a chain its last spheres", default=None)
    rate: float | None = number(
        "largest damping rate: the force is mass x rate x velocity", unit="1/s", above=0, default=None, usual=_RATE
    )
    towards: str = choice(
        'direction in which the rate rises, as the square of the depth, from zero; "none": the same everywhere',
        _DIRECTIONS,
        default="+z",
    )
    impedance: float | str | None = custom(
        "force along z over the velocity of each sphere; matched: that of long waves under the precompression",
        _parse_impedance,
        unit="N s/m",
        default=None,
    )
