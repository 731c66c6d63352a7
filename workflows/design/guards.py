"""Checks of the best design: what the optimum could owe to the model, the runs or luck rather than to the packing.

Some are read from its run; the others are further runs with one thing changed. What changes an objective by more than
5 % stands in the first lines of the report.
"""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from granwave.lammps_inputs.case.parse import apply_overrides
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.disorder import is_random
from granwave.lammps_inputs.run_directory import RESULT_FILE
from granwave.workflows.design.keys import KNOWN_BEFORE
from granwave.workflows.design.problem import Problem, examined
from granwave.workflows.design.study import Design

Tables = dict[str, Any]
NOTABLE = 0.05  # change of an objective that is said first
FALLEN = 0.1  # of its peak: the force on a target has passed where it has fallen to that
_STILL = 0.05  # share of the impulse that may come in the last tenth of a run
_MOVING = 0.3  # share of the energy that may be kinetic at the end
_TOLERANCE = 5e-4  # of the diameter
_DEFAULT_TOLERANCE = 3e-6  # run.energy_tolerance


@dataclasses.dataclass(frozen=True)
class Guard:
    """A check of the best design by a further run.

    Attributes
    ----------
    name
        Name of the directory of its run, after ``best-``.
    what
        What is changed.
    change
        Function that returns the changed tables of a case; None where it does not apply.
    """

    name: str
    what: str
    change: Callable[[Tables], Tables | None]


@dataclasses.dataclass(frozen=True)
class Finding:
    """Outcome of a check.

    Attributes
    ----------
    name, what
        As of `Guard`.
    text
        What was found, in a sentence.
    changes
        Relative changes of the objectives by name; empty of checks that ran nothing.
    warning
        True if it belongs into the first lines.
    """

    name: str
    what: str
    text: str
    changes: Mapping[str, float] = dataclasses.field(default_factory=dict)
    warning: bool = False


def _wider(tables: Tables) -> Tables | None:
    packing, sides = tables["packing"], tables.get("boundary", {}).get("sides")
    size = packing.get("size")
    by_id = any("index" in entry for entry in tables.get("replace", []))
    if not isinstance(size, list) or sides == "periodic" or by_id:
        return None
    across = 1 if len(size) == 2 and packing["kind"] != "square" else 2  # crystals in the plane are one wide
    packing["size"] = [n + 2 * max(1, round(n / 4)) if place < across else n for place, n in enumerate(size)]
    return tables


def _longer(tables: Tables) -> Tables | None:
    end = tables["run"].get("end_time")
    if not isinstance(end, int | float):
        return None
    tables["run"]["end_time"] = 1.5 * end
    return tables


def _finer(tables: Tables) -> Tables | None:
    step = tables["run"].get("timestep", "auto")
    if isinstance(step, int | float):
        tables["run"]["timestep"] = step / 2
    else:
        tables["run"]["energy_tolerance"] = tables["run"].get("energy_tolerance", _DEFAULT_TOLERANCE) / 2
    return tables


def _with_tolerance(tables: Tables) -> Tables | None:
    packing = tables["packing"]
    if packing.get("diameter_scatter") or "diameter" not in packing:
        return None
    packing["diameter_scatter"] = _TOLERANCE * packing["diameter"]
    return tables


def _reseeded(tables: Tables) -> Tables | None:
    tables["packing"]["seed"] = tables["packing"].get("seed", 1) + 1000
    return tables


def _stiffer(tables: Tables) -> Tables | None:
    bottom = tables.get("boundary", {}).get("bottom")
    if not isinstance(bottom, dict) or "plate" not in bottom:
        return None
    bottom["plate"]["stiffness"] = 4 * bottom["plate"]["stiffness"]
    return tables


GUARDS = (
    Guard("wider", "a packing 1.5 times as wide", _wider),
    Guard("longer", "a run 1.5 times as long", _longer),
    Guard("finer", "half the error of the energy balance, or half the timestep", _finer),
    Guard("tolerance", "diameters that scatter by 0.05 %", _with_tolerance),
    Guard("seed", "another seed", _reseeded),
    Guard("stiffer", "a plate on a spring four times as stiff", _stiffer),
)


def further_runs(problem: Problem, best: Design, longer: float) -> Iterator[tuple[Guard, Tables]]:
    """Give the guards that apply to a design with the tables of their runs.

    ``longer``: how many times as late as in the design file its run has ended.
    """

    made = problem.tables_of(best.values, problem.samples[0])
    case = problem.case(made if longer == 1 else longer_end(made, longer))
    tables, random = case.to_dict(), is_random(case)
    for guard in GUARDS:
        if (guard.name == "seed") > random:
            continue
        changed = guard.change(copy.deepcopy(tables))
        if changed is not None and _reads(problem, changed):
            yield guard, changed


def _reads(problem: Problem, tables: Tables) -> bool:
    try:
        problem.case(tables)
    except InputError:
        return False
    return True


