"""Damped run: motion with friction, losses and local damping until a packing is at rest.

Grains that friction supports would slide without it. Where `precompression.damped` is true, both
halves of the static stage integrate the motion with friction, losses and local damping (Cundall and
Strack 1979), starting from the positions of the case; the resulting tangential springs are kept.
Along each axis, half of the net force on a sphere is subtracted where the sphere moves with the
force, and added where it moves against it. This damps a grain that rolls under its weight as fast,
relative to its period, as a grain that oscillates on a stiff contact. A drag that ends the swings
would hold the rolling grain, which then creeps on with a net force equal to its drag. Settled
grains need about a thousand steps, or tens of thousands if some grains roll to other positions.

The last motion is the slow swing of single grains that roll in hollows. Twice in its period the net
force on such a grain passes through zero while it moves, with its drag in balance with its weight.
A grain is therefore at rest only if the drag on its spin is small as well: it is added to the net
force, as a force at the radius, and the spin is zero at the end.

A clump is one body, whose net force is the sum over its grains. Half of it is subtracted or added
as for a single grain, distributed by mass; damping each grain by its own forces would hold the
clump like dry friction. Its rotation is damped by the drag on spin. The moment about its centre
counts as a force at the radius of a grain.
"""

from __future__ import annotations

import math

import numpy as np

from granwave.lammps_inputs.contact.static_load import (
    dead_loads,
    static_stiffness,
    stiffness_in_bed,
)
from granwave.lammps_inputs.deck.motion import CLUMPS, integration
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import struck_of
from granwave.lammps_inputs.packing.walls import plane_fixes
from granwave.lammps_inputs.script_words import joined, num

_DAMPING = "static_damping"  # fix, and prefix of its variables
_SPIN = "static_spin"  # compute, of angular velocities
# net force, with the drag on the spin / largest contact force, at the end of a damped run
QUIET = 4e-7
_MOST_STEPS = 1_000_000  # most steps of a damped run
# steps times grains up to which `QUIET` is required under gravity, and its bounds in steps
_STRICT_WORK = 30_000_000
_STRICT_STEPS = (10_000, 60_000)
# limits after these steps: sum of the net forces / weight of the bed, and net force /
# weight of a grain or a clump
CALM = 3e-4
HELD = 1.0
LOOSE = 0.01  # net force / weight of a grain above which it is named
# fraction by which a net force is reduced where it accelerates a sphere in a damped run
_DAMPED_PART = 0.5
# drag on spin over sqrt(stiffness mass) times 0.4 radius^2; a third and 2.7 times of it take a
# quarter more steps with 200 poured grains
_DRAG_ON_SPIN = 0.006
# largest drag on spin over radius sqrt(0.4 radius mass weight): more of it lets grains creep
_DRAG_ON_ROLLING = 0.5
_DAMPED_STEP = 0.2  # timestep of a damped run over sqrt(mass/stiffness)
_NET = "sqrt(fx^2+fy^2+fz^2)"  # net force on a sphere
# columns of the log: largest force of a contact between grains, and with walls
LARGEST_OF_PAIRS = "c_static_largest"
LARGEST_OF_ALL = "v_static_carried"
UNBALANCED = "static_unbalanced"  # variable: sum of the net forces / weight of the bed
LEAST_HELD = "static_worst"  # compute: largest net force / weight of its grain or clump
ROLLING_GRAINS = "static_rolling"  # compute: number of grains above `LOOSE`
_BODY = "static_body"  # compute of sums over clumps, and prefix of the others that it needs
# first columns of it
_FORCE_OF_BODY = 1
_MASS_OF_BODY = 4
_TORQUE_OF_BODY = 5
_MOMENT_OF_BODY = 8
_VELOCITY_OF_BODY = 11


