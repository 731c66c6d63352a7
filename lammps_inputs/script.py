"""The LAMMPS input script of a case.

Three parts, parted by `RUN_MARKER` and `END_MARKER`: everything up to the run, the run itself, and what is
written at its end. A program that drives LAMMPS can execute the first part, run as it likes, and execute the
last.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.schedule import BLOCK_THRESHOLD, Schedule
from granwave.lammps_inputs.script_output import dumps_at_end, frames, ledger, probes, thermo, wall_forces
from granwave.lammps_inputs.script_text import joined, law_coefficients, num
from granwave.lammps_inputs.walls import walls

RUN_MARKER = "# --- run ---"
END_MARKER = "# --- end ---"

_HARMFUL = re.compile(r"""[^ -~]|["&]""")  # would join lines even in a comment
_SKIN = 0.1  # of the neighbour list, in diameters
_MOST_STEPS_BETWEEN_CHECKS = 10
_TRAVEL_BETWEEN_CHECKS = 0.01  # of the skin, at the impact velocity


def input_script(case: Case, schedule: Schedule, struck: tuple[int, ...]) -> str:
    """The text of in.granwave.

    Parameters
    ----------
    struck
        Ids of the spheres that get the velocity, the struck sphere first.
    """
    parts = [
        _head(case),
        _system(case),
        _neighbours(case, schedule),
        _contact(case),
        _walls(case),
        _motion(case, schedule, struck),
        ledger(case, schedule),
        wall_forces(case, schedule),
        probes(case, schedule),
        frames(schedule),
        thermo(schedule),
        _run(schedule),
        [END_MARKER, "", *dumps_at_end(case)],
    ]
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _head(case: Case) -> list[str]:
    packing = case.packing
    size = " x ".join(str(n) for n in packing.size)
    what = f"{case.load.spheres} sphere{'s' if case.load.spheres > 1 else ''}"
    return [
        f"# {_HARMFUL.sub('?', case.name)}",
        f"# Impact on an ordered packing: {size} spheres, {packing.kind}, diameter {packing.diameter:g} m;",
        f"# {what} of the top layer struck at {case.load.velocity:g} m/s along +z.",
        "# Written by granwave from case.toml.",
        "# Run it here:  lmp -in in.granwave   (the pair style gran/hysteretic comes with granwave)",
    ]


def _system(case: Case) -> list[str]:
    sides = "p p" if case.lattice.periodic else "m m"
    return [
        "# The packing: spheres that just touch. Both processors that share a pair compute it (newton off).",
        "units           si",
        "atom_style      sphere",
        "atom_modify     map yes",
        "newton          off",
        f"boundary        {sides} m",
        "read_data       data.granwave",
    ]


def _neighbours(case: Case, schedule: Schedule) -> list[str]:
    skin = _SKIN * case.packing.diameter
    checks = int(_TRAVEL_BETWEEN_CHECKS * skin / (case.load.velocity * schedule.timestep))
    every = min(max(checks, 1), _MOST_STEPS_BETWEEN_CHECKS)
    return [
        "# Neighbours: the spheres hardly move, so the lists last.",
        f"neighbor        {num(skin)} bin",
        f"neigh_modify    delay 0 every {every} check yes",
    ]


def _contact(case: Case) -> list[str]:
    gap = case.boundary.forget_gap * case.packing.diameter
    return [
        f"# Contact: {case.contact.law}; a dent is forgotten beyond the gap given here, m.",
        f"pair_style      gran/hysteretic {num(gap)}",
        f"pair_coeff      1 1 {law_coefficients(case)}",
    ]


def _walls(case: Case) -> list[str]:
    lines = []
    for wall in walls(case):
        if wall.held_layer:
            nx, ny, nz = case.lattice.shape
            last = nx * ny * nz
            lines.append(f"group           held id {last - nx * ny + 1}:{last}")
            lines.append("fix             held held setforce 0.0 0.0 0.0")
        else:
            low, high = ("NULL", num(wall.coordinate)) if wall.outward > 0 else (num(wall.coordinate), "NULL")
            style = f"{'xyz'[wall.axis]}plane {low} {high}"
            lines.append(f"fix             {wall.name} all wall/gran/hysteretic {style} {law_coefficients(case)}")
    return (
        ["# Walls: rigid planes that touch the outermost spheres, or the last layer held in place.", *lines]
        if lines
        else []
    )


def _motion(case: Case, schedule: Schedule, struck: tuple[int, ...]) -> list[str]:
    held = any(wall.held_layer for wall in walls(case))
    velocity = num(case.load.velocity)
    return [
        "# Motion: velocity Verlet (the contacts are frictionless, so nothing rotates), and the impact.",
        *(["group           mobile subtract all held"] if held else []),
        f"fix             motion {'mobile' if held else 'all'} nve",
        f"timestep        {num(schedule.timestep)}",
        f"group           struck id {struck[0]}",
        f"group           hit id {joined(struck)}",
        f"velocity        hit set 0.0 0.0 {velocity} units box",
        f"variable        input equal $(0.5*mass(hit)*{velocity}^2:%.17g)",
    ]


def _run(schedule: Schedule) -> list[str]:
    if not schedule.block_steps:
        return [RUN_MARKER, "", f"run             {schedule.n_steps}"]
    n_blocks = schedule.n_steps // schedule.block_steps
    return [
        RUN_MARKER,
        "",
        f"# Blocks of {schedule.block_steps} steps, at most {n_blocks};",
        f"# the last is the first that adds less than {BLOCK_THRESHOLD:g} of the input to dissipation.",
        "variable        before equal 0.0",
        f"variable        block loop {n_blocks}",
        "label           next_block",
        f"run             {schedule.block_steps}",
        "variable        after equal $(v_dissipated:%.17g)",
        f'if "$(v_after-v_before:%.17g) < $({BLOCK_THRESHOLD:g}*v_input:%.17g)" then "jump SELF finished"',
        "variable        before equal ${after}",
        "next            block",
        "jump            SELF next_block",
        "label           finished",
    ]


def part(script: str, which: str) -> str:
    """One part of a script: "setup" (before the run), "run" or "end".

    Raises
    ------
    ValueError
        The script lacks a marker, or there is no such part.
    """
    names: Iterable[str] = ("setup", "run", "end")
    if which not in names:
        raise ValueError(f'found "{which}", expected one of {", ".join(names)}')
    setup, run_marker, rest = script.partition(f"\n{RUN_MARKER}\n")
    run, end_marker, end = rest.partition(f"\n{END_MARKER}\n")
    if not (run_marker and end_marker):
        raise ValueError(f"the script lacks the line {RUN_MARKER!r} or {END_MARKER!r}")
    return {"setup": setup, "run": run, "end": end}[which] + "\n"
