"""``result.h5`` of the two finite-element problems: written whole or not at all, and read again."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.result.trajectory import COMPRESSION
from granwave.lammps_inputs.run_directory import RESULT_FILE
from granwave.lammps_inputs.run_state import changed_result
from granwave.workflows.finite_elements.frame import ElementCase

_COMPRESSED_FROM = 4096  # values; smaller data sets are kept plain


@contextmanager
def new_result(directory: Path, kind: str, case: ElementCase, summary: Mapping[str, Any]) -> Iterator[h5py.File]:
    """Open a new ``result.h5`` in a directory; it is there once all has been put into it.

    Parameters
    ----------
    kind
        Of the result, as its root says.
    """
    with new_hdf5(directory / RESULT_FILE, libver="v110") as file:
        yield file
        file.attrs["kind"] = kind
        file.attrs["name"] = case.name
        file.attrs["case"] = case.to_toml()
        file.attrs["summary"] = json.dumps(summary)
        file.attrs["versions"] = json.dumps(summary["versions"])


def put_dataset(file: h5py.File, name: str, values: ArrayLike, unit: str) -> None:
    """Write a data set with its unit."""
    array = np.asarray(values)
    options: dict[str, Any] = dict(COMPRESSION) if array.size >= _COMPRESSED_FROM else {}
    file.create_dataset(name, data=array, **options).attrs["unit"] = unit


class ElementResult:
    """The ``result.h5`` of a finite-element run: all its data sets, its case and its summary.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    OutputFormatError
        It is damaged.
    """

    def __init__(self, directory: str | Path) -> None:
        path = Path(directory) / RESULT_FILE
        if not path.exists():
            raise MissingOutputError(f"{path} is missing: make it with  granwave continuum CASE -o {directory}")
        if changed := changed_result(path.parent):
            raise OutputFormatError(changed)
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
        """Further values that a kind of result reads."""

    def __getitem__(self, name: str) -> NDArray:
        """A data set by its name."""
        return self._values[name]

    def __contains__(self, name: str) -> bool:
        return name in self._values
