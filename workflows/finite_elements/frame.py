"""Common parts of the finite-element programs: base of their cases, directory of a run, ``result.h5``."""

from __future__ import annotations

import abc
import dataclasses
import json
import logging
import os
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar, Self

import h5py
import tomli_w
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.lammps_inputs.case.case import KNOWN, read_parts
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.overrides import apply_overrides, parse_overrides
from granwave.lammps_inputs.case.schema import ErrorList, keys_of, refuse_unknown
from granwave.lammps_inputs.directories import decide
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.memory import refuse_too_large
from granwave.lammps_inputs.named_files import with_absolute_paths
from granwave.lammps_inputs.ownership import claim, clear, figure_files, refuse_foreign
from granwave.lammps_inputs.run_directory import CASE_FILE, CONTINUUM, FIGURES_DIRECTORY, RESULT_FILE
from granwave.lammps_inputs.run_state import read_summary, restore_case, result_fault
from granwave.lammps_inputs.toml_files import read_toml

logger = logging.getLogger("granwave")

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
        """Make a case from the nested mapping of a case file, and check it; parameters as in `case_from_dict`.

        Raises
        ------
        InputError
            The case is wrong; the message lists all faults.
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
        """Read further parts, and check keys against each other; parts that are wrong are None."""

    @classmethod
    def load(cls, path: str | Path, overrides: Iterable[str] | Mapping[str, Any] = ()) -> Self:
        """Read a case file; ``overrides`` as in `granwave.lammps_inputs.load_case`.

        Raises
        ------
        InputError
            The file or an override is wrong; the message lists all faults.
        """
        changes = parse_overrides(overrides)
        data = apply_overrides(read_toml(path), changes)
        return cls.from_dict(data, path, overridden=changes)

    @property
    @abc.abstractmethod
    def elements(self) -> int:
        """Approximate number of elements of the mesh."""

    @property
    def memory(self) -> float:
        """Estimated memory of a run, bytes."""
        return _MEMORY_BASE + _MEMORY_PER_ELEMENT * self.elements

    def to_dict(self) -> dict[str, Any]:
        """Return the case as nested tables of TOML values, all defaults filled in."""
        return _without_none(dataclasses.asdict(self))

    def to_toml(self) -> str:
        """Return the case as the text of a TOML file."""
        return tomli_w.dumps(self.to_dict())


def check_memory(case: ElementCase, available: float | None = None) -> None:
    """Raise InputError if a mesh does not fit into memory (``available`` bytes; by default that of the machine).

    Raises
    ------
    InputError
        The run needs more memory than available.
    """
    what = f"{case.name}: run.elements: {case.elements} elements"
    refuse_too_large(what, case.memory, "take fewer elements", available)


def begin(
    case: ElementCase,
    directory: Path,
    results: Sequence[str],
    finished: Sequence[str],
    *,
    resume: bool,
    force: bool,
    figures: Callable[[], Iterable[str]] | None,
) -> dict[str, Any] | None:
    """Prepare a directory for a run, or read the summary of a finished run of the same case.

    Parameters
    ----------
    results
        Names of the files that a run writes.
    finished
        Values of ``end_reason`` of finished runs.
    figures
        Function that returns the names of the figures, called if figures may exist; None: none are drawn.

    Returns
    -------
    dict or None
        Values of summary.json of the finished run; None if the case must be run, for which case.toml has been written.

    Raises
    ------
    InputError
        The directory holds results, or another case, or files that granwave did not write and would overwrite, or the
        mesh does not fit into memory; nothing was changed.
    """

    def there(tables: Mapping[str, Any]) -> Mapping[str, Any]:
        try:
            return type(case).from_dict(tables, directory / CASE_FILE).to_dict()
        except InputError:
            return {}  # a case of another kind, which differs in any case

    names = list(results)
    if figures and os.path.lexists(directory / FIGURES_DIRECTORY):
        names += [file for name in figures() for file in figure_files(name)]
    if decide(directory, CONTINUUM, names, resume=resume, force=force, case=case.to_dict(), read=there):
        summary, fault = read_summary(directory), result_fault(directory)
        if summary.get("end_reason") in finished and not fault:
            restore_case(directory)
            return summary
        if summary.get("end_reason") in finished:
            logger.warning("%s; the case is run again", fault)
        refuse_foreign(directory, names)
    check_memory(case)
    clear(directory)
    directory.mkdir(parents=True, exist_ok=True)
    text = case.to_toml()
    claim(directory, results, kind=CONTINUUM, case=text)
    replace_text(directory / CASE_FILE, text)
    return None


class ElementResult:
    """Data sets, case and summary in the ``result.h5`` of a finite-element run.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        The file is damaged.
    """

    def __init__(self, directory: str | Path) -> None:
        path = Path(directory) / RESULT_FILE
        if not path.exists():
            raise MissingOutputError(f"{path} is missing: make it with  granwave continuum CASE -o {directory}")
        try:
            with h5py.File(path, "r") as file:
                self._read(file)
        except (OSError, KeyError, ValueError) as error:
            raise OutputFormatError(
                f"{path}: is damaged ({' '.join(str(error).split())}); run the case again"
            ) from None

    def _read(self, file: h5py.File) -> None:
        names: list[str] = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        self._values: dict[str, NDArray] = {name: file[name][()] for name in names}
        self.tables: dict[str, Any] = tomllib.loads(str(file.attrs["case"]))
        self.summary: dict[str, Any] = json.loads(str(file.attrs["summary"]))
        self._read_more(file)

    def _read_more(self, file: h5py.File) -> None:
        """Read further values; for derived classes."""

    def __getitem__(self, name: str) -> NDArray:
        """Return a data set by its name."""
        return self._values[name]

    def __contains__(self, name: str) -> bool:
        return name in self._values


def _without_none(tables: dict[str, Any]) -> dict[str, Any]:
    return {
        key: _without_none(value) if isinstance(value, dict) else value
        for key, value in tables.items()
        if value is not None
    }
