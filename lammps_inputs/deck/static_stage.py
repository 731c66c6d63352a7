"""Static stage before a precompressed run, in the LAMMPS input script.

Dead loads are applied, and the spheres are brought to equilibrium by damped dynamics (FIRE, Bitzek
et al. 2006) without friction. The first half uses Hertz's law for all contacts, and the contact
history is cleared afterwards, since its overlaps differ from the case's law. The second half
starts from that equilibrium with the laws and initial dents of the case; contacts whose static
force exceeds yield get their dents there. FIRE overshoots, which leaves no dents: every iteration
begins with the histories at the start (pair_gran_hysteretic_forces.cpp), so that dents correspond
to a monotonically increasing load. Then time and energies are reset to zero.

Grains that friction supports would slide without it. Where `precompression.damped` is true, both
halves are one damped run (`damped_run.py`) starting from the positions of the case; the resulting
tangential springs are kept.

A packing under uniform pressure may rotate rigidly, and dead loads, which keep their directions,
would amplify the rotation: inertia relief cancels the forces that accelerate it rigidly during the
stage (`inertia_relief.py`).

A resumed run does not repeat the stage. Files remain: STATIC_STAGE_FILE,
a record; STATIC_FILE, script lines with the reference energy of the energy record; and the forces
of all contacts (`initial_forces`).
"""

from __future__ import annotations

import math

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import (
    force_of_contact,
    static_stiffness,
)
from granwave.lammps_inputs.deck import columns as table
from granwave.lammps_inputs.deck.commands import (
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
from granwave.lammps_inputs.deck.minimisation import WALL_PREFIX, minimise, press_walls
from granwave.lammps_inputs.deck.motion import MOVING_BED, POTENTIAL
from granwave.lammps_inputs.deck.output import (
    count_commands,
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
    DUMPS,
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

_SPHERES = "static_spheres"  # group of the moving spheres
_STRIKERS = "static_strikers"  # group, and fix that holds them
_STEP = 0.03  # initial timestep over sqrt(mass/stiffness); FIRE makes it up to ten times longer
# energies stored by springs, of pairs and of a wall
_TANGENTIAL = (EnergyColumn.ELASTIC_TANGENTIAL, WallColumn.ELASTIC_TANGENTIAL)
_ROLLING = (EnergyColumn.ELASTIC_ROLLING, WallColumn.ELASTIC_ROLLING)
_TWISTING = (EnergyColumn.ELASTIC_TWISTING, WallColumn.ELASTIC_TWISTING)
_LONGEST_MOVE = 0.5  # displacement of a sphere in one iteration over the overlap of a contact

# column of the log: largest net force on a sphere
NET_FORCE = "c_static_net"
_START = "static_start"  # fix, of velocities before the stage
_STILL = "velocity        all set 0.0 0.0 0.0 units box"
_ENERGY = "c_static"  # energy of all contacts of pairs
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

# residual: largest net force on a sphere / largest contact force, or / load if no
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
# for grains that carry their own weight, after a damped run: sum of the net forces over the weight
# of all, largest net force / weight of its grain, number of grains that still roll
RECORD_OF_WEIGHT = {
    "unbalanced": f"$(v_{UNBALANCED}:%.6g)",
    "worst": f"$(c_{LEAST_HELD}:%.6g)",
    "rolling": f"$(c_{ROLLING_GRAINS}:%.0f)",
}


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
    """Return the commands that store the velocities of the grains, which are then at rest."""
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
    )  # overlap of a contact, by which walls move at first
    return [
        _STAGE_MARKER,
        "# Equilibrium under the dead loads, first with elastic contacts, whose history is then "
        "cleared.",
        *pair_coefficients(assembly, elastic=True),
        *(
            f"variable        {moved_wall(name)} equal {num(overlap)}"
            for name in pressed_walls(assembly)
        ),
        *wall_commands(assembly, elastic=True, prefix=WALL_PREFIX),
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
        minimise(assembly, first=True),
        *press_walls(assembly),
        "variable        static_force equal $(c_static_largest:%.17g)",
        *(f"unfix           {WALL_PREFIX}{name}" for name in plane_names(assembly)),
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
    """Return the commands that displace the grains to the equilibrium that was found before the
    run.
    """
    if balanced_displacements(assembly) is None:
        return []
    return [
        "# Equilibrium found by Newton's method: displacements relative to the data file, m.",
        *(f"variable        start_{axis} atomfile {START_FILE.format(axis)}" for axis in "xyz"),
        f"displace_atoms  {_SPHERES} move v_start_x v_start_y v_start_z units box",
        *(f"variable        start_{axis} delete" for axis in "xyz"),
    ]


def _halt(assembly: Assembly) -> list[str]:
    """Return the commands that stop the run if a packing rearranges that must not."""
    if assembly.case.may_rearrange:
        return []
    return [
        "variable        static_moved equal c_static_moved",
        f"variable        static_most equal {num(largest_move(assembly))}",
        "fix             static_halt all halt 100 v_static_moved > ${static_most} error continue",
    ]


def _springs(assembly: Assembly) -> list[str]:
    """Return the energies stored in the springs of friction, rolling and twisting after damped
    motion.
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
    """Return the suffixes of the names of the computes of net forces divided by weights."""
    if not bears_its_weight(assembly):
        return ()
    return ("_rolling", "_worst", "_sum")


def _with_walls(assembly: Assembly) -> list[str]:
    """Return the commands of the largest force of a contact, including contacts with walls."""
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
    return [minimise(assembly) if case.seeks_balance else "run             0 post no"]


def _turning(case: Case) -> list[str]:
    """Return the commands for the energy of rotation in a restart file."""
    return ["compute         static_turning all erotate/sphere"] if case.has_rotation else []


def _moving_bed(assembly: Assembly) -> list[str]:
    """Return the commands that record the kinetic energy of a restart file, which counts as input.
    The impacted spheres get another velocity.
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


def _relief(case: Case, *, again: bool = False) -> list[str]:
    """Return the commands of inertia relief, if nothing holds the packing in place."""
    stage = case.precompression
    bottom = case.boundary.bottom_rule
    if stage is None or not stage.rule.on_all_faces or bottom.holds_layer:
        return []
    return (relief_state if again else relief_commands)(
        "static_relief", _SPHERES, on_plane=bottom.has_plane
    )
