"""Readers by the name of their format, and reading of a file of grains of any of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, cast

from granwave.lammps_inputs.readers import (
    ase_files,
    esys,
    h5md,
    lammps_data,
    lammps_dump,
    lammps_molecule,
    lammps_yaml,
    mercury,
    mfix,
    table,
    vtk_files,
    xyz,
    xyzd,
    yade,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource


class GrainReader(Protocol):
    """Module that reads a format."""

    NAME: str
    LABEL: str
    recognises: Callable[[GrainSource], bool]
    read: Callable[[GrainSource], GrainTable]


_READERS = (
    h5md,
    vtk_files,
    lammps_dump,
    lammps_yaml,
    lammps_data,
    lammps_molecule,
    yade,
    mercury,
    esys,
    mfix,
    xyz,
    xyzd,
    table,
    ase_files,
)
#: Readers by format, in the order in which they are tried.
READERS: dict[str, GrainReader] = {module.NAME: cast("GrainReader", module) for module in _READERS}
_TABLES = (".csv", ".txt", ".dat", ".tsv")  # endings of files that are tables if nothing else
_LAMMPS_RESTART = b"LammpS RestartT"


def read_grain_table(source: GrainSource) -> GrainTable:
    """Read a file of grains, in the order of their ids.

    Raises
    ------
    OSError
        The file cannot be read.
    ValueError
        It is of no known format, or has a fault; the message states where, and the remedy.
    """
    if not source.content.strip():
        raise ValueError("found an empty file, expected a row or a line for each grain")
    return reader_of(source).read(source).in_order()


def reader_of(source: GrainSource) -> GrainReader:
    """Return the reader of a file, by the format that the user named, or by its content."""
    if source.options.format:
        return READERS[source.options.format]
    if source.content.startswith(_LAMMPS_RESTART):
        raise ValueError(
            "found a binary restart file of LAMMPS, expected text; make one by "
            "lmp -restart2data FILE FILE.data"
        )
    is_table = source.path.suffix.lower() in _TABLES
    for name, reader in READERS.items():
        if name == ase_files.NAME and is_table:
            return READERS[table.NAME]
        if name == table.NAME and not is_table and _is_left_to_ase(source):
            continue
        if reader.recognises(source):
            return reader
    return READERS[ase_files.NAME]


def _is_left_to_ase(source: GrainSource) -> bool:
    """Return True if a file has no names of columns, and ASE knows its format by its content or its
    ending.
    """
    if table.has_names(source):
        return False
    from ase.io import formats  # imported on demand: slow to load

    try:
        return bool(formats.filetype(str(source.path), guess=False))
    except Exception:  # ASE raises exceptions of all kinds
        return False