def damped_run(assembly: Assembly, group: str) -> list[str]:
    """Return the commands of a damped run, which ends when the net forces are small.

    Parameters
    ----------
    group
        Group of the moving spheres.
    """
    case = assembly.case
    mass = float(assembly.sphere_masses().min())
    radius = float(assembly.sphere_diameters().min()) / 2
    stiffness = stiffness_in_bed(assembly)
    lines = integration(assembly)
    if case.load.prescribes_motion:
        lines.insert(0, f"group           hit id {joined(struck_of(assembly))}")
    fixes = [line.split()[1] for line in lines if line.startswith("fix ")]
    if case.has_rotation:
        on_spin = _drag_on_spin(assembly, mass, radius)
        spin = "+".join(f"c_{_SPIN}[{axis}]^2" for axis in (1, 2, 3))
        net = f"{net_force(assembly)}+{num(on_spin)}*sqrt({spin})/radius"
        lines += [
            f"fix             static_twist all viscous/sphere {num(on_spin)}",
            f"compute         {_SPIN} all property/atom omegax omegay omegaz",
            f"variable        static_net atom {net}",
        ]
        fixes.append("static_twist")
    return [
        "# Damped run, until the largest net force is small compared with the largest contact "
        "force.",
        "thermo          1000",
        *lines,
        *_local_damping(assembly),
        f"timestep        {num(_DAMPED_STEP * math.sqrt(mass / stiffness))}",
        *_unbalanced_weight(assembly, group),
        f"variable        static_quiet equal {_quiet(assembly)}",
        f"fix             static_quiet all halt 100 v_static_quiet < {num(QUIET)} error continue",
        f"run             {_MOST_STEPS} post no",
        *(f"unfix           {name}" for name in ("static_quiet", *fixes, *_dampings(assembly))),
        *_without_spin(assembly, group),
    ]


def largest_force(assembly: Assembly) -> str:
    """Return the largest force of a contact, between grains and, for grains of a file, with walls:
    such grains may touch only walls.
    """
    return LARGEST_OF_ALL if counts_walls(assembly) else LARGEST_OF_PAIRS


def counts_walls(assembly: Assembly) -> bool:
    """Return True if the largest force of a contact includes contacts with walls."""
    return assembly.case.packing.contact_way is not None and bool(plane_fixes(assembly))


def bears_its_weight(assembly: Assembly) -> bool:
    """Return True for a damped run of grains that each carry their own weight."""
    stage = assembly.case.precompression
    return assembly.case.settles_damped and stage is not None and stage.rule.grows_with_depth


