"""Command ``granwave check``: what a run would be, its inputs, and the case that it compares with."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.case.parse import apply_overrides, parse_overrides
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows import library
from granwave.workflows.cli.as_json import print_json
from granwave.workflows.cli.plan_values import packing_values
from granwave.workflows.cli.small_waves import SmallWaves, small_waves, wave_rows, wave_values
from granwave.workflows.cli.tables import continuum_plan_table, expected_cut, is_bound, plan_table
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
    waves = small_waves(case) if kind is GRANULAR else None
    if options.json:
        kind.check(case, expected, Path(case.name).absolute())
        print_json(_values(kind, case, expected, inputs, counterpart, waves))
        return 0
    if kind is GRANULAR:
        print(plan_table(case, expected, inputs, wave_rows(waves)))
    else:
        print(continuum_plan_table(case.name, kind.size(case), expected, inputs))
    if counterpart is not None:
        what = "continuum" if kind is GRANULAR else "packing"
        print(f"\n{what} of equal input: {counterpart.command or f'none, {counterpart.reason}'}")
    sys.stdout.flush()
    kind.check(case, expected, Path(case.name).absolute())
    for warning in _warnings(expected):
        print(f"granwave: warning: {case.name}: {warning}", file=sys.stderr)
    return 0


def _warnings(expected: Cost) -> list[str]:
    """Return what to think of before this run."""
    if not isinstance(expected, Plan):
        return []
    slow = f"the run takes about {duration(expected.wall_time)}: {expected.slowness}" if expected.slowness else ""
    return [one for one in (slow, expected_cut(expected.zone)) if one]


def _values(
    kind: Kind,
    case: Any,
    expected: Cost,
    inputs: Inputs | None,
    counterpart: Counterpart | None,
    waves: SmallWaves | None,
) -> dict[str, Any]:
    """Return the values of the plan; units are part of the names."""
    found: dict[str, Any] = {"name": case.name, "command": kind.verb, f"n_{kind.parts}": kind.size(case)}
    if isinstance(expected, Plan):
        found |= packing_values(case, expected) | {"small_waves": wave_values(waves)}
    found |= {
        "memory_bytes": expected.memory,
        "disk_bytes": expected.disk,
        "wall_time_s": expected.wall_time,
    }
    if inputs is not None:
        found |= {
            "energy_input_J": inputs.energy,
            "energy_input_at_most": kind is GRANULAR and is_bound(case),
            "energy_input_normalised": inputs.energy_continuum
            if inputs.energy_normalised is None
            else inputs.energy_normalised,
            "energy_input_over_sigma2_D3_E": inputs.energy_continuum,
            "velocity_normalised": inputs.velocity_normalised,
        }
    if counterpart is not None:
        found["counterpart"] = {"command": counterpart.command or None, "reason": counterpart.reason or None}
    return found | {"warnings": _warnings(expected)}
