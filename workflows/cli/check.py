"""Command ``granwave check``: what a run would be, its inputs, and the case that it compares with, as a table."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.summary_table import lines
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.cylinders import GRAINS
from granwave.lammps_inputs.planning.cost import ExpectedZone, WallTime
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.planning.schedule import Schedule
from granwave.workflows import library
from granwave.workflows.cli.plan_values import packing_values, small_waves, wave_rows
from granwave.workflows.cli.terminal import print_json, warn
from granwave.workflows.counterpart import (
    Counterpart,
    Inputs,
    continuum_of,
    inputs_of_continuum,
    inputs_of_packing,
    packing_of,
)
from granwave.workflows.solvers import CONTINUUM, GRANULAR, Cost, Kind, solver_of

_LOSSES = {"time_s": "time {:.4g} s", "dashpot": "dashpot {:.4g}"}


def check(options: argparse.Namespace) -> int:
    """Plan a case and check that this machine can run it; return the exit status."""
    path = library.find_for(options.case, GRANULAR.verb, CONTINUUM.verb, library.DESIGN)
    if library.verb_of(path) == library.DESIGN:
        from granwave.workflows.cli.design import plan_of_design  # loads SciPy, which takes longer than most checks

        return plan_of_design(path, options)
    kind = solver_of(read_toml(path))
    case = kind.load(path, options.overrides)
    expected = kind.cost(case, options.ranks, True)
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
        warn(f"{case.name}: {warning}")
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
    waves: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """Return the values of the plan; units are part of the names."""
    found: dict[str, Any] = {"name": case.name, "command": kind.verb, f"n_{kind.parts}": kind.size(case)}
    if isinstance(expected, Plan):
        found |= packing_values(case, expected) | {"small_waves": waves}
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


def plan_table(case: Case, plan: Plan, inputs: Inputs | None = None, waves: Sequence[tuple[str, str]] = ()) -> str:
    """Return the table of a planned run; ``waves`` are rows on small waves."""
    schedule, times, values = plan.schedule, plan.times, packing_values(case, plan)
    usual, most = duration(times.total), duration(times.longest)
    at_most = "at most " if schedule.block_steps else ""
    held, loss = values["held_by_first_rank"], values["loss"] or {}
    overlap = f"{plan.peak_overlap:.3g} m, {plan.peak_overlap_radius:.3g} R*"
    if plan.peak_overlap_yield is not None:
        overlap += f", {plan.peak_overlap_yield:.3g} of that at first yield"
    if values["peak_overlap_beyond_law"]:
        overlap += " - beyond 0.2 R*, where the contact law ends"
    return lines(
        [
            ("case", plan.name),
            _grains(case, plan),
            ("contacts at the start", f"{plan.n_contacts}"),
            *_size(values),
            *_coordination(values),
            *_static(case),
            *waves,
            *_inputs(inputs, at_most="at most " * is_bound(case)),
            ("memory", _memory(plan)),
            ("disk", f"about {plan.disk / 1e9:.3g} GB"),
            ("timestep", _timestep(schedule)),
            *(
                [("", f"set by {plan.limit.cause}; a contact alone would allow {plan.allowed:.2g} s")]
                if plan.limit
                else []
            ),
            ("steps", f"{at_most}{_steps(schedule)}, to {schedule.end_time:.4g} s"),
            ("snapshots", f"{at_most}{schedule.n_frames}"),
            ("expected time", f"about {usual}: {_parts(times)}"),
            *([("", f"at most {most}")] if schedule.block_steps and most != usual else []),
            *([("static stage", static_stage_note([times]))] if times.most_static > times.static else []),
            *([("output", "a file from each rank (output.parts)")] if values["output_in_parts"] else []),
            *([("held by the first rank", f"all sites at once, for {' and '.join(held)}")] if held else []),
            ("largest overlap", f"up to {overlap}"),
            *(
                ("loss", f"{name.removesuffix('_s')} {size:.4g}{' s' * (name == 'time_s')}")
                for name, size in loss.items()
            ),
            *([("outermost yield", _expected(plan.zone))] if plan.zone else []),
            *(("no peak reduction", reason) for reason in values["nulls"].values()),
        ]
    )


def _inputs(inputs: Inputs | None, at_most: str = "") -> list[tuple[str, str]]:
    """Rows of energy and velocity, as far as they apply."""
    if inputs is None or not inputs.energy:
        return []
    found = [
        (inputs.energy_normalised, "F_y alpha_y of a contact"),
        (inputs.energy_continuum, "sigma_y^2 D^3/E, as in the continuum"),
    ]
    rows = [("energy in", f"{at_most}{inputs.energy:.6g} J")]
    for value, unit in found:
        if value is not None:
            rows.append(("energy normalised" * (len(rows) == 1), f"{at_most}{value:.6g} {unit}"))
    if inputs.velocity_normalised is not None:
        rows.append(("velocity normalised", f"{inputs.velocity_normalised:.6g}"))
    return rows


def _size(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return mass and extent of the packing, and what the load hits."""
    struck, across = values["struck"], " and ".join(f"{width:.4g}" for width in values["packing_width_m"])
    size = f"{values['packing_mass_kg']:.4g} kg, {values['packing_height_m']:.4g} m high, {across} m wide"
    rows = [("packing", size)]
    if struck is not None:
        aside = f"{struck['aside_m']:.3g} m beside the middle of the top" if struck["aside_m"] else ""
        below = f"{struck['below_m']:.3g} m below the top" if struck["below_m"] else ""
        rows.append(("struck", ", ".join(filter(None, [f"sphere {struck['sphere']}", struck["where"], aside, below]))))
    return rows


