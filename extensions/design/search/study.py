"""Evaluated designs and their files.

An interrupted search resumes from study.json, from which designs.csv is made. A finished search
writes the cases of the best designs, design.json and the report.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import itertools
import json
import math
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import tomli_w

from granwave.analysis.reports.report import write_report
from granwave.analysis.versions import versions_of
from granwave.extensions.design.files import (
    BEST_DESIGNS,
    DESIGN_OUTCOME,
    DESIGN_STUDY,
    DESIGN_TABLE,
)
from granwave.extensions.design.search.points import names
from granwave.extensions.design.search.problem import DesignProblem, Objective, examined
from granwave.extensions.design.search.search import (
    TriedDesign,
    expected_random,
    front,
    importance,
    ordered,
)
from granwave.extensions.design.search.variables import Space, Values
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory, changed_values
from granwave.lammps_inputs.run_directory import POINTS, SCAN_REPORT
from granwave.workflows.run.record import versions

RUNNING = "running"
COMPLETE = "complete"
PRUNED = "pruned"
REFUSED = "refused"
FAILED = "failed"
MOST_REFUSED = 200  # consecutive rejected designs after which the search ends
_MAY_CHANGE = ("evaluations", "guards", "neighbours")  # keys of [search] of a resumed search


@dataclasses.dataclass
class Design:
    """A design, with the outcome of its checks and runs.

    Attributes
    ----------
    number
        Number from 1, in the order of choice.
    state
        `RUNNING`, `COMPLETE`, `PRUNED`, `REFUSED` or `FAILED`.
    reason
        Reason why it was pruned or rejected, or has failed.
    known
        Values of the packing that are known before a run, by name.
    runs
        Entries of each run, by the name of its directory: the ``value`` of objectives and limits,
        its duration divided by that of the file (``longer``), and a ``note``.
    objectives, spread
        Objectives by name; the smallest and the largest of several runs.
    margins, limited
        Relative distance beyond each limit; worst value of each limit that needs a run.
    full
        True if all its runs use the tolerance of the case.
    next_to
        Number of the best design next to which it was tried after the search; 0 for designs of the
        search itself.
    """

    number: int
    values: Values
    state: str = RUNNING
    reason: str = ""
    known: dict[str, float] = dataclasses.field(default_factory=dict)
    runs: dict[str, dict[str, Any]] = dataclasses.field(default_factory=dict)
    objectives: dict[str, float] = dataclasses.field(default_factory=dict)
    spread: dict[str, list[float]] = dataclasses.field(default_factory=dict)
    margins: dict[str, float] = dataclasses.field(default_factory=dict)
    limited: dict[str, float] = dataclasses.field(default_factory=dict)
    seconds: float = 0.0
    full: bool = False
    next_to: int = 0

    @property
    def ran(self) -> bool:
        """True if it was run, or is running."""
        return self.state != REFUSED or bool(self.runs)

    @property
    def notes(self) -> list[str]:
        """Notes of its runs."""
        return list(dict.fromkeys(run["note"] for run in self.runs.values() if run.get("note")))

    def losses(self, objectives: tuple[Objective, ...]) -> tuple[float, ...] | None:
        """Return the objectives with signs such that small values are good; None
        without a value.
        """
        if self.state in (RUNNING, FAILED) or len(self.objectives) < len(objectives):
            return None
        return tuple(objective.sign * self.objectives[objective.name] for objective in objectives)


@dataclasses.dataclass
class DesignStudy:
    """All designs of a search, in their order."""

    problem: DesignProblem
    directory: Path
    designs: list[Design] = dataclasses.field(default_factory=list)
    exhausted: int = 0  # evaluations of the file when no further design was found

    @property
    def n_evaluated(self) -> int:
        """Number of designs that the search ran or is running, without designs next to the best
        one.
        """
        return sum(design.ran and not design.next_to for design in self.designs)

    def unconfirmed(self) -> list[Design]:
        """Return the designs of the front, or of the best tenth (at least 3), that were not run in
        full.
        """
        objectives = self.problem.objectives
        if len(objectives) > 1:
            candidates = self.best()
        else:
            ranked = [design for design in self.designs if design.state in (COMPLETE, PRUNED)]
            ranked.sort(key=lambda design: design.losses(objectives) or ())
            candidates = ranked[: max(3, math.ceil(self.n_evaluated / 10))]
        return [design for design in candidates if not design.full]

    def best(self) -> list[Design]:
        """Return the designs that meet the limits, the best first; with two objectives only the
        Pareto front.
        """
        objectives = self.problem.objectives
        complete = [design for design in self.designs if design.state == COMPLETE]
        losses = [design.losses(objectives) or () for design in complete]
        if len(objectives) > 1:
            return [complete[n] for n in front(losses)]
        return sorted(complete, key=lambda design: design.losses(objectives) or ())

    def tried(self) -> list[TriedDesign]:
        """Return all designs in the form for the model of the search.

        Invalid cases and failed runs count as limits, so that the model avoids designs near them.
        """
        return [self._tried(design) for design in self.designs]

    def _tried(self, design: Design) -> TriedDesign:
        is_running = design.state == RUNNING
        margins = {**design.margins, "wrong": -1.0 if design.known else 1.0}
        if design.runs and not is_running:
            margins["failed"] = 1.0 if design.state == FAILED else -1.0
        losses = design.losses(self.problem.objectives)
        return TriedDesign(design.values, losses, margins, is_running)

    @property
    def search_arguments(self) -> tuple[Space, list[TriedDesign], int]:
        """Arguments of `ordered` and `promising`."""
        return self.problem.space, self.tried(), self.problem.search.seed

    def write(self) -> None:
        """Write study.json and designs.csv."""
        content = {
            "versions": versions_of(()),
            "problem": self.problem.record,
            "exhausted": self.exhausted,
        }
        content["designs"] = [dataclasses.asdict(design) for design in self.designs]
        replace_text(self.directory / DESIGN_STUDY, json.dumps(content, indent=1) + "\n")
        replace_text(self.directory / DESIGN_TABLE, self._table())

    def _table(self) -> str:
        """Return the text of designs.csv."""
        problem = self.problem
        packing_values: dict[
            str, None
        ] = {}  # values of the packing, in the order of their appearance
        for design in self.designs:
            packing_values.update(dict.fromkeys(design.known))
        objectives = [
            entry.name for entry in problem.objectives if entry.name not in packing_values
        ]
        limits = [
            entry.name
            for entry in problem.limits
            if entry.name not in (*packing_values, *objectives)
        ]
        spreads = []
        if len(problem.samples) > 1:
            for objective in problem.objectives:
                spreads += [f"{objective.name}_low", f"{objective.name}_high"]
        keys = [variable.key for variable in problem.space.variables]
        columns = [
            "number",
            "state",
            "reason",
            "directory",
            *keys,
            *packing_values,
            *objectives,
            *spreads,
        ]
        stream = io.StringIO()
        table = csv.DictWriter(stream, [*columns, *limits], restval="", lineterminator="\n")
        table.writeheader()
        for design in self.designs:
            table.writerow(self._row(design, objectives, limits))
        return stream.getvalue()

    def _row(
        self, design: Design, objectives: Collection[str], limits: Collection[str]
    ) -> dict[str, Any]:
        """Return the cells of a design, with the objectives and limits of these names."""
        row: dict[str, Any] = {
            name: value for name, value in design.limited.items() if name in limits
        }
        if design.state != PRUNED:  # the objective of a pruned design is an estimate
            row |= {name: value for name, value in design.objectives.items() if name in objectives}
        for name, (low, high) in design.spread.items():
            row |= {f"{name}_low": low, f"{name}_high": high}
        directory = ""
        if design.runs:
            directory = f"{POINTS}/{names(design.number, self.problem.samples)[0]}"
        reasons = [design.reason]
        if design.next_to:
            reasons.append(f"neighbour of design {design.next_to}, run after the search")
        reasons += design.notes
        row |= {
            "number": design.number,
            "state": design.state,
            "reason": "; ".join(filter(None, reasons)),
            "directory": directory,
        }
        for key, value in design.values.items():
            row[key] = value if isinstance(value, bool | int | float | str) else show(value)
        return row | design.known


def first_design(study: DesignStudy) -> None:
    """Check that some design meets the limits known before a run.

    Raises
    ------
    InputError
        No design meets the limits; the message has the nearest one.
    """
    if any(design.ran for design in study.designs):
        return
    refused: list[Design] = []
    drawn = ordered(*study.search_arguments, guided=False)
    for number, values in enumerate(itertools.islice(drawn, MOST_REFUSED), start=1):
        refused.append(new_design(study.problem, number, values))
        if refused[-1].state != REFUSED:
            return
    place = study.problem.path
    near = [design for design in refused if design.margins]
    if not near:
        faults = list(dict.fromkeys(design.reason.removeprefix(f"{place}: ") for design in refused))
        raise InputError([f"{place}: variables: {fault}" for fault in faults[:5]])
    nearest = min(near, key=lambda design: max(design.margins.values()))
    choice = ", ".join(f"{key} = {value}" for key, value in nearest.values.items())
    raise InputError(
        f"{place}: limits: none of {MOST_REFUSED} random designs, or of all designs, meets them; "
        f"the nearest is {choice}: {nearest.reason}; widen the limits or the ranges"
    )


def new_design(problem: DesignProblem, number: int, values: Mapping[str, Any]) -> Design:
    """Return a design with the values that are known before a run.

    It is rejected if its case is invalid, or if a value is beyond a limit.
    """
    values_before, margins, fault = examined(problem, dict(values))
    return Design(
        number, dict(values), REFUSED if fault else RUNNING, fault, values_before, margins=margins
    )


def read_study(problem: DesignProblem, directory: Path) -> DesignStudy:
    """Read the designs of an earlier start of the same search.

    Raises
    ------
    InputError
        The directory holds another search; the message lists the differences.
    """
    path = directory / DESIGN_STUDY
    if not path.exists():
        return DesignStudy(problem, directory)
    content = read_json(path)
    try:
        if content is None:
            raise ValueError
        stored = _comparable(content["problem"])
        designs = [Design(**record) for record in content["designs"]]
        exhausted = int(content.get("exhausted", 0))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{path}: is damaged, so the search cannot continue; restore the file, or use "
            "force=True to restart from the beginning"
        ) from None
    differences = [
        f"{name} was {_shown(before)}, is {_shown(now)}"
        for name, before, now in changed_values(stored, _comparable(problem.record))
    ]
    if differences:
        raise InputError(
            f"{directory}: holds another search: {'; '.join(differences[:5])}; give the same file "
            f"to resume=True, {ResultDirectory(directory).by_force}"
        )
    return DesignStudy(problem, directory, designs, exhausted)


def _comparable(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a search without the keys that a resumed search may change."""
    search = {
        key: value for key, value in tables.get("search", {}).items() if key not in _MAY_CHANGE
    }
    return json.loads(json.dumps({**tables, "search": search}))  # type: ignore[no-any-return]


