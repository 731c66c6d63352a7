"""Other formats, read by ASE, in metres."""

from __future__ import annotations

import re
import warnings
from typing import Any

import numpy as np

from granwave.lammps_inputs.readers.columns import AXIS_PARTS, DIAMETER, RADIUS, WORDS
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.digits import half_units
from granwave.lammps_inputs.tables.units import in_si

NAME = "ase"
LABEL = "ASE"
_XYZ_DECIMALS = "0.00000001"  # decimals of the extended XYZ format of ASE
_JSON = re.compile(r'\s*(?:\{\s*"|\[\s*(?:\{|\[\s*[-0-9]))')
_STRAIGHT = 1e-9  # components of the edges of a box across its axes, over its largest edge
_NAMES = (DIAMETER, RADIUS, "length", *AXIS_PARTS, *WORDS)
_PLURALS = {RADIUS: "radii"}


def recognises(source: GrainSource) -> bool:
    """Return True: ASE reads the files that no other reader recognises."""
    return True


def read(source: GrainSource) -> GrainTable:
    """Read the last frame of a file by ASE, or the frame whose number is the step.

    Raises
    ------
    ValueError
        ASE cannot read it, or its atoms have momenta, whose units are those of atoms.
    """
    atoms = _read_atoms(source)
    if "momenta" in atoms.arrays and atoms.get_momenta().any():
        raise ValueError(
            "found momenta, whose units are those of atoms; give vx, vy, vz (m/s) in a table"
        )
    power = source.options.power()
    position = np.asarray(atoms.positions, dtype=np.float64)
    half = half_units([_XYZ_DECIMALS], position)
    columns = _columns(atoms, source)
    sizes = {name: columns.pop(name) for name in (DIAMETER, RADIUS) if name in columns}
    if not sizes and source.options.diameter is None:
        raise ValueError(
            "found no diameters, expected an array diameter or radius, or packing.diameter for "
            "all grains"
        )
    grains = GrainTable(format=LABEL, position=in_si(position, power), half_unit=in_si(half, power))
    if sizes:
        radius = sizes[DIAMETER] / 2 if DIAMETER in sizes else sizes[RADIUS]
        grains.radius = in_si(np.asarray(radius, dtype=np.float64), power)
    for name, values in columns.items():
        if name in WORDS:
            grains.words[name] = [str(word) for word in values]
        else:
            numbers = np.asarray(values, dtype=np.float64)
            grains.numbers[name] = in_si(numbers, power) if name == "length" else numbers
    _add_cell(atoms, grains, power)
    return grains


def _read_atoms(source: GrainSource) -> Any:
    """Read a frame of a file by ASE."""
    import ase.io  # imported on demand: slow to load
    from ase.io.formats import UnknownFileTypeError

    step = source.options.step
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # on the future of its readers
            return ase.io.read(source.path, index=-1 if step is None else step)
    except UnknownFileTypeError:
        reason = ""
    except Exception as error:  # ASE raises exceptions of all kinds
        reason = f" (ASE: {' '.join(str(error).split()) or type(error).__name__})"
    if _JSON.match(source.head):
        raise ValueError(
            "found JSON, expected a file of grains; write a table with a line x y z radius and a "
            "row for each grain"
        )
    kind = "a binary file" if source.is_binary else "a file"
    raise ValueError(
        f"found {kind} of no known format{reason}, expected a table, a dump or data file of "
        "LAMMPS, or another format of packing.format"
    )


def _columns(atoms: Any, source: GrainSource) -> dict[str, Any]:
    """Return the arrays of atoms by quantity."""
    columns: dict[str, Any] = {}
    for name in _NAMES:
        plural = _PLURALS.get(name, f"{name}s")
        named = str(source.options.names.get(name, name))
        for key in (plural, name, named):
            if key in atoms.arrays:
                columns[name] = atoms.arrays[key]
    return columns


def _add_cell(atoms: Any, grains: GrainTable, power: float) -> None:
    """Add the vectors of the periodic cell, and the box if its edges are along the axes."""
    repeats = atoms.pbc
    cell = in_si(np.asarray(atoms.cell.array, dtype=np.float64), power)
    grains.cell = [
        vector.tolist()
        for vector, there in zip(cell, repeats, strict=True)
        if there and any(vector)
    ]
    slant = np.abs(cell - np.diag(np.diag(cell))).max()
    is_straight = slant <= _STRAIGHT * np.abs(cell).max()
    if repeats[:2].all() and is_straight and min(cell[0, 0], cell[1, 1]) > 0:
        grains.bounds = np.stack([np.zeros(3), np.diag(cell)], axis=1)
        grains.periodic = tuple(bool(axis) for axis in repeats)  # type: ignore[assignment]
