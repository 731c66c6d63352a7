"""The LAMMPS input script of a case.

Three parts, parted by `RUN_MARKER` and `END_MARKER`: everything up to the run, the run itself, and what is
written at its end. A program that drives LAMMPS can execute the first part, run as it likes, and execute the
last.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from granwave.lammps_inputs.assembly import INCIDENT_BAR, struck_of, velocities_of
from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.schedule import BLOCK_THRESHOLD, Schedule
from granwave.lammps_inputs.script_output import dumps_at_end, frames, history, ledger, probes, thermo, wall_forces
from granwave.lammps_inputs.script_text import joined, law_coefficients, num
from granwave.lammps_inputs.sections import Contact
from granwave.lammps_inputs.timestep import fastest
from granwave.lammps_inputs.walls import wall_fixes, walls

LOAD_FILE = "load.txt"  # beside the deck: points of a load given as a table

RUN_MARKER = "# --- run ---"
END_MARKER = "# --- end ---"

_HARMFUL = re.compile(r"""[^ -~]|["&]""")  # would join lines even in a comment
_SKIN = 0.1  # of the neighbour list, in diameters
_MOST_STEPS_BETWEEN_CHECKS = 10
_TRAVEL_BETWEEN_CHECKS = 0.01  # of the skin, at the impact velocity


def input_script(case: Case, schedule: Schedule) -> str:
    """The text of in.granwave."""
    parts = [
        _head(case),
        _system(case),
        _neighbours(case, schedule),
        _contact(case),
        _walls(case),
        _motion(case, schedule),
        ledger(case, schedule),
        wall_forces(case, schedule),
        probes(case, schedule),
        frames(schedule),
        history(case, schedule),
        thermo(schedule),
        _run(case, schedule),
        [END_MARKER, "", *dumps_at_end(case)],
    ]
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _head(case: Case) -> list[str]:
    packing, load = case.packing, case.load
    size = " x ".join(str(n) for n in packing.size)
    what = f"{load.spheres} sphere{'s' if load.spheres > 1 else ''} of the top layer"
    how = {
        "impact": f"{what} struck at {load.velocity:g} m/s along +z.",
        "striker": f"struck by {len(case.striker)} sphere{'s' if len(case.striker) > 1 else ''} placed against it.",
        "force": f"{load.shape} force, at most {load.largest:g} N, along +z.",
        "displacement": f"{what} moved by a {load.shape} displacement, at most {load.largest:g} m, along z.",
    }
    return [
        f"# {_HARMFUL.sub('?', case.name)}",
        f"# Impact on an ordered packing: {size} spheres, {packing.kind}, diameter {packing.diameter:g} m;",
        f"# {how[load.kind]}",
        "# Written by granwave from case.toml.",
        "# Run it here:  lmp -in in.granwave   (the pair style gran/hysteretic comes with granwave)",
    ]


def _system(case: Case) -> list[str]:
    sides = "p p" if case.lattice.periodic else "m m"
    bars = case.assembly.bars
    return [
        "# The packing: spheres that just touch. Both processors that share a pair compute it (newton off).",
        "units           si",
        f"atom_style      {'hybrid sphere bond' if bars else 'sphere'}",
        "atom_modify     map yes",
        "newton          off",
        f"boundary        {sides} m",
        *(["bond_style      harmonic"] if bars else []),
        "read_data       data.granwave",
        *_bars(case),
    ]


def _bars(case: Case) -> list[str]:
    """Groups and springs of elastic bars: linear elements between lumped masses."""
    lines, bars = [], case.assembly.bars
    largest = max([case.packing.diameter, *case.assembly.diameters.values()])
    reach = 2 * max([largest, *(bar.pitch for bar in bars)]) + _SKIN * case.packing.diameter  # of ghosts
    for kind, bar in enumerate(bars, start=1):
        lines.append(f"group           {bar.name} id {bar.first}:{bar.last}")
        lines.append(f"bond_coeff      {kind} {num(bar.stiffness / 2)} {num(bar.pitch)}")
    if lines:
        lines.append(f"comm_modify     cutoff {num(reach)}")
    return ["# Elastic bars: lumped masses, joined by springs E A / (length of an element).", *lines] if lines else []


def _neighbours(case: Case, schedule: Schedule) -> list[str]:
    skin = _SKIN * case.packing.diameter
    checks = int(_TRAVEL_BETWEEN_CHECKS * skin / (fastest(case) * schedule.timestep))
    every = min(max(checks, 1), _MOST_STEPS_BETWEEN_CHECKS)
    kinds = case.assembly.species
    nodes = [n for n, species in enumerate(kinds, start=1) if species.role == "node"]
    apart = {tuple(sorted((node, other))) for node in nodes for other in range(1, len(kinds) + 1)}
    return [
        "# Neighbours: the spheres hardly move, so the lists last.",
        f"neighbor        {num(skin)} bin",
        f"neigh_modify    delay 0 every {every} check yes",
        *(f"neigh_modify    exclude type {a} {b}" for a, b in sorted(apart)),
    ]


