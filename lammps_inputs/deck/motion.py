"""Motion in the LAMMPS input script: integration, initial velocities and spins, driven loads."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.static_load import absorbing_ids, impedance_of, rise_of
from granwave.lammps_inputs.deck.commands import id_ranges
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.bodies import INCIDENT_BAR
from granwave.lammps_inputs.packing.motion import (
    own_spins,
    own_velocities,
    start_velocity,
    struck_of,
)
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.script_words import joined, num

MOVING_BED = "v_moving_bed"  # kinetic energy in a restart file, without the impacted spheres
POTENTIAL = "c_potential"  # potential energy of dead loads, zero at the positions of the data file
FALL = "c_fall"  # potential energy of strikers: minus the work of gravity on them, which is input
STATIC = "v_static"  # elastic and potential energy at the start of the run
CLUMPS = "clumps"  # group of the grains of all clumps
GRAVITY = 9.81  # gravity on beads in their guide, m/s^2
_TICK = (
    "# A tick is the unit of the step counter; fix step, below, sets the number of ticks per step."
)
_HALF_INERTIA = 0.2  # half the moment of inertia of a sphere / m R^2
_OF_CYLINDER = 1.25  # moment of inertia of a cylinder over that of a sphere of this mass and radius

Vector = tuple[float, float, float]


def motion(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of time integration and load; the variable ``input`` is the energy input
    so far.
    """
    case = assembly.case
    struck = struck_of(assembly)
    turning = (
        "and rotations"
        if case.has_rotation
        else "(without rotation: the contacts are frictionless)"
    )
    lines = [
        f"# Motion: velocity Verlet {turning}, and the load.",
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
    """Return the command of the adaptive timestep, which follows all fixes that act at the end of a
    step.
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
        "# Timestep: as many ticks as the energy balance allows.",
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
    clumps = [CLUMPS] if assembly.clumps else []
    others = [*still, *apart, *clumps]
    group = "mobile" if others else "all"
    style = "gran/nve/sphere" if turning else "gran/nve"
    lines += [f"group           mobile subtract all {joined(others)}"] if others else []
    lines.append(f"fix             motion {group} {style}")
    lines += [f"fix             motion_{name} {name} nve" for name in apart]
    return [
        *lines,
        *(f"fix             motion_{name} {name} rigid/small molecule" for name in clumps),
    ]


def _prescribed(assembly: Assembly) -> list[str]:
    """Return the groups of spheres with a prescribed motion: spheres held in place, and driven
    spheres.
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
    """Return the commands for the guide of a chain, after all commands that apply forces, because
    friction opposes their sum.
    """
    friction = assembly.case.boundary.holder_friction
    if not friction:
        return []
    without = [*_prescribed(assembly), *(bar.name for bar in assembly.bars)]
    group = "loose" if without else "all"
    return [
        "# Friction of the guide, which supports the weight of the beads.",
        *([f"group           loose subtract all {joined(without)}"] if without else []),
        f"fix             holder {group} gran/holder z {num(friction)} {num(GRAVITY)}",
    ]


class MovingGroup(NamedTuple):
    """Spheres that start with a velocity, m/s, and a spin, rad/s; group of LAMMPS and ids."""

    group: str
    spheres: Sequence[int]
    velocity: Vector
    spin: Vector


def _velocities(assembly: Assembly, *, resumed: bool) -> list[str]:
    """Return the commands for initial velocities and spins, and their kinetic energy."""
    case = assembly.case
    first_striker = assembly.lattice.n_spheres + 1
    lines = list[str]()
    if case.precompression is not None and not resumed:
        lines += case.load.release_commands()
    moving = []
    velocity = start_velocity(assembly)
    struck = struck_of(assembly)
    if velocity is not None and struck:
        moving.append(MovingGroup("hit", struck, velocity, case.load.spin))
    for number, striker in enumerate(case.striker):
        if striker.moves:
            group = f"striker{number + 1}"
            sphere = first_striker + number
            lines.append(f"group           {group} id {sphere}")
            moving.append(MovingGroup(group, (sphere,), striker.velocity, striker.spin))
    if not resumed:
        for part in moving:
            lines += _set_motion(part)
    terms = _start_energies(assembly, moving)
    energy = f"$({'+'.join(terms)}:%.17g)" if terms else "0.0"
    return [*lines, f"variable        given equal {energy}"]


def _set_motion(part: MovingGroup) -> list[str]:
    """Return the commands that set velocity and spin of spheres."""
    lines = [f"velocity        {part.group} set {_components(part.velocity)} units box"]
    if any(part.spin):
        lines.append(f"set             group {part.group} omega {_components(part.spin)}")
    return lines


def _start_energies(assembly: Assembly, moving: Sequence[MovingGroup]) -> list[str]:
    """Return the terms of the energy at the start, J: of velocities in the data file that no load
    replaces, of the load, and of the moving spheres.
    """
    terms = _energies_of_file(assembly, moving)
    if assembly.case.load.start_energy:
        terms.append(assembly.case.load.start_energy)
    for part in moving:
        if any(part.velocity):
            terms.append(f"0.5*mass({part.group})*({_square(part.velocity)})")
        if any(part.spin):
            inertia = sum(_inertia(assembly, sphere) for sphere in part.spheres)
            terms.append(f"{num(_HALF_INERTIA * inertia)}*({_square(part.spin)})")
    if assembly.case.packing.restart:
        terms.append(MOVING_BED)
    return terms


def _energies_of_file(assembly: Assembly, moving: Sequence[MovingGroup]) -> list[str]:
    """Return the terms of the energy of velocities and spins of a file that no load replaces, J."""
    terms = list[str]()
    loaded = set(chain.from_iterable(part.spheres for part in moving))
    velocities = own_velocities(assembly).items()
    own = {sphere: velocity for sphere, velocity in velocities if sphere not in loaded}
    if own:
        energies = (
            assembly.mass_of(sphere) * math.hypot(*velocity) ** 2 / 2
            for sphere, velocity in own.items()
        )
        terms.append(num(sum(energies)))
    turned = set(chain.from_iterable(part.spheres for part in moving if any(part.spin)))
    spins = own_spins(assembly).items()
    turning = {sphere: spin for sphere, spin in spins if sphere not in turned}
    if turning:
        energies = (
            _HALF_INERTIA * _inertia(assembly, sphere) * math.hypot(*spin) ** 2
            for sphere, spin in turning.items()
        )
        terms.append(num(sum(energies)))
    return terms


def _inertia(assembly: Assembly, sphere: int) -> float:
    """Return m R^2 of a grain, kg m^2; of a cylinder, times its factor relative to a sphere."""
    factor = _OF_CYLINDER if assembly.shape_of(sphere) else 1.0
    return assembly.mass_of(sphere) * (assembly.diameter_of(sphere) / 2) ** 2 * factor


def _components(vector: Vector) -> str:
    return joined(num(component) if component else "0.0" for component in vector)


def _square(vector: Vector) -> str:
    return "+".join(f"{num(component)}^2" for component in vector if component)


def _load(assembly: Assembly) -> list[str]:
    """Return the commands of the load on the impacted spheres or the end of the incident bar, and
    of the energy input so far.
    """
    load = assembly.case.load
    driven = [bar.far for bar in assembly.bars if bar.name == INCIDENT_BAR]
    inputs = [load.input_formula]
    if assembly.case.strikers_fall:
        inputs.append(f"-{FALL}")
    lines = [
        *(f"group           driven id {far}" for far in driven),
        *load.commands("driven" if driven else "hit"),
        f"variable        input equal {sum_of(inputs)}",
    ]
    if load.may_stop:
        velocity = velocity_along(assembly.case, "hit")
        lines += [
            "# Energy input without the kinetic energy of the moved spheres, which is returned "
            "when they stop.",
            f"variable        load_work equal v_input-0.5*mass(hit)*{velocity}^2",
        ]
    return lines


def velocity_along(case: Case, group: str) -> str:
    """Return the formula of the velocity of a group along the load."""
    terms = []
    for axis, part in zip("xyz", case.load.way, strict=True):
        if part:
            factor = "" if part == 1 else f"{num(part)}*"
            terms.append(f"{factor}vcm({group},{axis})")
    if terms[0].startswith("vcm"):
        return terms[0]
    return f"({sum_of(terms)})"


def sum_of(terms: Sequence[str]) -> str:
    """Return the formula of a sum; 0.0 for no terms."""
    return "+".join(terms).replace("+-", "-") or "0.0"