def is_bound(case: Case) -> bool:
    """Return True if the energy input of a plan is an upper bound."""
    return case.load.kind == "force"


def _coordination(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return the contacts of a grain that were found in a file of grains or a plane crystal."""
    found = values["coordination"]
    if found is None:
        return []
    parts = ", ".join(f"{number} on {n} grain{'s' * (n > 1)}" for number, n in found["grains"].items())
    return [("contacts of a grain", f"{found['mean']:.3g} in the mean: {parts}")]


def _grains(case: Case, plan: Plan) -> tuple[str, str]:
    """Return what the grains are called, and their number; by shapes where there are several."""
    assembly = assemble(case)
    if assembly.grains_called != GRAINS:
        return assembly.grains_called, f"{plan.n_spheres}"
    cylinders = assembly.n_cylinders
    return GRAINS, f"{plan.n_spheres}: {plan.n_spheres - cylinders} spheres and {cylinders} cylinders"


def _static(case: Case) -> list[tuple[str, str]]:
    """Return the load before the impact."""
    stage = case.precompression
    if stage is None:
        return []
    parts = [f"{_wall(name)} by {length:.4g} m" for name, length in stage.moves.items()]
    parts += [f"{_wall(name)} to {force:.4g} N" for name, force in stage.presses.items()]
    if stage.pressure is not None:
        parts.append(f"{stage.pressure:.4g} Pa on the free faces")
    if stage.force is not None:
        parts.append(f"{stage.force:.4g} N on each grain of the top")
    if stage.kind == "gravity":
        parts.append(f"weight at {stage.acceleration:.4g} m/s^2")
    if stage.takes_overlaps:
        parts.append("overlaps at the start press")
    return [("precompression", "; ".join(parts))] if parts else []


def _wall(name: str) -> str:
    return "the tube shrinks" if name == "tube" else f"the walls across {name} move in"


def _memory(plan: Plan) -> str:
    text = f"about {plan.memory / 2**30:.2f} GiB"
    if plan.n_ranks == 1:
        return text
    first, other = plan.space.first_rank / 2**30, plan.space.other_rank / 2**30
    return f"{text}: first rank, which makes the analysis, {first:.2f}, each other {other:.2f}"


def _timestep(schedule: Schedule) -> str:
    if not schedule.adaptive:
        return f"{schedule.timestep:.4g} s"
    tolerance = f"energy balance to {schedule.energy_tolerance:g} of the input"
    return f"{schedule.first_timestep:.4g} s at first, {schedule.largest_timestep:.4g} s at most: {tolerance}"


def _steps(schedule: Schedule) -> str:
    """Number of steps; of an automatic timestep if all were as long as the first."""
    if not schedule.adaptive:
        return f"{schedule.n_steps}"
    return f"{schedule.n_steps // schedule.first_step} if all were as long as the first"


def _expected(zone: ExpectedZone) -> str:
    """Estimate of the outermost yield."""
    if "sides" not in zone.room and zone.reaches:
        return "the whole chain"
    within = f", within a factor of {zone.spread:g}" if zone.spread > 1 else " or deeper"
    radius = f", radius {zone.radius:.2g} m" if zone.radius else ""
    larger = f"about {zone.depth:.2g} m deep{radius}{within}"
    if not zone.reaches:
        return larger
    return f"to the {' and the '.join(zone.reaches)} of the packing; in a larger one {larger}"


def expected_cut(zone: ExpectedZone | None) -> str:
    """Warning that a packing will cut the plastic zone; empty where it has room, and for chains.

    In a chain the pulse goes from end to end, whatever its length.
    """
    if zone is None or "sides" not in zone.room:
        return ""
    found = [(zone.reaches, "is expected to reach"), (zone.may_reach, "may reach")]
    parts = [f"{verb} {' and '.join(_bound(zone, name) for name in names)}" for names, verb in found if names]
    if not parts:
        return ""
    return (
        f"packing.size: the plastic zone {', and '.join(parts)}; its outermost yield is then cut there, and "
        "zone_cut in summary.json says so. Make the packing larger to have it whole"
    )


def _bound(zone: ExpectedZone, name: str) -> str:
    return f"the {name}, {zone.room[name]:.2g} m away"


def _parts(times: WallTime) -> str:
    """Describe the parts of the time of a run."""
    parts = {
        "static stage": times.static,
        "steps": times.steps,
        "set-up and analysis": times.rest,
        "figures": times.figures,
    }
    return ", ".join(f"{name} {duration(time)}" for name, time in parts.items() if time >= 0.5)


def static_stage_note(times: Sequence[WallTime], jobs: float = 1.0) -> str:
    """Return the plan's note on static stages whose length cannot be known, with so many jobs at once."""
    counted, most = sum(time.static for time in times) / jobs, sum(time.most_static for time in times) / jobs
    return f"counted with {duration(counted)}, but cannot be known where there is disorder: up to {duration(most)}"


def continuum_plan_table(name: str, n_elements: int, cost: Cost, inputs: Inputs | None = None) -> str:
    """Return the table of a planned continuum run."""
    return lines(
        [
            ("case", name),
            ("elements", f"about {n_elements}"),
            *_inputs(inputs),
            ("memory", f"about {cost.memory / 2**30:.2f} GiB"),
            ("disk", f"about {cost.disk / 1e9:.3g} GB"),
            ("expected time", f"about {duration(cost.wall_time)}"),
        ]
    )
