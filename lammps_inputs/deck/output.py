"""Output commands of the LAMMPS input script: energy ledger, walls, probes, snapshots, final contacts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import (
    ABSORBED,
    CONTACTS,
    DENTS,
    FORCES,
    FORCES_AT_FRAMES,
    FORCES_OF_ALL,
    FREE_PLATE,
    FRICTION,
    HISTORY,
    HOLDER,
    LEDGER,
    LINES,
    LOSS,
    MOVING_WALL,
    ROTATION,
    SNAPSHOT,
    SUPPORT,
    TANGENTIAL,
    TIMESTEP,
    TURNING,
    VISCOUS,
    WALL_CONTACTS,
    names,
    sources,
)  # fmt: skip
from granwave.lammps_inputs.deck.commands import command, id_ranges, joined, num
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.lines import all_line_ids
from granwave.lammps_inputs.packing.walls import PLATE, Wall, moving_fix, wall_fixes, walls
from granwave.lammps_inputs.run_directory import (
    CHECKPOINT_FILE,
    CONTACTS_FILE,
    COUNT_FILE,
    DUMPS,
    ENERGY_FILE,
    FORCES_FILE,
    FRAME_FORCES_FILE,
    FRAMES_FILES,
    FRAMES_RESUMED,
    HISTORY_FILE,
    INITIAL_COUNT_FILE,
    INITIAL_FORCES_FILE,
    INITIAL_WALL_FORCES_FILE,
    LINES_FILE,
    MOVED_WALLS_FILE,
    PROBES_FILE,
    STATIC_FILE,
    STATIC_STAGE_FILE,
    WALL_CONTACTS_FILE,
    WALLS_FILE,
    of_each_rank,
)

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.packing.bars import PlacedBar
    from granwave.lammps_inputs.planning.schedule import Schedule

POTENTIAL = "c_potential"  # potential energy of dead loads, zero at the positions of the data file
STATIC = "v_static"  # elastic and potential energy at the start of the run

_FRAME_FORMAT = "%d %d" + " %.9g" + 3 * " %.10g" + 3 * " %.17g" + 8 * " %.9g"


def ledger(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of the energy ledger, which also counts yielded contacts."""
    case = assembly.case
    planes = [name for wall in walls(assembly) if not wall.held_layer for name, _, _ in wall_fixes(assembly, wall)]
    bars = [bar.name for bar in assembly.bars]
    columns = sources(LEDGER) | {name: f"v_energy_{name}" for name in bars}
    # contacts with faces of bars belong to the pair style
    stored, lost = ([f"f_{name}[{n}]" for name in planes] for n in (4, 5))
    at_bars = [[f"c_on_{name}[{n}]" for name in bars] for n in (4, 5)]
    elastic, dissipated = ["c_contact", *stored], ["c_contact[1]", *lost]
    lines = []
    moving = ["c_kinetic"]
    if case.has_rotation:
        columns |= sources(ROTATION)
        columns |= {"rotational": "v_rotational"} if assembly.has_cylinders else {}
        lines.append("compute         rotational all erotate/sphere")
        if assembly.has_cylinders:  # of spheres of their masses and radii, and what they have beyond
            lines.append("variable        rotational equal c_rotational+f_cylinders")
        moving.append("v_rotational" if assembly.has_cylinders else "c_rotational")
    if case.load.plate is not None:
        columns |= sources(FREE_PLATE, of=PLATE)
        moving += sources(FREE_PLATE, of=PLATE).values()
    if case.moves_otherwise:
        columns["kinetic"] = "v_motion"
        lines.append(f"variable        motion equal {_sum(moving)}")
    if case.has_friction:
        stretched, rubbed = ([f"f_{name}[{n}]" for name in planes] for n in (8, 9))
        columns |= sources(TANGENTIAL)
        lines.append(f"variable        elastic_tangential equal {_sum(['c_contact[6]', *stretched])}")
        lines.append(f"variable        friction equal {_sum(['c_contact[7]', *rubbed])}")
        stored, lost = [*stored, *stretched], [*lost, *rubbed]
        elastic.append("v_elastic_tangential")
        dissipated.append("v_friction")
    if case.has_loss:
        damped = [f"f_{name}[16]" for name in planes]
        columns |= sources(VISCOUS)
        viscous = ["c_contact[8]", *damped]  # a variable within another has 15 digits
        lines.append(f"variable        viscous equal {_sum(viscous)}")
        lost = [*lost, *damped]
        at_bars[1] += [f"c_on_{name}[8]" for name in bars]
        dissipated += viscous
    if case.has_holder_friction:
        columns |= sources(HOLDER)
        dissipated.append(columns["holder"])
    if case.absorb:
        columns |= sources(ABSORBED)
        layers = [f"f_absorb{number}" for number in range(1, len(case.absorb) + 1)]
        lines.append(f"variable        absorbed equal {_sum(layers)}")
        dissipated.append(columns["absorbed"])
    if support := moving_fix(assembly):
        columns |= sources(SUPPORT, of=support)
        elastic.append(columns["support"])
        dissipated.append(columns["support_lost"])
    if schedule.adaptive:
        columns |= sources(TIMESTEP)
        lines += [f"variable        {name} equal f_step[{n}]" for n, name in enumerate(names(TIMESTEP), start=1)]
    elastic += [f"c_elastic_{name}" for name in bars]
    if case.precompression:
        elastic += [POTENTIAL, f"-{STATIC}"]
    return [
        "# Energies, J. Their sum must stay equal to the input.",
        "compute         kinetic all ke",
        "compute         contact all gran/hysteretic/energy",
        f"variable        time equal step*{num(schedule.timestep) if schedule.adaptive else 'dt'}",
        *(line for bar in assembly.bars for line in _bar_energy(bar)),
        *lines,
        f"variable        elastic_wall equal {_sum(stored + at_bars[0])}",
        f"variable        dissipated_wall equal {_sum(lost + at_bars[1])}",
        f"variable        elastic equal {_sum(elastic)}",
        f"variable        dissipated equal {_sum(dissipated)}",
        "variable        struck_velocity equal vcm(struck,z)",
        *_series("ledger", schedule.ledger_every, ENERGY_FILE, "energy ledger, SI units", columns, resumed),
    ]


