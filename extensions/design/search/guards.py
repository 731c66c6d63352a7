"""Checks of the best design: whether the optimum depends on the model, the runs or chance.  Some
checks read the run of the best design; the others are further runs with one key changed. A change
of an objective by more than 5 % is in the first lines of the report.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.analysis.document.model import label_of, unit_of_value
from granwave.analysis.formatting.numbers import in_any_unit
from granwave.extensions.design.files import DESIGN_OUTCOME
from granwave.extensions.design.search.points import Points, names
from granwave.extensions.design.search.problem import (
    KNOWN_BEFORE,
    DesignProblem,
    examined,
    with_derived,
    with_values,
)
from granwave.extensions.design.search.study import COMPLETE, Design, DesignStudy
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.bounds import SIDES
from granwave.lammps_inputs.case.run import ENERGY_TOLERANCE
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, regular
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.lattices import kind_of
from granwave.lammps_inputs.message_words import counted
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import POINTS, RESULT_FILE
from granwave.workflows.run.progress import Progress

Tables = dict[str, Any]
NOTABLE = 0.05  # relative change of an objective that the report names first
FALLEN = 0.1  # fraction of the peak to which the force on a target falls once the impact has passed
_UNCHANGED = 5e-4  # relative change that a percentage with one digit does not show
_STILL = 0.05  # fraction of the impulse that is allowed in the last tenth of a run
_MOVING = 0.3  # fraction of the energy that is allowed to be kinetic at the end
_TOLERANCE = 5e-4  # scatter of diameters divided by the diameter


@dataclasses.dataclass(frozen=True)
class GuardOutcome:
    """Outcome of a check.

    Attributes
    ----------
    name
        Name of the check; for a further run the name of its directory, without ``best-``.
    what
        Changed or inspected quantity.
    text
        Finding, in a sentence.
    changes
        Relative changes of the objectives by name; empty for checks without a run.
    warning
        True if it belongs in the first lines of the report.
    """

    name: str
    what: str
    text: str
    changes: Mapping[str, float] = dataclasses.field(default_factory=dict)
    warning: bool = False


def check_best(
    study: DesignStudy, best: Design, points: Points, jobs: int, stop: Interrupts, *, show: bool
) -> list[GuardOutcome]:
    """Check the best design by its run and by further runs.

    Returns
    -------
    list of GuardOutcome
        The findings, warnings first.
    """
    problem = study.problem
    before = (read_json(study.directory / DESIGN_OUTCOME) or {}).get("best") or {}
    if before.get("variables") != best.values:  # further runs of another design
        further = (study.directory / POINTS).glob("best-*")
        points.results.clear([f"{POINTS}/{path.name}/" for path in further])
    first = names(best.number, problem.samples)[0]
    run = best.runs[first]
    place = study.directory / POINTS / first
    findings = [*findings_without_runs(problem, best, ResultDirectory(place).summary(), place)]
    findings += of_neighbours(problem, best, study.designs)
    if problem.search.guards:
        further_findings = _run_further(problem, best, run, points, jobs, stop, show=show)
        findings.extend(further_findings)
    return sorted(findings, key=lambda finding: not finding.warning)


def _run_further(
    problem: DesignProblem,
    best: Design,
    run: Mapping[str, Any],
    points: Points,
    jobs: int,
    stop: Interrupts,
    *,
    show: bool,
) -> Iterator[GuardOutcome]:
    """Make the further runs of the best design, whose run is ``run``; return their findings."""
    waiting = deque(further_runs(problem, best, run["longer"]))
    total = len(waiting)
    started = {}
    with contextlib.closing(Progress(total, f"{problem.name}: checks", enabled=show)) as bar:
        while (waiting or points) and not stop.count:
            while waiting and len(points) < jobs:
                name, what, tables = waiting.popleft()
                started[f"best-{name}"] = (name, what)
                points.start(f"best-{name}", tables)
            for ended in points.wait():
                name, what = started[ended.name]
                after = with_derived(ended.summary, best.known["smallest_diameter_m"])
                yield finding_of(name, what, problem, run["value"], after)
                bar.update(total - len(waiting) - len(points), what)
        if stop.count:
            points.stop()
            while points:
                points.wait()


def changes_of(tables: Tables, *, random: bool) -> Iterator[tuple[str, str, dict[str, Any]]]:
    """Return the further runs that apply to a case: name, description, and changed keys."""
    packing = tables["packing"]
    run = tables["run"]
    boundary = tables.get("boundary", {})
    size = packing.get("size")
    end = run.get("end_time")
    step = run.get("timestep")
    bottom = boundary.get("bottom")
    by_id = any("index" in entry for entry in tables.get("replace", []))
    if isinstance(size, list) and not by_id and not _is_periodic(boundary):
        across = 1 if kind_of(packing["kind"]).is_plane_crystal else 2
        wider = [
            n + 2 * max(1, round(n / 4)) if place < across else n for place, n in enumerate(size)
        ]
        yield "wider", "a packing 1.5 times as wide", {"packing.size": wider}
    if isinstance(end, int | float):
        yield "longer", "a run 1.5 times as long", {"run.end_time": 1.5 * end}
    finer = {"run.energy_tolerance": run.get("energy_tolerance", ENERGY_TOLERANCE) / 2}
    if isinstance(step, int | float):
        finer = {"run.timestep": step / 2}
    yield "finer", "half the error of the energy balance, or half the timestep", finer
    if "diameter" in packing and not packing.get("diameter_scatter"):
        scatter = {"packing.diameter_scatter": _TOLERANCE * packing["diameter"]}
        yield "tolerance", "a diameter scatter of 0.05 %", scatter
    if random:
        yield "seed", "another seed", {"packing.seed": packing.get("seed", 1) + 1000}
    plate = bottom.get("plate") if isinstance(bottom, dict) else None
    if plate is not None:
        stiffer = {"boundary.bottom.plate.stiffness": 4 * plate["stiffness"]}
        yield "stiffer", "a plate on a spring four times as stiff", stiffer


def _is_periodic(boundary: Tables) -> bool:
    """Return True for the table of a boundary whose sides are periodic."""
    sides = boundary.get("sides", Boundary.sides)
    return isinstance(sides, str) and SIDES[sides].repeats


def further_runs(
    problem: DesignProblem, best: Design, longer: float
) -> Iterator[tuple[str, str, Tables]]:
    """Return the further runs of a design that need a case: name, description, and tables.

    ``longer``: duration of its run divided by the duration in the design file.
    """
    case = problem.case(problem.tables_of(best.values, problem.samples[0], longer=longer))
    tables = case.to_dict()
    for name, what, changes in changes_of(tables, random=is_random(case)):
        changed = with_values(tables, changes)
        with contextlib.suppress(InputError):
            problem.case(changed)
            yield name, what, changed


def _compared(
    problem: DesignProblem, before: Mapping[str, Any], after: Mapping[str, Any]
) -> tuple[dict[str, float], str]:
    """Return the relative changes of the objectives that have two values, and a text on these
    changes.
    """
    changes = {}
    for objective in problem.objectives:
        old = before.get(objective.name)
        new = after.get(objective.name)
        if isinstance(old, int | float) and isinstance(new, int | float) and old:
            changes[objective.name] = new / old - 1
    return changes, ", ".join(
        _changed_value(name, before[name] if _is_unchanged(change) else after[name], change)
        for name, change in changes.items()
    )


def _is_unchanged(change: float) -> bool:
    """Return True for a relative change that a text calls unchanged."""
    return abs(change) < _UNCHANGED


def _changed_value(name: str, value: float, change: float) -> str:
    """Return an objective with its unit and its relative change, in words."""
    label = label_of(name)
    text = f"{label[:1].lower()}{label[1:]} {in_any_unit(value, unit_of_value(name))}"
    if _is_unchanged(change):
        return f"{text} (unchanged)"
    return f"{text} ({100 * change:+.1f} %)"


def finding_of(
    name: str,
    what: str,
    problem: DesignProblem,
    before: Mapping[str, Any],
    after: Mapping[str, Any],
) -> GuardOutcome:
    """Compare the objectives of a further run with the run of the best design."""
    changes, text = _compared(problem, before, after)
    if not changes:
        return GuardOutcome(name, what, f"{what}: no value", warning=True)
    notable = any(abs(change) > NOTABLE for change in changes.values())
    for limit in problem.limits:
        if limit.name not in KNOWN_BEFORE and limit.name in after:
            fault = limit.fault(after[limit.name] or 0.0)
            if fault:
                text += f"; beyond a limit: {fault}"
                notable = True
    return GuardOutcome(name, what, f"{what}: {text}", changes, notable)


def of_neighbours(
    problem: DesignProblem, best: Design, designs: Sequence[Design]
) -> Iterator[GuardOutcome]:
    """Return the findings of the designs next to the best one, and of the moves to them."""
    yield from _moves(problem, best, designs)
    by_values = {repr(design.values): design for design in designs}
    left = []
    for n, (key, values) in enumerate(problem.space.neighbours(best.values), start=1):
        what = f"{key} = {show(values[key])}"
        tried = by_values.get(repr(values))
        if tried is None:
            _, _, fault = examined(problem, values)
            if not fault:
                left.append(what)
            continue
        changes: Mapping[str, float] = {}
        text = f"{tried.state} (design {tried.number}): {tried.reason}"
        if tried.state == COMPLETE:
            changes, comparison = _compared(problem, best.objectives, tried.objectives)
            text = f"{comparison} (design {tried.number})"
        yield GuardOutcome(f"neighbour-{n}", what, f"{what}: {text}", changes)
    if left and problem.search.guards:
        text = (
            f"{len(left)} neighbours of the best design were not run and may be better: "
            f"{', '.join(left[:5])}"
        )
        yield GuardOutcome("neighbours", "neighbours", text, warning=True)


def _moves(
    problem: DesignProblem, best: Design, designs: Sequence[Design]
) -> Iterator[GuardOutcome]:
    """Return the changes due to moves from the best design of the search to designs next to it."""
    searched = [design for design in designs if design.state == COMPLETE and not design.next_to]
    if not best.next_to or not searched:
        return
    objective = problem.objectives[0]
    name = objective.name
    start = min(searched, key=lambda design: objective.sign * design.objectives[name])
    before = start.objectives[name]
    after = best.objectives[name]
    change = after / before - 1 if before else 0.0
    text = (
        f"the best design is a neighbour of the design from the search: {name} {before:.4g} of "
        f"design {start.number} became {after:.4g}"
    )
    yield GuardOutcome("moved", "moves to neighbours", text, {name: change}, abs(change) > NOTABLE)


def findings_without_runs(
    problem: DesignProblem, best: Design, summary: Mapping[str, Any], place: Path
) -> Iterator[GuardOutcome]:
    """Return the findings of the best design's run in the directory ``place``."""
    for note in best.notes:
        yield GuardOutcome("end", "the end of the run", note, warning=True)
    for variable in problem.space.variables:
        value = best.values[variable.key]
        end = variable.edge(value)
        if end:
            text = (
                f"{variable.key} = {show(value)} is at the {end} end of its range: a wider range "
                "may contain better designs"
            )
            yield GuardOutcome("edge", variable.key, text, warning=True)
    beyond = summary.get("contacts_beyond_law")
    if beyond:
        verb = "exceeds" if beyond == 1 else "exceed"
        text = f"{counted(beyond, 'contact')} {verb} the range of the contact law"
        yield GuardOutcome("law", "overlaps", text, warning=True)
    yield from _kinetic_energy_at_end(problem, best, summary)
    series = target_force(place)
    if series is not None:
        fraction = late_impulse(*series)
        text = (
            f"{100 * fraction:.0f} % of the impulse on the target occurs in the last tenth of the "
            "run"
        )
        yield GuardOutcome("impulse", "impulse", text, warning=fraction > _STILL)


