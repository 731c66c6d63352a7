"""Ids of spheres, as the ``index`` keys of a case file give them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.schema import ValidationError, whole

_INDEX_FORM = "an id from 1 up, a list of ids, or {first = 8, last = 17}, with step = 3 for every third"
_MOST_IDS = 10_000_000  # in one list; a longer one would take gigabytes as Python integers


def parse_index(value: Any) -> tuple[int, ...]:
    """Convert the value of an ``index`` key to ids; raise `ValidationError` if it is none."""
    if isinstance(value, Mapping):
        if set(value) - {"step"} != {"first", "last"}:
            raise ValidationError(_INDEX_FORM)
        first, last, step = (whole(value.get(name, 1), _INDEX_FORM) for name in ("first", "last", "step"))
        if last < first:
            raise ValidationError(f"{_INDEX_FORM}, the last not before the first")
        if (last - first) // step >= _MOST_IDS:
            raise ValidationError(f"at most {_MOST_IDS} ids; take a box from low to high for more")
        return tuple(range(first, last + 1, step))
    ids = tuple(whole(one, _INDEX_FORM) for one in (value if isinstance(value, list | tuple) else [value]))
    if not ids:
        raise ValidationError(_INDEX_FORM)
    return ids
