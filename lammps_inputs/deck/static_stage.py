"""The static stage before a precompressed run, in the LAMMPS input script.

Dead loads come on, and the spheres are led to balance by damped dynamics (FIRE, Bitzek et al. 2006), without
friction. On its way FIRE overshoots, which must not leave dents: the first half has Hertz's law everywhere, and what
contacts went through in it is forgotten. The second half begins at that balance with the laws and the dents of the
case; contacts whose static force is beyond yield get their dents there. Then the clock, and all accounts, are set to
zero.

A packing under uniform pressure may turn as a whole, and dead loads, which keep their directions, would make it turn
further and further: while balance is looked for, the forces that accelerate it as a whole are taken off (`relief`).

A run that is continued from a checkpoint does not repeat the stage. Two files stay: STATIC_STAGE_FILE, for people and
programs, and STATIC_FILE, lines of script with what the ledger counts from.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import dead_loads, directions, force_of_contact, static_stiffness
from granwave.lammps_inputs.deck.commands import joined, num
from granwave.lammps_inputs.deck.contacts import pair_coefficients, plane_names, wall_commands
from granwave.lammps_inputs.deck.inertia_relief import relief_commands, relief_state
from granwave.lammps_inputs.deck.output import POTENTIAL, displacements
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.packing.walls import moving_fix, support_timestep, wall_fixes, walls
from granwave.lammps_inputs.run_directory import DEAD_LOAD_FILE, DUMPS, STATIC_FILE, STATIC_STAGE_FILE

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case

_STAGE_MARKER, _STAGE_END = "# --- static stage ---", "# --- end of the static stage ---"

LARGEST_MOVE = 0.1  # diameters, of any sphere, beyond what contacts take up: one that moves further rearranges

_SPHERES = "static_spheres"  # the group of those that move
_PREFIX = "static_"  # of the fixes of planes during the stage
_TOLERANCE = 1e-9  # of the force of a contact: net force on a sphere at which the search ends
# With disorder or dents it takes tens of thousands of iterations, and few contacts may bear many times the mean force:
_TOLERANCE_OF_DISORDER = 3e-7  # of the largest force of a contact, found in the first half
_FIRST_HALF = 1e-5  # of the mean force, in the first half
_ROUNDING = 8.0  # net force by rounding: in units of stiffness times the last digit of a coordinate
_STEP = 0.03  # of sqrt(mass/stiffness), at the start; FIRE makes it up to ten times longer
_LONGEST_MOVE = 0.5  # of the overlap of a contact, of a sphere in one iteration
_MOST_ITERATIONS = 200_000

# residual: largest net force on a sphere over the largest force of a contact, or the load where only walls are touched
RECORD = {
    "residual": "$(c_static_net/(c_static_largest+(c_static_largest==0)*v_static_load):%.6g)",
    "largest_force": "$(c_static_largest:%.9g)",
    "contacts": "$(c_static_borne/2:%.0f)",
    "yielded": "${static_yielded}",
    "stored": "$(v_static_stored:%.17g)",
    "displacement": "$(c_static_moved:%.9g)",
    "iterations": "${static_iterations}",
}


def dead_load_commands(assembly: Assembly) -> list[str]:
    """The dead loads, which stay on; the compute ``potential`` is their energy, from the data file's positions on."""
    case = assembly.case
    axes = directions(assembly)
    words = joined(f"v_dead_{axis}" if axis in axes else "0.0" for axis in "xyz")
    work = "+".join(f"v_dead_{axis}*c_displacement[{'xyz'.index(axis) + 1}]" for axis in axes)
    return [
        "# Dead loads: constant forces on spheres, N. Displacements count from the data file, before any load.",
        *displacements(case),
        *(f"variable        dead_{axis} atomfile {DEAD_LOAD_FILE.format(axis)}" for axis in axes),
        f"variable        dead atom {'||'.join(f'(v_dead_{axis}!=0)' for axis in axes)}",
        "group           dead variable dead",
        f"fix             dead dead addforce {words} energy v_dead_{axes[-1]}",  # LAMMPS asks for an energy; unused
        f"variable        work atom -({work})",
        f"compute         {POTENTIAL.removeprefix('c_')} dead reduce sum v_work",
    ]


