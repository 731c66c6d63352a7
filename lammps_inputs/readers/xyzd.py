"""Packings of packing-generation (``packing.xyzd``): x, y, z and the diameter of each sphere as
binary numbers, in a periodic box.

Box and final porosity are in the text file ``packing.nfo`` in the same folder. The diameters in the
file belong to a step of the generation; the diameters of the packing follow from the porosity.

https://github.com/VasiliBaranov/packing-generation
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.lammps_inputs.tables.digits import significant_half_units
from granwave.lammps_inputs.tables.units import in_si

NAME = "xyzd"
LABEL = "packing-generation"
_N_OF_SPHERE = 4  # x, y, z, diameter
_DIGITS = {"<f8": 16, "<f4": 7}  # decimal digits of the types of numbers that the program writes
_SHOWN_SPHERES = 100  # from which the type of the numbers is found
_SMALLEST = 1e-9  # of the diameters
_LARGEST = 1e9  # of all numbers
_NUMBER = r"[ \t]*([-+.0-9eE]+)"
_BOX = re.compile(r"Dimensions:" + 3 * _NUMBER)
_POROSITY = re.compile(r"Final Porosity:" + _NUMBER)
_SAME = 1e-9  # relative difference of diameters that rounding explains
_INFO = ".nfo"


def recognises(source: GrainSource) -> bool:
    """Return True for binary numbers that are positions and diameters."""
    return bool(_type_of(source.content))


def read(source: GrainSource) -> GrainTable:
    """Read the spheres.

    Raises
    ------
    ValueError
        The file has no whole number of spheres, or other values; or its box or its porosity is
        damaged.
    """
    content = source.content
    kind = _type_of(content)
    if not kind:
        raise ValueError(
            f"found {len(content)} bytes, expected binary numbers x, y, z and a diameter for each "
            "sphere (32 or 16 bytes per sphere); the file is damaged or truncated"
        )
    power = source.options.power()
    numbers = np.frombuffer(content, kind).reshape(-1, _N_OF_SPHERE).astype(np.float64)
    position = numbers[:, :3]
    grains = GrainTable(
        format=LABEL,
        position=in_si(position, power),
        half_unit=in_si(significant_half_units(position, _DIGITS[kind]), power),
        radius=in_si(numbers[:, 3] / 2, power),
    )
    _check(grains)
    info = _info_of(source.path)
    if info is None:
        grains.notes.append(
            f"no file {source.path.with_suffix(_INFO).name} in the folder of the packing; read "
            "without a periodic box, and with the diameters of the file, which may belong to "
            "another step of the generation"
        )
        return grains
    _add_info(grains, info, power)
    return grains


def _type_of(content: bytes) -> str:
    """Return the type of the numbers of a file of spheres; empty for other files."""
    for kind in _DIGITS:
        n_bytes = _N_OF_SPHERE * np.dtype(kind).itemsize
        if not content or len(content) % n_bytes:
            continue
        numbers = np.frombuffer(content[: n_bytes * _SHOWN_SPHERES], kind)
        spheres = numbers.reshape(-1, _N_OF_SPHERE)
        if not (np.isfinite(spheres).all() and (np.abs(spheres) < _LARGEST).all()):
            continue
        if (spheres[:, 3] > _SMALLEST).all():
            return kind
    return ""


def _check(grains: GrainTable) -> None:
    """Raise ValueError for a position or a size that is not a finite number, or a size
    that is 0.
    """
    assert grains.radius is not None
    is_wrong = ~np.isfinite(grains.position).all(axis=1) | ~(grains.radius > 0)
    wrong = np.flatnonzero(is_wrong | ~np.isfinite(grains.radius))
    if len(wrong):
        raise ValueError(
            f"grain {wrong[0] + 1}: found no finite position, or no diameter above 0; the file is "
            "damaged"
        )


def _info_of(path: Path) -> str | None:
    """Return the text of the file on box and porosity next to a packing; None without one."""
    try:
        return path.with_suffix(_INFO).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None


def _add_info(grains: GrainTable, info: str, power: float) -> None:
    """Add the periodic box to the grains, and scale their diameters by the final porosity."""
    box = _BOX.search(info)
    porosity = _POROSITY.search(info)
    if box is None or porosity is None:
        raise ValueError(
            f"found no Dimensions and no Final Porosity in the {_INFO} file next to the packing, "
            "expected both; remove it to read the packing without a box"
        )
    lengths = in_si(_numbers(box), power)
    grains.bounds = np.stack([np.zeros(3), lengths], axis=1)
    grains.periodic = (True, True, True)
    solid_fraction = 1 - float(_numbers(porosity)[0])
    if not 0 < solid_fraction < 1:
        raise ValueError(
            f"found a final porosity of {porosity[1]} in the {_INFO} file, expected a number "
            "between 0 and 1"
        )
    assert grains.radius is not None
    spheres = 4 / 3 * np.pi * grains.radius**3
    scale = float(np.cbrt(solid_fraction * lengths.prod() / spheres.sum()))
    grains.radius = grains.radius * scale
    if abs(scale - 1) > _SAME:
        grains.notes.append(
            f"diameters times {scale:.6g}, by the final porosity of the {_INFO} file: solid "
            f"fraction {solid_fraction:.4g}"
        )


def _numbers(match: re.Match[str]) -> NDArray[np.float64]:
    """Return the numbers of a match; raise ValueError if they are not numbers."""
    try:
        return np.array(match.groups(), dtype=np.float64)
    except ValueError:
        raise ValueError(
            f"found {match[0].strip()} in the {_INFO} file, expected numbers"
        ) from None
