"""Files of a finished search: the checks of the best design, the cases of the best, design.json and the report."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from collections import deque
from collections.abc import Mapping, Sequence
from typing import Any

import tomli_w

from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.directories import read_summary
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.ownership import clear
from granwave.lammps_inputs.run_directory import BEST_DESIGNS, DESIGN_OUTCOME, POINTS, SCAN_REPORT
from granwave.workflows.design import guards
from granwave.workflows.design.points import Points, names
from granwave.workflows.design.problem import Problem
from granwave.workflows.design.search import expected_random, importance
from granwave.workflows.design.study import Design, Study
from granwave.workflows.run.progress import Progress
from granwave.workflows.run.record import versions


def check_best(
    study: Study, best: Design, points: Points, jobs: int, stop: Interrupts, *, show: bool
) -> list[guards.Finding]:
    """Check the best design by its own run and by further ones; return the findings, warnings first."""
    problem = study.problem
    before = (read_json(study.directory / DESIGN_OUTCOME) or {}).get("best") or {}
    if before.get("variables") != best.values:  # further runs of another design
        clear(study.directory, [f"{POINTS}/{path.name}/" for path in (study.directory / POINTS).glob("best-*")])
    first = names(best.number, problem.samples)[0]
    run, place = best.runs[first], study.directory / POINTS / first
    findings = guards.findings_without_runs(problem, best, read_summary(place), place)
    findings += guards.of_neighbours(problem, best, study.designs)
    waiting = deque(guards.further_runs(problem, best, run["longer"]) if problem.search.guards else ())
    total, made = len(waiting), {}
    with contextlib.closing(Progress(total, f"{problem.name}: checks", enabled=show)) as bar:
        while (waiting or points) and not stop.count:
            while waiting and len(points) < jobs:
                guard, tables = waiting.popleft()
                made[f"best-{guard.name}"] = guard
                points.start(f"best-{guard.name}", tables)
            for ended in points.wait():
                guard = made[ended.name]
                findings.append(
                    guards.finding_of(
                        guard, problem, run["value"], with_derived(ended.summary, best.known["smallest_diameter_m"])
                    )
                )
                bar.update(total - len(waiting) - len(points), guard.what)
        if stop.count:
            points.stop()
            while points:
                points.wait()
    return sorted(findings, key=lambda one: not one.warning)


def with_derived(summary: Mapping[str, Any], smallest_diameter: float) -> dict[str, Any]:
    """Return a summary with the values that are made of others, and those that are known before a run.

    ``overlap_over_radius``: the largest overlap over the effective radius of two of the smallest spheres, a quarter of
    their diameter. ``kinetic_share``: of the energy put in, at the end.
    """
    count, yielded = summary.get("n_spheres"), summary.get("n_plastic_spheres")
    overlap, given, kinetic = (summary.get(name) for name in ("peak_overlap_m", "energy_input_J", "energy_kinetic_J"))
    return {
        **summary,
        "mass_kg": summary.get("packing_mass_kg"),
        "height_m": summary.get("packing_height_m"),
        "overlap_over_radius": None if overlap is None else 4 * overlap / smallest_diameter,
        "kinetic_share": None if kinetic is None or not given else kinetic / given,
        "yielded_share": yielded / count if count and yielded is not None else None,
    }


def publish(study: Study, findings: Sequence[guards.Finding]) -> None:
    """Write the cases of the best designs, design.json and the report."""
    problem, best = study.problem, study.best()
    for name in BEST_DESIGNS:
        (study.directory / name).unlink(missing_ok=True)
    for name, design in zip(BEST_DESIGNS, best, strict=False):
        tables = problem.tables_of(design.values)
        longer = next(iter(design.runs.values()))["longer"]
        tables = tables if longer == 1 else guards.longer_end(tables, longer)
        tables = problem.case({**tables, "name": f"{problem.name}-{name.removesuffix('.toml')}"}).to_dict()
        replace_text(study.directory / name, tomli_w.dumps(tables))
    states = [design.state for design in study.designs]
    outcome = {
        "name": problem.name,
        "objectives": {one.name: "smallest" if one.sign > 0 else "largest" for one in problem.objectives},
        "best": {**_values_of(problem, best[0]), "guards": list(map(dataclasses.asdict, findings))} if best else None,
        "front": [_values_of(problem, design) for design in best] if len(problem.objectives) > 1 else None,
        "limits": {one.name: {"low": one.low, "high": one.high} for one in problem.limits},
        "evaluations": study.n_evaluated,
        "next_to_best": sum(bool(design.next_to) for design in study.designs),
        "states": {state: states.count(state) for state in dict.fromkeys(states)},
        "designs": problem.space.size if problem.space.size < float("inf") else None,
        "importance": importance(problem.space, study.known()),
        "random": _random(study),
        "seconds": sum(design.seconds for design in study.designs),
        "versions": versions(),
    }
    replace_text(study.directory / DESIGN_OUTCOME, json.dumps(outcome, indent=1) + "\n")
    write_report([study.directory], study.directory / SCAN_REPORT)


def _random(study: Study) -> list[float]:
    """Return the best of so many designs at random, by the model: what the search is compared with."""
    (first, *others) = study.problem.objectives
    counts = range(1, sum(design.ran for design in study.designs) + 1)
    losses = [] if others else expected_random(study.problem.space, study.known(), counts)
    return [first.sign * loss for loss in losses]


def _values_of(problem: Problem, design: Design) -> dict[str, Any]:
    return {
        "number": design.number,
        "directory": f"{POINTS}/{names(design.number, problem.samples)[0]}",
        "variables": design.values,
        **design.known,
        "objective": design.objectives,
        **({"spread": design.spread, "runs": len(problem.samples)} if design.spread else {}),
    }
