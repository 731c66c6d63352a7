"""Forces of all contacts after the static stage, in the LAMMPS input script.

They are written once, by the start of a run; a run that is resumed keeps the files.
"""

from __future__ import annotations

from granwave.lammps_inputs.deck.columns import FORCES, WALL_FORCES, sources
from granwave.lammps_inputs.deck.commands import command, joined
from granwave.lammps_inputs.deck.final_contacts import contacts_file, count_commands, count_written
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.records import written_in_parts
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    DUMPS,
    INITIAL_COUNT_FILE,
    INITIAL_FORCES_FILE,
    INITIAL_WALL_FORCES_FILE,
)

_COMPUTES = ("mean_contact", "all_contacts")  # of the number of contacts


def contacts_of_stage(assembly: Assembly) -> list[str]:
    """Return the compute of contacts, before the last step of the stage; `initial_forces` takes it back."""
    return [
        "compute         contacts all gran/hysteretic/local",
        *(count_commands() if written_in_parts(assembly) else []),
    ]


def initial_forces(assembly: Assembly) -> list[str]:
    """Return the commands that write the forces of all contacts, and of the spheres that press on walls."""
    columns = sources(FORCES)
    lines = command(
        f"write_dump      all local {DUMPS}/{contacts_file(assembly, INITIAL_FORCES_FILE)}",
        *columns.values(),
        "modify format line",
        f'"{joined(["%.17g"] * len(columns))}"',
        *_names(columns),
    )
    lines += [count_written(INITIAL_COUNT_FILE)] if written_in_parts(assembly) else []
    for fix in (fix for wall in walls(assembly) if not wall.held_layer for fix, _, _ in wall_fixes(assembly, wall)):
        columns = sources(WALL_FORCES, of=fix)
        lines += command(
            f"write_dump      all custom {DUMPS}/{INITIAL_WALL_FORCES_FILE.format(fix)} id",
            *columns.values(),
            f'modify sort id thresh {columns["force"]} > 0.0 format line "%d %.17g"',
            *_names(columns),
        )
    return [
        "# The forces of all contacts under the static load.",
        *lines,
        *(f"uncompute       {name}" for name in (*(_COMPUTES if written_in_parts(assembly) else ()), "contacts")),
    ]


def _names(columns: dict[str, str]) -> list[str]:
    """Return the names of columns, for a dump whose sources are none of them."""
    return [f"colname {source} {name}" for name, source in columns.items()]
