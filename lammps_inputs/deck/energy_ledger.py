"""Energy ledger and the log: energies, J, whose sum must stay equal to the input."""

from __future__ import annotations

from typing import TYPE_CHECKING

from granwave.lammps_inputs.deck.columns import (
    ABSORBED,
    FREE_PLATE,
    HOLDER,
    LEDGER,
    ROTATION,
    SUPPORT,
    TANGENTIAL,
    TIMESTEP,
    VISCOUS,
    names,
    sources,
)
from granwave.lammps_inputs.deck.commands import num, time_series
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import PLATE, moving_fix, wall_fixes, walls
from granwave.lammps_inputs.run_directory import ENERGY_FILE

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.packing.bars import PlacedBar
    from granwave.lammps_inputs.planning.schedule import Schedule

POTENTIAL = "c_potential"  # potential energy of dead loads, zero at the positions of the data file
STATIC = "v_static"  # elastic and potential energy at the start of the run


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
        *time_series("ledger", schedule.ledger_every, ENERGY_FILE, "energy ledger, SI units", columns, resumed),
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
