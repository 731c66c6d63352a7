"""Fields of a run, bands, modes and transmission as xarray Datasets; each variable has its unit in
``attrs["units"]``.

Snapshots are read from result.h5 when they are asked for. Bands, modes and transmission are made of
the groups of spectra.h5, as `granwave.extensions.waves.spectra.files` writes them.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from xarray import Dataset, Variable
from xarray.backends import BackendArray
from xarray.core import indexing

from granwave.analysis.errors import MissingDataError, OutputFormatError
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.extensions.waves.spectra.files import Table, read_spectra
from granwave.lammps_inputs.files import plain
from granwave.lammps_inputs.run_directory import SPECTRA_KINDS

if TYPE_CHECKING:
    import h5py

#: Dimensions of variables by kind, then group and name in spectra.h5.
_VARIABLES = {
    "bands": {
        "frequency": "point band", "group_velocity": "point band axis", "edges": "band edge", "gaps": "gap edge",
        "speed": "wave", "surface_share": "point band", "complex/attenuation": "complex_frequency root",
        "complex/phase": "complex_frequency root", "plane/frequency": "plane_k2 plane_k1 plane_band",
        "plane/slowness": "angle plane_wave",
    },
    "modes": {
        "frequency": "mode", "participation_ratio": "mode", "shape": "freedom mode",
        "density_of_states": "density_frequency",
    },
    "transmission": {"amplitude_ratio": "frequency sensor", "phase": "frequency sensor"},
}  # fmt: skip
#: Source and dimensions of coordinates by kind.
_COORDINATES = {
    "bands": {
        "distance": ("distance", "point"), "k": ("k", "point axis"),
        "complex_frequency": ("complex/frequency", "complex_frequency"), "plane_k1": ("plane/k", "plane_k1"),
        "plane_k2": ("plane/k", "plane_k2"), "angle": ("plane/angle", "angle"),
    },
    "modes": {
        "id": ("id", "freedom"), "direction": ("freedom", "freedom"),
        "density_frequency": ("density_frequency", "density_frequency"),
    },
    "transmission": {"frequency": ("frequency", "frequency"), "sensor": ("sensor", "sensor")},
}  # fmt: skip
_OF_PLANE = ("plane_frequency", "slowness", "angle")  # variables that say which plane it is


class _OnDemand(BackendArray):
    """Data set of an open result.h5 that is read where it is indexed."""

    def __init__(self, result: Result, name: str) -> None:
        # the result keeps the file open
        self.result = result
        self.name = name
        self.source: h5py.Dataset = result.file[name]
        self.shape, self.dtype = self.source.shape, self.source.dtype

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.result, self.name)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.BASIC, self._read
        )

    def _read(self, key: tuple[Any, ...]) -> NDArray:
        try:
            return np.asarray(self.source[key])
        except OSError as error:
            raise OutputFormatError(self.result.damaged(f"{self.name}: {error}")) from None


def fields(result: Result) -> Dataset:
    """Return the snapshots of all spheres.

    Returns
    -------
    Dataset
        ``position``, ``displacement``, ``velocity`` (time, id, axis), m, m, m s-1;
        ``contact_force`` (largest present force of a single contact), ``peak_force`` N,
        ``dissipated_energy``, ``elastic_energy`` and, with friction, ``friction_energy`` J (time,
        id). Coordinates ``time`` s, ``step``, ``id``, ``radius`` m, ``mass`` kg, ``axis``. Each has
        its unit in ``attrs["units"]``.
    """
    coordinates = {
        "time": Variable("time", result.frame_times, {"units": "s"}),
        "step": Variable("time", result[f"{GROUP}/position/step"], {"units": "1"}),
        "id": Variable("id", result["spheres/id"], {"units": "1"}),
        "axis": Variable("axis", list("xyz"), {"long_name": "axis; impact goes along +z"}),
        **{name: Variable("id", result[f"{GROUP}/{name}"], {"units": result.unit(f"{GROUP}/{name}")})
           for name in ("radius", "mass")},
    }  # fmt: skip
    dimensions = ("time", "id", "axis")
    variables = {
        name: _variable(result, f"{GROUP}/{name}/value", dimensions, name)
        for name in result.quantities
    }
    return Dataset(variables, coordinates, {"name": result.case.name})


def chain(result: Result) -> Dataset:
    """Return the history of a chain and of its bars.

    Returns
    -------
    Dataset
        ``displacement``, ``velocity`` (time, bead), m, m s-1; ``contact_force`` (time, contact), N;
        of a bar ``NAME_displacement``, ``NAME_velocity`` (time, NAME_node) and ``NAME_force``
        (time, NAME_element). Coordinates ``time`` s, ``bead`` (id), ``position`` m, ``contact_i``,
        ``contact_j``, ``contact_position`` m, ``NAME_position`` m. Beads and nodes are in the order
        of z.

    Raises
    ------
    MissingDataError
        The run is not one of a chain, or its history was not recorded.
    """
    if "chain" not in result:
        raise MissingDataError(
            f"{result.path}: has no history of a chain; run one with output.history, the number of its instants"
        )
    found = {}
    for name in result.names("chain"):
        own = "contact" if name.startswith("contact_") else "bead"
        found["bead" if name == "id" else name] = _variable(
            result, f"chain/{name}", ("time", own), name
        )
    for bar in result.names("bars"):
        for name in result.names(f"bars/{bar}"):
            own = f"{bar}_element" if name == "force" else f"{bar}_node"
            found[f"{bar}_{name}"] = _variable(
                result, f"bars/{bar}/{name}", ("time", own), f"{name} of the {bar}"
            )
    histories = {name: variable for name, variable in found.items() if variable.ndim == 2}
    coordinates = {name: variable for name, variable in found.items() if variable.ndim == 1}
    return Dataset(histories, coordinates, {"name": result.case.name})


def _variable(result: Result, path: str, dimensions: tuple[str, ...], name: str) -> Variable:
    """Make a variable; one of a single dimension is time, or has the last of ``dimensions``."""
    attributes = {"units": result.unit(path), "long_name": name.replace("_", " ")}
    source = result.file[path]
    if source.ndim == 1:
        return Variable("time" if name == "time" else dimensions[-1], result[path], attributes)
    # as `xarray.open_dataset` does: kept in memory once it was read whole, and copied when it is
    # changed
    lazy: Any = indexing.LazilyIndexedArray(_OnDemand(result, path))
    values = indexing.MemoryCachedArray(indexing.CopyOnWriteArray(lazy))
    return Variable(dimensions[: source.ndim], values, attributes)


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
    found = {
        f"{group}/{name}".removeprefix(f"{kind}/"): content
        for group, table in tables.items()
        for name, content in table.items()
        if group.startswith(kind)
    }
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
    """Return the bands, modes or transmission in a directory; of several kinds a dictionary by
    kind.

    Raises
    ------
    OutputFormatError
        A file is damaged.
    """
    found = {
        kind: dataset(kind, tables, values)
        for kind in SPECTRA_KINDS
        if (directory / f"{kind}.json").is_file()
        for values, tables in [read_spectra(directory, kind)]
    }
    return next(iter(found.values())) if len(found) == 1 else found


def _variable_of(dimensions: str, content: tuple[Any, str]) -> Variable:
    values, unit = content
    return Variable(
        dimensions.split(), list(values) if isinstance(values, tuple) else values, {"units": unit}
    )
