"""Units of the keys of all kinds of cases."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from granwave.lammps_inputs.case.boundary import Damper, HalfSpace, Plate, SupportBar
from granwave.lammps_inputs.case.case import unit_of as granular_unit_of

# Keys of continuum cases, whose schema belongs to their solver; a test compares both.
CONTINUUM_UNITS = {
    "block.diameter": "m",
    "block.height": "m",
    "punch.diameter": "m",
    "punch.mass": "kg",
    "punch.velocity": "m/s",
    "punch.taper": "m",
    "run.edge_size": "m",
    "run.frame_interval": "s",
}
#: Key whose unit follows from the kind of the load, and the key of that.
AMPLITUDE, LOAD_KIND = "load.amplitude", "load.kind"
_OF_AMPLITUDES = {"force": "N", "displacement": "m"}
_BOTTOM = "boundary.bottom."
_SUPPORTS: dict[str, type] = {"plate": Plate, "damper": Damper, "half_space": HalfSpace, "bar": SupportBar}


def unit_of(key: str) -> str:
    """Return the unit of a dotted key, such as ``load.velocity`` or ``punch.mass``; empty if it has none.

    That of `AMPLITUDE` follows from the kind of the load: `amplitude_unit`.
    """
    if key == AMPLITUDE:
        return ""
    if key.startswith(_BOTTOM):
        return _unit_in(_SUPPORTS, key.removeprefix(_BOTTOM)) or granular_unit_of(key)
    return granular_unit_of(key) or CONTINUUM_UNITS.get(key, "")


def amplitude_unit(kinds: Iterable[str]) -> str:
    """Return the unit of `AMPLITUDE` for loads of these kinds; empty if they differ, or none has an amplitude."""
    units = {_OF_AMPLITUDES.get(kind, "") for kind in kinds}
    return units.pop() if len(units) == 1 else ""


def shown_unit(key: str) -> str:
    """Unit of a dotted key as people write it: kg/m³."""
    return printed_unit(unit_of(key))


def unit_in_cases(key: str, cases: Iterable[Mapping[str, Any]]) -> str:
    """Unit, as people write it, of a dotted key of cases, each given by dotted keys."""
    if key == AMPLITUDE:
        return amplitude_unit(str(case.get(LOAD_KIND)) for case in cases if key in case)
    return shown_unit(key)


def printed_unit(unit: str) -> str:
    """A unit as people write it: kg/m³ for kg/m^3."""
    return unit.replace("^2", "²").replace("^3", "³")


def _unit_in(tables: Mapping[str, type], key: str) -> str:
    table, _, name = key.partition(".")
    fields = {field.name: field for field in dataclasses.fields(tables[table])} if table in tables else {}
    return (fields[name].metadata.get("unit") or "") if name in fields else ""
