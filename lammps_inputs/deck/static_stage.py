"""Static stage before a precompressed run, in the LAMMPS input script.

Dead loads are applied, and the spheres are brought to equilibrium by damped dynamics (FIRE, Bitzek
et al. 2006) without friction. The first half uses Hertz's law for all contacts, and the contact
history is cleared afterwards, since its overlaps are not those of the case's law. The second half
starts from that equilibrium with the laws and initial dents of the case; contacts whose static
force exceeds yield get their dents there. FIRE overshoots, which leaves no dents: every iteration
begins with the histories at the start (pair_gran_hysteretic_forces.cpp), so that dents are those of
a load that grows steadily. Then time and energies are reset to zero.

Grains that lean on friction would slide without it. Where `precompression.damped` is true, both
halves are one damped run (`damped_run.py`) from the positions of the case on; the tangential
springs that it leaves stay.

A packing under uniform pressure may rotate as a whole, and dead loads, which keep their directions,
would amplify the rotation: inertia relief cancels the forces that accelerate it as a whole during
the stage (`inertia_relief.py`).

A run that is resumed from a checkpoint does not repeat the stage. Files remain: STATIC_STAGE_FILE,
a record; STATIC_FILE, script lines with the reference energy of the energy record; and the forces
of all contacts (`initial_forces`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import (
    dead_loads,
    directions,
    force_of_contact,
    static_stiffness,
    striker_loads,
)
from granwave.lammps_inputs.deck import columns as table
from granwave.lammps_inputs.deck.commands import (
    id_ranges,
    moved_wall,
    pair_coefficients,
    plane_names,
    wall_commands,
)
from granwave.lammps_inputs.deck.damped_run import (
    LARGEST_OF_PAIRS,
    LEAST_HELD,
    ROLLING_GRAINS,
    UNBALANCED,
    bears_its_weight,
    clump_sums,
    counts_walls,
    damped_run,
    largest_force,
    net_force,
)
from granwave.lammps_inputs.deck.inertia_relief import relief_commands, relief_state
from granwave.lammps_inputs.deck.motion import FALL, MOVING_BED, POTENTIAL
from granwave.lammps_inputs.deck.output import (
    count_commands,
    displacements,
    initial_forces,
    outward_force,
)
from granwave.lammps_inputs.deck.plugin_columns import (
    DisplacementColumn,
    EnergyColumn,
    SphereColumn,
    WallColumn,
)
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.packing.motion import (
    own_velocities,
    start_velocity,
    struck_of,
    written_in_parts,
)
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.packing.walls import (
    moving_fix,
    plane_fixes,
    pressed_walls,
    support_timestep,
)
from granwave.lammps_inputs.run_directory import (
    DEAD_LOAD_FILE,
    DUMPS,
    MOVED_WALLS_FILE,
    START_FILE,
    STATIC_FILE,
    STATIC_STAGE_FILE,
)
from granwave.lammps_inputs.script_words import joined, num
from granwave.lammps_inputs.statics.balance import balanced_displacements

_STAGE_MARKER = "# --- static stage ---"
_STAGE_END = "# --- end of the static stage ---"

# diameters; largest displacement beyond contact deformation: larger ones mean rearrangement
LARGEST_MOVE = 0.1

# largest contact force over that expected of the load, below which the grains have lost the load
LOST_LOAD = 1e-3

_SPHERES = "static_spheres"  # group of the moving spheres
_STRIKERS = "static_strikers"  # group, and fix that holds them
_PREFIX = "static_"  # prefix of the wall fixes of the stage
_TOLERANCE = 1e-9  # net force on a sphere at convergence over the mean contact force
# With disorder or dents it takes tens of thousands of iterations, and single contacts may carry
# many times the mean:
_TOLERANCE_OF_DISORDER = 3e-7  # same, over the largest contact force, as found in the first half
_FIRST_HALF = 1e-5  # same, over the mean contact force, in the first half
_ROUNDING = 8.0  # net force by rounding over stiffness times the rounding error of a coordinate
_STEP = 0.03  # initial timestep over sqrt(mass/stiffness); FIRE makes it up to ten times longer
# energies stored by springs, of pairs and of a wall
_TANGENTIAL = (EnergyColumn.ELASTIC_TANGENTIAL, WallColumn.ELASTIC_TANGENTIAL)
_ROLLING = (EnergyColumn.ELASTIC_ROLLING, WallColumn.ELASTIC_ROLLING)
_TWISTING = (EnergyColumn.ELASTIC_TWISTING, WallColumn.ELASTIC_TWISTING)
_LONGEST_MOVE = 0.5  # displacement of a sphere in one iteration over the overlap of a contact
MOST_ITERATIONS = 200_000
_ROUNDS = 8  # in which walls move in to a force; a secant doubles the digits in two of them
# least slope of its power 2/3 over that of the line through the start: bounds the next distance
_FLATTEST = 0.1

# column of the log: largest net force on a sphere
NET_FORCE = "c_static_net"
_START = "static_start"  # fix, of velocities before the stage
_STILL = "velocity        all set 0.0 0.0 0.0 units box"
_ENERGY = "c_static"  # of all contacts of pairs
_SPHERE = "c_static_sphere"
# column of the array of fix wall/gran/hysteretic
_FORCE_OF_WALL = 1 + table.names(table.WALL_CONTACTS).index("force")
_DISPLACEMENT = DisplacementColumn.MAGNITUDE.of("c_displacement")
_WATCH_MOVES = f"compute         static_moved {_SPHERES} reduce max {_DISPLACEMENT}"
# largest contact force
_FORCES = (
    "compute         static_sphere all gran/hysteretic/atom",
    f"compute         static_largest all reduce max {SphereColumn.FORCE.of(_SPHERE)}",
)

# residual: largest net force on a sphere over the largest contact force, or over the load if no
# force is known
RECORD = {
    "residual": "$(c_static_net/({largest}+({largest}==0)*v_static_load):%.6g)",
    "largest_force": "$({largest}:%.9g)",
    "contacts": "$(c_static_borne/2:%.0f)",
    "yielded": "${static_yielded}",
    "stored": "$(v_static_stored:%.17g)",
    "displacement": "$(c_static_moved:%.9g)",
    "iterations": "${static_iterations}",
}
# of grains that each carry their weight, after a damped run: sum of the net forces over the weight
# of all, largest net force over the weight of its grain, number of grains that still roll
RECORD_OF_WEIGHT = {
    "unbalanced": f"$(v_{UNBALANCED}:%.6g)",
    "worst": f"$(c_{LEAST_HELD}:%.6g)",
    "rolling": f"$(c_{ROLLING_GRAINS}:%.0f)",
}


def dead_load_commands(assembly: Assembly) -> list[str]:
    """Return the commands of dead loads; the compute ``potential`` is their energy, zero in the
    data file.
    """
    case = assembly.case
    axes = directions(assembly)
    if not axes:
        return [
            "# The walls are in their final positions; there are no other loads. Displacements "
            "are relative to the data file.",
            *displacements(case),
            "variable        work atom 0.0",
            f"compute         {POTENTIAL.removeprefix('c_')} all reduce sum v_work",
        ]
    words = joined(f"v_dead_{axis}" if axis in axes else "0.0" for axis in "xyz")
    work = "+".join(f"v_dead_{axis}*c_displacement[{'xyz'.index(axis) + 1}]" for axis in axes)
    return [
        "# Dead loads: constant forces on spheres, N. Displacements are relative to the data "
        "file, before any load.",
        *displacements(case),
        *(f"variable        dead_{axis} atomfile {DEAD_LOAD_FILE.format(axis)}" for axis in axes),
        f"variable        dead atom {'||'.join(f'(v_dead_{axis}!=0)' for axis in axes)}",
        "group           dead variable dead",
        # required by LAMMPS; unused
        f"fix             dead dead addforce {words} energy v_dead_{axes[-1]}",
        f"variable        work atom -({work})",
        f"compute         {POTENTIAL.removeprefix('c_')} dead reduce sum v_work",
        *_fall(assembly),
    ]


def _fall(assembly: Assembly) -> list[str]:
    """Return the commands of the potential energy of strikers that gravity acts on."""
    if not assembly.case.strikers_fall:
        return []
    ids, _ = striker_loads(assembly)
    return [
        f"group           falling id {id_ranges(ids)}",
        f"compute         {FALL.removeprefix('c_')} falling reduce sum v_work",
    ]


def may_lose_its_load(assembly: Assembly) -> bool:
    """Return True if the initial overlaps are the only load: grains that are free to separate lose
    it, and contacts with nearly zero force have nearly zero stiffness.

    Forces are then compared with those at the start.
    """
    stage = assembly.case.precompression
    return stage is not None and stage.is_overlaps_alone


def largest_move(assembly: Assembly) -> float:
    """Return the largest displacement of a sphere in a packing that does not rearrange, m; infinite
    if it may rearrange.

    Along the load the overlaps of all contacts add up, and so do the gaps that smaller spheres and
    dents leave.
    """
    case = assembly.case
    stage = case.precompression
    lattice = assembly.lattice
    assert stage is not None
    if case.may_rearrange:
        return math.inf
    on_the_way = max(lattice.shape) if stage.rule.on_all_faces else lattice.shape[2]
    if isinstance(lattice, Places) and not stage.moves:
        on_the_way = math.ceil(
            float(np.ptp(lattice.bounds(), axis=0).max() / lattice.grains.diameter.min())
        )
    overlap = 1.5 * force_of_contact(assembly) / static_stiffness(assembly)
    gap = max(stage.moves.values(), default=0.0) + case.packing.diameter_scatter
    gap += largest_dent(assembly, sphere_contact(case))
    return LARGEST_MOVE * case.packing.diameter + on_the_way * (overlap + gap)


def _keeps_velocities(assembly: Assembly) -> bool:
    """Return True if grains reach equilibrium at rest, and receive initial velocities
    afterwards.
    """
    return assembly.case.seeks_balance and bool(own_velocities(assembly))


def stored_velocities(assembly: Assembly) -> list[str]:
    """Return the commands that store the velocities of the grains, which then are at rest."""
    if not _keeps_velocities(assembly):
        return []
    return [
        "# The grains start at rest and come to equilibrium; their velocities are set afterwards.",
        f"fix             {_START} all store/state 0 vx vy vz",
        *(
            f"variable        {_START}_v{axis} atom f_{_START}[{column}]"
            for column, axis in enumerate("xyz", start=1)
        ),
        _STILL,
    ]


def _stored_again(assembly: Assembly) -> list[str]:
    """Return the commands that set the velocities that were stored."""
    if not _keeps_velocities(assembly):
        return []
    words = [f"v_{_START}_v{axis}" for axis in "xyz"]
    return [
        f"velocity        all set {joined(words)} units box",
        f"unfix           {_START}",
    ]


def first_half(assembly: Assembly) -> list[str]:
    """Return the commands that bring the packing to equilibrium under Hertz's law."""
    case = assembly.case
    if not case.seeks_balance or case.settles_damped:
        return _as_found(assembly)
    mass = float(assembly.sphere_masses().min())
    overlap = (
        1.5 * force_of_contact(assembly) / static_stiffness(assembly)
    )  # of a contact; walls move by it at first
    return [
        _STAGE_MARKER,
        "# Equilibrium under the dead loads, first with elastic contacts, whose history is then "
        "cleared.",
        *pair_coefficients(assembly, elastic=True),
        *(
            f"variable        {moved_wall(name)} equal {num(overlap)}"
            for name in pressed_walls(assembly)
        ),
        *wall_commands(assembly, elastic=True, prefix=_PREFIX),
        f"group           {_SPHERES} id 1:{assembly.lattice.n_spheres}",
        *_relief(case),
        *_waiting(assembly),
        _WATCH_MOVES,
        *_halt(assembly),
        f"timestep        {num(_STEP * math.sqrt(mass / static_stiffness(assembly)))}",
        *_FORCES,
        "thermo          1000",
        f"thermo_style    custom step {LARGEST_OF_PAIRS}",
        "min_style       fire",
        f"min_modify      norm inf dmax {num(_LONGEST_MOVE * overlap)}",
        *_near_balance(assembly),
        _minimize(assembly, first=True),
        *_pressing(assembly),
        "variable        static_force equal $(c_static_largest:%.17g)",
        *(f"unfix           {_PREFIX}{name}" for name in plane_names(assembly)),
        "gran/dents      clear",
        *pair_coefficients(assembly),
        _STAGE_END,
    ]