def _contact(case: Case) -> list[str]:
    gap = case.boundary.forget_gap * case.packing.diameter
    return [
        f"# Contact: {case.contact.law}; a dent is forgotten beyond the gap given here, m.",
        f"pair_style      gran/hysteretic {num(gap)}",
        *_pair_coefficients(case),
    ]


def _pair_coefficients(case: Case) -> list[str]:
    lines = []
    kinds = list(enumerate(case.assembly.species, start=1))
    for i, first in kinds:
        for j, second in kinds[i - 1 :]:
            if first.role == "sphere":
                law = law_coefficients(case.contact, first.material, None if i == j else second.material)
            else:  # parts of bars never meet
                law = law_coefficients(Contact(law="hertz"), first.material, None if i == j else second.material)
            lines.append(f"pair_coeff      {i} {j} {law}")
    return lines


def _walls(case: Case) -> list[str]:
    lines = []
    planes = [wall for wall in walls(case) if not wall.held_layer]
    groups = [group for wall in planes[-1:] for _, group, _ in wall_fixes(case, wall) if group != "all"]
    n, n_all = case.lattice.n_spheres, case.assembly.n_spheres
    outside = ["group           strikers id " + f"{n + 1}:{n_all}"] if groups and n_all > n else []
    for number, group in enumerate(groups, start=1):
        if outside:
            lines.append(f"group           type{number} type {number}")
            lines.append(f"group           {group} subtract type{number} strikers")
        else:
            lines.append(f"group           {group} type {number}")
    lines = outside + lines
    for wall in walls(case):
        if wall.held_layer:
            nx, ny, nz = case.lattice.shape
            last = nx * ny * nz
            lines.append(f"group           held id {last - nx * ny + 1}:{last}")
            lines.append("fix             held held setforce 0.0 0.0 0.0")
        else:
            low, high = ("NULL", num(wall.coordinate)) if wall.outward > 0 else (num(wall.coordinate), "NULL")
            style = f"{'xyz'[wall.axis]}plane {low} {high}"
            for name, group, material in wall_fixes(case, wall):
                law = law_coefficients(case.contact, material, wall.material)
                lines.append(f"fix             {name} {group} wall/gran/hysteretic {style} {law}")
    return (
        ["# Walls: planes that touch the outermost spheres, or the last layer held in place.", *lines] if lines else []
    )


def _motion(case: Case, schedule: Schedule) -> list[str]:
    struck = struck_of(case)
    lines = [
        "# Motion: velocity Verlet (the contacts are frictionless, so nothing rotates), and what drives it.",
        f"timestep        {num(schedule.timestep)}",
        f"group           struck id {struck[0] if struck else 1}",
        f"group           hit id {joined(struck)}" if struck else "group           hit empty",
    ]
    still = []
    if any(wall.held_layer for wall in walls(case)):
        still.append("held")
    if case.load.kind == "displacement":
        still.append("hit")
    if still:
        lines.append(f"group           mobile subtract all {joined(still)}")
    lines.append(f"fix             motion {'mobile' if still else 'all'} nve")
    lines += _velocities(case)
    if case.load.driven:
        lines += _drive(case)
        lines.append("variable        input equal v_given+f_load")
    else:
        lines.append("variable        input equal v_given")
    return lines


def _velocities(case: Case) -> list[str]:
    """Initial velocities, and the kinetic energy that they are."""
    lines: list[str] = []
    terms: list[str] = []
    for sphere, velocity in velocities_of(case).items():
        group = "hit"  # all of these have one velocity
        if sphere > case.lattice.n_spheres:
            group = f"striker{sphere - case.lattice.n_spheres}"
            lines.append(f"group           {group} id {sphere}")
        elif terms:
            continue
        components = joined(num(component) if component else "0.0" for component in velocity)
        lines.append(f"velocity        {group} set {components} units box")
        square = "+".join(f"{num(component)}^2" for component in velocity if component)
        terms.append(f"0.5*mass({group})*({square})")
    given = f"$({'+'.join(terms)}:%.17g)" if terms else "0.0"
    return [*lines, f"variable        given equal {given}"]


def _drive(case: Case) -> list[str]:
    """The force, or the displacement, on the struck spheres or on the free end of the incident bar."""
    load, group, lines = case.load, "hit", []
    for bar in case.assembly.bars:
        if bar.name == INCIDENT_BAR:
            group = "driven"
            lines.append(f"group           driven id {bar.far}")
    shape = {
        "half-sine": (load.amplitude, load.duration),
        "rectangle": (load.amplitude, load.duration),
        "harmonic": (load.amplitude, load.frequency),
    }.get(load.shape or "", ())
    words = joined(num(value) for value in shape if value is not None) or LOAD_FILE
    return [*lines, f"fix             load {group} gran/load z {load.kind} {load.shape} {words}"]


def _run(case: Case, schedule: Schedule) -> list[str]:
    if not schedule.block_steps:
        return [RUN_MARKER, "", f"run             {schedule.n_steps}"]
    n_blocks = schedule.n_steps // schedule.block_steps
    small = f"$({BLOCK_THRESHOLD:g}*v_input:%.17g)"
    over = f" && $(v_time:%.17g) >= {num(case.load.lasts)}" if case.load.driven else ""
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
        f'if "$(v_after-v_before:%.17g) < {small}{over}" then "jump SELF finished"',
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