def _kinetic_energy_at_end(
    problem: DesignProblem, best: Design, summary: Mapping[str, Any]
) -> Iterator[GuardOutcome]:
    """Return the kinetic fraction of the energy at the end of the run. There is no warning for
    elastic packings and chains, which rattle indefinitely.
    """
    energy_input = summary.get("energy_input_J")
    kinetic = summary.get("energy_kinetic_J")
    if not energy_input or kinetic is None:
        return
    case = problem.case(problem.tables_of(best.values))
    comes_to_rest = case.contact.yields and not case.packing.rule.is_chain
    fraction = kinetic / energy_input
    text = (
        f"{100 * fraction:.0f} % of the energy is kinetic at the end: rattling or ejected beads, "
        "or a moving target"
    )
    warning = fraction > _MOVING and comes_to_rest
    yield GuardOutcome("flight", "energy in free flight", text, warning=warning)


def target_force(place: Path) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the times, s, and the force on the bottom, N, of a run; None without a bottom."""
    try:
        with h5py.File(regular(place / RESULT_FILE), "r") as file:
            group = file.get("walls/bottom")
            return None if group is None else (group["time"][:], group["force"][:])
    except (OSError, KeyError):
        return None


def has_passed(force: np.ndarray) -> bool:
    """Return True if a force has fallen to a tenth of its peak."""
    if not has_come(force):
        return False
    rise = force - force[0]
    after_peak = rise[int(rise.argmax()) :]
    return bool(np.any(after_peak <= FALLEN * rise.max()))


def has_come(force: np.ndarray) -> bool:
    """Return True if the peak of a force is before the last record."""
    rise = force - force[0]
    return bool(rise.max(initial=0.0) > 0 and rise.argmax() < len(rise) - 1)


def late_impulse(time: np.ndarray, force: np.ndarray) -> float:
    """Return the fraction of the impulse that acts in the last tenth of a run."""
    impulse = np.diff(time) * (force[1:] + force[:-1]) / 2
    total = float(impulse.sum())
    is_late = time[1:] > 0.9 * time[-1]
    return float(impulse[is_late].sum() / total) if total > 0 else 0.0
