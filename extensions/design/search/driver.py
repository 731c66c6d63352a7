"""One search from its file to the best designs, checks and report; interrupted ones go on."""

from __future__ import annotations

import contextlib
import itertools
import logging
from collections import Counter, deque
from fnmatch import fnmatchcase
from importlib.util import find_spec
from pathlib import Path

from granwave.analysis.document.model import is_number
from granwave.extensions.design.files import (
    BEST_DESIGNS,
    DESIGN,
    DESIGN_OUTCOME,
    DESIGN_STUDY,
    DESIGN_TABLE,
)
from granwave.extensions.design.search import guards
from granwave.extensions.design.search.guards import check_best
from granwave.extensions.design.search.points import Ended, Points, default_jobs, load, names
from granwave.extensions.design.search.problem import DesignProblem, with_derived
from granwave.extensions.design.search.search import n_first, ordered, promising
from granwave.extensions.design.search.study import (
    COMPLETE,
    FAILED,
    MOST_REFUSED,
    PRUNED,
    REFUSED,
    RUNNING,
    Design,
    DesignStudy,
    first_design,
    new_design,
    publish,
    read_study,
)
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import POINTS, SCAN_REPORT
from granwave.workflows.run.directory import held
from granwave.workflows.run.progress import Progress

logger = logging.getLogger(__name__)

_ASKED = 10  # designs that are refused until the model is made anew
_MOST_STOPPED = 3  # times that a run may be stopped by somebody else
_MOST_LONGER = 3  # times that the end of a run is put off, each time to twice as late
_LOST = {
    "worst": 1.2
}  # times the best: a design whose runs so far are beyond it is not run further ...
_LOST_IN_THE_MEAN = 1.5  # ... where the mean or a quantile counts
_OF_PEAK = ("target_*", "wall_peak_force_N", "ground_*", "peak_reduction*")
_FILES = (DESIGN_STUDY, DESIGN_TABLE, DESIGN_OUTCOME, SCAN_REPORT, *BEST_DESIGNS)


def run_design(
    problem: DesignProblem,
    directory: str | Path,
    *,
    jobs: int | None = None,
    ranks: int = 1,
    resume: bool = False,
    force: bool = False,
    progress: bool = False,
) -> tuple[DesignStudy, bool]:
    """Search for the best design, check it by further runs, and write report and cases.

    Parameters
    ----------
    directory
        Directory of the results.
    jobs
        Number of simultaneous runs; by default the cores of this machine over the ranks.
    ranks
        MPI ranks of each run.
    resume
        Go on with an earlier start of the same search.
    force
        Move existing results into NAME.old.
    progress
        Show a bar (on a terminal) or lines (in a log).

    Returns
    -------
    Study, bool
        The designs; True if the search was stopped before its end.

    Raises
    ------
    InputError
        The directory holds results, another search, or files of others; no design meets the limits;
        or scikit-learn is missing.
    """
    results = ResultDirectory(results_directory(directory))
    if find_spec("sklearn") is None:
        raise InputError(
            'granwave design: scikit-learn is not installed; pip install "granwave[design]"'
        )
    with held(results), Interrupts() as stop:
        results.check(resume=resume, force=force)
        results.refuse_other_kind(DESIGN)
        if not resume and not force:
            results.refuse_results()
        results.refuse_foreign([*_FILES, f"{POINTS}/"])
        study = DesignStudy(problem, results.path) if force else read_study(problem, results.path)
        first_design(study)
        if force:
            results.make_room(force=True)
        results.claim(_FILES, kind=DESIGN)
        study.write()
        _Search(study, results, jobs or default_jobs(ranks), ranks, stop, show=progress).run()
        return study, bool(stop.count)


