"""Readers of the time series and of the record of a run, and the check that its output is complete.

``dumps/energy.txt``, ``dumps/walls.txt`` and ``dumps/probes.txt`` begin with comments (``#``) and a
row of numbers for each instant; the last comment names the columns. A truncated last row is
dropped. If rows have the same instant (resumed run), the last one is used. Truncated files would
silently give wrong results.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.frame import AGAIN, CUT, read_rows
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.deck import columns
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory

#: Columns of the energy ledger.
ENERGY_COLUMNS = ("step", *columns.names(columns.LEDGER))
#: Columns that the ledger of a run without friction may lack; they are set to 0.
FRICTION_COLUMNS = ("rotational", "elastic_tangential", "friction")

Table = dict[str, NDArray[np.float64]]
_INSTANT = 0  # column of the step or the time
_RECORDED = {
    "n_steps": int,
    "wall_time_s": int | float,
    "versions": dict,
}  # values that are used, with their types


def read_energy(directory: str | Path) -> Table:
    """Read the energy record of a run, each column (n_instants,).

    Columns `ENERGY_COLUMNS` and `FRICTION_COLUMNS`; with a moving bottom ``support``,
    ``support_lost`` and ``target`` (energy of the support, dissipation by its damper, work done on
    it), J; with bars the energy of each, J; for chains with friction of the guide ``holder``
    (dissipation by this friction), with absorbing spheres ``absorbed``, with viscous losses
    ``viscous``, with cohesion ``adhesion`` (dissipation when surfaces meet and separate), with
    resistance to rolling and twisting ``rolling``, ``twisting`` (dissipation), ``elastic_rolling``
    and ``elastic_twisting``, J.

    Raises
    ------
    MissingOutputError
        The run left no ledger.
    OutputFormatError
        The ledger lacks a column, holds no row, or is damaged.
    """
    path = Path(directory) / files.DUMPS / files.ENERGY_FILE
    if not path.exists():
        case = Path(directory) / files.CASE_FILE
        command = f"granwave run CASE -o {directory}"
        if case.is_file():
            command = f"granwave run {case} -o {directory} --resume"
        raise MissingOutputError(f"{path} is missing: run the case first (use  {command})")
    table = read_table(directory, files.ENERGY_FILE)
    if missing := [name for name in ENERGY_COLUMNS if name not in table]:
        raise OutputFormatError(
            f"{path} has no columns {', '.join(missing)}; it has {', '.join(table)}; {AGAIN}"
        )
    zeros = np.zeros_like(table["time"])
    return table | {name: zeros for name in FRICTION_COLUMNS if name not in table}


def read_table(directory: str | Path, name: str) -> Table:
    """Read a table of this name in ``dumps``, each column (n_rows,); empty if the run has none.

    walls.txt
        Normal forces on walls, N, positive outwards, by name of the wall, with ``step`` and
        ``time``.
    probes.txt
        Records of the probes, with ``step`` and ``time``: ``sphere_ID_ux`` (uy, uz) displacement in
        m, ``_vx`` velocity in m/s, ``_fx`` force in N; ``contact_I_J_overlap`` in m and
        ``contact_I_J_force`` in N.
    prestage.txt
        Record of the static stage of a precompressed run, one row: ``residual`` (largest net force
        / largest contact force), ``largest_force`` N, ``contacts``, ``yielded``, ``stored``
        (elastic energy) J, ``displacement`` m, ``iterations``.
    """
    path = Path(directory) / files.DUMPS / name
    if not path.exists():
        return {}
    names: list[str] = []
    rows = []
    lines = []
    with open(
        path, encoding="ascii", errors="replace"
    ) as file:  # other bytes give an error with their line
        for number, line in enumerate(file, start=1):
            if line.startswith("#"):
                names = line[1:].split()
            elif line.endswith("\n"):  # otherwise the last line is incomplete
                rows.append(line)
                lines.append(number)
    if not rows or not names:
        what = "no names of columns" if rows else "no rows: the run ended before its first output"
        raise OutputFormatError(f"{path} holds {what}; {AGAIN}")
    values = read_rows(rows, names, lambda row: f"{path}: line {lines[row]}")
    instants = values[:, _INSTANT]
    _, backwards = np.unique(instants[::-1], return_index=True)
    values = values[len(values) - 1 - backwards]
    instants = values[:, _INSTANT]
    # rows are evenly spaced; a temporarily full disk could have left some out
    apart = np.diff(instants)
    if names[_INSTANT] == "step" and len(apart) and apart.max() > apart.min():
        n = int(apart.argmax())
        first, second = instants[n : n + 2]
        raise OutputFormatError(
            f"{path} has no rows between the steps {first:.0f} and {second:.0f}; {AGAIN}"
        )
    return {name: np.ascontiguousarray(values[:, n]) for n, name in enumerate(names)}


def read_record(directory: str | Path) -> dict[str, Any]:
    """Read the driver's record of the run (``run.json``); empty if there is none.

    Raises
    ------
    OutputFormatError
        The file is damaged.
    """
    path = Path(directory) / files.RECORD_FILE
    if not path.exists():
        return {}
    record = read_json(path)
    if record is None or any(
        not isinstance(record[name], kind) for name, kind in _RECORDED.items() if name in record
    ):
        raise OutputFormatError(f"{path} cannot be read: delete it, or {AGAIN}")
    return record


def check_complete(directory: Path, assembly: Assembly, schedule: Schedule) -> None:
    """Compare the tables of a run with each other and with its record.

    Raises
    ------
    MissingOutputError, OutputFormatError
        A file is missing, lacks a column, or ends before the run did.
    """
    dumps = directory / files.DUMPS
    case = assembly.case
    every = schedule.ledger_every
    last = int(read_energy(directory)["step"][-1])
    # None for an input script that was run by hand
    recorded = read_record(directory).get("n_steps")
    if recorded is not None and last < recorded - every:
        raise OutputFormatError(
            f"{dumps / files.ENERGY_FILE} ends at step {last}, the run at step {recorded}: {CUT}"
        )
    found = walls(assembly)
    columns = [wall.name for wall in found] + [bar.name for bar in assembly.bars]
    if columns:
        _check_series(directory, files.WALLS_FILE, columns, last, every)
    if case.probes:
        columns = [
            "contact_{}_{}_force".format(*probe.contact)
            for probe in case.probes
            if probe.contact is not None
        ]
        columns += [f"sphere_{probe.sphere}_ux" for probe in case.probes if probe.contact is None]
        _check_series(directory, files.PROBES_FILE, columns, last, max(every, schedule.probe_every))
    needed = [files.LINES_FILE] if case.line else []
    needed += [files.STATIC_STAGE_FILE] if case.precompression else []
    for wall in (wall for wall in found if not wall.held_layer):
        needed += [files.WALL_CONTACTS_FILE.format(name) for name, _, _ in wall.fixes]
    if missing := [dumps / name for name in needed if not (dumps / name).exists()]:
        raise MissingOutputError(f"{missing[0]} is missing; {AGAIN}")


def check_unchanged(results: ResultDirectory, processes: Processes = ALONE) -> None:
    """Raise OutputFormatError if a file that LAMMPS wrote has changed since the end of the run."""
    if fault := results.changed_file(results.output_names(), processes):
        raise OutputFormatError(
            f"{fault}: restore the file that the run wrote, or run the case again: "
            f"granwave run {results / files.CASE_FILE} -o {results} --resume"
        )


def _check_series(directory: Path, name: str, columns: list[str], last: int, every: int) -> None:
    """Check that a table exists, has these columns, and ends with the energy record."""
    table = read_table(directory, name)
    path = directory / files.DUMPS / name
    if not table:
        raise MissingOutputError(f"{path} is missing; {AGAIN}")
    if missing := [name for name in columns if name not in table]:
        raise OutputFormatError(
            f"{path} has no columns {', '.join(missing)}; it has {', '.join(table)}; {AGAIN}"
        )
    if abs(table["step"][-1] - last) > every:
        raise OutputFormatError(
            f"{path} ends at step {table['step'][-1]:.0f}, the energy balance at step {last}: {CUT}"
        )
