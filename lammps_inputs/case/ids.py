"""Ids of grains in keys: a single id, a list, or a range."""

from __future__ import annotations

import dataclasses

from granwave.lammps_inputs.case import schema

INDEX_FORM = (
    "an id from 1 up, a list of ids, or {first = 8, last = 17}, with step = 3 for every third"
)
# most ids in one list; a longer list would take gigabytes as Python integers
_MOST_IDS = 10_000_000
_ID = schema.CountType(form=INDEX_FORM)


@dataclasses.dataclass(frozen=True, kw_only=True)
class IdRange:
    """Ids from one to another, in steps."""

    first: int = schema.typed("first id", _ID)
    last: int = schema.typed("last id, if a step reaches it", _ID)
    step: int = schema.typed("step to the next id", _ID, default=1)

    def ids(self) -> tuple[int, ...]:
        """Return all ids; raise `ValidationError` if there are none, or too many."""
        is_empty = self.last < self.first
        schema.refuse_if(is_empty, f"{INDEX_FORM}, the last not before the first")
        is_long = (self.last - self.first) // self.step >= _MOST_IDS
        schema.refuse_if(is_long, f"at most {_MOST_IDS} ids; use a box from low to high for more")
        return tuple(range(self.first, self.last + 1, self.step))


#: Type of the values of ``index`` keys.
INDEX = schema.EitherType(
    types=(
        schema.TableType(section=IdRange, expected=INDEX_FORM, finish=IdRange.ids, listed=False),
        schema.ListType(item=_ID, expected=INDEX_FORM, alone=True),
    ),
    form=INDEX_FORM,
)
