"""Command ``granwave check``: what a run would be, its inputs, and the case that it compares with."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.case.overrides import apply_overrides, parse_overrides
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.toml_files import read_toml
from granwave.workflows import library
from granwave.workflows.cli.as_json import print_json
from granwave.workflows.cli.small_waves import small_waves
from granwave.workflows.cli.tables import continuum_plan_table, expected_cut, plan_table
from granwave.workflows.counterpart import (
    Counterpart,
    Inputs,
    continuum_of,
    inputs_of_continuum,
    inputs_of_packing,
    packing_of,
)
from granwave.workflows.solvers import CONTINUUM, GRANULAR, Cost, Kind, solver_of


def check(options: argparse.Namespace) -> int:
    """Plan a case and check that this machine can run it; return the exit status."""
    path = library.find_for(options.case, GRANULAR.verb, CONTINUUM.verb)
    kind = solver_of(read_toml(path))
    changes = parse_overrides(options.overrides)
    case = kind.read(apply_overrides(read_toml(path), changes), path, overridden=changes)
    expected = kind.cost(case, options.np, True)
    inputs = counterpart = None
    if kind is GRANULAR:
        inputs, counterpart = inputs_of_packing(case), continuum_of(case)
    elif kind is CONTINUUM:
        inputs, counterpart = inputs_of_continuum(case), packing_of(case)
    if options.json:
        kind.check(case, expected, Path(case.name).absolute())
        print_json(_values(kind, case, expected, inputs, counterpart))
        return 0
    if kind is GRANULAR:
        print(plan_table(case, expected, inputs, small_waves(case)))
    else:
        print(continuum_plan_table(case.name, kind.size(case), expected, inputs))
    if counterpart is not None:
        what = "continuum" if kind is GRANULAR else "packing"
        print(f"\n{what} of equal input: {counterpart.command or f'none, {counterpart.reason}'}")
    sys.stdout.flush()
    kind.check(case, expected, Path(case.name).absolute())
    if kind is GRANULAR and (warning := expected_cut(expected.zone)):
        print(f"granwave: warning: {case.name}: {warning}", file=sys.stderr)
    return 0


def _values(
    kind: Kind, case: Any, expected: Cost, inputs: Inputs | None, counterpart: Counterpart | None
) -> dict[str, Any]:
    """Return the values of the plan; units are part of the names."""
    found: dict[str, Any] = {"name": case.name, "command": kind.verb, f"n_{kind.parts}": kind.size(case)}
    if isinstance(expected, Plan):
        found |= _of_packing(expected)
    found |= {
        "memory_bytes": expected.memory,
        "disk_bytes": expected.disk,
        "wall_time_s": expected.wall_time,
    }
    if inputs is not None:
        found |= {
            "energy_input_J": inputs.energy,
            "energy_input_normalised": inputs.energy_continuum
            if inputs.energy_normalised is None
            else inputs.energy_normalised,
            "energy_input_over_sigma2_D3_E": inputs.energy_continuum,
            "velocity_normalised": inputs.velocity_normalised,
        }
    if counterpart is not None:
        found["counterpart"] = {"command": counterpart.command or None, "reason": counterpart.reason or None}
    warning = expected_cut(expected.zone) if isinstance(expected, Plan) else ""
    return found | {"warnings": [warning] if warning else []}


def _of_packing(expected: Plan) -> dict[str, Any]:
    """Return what only the plan of a packing has."""
    schedule, zone = expected.schedule, expected.zone
    return {
        "n_contacts": expected.n_contacts,
        "n_ranks": expected.n_ranks,
        "timestep_s": schedule.first_timestep,
        "timestep_largest_s": schedule.largest_timestep if schedule.adaptive else schedule.first_timestep,
        "n_steps": schedule.n_steps // schedule.first_step,
        "end_time_s": schedule.end_time,
        "ends_by_itself": bool(schedule.block_steps),
        "n_frames": schedule.n_frames,
        "wall_time_longest_s": expected.times.longest,
        "wall_time_parts_s": dataclasses.asdict(expected.times),
        "peak_overlap_m": expected.peak_overlap,
        "peak_overlap_over_yield": expected.peak_overlap_yield,
        "peak_overlap_over_radius": expected.peak_overlap_radius,
        "zone": None
        if zone is None
        else {
            "depth_m": zone.depth,
            "radius_m": zone.radius,
            "spread": zone.spread,
            "room_m": zone.room,
            "reaches": list(zone.reaches),
            "may_reach": list(zone.may_reach),
        },
    }
