"""Contacts and walls at the end of a run, and the number of contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import CONTACTS, WALL_CONTACTS, names, recorded, sources
from granwave.lammps_inputs.deck.commands import column_names, command, joined
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.records import written_in_parts
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import CONTACTS_FILE, COUNT_FILE, DUMPS, WALL_CONTACTS_FILE, of_each_rank

if TYPE_CHECKING:
    pass


def contacts_file(assembly: Assembly, name: str = CONTACTS_FILE) -> str:
    """Return the name of the dump of the contacts at the end, or of another, with "%" if each rank writes its own."""
    return of_each_rank(name) if written_in_parts(assembly) else name


def dumps_at_end(assembly: Assembly) -> list[str]:
    """Return the commands for the last snapshot, if missing, and for the final state of all contacts and walls."""
    case = assembly.case
    contacts = sources(CONTACTS, *recorded(case))
    lines = [
        "# The last snapshot, if the run did not end on one.",
        "dump_modify     frames every 1",
        *(["dump_modify     contact_forces every 1"] if case.output.contact_forces else []),
        *(count_commands() if written_in_parts(assembly) else []),
        "run             0 post no",
        "",
        "# Every contact there was, and every sphere that touched a wall.",
        *command(
            f"write_dump      all local {DUMPS}/{contacts_file(assembly)}",
            *contacts.values(),
            "modify format line",
            f'"{joined(["%.17g"] * len(contacts))}"',
            *column_names(contacts),
        ),
        *([count_written(COUNT_FILE)] if written_in_parts(assembly) else []),
    ]
    for wall in walls(assembly):
        if wall.held_layer:
            continue
        for fix, _, _ in wall_fixes(assembly, wall):
            columns = sources(WALL_CONTACTS, *recorded(case), of=fix)
            lines += command(
                f"write_dump      all custom {DUMPS}/{WALL_CONTACTS_FILE.format(fix)} id",
                *columns.values(),
                f"modify sort id thresh {columns['peak_overlap']} > 0.0 format line",
                f'"%d {joined(["%.17g"] * len(columns))}"',
                *column_names(columns),
            )
    return lines


def count_commands() -> list[str]:
    """Return the commands for the number of contacts, from the sum and the mean of a column that is never 0.

    It is written to a file, as the dumps of all ranks but the first have no header that tells if they were cut.
    """
    column = names(CONTACTS).index("i") + 1
    return [
        f"compute         all_contacts all reduce sum c_contacts[{column}] inputs local",
        f"compute         mean_contact all reduce ave c_contacts[{column}] inputs local",
        'variable        n_contacts equal "round(c_all_contacts/(c_mean_contact+(c_mean_contact==0)))"',
    ]


def count_written(file: str) -> str:
    """Return the command that writes the number of contacts to a file."""
    return f'print           "$(v_n_contacts:%.0f)" file {DUMPS}/{file}'
