"""Motion in the LAMMPS input script: integration, initial velocities and spins, driven loads, and
the energy ledger.
"""

from __future__ import annotations

import math

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import energy_at_start
from granwave.lammps_inputs.contact.static_load import absorbing_ids, impedance_of, rise_of
from granwave.lammps_inputs.deck import columns as table
from granwave.lammps_inputs.deck.columns import recorded, sources
from granwave.lammps_inputs.deck.commands import id_ranges, time_series
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import INCIDENT_BAR
from granwave.lammps_inputs.packing.motion import own_velocities, start_velocity, struck_of
from granwave.lammps_inputs.packing.walls import moving_fix, plane_fixes, walls
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.run_directory import ENERGY_FILE
from granwave.lammps_inputs.script_words import joined, num

GRAVITY = 9.81  # m/s^2, of beads on their holder
_TICK = "# A tick: the step counter counts these, and fix step, below, says how many of them a step takes."
_HALF_INERTIA = 0.2  # half the moment of inertia of a sphere over m R^2
_OF_CYLINDER = 1.25  # moment of inertia of a cylinder over that of a sphere of this mass and radius


def motion(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of time integration and load; the variable ``input`` is the energy input
    so far.
    """
    case = assembly.case
    struck = struck_of(assembly)
    turning = (
        "and rotations"
        if case.has_rotation
        else "(the contacts are frictionless, so nothing rotates)"
    )
    lines = [
        f"# Motion: velocity Verlet {turning}, and what drives it.",
        *([_TICK] if schedule.adaptive else []),
        f"timestep        {num(schedule.timestep)}",
        f"group           struck id {struck[0] if struck else assembly.ids[0]}",
        f"group           hit id {joined(struck)}" if struck else "group           hit empty",
        *integration(assembly),
        *_velocities(assembly, resumed=resumed),
    ]
    lines += _load(assembly)
    return [*lines, *_absorbing(assembly), *_holder(assembly)]


def adaptive_timestep(case: Case, schedule: Schedule) -> list[str]:
    """Timestep that follows the error of the energy balance; behind all fixes that act at the end
    of a step.
    """
    if not schedule.adaptive:
        return []
    kinetic = "v_motion" if case.moves_otherwise else "c_kinetic"
    until = f"until {num(case.load.lasts)} " if 0 < case.load.lasts < math.inf else ""
    given = "v_load_work" if case.load.may_stop else "v_input"
    tolerance = schedule.energy_tolerance
    longest = schedule.longest_step
    first = schedule.first_step
    return [
        "# The timestep: up to so many ticks as the energy balance allows.",
        f"variable        balance equal {kinetic}+v_elastic+v_dissipated-v_input",
        f"fix             step all gran/timestep {longest} {num(tolerance)} {given} first {first} "
        f"{until}balance v_balance {schedule.ledger_every}",
    ]


def integration(assembly: Assembly) -> list[str]:
    """Return the commands of time integration; nodes of bars and grains held upright are not
    rotated.
    """
    case = assembly.case
    lines = []
    still = _prescribed(assembly)
    turning = case.has_rotation
    upright = [
        name
        for name, hold in case.holds.items()
        if turning and hold.rotation and hold.axes != "xyz"
    ]
    apart = [bar.name for bar in assembly.bars] if turning else []
    if upright:
        lines.append(f"group           upright union {joined(upright)}")
        lines += [f"group           upright subtract upright {joined(still)}"] if still else []
        apart.append("upright")
    group = "mobile" if still or apart else "all"
    style = "nve/sphere" if turning else "gran/nve"
    lines += (
        [f"group           mobile subtract all {joined([*still, *apart])}"]
        if still or apart
        else []
    )
    lines.append(f"fix             motion {group} {style}")
    return [*lines, *(f"fix             motion_{name} {name} nve" for name in apart)]


def _prescribed(assembly: Assembly) -> list[str]:
    """Return the groups of spheres whose motion is prescribed: those held in place, and those that
    are moved.
    """
    case = assembly.case
    held = ["held"] if any(wall.held_layer for wall in walls(assembly)) else []
    moved = ["hit"] if case.load.prescribes_motion else []
    fixed = [
        name
        for name, one in case.holds.items()
        if one.axes == "xyz" and (one.rotation or not case.has_rotation)
    ]
    return [*held, *moved, *fixed]


def _absorbing(assembly: Assembly) -> list[str]:
    """Return the commands of spheres that absorb waves."""
    lines = ["# Spheres that absorb waves."] if assembly.case.absorb else []
    for number, entry in enumerate(assembly.case.absorb, start=1):
        lines.append(
            f"group           absorb{number} id {id_ranges(absorbing_ids(assembly, entry))}"
        )
        rise = rise_of(assembly, entry)
        words = [entry.towards[1], *map(num, rise)] if rise is not None else []
        if entry.rate is None:
            words = ["impedance", num(impedance_of(assembly, entry)), "z"]
        else:
            words = ["rate", num(entry.rate), *words]
        lines.append(f"fix             absorb{number} absorb{number} gran/absorb {joined(words)}")
    return lines


def _holder(assembly: Assembly) -> list[str]:
    """Return the commands for the holder of a chain; after all that apply forces, for friction
    opposes their sum.
    """
    friction = assembly.case.boundary.holder_friction
    if not friction:
        return []
    without = [*_prescribed(assembly), *(bar.name for bar in assembly.bars)]
    group = "loose" if without else "all"
    return [
        "# Friction of the holder, which bears the weight of the beads.",
        *([f"group           loose subtract all {joined(without)}"] if without else []),
        f"fix             holder {group} gran/holder z {num(friction)} {num(GRAVITY)}",
    ]


def _velocities(assembly: Assembly, *, resumed: bool) -> list[str]:
    """Return the commands for initial velocities and spins, and their kinetic energy."""
    case = assembly.case
    lines = list[str]()
    terms = list[str]()
    moving = []
    velocity = start_velocity(assembly)
    if velocity is not None and (struck := struck_of(assembly)):
        moving.append(("hit", struck, velocity, case.load.spin))
    if own := own_velocities(assembly):  # in the data file
        terms.append(
            num(
                sum(
                    assembly.mass_of(one) * math.hypot(*velocity) ** 2 / 2
                    for one, velocity in own.items()
                )
            )
        )
    if case.load.start_energy:
        terms.append(case.load.start_energy)
    if case.precompression is not None and not resumed:
        lines += case.load.release_commands()
    for number, striker in enumerate(case.striker, start=1):
        if striker.moves:
            one = assembly.lattice.n_spheres + number
            lines.append(f"group           striker{number} id {one}")
            moving.append((f"striker{number}", (one,), striker.velocity, striker.spin))
    for group, spheres, velocity, spin in moving:
        if not resumed:
            lines.append(f"velocity        {group} set {_components(velocity)} units box")
        if any(velocity):
            terms.append(f"0.5*mass({group})*({_square(velocity)})")
        if any(spin):
            if not resumed:
                lines.append(f"set             group {group} omega {_components(spin)}")
            inertia = 0.0
            for one in spheres:
                part = _OF_CYLINDER if assembly.shape_of(one) else 1.0
                inertia += assembly.mass_of(one) * (assembly.diameter_of(one) / 2) ** 2 * part
            terms.append(f"{num(_HALF_INERTIA * inertia)}*({_square(spin)})")
    terms += [MOVING_BED] if case.packing.restart else []
    given = f"$({'+'.join(terms)}:%.17g)" if terms else "0.0"
    return [*lines, f"variable        given equal {given}"]


def _components(vector: tuple[float, float, float]) -> str:
    return joined(num(component) if component else "0.0" for component in vector)


def _square(vector: tuple[float, float, float]) -> str:
    return "+".join(f"{num(component)}^2" for component in vector if component)


def _load(assembly: Assembly) -> list[str]:
    """Return the commands of the load on the struck spheres or the end of the incident bar, and of
    the energy input so far.
    """
    load = assembly.case.load
    driven = [bar.far for bar in assembly.bars if bar.name == INCIDENT_BAR]
    lines = [
        *(f"group           driven id {far}" for far in driven),
        *load.commands("driven" if driven else "hit"),
        f"variable        input equal {load.input_formula}",
    ]
    if load.may_stop:
        along = _along(assembly.case, "hit")
        lines += [
            "# The same without the kinetic energy of the moved spheres, which comes back when they stop.",
            f"variable        load_work equal v_input-0.5*mass(hit)*{along}^2",
        ]
    return lines


def _along(case: Case, group: str) -> str:
    """Return the formula of the velocity of a group along the load."""
    terms = [f"{'' if part == 1 else f'{num(part)}*'}vcm({group},{axis})"
             for axis, part in zip("xyz", case.load.way, strict=True) if part]  # fmt: skip
    return terms[0] if terms[0].startswith("vcm") else f"({_sum(terms)})"


POTENTIAL = "c_potential"  # potential energy of dead loads, zero at the positions of the data file
MOVING_BED = "v_moving_bed"  # kinetic energy in a restart file, but for spheres that are struck
STATIC = "v_static"  # elastic and potential energy at the start of the run
#: Parts of the energies: condition, name, number in the compute, and in the fix of a wall; a variable within another
#: has 15 digits, which is enough for those of friction.
_PARTS = (
    (table.FRICTION, "elastic_tangential", 6, 8),
    (table.FRICTION, "friction", 7, 9),
    (table.RESISTANCE, "elastic_rolling", 9, 17),
    (table.RESISTANCE, "rolling", 10, 18),
    (table.RESISTANCE, "elastic_twisting", 11, 19),
    (table.RESISTANCE, "twisting", 12, 20),
    (table.COHESION, "adhesion", 13, 21),
    (table.LOSS, "viscous", 8, 16),
)


def ledger(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of the energy ledger, which also counts yielded contacts."""
    case = assembly.case
    planes = plane_fixes(assembly)
    bars = [bar.name for bar in assembly.bars]
    conditions = [*recorded(case), *([table.ADAPTIVE] if schedule.adaptive else [])]
    columns = sources(table.LEDGER) | {name: f"v_energy_{name}" for name in bars}
    columns |= sources(table.LEDGER, *conditions, of=moving_fix(assembly) or "")
    lines = []
    of_bars = list[str]()
    moving = ["c_kinetic"]

    def on_walls(*numbers: int) -> list[str]:
        return [f"f_{name}[{number}]" for number in numbers for name in planes]

    def at_bars(*numbers: int) -> list[str]:  # their contacts belong to the pair style
        return [f"c_on_{name}[{number}]" for number in numbers for name in bars]

    if case.has_rotation:
        lines.append("compute         rotational all erotate/sphere")
        if (
            assembly.has_cylinders
        ):  # of spheres of their masses and radii, and what they have beyond
            columns["rotational"] = "v_rotational"
            lines.append("variable        rotational equal c_rotational+f_cylinders")
        moving.append(columns["rotational"])
    if case.load.plate is not None:
        moving.append(columns["plate"])
    if case.moves_otherwise:
        columns["kinetic"] = "v_motion"
        lines.append(f"variable        motion equal {_sum(moving)}")
    stored = [4]
    lost = [5]
    elastic = ["c_contact", *on_walls(4)]
    dissipated = ["c_contact[1]", *on_walls(5)]
    for when, name, number, of_wall in _PARTS:
        if when in conditions:
            terms = [f"c_contact[{number}]", *on_walls(of_wall)]
            is_stored = name.startswith("elastic")
            lines.append(f"variable        {name} equal {_sum(terms)}")
            (stored if is_stored else lost).append(of_wall)
            (elastic if is_stored else dissipated).extend(
                [f"v_{name}"] if when == table.FRICTION else terms
            )
    if case.absorb:
        lines.append(
            f"variable        absorbed equal {_sum([f'f_absorb{n}' for n, _ in enumerate(case.absorb, 1)])}"
        )
    dissipated += [
        columns[name] for name in ("holder", "absorbed", "support_lost") if name in columns
    ]
    elastic += [columns["support"]] if "support" in columns else []
    if schedule.adaptive:
        timestep = [column.name for column in table.LEDGER if column.when == table.ADAPTIVE]
        lines += [
            f"variable        {name} equal f_step[{n}]" for n, name in enumerate(timestep, start=1)
        ]
    elastic += [f"c_elastic_{name}" for name in bars]
    elastic += [POTENTIAL, f"-{STATIC}"] if case.precompression else []
    if at_start := energy_at_start(assembly):
        elastic.append(num(-at_start))
    for bar in assembly.bars:  # kinetic and elastic energy, and contact with the chain
        of_bars += [
            f"compute         on_{bar.name} all gran/hysteretic/contact {bar.touches} {bar.face}",
            f"compute         bonds_{bar.name} {bar.name} bond/local engpot",
            f"compute         elastic_{bar.name} {bar.name} reduce sum c_bonds_{bar.name} inputs local",
            f"compute         kinetic_{bar.name} {bar.name} ke",
            f"variable        energy_{bar.name} equal c_kinetic_{bar.name}+c_elastic_{bar.name}",
        ]
    return [
        "# Energies, J. Their sum must stay equal to the input.",
        "compute         kinetic all ke",
        "compute         contact all gran/hysteretic/energy",
        f"variable        time equal step*{num(schedule.timestep) if schedule.adaptive else 'dt'}",
        *of_bars,
        *lines,
        f"variable        elastic_wall equal {_sum(on_walls(*stored) + at_bars(4))}",
        f"variable        dissipated_wall equal {_sum(on_walls(*lost) + at_bars(5, *([8] if case.has_loss else [])))}",
        f"variable        elastic equal {_sum(elastic)}",
        f"variable        dissipated equal {_sum(dissipated)}",
        f"variable        struck_velocity equal {_along(case, 'struck')}",
        *time_series(
            "ledger",
            schedule.ledger_every,
            ENERGY_FILE,
            "energy ledger, SI units",
            columns,
            resumed,
        ),
    ]


def _sum(terms: list[str]) -> str:
    return "+".join(terms).replace("+-", "-") or "0.0"


def thermo(case: Case, schedule: Schedule) -> list[str]:
    """Return the commands of thermodynamic output."""
    every = (
        schedule.block_steps
        or max(1, schedule.n_steps // schedule.ledger_every // 20) * schedule.ledger_every
    )
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
