"""Units of the keys of cases, of whatever kind."""

from __future__ import annotations

import dataclasses

from granwave.analysis.continuum.case import Block, ContinuumRun, Punch
from granwave.lammps_inputs.case import unit_of as granular_unit_of

_CONTINUUM: dict[str, type] = {"block": Block, "punch": Punch, "run": ContinuumRun}


def unit_of(key: str) -> str:
    """Unit of a dotted key, such as ``load.velocity`` or ``punch.mass``; empty where it has none."""
    return granular_unit_of(key) or _continuum_unit_of(key)


def _continuum_unit_of(key: str) -> str:
    table, _, name = key.partition(".")
    fields = {field.name: field for field in dataclasses.fields(_CONTINUUM[table])} if table in _CONTINUUM else {}
    return (fields[name].metadata["unit"] or "") if name in fields else ""
