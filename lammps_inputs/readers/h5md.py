"""Trajectories in H5MD form: positions and radii of a group of particles, by default the last step.

https://www.nongnu.org/h5md/h5md.html
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.message_words import show
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.readers.vtk_files import grains_of_arrays
from granwave.lammps_inputs.tables.units import LENGTH_UNITS, in_si

NAME = "h5md"
LABEL = "H5MD"
_SIGNATURE = b"\x89HDF\r\n\x1a\n"
_NAMES = {"species": "type"}


def recognises(source: GrainSource) -> bool:
    """Return True for a file of HDF5."""
    return source.content.startswith(_SIGNATURE)


def read(source: GrainSource) -> GrainTable:
    """Read the particles of a step.

    Raises
    ------
    ValueError
        There are no particles, none of that step, or they have no sizes.
    """
    import h5py  # imported on demand: slow to load

    try:
        file = h5py.File(io.BytesIO(source.content), "r")
    except OSError as error:
        raise ValueError(f"found an HDF5 file that is damaged or truncated ({error})") from None
    with file:
        groups = file.get("particles")
        names = list(groups) if groups is not None else []
        if not names or "position" not in groups[names[0]]:
            raise ValueError("found no particles with a position, expected an H5MD file with them")
        return _grains(groups[names[0]], source)


def _grains(group: Any, source: GrainSource) -> GrainTable:
    """Return the grains of a group of particles."""
    options = source.options
    position = group["position"]
    step, row = _step(position, options.step)
    power = options.power() if options.units else _power(position)
    points = _at(position, step, row)
    if points is None:
        raise ValueError("found no values of the positions, expected an H5MD file with them")
    arrays = {}
    for name in group:
        if name in ("position", "box", "image", "force"):
            continue
        values = _at(group[name], step, row)
        if values is not None and len(values) == len(points):
            arrays[_NAMES.get(name, name)] = values
    grains = grains_of_arrays(f"{LABEL} trajectory, step {step}", points, arrays, options)
    if power and not options.units:
        grains.position = in_si(grains.position, power)
        grains.half_unit = in_si(grains.half_unit, power)
        grains.radius = None if grains.radius is None else in_si(grains.radius, power)
        grains.velocity = None if grains.velocity is None else in_si(grains.velocity, power)
    _add_box(group, grains, (step, row), power)
    return grains


def _power(position: Any) -> int:
    """Return the power of ten of the unit of the positions; 0 for a file without a unit."""
    unit = _word(_values(position).attrs.get("unit", _word(position.attrs.get("unit", ""))))
    if unit and unit not in LENGTH_UNITS:
        raise ValueError(
            f"found positions in the unit {show(unit)}, expected {', '.join(LENGTH_UNITS)}; give "
            'it, such as packing.units = "mm"'
        )
    return LENGTH_UNITS[unit] if unit else 0


def _word(value: Any) -> str:
    """Return an attribute as a word; strings of C are bytes."""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _values(element: Any) -> Any:
    """Return the values of an element, whether it depends on time or not."""
    return element["value"] if hasattr(element, "keys") else element


def _step(position: Any, wanted: int | None) -> tuple[int, int]:
    """Return number and row of the step to be read."""
    if not hasattr(position, "keys"):
        return 0, 0
    n_rows = len(position["value"])
    steps = _steps(position)
    if wanted is None:
        return int(steps[-1]), n_rows - 1
    rows = np.flatnonzero(steps == wanted)
    if not len(rows):
        raise ValueError(
            f"found no step {wanted} (packing.step), expected one from {steps[0]} to {steps[-1]}"
        )
    return wanted, int(rows[-1])


def _steps(element: Any) -> NDArray[np.generic]:
    """Return the step of each row of an element; without any, the numbers of the rows: (n,)."""
    n_rows = len(element["value"])
    steps = np.asarray(element["step"][()]) if "step" in element else np.arange(n_rows)
    if steps.ndim:
        return np.broadcast_to(steps, (n_rows,))
    return np.asarray(steps * np.arange(n_rows))


def _at(element: Any, step: int, row: int) -> NDArray[np.generic] | None:
    """Return the values of an element at a step; None for other groups, or without values at this
    step.
    """
    if hasattr(element, "keys"):
        if "value" not in element:
            return None
        if "step" in element:
            rows = np.flatnonzero(_steps(element) == step)
            if not len(rows):
                return None
            row = int(rows[-1])
        value: NDArray[np.generic] = element["value"][min(row, len(element["value"]) - 1)]
        return value
    fixed: NDArray[np.generic] = element[()]
    return fixed


def _add_box(group: Any, grains: GrainTable, place: tuple[int, int], power: float) -> None:
    """Add the box at a position, step and row, if its edges are along the axes."""
    if "box" not in group or "edges" not in group["box"]:
        return
    edges = _at(group["box"]["edges"], *place)
    if edges is None or edges.shape != (3,):
        return
    flags = [_word(flag) for flag in np.atleast_1d(group["box"].attrs.get("boundary", []))]
    periodic = ["periodic" in flag and "none" not in flag for flag in flags]
    lengths = in_si(np.asarray(edges, dtype=np.float64), power)
    lower = np.zeros(3)
    if "lower" in group["box"]:  # only in `result.h5`
        lower = in_si(np.asarray(group["box"]["lower"][()], dtype=np.float64), power)
    grains.bounds = np.stack([lower, lower + lengths], axis=1)
    if len(periodic) == len(lengths):
        grains.periodic = periodic[0], periodic[1], periodic[2]
