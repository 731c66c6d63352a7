"""Output of LAMMPS: snapshots, histories, probes, walls in time, contacts at the end and after the
static stage.

The forces after the static stage are written once, by the start of a run; a run that is resumed
keeps the files.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

from granwave.lammps_inputs import run_directory
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.deck import columns as table
from granwave.lammps_inputs.deck.columns import names, recorded, sources
from granwave.lammps_inputs.deck.commands import (
    command,
    dump,
    id_ranges,
    time_series,
    write_dump,
)
from granwave.lammps_inputs.deck.plugin_columns import WALL_FORCE, PairColumn
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import all_line_ids, written_in_parts
from granwave.lammps_inputs.packing.walls import PLATE, Wall, moving_fix, plane_fixes, walls
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.run_directory import DUMPS, of_each_rank
from granwave.lammps_inputs.script_words import joined


def wall_forces(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the forces on walls, positive outwards."""
    case = assembly.case
    found = walls(assembly)
    bars = assembly.bars
    if not found and not bars:
        return []
    columns = {wall.name: f"v_{wall.name}" for wall in found} | {
        bar.name: PairColumn.FORCE.of(f"c_on_{bar.name}") for bar in bars
    }
    if support := moving_fix(assembly):
        columns |= {
            f"bottom_{name}": source
            for name, source in sources(table.MOVING_WALL, of=support).items()
        }
    if case.load.plate is not None:
        columns |= {
            f"{PLATE}_{name}": source
            for name, source in sources(table.MOVING_WALL, of=PLATE).items()
        }
    columns = {"time": "v_time"} | columns
    file = run_directory.WALLS_FILE
    return [
        "# Force of the spheres on each wall and bar, N, positive outwards.",
        *(f"variable        {wall.name} equal {outward_force(wall)}" for wall in found),
        *time_series("walls", schedule.wall_every, file, "wall forces, N", columns, resumed),
    ]


def outward_force(wall: Wall, prefix: str = "") -> str:
    """Return the formula of the force of the spheres on a wall, positive outwards; ``prefix``: of
    its fixes.
    """
    sources = ["held"] if wall.held_layer else [prefix + name for name, _, _ in wall.fixes]
    sign = "-" if wall.outward < 0 else "+"
    component = WALL_FORCE[wall.axis]
    terms = (f"{sign}{component.of(f'f_{source}')}" for source in sources)
    return "".join(terms).removeprefix("+")


