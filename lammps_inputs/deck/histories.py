"""Chains, and lines of grains, in time."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import FORCES, HISTORY, LINES, TURNING, sources
from granwave.lammps_inputs.deck.commands import column_names, command, first_or_append, id_ranges, joined
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.lines import all_line_ids
from granwave.lammps_inputs.run_directory import DUMPS, FORCES_FILE, HISTORY_FILE, LINES_FILE

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.planning.schedule import Schedule


def history(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the history of a chain: displacements and velocities of all particles, contact forces."""
    every = schedule.history_every
    if not every:
        return []
    moved, forces = sources(HISTORY), sources(FORCES)
    return [
        "# The chain in time.",
        *command(f"dump            history all custom {every} {DUMPS}/{HISTORY_FILE}", *moved.values()),
        f'dump_modify     history {first_or_append(resumed)} sort id format line "%d %.17g %.17g"',
        *(f"dump_modify     history {renamed}" for renamed in column_names(moved)),
        f"dump            forces all local {every} {DUMPS}/{FORCES_FILE} {joined(forces.values())}",
        f'dump_modify     forces {first_or_append(resumed)} format line "%.9g %.9g %.17g"',
        *(f"dump_modify     forces {renamed}" for renamed in column_names(forces)),
    ]


def lines(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the motion of lines of grains, and of the sums of the forces on each."""
    case = assembly.case
    if not case.line:
        return []
    columns = sources(LINES, *([TURNING] if case.has_rotation else []))
    return [
        "# Lines of grains in time; sums of the magnitudes of the components of their contact forces.",
        "compute         sums all gran/hysteretic/sums",
        *command("group           lines id", id_ranges(all_line_ids(assembly))),
        *command(f"dump            lines lines custom {schedule.line_every} {DUMPS}/{LINES_FILE}", *columns.values()),
        f'dump_modify     lines {first_or_append(resumed)} sort id format line "%d{" %.12g" * (len(columns) - 1)}"',
        *command("dump_modify     lines", *column_names(columns)),
    ]
