"""Small waves about a static state in Python: bands, modes, transmission."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from granwave.analysis.notebook.run import Run
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.python.inputs import CaseLike, home, read_case, words_of_python
from granwave.workflows.solvers import GRANULAR

if TYPE_CHECKING:
    from xarray import Dataset


def bands(
    source: CaseLike,
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    path: str | ArrayLike = "",
    points: int | None = None,
    n_bands: int | None = None,
    directions: str = "",
    plane: str = "",
    allow_floppy: bool = False,
    slab: bool = False,
    directory: str | Path | None = None,
    force: bool = False,
    **keys: Any,
) -> Dataset:
    """Find the bands of an infinite, periodic packing under its static load.

    Parameters
    ----------
    source, changes, keys
        The case, as in `case`; or a `Run`, whose static state is read from its results.
    path
        Names of points, ``"G-X-M-G"``, or wave vectors, (n, 3), rad/m; by default the standard path
        of the cell.
    points
        Wave vectors of each stretch; by default 61, or 16 of a cell with more than 150 degrees of
        freedom.
    n_bands
        Number of bands; by default all for a small cell, 30 for a large cell.
    directions
        Directions in which grains move, from "xyz"; by default the directions of the packing.
    plane
        Plane of slowness and equal-frequency curves: xy, xz or yz.
    allow_floppy
        Continue if grains can move without resistance; such frequencies are NaN.
    slab
        Take the packing as it ends above and below: waves of its surface. Its sides must be
        periodic.
    directory
        Directory of the results, as of ``granwave bands``; by default nothing is written.
    force
        Move existing results into NAME.old.

    Returns
    -------
    xarray.Dataset
        See `granwave.extensions.waves.datasets.dataset`.

    Raises
    ------
    InputError
        The case is invalid, not periodic, unloaded or not rigid.
    """
    if not isinstance(path, str):
        corners = np.atleast_2d(path).astype(float).tolist()
        path = "; ".join(",".join(map(repr, corner)) for corner in corners)
    return _solved(
        "bands", source, changes, keys, directory, path=path, points=points, n_bands=n_bands, directions=directions,
        plane=plane, allow_floppy=allow_floppy, slab=slab, force=force,
    )  # fmt: skip


def modes(
    source: CaseLike,
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    n_modes: int | None = None,
    directions: str = "",
    allow_floppy: bool = False,
    directory: str | Path | None = None,
    force: bool = False,
    **keys: Any,
) -> Dataset:
    """Find the modes of a finite packing under its static load.

    Parameters
    ----------
    source, changes, keys, directions, allow_floppy, directory, force
        As in `bands`.
    n_modes
        Number of modes; by default all for a small packing, 60 for a large packing.

    Returns
    -------
    xarray.Dataset
        See `granwave.extensions.waves.datasets.dataset`.

    Raises
    ------
    InputError
        As of `bands`.
    """
    how = {
        "n_modes": n_modes,
        "directions": directions,
        "allow_floppy": allow_floppy,
        "force": force,
    }
    return _solved("modes", source, changes, keys, directory, **how)


def transmission(
    source: CaseLike,
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    drive: int | Sequence[int],
    sensors: int | Sequence[int],
    frequencies: ArrayLike,
    axis: str = "",
    end: str = "",
    directions: str = "",
    directory: str | Path | None = None,
    force: bool = False,
    **keys: Any,
) -> Dataset:
    """Find the steady response of a finite packing to the prescribed motion of a grain.

    Parameters
    ----------
    source, changes, keys, directions, directory, force
        As in `bands`.
    drive, sensors
        Ids of the driven grain, or of several grains driven in phase, and of the sensor grains.
    frequencies
        (n,), Hz.
    axis
        Direction of the motions, x, y or z; by default z.
    end
        Far end: ``reflecting``, ``matched`` or ``layer:N``.

    Returns
    -------
    xarray.Dataset
        See `granwave.extensions.waves.datasets.dataset`.

    Raises
    ------
    InputError
        As of `bands`; or a grain is not there or cannot move.
    """
    return _solved(
        "steady", source, changes, keys, directory, axis=axis, end=end, directions=directions, force=force,
        drive=drive if isinstance(drive, int) else list(drive),
        sensors=[sensors] if isinstance(sensors, int) else list(sensors),
        frequencies=np.atleast_1d(np.asarray(frequencies, dtype=float)),
    )  # fmt: skip


def _solved(
    name: str,
    source: CaseLike,
    changes: Mapping[str, Any] | None,
    keys: Mapping[str, Any],
    directory: str | Path | None,
    **how: Any,
) -> Dataset:
    """Return the result of a function of `granwave.extensions.waves.small_waves` for a case or a
    run.
    """
    from granwave.extensions.waves import small_waves as spectra
    from granwave.extensions.waves.datasets import dataset  # loads xarray

    with words_of_python():
        packing = source.directory if isinstance(source, Run) and not changes and not keys else None
        if packing is None:
            case, kind = read_case(source, changes, keys)
            if kind is not GRANULAR:
                raise InputError(f"{case.name}: found a continuum case, expected a packing")
            packing = kind.assemble(case)
        waves, _ = getattr(spectra, name)(
            packing, None if directory is None else Path(home(directory)), **how
        )
    return dataset(waves.name, waves.tables, waves.summary)