def _as_found(assembly: Assembly) -> list[str]:
    """Return the commands of the first half if contacts start unchanged."""
    return [
        _STAGE_MARKER,
        "# The grains start in the state of the file.",
        f"group           {_SPHERES} id 1:{assembly.lattice.n_spheres}",
        *_waiting(assembly),
        _WATCH_MOVES,
        *_FORCES,
        _STAGE_END,
    ]


def _waiting(assembly: Assembly) -> list[str]:
    """Return the commands that hold the strikers, if there are any."""
    if not assembly.case.striker:
        return []
    strikers = f"{assembly.lattice.n_spheres + 1}:{assembly.last_sphere}"
    return [
        f"group           {_STRIKERS} id {strikers}",
        f"fix             {_STRIKERS} {_STRIKERS} setforce 0 0 0",
    ]


def _near_balance(assembly: Assembly) -> list[str]:
    """Return the commands that put the grains near the balance that was found beforehand."""
    if balanced_displacements(assembly) is None:
        return []
    return [
        "# Equilibrium found by Newton's method: displacements relative to the data file, m.",
        *(f"variable        start_{axis} atomfile {START_FILE.format(axis)}" for axis in "xyz"),
        f"displace_atoms  {_SPHERES} move v_start_x v_start_y v_start_z units box",
        *(f"variable        start_{axis} delete" for axis in "xyz"),
    ]


