"""Readers of the time series and of the record of a run, and the check that its output is complete.

``dumps/energy.txt``, ``dumps/walls.txt`` and ``dumps/probes.txt`` begin with comments (``#``), the last of which names
the columns, followed by a row of numbers for each instant. A last row that was cut is dropped; of rows of the same
instant (resumed run) the last one is used. ``dumps/lines.dump`` has the motion of lines of grains. Truncated files
would silently give wrong results.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dumps import instants
from granwave.analysis.lammps_output.frame import AGAIN, CUT, read_rows
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.deck.columns import LINES, names
from granwave.lammps_inputs.deck.deck import read_deck
from granwave.lammps_inputs.directories import changed_file
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    DUMPS,
    ENERGY_FILE,
    LINES_FILE,
    PROBES_FILE,
    RECORD_FILE,
    STATIC_STAGE_FILE,
    WALL_CONTACTS_FILE,
    WALLS_FILE,
)

#: Columns of the energy ledger.
ENERGY_COLUMNS = ("step", *columns.names(columns.LEDGER))
#: Columns that the ledger of a run without friction may lack; they are set to 0.
FRICTION_COLUMNS = columns.names((*columns.ROTATION, *columns.TANGENTIAL))

Table = dict[str, NDArray[np.float64]]
#: Columns of the motion of lines, without the axis.
_MOTION = {"displacement": "u", "velocity": "v", "force_sums": "sum_f", "angular_velocity": "omega"}
_RECORDED = {"n_steps": int, "wall_time_s": int | float, "versions": dict}  # values that are used, with their types


def read_energy(directory: str | Path) -> Table:
    """Read the energy ledger of a run, each column (n_instants,).

    Columns `ENERGY_COLUMNS` and `FRICTION_COLUMNS`; with a moving bottom ``support``, ``support_lost`` and ``target``
    (energy of the support, dissipation by its damper, work done on it), J; with bars the energy of each, J; of chains
    that rub against their holder ``holder`` (dissipation by this friction), with absorbing spheres ``absorbed``, with
    viscous losses ``viscous``, J.

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
    table = _read_table(path)
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
    return _read_table(path) if path.exists() else {}


def _read_table(path: Path) -> Table:
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


def read_record(directory: str | Path) -> dict[str, Any]:
    """Read the driver's record of the run (``run.json``); empty if there is none.

    Raises
    ------
    OutputFormatError
        The file is damaged.
    """
    path = Path(directory) / RECORD_FILE
    if not path.exists():
        return {}
    record = read_json(path)
    if record is None or any(not isinstance(record[name], kind) for name, kind in _RECORDED.items() if name in record):
        raise OutputFormatError(f"{path} cannot be read: delete it, or {AGAIN}")
    return record


def read_lines(directory: str | Path, ids: tuple[int, ...], last: int) -> tuple[NDArray[np.int64], Table]:
    """Read the motion of the grains of all lines, whose ids rise, up to the step ``last``.

    Returns
    -------
    steps
        Counts of the step counter: (n_times,).
    motion
        ``displacement`` m, ``velocity`` m/s, ``force_sums`` (sums of the magnitudes of the contact forces along x, y
        and z) N and, if grains turn, ``angular_velocity`` rad/s: (n_times, n, 3).

    Raises
    ------
    MissingOutputError, OutputFormatError
        The file is missing, damaged or ends too soon, or holds other grains.
    """
    path = Path(directory) / DUMPS / LINES_FILE
    frames = list(instants(directory, LINES_FILE, names(LINES)))
    for frame in frames:
        if tuple(frame["id"].astype(int).tolist()) != ids:
            raise OutputFormatError(
                f"{path}: the snapshot of step {frame.step} holds {len(frame)} grains that are not the {len(ids)} of "
                f"the lines of the case: the files belong to different runs, or one is damaged; {AGAIN}"
            )
    if frames[-1].step < last:
        raise OutputFormatError(
            f"{path} ends with the snapshot of step {frames[-1].step}, the run at step {last}: {CUT}"
        )
    motion = {
        name: np.stack([frame.vector(*(f"{column}{axis}" for axis in "xyz")) for frame in frames])
        for name, column in _MOTION.items()
        if f"{column}x" in frames[0].columns
    }
    return np.array([frame.step for frame in frames]), motion


def check_complete(directory: Path) -> Case:
    """Compare the tables of a run with each other and with its record; return its case.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing, lacks a column, or ends before the run did.
    """
    deck, dumps = read_deck(directory), directory / DUMPS
    case, every = deck.case, deck.schedule.ledger_every
    last = int(read_energy(directory)["step"][-1])
    recorded = read_record(directory).get("n_steps")  # None for a deck that was run by hand
    if recorded is not None and last < recorded - every:
        raise OutputFormatError(f"{dumps / ENERGY_FILE} ends at step {last}, the run at step {recorded}: {CUT}")
    found = walls(case)
    columns = [wall.name for wall in found] + [bar.name for bar in assemble(case).bars]
    if columns:
        _check_series(dumps / WALLS_FILE, read_walls(directory), columns, last, every)
    if case.probes:
        columns = _probe_columns(case)
        _check_series(dumps / PROBES_FILE, read_probes(directory), columns, last, max(every, deck.schedule.probe_every))
    if case.line and not (dumps / LINES_FILE).exists():
        raise MissingOutputError(f"{dumps / LINES_FILE} is missing; {AGAIN}")
    if case.precompression and not read_static_stage(directory):
        raise MissingOutputError(f"{dumps / STATIC_STAGE_FILE} is missing; {AGAIN}")
    for name in (name for wall in found if not wall.held_layer for name, _, _ in wall_fixes(assemble(case), wall)):
        if not (path := dumps / WALL_CONTACTS_FILE.format(name)).exists():
            raise MissingOutputError(f"{path} is missing; {AGAIN}")
    return case


def check_unchanged(directory: Path) -> None:
    """Raise OutputFormatError if a file that LAMMPS wrote is not as it was at the end of the run."""
    if fault := changed_file(directory, output_names(directory)):
        raise OutputFormatError(
            f"{fault}: put back what the run wrote, or run the case again: "
            f"granwave run {directory / CASE_FILE} -o {directory} --resume"
        )


def _check_series(path: Path, table: Table, columns: list[str], last: int, every: int) -> None:
    """Check that a table exists, has these columns, and ends with the ledger."""
    if not table:
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    if missing := [name for name in columns if name not in table]:
        raise OutputFormatError(f"{path} lacks the columns {', '.join(missing)}; it has {', '.join(table)}; {AGAIN}")
    if abs(table["step"][-1] - last) > every:
        raise OutputFormatError(f"{path} ends at step {table['step'][-1]:.0f}, the ledger at step {last}: {CUT}")


def _probe_columns(case: Case) -> list[str]:
    """Return the name of one column of each probe."""
    contacts = ["contact_{}_{}_force".format(*probe.contact) for probe in case.probes if probe.contact is not None]
    return contacts + [f"sphere_{probe.sphere}_ux" for probe in case.probes if probe.contact is None]
