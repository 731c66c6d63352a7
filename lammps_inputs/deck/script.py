"""The LAMMPS input script of a case.

It has three parts, separated by `RUN_MARKER` and `END_MARKER`: set-up, run, and output at the end.
A program that drives LAMMPS can execute the first part, run in a different way, and execute the
last part.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from itertools import product

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import INITIAL
from granwave.lammps_inputs.deck.commands import (
    PARTS,
    command,
    contacts,
    cylinder_commands,
    id_ranges,
    wall_commands,
)
from granwave.lammps_inputs.deck.dead_load import dead_load_commands
from granwave.lammps_inputs.deck.ledger import ledger, thermo
from granwave.lammps_inputs.deck.motion import CLUMPS, adaptive_timestep, motion
from granwave.lammps_inputs.deck.output import (
    dumps_at_end,
    frames,
    history,
    lines,
    probes,
    wall_forces,
)
from granwave.lammps_inputs.deck.static_stage import (
    first_half,
    second_half,
    stored_velocities,
)
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.clumps import largest_extent
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.packing.motion import written_in_parts
from granwave.lammps_inputs.planning.blocks import BLOCK_THRESHOLD
from granwave.lammps_inputs.planning.encounters import fastest
from granwave.lammps_inputs.planning.ranks import costs_of
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.lammps_inputs.run_directory import (
    BED_FILE,
    CASE_FILE,
    CHECKPOINT_FILE,
    DATA_FILE,
    DEAD_LOAD_FILE,
    DENTS_FILE,
    DUMPS,
    LOAD_FILE,
    LOG_FILE,
    MESH_FILE,
    MOST_PARTS,
    MOVED_WALLS_FILE,
    SCRIPT_FILE,
    START_FILE,
    STATIC_FILE,
)
from granwave.lammps_inputs.script_words import num

RUN_MARKER = "# --- run ---"
END_MARKER = "# --- end ---"
READ_DATA = f"read_data       {DATA_FILE}"

# words of commands that name files of a run
_NAMES = (
    BED_FILE,
    DATA_FILE,
    DENTS_FILE,
    LOAD_FILE,
    LOG_FILE,
    MESH_FILE,
    DEAD_LOAD_FILE,
    START_FILE,
    CHECKPOINT_FILE,
    f"{DUMPS}/{{}}",
)
_WORDS = "|".join(re.escape(name).replace(r"\{\}", r'[^\s"]+') for name in _NAMES)
_FILES = re.compile(rf"(?<!\S)(?:{_WORDS})(?!\S)")
_HARMFUL = re.compile(r"""[^ -~]|["&]""")  # not ASCII, or joins lines even in a comment
_OF_CLUMPS = "molecules"  # fix that holds the number of the clump of each grain
_SKIN = 0.1  # skin distance of the neighbour list, diameters
_MOST_STEPS_BETWEEN_CHECKS = 10
# distance between checks of the list at the highest speed, over the skin
_TRAVEL_BETWEEN_CHECKS = 0.01
_STEPS_BETWEEN_BALANCES = 500  # steps between balances of the box between ranks
_IMBALANCE = 1.1  # work of the busiest rank / mean, above which the box is divided again


