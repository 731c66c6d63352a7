"""The case of a finished continuum run, as its case.toml tells it: all values are filled in there."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.material import Material, read_material
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml


@dataclasses.dataclass(frozen=True)
class Block:
    """The block; lengths in m."""

    diameter: float
    height: float


@dataclasses.dataclass(frozen=True)
class Punch:
    """The rigid punch; SI units."""

    diameter: float
    mass: float
    velocity: float
    taper: float


@dataclasses.dataclass(frozen=True)
class Mesh:
    """Fineness of the mesh.

    Attributes
    ----------
    elements
        Number of elements that was asked for.
    edge_size
        Width of the elements at the punch's edge, m, or ``auto``.
    """

    elements: int
    edge_size: float | str


@dataclasses.dataclass(frozen=True)
class PunchCase:
    """A punch that hit a block."""

    material: Material
    block: Block
    punch: Punch
    run: Mesh


def read_punch_case(path: Path) -> PunchCase:
    """Read the case.toml of a finished run.

    Raises
    ------
    InputError
        It is missing, or not that of such a run.
    """
    tables, errors = read_toml(path), ErrorList(str(path))
    material = read_material(tables.get("material", {}), errors)
    if material is None or errors.lines:
        raise InputError(errors.lines or [f"{path}: found no material"])
    try:
        return PunchCase(
            material,
            _pick(Block, tables["block"]),
            _pick(Punch, tables["punch"]),
            _pick(Mesh, tables["run"]),
        )
    except (KeyError, TypeError):
        raise InputError(
            f"{path}: found no [block], [punch] and [run] with all values, expected a continuum run's"
        ) from None


def _pick(section: type, table: Mapping[str, Any]) -> Any:
    return section(**{field.name: table[field.name] for field in dataclasses.fields(section)})