def probes(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of probes of spheres and contacts."""
    if not case.probes:
        return []
    lines = [
        "# Probes: displacement, velocity and force of spheres; overlap and force of contacts."
    ]
    if not case.precompression:
        lines += displacements(case)[1:]
    columns = {"time": "v_time"}
    for n, probe in enumerate(case.probes, start=1):
        if probe.contact is not None:
            lines.append(
                f"compute         probe{n} all gran/hysteretic/contact {joined(probe.contact)}"
            )
            label = "contact_{}_{}".format(*probe.contact)
            columns |= {f"{label}_overlap": f"c_probe{n}[1]", f"{label}_force": f"c_probe{n}[2]"}
            continue
        values = {
            f"u{axis}": f"C_probed[{probe.sphere}][{number}]"
            for number, axis in enumerate("xyz", start=1)
        }
        values |= {
            component: f"{component}[{probe.sphere}]"
            for component in ("vx", "vy", "vz", "fx", "fy", "fz")
        }
        lines += [
            f"variable        probe{n}{quantity} equal {source}"
            for quantity, source in values.items()
        ]
        columns |= {
            f"sphere_{probe.sphere}_{quantity}": f"v_probe{n}{quantity}" for quantity in values
        }
    return lines + time_series(
        "probes",
        schedule.probe_every,
        run_directory.PROBES_FILE,
        "probes, SI units",
        columns,
        resumed,
    )


def displacements(case: Case) -> list[str]:
    """Return the commands for displacements from the data file, of all spheres and of probed
    spheres.
    """
    lines = ["compute         displacement all displace/atom"]
    spheres = [probe.sphere for probe in case.probes if probe.sphere is not None]
    if spheres:
        lines.append(f"group           probes id {joined(dict.fromkeys(spheres))}")
        lines.append("compute         probed probes displace/atom")
    return lines


_FRAME_FORMAT = "%d %d" + " %.9g" + 3 * " %.10g" + 3 * " %.17g" + 8 * " %.9g"


def frames(assembly: Assembly, schedule: Schedule, *, restart_from: str = "") -> list[str]:
    """Return the commands of snapshots of all spheres; ``restart_from``: restart file of a resumed
    run.
    """
    case = assembly.case
    every = schedule.frame_every
    resumed = bool(restart_from)
    chosen = list[str]()
    forces = list[str]()
    columns = sources(table.SNAPSHOT, *recorded(case))
    if case.output.contact_forces:
        force = (
            names(table.WALL_CONTACTS).index("force") + 1
        )  # normal forces of walls on each sphere
        columns |= {f"wall_{fix}": f"f_{fix}[{force}]" for fix in plane_fixes(assembly)}
    form = _FRAME_FORMAT + " %.9g" * (len(columns) - len(names(table.SNAPSHOT)))
    if not every:
        every = schedule.n_steps
        chosen = [
            "# Next snapshot after each step, from the list of times.",
            *command("variable        frame equal", f'"{_next_frame(schedule.frame_steps)}"'),
            "dump_modify     frames every v_frame",
        ]
    if case.output.contact_forces:
        at_frames = sources(table.FORCES_AT_FRAMES, table.FORCES_OF_ALL)
        forces = [
            "# Forces of all contacts at every snapshot.",
            *dump("contact_forces", "local", every, run_directory.FRAME_FORCES_FILE, at_frames, resumed,
                  form=joined(["%.17g"] * len(at_frames))),
            *(["dump_modify     contact_forces every v_frame"] if chosen else []),
        ]  # fmt: skip
    return [
        "# Snapshots of all spheres.",
        *([] if case.precompression else displacements(case)[:1]),
        "compute         sphere all gran/hysteretic/atom",
        "compute         contacts all gran/hysteretic/local",
        *dump("frames", "custom", every, frames_file(assembly, restart_from), columns, resumed,
              form=form if case.output.dump_format == "text" else "", one_line=True,
              parts=written_in_parts(assembly)),
        *chosen,
        *forces,
    ]  # fmt: skip


def frames_file(assembly: Assembly, restart_from: str = "") -> str:
    """Return the name of the dump of snapshots, with "%" if it has several files.

    LAMMPS appends to text, but not to binary files: a run that is resumed from a restart file
    writes separate files. So does a run that writes in parts, because it may have another number of
    ranks.
    """
    form = assembly.case.output.dump_format
    parts = written_in_parts(assembly)
    name = run_directory.FRAMES_FILES[form]
    if restart_from and (form == "binary" or parts):
        step = re.findall(r"\d+", restart_from)[0]  # step in the name of a checkpoint
        name = run_directory.FRAMES_RESUMED[form].format(step)
    return of_each_rank(name) if parts else name


def _next_frame(steps: tuple[int, ...]) -> str:
    """Return a formula for the next of the steps after the present step; after the last of them, a
    step beyond the run.

    It depends on the present step only, so that it also holds in a resumed run.
    """
    lines = [str(steps[0])]
    for here, there in itertools.pairwise((*steps, 2 * steps[-1])):
        term = f"(step>={here})*{there - here}"
        lines += [""] if len(lines[-1]) + len(term) > 90 else []
        lines[-1] += f"+{term}"
    return " &\n                ".join(lines)


def history(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the history of a chain: displacements and velocities of all
    particles, contact forces.
    """
    if not schedule.history_every:
        return []
    every = schedule.history_every
    moved = run_directory.HISTORY_FILE
    forces = run_directory.FORCES_FILE
    return [
        "# History of the chain.",
        *dump(
            "history",
            "custom",
            every,
            moved,
            sources(table.HISTORY),
            resumed,
            form="%d %.17g %.17g",
        ),
        *dump(
            "forces", "local", every, forces, sources(table.FORCES), resumed, form="%.9g %.9g %.17g"
        ),
    ]


def lines(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the motion of lines of grains, and of the sums of the forces on
    each.
    """
    case = assembly.case
    if not case.line:
        return []
    columns = sources(table.LINES, *recorded(case))
    return [
        "# History of lines of grains: sums of the magnitudes of the components of their contact "
        "forces.",
        "compute         sums all gran/hysteretic/sums",
        *command("group           lines id", id_ranges(all_line_ids(assembly))),
        *dump("lines", "custom", schedule.line_every, run_directory.LINES_FILE, columns, resumed, group="lines",
              form="%d" + " %.12g" * (len(columns) - 1), one_line=True),
    ]  # fmt: skip


def contacts_file(assembly: Assembly, name: str = run_directory.CONTACTS_FILE) -> str:
    """Return the name of the dump of the contacts at the end, or of another dump, with "%" if it
    has several files.
    """
    return of_each_rank(name) if written_in_parts(assembly) else name


def dumps_at_end(assembly: Assembly) -> list[str]:
    """Return the commands for the last snapshot, if missing, and for the final state of all
    contacts and walls.
    """
    case = assembly.case
    parts = written_in_parts(assembly)
    lines = [
        "# Last snapshot, unless the run ended on one.",
        "dump_modify     frames every 1",
        *(["dump_modify     contact_forces every 1"] if case.output.contact_forces else []),
        *(count_commands() if parts else []),
        "run             0 post no",
        "",
        "# All contacts of the run, and all spheres that touched a wall.",
        *write_dump(
            "local",
            contacts_file(assembly),
            sources(table.CONTACTS, *recorded(case)),
            parts=parts,
        ),
        *([_COUNT.format(run_directory.COUNT_FILE)] if parts else []),
    ]
    for fix in plane_fixes(assembly):
        columns = sources(table.WALL_CONTACTS, *recorded(case), of=fix)
        lines += write_dump(
            "custom", run_directory.WALL_CONTACTS_FILE.format(fix), columns, columns["peak_overlap"]
        )
    return lines


def count_commands() -> list[str]:
    """Return the commands for the number of contacts, from the sum and the mean of a column that is
    never 0.

    It is written to a file, because only the first part of a dump has a header, so that truncated
    other parts would not be recognised.
    """
    column = names(table.CONTACTS).index("i") + 1
    return [
        f"compute         all_contacts all reduce sum c_contacts[{column}] inputs local",
        f"compute         mean_contact all reduce ave c_contacts[{column}] inputs local",
        'variable        n_contacts equal "round(c_all_contacts/(c_mean_contact+(c_mean_contact==0)))"',
    ]


# the number of contacts, to a file
_COUNT = f'print           "$(v_n_contacts:%.0f)" file {DUMPS}/{{}}'


def initial_forces(assembly: Assembly) -> list[str]:
    """Return the commands that write the forces of all contacts, and of the spheres that press on
    walls.
    """
    parts = written_in_parts(assembly)
    file = contacts_file(assembly, run_directory.INITIAL_FORCES_FILE)
    lines = [
        "# Forces of all contacts under the static load.",
        *write_dump("local", file, sources(table.FORCES), parts=parts),
    ]
    lines += [_COUNT.format(run_directory.INITIAL_COUNT_FILE)] if parts else []
    for fix in plane_fixes(assembly):
        columns = sources(table.WALL_FORCES, of=fix)
        lines += write_dump(
            "custom", run_directory.INITIAL_WALL_FORCES_FILE.format(fix), columns, columns["force"]
        )
    computes = ["mean_contact", "all_contacts", "contacts"] if parts else ["contacts"]
    return [*lines, *(f"uncompute       {name}" for name in computes)]


def output_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files that LAMMPS writes to dumps/."""
    case = assembly.case
    stage = assembly.case.precompression
    planes = plane_fixes(assembly)
    parts = written_in_parts(assembly)
    initial = contacts_file(assembly, run_directory.INITIAL_FORCES_FILE)
    wanted: list[tuple[object, Sequence[str]]] = [
        (True, [run_directory.ENERGY_FILE, frames_file(assembly), contacts_file(assembly)]),
        (True, [run_directory.WALL_CONTACTS_FILE.format(fix) for fix in planes]),
        (parts, [run_directory.COUNT_FILE]),
        (walls(assembly) or assembly.bars, [run_directory.WALLS_FILE]),
        (case.probes, [run_directory.PROBES_FILE]),
        (schedule.history_every, [run_directory.HISTORY_FILE, run_directory.FORCES_FILE]),
        (case.output.contact_forces, [run_directory.FRAME_FORCES_FILE]),
        (case.line, [run_directory.LINES_FILE]),
        (stage and stage.presses, [run_directory.MOVED_WALLS_FILE]),
        (stage, [initial, *(run_directory.INITIAL_WALL_FORCES_FILE.format(fix) for fix in planes)]),
        (stage and parts, [run_directory.INITIAL_COUNT_FILE]),
        (stage, [run_directory.STATIC_STAGE_FILE, run_directory.STATIC_FILE]),
    ]
    return [*itertools.chain.from_iterable(names for there, names in wanted if there)]
