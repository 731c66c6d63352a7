"""``packing.file`` and the keys for reading it; the stored case contains the grains."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.packing.grains import GrainChoices, Grains, read_grains
from granwave.lammps_inputs.case.schema import ErrorList, read_table
from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.columns import QUANTITIES
from granwave.lammps_inputs.readers.grain_table import TURNS
from granwave.lammps_inputs.readers.registry import READERS
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.units import LENGTH_UNITS, length_power

FORM_OF_FILE = (
    "the path of a table of grains (x, y, z, diameter in m), or of a dump or another packing"
)
TYPES = "types"
_BY_CONTENT = "auto"
_LARGEST_STEP = 2**63 - 1
_VELOCITIES = ("keep", "drop")
_COLUMNS_FORM = (
    'names of all columns in their order, such as ["x", "y", "z", "radius"], or the column of each '
    'quantity, such as {x = "pos_x", radius = 4}'
)
_UNITS_FORM = (
    f'one of {", ".join(map(show, LENGTH_UNITS))}, or the size of a voxel, such as "0.012 mm"'
)
_TYPES_FORM = 'a material for each type of the file, such as {1 = "steel", 2 = "ptfe"}'


@dataclasses.dataclass(frozen=True)
class ColumnsType(schema.ValueType):
    """Type of the names of columns: a list, or a table of quantities."""

    expected: str = _COLUMNS_FORM

    def read(self, value: Any) -> Any:
        """Return a tuple of names, or a table of names or numbers from 1."""
        if isinstance(value, Mapping):
            for quantity, name in value.items():
                near = schema.did_you_mean(quantity, QUANTITIES)
                unknown = f"{self.expected}; {quantity} is not a quantity{near}"
                schema.refuse_if(quantity not in QUANTITIES, unknown)
                is_name = isinstance(name, str | int) and not isinstance(name, bool)
                schema.refuse_if(not is_name, self.expected)
            return dict(value)
        schema.refuse_if(not isinstance(value, list | tuple) or not value, self.expected)
        schema.refuse_if(not all(isinstance(name, str) for name in value), self.expected)
        return tuple(value)

    @property
    def json(self) -> dict[str, Any]:
        """A list of names, or a table."""
        name = {"type": ["string", "integer"]}
        names = {"type": "array", "items": {"type": "string"}, "minItems": 1}
        return {"anyOf": [names, {"type": "object", "additionalProperties": name}]}


@dataclasses.dataclass(frozen=True)
class LengthUnitType(schema.ValueType):
    """Type of a unit of lengths, or of the size of a voxel."""

    expected: str = _UNITS_FORM

    def read(self, value: Any) -> str:
        """Return the unit."""
        schema.refuse_if(not isinstance(value, str), self.expected)
        try:
            length_power(value)
        except ValueError:
            near = schema.did_you_mean(value, LENGTH_UNITS)
            raise schema.ValidationError(self.expected + near) from None
        return str(value)

    @property
    def json(self) -> dict[str, Any]:
        """A word."""
        return {"type": "string"}


@dataclasses.dataclass(frozen=True)
class MaterialOfTypesType(schema.ValueType):
    """Type of a table of materials by type of the file."""

    expected: str = _TYPES_FORM

    def read(self, value: Any) -> dict[str, str]:
        """Return the names of the materials by type."""
        schema.refuse_if(not isinstance(value, Mapping) or not value, self.expected)
        schema.refuse_if(not all(isinstance(one, str) for one in value.values()), self.expected)
        return dict(value)

    @property
    def json(self) -> dict[str, Any]:
        """A table of words."""
        return {"type": "object", "additionalProperties": {"type": "string"}}


@dataclasses.dataclass(frozen=True, kw_only=True)
class GrainFileSection:
    """Keys of ``[packing]`` for reading ``packing.file``."""

    file: str | None = schema.path(
        "grains of a packing of kind file: a table (x, y, z, diameter ...), a LAMMPS dump or data "
        "file, or a file of another program",
        default=None,
    )
    format: str = schema.choice(
        "format of the file; auto: detected from its content",
        (_BY_CONTENT, *READERS),
        default=_BY_CONTENT,
    )
    columns: Any = schema.typed(
        "names of the columns, if the file has no names or unusual names",
        ColumnsType(),
        default=(),
    )
    units: str | None = schema.typed(
        "unit of the lengths of the file (and of its velocities, per second), if the names of its "
        "columns do not state it, or the size of a voxel of an image; metres by default",
        LengthUnitType(),
        default=None,
    )
    step: int | None = schema.typed(
        "timestep to read from a file with several timesteps; default: the last timestep",
        schema.CountType(at_least=0, at_most=_LARGEST_STEP, form="a whole number from 0 up"),
        default=None,
    )
    types: dict[str, str] | None = schema.typed(
        "material of each type of grains of the file", MaterialOfTypesType(), default=None
    )
    velocities: str = schema.choice(
        "initial velocities of the file: keep or discard", _VELOCITIES, default=_VELOCITIES[0]
    )

    up: str = schema.choice(
        "direction of the file that points up; in granwave the top is at the lowest z",
        tuple(TURNS),
        default="-z",
    )

    def options(self, diameter: float | None) -> FileOptions:
        """Return the options of the reader; ``diameter`` is the diameter of grains without one,
        m.
        """
        return FileOptions(
            format="" if self.format == _BY_CONTENT else self.format,
            columns=self.columns,
            units=self.units or "",
            step=self.step,
            diameter=diameter,
        )


FILE_FIELDS = schema.declared_fields(GrainFileSection)


def read_grain_file(
    table: Mapping[str, Any], diameter: float | None, errors: ErrorList
) -> Grains | None:
    """Read the grains of the file that ``[packing]`` names; None with a fault.

    Parameters
    ----------
    table
        The table ``[packing]``.
    diameter
        Diameter of grains for which the file has none, m.
    """
    own = {name: value for name, value in table.items() if name in FILE_FIELDS and name != "file"}
    section = read_table(GrainFileSection, own, "packing", errors)
    if section is None:
        return None
    options = section.options(diameter)
    choices = GrainChoices(
        materials=section.types or {},
        keeps_velocities=section.velocities == _VELOCITIES[0],
        up=section.up,
    )

    def read(path: Path) -> Grains:
        return read_grains(GrainSource(path, options), choices)

    grains = schema.read_named("packing.file", table["file"], FORM_OF_FILE, read, errors)
    if grains is not None and grains.reading is not None:
        errors.notes += [f"packing.file: {table['file']}: {note}" for note in grains.reading.notes]
    return grains