def largest_move(assembly: Assembly) -> float:
    """How far a sphere of a packing that keeps its shape may move, m.

    Contacts on the way along the load give way to it, and close the gaps that smaller spheres and dents leave; all that
    adds up.
    """
    case = assembly.case
    stage, lattice = case.precompression, assembly.lattice
    assert stage is not None
    on_the_way = max(lattice.shape) if stage.kind == "uniform" else lattice.shape[2]
    overlap = 1.5 * force_of_contact(assembly) / static_stiffness(assembly)
    gap = case.packing.diameter_scatter + largest_dent(case, sphere_contact(case))
    return LARGEST_MOVE * case.packing.diameter + on_the_way * (overlap + gap)


def first_half(assembly: Assembly) -> list[str]:
    """To balance under Hertz's law."""
    case = assembly.case
    mass = float(assembly.sphere_masses().min())
    longest_move = _LONGEST_MOVE * 1.5 * force_of_contact(assembly) / static_stiffness(assembly)
    return [
        _STAGE_MARKER,
        "# To balance under the dead loads, first with elastic contacts, whose overshoots leave no dents.",
        *pair_coefficients(assembly, elastic=True),
        *wall_commands(assembly, elastic=True, prefix=_PREFIX),
        f"group           {_SPHERES} id 1:{assembly.lattice.n_spheres}",
        *_relief(case),
        *_waiting(assembly),
        f"compute         static_moved {_SPHERES} reduce max c_displacement[4]",
        "variable        static_moved equal c_static_moved",
        f"variable        static_most equal {num(largest_move(assembly))}",
        "fix             static_halt all halt 100 v_static_moved > ${static_most} error continue",
        f"timestep        {num(_STEP * math.sqrt(mass / static_stiffness(assembly)))}",
        "compute         static_sphere all gran/hysteretic/atom",
        "compute         static_largest all reduce max c_static_sphere[1]",
        "thermo          1000",
        "thermo_style    custom step c_static_largest",
        "min_style       fire",
        f"min_modify      norm inf dmax {num(longest_move)}",
        _minimize(assembly, first=True),
        "variable        static_force equal $(c_static_largest:%.17g)",
        *(f"unfix           {_PREFIX}{name}" for name in plane_names(assembly)),
        "gran/dents      begin",
        *pair_coefficients(assembly),
        _STAGE_END,
    ]


def second_half(assembly: Assembly) -> list[str]:
    """To balance with the laws and dents of the case, and the record of it."""
    case = assembly.case
    columns = ["c_static", "c_static[2]", "c_static_largest", "c_static_borne", "c_static_net", "c_static_moved"]
    values = "\n".join([f"# {joined(RECORD)}", joined(RECORD.values())])
    return [
        _STAGE_MARKER,
        "# Once more, with the law of the case; then the state is recorded, and the run begins at time 0.",
        *_relief(case, again=True),
        "compute         static all gran/hysteretic/energy",
        "compute         static_borne all reduce sum c_static_sphere[6]",
        "variable        static_net atom sqrt(fx^2+fy^2+fz^2)",
        f"compute         static_net {_SPHERES} reduce max v_static_net",
        f"thermo_style    custom step {joined(columns)} {POTENTIAL}",
        "thermo_modify   norm no",
        _minimize(assembly),
        "variable        static_iterations equal $(step)",
        "variable        static_yielded equal $(c_static[2]:%.0f)",
        "gran/dents      begin",
        "unfix           static_halt",
        "velocity        all set 0.0 0.0 0.0 units box",
        "reset_timestep  0 time 0.0",
        *_step_of_support(assembly),
        "run             0 post no",
        f"variable        static_stored equal {'+'.join(_stored(assembly))}",
        f"variable        static_load equal {num(force_of_contact(assembly))}",
        f'print           """{values}""" file {DUMPS}/{STATIC_STAGE_FILE} screen no',
        f"variable        static_all equal v_static_stored+{POTENTIAL}",
        *(["unfix           static_strikers"] if case.striker else []),
        *(["unfix           static_relief"] if _relief(case) else []),
        f'print           "variable static equal $(v_static_all:%.17g)" file {DUMPS}/{STATIC_FILE} screen no',
        *(f"uncompute       static{name}" for name in ("_moved", "_net", "_borne", "_largest", "_sphere", "")),
        _STAGE_END,
        "",
    ]


