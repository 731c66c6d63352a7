"""Fields of a run as xarray Datasets; each variable has its unit in ``attrs["units"]``.

Snapshots are read from result.h5 on demand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from xarray import Dataset, Variable
from xarray.backends import BackendArray
from xarray.core import indexing

from granwave.analysis.errors import MissingDataError, OutputFormatError
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP

if TYPE_CHECKING:
    import h5py


class _OnDemand(BackendArray):
    """Data set of an open result.h5; indexing reads only the requested values."""

    def __init__(self, result: Result, name: str) -> None:
        # the result keeps the file open
        self.result = result
        self.name = name
        self.source: h5py.Dataset = result.file[name]
        self.shape = self.source.shape
        self.dtype = self.source.dtype

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
        The run is not of a chain, or its history was not recorded.
    """
    if "chain" not in result:
        raise MissingDataError(
            f"{result.path}: has no history of a chain; set output.history, the number of "
            "instants, and run the case again"
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
    """Make a variable; if it has a single dimension, it is time, or has the
    last of ``dimensions``.
    """
    attributes = {"units": result.unit(path), "long_name": name.replace("_", " ")}
    source = result.file[path]
    if source.ndim == 1:
        return Variable("time" if name == "time" else dimensions[-1], result[path], attributes)
    # as `xarray.open_dataset` does: kept in memory after it was read completely, and copied when it
    # is changed
    lazy: Any = indexing.LazilyIndexedArray(_OnDemand(result, path))
    values = indexing.MemoryCachedArray(indexing.CopyOnWriteArray(lazy))
    return Variable(dimensions[: source.ndim], values, attributes)
