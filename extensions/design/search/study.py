"""Evaluated designs and their files.

study.json, from which an interrupted search goes on, and designs.csv, made of it; and of a finished
search the cases of the best designs, design.json and the report.
"""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from collections import Counter
from collections.abc import Iterable, Mapping
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
    Known,
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
MOST_REFUSED = 200  # designs that are refused, one after the other, before the search ends


@dataclasses.dataclass
class Design:
    """A design and what is known of it.

    Attributes
    ----------
    number
        From 1, in the order of their choice.
    state
        `RUNNING`, `COMPLETE`, `PRUNED`, `REFUSED` or `FAILED`.
    reason
        Why it was pruned or refused, or has failed.
    known
        Values of the packing before a run, by name.
    runs
        Values of each run, by the name of its directory: objectives and limits, how many times
        ``longer`` than in the file it was, and a ``note``.
    objectives, spread
        Objectives by name; the smallest and the largest of several runs.
    margins, limited
        By limit, how far its value is beyond it; and the worst value of those that are known after
        a run.
    full
        True if all its runs are, or are to be, made with the tolerance of the case.
    next_to
        Number of the best design next to which it was tried after the search; 0 of designs of the
        search.
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
        """True if it was run, or is in work."""
        return self.state != REFUSED or bool(self.runs)

    @property
    def notes(self) -> list[str]:
        """Marks of its runs."""
        return list(dict.fromkeys(run["note"] for run in self.runs.values() if run.get("note")))

    def losses(self, objectives: tuple[Objective, ...]) -> tuple[float, ...] | None:
        """Return the numbers that are to be small; None without a value."""
        if self.state in (RUNNING, FAILED) or len(self.objectives) < len(objectives):
            return None
        return tuple(one.sign * self.objectives[one.name] for one in objectives)


@dataclasses.dataclass
class DesignStudy:
    """All designs of a search, in their order."""

    problem: DesignProblem
    directory: Path
    designs: list[Design] = dataclasses.field(default_factory=list)
    exhausted: int = 0  # evaluations that were asked for when no more designs were found

    @property
    def n_evaluated(self) -> int:
        """Number of designs that the search ran, or that are in work; without those next to the
        best.
        """
        return sum(design.ran and not design.next_to for design in self.designs)

    def unconfirmed(self) -> list[Design]:
        """Return those of the best tenth (3 at least; of the front) that were not run in full."""
        if len(self.problem.objectives) > 1:
            found = self.best()
        else:
            ranked = [design for design in self.designs if design.state in (COMPLETE, PRUNED)]
            ranked.sort(key=lambda design: design.losses(self.problem.objectives) or ())
            found = ranked[: max(3, -(-self.n_evaluated // 10))]
        return [design for design in found if not design.full]

    def best(self) -> list[Design]:
        """Return the designs that meet the limits, the best first; with two objectives those of the
        Pareto front.
        """
        objectives = self.problem.objectives
        found = [design for design in self.designs if design.state == COMPLETE]
        losses = [design.losses(objectives) or () for design in found]
        if len(objectives) > 1:
            return [found[n] for n in front(losses)]
        return [found[n] for n in sorted(range(len(found)), key=lambda n: losses[n])]

    def known(self) -> list[Known]:
        """Return what the search is told of all designs."""
        found = []
        for one in self.designs:
            failed = (
                {"failed": 1.0 if one.state == FAILED else -1.0}
                if one.runs and one.state != RUNNING
                else {}
            )
            margins = {
                **one.margins,
                "wrong": -1.0 if one.known else 1.0,
                **failed,
            }  # a wrong case has no known values
            found.append(
                Known(
                    one.values, one.losses(self.problem.objectives), margins, one.state == RUNNING
                )
            )
        return found

    @property
    def asked(self) -> tuple[Space, list[Known], int]:
        """Arguments of `ordered` and `promising`."""
        return self.problem.space, self.known(), self.problem.search.seed

    def write(self) -> None:
        """Write study.json and designs.csv."""
        content = {
            "versions": versions_of(()),
            "problem": self.problem.record,
            "exhausted": self.exhausted,
        }
        content["designs"] = [dataclasses.asdict(one) for one in self.designs]
        replace_text(self.directory / DESIGN_STUDY, json.dumps(content, indent=1) + "\n")
        replace_text(self.directory / DESIGN_TABLE, self._table())

    def _table(self) -> str:
        problem = self.problem
        more = list(dict.fromkeys(name for one in self.designs for name in one.known))
        named = [one.name for one in problem.objectives if one.name not in more]
        limited = [one.name for one in problem.limits if one.name not in (*more, *named)]
        heads = [
            "number",
            "state",
            "reason",
            "directory",
            *(one.key for one in problem.space.variables),
            *more,
            *named,
        ]
        if len(problem.samples) > 1:
            heads += [f"{one.name}_{end}" for one in problem.objectives for end in ("low", "high")]
        stream = io.StringIO()
        table = csv.DictWriter(stream, [*heads, *limited], restval="", lineterminator="\n")
        table.writeheader()
        for design in self.designs:
            place = f"{POINTS}/{names(design.number, problem.samples)[0]}" if design.runs else ""
            tried = (
                f"next to design {design.next_to}, tried after the search" if design.next_to else ""
            )
            reason = "; ".join(filter(None, (design.reason, tried, *design.notes)))
            row: dict[str, Any] = {
                name: value for name, value in design.limited.items() if name in limited
            }
            if design.state != PRUNED:  # of which the objective is that of its first runs
                row |= {name: value for name, value in design.objectives.items() if name in named}
            for name, ends in design.spread.items():
                row |= {f"{name}_low": ends[0], f"{name}_high": ends[1]}
            row |= {
                "number": design.number,
                "state": design.state,
                "reason": reason,
                "directory": place,
            }
            values = {key: one if isinstance(one, bool | int | float | str) else show(one)
                      for key, one in design.values.items()}  # fmt: skip
            table.writerow({**row, **values, **design.known})
        return stream.getvalue()


def first_design(study: DesignStudy) -> None:
    """Raise InputError if no design can be found that meets the limits known before a run; changes
    nothing.
    """
    if any(design.ran for design in study.designs):
        return
    refused: list[Design] = []
    for n, values in zip(range(MOST_REFUSED), ordered(*study.asked, guided=False), strict=False):
        refused.append(new_design(study.problem, n + 1, values))
        if refused[-1].state != REFUSED:
            return
    place = study.problem.path
    near = [design for design in refused if design.margins]
    if not near:
        faults = list(dict.fromkeys(design.reason.removeprefix(f"{place}: ") for design in refused))
        raise InputError([f"{place}: variables: {fault}" for fault in faults[:5]])
    nearest = min(near, key=lambda design: max(design.margins.values()))
    made = ", ".join(f"{key} = {value}" for key, value in nearest.values.items())
    raise InputError(
        f"{place}: limits: no design meets them, of {MOST_REFUSED} drawn or all that there are; "
        f"the nearest is {made}: {nearest.reason}; widen the limits or the ranges"
    )


def new_design(problem: DesignProblem, number: int, values: Mapping[str, Any]) -> Design:
    """Return a design with what is known before a run; refused where its case is wrong, or beyond a
    limit.
    """
    known, margins, fault = examined(problem, dict(values))
    return Design(
        number, dict(values), REFUSED if fault else RUNNING, fault, known, margins=margins
    )


def read_study(problem: DesignProblem, directory: Path) -> DesignStudy:
    """Read the designs of an earlier start of the same search.

    Raises
    ------
    InputError
        The directory holds another search; the message says what differs.
    """

    def comparable(tables: Mapping[str, Any]) -> dict[str, Any]:
        """Return the tables without what may change: the number of evaluations, and what follows
        them.
        """
        may_change = ("evaluations", "guards", "neighbours")
        search = {
            key: value for key, value in tables.get("search", {}).items() if key not in may_change
        }
        return json.loads(json.dumps({**tables, "search": search}))  # type: ignore[no-any-return]

    path = directory / DESIGN_STUDY
    if not path.exists():
        return DesignStudy(problem, directory)
    content = read_json(path)
    try:
        if content is None:
            raise ValueError
        there = comparable(content["problem"])
        designs = [Design(**one) for one in content["designs"]]
        exhausted = int(content.get("exhausted", 0))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{path}: is damaged, so that the search cannot go on; force=True begins it again, or put the file back"
        ) from None
    differences = [
        f"{name} was {_shown(before)}, is {_shown(now)}"
        for name, before, now in changed_values(there, comparable(problem.record))
    ]
    if differences:
        raise InputError(
            f"{directory}: holds another search: {'; '.join(differences[:5])}; give the same file to resume=True, "
            f"{ResultDirectory(directory).by_force}"
        )
    return DesignStudy(problem, directory, designs, exhausted)


def _shown(value: Any) -> str:
    return "left out" if value is None else show(value)


def publish(study: DesignStudy, findings: Iterable[Any]) -> None:
    """Write the cases of the best designs, design.json with the findings of `check_best`, and the
    report.
    """
    problem = study.problem
    best = study.best()
    for name in BEST_DESIGNS:
        (study.directory / name).unlink(missing_ok=True)
    for name, design in zip(BEST_DESIGNS, best, strict=False):
        tables = problem.tables_of(design.values, longer=next(iter(design.runs.values()))["longer"])
        tables = problem.case(
            {**tables, "name": f"{problem.name}-{name.removesuffix('.toml')}"}
        ).to_dict()
        replace_text(study.directory / name, tomli_w.dumps(tables))

    def values_of(design: Design) -> dict[str, Any]:
        return {
            "number": design.number,
            "directory": f"{POINTS}/{names(design.number, problem.samples)[0]}",
            "variables": design.values,
            **design.known,
            "objective": design.objectives,
            **({"spread": design.spread, "runs": len(problem.samples)} if design.spread else {}),
        }

    (first, *others), known, space = problem.objectives, study.known(), problem.space
    counts = range(1, sum(design.ran for design in study.designs) + 1)
    at_random = (
        [] if others else expected_random(space, known, counts)
    )  # the best of so many, by the model
    outcome = {
        "name": problem.name,
        "objectives": {
            one.name: "smallest" if one.sign > 0 else "largest" for one in problem.objectives
        },
        "best": {**values_of(best[0]), "guards": list(map(dataclasses.asdict, findings))}
        if best
        else None,
        "front": list(map(values_of, best)) if others else None,
        "limits": {one.name: {"low": one.low, "high": one.high} for one in problem.limits},
        "evaluations": study.n_evaluated,
        "next_to_best": sum(bool(design.next_to) for design in study.designs),
        "states": dict(Counter(design.state for design in study.designs)),
        "designs": space.size if space.size < float("inf") else None,
        "importance": importance(space, known),
        "random": [first.sign * loss for loss in at_random],
        "seconds": sum(design.seconds for design in study.designs),
        "versions": versions(),
    }
    replace_text(study.directory / DESIGN_OUTCOME, json.dumps(outcome, indent=1) + "\n")
    write_report([study.directory], study.directory / SCAN_REPORT)
