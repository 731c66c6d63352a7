"""Table of the kinds of loads, the keys of ``[load]``, and its reader."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any, get_type_hints

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.loads.displacement import DisplacementLoad
from granwave.lammps_inputs.case.loads.force import ForceLoad
from granwave.lammps_inputs.case.loads.grains import GrainsLoad
from granwave.lammps_inputs.case.loads.impact import ImpactLoad
from granwave.lammps_inputs.case.loads.load import Load
from granwave.lammps_inputs.case.loads.plate import PlateLoad
from granwave.lammps_inputs.case.loads.shapes import read_points
from granwave.lammps_inputs.case.loads.striker import StrikerLoad
from granwave.lammps_inputs.case.schema import ErrorList, info_of, read_table, show
from granwave.lammps_inputs.case.schema.reading import FURTHER_KEYS
from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.extensions import joined, loaded

#: Loads of the core; the first one is the default.
_OWN: tuple[type[Load], ...] = (
    ImpactLoad,
    StrikerLoad,
    ForceLoad,
    DisplacementLoad,
    PlateLoad,
    GrainsLoad,
)

Field = dataclasses.Field[Any]


@cache
def load_kinds() -> dict[str, type[Load]]:
    """Return all kinds of loads by name: loads of the core, then loads of extensions.

    Raises
    ------
    InputError
        Two loads have the same name, or an extension cannot be loaded.
    """
    added = {name: _by_kind(loads) for name, loads in loaded("loads").items()}
    return joined("load.kind", _by_kind(_OWN), added)


def _by_kind(loads: Iterable[type[Load]]) -> dict[str, type[Load]]:
    return {load.kind: load for load in loads}


def load_keys(load: type[Load]) -> tuple[str, ...]:
    """Return the keys that a kind of load takes."""
    fields = (field.name for field in dataclasses.fields(load))
    return ("kind", *fields, *load.other_keys)


def _own_fields_first(load: type) -> list[Field]:
    """Return the fields of a kind of load, its own fields before the fields of its base class."""
    if load is Load:
        return []
    (base,) = load.__bases__
    inherited = [field.name for field in dataclasses.fields(base)]
    own = [field for field in dataclasses.fields(load) if field.name not in inherited]
    return [*own, *_own_fields_first(base)]


_FILE = schema.path(
    "the table as a file: two columns, time (s) and force (N) or displacement (m)", default=None
)


@cache
def load_section() -> type:
    """Return the section of the keys of all kinds of loads, from which `read_load` makes the load;
    the keys of the kind with the fewest keys come first.

    Raises
    ------
    InputError
        As of `load_kinds`.
    """
    kinds = load_kinds()
    meanings = ", ".join(f"{name} ({load.means})" for name, load in kinds.items())
    kind: Any = schema.choice(f"kind of load: {meanings}", tuple(kinds), default=next(iter(kinds)))
    keys: dict[str, tuple[str, Any, Field]] = {}
    owners: dict[str, type[Load]] = {}
    for load in sorted(kinds.values(), key=lambda load: len(load_keys(load))):
        types = get_type_hints(load)
        for field in _own_fields_first(load):
            copy: Field = dataclasses.field(default=field.default, metadata=field.metadata)
            _, _, there = keys.setdefault(field.name, (field.name, types[field.name], copy))
            owner = owners.setdefault(field.name, load)
            _check_same(there, copy, f"load.{field.name}", owner, load)
    _give_keys_of_others(keys)
    return dataclasses.make_dataclass(
        "LoadSection",
        [("kind", str, kind), *keys.values()],
        namespace={"__doc__": "``[load]``: the load on a packing.", FURTHER_KEYS: {"file": _FILE}},
        frozen=True,
        kw_only=True,
    )


def _check_same(one: Field, other: Field, key: str, *loads: type[Load]) -> None:
    """Raise InputError unless a key has the same meaning in two loads."""
    same = info_of(one).description == info_of(other).description and one.default == other.default
    if not same:
        whose = " and ".join(f"{load.__name__} of {load.__module__}" for load in loads)
        raise InputError(
            f"{key}: {whose} define this key with different meanings or defaults; rename one of "
            "them"
        )


def _give_keys_of_others(names: Iterable[str]) -> None:
    """Set keys of other kinds to None, so that studies can read e.g. `run.case.load.amplitude` of
    an impact.
    """
    for name in names:
        if not hasattr(Load, name):
            setattr(Load, name, None)


for _load in _OWN:
    _give_keys_of_others(field.name for field in dataclasses.fields(_load))


def read_load(table: Any, errors: ErrorList) -> Load | None:
    """Read ``[load]``; missing and wrong values are added to ``errors``.

    The points of ``load.file`` become ``load.table``, so that the case is complete without the
    file.
    """
    before = len(errors.items)
    names = list(table) if isinstance(table, Mapping) else []
    if "file" in names:
        table = _with_points(table, errors)
    values = read_table(load_section(), table, "load", errors) if table is not None else None
    if values is None:
        return None
    kind = values.kind  # type: ignore[attr-defined]
    load = load_kinds()[kind]
    fields = (field.name for field in dataclasses.fields(load))
    made = load(**{name: getattr(values, name) for name in fields})
    _check_keys(load, names, errors)
    made.check(names, errors)
    return made if len(errors.items) == before else None


def _check_keys(load: type[Load], names: Sequence[str], errors: ErrorList) -> None:
    """Check that the keys of the table belong to the kind of load."""
    for name in names:
        kinds = [kind for kind, other in load_kinds().items() if name in load_keys(other)]
        belongs = f"applies only to loads of kind {' or '.join(map(show, kinds))}"
        text = f'{belongs}; found load.kind = "{load.kind}"'
        errors.check((load.kind not in kinds, f"load.{name}", text))


def _with_points(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any] | None:
    """Return the table with the points of ``load.file`` as ``load.table``; None if there is a
    fault.
    """
    if "table" in table:
        errors.add(
            "load.file", Mismatch("together with load.table", remedy="specify only one of them")
        )
        return None
    expected = "the path of a file of two columns, time and value"
    points = schema.read_named("load.file", table["file"], expected, read_points, errors)
    if points is None:
        return None
    others = {name: value for name, value in table.items() if name != "file"}
    return {"shape": "table", "table": points} | others
