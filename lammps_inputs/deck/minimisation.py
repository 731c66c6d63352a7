"""Minimisation of a static stage (FIRE), and walls that move in until they carry their forces."""

from __future__ import annotations

from itertools import chain

import numpy as np

from granwave.lammps_inputs.contact.static_load import force_of_contact, static_stiffness
from granwave.lammps_inputs.deck.commands import moved_wall, wall_commands
from granwave.lammps_inputs.deck.output import outward_force
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.disorder import has_gaps
from granwave.lammps_inputs.packing.walls import pressed_walls
from granwave.lammps_inputs.run_directory import DUMPS, MOVED_WALLS_FILE
from granwave.lammps_inputs.script_words import num

MOST_ITERATIONS = 200_000
# largest contact force / expected one, below which the grains no longer carry the load
LOST_LOAD = 1e-3
WALL_PREFIX = "static_"  # prefix of the wall fixes of the stage

_TOLERANCE = 1e-9  # net force on a sphere at convergence / mean contact force
# With disorder or dents it takes tens of thousands of iterations, and single contacts may carry
# many times the mean:
_TOLERANCE_OF_DISORDER = 3e-7  # the same / largest contact force of the first half
_FIRST_HALF = 1e-5  # the same / mean contact force, in the first half
_ROUNDING = 8.0  # net force by rounding over stiffness times the rounding error of a coordinate
# rounds in which walls move to a force; the secant method doubles the digits in two rounds
_ROUNDS = 8
# lower bound of the slope of force^(2/3) over the slope of the line through the start; limits the
# next distance
_FLATTEST = 0.1


def may_lose_its_load(assembly: Assembly) -> bool:
    """Return True if the initial overlaps are the only load: grains that are free to separate lose
    it, and contacts with nearly zero force have nearly zero stiffness.

    Forces are then compared with the initial forces.
    """
    stage = assembly.case.precompression
    return stage is not None and stage.is_overlaps_alone


def minimise(assembly: Assembly, *, first: bool = False) -> str:
    """Return the command that finds equilibrium, up to a net force that is a fraction of contact
    forces, plus rounding.
    """
    case = assembly.case
    of_file = case.packing.contact_way is not None
    disordered = has_gaps(case) or of_file
    mean = force_of_contact(assembly)
    span = float(np.abs(assembly.bounds() - assembly.deck_origin).max())
    rounding = float(
        _ROUNDING * static_stiffness(assembly) * np.finfo(float).eps * span
    )  # rounding error of coordinates
    if may_lose_its_load(assembly):
        return _minimise_to(num(float(f"{_TOLERANCE_OF_DISORDER * mean + rounding:.3g}")))
    least = num(float(f"{(_FIRST_HALF if disordered else _TOLERANCE) * mean + rounding:.3g}"))
    if disordered and not first:
        none = f"<{num(LOST_LOAD * mean)}" if of_file else "==0"
        largest = f"(v_static_force+(v_static_force{none})*{num(mean)})"
        least = f"$({num(_TOLERANCE_OF_DISORDER)}*{largest}+{num(float(f'{rounding:.3g}'))})"
    return _minimise_to(least)


def _minimise_to(least: str) -> str:
    """Return the command that ends when no net force is larger than ``least``, N."""
    return f"minimize        0.0 {least} {MOST_ITERATIONS} {2 * MOST_ITERATIONS}"


def press_walls(assembly: Assembly) -> list[str]:
    """Return the commands that move walls inwards iteratively until they carry their forces.

    The power 2/3 of the force is about linear in the distance: a secant gives the next distance, or
    in the first round a line through the start.
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
            force = "+".join(f"({outward_force(wall, WALL_PREFIX)})" for wall in pressed)
            share = f"abs({force})/{num(len(pressed) * stage.presses[name])}"
            if number:
                lines.append(f"variable        static_before_{name} equal $(v_{level}:%.17g)")
            lines.append(f"variable        {level} equal $(({share})^(2/3):%.17g)")
            slope = f"v_{level}/{here}"
            if number:
                rise = f"v_{level}-v_static_before_{name}"
                run = f"{here}-v_static_from_{name}"
                slope = f"(({rise})/(({run})+(({run})==0)))"
            taken = f"static_slope_{name}"
            least = f"{_FLATTEST}/{here}"
            bounded = f"ternary(v_{taken}>{least},v_{taken},{least})"
            lines += [
                f"variable        {taken} equal $({slope}:%.17g)",
                f"variable        {taken} equal $({bounded}:%.17g)",
                f"variable        static_from_{name} equal $({here}:%.17g)",
                f"variable        {moved_wall(name)} equal $({here}+(1-v_{level})/v_{taken}:%.17g)",
            ]
        moved = list(chain.from_iterable(pressed_walls(assembly).values()))
        lines += wall_commands(assembly, elastic=True, prefix=WALL_PREFIX, only=moved)
        lines.append(minimise(assembly, first=True))
    found = "\n".join(
        f"variable {moved_wall(name)} equal $(v_{moved_wall(name)}:%.17g)" for name in stage.presses
    )
    return [*lines, f'print           """{found}""" file {DUMPS}/{MOVED_WALLS_FILE} screen no']