def _shown(value: Any) -> str:
    return "left out" if value is None else show(value)


def publish(study: DesignStudy, findings: Iterable[Any]) -> None:
    """Write the cases of the best designs, design.json with the findings of `check_best`, and the
    report.
    """
    _write_best_cases(study)
    outcome = _outcome(study, findings)
    replace_text(study.directory / DESIGN_OUTCOME, json.dumps(outcome, indent=1) + "\n")
    write_report([study.directory], study.directory / SCAN_REPORT)


def _write_best_cases(study: DesignStudy) -> None:
    """Write the case files of the best designs, and remove earlier files."""
    problem = study.problem
    for name in BEST_DESIGNS:
        (study.directory / name).unlink(missing_ok=True)
    for name, design in zip(BEST_DESIGNS, study.best(), strict=False):
        first_run = next(iter(design.runs.values()))
        tables = problem.tables_of(design.values, longer=first_run["longer"])
        tables["name"] = f"{problem.name}-{name.removesuffix('.toml')}"
        replace_text(study.directory / name, tomli_w.dumps(problem.case(tables).to_dict()))


def _outcome(study: DesignStudy, findings: Iterable[Any]) -> dict[str, Any]:
    """Return the content of design.json."""
    problem = study.problem
    space = problem.space
    tried = study.tried()
    first, *others = problem.objectives
    at_random: list[float] = []  # expected best objective against the number of random designs
    if not others:
        counts = range(1, sum(design.ran for design in study.designs) + 1)
        at_random = expected_random(space, tried, counts)
    front_of_designs = [_values_of(problem, design) for design in study.best()]
    best = None
    if front_of_designs:
        best = {**front_of_designs[0], "guards": list(map(dataclasses.asdict, findings))}
    return {
        "name": problem.name,
        "objectives": {
            objective.name: "smallest" if objective.sign > 0 else "largest"
            for objective in problem.objectives
        },
        "statistic": problem.statistic,
        "best": best,
        "front": front_of_designs if others else None,
        "limits": {limit.name: {"low": limit.low, "high": limit.high} for limit in problem.limits},
        "evaluations": study.n_evaluated,
        "next_to_best": sum(bool(design.next_to) for design in study.designs),
        "states": dict(Counter(design.state for design in study.designs)),
        "designs": space.size if space.size < float("inf") else None,
        "importance": importance(space, tried),
        "random": [first.sign * loss for loss in at_random],
        "seconds": sum(design.seconds for design in study.designs),
        "versions": versions(),
    }


def _values_of(problem: DesignProblem, design: Design) -> dict[str, Any]:
    """Return the entry of a design in design.json."""
    values = {
        "number": design.number,
        "directory": f"{POINTS}/{names(design.number, problem.samples)[0]}",
        "variables": design.values,
        **design.known,
        "objective": design.objectives,
    }
    if design.spread:
        values |= {"spread": design.spread, "runs": len(problem.samples)}
    return values