def finding_of(guard: Guard, problem: Problem, before: Mapping[str, Any], after: Mapping[str, Any]) -> Finding:
    """Compare the objectives of a further run with those of the run of the best design."""
    changes = {}
    for one in problem.objectives:
        old, new = before.get(one.name), after.get(one.name)
        if isinstance(old, int | float) and isinstance(new, int | float) and old:
            changes[one.name] = new / old - 1
    if not changes:
        return Finding(guard.name, guard.what, f"{guard.what}: gives no value", {}, warning=True)
    notable = any(abs(change) > NOTABLE for change in changes.values())
    of_runs = [one for one in problem.limits if one.name not in KNOWN_BEFORE and one.name in after]
    beyond = [fault for one in of_runs if (fault := one.fault(after[one.name] or 0.0))]
    said = ", ".join(f"{name} {after[name]:.4g} ({100 * change:+.1f} %)" for name, change in changes.items())
    said += "".join(f"; beyond a limit: {fault}" for fault in beyond)
    return Finding(guard.name, guard.what, f"{guard.what}: {said}", changes, notable or bool(beyond))


def of_neighbours(problem: Problem, best: Design, designs: Sequence[Design]) -> Iterator[Finding]:
    """Give what was found next to the best design, and how it was moved there."""
    first = problem.objectives[0]
    by_values = {repr(one.values): one for one in designs}
    feasible = [one for one in designs if one.feasible and not one.next_to]
    if best.next_to and feasible:
        start = min(feasible, key=lambda one: first.loss(one.objectives[first.name]))
        before, after = (one.objectives[first.name] for one in (start, best))
        said = f"{first.name} {before:.4g} of design {start.number} became {after:.4g}"
        text = f"the best design was found next to that of the search: {said}"
        change = after / before - 1 if before else 0.0
        yield Finding("moved", "moves to neighbours", text, {first.name: change}, abs(change) > NOTABLE)
    left = []
    for n, (key, values) in enumerate(problem.space.neighbours(best.values), start=1):
        what, tried = f"{key} = {show(values[key])}", by_values.get(repr(values))
        if tried is None:
            left += [] if examined(problem, values)[2] else [what]
        elif tried.feasible:
            pairs = {one.name: (tried.objectives[one.name], best.objectives[one.name]) for one in problem.objectives}
            changes = {name: new / old - 1 for name, (new, old) in pairs.items() if old}
            said = ", ".join(f"{name} {pairs[name][0]:.4g} ({100 * change:+.1f} %)" for name, change in changes.items())
            yield Finding(f"neighbour-{n}", what, f"{what}: {said} (design {tried.number})", changes)
        else:
            text = f"{what}: {tried.state} (design {tried.number}): {tried.reason}"
            yield Finding(f"neighbour-{n}", what, text)
    if left and problem.search.guards:
        text = f"next to the best, {len(left)} not run that may be better: {', '.join(left[:5])}"
        yield Finding("neighbours", "neighbours", text, warning=True)


def findings_without_runs(problem: Problem, best: Design, summary: Mapping[str, Any], place: Path) -> list[Finding]:
    """Return what is to be said of the best design from its own run."""
    found = [Finding("end", "the end of the run", note, {}, warning=True) for note in best.notes]
    for one in problem.space.variables:
        if end := one.edge(best.values[one.key]):
            chosen = f"{one.key} = {show(best.values[one.key])}"
            text = f"{chosen} is at the {end} end of its range: a wider range may hold better"
            found.append(Finding("edge", one.key, text, {}, warning=True))
    if beyond := summary.get("contacts_beyond_law"):
        text = f"{beyond} contacts are pressed beyond the range of the contact law"
        found.append(Finding("law", "overlaps", text, {}, warning=True))
    case = problem.case(problem.tables_of(best.values))
    yields = case.contact.yields and case.packing.kind != "chain"  # elastic packings, and rows, rattle for ever
    given, kinetic = summary.get("energy_input_J"), summary.get("energy_kinetic_J")
    if given and kinetic is not None:
        share = kinetic / given
        moving = "beads that rattle or fly off, or a target that moves"
        text = f"{100 * share:.0f} % of the energy is kinetic at the end: {moving}"
        found.append(Finding("flight", "energy in free flight", text, {}, share > _MOVING and yields))
    if (series := target_force(place)) is not None:
        share = late_impulse(*series)
        text = f"{100 * share:.0f} % of the impulse on the target comes in the last tenth of the run"
        found.append(Finding("impulse", "impulse", text, {}, share > _STILL))
    return found


def target_force(place: Path) -> tuple[np.ndarray, np.ndarray] | None:
    """Return times, s, and force on the bottom, N, of a run; None without a bottom."""
    try:
        with h5py.File(place / RESULT_FILE) as file:
            group = file.get("walls/bottom")
            return None if group is None else (group["time"][:], group["force"][:])
    except (OSError, KeyError):
        return None


def has_passed(force: np.ndarray) -> bool:
    """Return True if a force has had its peak and fallen to a tenth of it."""
    rise = force - force[0]
    return has_come(force) and bool(np.any(rise[int(rise.argmax()) :] <= FALLEN * rise.max()))


def has_come(force: np.ndarray) -> bool:
    """Return True if a force has risen and had its peak before the last record."""
    rise = force - force[0]
    return bool(rise.max(initial=0.0) > 0 and rise.argmax() < len(rise) - 1)


def late_impulse(time: np.ndarray, force: np.ndarray) -> float:
    """Return the share of the impulse that comes in the last tenth of a run."""
    pieces = np.diff(time) * (force[1:] + force[:-1]) / 2
    total = float(pieces.sum())
    return float(pieces[time[1:] > 0.9 * time[-1]].sum() / total) if total > 0 else 0.0


def longer_end(tables: Mapping[str, Any], times: float) -> Tables:
    """Return the tables of a case with an end time that is so many times as late."""
    return apply_overrides(tables, {"run.end_time": times * tables["run"]["end_time"]})
