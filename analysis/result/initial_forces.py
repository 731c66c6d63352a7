"""Normal forces of contacts after the static stage of a precompressed run, for the tables of ``result.h5``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.lammps_output.dump_files import initial_forces_path
from granwave.analysis.lammps_output.dumps import read_initial_forces_in_parts, read_initial_wall_forces
from granwave.analysis.lammps_output.frame import AGAIN, Frame
from granwave.analysis.result.dents import Dents
from granwave.analysis.result.scratch import Buckets
from granwave.analysis.result.start import Start
from granwave.lammps_inputs.run_directory import INITIAL_WALL_FORCES_FILE

COLUMN = "initial_force"


class InitialForces:
    """Forces of contacts after the static stage.

    Parameters
    ----------
    pairs
        Contacts of particles: i, j, force.
    planes
        Contacts with each plane, by its name: id, force.
    directory
        Directory of the run, for messages.
    """

    def __init__(self, pairs: Dents, planes: Mapping[str, Frame], directory: Path) -> None:
        self._pairs, self._planes, self._directory = pairs, planes, directory

    def of_part(self, part: int, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of pairs of spheres, one of each in this part, i < j: (n_pairs,), N."""
        return force_of_pairs(self._pairs.of_part(part), first, second)

    def at_bars(self, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of spheres on the faces of bars: (n_pairs,), N."""
        return force_of_pairs(self._pairs.at_bars(), first, second)

    def on_wall(self, wall: str, ids: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the forces of spheres, ids rising, on a plane: (n_ids,), N.

        Raises
        ------
        OutputFormatError
            A sphere pressed on the plane that is not among these.
        """
        found = self._planes[wall]
        pressing = found["id"].astype(np.int64)
        if len(strange := np.setdiff1d(pressing, ids)):
            raise OutputFormatError(
                f"{self._directory / INITIAL_WALL_FORCES_FILE.format(wall)}: found sphere {strange[0]}, which never "
                f"touched the wall {wall}: the files belong to different runs, or one is damaged; {AGAIN}"
            )
        forces = np.zeros(len(ids))
        forces[np.searchsorted(ids, pressing)] = found["force"]
        return forces


def read_initial_forces(directory: Path, start: Start, rows: Buckets, at_once: int | None) -> InitialForces | None:
    """Read the forces after the static stage; None if there was none, or if an early version ran it.

    Parameters
    ----------
    rows
        Contacts by part of either sphere.
    at_once
        Largest number of contacts that are read at once.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing or damaged, or belongs to another run.
    """
    path = initial_forces_path(directory)
    if path is None:
        return None
    pairs, planes = Dents(start, rows), read_initial_wall_forces(directory)
    for frame in read_initial_forces_in_parts(directory, at_once):
        start.check_ids(path, frame)
        pairs.add(frame)
    for name, frame in planes.items():
        start.check_ids(path.with_name(INITIAL_WALL_FORCES_FILE.format(name)), frame)
    return InitialForces(pairs, planes, path.parent)


def force_of_pairs(frame: Frame, first: NDArray[np.int64], second: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the forces of pairs: (n_pairs,), N; 0 for those that are not among the rows.

    Parameters
    ----------
    frame
        Contacts: i, j, force.
    first, second
        Ids of the pairs, i < j: (n_pairs,).
    """
    i, j = np.sort(frame.vector("i", "j").astype(np.int64), axis=1).T
    stride = 1 + max(j.max(initial=0), second.max(initial=0))
    known, rows = np.unique(i * stride + j, return_inverse=True)
    forces = np.append(np.bincount(rows, frame["force"], minlength=len(known)), 0.0)
    keys = first * stride + second
    found = np.searchsorted(known, keys)
    known = np.append(known, -1)
    return np.asarray(np.where(known[found] == keys, forces[found], 0.0))
