"""Form of the cases of the two finite-element problems."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

import tomli_w

from granwave.lammps_inputs.case.case import KNOWN, read_parts
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.overrides import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import ErrorList, keys_of, refuse_unknown
from granwave.lammps_inputs.memory import refuse_too_large
from granwave.lammps_inputs.named_files import with_absolute_paths
from granwave.lammps_inputs.toml_files import read_toml

_MEMORY_BASE = 350e6  # bytes; the interpreter with numba and the drawing library
_MEMORY_PER_ELEMENT = 2500.0  # measured, setting up included, rounded up


@dataclasses.dataclass(frozen=True, kw_only=True)
class ElementCase(abc.ABC):
    """A case with a mesh: ``run.elements`` tells how fine.

    Attributes
    ----------
    SECTIONS
        The dataclass of each table.
    REQUIRED
        Tables that the case cannot do without.
    """

    SECTIONS: ClassVar[Mapping[str, type]]
    REQUIRED: ClassVar[tuple[str, ...]] = ("material",)

    name: str

    @classmethod
    def from_dict(
        cls,
        data: Mapping[str, Any],
        source: str | Path = "case",
        overridden: Iterable[str] = (),
    ) -> Self:
        """Check the nested mapping of a case file and make a case of it; parameters as of `case_from_dict`.

        Raises
        ------
        InputError
            With every fault there is.
        """
        known = (*cls.SECTIONS, *keys_of({**cls.SECTIONS, "material": Material}))
        errors, data = ErrorList(str(source), tuple(overridden), known), with_absolute_paths(data, Path())
        own = [field.name for field in dataclasses.fields(cls)]
        others = [name for name in data if name in KNOWN and name not in own]
        for name in others:
            errors.add_unknown(name, "belongs to a granular case: granwave run runs it")
        refuse_unknown({name: table for name, table in data.items() if name not in others}, own, "", errors)
        parts = read_parts(data, source, errors, sections=cls.SECTIONS, required=cls.REQUIRED)
        cls._complete(parts, data, errors)
        errors.report(parts["name"])
        return cls(**parts)

    @staticmethod
    @abc.abstractmethod
    def _complete(parts: dict[str, Any], data: Mapping[str, Any], errors: ErrorList) -> None:
        """Read what is no section, and check what concerns several keys; a part that is wrong is None."""

    @classmethod
    def load(cls, path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Self:
        """Read a case file; ``overrides`` as of `granwave.lammps_inputs.load_case`.

        Raises
        ------
        InputError
            The file or an override is wrong; every fault is named.
        """
        changes = parse_overrides(overrides)
        data = apply_overrides(read_toml(path), changes)
        return cls.from_dict(data, path, overridden=changes)

    @property
    @abc.abstractmethod
    def elements(self) -> int:
        """About how many elements the mesh has."""

    @property
    def memory(self) -> float:
        """Bytes that a run needs, an estimate."""
        return _MEMORY_BASE + _MEMORY_PER_ELEMENT * self.elements

    def to_dict(self) -> dict[str, Any]:
        """The case as nested tables, all defaults filled in, as TOML writes them."""
        return _without_none(dataclasses.asdict(self))

    def to_toml(self) -> str:
        """The case as a TOML file."""
        return tomli_w.dumps(self.to_dict())


def check_memory(case: ElementCase, available: float | None = None) -> None:
    """Refuse a mesh that does not fit into memory (``available`` bytes; by default what is free now).

    Raises
    ------
    InputError
        The run needs more than there is.
    """
    what = f"{case.name}: run.elements: {case.elements} elements"
    refuse_too_large(what, case.memory, "take fewer elements", available)


def _without_none(tables: dict[str, Any]) -> dict[str, Any]:
    return {
        key: _without_none(value) if isinstance(value, dict) else value
        for key, value in tables.items()
        if value is not None
    }
