"""Trajectory of a run as an MDAnalysis universe.

MDAnalysis stores positions in single precision, with a spacing of 60 nm at 0.7 m, which is 5 % of a
yield overlap, and of 8 µm at 100 m: never compute overlaps from ``ts.positions``. This reader adds quantities in double
precision to every snapshot: ``ts.data["displacement"]`` (m), ``ts.data["contact_force"]`` (N),
``ts.data["peak_force"]`` (N), ``ts.data["dissipated_energy"]`` (J) and, with friction,
``ts.data["friction_energy"]`` (J), with viscous losses ``ts.data["viscous_energy"]`` (J). Lengths
are in m and times in s, regardless of the units that MDAnalysis assumes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import ClassVar

if sys.flags.optimize > 1:
    raise ImportError(
        "granwave.analysis.universe: MDAnalysis needs docstrings, which python -OO (PYTHONOPTIMIZE=2) drops; use -O"
    )

import h5py
import MDAnalysis
import numpy as np
from MDAnalysis.coordinates.base import ReaderBase
from MDAnalysis.coordinates.timestep import Timestep

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.result.reader import Result
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.result_directory import ResultDirectory

DATA = (
    "displacement",
    "contact_force",
    "peak_force",
    "dissipated_energy",
    "friction_energy",
    "viscous_energy",
)


class ResultReader(ReaderBase):
    """MDAnalysis reader of the trajectory in ``result.h5`` (format ``GRANWAVE``); nothing is
    converted.

    Parameters
    ----------
    filename
        Path of result.h5.
    """

    format = "GRANWAVE"
    units: ClassVar[dict[str, None]] = {"time": None, "length": None, "velocity": None}

    def __init__(self, filename: str | Path, **kwargs: object) -> None:
        super().__init__(filename, **kwargs)
        path = Path(self.filename)
        if changed := ResultDirectory(path.parent).changed_result([path.name]):
            raise OutputFormatError(changed)
        self._open()
        self._data = [name for name in DATA if name in self._spheres]
        self._times = self._spheres["position/time"][()]
        self._steps = self._spheres["position/step"][()]
        self.n_atoms = self._spheres["id"].shape[0]
        boundary = self._spheres["box"].attrs["boundary"]
        self._edges = self._spheres["box/edges"][()] if "periodic" in list(boundary) else None
        step = float(self._times[1] - self._times[0]) if len(self._times) > 1 else 1.0
        self._ts_kwargs.setdefault("dt", step)
        self._reopen()
        self._read_next_timestep()

    @staticmethod
    def parse_n_atoms(filename: str | Path, **kwargs: object) -> int:
        """Return the number of spheres in the file."""
        with h5py.File(regular(Path(filename)), "r") as file:
            return file[GROUP]["id"].shape[0]

    @property
    def n_frames(self) -> int:
        """Number of snapshots in the file."""
        return len(self._times)

    def __getstate__(self) -> dict[str, object]:
        """Return the state without the open file, which cannot be pickled; `__setstate__` opens it
        again.
        """
        return {
            name: value
            for name, value in self.__dict__.items()
            if name not in ("_file", "_spheres")
        }

    def __setstate__(self, state: dict[str, object]) -> None:
        self.__dict__ = state
        self._open()
        self[self.ts.frame]

    def close(self) -> None:
        """Close the file."""
        if hasattr(self, "_file"):
            self._file.close()

    def _open(self) -> None:
        self._file = h5py.File(regular(Path(self.filename)), "r")
        self._spheres = self._file[GROUP]

    def _reopen(self) -> None:
        if not self._file:
            self._open()
        self.ts = self._Timestep(self.n_atoms, velocities=True, **self._ts_kwargs)
        self.ts.frame = -1

    def _read_frame(self, frame: int) -> Timestep:
        ts = self.ts
        ts.positions = self._spheres["position/value"][frame]
        ts.velocities = self._spheres["velocity/value"][frame]
        ts.frame = frame
        ts.time = float(self._times[frame])
        ts.data["step"] = int(self._steps[frame])
        for name in self._data:
            ts.data[name] = self._spheres[f"{name}/value"][frame]
        if self._edges is not None:
            ts.dimensions = [*self._edges, 90.0, 90.0, 90.0]
        return ts

    def _read_next_timestep(self) -> Timestep:
        if self.ts.frame + 1 >= self.n_frames:
            raise EOFError
        return self._read_frame(self.ts.frame + 1)


def universe(source: str | Path) -> MDAnalysis.Universe:
    """Make a universe of the spheres of a run and their trajectory.

    Parameters
    ----------
    source
        Directory of a run, or its result.h5.

    Returns
    -------
    MDAnalysis.Universe
        Atoms are spheres in the order of their ids, with ``ids``, ``types``, ``radii`` (m) and
        ``masses`` (kg); positions in m, velocities in m/s, and `DATA` in ``ts.data``.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    """
    with Result(source) as result:
        path = result.path
        ids, radii, masses = (result[f"{GROUP}/{name}"] for name in ("id", "radius", "mass"))
        species = result[f"{GROUP}/species"]
    spheres = MDAnalysis.Universe.empty(len(ids), trajectory=False)
    spheres.add_TopologyAttr("ids", ids)
    spheres.add_TopologyAttr("types", np.char.mod("%d", species).astype(object))
    spheres.add_TopologyAttr("radii", radii)
    spheres.add_TopologyAttr("masses", masses)
    spheres.load_new(str(path), format=ResultReader)
    return spheres
