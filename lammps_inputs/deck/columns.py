"""Columns of the output of LAMMPS: name in the file, source in LAMMPS, and unit.

The input script, the readers and ``result.h5`` take names, order and units from here. The pages of
the computes and fixes of the plugin (plugins/doc) list the column numbers.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.plugin_columns import (
    DisplacementColumn,
    EnergyColumn,
    SphereColumn,
    WallColumn,
)

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case

# Conditions of columns: friction, initial dents, viscous losses, rotation; a record of the forces
# at every snapshot
FRICTION = "friction"
DENTS = "dents"
LOSS = "loss"
TURNING = "turning"
FORCES_OF_ALL = "forces"
# resistance to rolling and twisting, of contacts
RESISTANCE = "resistance"
COHESION = "cohesion"
# a load by a plate, friction in a holder, spheres that absorb waves, a bottom that moves, an
# automatic timestep
PLATE = "plate"
HOLDER = "holder"
ABSORB = "absorb"
SUPPORT = "support"
ADAPTIVE = "adaptive"


@dataclasses.dataclass(frozen=True)
class Column:
    """One column of an output file.

    Attributes
    ----------
    name
        Name in the file.
    source
        Attribute of LAMMPS, or reference to a compute, fix or variable.
    unit
        SI unit; "1" if dimensionless.
    when
        Condition, such as `FRICTION`, for a column of such cases only; empty: of all cases.
    """

    name: str
    source: str
    unit: str = "1"
    when: str = ""


def of_compute(
    name: str, columns: Iterable[tuple[str, str] | tuple[str, str, str]], first: int = 1
) -> tuple[Column, ...]:
    """Make the columns of a compute or fix from their names, units and conditions, in the order of
    their numbers.

    Parameters
    ----------
    name
        Reference to the compute or fix, such as ``c_contacts``; ``{}`` is a placeholder for a name
        that `sources` fills in.
    first
        Number of the first column.
    """
    return tuple(
        Column(column, f"{name}[{number}]", unit, *when)
        for number, (column, unit, *when) in enumerate(columns, first)
    )


#: dumps/energy.txt, after the step. Those of the timestep are by variables, since its fix comes later.
LEDGER = (
    Column("time", "v_time", "s"),
    Column("kinetic", "c_kinetic", "J"),
    Column("elastic", "v_elastic", "J"),
    Column("dissipated", "v_dissipated", "J"),
    Column("elastic_wall", "v_elastic_wall", "J"),
    Column("dissipated_wall", "v_dissipated_wall", "J"),
    Column("input", "v_input", "J"),
    *of_compute(
        "c_contact",
        [
            ("contacts_yielded", "1"),
            ("beyond_law", "1"),
            ("beyond_half", "1"),
            ("largest_force", "N"),
        ],
        first=EnergyColumn.YIELDED,
    ),
    Column("struck_velocity", "v_struck_velocity", "m s-1"),
    Column("rotational", "c_rotational", "J", TURNING),
    Column(
        "plate", WallColumn.SUPPORT_ENERGY.of("f_plate"), "J", PLATE
    ),  # included in the kinetic energy
    Column("elastic_tangential", "v_elastic_tangential", "J", FRICTION),
    Column("friction", "v_friction", "J", FRICTION),
    Column("elastic_rolling", "v_elastic_rolling", "J", RESISTANCE),
    Column("rolling", "v_rolling", "J", RESISTANCE),
    Column("elastic_twisting", "v_elastic_twisting", "J", RESISTANCE),
    Column("twisting", "v_twisting", "J", RESISTANCE),
    Column("adhesion", "v_adhesion", "J", COHESION),
    Column("viscous", "v_viscous", "J", LOSS),
    Column("holder", "f_holder", "J", HOLDER),
    Column("absorbed", "v_absorbed", "J", ABSORB),
    # energy of the support, dissipation of its damper, work done on it
    Column("support", WallColumn.SUPPORT_ENERGY.of("f_{}"), "J", SUPPORT),
    Column("support_lost", WallColumn.SUPPORT_LOSS.of("f_{}"), "J", SUPPORT),
    Column("target", WallColumn.WORK.of("f_{}"), "J", SUPPORT),
    Column("timestep", "v_timestep", "s", ADAPTIVE),
    Column("expected_error", "v_expected_error", "1", ADAPTIVE),
    Column("timesteps", "v_timesteps", "1", ADAPTIVE),
    Column("smallest_timestep", "v_smallest_timestep", "s", ADAPTIVE),
    Column("largest_timestep", "v_largest_timestep", "s", ADAPTIVE),
)

#: dumps/spheres.dump.
SNAPSHOT = (
    Column("id", "id"),
    Column("type", "type"),
    Column("radius", "radius", "m"),
    *(Column(axis, axis, "m") for axis in "xyz"),
    *of_compute("c_displacement", [(f"u{axis}", "m") for axis in "xyz"]),
    *(Column(f"v{axis}", f"v{axis}", "m s-1") for axis in "xyz"),
    Column("force", SphereColumn.FORCE.of("c_sphere"), "N"),
    Column("peak_force", SphereColumn.PEAK_FORCE.of("c_sphere"), "N"),
    Column("peak_overlap", SphereColumn.PEAK_OVERLAP.of("c_sphere"), "m"),
    Column("dissipated", SphereColumn.DISSIPATED.of("c_sphere"), "J"),
    Column("elastic", SphereColumn.ELASTIC.of("c_sphere"), "J"),
    Column("elastic_tangential", SphereColumn.ELASTIC_TANGENTIAL.of("c_sphere"), "J", FRICTION),
    Column("friction", SphereColumn.FRICTION.of("c_sphere"), "J", FRICTION),
    Column("viscous", SphereColumn.VISCOUS.of("c_sphere"), "J", LOSS),
    *(Column(f"f{axis}", f"f{axis}", "N", FORCES_OF_ALL) for axis in "xyz"),
    *(Column(f"omega{axis}", f"omega{axis}", "rad s-1", FORCES_OF_ALL) for axis in "xyz"),
    *(Column(f"tq{axis}", f"tq{axis}", "N m", FORCES_OF_ALL) for axis in "xyz"),
)

#: dumps/history.dump: history of a chain.
HISTORY = (
    Column("id", "id"),
    Column("uz", DisplacementColumn.Z.of("c_displacement"), "m"),
    Column("vz", "vz", "m s-1"),
)

#: dumps/lines.dump: history of lines of grains.
LINES = (
    Column("id", "id"),
    *of_compute("c_displacement", [(f"u{axis}", "m") for axis in "xyz"]),
    *(Column(f"v{axis}", f"v{axis}", "m s-1") for axis in "xyz"),
    *of_compute("c_sums", [(f"sum_f{axis}", "N") for axis in "xyz"]),
    *(Column(f"omega{axis}", f"omega{axis}", "rad s-1", TURNING) for axis in "xyz"),
)

_HISTORY_OF_CONTACT = [("time_first", "s"), ("time_peak", "s"), ("time_yield", "s")]

#: dumps/contacts.dump: compute gran/hysteretic/local.
CONTACTS = of_compute(
    "c_contacts",
    [
        ("i", "1"), ("j", "1"), ("overlap", "m"), ("force", "N"), ("peak_overlap", "m"), ("peak_force", "N"),
        ("elastic", "J"), ("dissipated", "J"), *_HISTORY_OF_CONTACT, ("live", "1"), ("tangential_force", "N", FRICTION),
        ("elastic_tangential", "J", FRICTION), ("friction", "J", FRICTION), ("initial", "m", DENTS),
        ("viscous", "J", LOSS), *((f"t{axis}", "N", FORCES_OF_ALL) for axis in "xyz"),
    ],
)  # fmt: skip

#: dumps/forces.dump: history of the contact forces of a chain; dumps/initial_forces.dump: after the static stage.
FORCES = tuple(column for column in CONTACTS if column.name in ("i", "j", "force"))

#: dumps/forces-*.dump: contact forces at every snapshot; the tangential force is that on sphere i.
FORCES_AT_FRAMES = tuple(
    column for column in CONTACTS if column.name in ("i", "j", "force", "tx", "ty", "tz")
)

#: dumps/wall_NAME.dump, after the id: fix wall/gran/hysteretic, per sphere.
WALL_CONTACTS = of_compute(
    "f_{}",
    [
        ("overlap", "m"), ("force", "N"), ("peak_overlap", "m"), ("peak_force", "N"), ("dissipated", "J"),
        *_HISTORY_OF_CONTACT, ("tangential_force", "N", FRICTION), ("friction", "J", FRICTION), ("initial", "m", DENTS),
        ("viscous", "J", LOSS),
    ],
)  # fmt: skip

#: dumps/initial_forces_NAME.dump, after the id: force on a wall after the static stage.
WALL_FORCES = tuple(column for column in WALL_CONTACTS if column.name == "force")

#: dumps/walls.txt, after the forces, for a moving plane: from the vector of its fix.
MOVING_WALL = (
    Column("displacement", WallColumn.DISPLACEMENT.of("f_{}"), "m"),
    Column("velocity", WallColumn.VELOCITY.of("f_{}"), "m s-1"),
    Column("ground_force", WallColumn.GROUND_FORCE.of("f_{}"), "N"),
)


def names(table: Iterable[Column], *having: str) -> tuple[str, ...]:
    """Return the names of the columns of all cases, and of columns with the given conditions."""
    return tuple(column.name for column in table if not column.when or column.when in having)


def sources(table: Iterable[Column], *having: str, of: str = "") -> dict[str, str]:
    """Return the sources in LAMMPS of the columns, by name.

    Parameters
    ----------
    having
        Conditions that apply to the case.
    of
        Name of the fix, inserted for ``{}``.
    """
    return {
        column.name: column.source.format(of)
        for column in table
        if not column.when or column.when in having
    }


def recorded(case: Case) -> tuple[str, ...]:
    """Return the conditions that select the columns of a case."""
    there = {
        FRICTION: case.has_friction,
        RESISTANCE: case.has_resistance,
        COHESION: case.has_cohesion,
        DENTS: case.has_initial_dents,
        LOSS: case.has_loss,
        TURNING: case.has_rotation,
        FORCES_OF_ALL: case.output.contact_forces,
        PLATE: case.load.plate,
        HOLDER: case.has_holder_friction,
        ABSORB: case.absorb,
        SUPPORT: case.boundary.bottom_support,
    }
    return tuple(name for name, recorded in there.items() if recorded)