def _halt(assembly: Assembly) -> list[str]:
    """Return the commands that stop a packing that rearranges, where it may not."""
    if assembly.case.may_rearrange:
        return []
    return [
        "variable        static_moved equal c_static_moved",
        f"variable        static_most equal {num(largest_move(assembly))}",
        "fix             static_halt all halt 100 v_static_moved > ${static_most} error continue",
    ]


def _springs(assembly: Assembly) -> list[str]:
    """Return the energies stored in the springs of friction, rolling and twisting, which damped
    motion leaves.
    """
    case = assembly.case
    parts = [_TANGENTIAL] if case.has_friction else []
    parts += [_ROLLING, _TWISTING] if case.has_resistance else []
    words = []
    for of_pairs, of_wall in parts:
        words.append(of_pairs.of(_ENERGY))
        words += [of_wall.of(f"f_{name}") for name in plane_fixes(assembly)]
    return words


def second_half(assembly: Assembly) -> list[str]:
    """Return the commands for equilibrium with the laws and dents of the case, and its record."""
    case = assembly.case
    step = support_timestep(assembly, static_stiffness(assembly))
    columns = [
        _ENERGY,
        EnergyColumn.YIELDED.of(_ENERGY),
        largest_force(assembly),
        "c_static_borne",
        NET_FORCE,
        "c_static_moved",
    ]
    record = _record(assembly)
    support = moving_fix(assembly)
    for name, pressed in pressed_walls(assembly).items():
        mean = "+".join(f"({outward_force(wall)})" for wall in pressed)
        record[f"moved_{name}"] = f"$(v_{moved_wall(name)}:%.17g)"
        record[f"force_{name}"] = f"$(({mean})/{len(pressed)}:%.17g)"
    stored = [_ENERGY, *(WallColumn.ELASTIC.of(f"f_{name}") for name in plane_fixes(assembly))]
    if case.settles_damped or not case.seeks_balance:
        stored += _springs(assembly)
    if support:
        stored.append(WallColumn.SUPPORT_ENERGY.of(f"f_{support}"))
    values = "\n".join([f"# {joined(record)}", joined(record.values())])
    halted = case.seeks_balance and not case.may_rearrange
    return [
        _STAGE_MARKER,
        "# Equilibrium with the law of the case; the state is then recorded, and the run starts "
        "at time 0.",
        *_relief(case, again=True),
        "compute         static all gran/hysteretic/energy",
        f"compute         static_borne all reduce sum {SphereColumn.COORDINATION.of(_SPHERE)}",
        *clump_sums(assembly),
        *_with_walls(assembly),
        f"variable        static_net atom {net_force(assembly)}",
        f"compute         static_net {_SPHERES} reduce max v_static_net",
        f"thermo_style    custom step {joined(columns)} {POTENTIAL}",
        "thermo_modify   norm no",
        *_balance(assembly),
        f"variable        static_iterations equal {'$(step)' if case.seeks_balance else 0}",
        f"variable        static_yielded equal $({EnergyColumn.YIELDED.of(_ENERGY)}:%.0f)",
        "gran/dents      begin",
        *(["unfix           static_halt"] if halted else []),
        *([_STILL] if case.seeks_balance else []),
        *_stored_again(assembly),
        "reset_timestep  0 time 0.0",
        # FIRE may leave a step that is too long for the support of the bottom
        *([f"timestep        {num(step)}"] if math.isfinite(step) else []),
        "compute         contacts all gran/hysteretic/local",  # taken back by `initial_forces`
        *(count_commands() if written_in_parts(assembly) else []),
        *(_turning(case) if case.packing.restart else []),
        "run             0 post no",
        *initial_forces(assembly),
        f"variable        static_stored equal {'+'.join(stored)}",
        f"variable        static_load equal {num(force_of_contact(assembly))}",
        f'print           """{values}""" file {DUMPS}/{STATIC_STAGE_FILE} screen no',
        f"variable        static_all equal v_static_stored+{POTENTIAL}",
        *([f"unfix           {_STRIKERS}"] if case.striker else []),
        *(["unfix           static_relief"] if _relief(case) else []),
        f'print           "variable static equal $(v_static_all:%.17g)" file {DUMPS}/{STATIC_FILE} screen no',
        *(_moving_bed(assembly) if case.packing.restart else []),
        *(
            f"uncompute       static{name}"
            for name in (
                *_computes_of_weight(assembly),
                "_moved",
                "_net",
                "_borne",
                *(["_carried_each"] if counts_walls(assembly) else []),
                "_largest",
                "_sphere",
                "",
            )
        ),
        *(f"uncompute       {line.split()[1]}" for line in reversed(clump_sums(assembly))),
        _STAGE_END,
        "",
    ]