def reference_state() -> list[str]:
    """The energies that the ledger counts from, which the static stage has left in a file."""
    return ["# What the ledger counts from.", f"include         {DUMPS}/{STATIC_FILE}"]


def load_tables(assembly: Assembly) -> dict[str, str]:
    """The files of dead loads: name and text, one for each direction."""
    ids, forces = dead_loads(assembly)
    tables = {}
    for axis in directions(assembly):
        along = forces[:, "xyz".index(axis)].tolist()
        pairs = [(sphere, force) for sphere, force in zip(ids.tolist(), along, strict=True) if force]
        rows = "".join(f"{sphere} {force:.17g}\n" for sphere, force in pairs)
        tables[DEAD_LOAD_FILE.format(axis)] = f"# dead loads: id, force (N); how many\n{len(pairs)}\n{rows}"
    return tables


def _relief(case: Case, *, again: bool = False) -> list[str]:
    """Return commands that keep a packing from turning, and from moving as a whole, where nothing holds it."""
    stage, bottom = case.precompression, case.boundary.bottom
    if stage is None or stage.kind != "uniform" or bottom == "fixed":
        return []
    commands = relief_state if again else relief_commands
    return commands("static_relief", _SPHERES, on_plane=bottom == "wall")


def _step_of_support(assembly: Assembly) -> list[str]:
    """FIRE leaves a timestep that may be too long for what the bottom moves on, which refuses to run with it."""
    step = support_timestep(assembly, static_stiffness(assembly))
    return [f"timestep        {num(step)}"] if math.isfinite(step) else []


def _waiting(assembly: Assembly) -> list[str]:
    """Strikers stay where they are until the run begins."""
    first, last = assembly.lattice.n_spheres + 1, assembly.last_sphere
    name = "static_strikers"
    return [f"group           {name} id {first}:{last}", f"fix             {name} {name} setforce 0 0 0"] * (
        last >= first
    )


def _stored(assembly: Assembly) -> list[str]:
    """Terms of the energy stored in contacts, walls and what a wall moves on."""
    planes = [name for wall in walls(assembly) if not wall.held_layer for name, _, _ in wall_fixes(assembly, wall)]
    support = moving_fix(assembly)
    return ["c_static", *(f"f_{name}[4]" for name in planes), *([f"f_{support}[12]"] if support else [])]


def _rounding(assembly: Assembly) -> float:
    """Return the net force that rounding of the coordinates makes, N."""
    span = float(np.abs(assembly.bounds()).max())
    return float(_ROUNDING * static_stiffness(assembly) * np.finfo(float).eps * span)


def _least_net_force(assembly: Assembly, *, first: bool = False) -> str:
    """The net force on a sphere at which the search ends, N: a small part of the forces of contacts, or rounding."""
    case = assembly.case
    rounding, mean = _rounding(assembly), force_of_contact(assembly)
    if not has_gaps(case) or first:
        part = _FIRST_HALF if has_gaps(case) else _TOLERANCE
        return num(float(f"{part * mean + rounding:.3g}"))
    largest = f"(v_static_force+(v_static_force==0)*{num(mean)})"
    return f"$({num(_TOLERANCE_OF_DISORDER)}*{largest}+{num(float(f'{rounding:.3g}'))})"


def _minimize(assembly: Assembly, *, first: bool = False) -> str:
    return f"minimize        0.0 {_least_net_force(assembly, first=first)} {_MOST_ITERATIONS} {2 * _MOST_ITERATIONS}"