class _Search:
    def __init__(
        self,
        study: DesignStudy,
        results: ResultDirectory,
        jobs: int,
        ranks: int,
        stop: Interrupts,
        *,
        show: bool,
    ) -> None:
        self.study = study
        self.problem = study.problem
        self.jobs = jobs
        self.stop = stop
        self.show = show
        self.points = Points(results, ranks)
        self.queue: deque[tuple[Design, int]] = deque()  # runs to be started: design and sample
        self.at_work: dict[str, tuple[Design, int]] = {}

    def run(self) -> None:
        """Search, check the best design, and write the results."""
        load()
        study = self.study
        problem = self.problem
        total = self.problem.search.evaluations
        for design in study.designs:
            lost = [
                name
                for name in design.runs
                if not ResultDirectory(study.directory / POINTS / name).summary()
            ]
            if lost and design.state in (COMPLETE, PRUNED):
                logger.warning(
                    "%s: runs of design %d are gone; it is run again", problem.name, design.number
                )
                design.state = RUNNING
                design.reason = ""
                design.runs = {}
                design.objectives = {}
            if design.state == RUNNING:
                self._queue(design)
        self.bar = Progress(
            total, problem.name, enabled=self.show, done=self._n_done(), at_most=True
        )
        with contextlib.closing(self.bar):
            while self._fill() and not self.stop.count:
                self._take()
            if self.stop.count and self.points:
                logger.warning("%s: stopping; the runs in work write checkpoints ...", problem.name)
                self.points.stop()
                while self.points:
                    self._take()
        study.write()
        best = next(iter(study.best()), None)
        findings: list[guards.GuardOutcome] = []
        if best is not None and not self.stop.count:
            findings = check_best(study, best, self.points, self.jobs, self.stop, show=self.show)
        if not self.stop.count:
            publish(study, findings)

    def _n_done(self) -> int:
        done = sum(
            design.ran and design.state != RUNNING and not design.next_to
            for design in self.study.designs
        )
        return min(done, self.problem.search.evaluations)

    def _queue(self, design: Design) -> None:
        there = names(design.number, self.problem.samples)
        self.queue.extend(
            (design, n) for n, name in enumerate(there) if "value" not in design.runs.get(name, {})
        )

    def _end(self, design: Design, state: str, reason: str) -> None:
        design.state = state
        design.reason = reason
        self.queue = deque(entry for entry in self.queue if entry[0] is not design)

    # ------------------------------------------------------------------ runs

    def _fill(self) -> bool:
        """Start runs until all jobs are busy; return True while any is."""
        while (
            len(self.points) < self.jobs and not self.stop.count and (self.queue or self._choose())
        ):
            design, n = self.queue.popleft()
            name = names(design.number, self.problem.samples)[n]
            run = design.runs.setdefault(name, {"longer": 1.0})
            tables = self.problem.tables_of(
                design.values, self.problem.samples[n], longer=run["longer"]
            )
            self.study.write()
            try:
                self.points.start(name, tables if design.full else self.problem.cheaply(tables))
            except InputError as error:
                run["reason"] = "; ".join(error.errors)
                self._end(design, FAILED, run["reason"])
                continue
            self.at_work[name] = (design, n)
        return bool(self.points)

    def _take(self) -> None:
        """Take the values of runs that have ended."""
        finished = self.points.wait()
        for ended in finished:
            design, n = self.at_work.pop(ended.name)
            design.seconds += ended.seconds
            if (
                ended.interrupted
            ):  # by a signal: it goes on with the next start, or at once if it came from elsewhere
                design.runs[ended.name]["stopped"] = stopped = (
                    design.runs[ended.name].get("stopped", 0) + 1
                )
                if not self.stop.count and stopped < _MOST_STOPPED:
                    self.queue.appendleft((design, n))
                elif not self.stop.count:
                    self._end(design, FAILED, "its run was stopped from elsewhere")
                continue
            if design.state == RUNNING:
                self._note(design, n, ended)
            states = Counter(one.state for one in self.study.designs)
            parts = [f"{states[state]} {state}" for state in (REFUSED, FAILED) if states[state]]
            for best in self.study.best()[:1]:
                values = ", ".join(f"{name} {value:.4g}" for name, value in best.objectives.items())
                parts.insert(0, f"best {values} (design {best.number})")
            self.bar.update(self._n_done(), ", ".join(parts))
        if finished:
            self.study.write()

    def _note(self, design: Design, n: int, ended: Ended) -> None:
        """Enter the values of a run, or let it run longer; end the design with its last run."""
        run = design.runs[ended.name]
        problem = self.problem
        if ended.reason:
            return self._end(design, FAILED, ended.reason)
        of_peak = any(
            fnmatchcase(one.name, pattern) for one in problem.objectives for pattern in _OF_PEAK
        )
        series = (
            guards.target_force(self.study.directory / POINTS / ended.name) if of_peak else None
        )
        if series is not None and not guards.has_passed(series[1]):
            fixed = isinstance(
                problem.tables_of(design.values).get("run", {}).get("end_time"), int | float
            )
            if fixed and run["longer"] < 2**_MOST_LONGER:
                run["longer"] *= 2
                return self.queue.appendleft((design, n))
            if not guards.has_come(series[1]):
                end = f"{series[0][-1]:.3g} s"
                return self._end(
                    design,
                    REFUSED,
                    f"the force on the target still rises, or has not come, after {end}",
                )
            run["note"] = (
                "the force on the target has not fallen to a tenth of its peak at the end of the run"
            )
        values = with_derived(ended.summary, design.known["smallest_diameter_m"]) | design.known
        wanted = [one.name for one in problem.objectives] + [one.name for one in problem.limits]
        if missing := [name for name in wanted if not is_number(values.get(name))]:
            shown = ", ".join(
                f"{name}: {show(values.get(name)) if values.get(name) else 'null'}"
                for name in missing
            )
            return self._end(design, FAILED, f"{shown} in summary.json, expected a number")
        run["value"] = {name: float(values[name]) for name in wanted}
        if self._is_lost(design):
            return self._end(design, PRUNED, "its first runs are far beyond the best design")
        made = [one["value"] for one in design.runs.values() if "value" in one]
        if len(made) < len(problem.samples):
            return None
        for objective in problem.objectives:
            found = [row[objective.name] for row in made]
            design.objectives[objective.name] = problem.statistic_of(objective, found)
            if len(found) > 1:
                design.spread[objective.name] = [min(found), max(found)]
        faults = []
        for limit in problem.limits:
            worst = design.limited[limit.name] = max(
                (row[limit.name] for row in made), key=limit.margin
            )
            design.margins[limit.name] = limit.margin(worst)
            faults.append(limit.fault(worst))
        reason = "; ".join(filter(None, faults))
        return self._end(design, REFUSED if reason else COMPLETE, reason)

    def _is_lost(self, design: Design) -> bool:
        """Return True if the runs so far are that much worse than the best design that more runs
        hardly help.
        """
        problem = self.problem
        best = next(iter(self.study.best()), None)
        if best is None or len(problem.objectives) > 1 or (design.full and not design.next_to):
            return False
        (objective,) = problem.objectives
        mine = [run["value"][objective.name] for run in design.runs.values() if "value" in run]
        if len(mine) == len(problem.samples):
            return False
        same = [run["value"][objective.name] for run in best.runs.values()][
            : len(mine)
        ]  # with the same velocities ...
        ours, theirs = (problem.statistic_of(objective, values) for values in (mine, same))
        most = _LOST.get(str(problem.statistic), _LOST_IN_THE_MEAN) ** objective.sign
        if theirs <= 0 or objective.sign * ours <= objective.sign * most * theirs:
            return False
        design.objectives[objective.name] = (
            best.objectives[objective.name] * ours / theirs
        )  # for the model
        return True

    # --------------------------------------------------------------- designs

    def _choose(self) -> bool:
        """Queue the runs of the next design: of the search, the best once more in full, then those
        next to the best.

        Return False if there is none, or none until those at work have ended.
        """
        study = self.study
        problem = self.problem
        search = self.problem.search
        if study.exhausted < search.evaluations > study.n_evaluated and self._choose_of_space():
            return True
        if any(not design.next_to for design, _ in self.at_work.values()):
            return False
        if again := study.unconfirmed():
            for design in again:
                design.full, tables = True, problem.tables_of(design.values)
                if cheap := problem.cheaply(tables) != tables:
                    design.runs = {
                        name: {"longer": run["longer"]} for name, run in design.runs.items()
                    }
                if cheap or design.state == PRUNED:
                    design.state = RUNNING
                    design.reason = ""
                    design.objectives = {}
                    design.spread = {}
                    self._queue(design)
            return bool(self.queue) or self._choose()
        best = next(iter(study.best()), None)
        left = min(search.neighbours, search.evaluations) - sum(
            bool(design.next_to) for design in study.designs
        )
        if best is None or left <= 0 or not search.guards or search.sampler != "model":
            return False
        for values in promising(
            *study.asked, [values for _, values in problem.space.neighbours(best.values)]
        ):
            design = new_design(problem, len(study.designs) + 1, values)
            if design.state != REFUSED:
                design.full = True
                design.next_to = best.number
                study.designs.append(design)
                self._queue(design)
                return True
        return False

    def _choose_of_space(self) -> bool:
        study = self.study
        problem = self.problem
        guided = problem.search.sampler == "model"
        guided = guided and study.n_evaluated >= n_first(problem.space, problem.search.evaluations)
        before = len(study.designs)
        while len(study.designs) < before + MOST_REFUSED:
            first = len(study.designs)
            for values in itertools.islice(ordered(*study.asked, guided=guided), _ASKED):
                design = new_design(problem, len(study.designs) + 1, values)
                study.designs.append(design)
                if design.state != REFUSED:
                    self._queue(design)
                    return True
            if len(study.designs) == first:
                break
        else:
            text = "%s: ends after %d designs: %d more, one after the other, are beyond the limits, or are no packings"
            logger.warning(text, problem.name, study.n_evaluated, MOST_REFUSED)
        study.exhausted = problem.search.evaluations
        return False
