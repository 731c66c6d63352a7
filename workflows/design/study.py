"""Evaluated designs, kept in study.json, from which an interrupted search goes on; and designs.csv, made of them."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json, replace_text
from granwave.lammps_inputs.run_directory import DESIGN_STUDY, DESIGN_TABLE, POINTS
from granwave.workflows.design.points import names
from granwave.workflows.design.problem import Objective, Problem, examined
from granwave.workflows.design.search import Known, front, ordered
from granwave.workflows.design.variables import Space, Values

RUNNING, COMPLETE, PRUNED, REFUSED, FAILED = "running", "complete", "pruned", "refused", "failed"
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
        Values of each run, by the name of its directory: objectives and limits, how many times ``longer`` than in the
        file it was, and a ``note``.
    objectives, spread
        Objectives by name; the smallest and the largest of several runs.
    margins, limited
        By limit, how far its value is beyond it; and the worst value of those that are known after a run.
    full
        True if all its runs are, or are to be, made with the tolerance of the case.
    next_to
        Number of the best design next to which it was tried after the search; 0 of designs of the search.
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
    def feasible(self) -> bool:
        """True if it was run to its end and meets all limits."""
        return self.state == COMPLETE

    @property
    def notes(self) -> list[str]:
        """Marks of its runs."""
        return list(dict.fromkeys(run["note"] for run in self.runs.values() if run.get("note")))

    def losses(self, objectives: tuple[Objective, ...]) -> tuple[float, ...] | None:
        """Return the numbers that are to be small; None without a value."""
        if self.state in (RUNNING, FAILED) or len(self.objectives) < len(objectives):
            return None
        return tuple(one.loss(self.objectives[one.name]) for one in objectives)

    def as_known(self, objectives: tuple[Objective, ...]) -> Known:
        """Return what the search is told."""
        failed = {"failed": 1.0 if self.state == FAILED else -1.0} if self.runs and self.state != RUNNING else {}
        margins = {**self.margins, "wrong": -1.0 if self.known else 1.0, **failed}  # a wrong case has no known values
        return Known(self.values, self.losses(objectives), margins, self.state == RUNNING)


@dataclasses.dataclass
class Study:
    """All designs of a search, in their order."""

    problem: Problem
    directory: Path
    designs: list[Design] = dataclasses.field(default_factory=list)
    exhausted: int = 0  # evaluations that were asked for when no more designs were found

    @property
    def n_evaluated(self) -> int:
        """Number of designs that the search ran, or that are in work; without those next to the best."""
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
        """Return the designs that meet the limits, the best first; with two objectives those of the Pareto front."""
        objectives = self.problem.objectives
        found = [design for design in self.designs if design.feasible]
        losses = [design.losses(objectives) or () for design in found]
        if len(objectives) > 1:
            return [found[n] for n in front(losses)]
        return [found[n] for n in sorted(range(len(found)), key=lambda n: losses[n])]

    def known(self) -> list[Known]:
        """Return what the search is told of all designs."""
        return [design.as_known(self.problem.objectives) for design in self.designs]

    @property
    def asked(self) -> tuple[Space, list[Known], int]:
        """Arguments of `ordered` and `promising`."""
        return self.problem.space, self.known(), self.problem.search.seed

    def write(self) -> None:
        """Write study.json and designs.csv."""
        content = {"versions": versions_of(()), "problem": self.problem.record, "exhausted": self.exhausted}
        content["designs"] = [dataclasses.asdict(one) for one in self.designs]
        replace_text(self.directory / DESIGN_STUDY, json.dumps(content, indent=1) + "\n")
        replace_text(self.directory / DESIGN_TABLE, self._table())

    def _table(self) -> str:
        problem = self.problem
        spread = len(problem.samples) > 1
        several = [part for one in problem.objectives for part in (f"{one.name}_low", f"{one.name}_high")]
        keys = [one.key for one in problem.space.variables]
        stream = io.StringIO()
        table = csv.writer(stream, lineterminator="\n")
        more = list(dict.fromkeys(name for one in self.designs for name in one.known))
        named = [one.name for one in problem.objectives if one.name not in more]
        limited = [one.name for one in problem.limits if one.name not in (*more, *named)]
        heads = [*keys, *more, *named, *(several if spread else []), *limited]
        table.writerow(["number", "state", "reason", "directory", *heads])
        for design in self.designs:
            place = f"{POINTS}/{names(design.number, problem.samples)[0]}" if design.runs else ""
            cells = [_written(design.values[key]) for key in keys]
            known = [design.known.get(name, "") for name in more]
            known_all = design.state != PRUNED  # of a pruned design the objective is that of its first runs
            objectives = [design.objectives.get(name, "") if known_all else "" for name in named]
            ends = (
                [end for name in [one.name for one in problem.objectives] for end in design.spread.get(name, ["", ""])]
                if spread
                else []
            )
            limits = [design.limited.get(name, "") for name in limited]
            place_of = f"next to design {design.next_to}, tried after the search" if design.next_to else ""
            reason = "; ".join(filter(None, (design.reason, place_of, *design.notes)))
            table.writerow([design.number, design.state, reason, place, *cells, *known, *objectives, *ends, *limits])
        return stream.getvalue()


def _written(value: Any) -> Any:
    return value if isinstance(value, bool | int | float | str) else show(value)


def first_design(study: Study) -> None:
    """Raise InputError if no design can be found that meets the limits known before a run; changes nothing."""
    if any(design.ran for design in study.designs):
        return
    nearest: tuple[float, Design] | None = None
    faults: dict[str, int] = {}
    trial = Study(study.problem, study.directory, list(study.designs))
    for n, values in zip(range(MOST_REFUSED), ordered(*trial.asked, guided=False), strict=False):
        design = new_design(study.problem, len(trial.designs) + n + 1, values)
        if design.state != REFUSED:
            return
        if design.margins:
            worst = max(design.margins.values())
            nearest = min(nearest or (worst, design), (worst, design), key=lambda pair: pair[0])
        else:
            faults[design.reason] = faults.get(design.reason, 0) + 1
    place = study.problem.path
    if nearest is None:
        raise InputError([f"{place}: variables: {fault.removeprefix(f'{place}: ')}" for fault in list(faults)[:5]])
    design = nearest[1]
    made = ", ".join(f"{key} = {value}" for key, value in design.values.items())
    raise InputError(
        f"{place}: limits: no design meets them, of {MOST_REFUSED} drawn or all that there are; "
        f"the nearest is {made}: {design.reason}; widen the limits or the ranges"
    )


def new_design(problem: Problem, number: int, values: Mapping[str, Any]) -> Design:
    """Return a design with what is known before a run; refused where its case is wrong, or beyond a limit."""
    known, margins, fault = examined(problem, dict(values))
    return Design(number, dict(values), REFUSED if fault else RUNNING, fault, known, margins=margins)


def read_study(problem: Problem, directory: Path) -> Study:
    """Read the designs of an earlier start of the same search.

    Raises
    ------
    InputError
        The directory holds another search; the message says what differs.
    """
    path = directory / DESIGN_STUDY
    if not path.exists():
        return Study(problem, directory)
    content = read_json(path)
    try:
        if content is None:
            raise ValueError
        there, designs = _comparable(content["problem"]), [Design(**one) for one in content["designs"]]
        exhausted = int(content.get("exhausted", 0))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{path}: is damaged, so that the search cannot go on; --force begins it again, or put the file back"
        ) from None
    here = _comparable(problem.record)
    if differences := list(_differences(there, here)):
        raise InputError(
            f"{directory}: holds another search: {'; '.join(differences[:5])}; give the same file to --resume, "
            "--force replaces it, or choose another directory with -o"
        )
    return Study(problem, directory, designs, exhausted)


def _comparable(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables without what may change: the number of evaluations, and what follows them."""
    may_change = ("evaluations", "guards", "neighbours")
    search = {key: value for key, value in tables.get("search", {}).items() if key not in may_change}
    return json.loads(json.dumps({**tables, "search": search}))  # type: ignore[no-any-return]


def _differences(there: Mapping[str, Any], here: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for key in dict.fromkeys((*there, *here)):
        before, now, name = there.get(key), here.get(key), f"{prefix}{key}"
        if isinstance(before, Mapping) and isinstance(now, Mapping):
            yield from _differences(before, now, f"{name}.")
        elif before != now:
            was, now_is = ("left out" if value is None else show(value) for value in (before, now))
            yield f"{name} was {was}, is {now_is}"