def _quiet(assembly: Assembly) -> str:
    """Return the largest net force divided by the largest force of a contact; 0 where only single
    grains of a bed still roll.
    """
    largest = largest_force(assembly)
    ratio = f"c_static_net/({largest}+({largest}==0))"
    if not bears_its_weight(assembly):
        return ratio
    low, high = _STRICT_STEPS
    strict = min(max(_STRICT_WORK // assembly.lattice.n_spheres, low), high)
    calm = f"(v_{UNBALANCED}<{num(CALM)})*(c_{LEAST_HELD}<{num(HELD)})"
    return f"{ratio}*(1-(step>{strict})*{calm})"


def _unbalanced_weight(assembly: Assembly, group: str) -> list[str]:
    """Return the commands of net forces divided by weights: of all grains together, and of the
    grain or the clump with the largest ratio.
    """
    if not bears_its_weight(assembly):
        return []
    _, loads = dead_loads(assembly)
    weight = float(np.linalg.norm(loads, axis=1).sum())
    return [
        f"variable        static_weight atom {_weight(assembly)}",
        f"variable        static_part atom {_part_of_net_force(assembly)}",
        "variable        static_loose atom "
        "v_static_net*(v_static_weight>0)/(v_static_weight+(v_static_weight==0))",
        f"compute         static_sum {group} reduce sum v_static_part",
        f"compute         {LEAST_HELD} {group} reduce max v_static_loose",
        f"variable        {UNBALANCED} equal c_static_sum/{num(weight)}",
        f"variable        static_rolls atom v_static_loose>{num(LOOSE)}",
        f"compute         {ROLLING_GRAINS} {group} reduce sum v_static_rolls",
    ]


def _weight(assembly: Assembly) -> str:
    """Return the formula of the weight of a grain, or of the clump of the grain."""
    weight = "abs(v_dead_z)"
    if not assembly.clumps:
        return weight
    mass = _of_body(_MASS_OF_BODY)
    return f"{weight}*ternary({mass}>0,{mass}/mass,1)"


def _part_of_net_force(assembly: Assembly) -> str:
    """Return the formula of a net force, whose sum over the grains of a clump is the net force on
    the clump.
    """
    if not assembly.clumps:
        return "v_static_net"
    mass = _of_body(_MASS_OF_BODY)
    return f"v_static_net*ternary({mass}>0,mass/({mass}+({mass}==0)),1)"


def _drag_on_spin(assembly: Assembly, mass: float, radius: float) -> float:
    """Return the drag on the spin of a grain in a damped run, N m s; mass in kg, radius in m.

    It damps oscillations on the springs of contacts, but grains that their weight drives can roll.
    """
    drag = 0.4 * _DRAG_ON_SPIN * math.sqrt(static_stiffness(assembly) * mass) * radius**2
    _, loads = dead_loads(assembly)
    if not len(loads):
        return drag
    weight = float(np.linalg.norm(loads, axis=1).mean())
    return min(drag, _DRAG_ON_ROLLING * radius * math.sqrt(0.4 * radius * mass * weight))


def _without_spin(assembly: Assembly, group: str) -> list[str]:
    """Return the commands that end the rotation of a damped run."""
    if not assembly.case.has_rotation:
        return []
    return [
        f"set             group {group} omega 0.0 0.0 0.0",
        f"variable        static_net atom {net_force(assembly)}",
        f"uncompute       {_SPIN}",
    ]


def _local_damping(assembly: Assembly) -> list[str]:
    """Return the commands of local damping; its fixes act on the sum of the other forces, and
    therefore come last.
    """
    part = num(_DAMPED_PART)
    words = [f"v_{_DAMPING}_{axis}" for axis in "xyz"]
    of_grains = [
        *(
            f"variable        {_DAMPING}_{axis} atom -{part}*abs(f{axis})*((v{axis}>0)-(v{axis}<0))"
            for axis in "xyz"
        ),
        f"fix             {_DAMPING} all addforce {joined(words)}",
    ]
    if not assembly.clumps:
        return of_grains
    of_grains[-1] = f"fix             {_DAMPING} static_single addforce {joined(words)}"
    of_clumps = f"{_DAMPING}_{CLUMPS}"
    words = [f"v_{of_clumps}_{axis}" for axis in "xyz"]
    lines = [f"group           static_single subtract all {CLUMPS}", *of_grains]
    for place, axis in enumerate("xyz"):
        force = _of_body(_FORCE_OF_BODY + place)
        velocity = _of_body(_VELOCITY_OF_BODY + place)
        fraction = f"mass/{_of_body(_MASS_OF_BODY)}"
        lines.append(
            f"variable        {of_clumps}_{axis} atom "
            f"-{part}*abs({force})*{fraction}*(({velocity}>0)-({velocity}<0))"
        )
    return [*lines, f"fix             {of_clumps} {CLUMPS} addforce {joined(words)}"]


def _dampings(assembly: Assembly) -> list[str]:
    """Return the fixes of local damping."""
    return [_DAMPING, *([f"{_DAMPING}_{CLUMPS}"] if assembly.clumps else [])]


def clump_sums(assembly: Assembly) -> list[str]:
    """Return the computes of the sums over each clump; the last compute assigns the sums to the
    grains.
    """
    if not assembly.clumps:
        return []
    columns = joined(f"c_{_BODY}_{name}[*]" for name in ("sum", "moment", "velocity"))
    chunks = f"{_BODY}_chunks"
    return [
        f"compute         {chunks} {CLUMPS} chunk/atom molecule",
        f"compute         {_BODY}_own {CLUMPS} property/atom fx fy fz mass tqx tqy tqz",
        f"compute         {_BODY}_sum {CLUMPS} reduce/chunk {chunks} sum c_{_BODY}_own[*]",
        f"compute         {_BODY}_moment {CLUMPS} torque/chunk {chunks}",
        f"compute         {_BODY}_velocity {CLUMPS} vcm/chunk {chunks}",
        f"compute         {_BODY} {CLUMPS} chunk/spread/atom {chunks} {columns}",
    ]


def _of_body(column: int) -> str:
    """Return a column of the sums over clumps."""
    return f"c_{_BODY}[{column}]"


def net_force(assembly: Assembly) -> str:
    """Return the formula of the net force on a sphere, or on the clump of the sphere with the
    moment about its centre.
    """
    if not assembly.clumps:
        return _NET
    force = "+".join(f"{_of_body(_FORCE_OF_BODY + place)}^2" for place in range(3))
    moment = "+".join(
        f"({_of_body(_TORQUE_OF_BODY + place)}+{_of_body(_MOMENT_OF_BODY + place)})^2"
        for place in range(3)
    )
    of_clump = f"sqrt({force})+sqrt({moment})/radius"
    return f"ternary({_of_body(_MASS_OF_BODY)}>0,{of_clump},{_NET})"