def _sum(terms: list[str]) -> str:
    return "+".join(terms).replace("+-", "-") or "0.0"


def _bar_energy(bar: PlacedBar) -> list[str]:
    """Return the commands for the energy of a bar, kinetic and elastic, and for its contact with the chain."""
    name = bar.name
    return [
        f"compute         on_{name} all gran/hysteretic/contact {bar.touches} {bar.face}",
        f"compute         bonds_{name} {name} bond/local engpot",
        f"compute         elastic_{name} {name} reduce sum c_bonds_{name} inputs local",
        f"compute         kinetic_{name} {name} ke",
        f"variable        energy_{name} equal c_kinetic_{name}+c_elastic_{name}",
    ]


def wall_forces(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the forces on walls, positive outwards."""
    case, found, bars = assembly.case, walls(assembly), assembly.bars
    if not found and not bars:
        return []
    columns = {wall.name: f"v_{wall.name}" for wall in found} | {bar.name: f"c_on_{bar.name}[2]" for bar in bars}
    if support := moving_fix(assembly):
        columns |= {f"bottom_{name}": source for name, source in sources(MOVING_WALL, of=support).items()}
    if case.load.plate is not None:
        columns |= {f"{PLATE}_{name}": source for name, source in sources(MOVING_WALL, of=PLATE).items()}
    return [
        "# Force of the spheres on each wall and bar, N, positive outwards.",
        *(f"variable        {wall.name} equal {outward_force(assembly, wall)}" for wall in found),
        *_series("walls", schedule.wall_every, WALLS_FILE, "wall forces, N", {"time": "v_time"} | columns, resumed),
    ]


def probes(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of probes of spheres and contacts."""
    if not case.probes:
        return []
    lines = ["# Probes: displacement, velocity and force of spheres; overlap and force of contacts."]
    if not case.precompression:
        lines += displacements(case)[1:]
    columns = {"time": "v_time"}
    for n, probe in enumerate(case.probes, start=1):
        if probe.contact is not None:
            lines.append(f"compute         probe{n} all gran/hysteretic/contact {joined(probe.contact)}")
            label = "contact_{}_{}".format(*probe.contact)
            columns |= {f"{label}_overlap": f"c_probe{n}[1]", f"{label}_force": f"c_probe{n}[2]"}
            continue
        for quantity, source in _sphere_probe(probe.sphere or 0).items():
            lines.append(f"variable        probe{n}{quantity} equal {source}")
            columns[f"sphere_{probe.sphere}_{quantity}"] = f"v_probe{n}{quantity}"
    return lines + _series("probes", schedule.probe_every, PROBES_FILE, "probes, SI units", columns, resumed)


def displacements(case: Case) -> list[str]:
    """Return the commands for displacements from the data file, of all spheres and of those probed."""
    lines = ["compute         displacement all displace/atom"]
    spheres = [probe.sphere for probe in case.probes if probe.sphere is not None]
    if spheres:
        lines.append(f"group           probes id {joined(dict.fromkeys(spheres))}")
        lines.append("compute         probed probes displace/atom")
    return lines


def frames(assembly: Assembly, schedule: Schedule, *, restart_from: str = "") -> list[str]:
    """Return the commands of snapshots of all spheres; ``restart_from``: restart file of a resumed run."""
    case, every = assembly.case, schedule.frame_every
    chosen: list[str] = []
    columns = sources(SNAPSHOT, *_recorded(case))
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
        f"dump_modify     frames {_first(bool(restart_from))} sort id{form if text else ''}",
        *command("dump_modify     frames", *_names(columns)),
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
        f"dump_modify     contact_forces {_first(resumed)} format line {form}",
        *(f"dump_modify     contact_forces {renamed}" for renamed in _names(columns)),
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
    form, parts = assembly.case.output.dump_format, assembly.in_parts
    name = FRAMES_FILES[form]
    if restart_from and (form == "binary" or parts):
        prefix, suffix = CHECKPOINT_FILE.split("{}")
        name = FRAMES_RESUMED[form].format(restart_from.removeprefix(prefix).removesuffix(suffix))
    return of_each_rank(name) if parts else name


def contacts_file(assembly: Assembly, name: str = CONTACTS_FILE) -> str:
    """Return the name of the dump of the contacts at the end, or of another, with "%" if each rank writes its own."""
    return of_each_rank(name) if assembly.in_parts else name


def history(case: Case, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands for the history of a chain: displacements and velocities of all particles, contact forces."""
    every = schedule.history_every
    if not every:
        return []
    moved, forces = sources(HISTORY), sources(FORCES)
    return [
        "# The chain in time.",
        *command(f"dump            history all custom {every} {DUMPS}/{HISTORY_FILE}", *moved.values()),
        f'dump_modify     history {_first(resumed)} sort id format line "%d %.17g %.17g"',
        *(f"dump_modify     history {renamed}" for renamed in _names(moved)),
        f"dump            forces all local {every} {DUMPS}/{FORCES_FILE} {joined(forces.values())}",
        f'dump_modify     forces {_first(resumed)} format line "%.9g %.9g %.17g"',
        *(f"dump_modify     forces {renamed}" for renamed in _names(forces)),
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
        f'dump_modify     lines {_first(resumed)} sort id format line "%d{" %.12g" * (len(columns) - 1)}"',
        *command("dump_modify     lines", *_names(columns)),
    ]


def thermo(case: Case, schedule: Schedule) -> list[str]:
    """Return the commands of thermodynamic output."""
    every = schedule.block_steps or max(1, schedule.n_steps // schedule.ledger_every // 20) * schedule.ledger_every
    kinetic = "v_motion" if case.moves_otherwise else "c_kinetic"
    return [
        "# The log.",
        f"thermo_style    custom step v_time {kinetic} v_elastic v_dissipated c_contact[2] v_struck_velocity",
        "thermo_modify   lost error norm no flush yes",
        f"thermo          {every}",
        "# Nobody looks at these, and each is computed at every step at which any fix above is due.",
        "uncompute       thermo_press",
        "uncompute       thermo_pe",
    ]


def dumps_at_end(assembly: Assembly) -> list[str]:
    """Return the commands for the last snapshot, if missing, and for the final state of all contacts and walls."""
    case = assembly.case
    contacts = sources(CONTACTS, *_recorded(case))
    lines = [
        "# The last snapshot, if the run did not end on one.",
        "dump_modify     frames every 1",
        *(["dump_modify     contact_forces every 1"] if case.output.contact_forces else []),
        *(count_commands() if assembly.in_parts else []),
        "run             0 post no",
        "",
        "# Every contact there was, and every sphere that touched a wall.",
        *command(
            f"write_dump      all local {DUMPS}/{contacts_file(assembly)}",
            *contacts.values(),
            "modify format line",
            f'"{joined(["%.17g"] * len(contacts))}"',
            *_names(contacts),
        ),
        *([count_written(COUNT_FILE)] if assembly.in_parts else []),
    ]
    for wall in walls(assembly):
        if wall.held_layer:
            continue
        for fix, _, _ in wall_fixes(assembly, wall):
            columns = sources(WALL_CONTACTS, *_recorded(case), of=fix)
            lines += command(
                f"write_dump      all custom {DUMPS}/{WALL_CONTACTS_FILE.format(fix)} id",
                *columns.values(),
                f"modify sort id thresh {columns['peak_overlap']} > 0.0 format line",
                f'"%d {joined(["%.17g"] * len(columns))}"',
                *_names(columns),
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


def output_files(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the names of the files that LAMMPS writes to dumps/."""
    case = assembly.case
    planes = [fix for wall in walls(assembly) if not wall.held_layer for fix, _, _ in wall_fixes(assembly, wall)]
    files = [
        ENERGY_FILE,
        frames_file(assembly),
        contacts_file(assembly),
        *(WALL_CONTACTS_FILE.format(fix) for fix in planes),
    ]
    files += [COUNT_FILE] if assembly.in_parts else []
    files += [WALLS_FILE] if wall_forces(assembly, schedule) else []
    files += [PROBES_FILE] if case.probes else []
    files += [HISTORY_FILE, FORCES_FILE] if schedule.history_every else []
    files += [FRAME_FORCES_FILE] if case.output.contact_forces else []
    files += [LINES_FILE] if case.line else []
    if case.precompression is None:
        return files
    files += [MOVED_WALLS_FILE] if case.precompression.presses else []
    files += [contacts_file(assembly, INITIAL_FORCES_FILE), *(INITIAL_WALL_FORCES_FILE.format(fix) for fix in planes)]
    files += [INITIAL_COUNT_FILE] if assembly.in_parts else []
    return [*files, STATIC_STAGE_FILE, STATIC_FILE]


def _recorded(case: Case) -> tuple[str, ...]:
    """Return the conditions that select the columns of the contacts of a case."""
    there = {
        FRICTION: case.has_friction,
        DENTS: case.has_initial_dents,
        LOSS: case.has_loss,
        FORCES_OF_ALL: case.output.contact_forces,
    }
    return tuple(name for name, recorded in there.items() if recorded)


def _series(name: str, every: int, file: str, title: str, columns: dict[str, str], resumed: bool) -> list[str]:
    """Return the command of a time series: one row every so many steps, the step first."""
    return command(
        f"fix             {name} all ave/time {every} 1 {every}",
        *columns.values(),
        f'{"append" if resumed else "file"} {DUMPS}/{file} format " %.17g" title1 "# {title}"',
        f'title2 "# {joined(["step", *columns])}"',
    )


def _first(resumed: bool) -> str:
    """Return the arguments of dump_modify: a snapshot at the first step, or appended to earlier ones."""
    return "append yes first no" if resumed else "first yes"


def _names(columns: dict[str, str]) -> list[str]:
    return [f"colname {source} {name}" for name, source in columns.items() if name != source]


def outward_force(assembly: Assembly, wall: Wall, prefix: str = "") -> str:
    """Return the formula of the force of the spheres on a wall, positive outwards; ``prefix``: of its fixes."""
    sources = ["held"] if wall.held_layer else [prefix + name for name, _, _ in wall_fixes(assembly, wall)]
    sign = "-" if wall.outward < 0 else "+"
    return "".join(f"{sign}f_{source}[{wall.axis + 1}]" for source in sources).removeprefix("+")


def _sphere_probe(sphere: int) -> dict[str, str]:
    axes = list(enumerate("xyz", start=1))
    return (
        {f"u{letter}": f"C_probed[{sphere}][{n}]" for n, letter in axes}
        | {f"v{letter}": f"v{letter}[{sphere}]" for _, letter in axes}
        | {f"f{letter}": f"f{letter}[{sphere}]" for _, letter in axes}
    )


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
