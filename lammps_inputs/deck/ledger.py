"""Energies in the LAMMPS input script: the energy record, and the log."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import energy_at_start
from granwave.lammps_inputs.deck import columns as table
from granwave.lammps_inputs.deck.columns import recorded, sources
from granwave.lammps_inputs.deck.commands import time_series
from granwave.lammps_inputs.deck.motion import FALL, POTENTIAL, STATIC, sum_of, velocity_along
from granwave.lammps_inputs.deck.plugin_columns import EnergyColumn, PairColumn, WallColumn
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import moving_fix, plane_fixes
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.run_directory import ENERGY_FILE
from granwave.lammps_inputs.script_words import joined, num

_LINES = 20  # approximate number of lines of the log


class EnergyPart(NamedTuple):
    """Part of the stored or dissipated energy of contacts.

    Attributes
    ----------
    when
        Condition of the cases that have it.
    name
        Its variable; a variable within another has 15 digits, which is enough for friction.
    of_contacts, of_walls
        Its columns.
    """

    when: str
    name: str
    of_contacts: EnergyColumn
    of_walls: WallColumn

    @property
    def is_stored(self) -> bool:
        """True for elastic energy."""
        return self.name.startswith("elastic")


_PARTS = tuple(
    EnergyPart(when, name, EnergyColumn[name.upper()], WallColumn[name.upper()])
    for when, name in (
        (table.FRICTION, "elastic_tangential"),
        (table.FRICTION, "friction"),
        (table.RESISTANCE, "elastic_rolling"),
        (table.RESISTANCE, "rolling"),
        (table.RESISTANCE, "elastic_twisting"),
        (table.RESISTANCE, "twisting"),
        (table.COHESION, "adhesion"),
        (table.LOSS, "viscous"),
    )
)


def ledger(assembly: Assembly, schedule: Schedule, *, resumed: bool = False) -> list[str]:
    """Return the commands of the energy record, which also counts yielded contacts."""
    case = assembly.case
    conditions = [*recorded(case), *([table.ADAPTIVE] if schedule.adaptive else [])]
    columns = sources(table.LEDGER)
    columns |= {bar.name: f"v_energy_{bar.name}" for bar in assembly.bars}
    columns |= sources(table.LEDGER, *conditions, of=moving_fix(assembly) or "")
    tick = num(schedule.timestep) if schedule.adaptive else "dt"
    kinetic = _kinetic_energy(assembly, columns)
    parts = [part for part in _PARTS if part.when in conditions]
    variables = _variables_of_parts(assembly, parts)
    if case.absorb:
        absorbed = [f"f_absorb{n}" for n, _ in enumerate(case.absorb, start=1)]
        variables.append(f"variable        absorbed equal {sum_of(absorbed)}")
    if schedule.adaptive:
        names = [column.name for column in table.LEDGER if column.when == table.ADAPTIVE]
        for number, name in enumerate(names, start=1):
            variables.append(f"variable        {name} equal f_step[{number}]")
    elastic = sum_of(_elastic_energies(assembly, parts, columns))
    dissipated = sum_of(_dissipated_energies(assembly, parts, columns))
    return [
        "# Energies, J. Their sum must remain equal to the energy input.",
        "compute         kinetic all ke",
        "compute         contact all gran/hysteretic/energy",
        f"variable        time equal step*{tick}",
        *_energies_of_bars(assembly),
        *kinetic,
        *variables,
        *_energies_at_walls(assembly, parts),
        f"variable        elastic equal {elastic}",
        f"variable        dissipated equal {dissipated}",
        f"variable        struck_velocity equal {velocity_along(case, 'struck')}",
        *time_series(
            "ledger",
            schedule.ledger_every,
            ENERGY_FILE,
            "energy balance, SI units",
            columns,
            resumed,
        ),
    ]


def _on_walls(assembly: Assembly, *columns: WallColumn) -> list[str]:
    """Return the references to columns of the fixes of all planes, column by column."""
    fixes = [f"f_{name}" for name in plane_fixes(assembly)]
    terms = []
    for column in columns:
        terms += [column.of(fix) for fix in fixes]
    return terms


def _terms_of(assembly: Assembly, part: EnergyPart) -> list[str]:
    """Return the references to a part of the energies, of contacts and of walls."""
    return [part.of_contacts.of("c_contact"), *_on_walls(assembly, part.of_walls)]


def _term_insum_of(assembly: Assembly, part: EnergyPart) -> list[str]:
    """Return the references to a part within another variable; friction has its own variable."""
    return [f"v_{part.name}"] if part.when == table.FRICTION else _terms_of(assembly, part)


def _kinetic_energy(assembly: Assembly, columns: dict[str, str]) -> list[str]:
    """Return the commands for the kinetic energy, and set the sources of its columns."""
    case = assembly.case
    lines = []
    moving = ["c_kinetic"]
    if case.has_rotation:
        lines.append("compute         rotational all erotate/sphere")
        if assembly.has_cylinders:  # for LAMMPS they are spheres of these masses and radii
            columns["rotational"] = "v_rotational"
            lines.append("variable        rotational equal c_rotational+f_cylinders")
        moving.append(columns["rotational"])
    if case.load.plate is not None:
        moving.append(columns["plate"])
    if case.moves_otherwise:
        columns["kinetic"] = "v_motion"
        lines.append(f"variable        motion equal {sum_of(moving)}")
    return lines


def _variables_of_parts(assembly: Assembly, parts: Sequence[EnergyPart]) -> list[str]:
    """Return the variables of parts of the energies, each summed over contacts and walls."""
    return [
        f"variable        {part.name} equal {sum_of(_terms_of(assembly, part))}" for part in parts
    ]


def _energies_at_walls(assembly: Assembly, parts: Sequence[EnergyPart]) -> list[str]:
    """Return the variables of the energies stored and dissipated at walls and bars."""
    stored = [WallColumn.ELASTIC]
    lost = [WallColumn.DISSIPATED]
    for part in parts:
        if part.is_stored:
            stored.append(part.of_walls)
        else:
            lost.append(part.of_walls)
    lost_at_bars = [PairColumn.DISSIPATED]
    if assembly.case.has_loss:
        lost_at_bars.append(PairColumn.VISCOUS)
    bars = [f"c_on_{bar.name}" for bar in assembly.bars]  # their contacts are of the pair style
    elastic = _on_walls(assembly, *stored) + [PairColumn.ELASTIC.of(bar) for bar in bars]
    dissipated = _on_walls(assembly, *lost)
    for column in lost_at_bars:
        dissipated += [column.of(bar) for bar in bars]
    return [
        f"variable        elastic_wall equal {sum_of(elastic)}",
        f"variable        dissipated_wall equal {sum_of(dissipated)}",
    ]


def _elastic_energies(
    assembly: Assembly, parts: Sequence[EnergyPart], columns: Mapping[str, str]
) -> list[str]:
    """Return the terms of the stored energy: contacts, support, bars, dead loads, cohesion."""
    terms = ["c_contact", *_on_walls(assembly, WallColumn.ELASTIC)]
    for part in parts:
        if part.is_stored:
            terms += _term_insum_of(assembly, part)
    if "support" in columns:
        terms.append(columns["support"])
    terms += [f"c_elastic_{bar.name}" for bar in assembly.bars]
    if assembly.case.precompression:
        terms += [POTENTIAL, f"-{STATIC}"]
    if assembly.case.strikers_fall:
        terms.append(f"-{FALL}")
    at_start = energy_at_start(assembly)
    if at_start:
        terms.append(num(-at_start))
    return terms


def _dissipated_energies(
    assembly: Assembly, parts: Sequence[EnergyPart], columns: Mapping[str, str]
) -> list[str]:
    """Return the terms of the dissipated energy: contacts, guide, absorbing spheres, support."""
    terms = [EnergyColumn.DISSIPATED.of("c_contact"), *_on_walls(assembly, WallColumn.DISSIPATED)]
    for part in parts:
        if not part.is_stored:
            terms += _term_insum_of(assembly, part)
    names = ("holder", "absorbed", "support_lost")
    return terms + [columns[name] for name in names if name in columns]


def _energies_of_bars(assembly: Assembly) -> list[str]:
    """Return the commands of kinetic and elastic energy of bars, and contact with the chain."""
    lines = []
    for bar in assembly.bars:
        name = bar.name
        lines += [
            f"compute         on_{name} all gran/hysteretic/contact {bar.touches} {bar.face}",
            f"compute         bonds_{name} {name} bond/local engpot",
            f"compute         elastic_{name} {name} reduce sum c_bonds_{name} inputs local",
            f"compute         kinetic_{name} {name} ke",
            f"variable        energy_{name} equal c_kinetic_{name}+c_elastic_{name}",
        ]
    return lines


def thermo(case: Case, schedule: Schedule) -> list[str]:
    """Return the commands of thermodynamic output."""
    every = schedule.block_steps
    if not every:
        every = max(1, schedule.n_steps // schedule.ledger_every // _LINES) * schedule.ledger_every
    kinetic = "v_motion" if case.moves_otherwise else "c_kinetic"
    yielded = EnergyColumn.YIELDED.of("c_contact")
    columns = (kinetic, "v_elastic", "v_dissipated", yielded, "v_struck_velocity")
    return [
        "# Log.",
        f"thermo_style    custom step v_time {joined(columns)}",
        "thermo_modify   lost error norm no flush yes",
        f"thermo          {every}",
        "# These computes are not used, but would be evaluated whenever one of the fixes above is.",
        "uncompute       thermo_press",
        "uncompute       thermo_pe",
    ]
