"""Table of a planned run, as ``granwave check`` prints it: a row for each property, by subject."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.analysis.formatting.numbers import counted, duration
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import GRAINS
from granwave.lammps_inputs.planning.impact_input import ImpactInput
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows.check_part import Rows, input_rows
from granwave.workflows.cli.tables.grain_file_values import grain_file_rows
from granwave.workflows.cli.tables.plan_values import packing_values
from granwave.workflows.cli.tables.rows import GIB, table
from granwave.workflows.cli.tables.static_stages import static_stage_note
from granwave.workflows.cli.tables.zone import plastic_zone

_LOSS_ROWS = {
    "time_s": "time {:.4g} s",
    "dashpot": "dashpot {:.4g}",
    "weights": "Prony series, weights {}",
    "times_s": "times {} s",
    "tangential": "tangential {:.4g} times the normal value",
}
_TIMES = {
    "static stage": "static",
    "steps": "steps",
    "set-up and analysis": "rest",
    "figures": "figures",
}


def plan_table(
    assembly: Assembly, plan: Plan, inputs: ImpactInput | None = None, rows: Rows = ()
) -> str:
    """Return the table of a planned run; ``rows`` are added by extensions."""
    return table(_plan_rows(assembly, plan, inputs, rows))


def _plan_rows(assembly: Assembly, plan: Plan, inputs: ImpactInput | None, rows: Rows) -> Rows:
    values = packing_values(assembly, plan)
    yield "case", plan.name
    yield from _packing_rows(assembly, plan, values)
    yield "precompression", _static(assembly.case)
    yield from rows
    yield from input_rows(inputs, at_most=energy_is_bound(assembly.case))
    yield "memory", f"about {plan.memory / GIB:.2f} GiB{_memory_of_ranks(plan)}"
    yield "disk", f"about {plan.disk / 1e9:.3g} GB"
    yield from _schedule_rows(plan, values)
    yield from _time_rows(plan)
    yield "output", "one file per node (output.parts)" if values["output_in_parts"] else ""
    if held := values["held_by_first_rank"]:
        yield "held by the first rank", f"all sites at once, for {' and '.join(held)}"
    yield "largest overlap", _largest_overlap(plan, values)
    yield from _rate_rows(values["rate"])
    for name, size in (values["loss"] or {}).items():
        shown = ", ".join(f"{value:.4g}" for value in size) if isinstance(size, list) else size
        yield "loss", _LOSS_ROWS[name].format(shown)
    yield "plastic zone", plastic_zone(plan.zone)
    for reason in values["nulls"].values():
        yield "no peak reduction", reason


def _packing_rows(assembly: Assembly, plan: Plan, values: Mapping[str, Any]) -> Rows:
    """Return rows on grains, their contacts, and the size of the packing."""
    grains = f"{plan.n_spheres}"
    if assembly.grains_called == GRAINS:
        n_spheres = plan.n_spheres - assembly.n_cylinders
        cylinders = counted(assembly.n_cylinders, "cylinder")
        grains += f": {counted(n_spheres, 'sphere')} and {cylinders}"
    yield assembly.grains_called, grains
    yield from grain_file_rows(values["packing_file"])
    if values["n_clumps"]:
        yield "clumps", f"{values['n_clumps']}, of {values['n_grains_in_clumps']} grains in all"
    yield "contacts at the start", f"{plan.n_contacts}"
    mass = f"{values['packing_mass_kg']:.4g} kg"
    height = f"{values['packing_height_m']:.4g} m high"
    across = " and ".join(f"{width:.4g}" for width in values["packing_width_m"])
    yield "packing", f"{mass}, {height}, {across} m wide"
    yield "impacted", _impacted(values["struck"])
    yield "contacts per grain", _coordination(values["coordination"])
    yield from _contact_rows(values["contacts_found"])


def _impacted(struck: Mapping[str, Any] | None) -> str:
    """Return the impacted sphere and its position; empty if the load acts on no sphere in
    particular.
    """
    if struck is None:
        return ""
    parts = [f"sphere {struck['sphere']}"]
    if struck["where"]:
        parts.append(struck["where"])
    if struck["aside_m"]:
        parts.append(f"{struck['aside_m']:.3g} m from the middle of the top")
    if struck["below_m"]:
        parts.append(f"{struck['below_m']:.3g} m below the top")
    return ", ".join(parts)


def _coordination(coordination: Mapping[str, Any] | None) -> str:
    """Return the mean number of contacts of a grain, and the number of grains with each number of
    contacts; empty for crystals, whose grains all have the coordination of their lattice.
    """
    if coordination is None:
        return ""
    numbers = []
    for n_contacts, n_grains in coordination["grains"].items():
        numbers.append(f"{n_contacts} on {counted(n_grains, 'grain')}")
    return f"{coordination['mean']:.3g} on average: {', '.join(numbers)}"


def _contact_rows(found: Mapping[str, Any] | None) -> Rows:
    """Return rows on contacts of grains of a file that overlap or nearly touch."""
    if found is None:
        return
    within = f"{counted(found['n_within'], 'pair')} within {found['tolerance_m']:.3g} m"
    last = f"last digit of the file: {found['last_place_m']:.3g} m"
    beyond = (
        f"{found['n_beyond']} with a larger overlap, at most {found['largest_overlap_m']:.3g} m"
    )
    yield "touching in the file", f"{within} ({last}); {beyond}"
    way = found["way"]
    for choice in found["choices"]:
        chosen = " (chosen)" if way is not None and choice.startswith(f'"{way}"') else ""
        yield "", choice + chosen


def _schedule_rows(plan: Plan, values: Mapping[str, Any]) -> Rows:
    """Return rows on timestep, steps, snapshots, and the arrival of the wave at the bottom."""
    schedule = plan.schedule
    timestep = f"{schedule.timestep:.4g} s"
    steps = f"{schedule.n_steps}"
    if schedule.adaptive:
        first = f"{schedule.first_timestep:.4g} s at first"
        largest = f"{schedule.largest_timestep:.4g} s at most"
        balance = f"energy balance to {schedule.energy_tolerance:g} of the input"
        timestep = f"{first}, {largest}: {balance}"
        steps = f"{schedule.n_steps // schedule.first_step} with the initial timestep"
    at_most = "at most " if schedule.block_steps else ""  # such a run ends automatically
    yield "timestep", timestep
    if plan.limit:
        yield "", f"limited by {plan.limit.cause}; contacts would allow {plan.allowed:.2g} s"
    yield "steps", f"{at_most}{steps}, to {schedule.end_time:.4g} s"
    yield "snapshots", f"{at_most}{schedule.n_frames}"
    if (arrival := values["expected_arrival_s"]) is not None:
        before = values["n_frames_before_arrival"]
        some = f"; {before} of {schedule.n_frames} snapshots are before this time"
        some = some if arrival < schedule.end_time else ""
        yield "wave at the bottom", f"after about {arrival:.3g} s{some}"


def _time_rows(plan: Plan) -> Rows:
    """Return rows on the time that a run is expected to take."""
    times = plan.times
    parts = {name: getattr(times, part) for name, part in _TIMES.items()}
    longer = ", ".join(
        f"{name} {duration(seconds)}" for name, seconds in parts.items() if seconds >= 0.5
    )
    usual = duration(times.total)
    most = duration(times.longest)
    yield "expected time", f"about {usual}: {longer}"
    if plan.schedule.block_steps and most != usual:
        yield "", f"at most {most}"
    if times.most_static > times.static:
        yield "static stage", static_stage_note([times])


def _largest_overlap(plan: Plan, values: Mapping[str, Any]) -> str:
    """Return the largest expected overlap, in m and in units of the contact."""
    overlap = f"up to {plan.peak_overlap:.3g} m, {plan.peak_overlap_radius:.3g} R*"
    if plan.peak_overlap_yield is not None:
        overlap += f", {plan.peak_overlap_yield:.3g} of the overlap at first yield"
    if values["peak_overlap_beyond_law"]:
        overlap += " - beyond 0.2 R*, the limit of the contact law"
    return overlap


def _rate_rows(rate: Mapping[str, Any] | None) -> Rows:
    """Return a row on the rise of the yield strength with the rate of deformation."""
    if rate is None:
        return
    first = f"times {rate['factor_at_yield']:.4g} at first yield"
    last = f"{rate['factor_at_largest_overlap']:.4g} at the largest overlap"
    yield "yield strength", f"{first}, {last}, at {rate['velocity_m_s']:.4g} m/s"


def _memory_of_ranks(plan: Plan) -> str:
    """Return the memory of each rank; empty for a single one."""
    if plan.n_ranks == 1:
        return ""
    first = f": first rank, which collects the results, {plan.first_rank / GIB:.2f}"
    other = f"{plan.other_rank / GIB:.2f}"
    if plan.n_analysing == plan.n_ranks:
        return f"{first}, each other {other}"
    n_others = plan.n_analysing - 1
    idle = f"each rank without analysis {plan.idle_rank / GIB:.2f}"
    if not n_others:
        return f"{first}, {idle}"
    return f"{first}, each of the {n_others} other analysis ranks {other}, {idle}"


def energy_is_bound(case: Case) -> bool:
    """Return True if the energy input of a plan is an upper bound."""
    return case.load.energy_is_bound


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
        "initial overlaps exert force" if stage.takes_overlaps else "",
    ]
    return "; ".join(filter(None, parts))
