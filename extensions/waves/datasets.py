"""Bands, modes and transmission as xarray Datasets; units of variables are in ``attrs["units"]``.

They are made from the groups of spectra.h5, which `granwave.extensions.waves.spectra.files` writes.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from xarray import Dataset, Variable

from granwave.extensions.waves.files import spectra_in
from granwave.extensions.waves.spectra.files import Table, read_spectra
from granwave.lammps_inputs.files import plain

#: Dimensions of variables by kind, then group and name in spectra.h5.
_VARIABLES = {
    "bands": {
        "frequency": "point band",
        "group_velocity": "point band axis",
        "edges": "band edge",
        "gaps": "gap edge",
        "speed": "wave",
        "surface_share": "point band",
        "complex/attenuation": "complex_frequency root",
        "complex/phase": "complex_frequency root",
        "plane/frequency": "plane_k2 plane_k1 plane_band",
        "plane/slowness": "angle plane_wave",
    },
    "modes": {
        "frequency": "mode",
        "participation_ratio": "mode",
        "shape": "freedom mode",
        "density_of_states": "density_frequency",
    },
    "transmission": {"amplitude_ratio": "frequency sensor", "phase": "frequency sensor"},
}
#: Source and dimensions of coordinates by kind.
_COORDINATES = {
    "bands": {
        "distance": ("distance", "point"),
        "k": ("k", "point axis"),
        "complex_frequency": ("complex/frequency", "complex_frequency"),
        "plane_k1": ("plane/k", "plane_k1"),
        "plane_k2": ("plane/k", "plane_k2"),
        "angle": ("plane/angle", "angle"),
    },
    "modes": {
        "id": ("id", "freedom"),
        "direction": ("freedom", "freedom"),
        "density_frequency": ("density_frequency", "density_frequency"),
    },
    "transmission": {"frequency": ("frequency", "frequency"), "sensor": ("sensor", "sensor")},
}
_OF_PLANE = ("plane_frequency", "slowness", "angle")  # variables that identify the plane


def dataset(kind: str, tables: Mapping[str, Table], values: Mapping[str, Any]) -> Dataset:
    """Return bands along a path, modes of a finite packing, or the transmission between grains.

    Parameters
    ----------
    kind
        ``bands``, ``modes`` or ``transmission``.
    tables
        Groups of spectra.h5 by name.
    values
        Values of bands.json, modes.json or transmission.json.

    Returns
    -------
    Dataset
        Of bands: ``frequency`` Hz, ``group_velocity`` m/s (point, band, axis), ``edges`` Hz (band,
        edge), ``gaps`` Hz (gap, edge), ``speed`` of long waves m/s (wave); where known
        ``attenuation`` from plane to plane and ``phase`` rad (complex_frequency, root),
        ``slowness`` s/m (angle, wave), ``plane_frequency`` Hz over a plane of wave vectors
        (plane_k2, plane_k1, band), and of a slab ``surface_share`` (point, band), the part of the
        energy in its upper quarter. Coordinates ``distance`` and ``k`` rad/m, ``corner``. Of modes:
        ``frequency`` Hz, ``participation_ratio`` (mode), ``shape`` (freedom, mode),
        ``density_of_states`` 1/Hz (density_frequency). Coordinates ``id`` and ``direction`` of each
        freedom. Of a transmission: ``amplitude_ratio``, ``phase`` rad (frequency, sensor). The
        values are in ``attrs``.
    """
    found = {}
    for group, table in tables.items():
        if group.startswith(kind):
            for name, content in table.items():
                found[f"{group}/{name}".removeprefix(f"{kind}/")] = content
    variables = {
        "plane_frequency" if name == "plane/frequency" else name.rpartition("/")[2]: _variable_of(
            shape, found[name]
        )
        for name, shape in _VARIABLES[kind].items()
        if name in found
    }
    sources = {name: of for name, of in _COORDINATES[kind].items() if of[0] in found}
    coordinates = {
        name: _variable_of(shape, found[source]) for name, (source, shape) in sources.items()
    }
    if kind == "bands":
        coordinates["axis"] = Variable("axis", list("xyz"), {"units": "1"})
        coordinates["edge"] = Variable("edge", ["low", "high"], {"units": "1"})
        corner = np.full(len(found["distance"][0]), "", dtype=object)
        for row, name in zip(found["corner"][0], found["corner_name"][0], strict=True):
            corner[row] = name
        coordinates["corner"] = Variable("point", corner.astype(str), {"units": "1"})
        if "plane/name" in found:
            for name in _OF_PLANE:
                (variables if name in variables else coordinates)[name].attrs["plane"] = str(
                    found["plane/name"][0]
                )
    return Dataset(variables, coordinates, plain(dict(values)))


def load_spectra(directory: Path) -> Dataset | dict[str, Dataset]:
    """Return the bands, modes or transmission in a directory; if there are several kinds, a
    dictionary by kind.

    Raises
    ------
    OutputFormatError
        A file is damaged.
    """
    found = {}
    for kind in spectra_in(directory):
        values, tables = read_spectra(directory, kind)
        found[kind] = dataset(kind, tables, values)
    return next(iter(found.values())) if len(found) == 1 else found


def _variable_of(dimensions: str, content: tuple[Any, str]) -> Variable:
    values, unit = content
    return Variable(
        dimensions.split(), list(values) if isinstance(values, tuple) else values, {"units": unit}
    )
