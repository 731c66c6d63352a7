"""``contact.initial_overlap``: dents that contacts have before the run."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.schema import ValidationError, finite, parse_point

_DENT_FORM = (
    "a number in m, the path of a result.h5, or tables {overlap = ...} or {force = ...} with low and high = [x, y, z]"
)


def parse_dents(value: Any) -> float | str | tuple[Dents, ...]:
    if isinstance(value, str) and value:
        return value
    if isinstance(value, Mapping | list | tuple):
        tables = [value] if isinstance(value, Mapping) else value
        if not tables:
            raise ValidationError(_DENT_FORM)
        return tuple(_parse_dent(table) for table in tables)
    size = finite(value, _DENT_FORM)
    if size < 0:
        raise ValidationError(f"{_DENT_FORM}, not negative")
    return size


def _parse_dent(table: Any) -> Dents:
    known = {"overlap", "force", "low", "high"}
    if not isinstance(table, Mapping) or not set(table) <= known or ("overlap" in table) == ("force" in table):
        raise ValidationError(_DENT_FORM)
    size = finite(table.get("overlap", table.get("force")), _DENT_FORM)
    if size < 0:
        raise ValidationError(f"{_DENT_FORM}, not negative")
    low, high = (parse_point(table[name], _DENT_FORM) if name in table else None for name in ("low", "high"))
    if low is not None and high is not None and any(a > b for a, b in zip(low, high, strict=True)):
        raise ValidationError("low of a box of dents below its high, along each axis")
    return Dents(overlap=size, low=low, high=high) if "overlap" in table else Dents(force=size, low=low, high=high)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dents:
    """Initial dents of the contacts in a box, given by the largest earlier overlap (m) or force (N)."""

    overlap: float | None = None
    force: float | None = None
    low: tuple[float, float, float] | None = None
    high: tuple[float, float, float] | None = None