def _record(assembly: Assembly) -> dict[str, str]:
    """Return the values of the record by column."""
    largest = largest_force(assembly)
    record = {name: value.replace("{largest}", largest) for name, value in RECORD.items()}
    if bears_its_weight(assembly):
        record |= RECORD_OF_WEIGHT
    return record


def _computes_of_weight(assembly: Assembly) -> tuple[str, ...]:
    """Return the ends of the names of the computes of net forces over weights."""
    if not bears_its_weight(assembly):
        return ()
    return ("_rolling", "_worst", "_sum")


def _with_walls(assembly: Assembly) -> list[str]:
    """Return the commands of the largest force of a contact, of those with walls too."""
    if not counts_walls(assembly):
        return []
    forces = [f"f_{fix}[{_FORCE_OF_WALL}]" for fix in plane_fixes(assembly)]
    own = SphereColumn.FORCE.of(_SPHERE)
    return [
        f"compute         static_carried_each all reduce max {own} {joined(forces)}",
        "variable        static_carried equal max(c_static_carried_each)",
    ]


def _balance(assembly: Assembly) -> list[str]:
    """Return the commands that bring the packing to balance with the laws of the case."""
    case = assembly.case
    if case.settles_damped:
        return damped_run(assembly, _SPHERES)
    return [_minimize(assembly) if case.seeks_balance else "run             0 post no"]


