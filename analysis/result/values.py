"""Impossible values of a result.h5: invalid ids, and numbers that are not finite.

A time is NaN if the event did not occur; a quantity of a snapshot is NaN for all spheres if LAMMPS
did not record it.
"""

from __future__ import annotations

from collections.abc import Iterator

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.case.schema import LARGEST_COUNT

_TABLES = ("spheres", "contacts", "wall_contacts", "energy", "probes", "prestage")
_OF_WALLS = "walls"  # one table for each wall
_OF_SPHERES = ("id", "mass", "radius", "position/time")  # data sets of the trajectory
_IDS = ("id", "i", "j")  # columns
_MAY_BE_NAN = "time_"  # prefix of columns
_RISING = ("spheres/id", f"{GROUP}/id", "energy/time", f"{GROUP}/position/time")
_MAY_BE_INFINITE = "yield_overlap"  # column that marks contacts that do not yield
_BLOCK = 2**20  # numbers that are read at a time


def wrong_value(file: h5py.File) -> str:
    """Describe the first impossible value; empty if there is none."""
    tables = [name for name in _TABLES if name in file]
    tables += [f"{_OF_WALLS}/{name}" for name in file.get(_OF_WALLS, {})]
    names = []
    for table in tables:
        for column in file[table]:
            names.append(f"{table}/{column}")
    names += [f"{GROUP}/{name}" for name in _OF_SPHERES if f"{GROUP}/{name}" in file]
    for name in names:
        if fault := _fault_of_column(file, name):
            return fault
    for quantity, element in file[GROUP].items():
        recorded = isinstance(element, h5py.Group) and "value" in element
        if recorded and (fault := _fault_of_snapshots(element["value"], quantity)):
            return fault
    return ""


def _fault_of_column(file: h5py.File, name: str) -> str:
    values = file[name]
    if not isinstance(values, h5py.Dataset) or values.dtype.kind not in "iuf":
        return ""
    column = name.rpartition("/")[2]
    last = -np.inf
    for first, block in _blocks(values):
        if values.dtype.kind == "f":
            wrong = ~np.isfinite(block)
            if column.startswith(_MAY_BE_NAN):
                wrong &= ~np.isnan(block)
            elif column == _MAY_BE_INFINITE:
                wrong &= block != np.inf
            expected = "a finite number"
        elif column in _IDS:
            wrong = (block < 1) | (block > LARGEST_COUNT)
            expected = "an id"
        else:
            continue
        if wrong.any():
            place = np.argwhere(wrong)[0]
            return (
                f"{name}: row {first + place[0]}: found {block[tuple(place)]}, expected {expected}"
            )
        if name in _RISING:
            if not (np.diff(np.concatenate([[last], block])) > 0).all():
                return f"{name}: found values that do not rise"
            last = block[-1]
    return ""


def _fault_of_snapshots(values: h5py.Dataset, quantity: str) -> str:
    for first, block in _blocks(values):
        if block.dtype.kind != "f":
            continue
        for number, snapshot in enumerate(block, start=first):
            wrong = ~np.isfinite(snapshot)
            if wrong.any() and not np.isnan(snapshot).all():
                place = tuple(np.argwhere(wrong)[0])
                where = f"{GROUP}/{quantity}: snapshot {number}, row {place[0]}"
                return f"{where}: found {snapshot[place]}, expected a finite number"
    return ""


def _blocks(values: h5py.Dataset) -> Iterator[tuple[int, NDArray]]:
    """Iterate over the number of the first row and the values of blocks of rows."""
    if not values.size:
        return
    step = max(1, _BLOCK * len(values) // values.size)
    for first in range(0, len(values), step):
        yield first, values[first : first + step]
