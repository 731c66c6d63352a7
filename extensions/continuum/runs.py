"""Finished runs of finite elements with their cases, as studies take them from a report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.analysis.studies.runs import AnyRun
from granwave.lammps_inputs.case.material import read_material
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.run_directory import CASE_FILE

_OF_A_PUNCH = {  # keys that case.toml holds for a punch on a block
    "block": ("diameter", "height"),
    "punch": ("diameter", "mass", "velocity", "taper"),
    "run": ("elements", "edge_size"),
}


class ContinuumRun(AnyRun[Mapping[str, Any]]):
    """A finished run of a punch on a block; its case is the content of case.toml, with all
    values filled in.
    """


class SphereContactRun(AnyRun[Mapping[str, Any]]):
    """A finished run of two finite-element spheres; its case is the content of case.toml."""


def read_elements(
    label: str, directory: Path, summary: Mapping[str, Any]
) -> ContinuumRun | SphereContactRun | None:
    """Read a finished run of finite elements; None if its case cannot be read."""
    try:
        tables = read_toml(directory / CASE_FILE)
    except GranwaveError:
        return None  # the report states it elsewhere
    if summary.get("kind") == "sphere-contact":
        return SphereContactRun(label, directory, tables, summary)
    errors = ErrorList("")
    whole = all(set(keys) <= set(tables.get(name, {})) for name, keys in _OF_A_PUNCH.items())
    sound = read_material(tables.get("material", {}), errors) is not None and not errors.items
    return ContinuumRun(label, directory, tables, summary) if whole and sound else None