def _turning(case: Case) -> list[str]:
    """Return the commands for the energy of rotation that a restart file brings."""
    return ["compute         static_turning all erotate/sphere"] if case.has_rotation else []


def _moving_bed(assembly: Assembly) -> list[str]:
    """Return the commands that record the kinetic energy of a restart file, which is input too.

    Spheres that are struck get another velocity.
    """
    case = assembly.case
    terms = ["ke(all)"]
    lines = []
    if start_velocity(assembly) is not None and (struck := struck_of(assembly)):
        lines.append(f"group           static_struck id {joined(struck)}")
        terms.append("-ke(static_struck)")
    if case.has_rotation:
        terms.append("+c_static_turning")
    name = MOVING_BED.removeprefix("v_")
    value = f"$({''.join(terms)}:%.17g)"
    return [
        *lines,
        f'print           "variable {name} equal {value}" append {DUMPS}/{STATIC_FILE} screen no',
        *(["uncompute       static_turning"] if case.has_rotation else []),
    ]


def load_tables(assembly: Assembly) -> dict[str, str]:
    """Return the texts of the files of dead loads and of displacements to equilibrium by name, one
    for each direction.
    """
    each = (dead_loads(assembly), striker_loads(assembly))
    ids = np.concatenate([numbers for numbers, _ in each])
    forces = np.concatenate([loads for _, loads in each])
    tables = {}
    for axis in directions(assembly):
        along = forces[:, "xyz".index(axis)]
        tables[DEAD_LOAD_FILE.format(axis)] = _table("dead loads: id, force (N)", ids, along)
    moved = balanced_displacements(assembly)
    if moved is not None:
        for axis, along in zip("xyz", moved.T, strict=True):
            title = "displacements: id, displacement (m)"
            tables[START_FILE.format(axis)] = _table(title, assembly.ids, along)
    return tables


