"""Readers of the time series of a run: energy ledger, wall forces and probes.

``dumps/energy.txt``, ``dumps/walls.txt`` and ``dumps/probes.txt`` begin with comments (``#``), the last of which names
the columns, followed by a row of numbers for each instant. A last row that was cut is dropped; of rows of the same
instant (resumed run) the last one is used.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.number_rows import AGAIN, read_rows
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.run_directory import DUMPS, ENERGY_FILE, PROBES_FILE, STATIC_STAGE_FILE, WALLS_FILE

#: Columns of the energy ledger.
ENERGY_COLUMNS = ("step", *columns.names(columns.LEDGER))
#: Columns that the ledger of a run without friction may lack; they are set to 0.
FRICTION_COLUMNS = columns.names((*columns.ROTATION, *columns.TANGENTIAL))

Table = dict[str, NDArray[np.float64]]


def read_energy(directory: str | Path) -> Table:
    """Read the energy ledger of a run, each column (n_instants,).

    Columns `ENERGY_COLUMNS` and `FRICTION_COLUMNS`; with a moving bottom ``support``, ``support_lost`` and ``target``
    (energy of the support, dissipation by its damper, work done on it), J; with bars the energy of each, J; of chains
    that rub against their holder ``holder`` (dissipation by this friction), with viscous losses ``viscous``, J.

    Raises
    ------
    MissingOutputError
        The run left no ledger.
    OutputFormatError
        The ledger lacks a column, holds no row, or is damaged.
    """
    path = Path(directory) / DUMPS / ENERGY_FILE
    if not path.exists():
        raise MissingOutputError(f"{path} is missing: run the case first (granwave run CASE -o {directory} --force)")
    table = _read(path)
    missing = [name for name in ENERGY_COLUMNS if name not in table]
    if missing:
        raise OutputFormatError(f"{path} lacks the columns {', '.join(missing)}; it has {', '.join(table)}; {AGAIN}")
    zeros = np.zeros_like(table["time"])
    return table | {name: zeros for name in FRICTION_COLUMNS if name not in table}


def read_static_stage(directory: str | Path) -> Table:
    """Read the record of the static stage of a precompressed run, one row; empty if there was none.

    Columns: ``residual`` (largest net force over the largest contact force), ``largest_force`` N, ``contacts``,
    ``yielded``, ``stored`` (elastic energy) J, ``displacement`` m, ``iterations``.
    """
    return _read_if_there(Path(directory) / DUMPS / STATIC_STAGE_FILE)


def read_walls(directory: str | Path) -> Table:
    """Read the normal forces on walls, N, positive outwards, by name of the wall, with ``step`` and ``time``.

    The result is empty if the run has no wall.
    """
    return _read_if_there(Path(directory) / DUMPS / WALLS_FILE)


def read_probes(directory: str | Path) -> Table:
    """Read the records of the probes, with ``step`` and ``time``; empty if there are none.

    Columns: ``sphere_ID_ux`` (uy, uz) displacement in m, ``_vx`` velocity in m/s, ``_fx`` force in N;
    ``contact_I_J_overlap`` in m and ``contact_I_J_force`` in N.
    """
    return _read_if_there(Path(directory) / DUMPS / PROBES_FILE)


def _read_if_there(path: Path) -> Table:
    return _read(path) if path.exists() else {}


def _read(path: Path) -> Table:
    names: list[str] = []
    rows, lines = [], []
    with open(path, encoding="ascii", errors="replace") as file:  # other bytes give an error with their line
        for number, line in enumerate(file, start=1):
            if line.startswith("#"):
                names = line[1:].split()
            elif line.endswith("\n"):  # otherwise the last line was cut
                rows.append(line)
                lines.append(number)
    if not rows or not names:
        what = "no names of columns" if rows else "no row: the run ended before its first report"
        raise OutputFormatError(f"{path} holds {what}; {AGAIN}")
    values = read_rows(rows, names, lambda row: f"{path}: line {lines[row]}")
    _, backwards = np.unique(values[::-1, 0], return_index=True)
    values = values[len(values) - 1 - backwards]
    if names[0] == "step":
        _check_steps(path, values[:, 0])
    return {name: np.ascontiguousarray(values[:, n]) for n, name in enumerate(names)}


def _check_steps(path: Path, steps: NDArray[np.float64]) -> None:
    """Check that rows are evenly spaced; a temporarily full disk could have left some out."""
    apart = np.diff(steps)
    if len(apart) and apart.max() > apart.min():
        n = int(apart.argmax())
        raise OutputFormatError(f"{path} lacks rows between the steps {steps[n]:.0f} and {steps[n + 1]:.0f}; {AGAIN}")
