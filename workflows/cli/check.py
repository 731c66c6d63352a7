"""Command ``granwave check``: what a run would be, its inputs, and what extensions show of it, as
a table.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.summary_table import lines
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.extensions import added, load
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import GRAINS
from granwave.lammps_inputs.planning.cost import ExpectedZone, WallTime
from granwave.lammps_inputs.planning.impact_input import ImpactInput, inputs_of_packing
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows import library
from granwave.workflows.check_part import CheckPart, Rows, input_rows, input_values
from granwave.workflows.cli.cluster_plan import ClusterPlan
from granwave.workflows.cli.grain_file_values import grain_file_rows
from granwave.workflows.cli.packing_picture import draw_packing
from granwave.workflows.cli.plan_values import packing_values
from granwave.workflows.cli.submission import ranks_of
from granwave.workflows.cli.terminal import print_json, warn, warn_of_lacks
from granwave.workflows.cluster.profile import load_profile
from granwave.workflows.file_kinds import file_kinds
from granwave.workflows.solvers import GRANULAR, CaseKind, case_commands, solver_of

_GIB = 2**30
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


def check(options: argparse.Namespace) -> int:
    """Plan a case and check that this machine can run it; return the exit status."""
    checks = {kind.command: kind.check for kind in file_kinds() if kind.check}
    path = library.find_for(options.case, *case_commands(), *checks)
    if (command := library.verb_of(path)) in checks:
        if options.profile:
            raise InputError(f"--profile: {path} is no case of a run; leave it out")
        draw_packing(options.picture, None)
        return int(load(checks[command])(path, options))
    kind = solver_of(read_toml(path))
    try:
        with nothing_made():
            case = kind.load(path, options.overrides)
    except PackingNotMadeError as error:
        return _not_made(error, as_json=options.json)
    assembled = kind.assemble(case)
    cluster = _cluster_plan(kind, assembled, options)
    expected = cluster.expected if cluster else kind.cost(assembled, options.ranks, True)
    parts = _parts(kind, assembled)
    if cluster is not None:
        parts.append(cluster.part())
    kind.check(case)
    draw_packing(options.picture, assembled)

    def afford() -> None:
        if cluster is None:
            kind.afford(case, expected, Path(case.name).absolute())

    warnings = _warnings(expected)
    if cluster is not None:
        warnings += cluster.warnings()
    if options.json:
        warnings += warn_of_lacks(case.name, afford)
        values = _values(kind, assembled, expected, parts)
        print_json({"name": case.name, "command": kind.verb, **values, "warnings": warnings})
        return 0
    print(_plan_text(kind, assembled, case.name, expected, parts))
    sys.stdout.flush()
    warn_of_lacks(case.name, afford)
    for warning in warnings:
        warn(f"{case.name}: {warning}")
    return 0


def _plan_text(
    kind: CaseKind, assembled: Any, name: str, expected: Any, parts: Sequence[CheckPart]
) -> str:
    """Return the table of a plan, and the lines that extensions add."""
    if isinstance(expected, Plan):
        rows = [row for part in parts for row in part.rows]
        text = plan_table(assembled, expected, inputs_of_packing(assembled), rows)
    else:
        text = _table_of_other(kind, assembled, name, expected, parts)
    texts = [text]
    for part in parts:
        texts += part.lines
    return "\n".join(texts)


def _cluster_plan(
    kind: CaseKind, assembled: Any, options: argparse.Namespace
) -> ClusterPlan | None:
    """Return the plan for the cluster of ``--profile``; None without one."""
    if not options.profile:
        return None
    profile = load_profile(options.profile)
    ranks = ranks_of(options, profile) if kind.parallel else 1
    return ClusterPlan(profile, kind.cost(assembled, ranks, True), ranks)


def _not_made(error: PackingNotMadeError, *, as_json: bool) -> int:
    """Show what the bed of a case would be, whose plan follows once it is made."""
    (packing,) = error.packings
    if as_json:
        print_json({"not_made": dict(packing.rows)})
    else:
        print(table(packing.rows))
    return 0


def _parts(kind: CaseKind, assembled: Any) -> list[CheckPart]:
    """Return what extensions show of a case."""
    if kind is GRANULAR:
        return [part(assembled) for part in added("check")]
    return [] if kind.check_part is None else [kind.check_part(assembled)]


def _warnings(expected: Any) -> list[str]:
    """Return warnings of the plan of a packing."""
    if not isinstance(expected, Plan):
        return []
    warnings = []
    if expected.slowness:
        warnings.append(f"the run takes about {duration(expected.wall_time)}: {expected.slowness}")
    if cut := expected_cut(expected.zone):
        warnings.append(cut)
    return warnings


def _values(
    kind: CaseKind, assembled: Any, expected: Any, parts: Sequence[CheckPart]
) -> dict[str, Any]:
    """Return the values of a planned case; units are part of the names."""
    values: dict[str, Any] = {f"n_{kind.parts}": kind.size(assembled)}
    if isinstance(expected, Plan):
        values |= packing_values(assembled, expected)
    for part in parts:
        values |= part.values
    values |= {
        "memory_bytes": expected.memory,
        "disk_bytes": expected.disk,
        "wall_time_s": expected.wall_time,
    }
    if isinstance(expected, Plan):
        at_most = _is_bound(assembled.case)
        values |= input_values(inputs_of_packing(assembled), at_most=at_most)
    for part in parts:
        values |= part.further_values
    return values


def _table_of_other(
    kind: CaseKind, assembled: Any, name: str, expected: Any, parts: Sequence[CheckPart]
) -> str:
    """Return the table of a case that is not of spheres."""
    rows = [("case", name), (kind.parts, f"about {kind.size(assembled)}")]
    for part in parts:
        rows += part.rows
    rows.append(("memory", f"about {expected.memory / _GIB:.2f} GiB"))
    rows.append(("disk", f"about {expected.disk / 1e9:.3g} GB"))
    rows.append(("expected time", f"about {duration(expected.wall_time)}"))
    return table(rows)


def table(rows: Rows) -> str:
    """Return a table of the rows that have a text."""
    return lines([(label, text) for label, text in rows if text])


def plan_table(
    assembly: Assembly, plan: Plan, inputs: ImpactInput | None = None, rows: Rows = ()
) -> str:
    """Return the table of a planned run; ``rows`` are those of extensions."""
    return table(_plan_rows(assembly, plan, inputs, rows))


def _plan_rows(assembly: Assembly, plan: Plan, inputs: ImpactInput | None, rows: Rows) -> Rows:
    case = assembly.case
    schedule = plan.schedule
    times = plan.times
    values = packing_values(assembly, plan)
    grains = f"{plan.n_spheres}"
    if assembly.grains_called == GRAINS:
        grains += f": {plan.n_spheres - assembly.n_cylinders} spheres and {assembly.n_cylinders} cylinders"
    yield "case", plan.name
    yield assembly.grains_called, grains
    yield from grain_file_rows(values["packing_file"])
    if values["n_clumps"]:
        yield "clumps", f"{values['n_clumps']}, of {values['n_grains_in_clumps']} grains in all"
    yield "contacts at the start", f"{plan.n_contacts}"
    across = " and ".join(f"{width:.4g}" for width in values["packing_width_m"])
    yield (
        "packing",
        f"{values['packing_mass_kg']:.4g} kg, {values['packing_height_m']:.4g} m high, {across} m wide",
    )
    if (struck := values["struck"]) is not None:
        aside = f"{struck['aside_m']:.3g} m from the middle of the top" if struck["aside_m"] else ""
        below = f"{struck['below_m']:.3g} m below the top" if struck["below_m"] else ""
        yield (
            "impacted",
            ", ".join(filter(None, [f"sphere {struck['sphere']}", struck["where"], aside, below])),
        )
    if (found := values["coordination"]) is not None:
        numbers = ", ".join(
            f"{number} on {n} grain{'s' * (n > 1)}" for number, n in found["grains"].items()
        )
        yield "contacts per grain", f"{found['mean']:.3g} on average: {numbers}"
    yield from _contact_rows(values["contacts_found"])
    yield "precompression", _static(case)
    yield from rows
    yield from input_rows(inputs, at_most=_is_bound(case))
    yield "memory", f"about {plan.memory / _GIB:.2f} GiB{_memory_of_ranks(plan)}"
    yield "disk", f"about {plan.disk / 1e9:.3g} GB"
    timestep = f"{schedule.timestep:.4g} s"
    steps = f"{schedule.n_steps}"
    if schedule.adaptive:
        timestep = (
            f"{schedule.first_timestep:.4g} s at first, {schedule.largest_timestep:.4g} s at most: "
        )
        timestep += f"energy balance to {schedule.energy_tolerance:g} of the input"
        steps = f"{schedule.n_steps // schedule.first_step} if all steps had the first length"
    at_most = "at most " if schedule.block_steps else ""  # such a run ends by itself
    yield "timestep", timestep
    yield (
        "",
        f"limited by {plan.limit.cause}; contacts would allow {plan.allowed:.2g} s"
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
    yield "output", "one file per rank (output.parts)" if values["output_in_parts"] else ""
    if held := values["held_by_first_rank"]:
        yield "held by the first rank", f"all sites at once, for {' and '.join(held)}"
    overlap = f"up to {plan.peak_overlap:.3g} m, {plan.peak_overlap_radius:.3g} R*"
    if plan.peak_overlap_yield is not None:
        overlap += f", {plan.peak_overlap_yield:.3g} of the overlap at first yield"
    if values["peak_overlap_beyond_law"]:
        overlap += " - beyond 0.2 R*, the limit of the contact law"
    yield "largest overlap", overlap
    if (rate := values["rate"]) is not None:
        first = rate["factor_at_yield"]
        last = rate["factor_at_largest_overlap"]
        at = f"at first yield, {last:.4g} at the largest overlap, at {rate['velocity_m_s']:.4g} m/s"
        yield "yield strength", f"times {first:.4g} {at}"
    for name, size in (values["loss"] or {}).items():
        is_list = isinstance(size, list)
        shown = ", ".join(f"{one:.4g}" for one in size) if is_list else size
        yield "loss", _LOSS_ROWS[name].format(shown)
    yield "plastic zone", _plastic_zone(plan.zone)
    yield from (("no peak reduction", reason) for reason in values["nulls"].values())


def _contact_rows(found: Mapping[str, Any] | None) -> Rows:
    """Return rows on contacts of grains of a file that overlap or nearly touch."""
    if found is None:
        return
    within = f"{found['n_within']} pairs within {found['tolerance_m']:.3g} m"
    last = f"last digit of the file: {found['last_place_m']:.3g} m"
    beyond = (
        f"{found['n_beyond']} have a larger overlap, at most {found['largest_overlap_m']:.3g} m"
    )
    yield "touching in the file", f"{within} ({last}); {beyond}"
    way = found["way"]
    for choice in found["choices"]:
        chosen = " (chosen)" if way is not None and choice.startswith(f'"{way}"') else ""
        yield "", choice + chosen


def _memory_of_ranks(plan: Plan) -> str:
    """Return the memory of each rank; empty for a single one."""
    if plan.n_ranks == 1:
        return ""
    first = f": first rank, which collects the results, {plan.first_rank / _GIB:.2f}"
    other = f"{plan.other_rank / _GIB:.2f}"
    if plan.n_analysing == plan.n_ranks:
        return f"{first}, each other {other}"
    n_others = plan.n_analysing - 1
    idle = f"each rank without analysis {plan.idle_rank / _GIB:.2f}"
    if not n_others:
        return f"{first}, {idle}"
    return f"{first}, each of the {n_others} other analysis ranks {other}, {idle}"


def _is_bound(case: Case) -> bool:
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


def _plastic_zone(zone: ExpectedZone | None) -> str:
    """Return an estimate of the size of the plastic zone; empty if there is none."""
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
    parts = []
    for names, verb in ((zone.reaches, "is expected to reach"), (zone.may_reach, "may reach")):
        if names:
            edges = [f"the {name}, {zone.room[name]:.2g} m away" for name in names]
            parts.append(f"{verb} {' and '.join(edges)}")
    if not parts:
        return ""
    return (
        f"packing.size: the plastic zone {', and '.join(parts)}. The boundary limits the zone, "
        "and zone_cut in summary.json lists it. Use a larger packing to contain the zone"
    )


def static_stage_note(times: Sequence[WallTime], jobs: float = 1.0) -> str:
    """Return the plan's note on static stages whose length cannot be known, with so many jobs at
    once.
    """
    counted = sum(time.static for time in times) / jobs
    most = sum(time.most_static for time in times) / jobs
    return (
        f"estimated as {duration(counted)}, but unpredictable in a disordered packing: up to "
        f"{duration(most)}"
    )
