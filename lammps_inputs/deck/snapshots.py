"""Snapshots of all spheres, perhaps with the forces of all contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import (
    FORCES_AT_FRAMES,
    FORCES_OF_ALL,
    SNAPSHOT,
    WALL_CONTACTS,
    names,
    recorded,
    sources,
)
from granwave.lammps_inputs.deck.commands import column_names, command, first_or_append, joined
from granwave.lammps_inputs.deck.probes import displacements
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.records import written_in_parts
from granwave.lammps_inputs.packing.walls import wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    CHECKPOINT_FILE,
    DUMPS,
    FRAME_FORCES_FILE,
    FRAMES_FILES,
    FRAMES_RESUMED,
    of_each_rank,
)

if TYPE_CHECKING:
    from granwave.lammps_inputs.planning.schedule import Schedule

_FRAME_FORMAT = "%d %d" + " %.9g" + 3 * " %.10g" + 3 * " %.17g" + 8 * " %.9g"


def frames(assembly: Assembly, schedule: Schedule, *, restart_from: str = "") -> list[str]:
    """Return the commands of snapshots of all spheres; ``restart_from``: restart file of a resumed run."""
    case, every = assembly.case, schedule.frame_every
    chosen: list[str] = []
    columns = sources(SNAPSHOT, *recorded(case))
    if case.output.contact_forces:
        columns |= wall_force_columns(assembly)
    form = f' format line "{_FRAME_FORMAT}{" %.9g" * (len(columns) - len(names(SNAPSHOT)))}"'
    text = case.output.dump_format == "text"
    if not every:
        every = schedule.n_steps
        chosen = [
            "# The next snapshot after each step, from the list of times.",
            *command("variable        frame equal", f'"{_next_frame(schedule.frame_steps)}"'),
            "dump_modify     frames every v_frame",
        ]
    return [
        "# Snapshots of all spheres.",
        *([] if case.precompression else displacements(case)[:1]),
        "compute         sphere all gran/hysteretic/atom",
        "compute         contacts all gran/hysteretic/local",
        *command(
            "dump            frames all custom",
            f"{every} {DUMPS}/{frames_file(assembly, restart_from)}",
            *columns.values(),
        ),
        f"dump_modify     frames {first_or_append(bool(restart_from))} sort id{form if text else ''}",
        *command("dump_modify     frames", *column_names(columns)),
        *chosen,
        *(_forces_of_all(every, bool(chosen), bool(restart_from)) if case.output.contact_forces else []),
    ]


def _forces_of_all(every: int, chosen: bool, resumed: bool) -> list[str]:
    """Return the commands for the contact forces at every snapshot; ``chosen``: its steps come from a list."""
    columns = sources(FORCES_AT_FRAMES, FORCES_OF_ALL)
    form = f'"{joined(["%.17g"] * len(columns))}"'
    return [
        "# The forces of all contacts at every snapshot.",
        f"dump            contact_forces all local {every} {DUMPS}/{FRAME_FORCES_FILE} {joined(columns.values())}",
        f"dump_modify     contact_forces {first_or_append(resumed)} format line {form}",
        *(f"dump_modify     contact_forces {renamed}" for renamed in column_names(columns)),
        *(["dump_modify     contact_forces every v_frame"] if chosen else []),
    ]


def wall_force_columns(assembly: Assembly) -> dict[str, str]:
    """Return the columns of the normal forces of walls on each sphere, in snapshots with contact forces."""
    fixes = [fix for wall in walls(assembly) if not wall.held_layer for fix, _, _ in wall_fixes(assembly, wall)]
    force = names(WALL_CONTACTS).index("force") + 1
    return {f"wall_{fix}": f"f_{fix}[{force}]" for fix in dict.fromkeys(fixes)}


def frames_file(assembly: Assembly, restart_from: str = "") -> str:
    """Return the name of the dump of snapshots, with "%" if each rank writes its own.

    LAMMPS appends to text, but not to binary files: a run that is resumed from a restart file writes one of its own. So
    does one that writes in parts, since it may have another number of ranks.
    """
    form, parts = assembly.case.output.dump_format, written_in_parts(assembly)
    name = FRAMES_FILES[form]
    if restart_from and (form == "binary" or parts):
        prefix, suffix = CHECKPOINT_FILE.split("{}")
        name = FRAMES_RESUMED[form].format(restart_from.removeprefix(prefix).removesuffix(suffix))
    return of_each_rank(name) if parts else name


def _next_frame(steps: tuple[int, ...]) -> str:
    """Return a formula for the next of the steps after the present one; after the last, a step beyond the run.

    It depends on the present step only, so that it also holds in a resumed run.
    """
    later = [*steps[1:], 2 * steps[-1]]
    terms = [f"(step>={a})*{b - a}" for a, b in zip(steps, later, strict=True)]
    lines, line = [], str(steps[0])
    for term in terms:
        if len(line) + len(term) > 90:
            lines.append(line)
            line = ""
        line += "+" + term
    return " &\n                ".join([*lines, line])