def _table(title: str, ids: NDArray[np.int64], values: NDArray[np.float64]) -> str:
    """Return the text of a file of an atomfile variable; spheres that it lacks have 0."""
    each = zip(ids.tolist(), values.tolist(), strict=True)
    rows = [f"{sphere} {value:.17g}\n" for sphere, value in each if value]
    rows = rows or [f"{ids[0]} 0\n"]  # LAMMPS reads no empty table
    return f"# {title}; number of rows\n{len(rows)}\n{''.join(rows)}"


def _pressing(assembly: Assembly) -> list[str]:
    """Return the commands that move walls inwards iteratively until they carry their forces.

    The power 2/3 of the force is about linear in the distance: its secant gives the next one, in
    the first round the line through the start.
    """
    stage = assembly.case.precompression
    if stage is None or not stage.presses:
        return []
    lines = [
        "# Walls move in until they carry their forces: secant steps in the power 2/3 of the force."
    ]
    for number in range(_ROUNDS):
        for name, pressed in pressed_walls(assembly).items():
            here = f"v_{moved_wall(name)}"
            level = f"static_level_{name}"
            force = "+".join(f"({outward_force(wall, _PREFIX)})" for wall in pressed)
            share = f"abs({force})/{num(len(pressed) * stage.presses[name])}"
            if number:
                lines.append(f"variable        static_before_{name} equal $(v_{level}:%.17g)")
            lines.append(f"variable        {level} equal $(({share})^(2/3):%.17g)")
            slope = f"v_{level}/{here}"
            if number:
                rise = f"v_{level}-v_static_before_{name}"
                run = f"{here}-v_static_from_{name}"
                slope = f"(({rise})/(({run})+(({run})==0)))"
            lines += [
                f"variable        static_slope_{name} equal $({slope}:%.17g)",
                f"variable        static_slope_{name} equal "
                f"$(ternary(v_static_slope_{name}>{_FLATTEST}/{here},v_static_slope_{name},{_FLATTEST}/{here}):%.17g)",
                f"variable        static_from_{name} equal $({here}:%.17g)",
                f"variable        {moved_wall(name)} equal $({here}+(1-v_{level})/v_static_slope_{name}:%.17g)",
            ]
        moved = [wall for pressed in pressed_walls(assembly).values() for wall in pressed]
        lines += wall_commands(assembly, elastic=True, prefix=_PREFIX, only=moved)
        lines.append(_minimize(assembly, first=True))
    found = "\n".join(
        f"variable {moved_wall(name)} equal $(v_{moved_wall(name)}:%.17g)" for name in stage.presses
    )
    return [*lines, f'print           """{found}""" file {DUMPS}/{MOVED_WALLS_FILE} screen no']


def _relief(case: Case, *, again: bool = False) -> list[str]:
    """Return the commands of inertia relief, if nothing holds the packing in place."""
    stage = case.precompression
    bottom = case.boundary.bottom_rule
    if stage is None or not stage.rule.on_all_faces or bottom.holds_layer:
        return []
    return (relief_state if again else relief_commands)(
        "static_relief", _SPHERES, on_plane=bottom.has_plane
    )


def _minimize(assembly: Assembly, *, first: bool = False) -> str:
    """Return the command that finds balance, to a net force that is a fraction of contact forces,
    plus rounding.
    """
    case = assembly.case
    of_file = case.packing.contact_way is not None
    disordered = has_gaps(case) or of_file
    mean = force_of_contact(assembly)
    span = float(np.abs(assembly.bounds() - assembly.deck_origin).max())
    rounding = float(
        _ROUNDING * static_stiffness(assembly) * np.finfo(float).eps * span
    )  # of coordinates
    if may_lose_its_load(assembly):
        return _minimize_to(num(float(f"{_TOLERANCE_OF_DISORDER * mean + rounding:.3g}")))
    least = num(float(f"{(_FIRST_HALF if disordered else _TOLERANCE) * mean + rounding:.3g}"))
    if disordered and not first:
        none = f"<{num(LOST_LOAD * mean)}" if of_file else "==0"
        largest = f"(v_static_force+(v_static_force{none})*{num(mean)})"
        least = f"$({num(_TOLERANCE_OF_DISORDER)}*{largest}+{num(float(f'{rounding:.3g}'))})"
    return _minimize_to(least)


def _minimize_to(least: str) -> str:
    """Return the command that ends when no net force is larger than ``least``, N."""
    return f"minimize        0.0 {least} {MOST_ITERATIONS} {2 * MOST_ITERATIONS}"
