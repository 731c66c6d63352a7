"""Command ``granwave check``: what a run would be, its inputs, and the case that it compares with,
as a table.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.summary_table import lines
from granwave.extensions.continuum.counterpart import (
    ImpactInput,
    continuum_of,
    inputs_of_continuum,
    inputs_of_packing,
    packing_of,
)
from granwave.extensions.continuum.punch.case import ContinuumCase
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import GRAINS
from granwave.lammps_inputs.planning.cost import ExpectedZone, WallTime
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows import library
from granwave.workflows.cli.plan_values import packing_values, small_waves
from granwave.workflows.cli.terminal import print_json, warn, warn_of_lacks
from granwave.workflows.solvers import CONTINUUM, GRANULAR, solver_of

Rows = Iterable[tuple[str, str]]

_KILO = 1e-3  # kHz in a Hz
_GIB = 2**30
_TIMES = {
    "static stage": "static",
    "steps": "steps",
    "set-up and analysis": "rest",
    "figures": "figures",
}


def check(options: argparse.Namespace) -> int:
    """Plan a case and check that this machine can run it; return the exit status."""
    path = library.find_for(options.case, GRANULAR.verb, CONTINUUM.verb, library.DESIGN)
    if library.verb_of(path) == library.DESIGN:
        from granwave.extensions.design.terminal import (
            plan_of_design,
        )  # loads SciPy, which takes longer than most checks

        return plan_of_design(path, options)
    kind = solver_of(read_toml(path))
    try:
        with nothing_made():
            case = kind.load(path, options.overrides)
    except PackingNotMadeError as error:
        return _not_made(error, as_json=options.json)
    assembled = kind.assemble(case)
    expected = kind.cost(assembled, options.ranks, True)
    inputs = counterpart = waves = None
    if kind is GRANULAR:
        inputs = inputs_of_packing(assembled)
        counterpart = continuum_of(assembled)
        waves = small_waves(assembled)
    elif kind is CONTINUUM:
        inputs = inputs_of_continuum(case)
        counterpart = packing_of(case)
    warnings: list[str] = []
    if isinstance(expected, Plan):
        slow = (
            f"the run takes about {duration(expected.wall_time)}: {expected.slowness}"
            if expected.slowness
            else ""
        )
        warnings = [one for one in (slow, expected_cut(expected.zone)) if one]
    kind.check(case)

    def afford() -> None:
        kind.afford(case, expected, Path(case.name).absolute())

    if options.json:
        warnings += warn_of_lacks(case.name, afford)
        found: dict[str, Any] = {
            "name": case.name,
            "command": kind.verb,
            f"n_{kind.parts}": kind.size(assembled),
        }
        if isinstance(expected, Plan):
            found |= packing_values(assembled, expected) | {"small_waves": waves}
        found |= {
            "memory_bytes": expected.memory,
            "disk_bytes": expected.disk,
            "wall_time_s": expected.wall_time,
        }
        if inputs is not None:
            normalised = inputs.energy_normalised
            energy_continuum = inputs.energy_continuum
            found |= {
                "energy_input_J": inputs.energy,
                "energy_input_at_most": kind is GRANULAR and _is_bound(case),
                "energy_input_normalised": energy_continuum if normalised is None else normalised,
                "energy_input_over_sigma2_D3_E": energy_continuum,
                "velocity_normalised": inputs.velocity_normalised,
            }
        if counterpart is not None:
            found["counterpart"] = {
                "command": counterpart.command or None,
                "reason": counterpart.reason or None,
                "yield_velocity_m_s": counterpart.yield_velocity,
                "stays_elastic": counterpart.stays_elastic,
            }
        if kind is CONTINUUM:
            found["yield_velocity_m_s"] = case.yield_velocity
        print_json(found | {"warnings": warnings})
        return 0
    if kind is GRANULAR:
        print(plan_table(assembled, expected, inputs, wave_rows(waves)))
    else:
        print(table([
            ("case", case.name),
            ("elements", f"about {kind.size(assembled)}"),
            *_inputs(inputs),
            ("first yield", _first_yield(case) if kind is CONTINUUM else ""),
            ("memory", f"about {expected.memory / _GIB:.2f} GiB"),
            ("disk", f"about {expected.disk / 1e9:.3g} GB"),
            ("expected time", f"about {duration(expected.wall_time)}"),
        ]))  # fmt: skip
    if counterpart is not None:
        what = "continuum" if kind is GRANULAR else "packing"
        print(f"\n{what} of equal input: {counterpart.command or f'none, {counterpart.reason}'}")
        if counterpart.stays_elastic:
            print(f"It stays elastic: it yields from about {counterpart.yield_velocity:.2g} m/s.")
    sys.stdout.flush()
    warn_of_lacks(case.name, afford)
    for warning in warnings:
        warn(f"{case.name}: {warning}")
    return 0


def _not_made(error: PackingNotMadeError, *, as_json: bool) -> int:
    """Show what the bed of a case would be, whose plan follows once it is made."""
    if as_json:
        print_json({"not_made": dict(error.rows)})
    else:
        print(table(error.rows))
    return 0


def _first_yield(case: ContinuumCase) -> str:
    """Return the velocity from which the block of a continuum case yields."""
    velocity = case.yield_velocity
    if velocity is None:
        return ""
    elastic = ": this impact is elastic" if case.punch.velocity < velocity else ""
    return f"from about {velocity:.2g} m/s, at the edge of the punch{elastic}"


def table(rows: Rows) -> str:
    """Return a table of the rows that have a text."""
    return lines([(label, text) for label, text in rows if text])


def plan_table(
    assembly: Assembly, plan: Plan, inputs: ImpactInput | None = None, waves: Rows = ()
) -> str:
    """Return the table of a planned run; ``waves`` are rows on small waves."""
    return table(_plan_rows(assembly, plan, inputs, waves))


def _plan_rows(assembly: Assembly, plan: Plan, inputs: ImpactInput | None, waves: Rows) -> Rows:
    case = assembly.case
    schedule = plan.schedule
    times = plan.times
    values = packing_values(assembly, plan)
    grains = f"{plan.n_spheres}"
    if assembly.grains_called == GRAINS:
        grains += f": {plan.n_spheres - assembly.n_cylinders} spheres and {assembly.n_cylinders} cylinders"
    yield "case", plan.name
    yield assembly.grains_called, grains
    yield "contacts at the start", f"{plan.n_contacts}"
    across = " and ".join(f"{width:.4g}" for width in values["packing_width_m"])
    yield (
        "packing",
        f"{values['packing_mass_kg']:.4g} kg, {values['packing_height_m']:.4g} m high, {across} m wide",
    )
    if (struck := values["struck"]) is not None:
        aside = (
            f"{struck['aside_m']:.3g} m beside the middle of the top" if struck["aside_m"] else ""
        )
        below = f"{struck['below_m']:.3g} m below the top" if struck["below_m"] else ""
        yield (
            "struck",
            ", ".join(filter(None, [f"sphere {struck['sphere']}", struck["where"], aside, below])),
        )
    if (found := values["coordination"]) is not None:
        numbers = ", ".join(
            f"{number} on {n} grain{'s' * (n > 1)}" for number, n in found["grains"].items()
        )
        yield "contacts of a grain", f"{found['mean']:.3g} in the mean: {numbers}"
    yield "precompression", _static(case)
    yield from waves
    yield from _inputs(inputs, at_most="at most " * _is_bound(case))
    yield "memory", f"about {plan.memory / _GIB:.2f} GiB{_memory_of_ranks(plan)}"
    yield "disk", f"about {plan.disk / 1e9:.3g} GB"
    timestep = f"{schedule.timestep:.4g} s"
    steps = f"{schedule.n_steps}"
    if schedule.adaptive:
        timestep = (
            f"{schedule.first_timestep:.4g} s at first, {schedule.largest_timestep:.4g} s at most: "
        )
        timestep += f"energy balance to {schedule.energy_tolerance:g} of the input"
        steps = f"{schedule.n_steps // schedule.first_step} if all were as long as the first"
    at_most = "at most " if schedule.block_steps else ""  # such a run ends by itself
    yield "timestep", timestep
    yield (
        "",
        f"set by {plan.limit.cause}; a contact alone would allow {plan.allowed:.2g} s"
        if plan.limit
        else "",
    )
    yield "steps", f"{at_most}{steps}, to {schedule.end_time:.4g} s"
    yield "snapshots", f"{at_most}{schedule.n_frames}"
    if (arrival := values["expected_arrival_s"]) is not None:
        before = values["n_frames_before_arrival"]
        some = f", with {before} of the snapshots before" if arrival < schedule.end_time else ""
        yield "wave at the bottom", f"after about {arrival:.3g} s{some}"
    parts = {name: getattr(times, part) for name, part in _TIMES.items()}
    longer = ", ".join(
        f"{name} {duration(seconds)}" for name, seconds in parts.items() if seconds >= 0.5
    )
    usual = duration(times.total)
    most = duration(times.longest)
    yield "expected time", f"about {usual}: {longer}"
    yield "", f"at most {most}" if at_most and most != usual else ""
    yield "static stage", static_stage_note([times]) if times.most_static > times.static else ""
    yield "output", "a file from each rank (output.parts)" if values["output_in_parts"] else ""
    if held := values["held_by_first_rank"]:
        yield "held by the first rank", f"all sites at once, for {' and '.join(held)}"
    overlap = f"up to {plan.peak_overlap:.3g} m, {plan.peak_overlap_radius:.3g} R*"
    if plan.peak_overlap_yield is not None:
        overlap += f", {plan.peak_overlap_yield:.3g} of that at first yield"
    if values["peak_overlap_beyond_law"]:
        overlap += " - beyond 0.2 R*, where the contact law ends"
    yield "largest overlap", overlap
    if (rate := values["rate"]) is not None:
        first = rate["factor_at_yield"]
        last = rate["factor_at_largest_overlap"]
        at = f"at first yield, {last:.4g} at the largest overlap, at {rate['velocity_m_s']:.4g} m/s"
        yield "yield strength", f"times {first:.4g} {at}"
    for name, loss in (values["loss"] or {}).items():
        yield "loss", f"time {loss:.4g} s" if name == "time_s" else f"dashpot {loss:.4g}"
    yield "outermost yield", _outermost_yield(plan.zone)
    yield from (("no peak reduction", reason) for reason in values["nulls"].values())


def _memory_of_ranks(plan: Plan) -> str:
    """Return the memory of each rank; empty for a single one."""
    if plan.n_ranks == 1:
        return ""
    first = f": first rank, which puts the results together, {plan.first_rank / _GIB:.2f}"
    other = f"{plan.other_rank / _GIB:.2f}"
    if plan.n_analysing == plan.n_ranks:
        return f"{first}, each other {other}"
    n_others = plan.n_analysing - 1
    idle = f"each rank that takes no part in the analysis {plan.idle_rank / _GIB:.2f}"
    if not n_others:
        return f"{first}, {idle}"
    return f"{first}, each of {n_others} others that analyse with it {other}, {idle}"


def _is_bound(case: Case) -> bool:
    """Return True if the energy input of a plan is an upper bound."""
    return case.load.energy_is_bound


def _inputs(inputs: ImpactInput | None, at_most: str = "") -> Rows:
    """Return rows of energy and velocity, as far as they apply."""
    if inputs is None or not inputs.energy:
        return
    yield "energy in", f"{at_most}{inputs.energy:.6g} J"
    label = "energy normalised"
    for value, unit in (
        (inputs.energy_normalised, "F_y alpha_y of a contact"),
        (inputs.energy_continuum, "sigma_y^2 D^3/E, as in the continuum"),
    ):
        if value is not None:
            yield label, f"{at_most}{value:.6g} {unit}"
            label = ""
    if inputs.velocity_normalised is not None:
        yield "velocity normalised", f"{inputs.velocity_normalised:.6g}"


def _static(case: Case) -> str:
    """Return the load before the impact; empty if there is none."""
    if (stage := case.precompression) is None:
        return ""
    walls = {name: "the tube shrinks" if name == "tube" else f"the walls across {name} move in"
             for name in (*stage.moves, *stage.presses)}  # fmt: skip
    parts = [
        *(f"{walls[name]} by {length:.4g} m" for name, length in stage.moves.items()),
        *(f"{walls[name]} to {force:.4g} N" for name, force in stage.presses.items()),
        "" if stage.pressure is None else f"{stage.pressure:.4g} Pa on the free faces",
        "" if stage.force is None else f"{stage.force:.4g} N on each grain of the top",
        *stage.rule.words(stage),
        "overlaps at the start press" if stage.takes_overlaps else "",
    ]
    return "; ".join(filter(None, parts))


def wave_rows(waves: Mapping[str, Any] | None) -> Rows:
    """Return rows on `small_waves` for the table of a plan."""
    if waves is None:
        return
    bounds = ", ".join(f"{_KILO * low:.4g} to {_KILO * high:.4g}" for low, high in waves["gaps_Hz"])
    but = f", but for gaps: {bounds} kHz" if bounds else ""
    yield "small waves", f"up to {_KILO * waves['highest_Hz']:.4g} kHz{but}"
    if waves["speed_m_s"] is not None:
        long = f"long ones {waves['speed_m_s']:.4g} m/s: from end to end ({waves['length_m']:.3g} m) in "
        yield "", f"{long}{waves['travel_time_s']:.3g} s"
    for load in waves["load"]:
        fate = "passes" if load["passes"] else "is stopped"
        yield "load's frequency", f"{_KILO * load['frequency_Hz']:.4g} kHz {fate}"


def _outermost_yield(zone: ExpectedZone | None) -> str:
    """Return an estimate of the outermost yield; empty if there is none."""
    if zone is None:
        return ""
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
    parts = [
        f"{verb} {' and '.join(f'the {name}, {zone.room[name]:.2g} m away' for name in names)}"
        for names, verb in ((zone.reaches, "is expected to reach"), (zone.may_reach, "may reach"))
        if names
    ]
    if not parts:
        return ""
    return (
        f"packing.size: the plastic zone {', and '.join(parts)}; its outermost yield is then cut there, and "
        "zone_cut in summary.json says so. Make the packing larger to have it whole"
    )


def static_stage_note(times: Sequence[WallTime], jobs: float = 1.0) -> str:
    """Return the plan's note on static stages whose length cannot be known, with so many jobs at
    once.
    """
    counted = sum(time.static for time in times) / jobs
    most = sum(time.most_static for time in times) / jobs
    return f"counted with {duration(counted)}, but cannot be known where there is disorder: up to {duration(most)}"