def input_script(assembly: Assembly, schedule: Schedule, *, restart_from: str = "") -> str:
    """Return the text of in.granwave.

    Parameters
    ----------
    restart_from
        Restart file to resume from: system, fixes and outputs are the same, but the state is read
        from this file, there is no initial velocity, spin, dent or static stage, and output is
        appended.
    """
    case = assembly.case
    resumed = bool(restart_from)
    static = case.precompression is not None
    moved = ["# Walls moved to their target force.", f"include         {DUMPS}/{MOVED_WALLS_FILE}"]
    reference = [
        "# Reference values of the energy balance.",
        f"include         {DUMPS}/{STATIC_FILE}",
    ]
    dents = [
        "# Plastic indentations from before the run, of pairs of spheres and on walls.",
        f"gran/dents      read {DENTS_FILE}",
    ]
    bed = [
        "# Plastic indentations and springs of the settled bed.",
        f"gran/dents      read {BED_FILE}",
    ]
    parts = [
        _head(assembly),
        _files_of_dumps() if written_in_parts(assembly) else [],
        _system(assembly, restart_from),
        _neighbours(assembly, schedule),
        contacts(assembly),
        dead_load_commands(assembly) if static else [],
        stored_velocities(assembly) if static and not resumed else [],
        first_half(assembly) if static and not resumed else [],
        moved if resumed and case.precompression and case.precompression.presses else [],
        wall_commands(assembly),
        cylinder_commands(assembly, again=True),
        dents if case.contact.initial_overlap and not resumed else [],
        bed if case.packing.has_history and not resumed else [],
        [*([] if resumed else second_half(assembly)), *reference] if static else [],
        motion(assembly, schedule, resumed=resumed),
        ledger(assembly, schedule, resumed=resumed),
        wall_forces(assembly, schedule, resumed=resumed),
        probes(case, schedule, resumed=resumed),
        frames(assembly, schedule, restart_from=restart_from),
        history(case, schedule, resumed=resumed),
        lines(assembly, schedule, resumed=resumed),
        adaptive_timestep(case, schedule),
        thermo(case, schedule),
        _balance(assembly, schedule),
        _run(case, schedule),
        [END_MARKER, "", *dumps_at_end(assembly)],
    ]
    return "\n\n".join("\n".join(lines) for lines in parts if lines) + "\n"


def _head(assembly: Assembly) -> list[str]:
    case = assembly.case
    packing = case.packing
    size = " x ".join(str(n) for n in packing.size)
    called = assembly.grains_called
    load = case.load.sentence(len(case.striker))
    return [
        f"# {_HARMFUL.sub('?', case.name)}",
        f"# Impact on an ordered packing: {size} {called}, {packing.kind}, diameter {packing.diameter:g} m;",
        f"# {in_grains(load, called)}",
        f"# Written by granwave from {CASE_FILE}.",
        f"# Run it here:  lmp -in {SCRIPT_FILE}   (granwave provides the pair style "
        "gran/hysteretic)",
    ]


def _files_of_dumps() -> list[str]:
    """Return the number of files of a dump in parts, unless the variable was set before."""
    return [
        "# Files of each dump of snapshots and contacts.",
        f"variable        {PARTS} index {MOST_PARTS}",
    ]


def _system(assembly: Assembly, restart_from: str) -> list[str]:
    sides = "p p" if assembly.lattice.periodic else "m m"
    bars = assembly.bars
    touch = "adhere, at rest" if assembly.case.has_cohesion else "just touch"
    lines = []
    if bars:
        diameter = assembly.case.packing.diameter
        reach = (
            2 * max([diameter, assembly.sites.largest, *(bar.pitch for bar in bars)])
            + _SKIN * diameter
        )
        lines.append(
            "# Elastic bars: lumped masses, joined by springs E A / (length of an element)."
        )
        for kind, bar in enumerate(bars, start=1):
            lines.append(f"group           {bar.name} id {bar.first}:{bar.last}")
            lines.append(f"bond_coeff      {kind} {num(bar.stiffness / 2)} {num(bar.pitch)}")
        lines.append(f"comm_modify     cutoff {num(reach)}")  # cutoff of ghosts
    return [
        f"# Packing: spheres that {touch}. Both processors that share a pair compute it (newton "
        "off).",
        "units           si",
        f"atom_style      {'hybrid sphere bond' if bars else 'sphere'}",
        "atom_modify     map yes",
        "newton          off",
        f"boundary        {sides} m",
        *(["bond_style      harmonic"] if bars else []),
        *_spheres_from(assembly, restart_from),
        *lines,
    ]


