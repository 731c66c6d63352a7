"""Check that a run's output is complete; truncated files would silently give wrong results."""

from __future__ import annotations

from pathlib import Path

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.number_rows import AGAIN, CUT
from granwave.analysis.lammps_output.run_record import read_record
from granwave.analysis.lammps_output.time_series import Table, read_energy, read_probes, read_static_stage, read_walls
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck.deck import read_deck
from granwave.lammps_inputs.ownership import output_names
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    DUMPS,
    ENERGY_FILE,
    LINES_FILE,
    PROBES_FILE,
    STATIC_STAGE_FILE,
    WALL_CONTACTS_FILE,
    WALLS_FILE,
)
from granwave.lammps_inputs.run_state import changed_file


def check_complete(directory: Path) -> None:
    """Compare the tables of a run with each other and with its record.

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
