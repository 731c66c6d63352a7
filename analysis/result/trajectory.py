"""Trajectory of a run in the H5MD format (version 1.1, P. de Buyl et al., doi:10.1016/j.cpc.2014.01.018).

``/particles/spheres`` holds ``position``, ``displacement``, ``velocity``, ``contact_force`` (largest present force of a
single contact), ``peak_force``, ``dissipated_energy`` (by yielding, friction and viscous losses), ``elastic_energy``
(half the energy stored in each contact with another sphere; NaN if it was not recorded) and, with friction,
``friction_energy``, with viscous losses ``viscous_energy``, each as ``value``, ``step`` and ``time`` of every snapshot;
``id``, ``species``, ``radius`` and ``mass`` are constant. Positions are initial positions plus displacements, not
wrapped into periodic boxes. All values are float64; overlaps should be computed from displacements, which have 17
digits independently of the distance from the origin.
"""

from __future__ import annotations

import getpass
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, Frame
from granwave.analysis.result.hdf5_file import COMPRESSION, ROWS_IN_CHUNK
from granwave.analysis.result.start import Start

GROUP = "particles/spheres"
_VECTORS = {"position": "m", "displacement": "m", "velocity": "m s-1"}
# columns of the dump that are added, and the unit
_SCALARS = {
    "contact_force": (("force",), "N"),
    "peak_force": (("peak_force",), "N"),
    "dissipated_energy": (("dissipated", "friction", "viscous"), "J"),
    "elastic_energy": (("elastic", "elastic_tangential"), "J"),
    "friction_energy": (("friction",), "J"),
    "viscous_energy": (("viscous",), "J"),
}
_FIXED = {"id": (np.int64, "1"), "species": (np.int32, "1"), "radius": (np.float64, "m"), "mass": (np.float64, "kg")}
QUANTITIES = (*_VECTORS, *_SCALARS)


def write_metadata(file: h5py.File, version: str) -> None:
    """Write the group ``/h5md``: version of the format, author and program."""
    group = file.create_group("h5md")
    group.attrs["version"] = np.array([1, 1], dtype=np.int32)
    group.create_group("author").attrs["name"] = _user()
    creator = group.create_group("creator")
    creator.attrs["name"] = "granwave"
    creator.attrs["version"] = version


def write_trajectory(
    file: h5py.File,
    start: Start,
    frames: Iterable[Frame],
    timestep: float,
    periodic: tuple[bool, bool, bool],
    source: Path,
    *,
    friction: bool = False,
    viscous: bool = False,
) -> int:
    """Write ``/particles/spheres``, one snapshot at a time, or a part of one.

    Parameters
    ----------
    start
        Spheres at the start.
    frames
        Snapshots from `granwave.analysis.lammps_output.dumps.read_frames`.
    timestep
        Timestep, s.
    periodic
        True for periodic axes, along x, y, z.
    source
        File of the snapshots, for messages.
    friction
        True to write ``friction_energy``.
    viscous
        True to write ``viscous_energy``.

    Returns
    -------
    int
        Step of the last snapshot.

    Raises
    ------
    OutputFormatError
        A snapshot has other spheres than the data file.
    """
    group = file.create_group(GROUP)
    _write_box(group, start, periodic)
    n_spheres = start.n_spheres
    for name, (dtype, unit) in _FIXED.items():
        group.create_dataset(name, n_spheres, dtype, **COMPRESSION).attrs["unit"] = unit
    for rows, spheres in start.parts():
        group["id"][rows] = spheres["id"]
        group["species"][rows] = spheres["type"]
        group["radius"][rows] = spheres["diameter"] / 2
        group["mass"][rows] = spheres["density"] * np.pi / 6 * spheres["diameter"] ** 3
    scalars = {
        name: of
        for name, of in _SCALARS.items()
        if (friction or name != "friction_energy") and (viscous or name != "viscous_energy")
    }
    elements = _elements(group, n_spheres, {name: unit for name, (_, unit) in scalars.items()})
    number, first, step = 0, 0, 0
    for piece in frames:
        frame, step = piece.up_to(start.last_sphere), piece.step
        stop = first + len(frame)
        strange = stop > n_spheres or not np.array_equal(frame["id"], start.ids(first, stop))
        if strange or (stop < n_spheres and not piece.more):
            raise OutputFormatError(
                f"{source}: snapshot {number} (step {step}) holds {stop} spheres that are not "
                f"the {n_spheres} of data.granwave: spheres were lost, or the files belong to different runs; {AGAIN}"
            )
        displacement, unknown = frame.vector("ux", "uy", "uz"), np.full(len(frame), np.nan)
        values = {"position": start.read(slice(first, stop)).vector("x", "y", "z") + displacement}
        values |= {"displacement": displacement, "velocity": frame.vector("vx", "vy", "vz")}
        for name, (columns, _) in scalars.items():
            there = [frame[column] for column in columns if column in frame.columns]
            values[name] = np.sum(there, axis=0) if there else unknown
        for name, element in elements.items():
            element.resize(number + 1, axis=0)
            element[number, first:stop] = values[name]
        first = stop
        if piece.more:
            continue
        for name, value in (("step", step), ("time", step * timestep)):
            dataset = group["position"][name]
            dataset.resize(number + 1, axis=0)
            dataset[number] = value
        number, first = number + 1, 0
    return step


def _write_box(group: h5py.Group, start: Start, periodic: tuple[bool, bool, bool]) -> None:
    box = group.create_group("box")
    box.attrs["dimension"] = 3
    box.attrs["boundary"] = ["periodic" if is_periodic else "none" for is_periodic in periodic]
    # lower is an extension of the standard, whose boxes start at 0
    for name, data in (("edges", start.box[:, 1] - start.box[:, 0]), ("lower", start.box[:, 0])):
        box.create_dataset(name, data=data).attrs["unit"] = "m"


def _elements(group: h5py.Group, n_spheres: int, scalars: dict[str, str]) -> dict[str, h5py.Dataset]:
    """Create the growing data sets; all elements share the ``step`` and the ``time`` of the first."""
    rows = min(n_spheres, ROWS_IN_CHUNK)
    elements = {}
    for name, unit in (_VECTORS | scalars).items():
        shape = (n_spheres, 3) if name in _VECTORS else (n_spheres,)
        options: dict[str, Any] = {"maxshape": (None, *shape), "chunks": (1, rows, *shape[1:]), **COMPRESSION}
        element = group.create_group(name)
        elements[name] = element.create_dataset("value", (0, *shape), np.float64, **options)
        elements[name].attrs["unit"] = unit
        for of_all, dtype, its_unit in (("step", np.int64, "1"), ("time", np.float64, "s")):
            if name == "position":
                element.create_dataset(of_all, (0,), dtype, maxshape=(None,)).attrs["unit"] = its_unit
            else:
                element[of_all] = group["position"][of_all]
    return elements


def _user() -> str:
    try:
        return getpass.getuser()
    except (KeyError, OSError):
        return "unknown"