def _spheres_from(assembly: Assembly, restart_from: str) -> list[str]:
    """Return the commands that read the spheres, the numbers of their clumps, and their initial
    positions.
    """
    spheres = f"read_restart    {restart_from}" if restart_from else READ_DATA
    if assembly.case.contact.normals == INITIAL:
        return [spheres, *_initial_places(resumed=bool(restart_from))]
    if not assembly.clumps:
        return [spheres]
    numbers = f"fix             {_OF_CLUMPS} all property/atom mol ghost yes"
    if restart_from:
        return [spheres, numbers]
    return [numbers, f"{spheres} fix {_OF_CLUMPS} NULL Molecules"]


def _initial_places(*, resumed: bool) -> list[str]:
    """Return the commands that store the initial positions of the spheres; a restart
    file has them.
    """
    lines = [
        "# Initial positions of the spheres: contact forces keep the directions between them.",
        "fix             initial all property/atom d2_initial 3 ghost yes",
    ]
    if resumed:
        return lines
    for column, axis in enumerate("xyz", start=1):
        lines.append(f"variable        initial_{axis} atom {axis}")
        lines.append(f"set             group all d2_initial[{column}] v_initial_{axis}")
        lines.append(f"variable        initial_{axis} delete")
    return lines


def _neighbours(assembly: Assembly, schedule: Schedule) -> list[str]:
    case = assembly.case
    skin = _SKIN * case.packing.diameter
    checks = int(_TRAVEL_BETWEEN_CHECKS * skin / (fastest(assembly) * schedule.largest_timestep))
    every = min(max(checks, 1), _MOST_STEPS_BETWEEN_CHECKS)
    nodes = [n for n, species in enumerate(assembly.species, start=1) if species.role == "node"]
    types = range(1, len(assembly.species) + 1)
    apart = {tuple(sorted(pair)) for pair in product(nodes, types)}
    return [
        "# Neighbour lists: the spheres hardly move, so rebuilds are rare.",
        f"neighbor        {num(skin)} bin",
        f"neigh_modify    delay 0 every {every} check yes",
        *(f"neigh_modify    exclude type {a} {b}" for a, b in sorted(apart)),
        *_clumps(assembly, skin),
    ]


def _clumps(assembly: Assembly, skin: float) -> list[str]:
    """Return the commands for the group of the grains of clumps, which do not press each other."""
    if not assembly.clumps:
        return []
    reach = largest_extent(assembly) + 2 * skin
    return [
        "# Clumps: grains of one molecule move as one rigid body, without contacts between them.",
        *command(f"group           {CLUMPS} id", *id_ranges(assembly.in_clumps).split()),
        f"neigh_modify    exclude molecule/intra {CLUMPS}",
        f"comm_modify     cutoff {num(reach)}",
    ]


def _balance(assembly: Assembly, schedule: Schedule) -> list[str]:
    """Return the commands that divide the box between ranks again as the wave grows."""
    if not assembly.case.run.balance:
        return []
    costs = costs_of(assembly)
    weight = round(costs.moving / costs.rest) - 1
    every = schedule.longest_step * math.ceil(_STEPS_BETWEEN_BALANCES / schedule.longest_step)
    return [
        "# Ranks: a moving sphere has the weight of several at rest, by the time of a step.",
        f"variable        activity atom 1+{weight}*(vx*vx+vy*vy+vz*vz>0.0)",
        "comm_style      tiled",
        f"fix             balance all balance {every} {num(_IMBALANCE)} rcb weight var activity",
    ]


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
        f"# the run ends after the first block that adds less than {BLOCK_THRESHOLD:g} of the "
        "input to dissipation.",
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


def with_absolute_files(commands: str, directory: str) -> str:
    """Return commands that use the files of a run in ``directory``, whatever the working directory
    of LAMMPS is.

    Parameters
    ----------
    directory
        Absolute path without double quotes; empty: the commands stay as they are.
    """
    if not directory:
        return commands
    return _FILES.sub(lambda name: f'"{directory}/{name[0]}"', commands)


def part(script: str, which: str) -> str:
    """Return one part of a script: "setup" (before the run), "run" or "end".

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
