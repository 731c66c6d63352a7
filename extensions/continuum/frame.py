"""Form of the cases of the two finite-element problems."""

from __future__ import annotations

import abc
import dataclasses
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar, Self

import tomli_w

from granwave.lammps_inputs.case.case import KNOWN
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides, read_parts
from granwave.lammps_inputs.case.schema import ErrorList, keys_of, refuse_unknown
from granwave.lammps_inputs.files import read_toml, refuse_too_large, with_absolute_paths

_MEMORY_BASE = 350e6  # bytes; the interpreter with numba and the drawing library
_MEMORY_PER_ELEMENT = 2500.0  # measured with set-up, rounded up


@dataclasses.dataclass(frozen=True, kw_only=True)
class ElementCase(abc.ABC):
    """Base class of the finite-element cases.

    Attributes
    ----------
    SECTIONS
        Dataclass of each table, by name.
    REQUIRED
        Names of the tables that must be there.
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
        """Make a case from the nested mapping of a case file, and check it; parameters as in
        `case_from_dict`.

        Raises
        ------
        InputError
            The case is invalid; the message lists all faults.
        """
        known = (*cls.SECTIONS, *keys_of({**cls.SECTIONS, "material": Material}))
        errors = ErrorList(str(source), tuple(overridden), known)
        data = with_absolute_paths(data, Path())
        own = [field.name for field in dataclasses.fields(cls)]
        for name in [name for name in data if name in KNOWN and name not in own]:
            errors.add_unknown(name, "is a key of granular cases; use granwave run")
        refuse_unknown(
            {name: data[name] for name in data if name in own or name not in KNOWN}, own, "", errors
        )
        parts = read_parts(data, source, errors, sections=cls.SECTIONS, required=cls.REQUIRED)
        cls._complete(parts, data, errors)
        errors.report(parts["name"])
        return cls(**parts)

    @staticmethod
    @abc.abstractmethod
    def _complete(parts: dict[str, Any], data: Mapping[str, Any], errors: ErrorList) -> None:
        """Read further parts, and check keys against each other; invalid parts are None."""

    @classmethod
    def load(cls, path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Self:
        """Read a case file; ``overrides`` as in `granwave.lammps_inputs.load_case`.

        Raises
        ------
        InputError
            The file or an override is invalid; the message lists all faults.
        """
        changes = parse_overrides(overrides)
        data = apply_overrides(read_toml(path), changes)
        return cls.from_dict(data, path, overridden=changes)

    @property
    def elements(self) -> int:
        """Approximate number of elements of the mesh, or of both spheres together."""
        return int(self.run.elements)  # type: ignore[attr-defined]

    @property
    def memory(self) -> float:
        """Estimated memory of a run, bytes."""
        return _MEMORY_BASE + _MEMORY_PER_ELEMENT * self.elements

    def to_dict(self) -> dict[str, Any]:
        """Return the case as nested tables of TOML values, all defaults filled in."""

        def known(items: list[tuple[str, Any]]) -> dict[str, Any]:
            return {key: value for key, value in items if value is not None}

        return dataclasses.asdict(self, dict_factory=known)

    def to_toml(self) -> str:
        """Return the case as the text of a TOML file."""
        return tomli_w.dumps(self.to_dict())


@dataclasses.dataclass(frozen=True)
class ElementPlan:
    """Size and cost of a finite-element run.

    Attributes
    ----------
    memory, disk, disk_reserve
        Estimates in bytes; files are written at the end, so that no reserve is needed.
    wall_time
        Estimated wall time, s.
    """

    name: str
    n_elements: int
    memory: float
    disk: float
    wall_time: float
    disk_reserve: float = 0.0


def check_memory(case: ElementCase, available: float | None = None) -> None:
    """Raise InputError if a mesh does not fit into memory (``available`` bytes; by default that of
    the machine).

    Raises
    ------
    InputError
        The run needs more memory than available.
    """
    what = f"{case.name}: run.elements: {case.elements} elements"
    refuse_too_large(what, case.memory, "use fewer elements", available)
