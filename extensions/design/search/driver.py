"""Search from its file to the best designs, checks and report; interrupted searches resume."""

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

_REFUSED_AT_ONCE = 10  # rejected designs until the model is updated
_MOST_STOPPED = 3  # number of external stops after which a run has failed
_MOST_LONGER = 3  # number of times that the duration of a run is doubled
# ratio to the best design above which a design is run no further, by the statistic of its runs
_LOST = {"worst": 1.2}
_LOST_IN_THE_MEAN = 1.5  # ratio for the mean and quantiles
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
        Number of simultaneous runs; by default the cores of this machine divided by the ranks.
    ranks
        MPI ranks of each run.
    resume
        Resume an earlier start of the same search.
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
        The directory holds results, another search, or foreign files; no design meets the limits;
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
            if self._has_lost_runs(design):
                logger.warning(
                    "%s: runs of design %d are missing; they are repeated",
                    problem.name,
                    design.number,
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
                logger.warning("%s: stopping; current runs write checkpoints ...", problem.name)
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

    def _has_lost_runs(self, design: Design) -> bool:
        """Return True if a design has ended, but the summary of one of its runs is missing."""
        if design.state not in (COMPLETE, PRUNED):
            return False
        points = self.study.directory / POINTS
        return any(not ResultDirectory(points / name).summary() for name in design.runs)

    def _n_done(self) -> int:
        """Return the number of evaluations that have ended."""
        done = sum(
            design.ran and design.state != RUNNING and not design.next_to
            for design in self.study.designs
        )
        return min(done, self.problem.search.evaluations)

    def _queue(self, design: Design) -> None:
        """Queue the runs of a design that have no values yet."""
        directories = names(design.number, self.problem.samples)
        self.queue.extend(
            (design, n)
            for n, name in enumerate(directories)
            if "value" not in design.runs.get(name, {})
        )

    def _end(self, design: Design, state: str, reason: str) -> None:
        """End a design with a state, and remove its queued runs."""
        design.state = state
        design.reason = reason
        self.queue = deque(entry for entry in self.queue if entry[0] is not design)

    # ------------------------------------------------------------------ runs

    def _fill(self) -> bool:
        """Start runs until all jobs are busy; return True if any job is busy."""
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
        """Process the values of runs that have ended."""
        finished = self.points.wait()
        for ended in finished:
            design, n = self.at_work.pop(ended.name)
            design.seconds += ended.seconds
            if ended.interrupted:
                self._put_back(design, n, ended)
                continue
            if design.state == RUNNING:
                self._enter(design, n, ended)
            self._show_progress()
        if finished:
            self.study.write()

    def _put_back(self, design: Design, n: int, ended: Ended) -> None:
        """Queue a run again that was stopped by a signal.

        If this search is stopped itself, its next start resumes the run.
        """
        run = design.runs[ended.name]
        run["stopped"] = run.get("stopped", 0) + 1
        if self.stop.count:
            return
        if run["stopped"] < _MOST_STOPPED:
            self.queue.appendleft((design, n))
        else:
            self._end(design, FAILED, "its run was stopped externally")

    def _show_progress(self) -> None:
        """Show the best objectives, and the numbers of rejected and failed designs."""
        parts = []
        for best in self.study.best()[:1]:
            values = ", ".join(f"{name} {value:.3g}" for name, value in best.objectives.items())
            parts.append(f"best {values} (design {best.number})")
        states = Counter(design.state for design in self.study.designs)
        parts += [f"{states[state]} {state}" for state in (REFUSED, FAILED) if states[state]]
        self.bar.update(self._n_done(), ", ".join(parts))

    def _enter(self, design: Design, n: int, ended: Ended) -> None:
        """Enter the values of a run, or let it run longer; end the design with its last run."""
        if ended.reason:
            self._end(design, FAILED, ended.reason)
        elif self._has_passed(design, n, ended) and self._has_values(design, ended):
            if self._is_lost(design):
                self._end(design, PRUNED, "its first runs are much worse than the best design")
            else:
                self._complete(design)

    def _has_passed(self, design: Design, n: int, ended: Ended) -> bool:
        """Return True if a run can be evaluated: the force on the target has passed, if the
        objectives depend on it.

        Otherwise the run is queued with twice the duration, or the design ends.
        """
        run = design.runs[ended.name]
        if not _depends_on_peak(self.problem):
            return True
        series = guards.target_force(self.study.directory / POINTS / ended.name)
        if series is None:
            return True
        time, force = series
        if guards.has_passed(force):
            return True
        end_time = self.problem.tables_of(design.values).get("run", {}).get("end_time")
        if isinstance(end_time, int | float) and run["longer"] < 2**_MOST_LONGER:
            run["longer"] *= 2
            self.queue.appendleft((design, n))
            return False
        if not guards.has_come(force):
            reason = "the force on the target still rises, or has not arrived, after"
            self._end(design, REFUSED, f"{reason} {time[-1]:.3g} s")
            return False
        run["note"] = (
            "the force on the target has not fallen to a tenth of its peak at the end of the run"
        )
        return True

    def _has_values(self, design: Design, ended: Ended) -> bool:
        """Enter the values of a run that objectives and limits need; the design
        fails without them.
        """
        problem = self.problem
        values = with_derived(ended.summary, design.known["smallest_diameter_m"]) | design.known
        names_of_values = [objective.name for objective in problem.objectives]
        names_of_values += [limit.name for limit in problem.limits]
        missing = [name for name in names_of_values if not is_number(values.get(name))]
        if missing:
            shown = ", ".join(
                f"{name}: {show(values.get(name)) if values.get(name) else 'null'}"
                for name in missing
            )
            self._end(design, FAILED, f"{shown} in summary.json, expected a number")
            return False
        design.runs[ended.name]["value"] = {name: float(values[name]) for name in names_of_values}
        return True

    def _complete(self, design: Design) -> None:
        """Enter objectives and limits of a design whose runs have all ended."""
        problem = self.problem
        values = [run["value"] for run in design.runs.values() if "value" in run]
        if len(values) < len(problem.samples):
            return
        for objective in problem.objectives:
            samples = [row[objective.name] for row in values]
            design.objectives[objective.name] = problem.statistic_of(objective, samples)
            if len(samples) > 1:
                design.spread[objective.name] = [min(samples), max(samples)]
        faults = []
        for limit in problem.limits:
            worst = max((row[limit.name] for row in values), key=limit.margin)
            design.limited[limit.name] = worst
            design.margins[limit.name] = limit.margin(worst)
            faults.append(limit.fault(worst))
        reason = "; ".join(filter(None, faults))
        self._end(design, REFUSED if reason else COMPLETE, reason)

    def _is_lost(self, design: Design) -> bool:
        """Return True if the runs so far are so much worse than the best design that further runs
        are useless.

        The objective of the design is then estimated from these runs, for the model.
        """
        problem = self.problem
        best = next(iter(self.study.best()), None)
        if best is None or len(problem.objectives) > 1 or (design.full and not design.next_to):
            return False
        (objective,) = problem.objectives
        values = [run["value"][objective.name] for run in design.runs.values() if "value" in run]
        if len(values) == len(problem.samples):
            return False
        best_values = [run["value"][objective.name] for run in best.runs.values()]
        statistic = problem.statistic_of(objective, values)
        best_statistic = problem.statistic_of(objective, best_values[: len(values)])  # same samples
        most = _LOST.get(str(problem.statistic), _LOST_IN_THE_MEAN) ** objective.sign
        if best_statistic <= 0:
            return False
        if objective.sign * statistic <= objective.sign * most * best_statistic:
            return False
        ratio = statistic / best_statistic
        design.objectives[objective.name] = best.objectives[objective.name] * ratio
        return True

    # --------------------------------------------------------------- designs

    def _choose(self) -> bool:
        """Queue the runs of the next design: first designs of the search, then the best designs in
        full, then designs next to the best one.  Return False if there is no next design, or none
        before the running designs have ended.
        """
        study = self.study
        evaluations = self.problem.search.evaluations
        if study.exhausted < evaluations > study.n_evaluated and self._choose_of_space():
            return True
        if any(not design.next_to for design, _ in self.at_work.values()):
            return False
        unconfirmed = study.unconfirmed()
        if unconfirmed:
            for design in unconfirmed:
                self._run_in_full(design)
            return bool(self.queue) or self._choose()
        return self._choose_next_to_best()

    def _run_in_full(self, design: Design) -> None:
        """Queue a design with the tolerance of the case, and with all its samples."""
        design.full = True
        tables = self.problem.tables_of(design.values)
        is_coarse = self.problem.cheaply(tables) != tables
        if is_coarse:
            design.runs = {name: {"longer": run["longer"]} for name, run in design.runs.items()}
        if is_coarse or design.state == PRUNED:
            design.state = RUNNING
            design.reason = ""
            design.objectives = {}
            design.spread = {}
            self._queue(design)

    def _choose_next_to_best(self) -> bool:
        """Queue a design next to the best one; return False if there is none, or if enough were
        run.
        """
        study = self.study
        problem = self.problem
        search = problem.search
        best = next(iter(study.best()), None)
        n_next_to_best = sum(bool(design.next_to) for design in study.designs)
        if n_next_to_best >= min(search.neighbours, search.evaluations):
            return False
        if best is None or not search.guards or search.sampler != "model":
            return False
        neighbours = [values for _, values in problem.space.neighbours(best.values)]
        for values in promising(*study.search_arguments, neighbours):
            design = new_design(problem, len(study.designs) + 1, values)
            if design.state != REFUSED:
                design.full = True
                design.next_to = best.number
                study.designs.append(design)
                self._queue(design)
                return True
        return False

    def _choose_of_space(self) -> bool:
        """Queue the next design of the search; return False if no design meets the limits."""
        study = self.study
        problem = self.problem
        n_random = n_first(problem.space, problem.search.evaluations)
        guided = problem.search.sampler == "model" and study.n_evaluated >= n_random
        before = len(study.designs)
        while len(study.designs) < before + MOST_REFUSED:
            first = len(study.designs)
            candidates = ordered(*study.search_arguments, guided=guided)
            for values in itertools.islice(candidates, _REFUSED_AT_ONCE):
                design = new_design(problem, len(study.designs) + 1, values)
                study.designs.append(design)
                if design.state != REFUSED:
                    self._queue(design)
                    return True
            if len(study.designs) == first:
                break
        else:
            logger.warning(
                "%s: ends after %d designs: the next %d designs are all beyond the limits, or are "
                "not valid packings",
                problem.name,
                study.n_evaluated,
                MOST_REFUSED,
            )
        study.exhausted = problem.search.evaluations
        return False


def _depends_on_peak(problem: DesignProblem) -> bool:
    """Return True if an objective depends on the peak of the force on the target."""
    for objective in problem.objectives:
        if any(fnmatchcase(objective.name, pattern) for pattern in _OF_PEAK):
            return True
    return False
