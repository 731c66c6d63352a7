"""One scan from its file to table, figures and report; missing points are run in rounds."""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import os
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.scans.result import ScanResult
from granwave.analysis.scans.table import ScanData, read_scan, write_scan_table
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.interrupts import Interrupts
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN_REPORT
from granwave.workflows.cluster.profile import Profile
from granwave.workflows.run.directory import held
from granwave.workflows.run.progress import Progress
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.batches import Machine, Outlook
from granwave.workflows.scanning.directory import decide, prepare
from granwave.workflows.scanning.engine import LOCAL, ClusterJobs, Jobs, LocalJobs
from granwave.workflows.scanning.queue import jobs_of, note_ended, note_refused
from granwave.workflows.scanning.scan_file import Scan, ScanPoint

logger = logging.getLogger(__name__)

STOPPED = "stopped"  # stopped by Ctrl-C or SIGTERM
_FORCED = 3  # signals that stop at once; the first one asks for checkpoints
# s between checks of the directory, and of the queue
_POLL = 0.3
_QUEUE_POLL = 2.0
# shortest s between updates during the run
_TABLE_EVERY = 5.0
_FIGURES_EVERY = 60.0
# a round that leaves points unfinished (jobs killed, time limit) is followed by another
_MOST_ROUNDS = 20
_MOST_SHOWN = 3  # running points, and labels of each, next to the bar


@dataclasses.dataclass(frozen=True)
class ScanOutcome:
    """Outcome of a scan.

    Attributes
    ----------
    done, failed, missing
        Numbers of distinct points.
    stopped
        `STOPPED`, or the reason why the scan could not continue; None if it was completed.
    """

    directory: Path
    done: int
    failed: int
    missing: int
    stopped: str | None

    @property
    def data(self) -> ScanData:
        """Table of the scan: a numpy array for each column, by name."""
        return read_scan(self.directory)

    @property
    def complete(self) -> bool:
        """True if all points are done."""
        return not self.failed and not self.missing


def run_scan(
    scan: Scan,
    directory: str | Path,
    *,
    executor: str = "local",
    profile: Profile | None = None,
    jobs: int | None = None,
    resume: bool = False,
    force: bool = False,
    progress: bool = False,
    slowness: float = 1.0,
) -> ScanOutcome:
    """Run a scan and make its table, figures and report.

    Parameters
    ----------
    directory
        Directory of the results.
    executor
        ``local``, or the scheduler of a cluster, as ``slurm``.
    profile
        Profile of the cluster.
    jobs
        Number of cores of this machine, or of simultaneous jobs on the cluster.
    resume
        Run missing points only; points that failed are tried again.
    force
        Move existing results into NAME.old.
    progress
        Show a bar (on a terminal) or lines (in a log).
    slowness
        Measured over planned time of a point.

    Raises
    ------
    InputError
        The directory holds results or another scan, or is in use; or there is no such scheduler.
        Nothing was run.
    RunError
        No job could start a point.
    """
    results = ResultDirectory(results_directory(directory))
    if executor == LOCAL:
        profile = None
    else:
        profile = profile or Profile(scheduler=executor)
        profile.queue.check(f"--executor {executor}", ", or use --executor local")
    with held(results), Interrupts() as stop:
        decide(scan, results, resume=resume, force=force)
        if force:
            results.make_room(force=True)
        prepare(scan, results, profile.queue if profile is not None else None)
        machine = Machine(jobs or default_jobs(profile), profile, slowness)
        run = _ScanRun(scan, results, machine, stop, show=progress)
        run.work()
        return run.outcome()


def default_jobs(profile: Profile | None) -> int:
    """Return the default number of simultaneous jobs: cores of this machine, or the number in the
    profile.
    """
    return profile.jobs if profile else len(os.sched_getaffinity(0))


class _ScanRun:
    def __init__(
        self,
        scan: Scan,
        results: ResultDirectory,
        machine: Machine,
        stop: Interrupts,
        *,
        show: bool,
    ) -> None:
        self.scan = scan
        self.results = results
        self.directory = results.path
        self.machine = machine
        self.stop = stop
        self.show = show
        self.open = dict(scan.distinct)  # points not known to be done or failed
        self.running: dict[str, float] = {}  # start times of running points, by id
        self.result = ScanResult(results)
        self.drawn = self.tabled = time.monotonic()
        self.changed = True
        self.stopped: str | None = None
        self.n_done = 0  # points
        left = [
            point for name, point in self.open.items() if not layout.is_done(results.path, name)
        ]
        self.outlook = Outlook(left, machine)

    def work(self) -> None:
        """Run rounds of jobs until every point is done or has failed; update table and figures."""
        self._update_points()
        self._bar = Progress(
            len(self.scan.distinct), self.scan.name, enabled=self.show, done=self._closed()
        )
        try:
            for number in range(_MOST_ROUNDS):
                # no point runs twice: an earlier start of this scan may have left jobs on the
                # cluster
                while not self.stop.count and self._has_jobs():
                    self._look("jobs of an earlier start continue")
                    time.sleep(_QUEUE_POLL)
                self._update_points()
                if not self.open or self.stop.count or self.stopped:
                    break
                self._round(list(self.open.values()), f"{int(time.time()):x}{number}")
        finally:
            self._bar.close()
        if self.stop.count:
            self.stopped = STOPPED
        write_scan_table(self.result)
        if not self.stop.count:  # figures would delay the stop
            _draw(self.result)
            publish(self.results, self.scan.study)

    def _has_jobs(self) -> bool:
        """Return True if jobs of this scan are in the queue of a cluster."""
        profile = self.machine.profile
        return profile is not None and bool(jobs_of(self.directory, profile.queue))

    def _round(self, points: Sequence[ScanPoint], prefix: str) -> None:
        jobs = self._jobs(points, prefix)
        stop = self.directory / layout.STOP
        before = self._states(points)
        try:
            jobs.running()
            # modules of table, figures and report are loaded while the jobs start
            import granwave.analysis.reports.report
            import granwave.analysis.scans.figures  # noqa: F401

            while self.open and jobs.running():
                time.sleep(_POLL)
                self._look()
                if self.stop.count or stop.exists():
                    if self.stop.count:
                        logger.warning(
                            "%s: stopping; running points write checkpoints ...", self.scan.name
                        )
                    with contextlib.suppress(OSError):
                        stop.touch()
                    jobs.stop(lambda: self.stop.count >= _FORCED)
                    break
        finally:
            jobs.kill()
        if stop.exists() and not self.stop.count:
            self.stopped = stop.read_text(encoding="utf-8") or "the disk is full"
        if not self.stopped and not self.stop.count:
            refused = []
            for batch in jobs.waiting:
                for point in batch.points:
                    refused.append(point.id)
            if not refused and self._states(points) == before:
                raise RunError(
                    f"no job has started a point; their logs are in {self.directory / layout.LOGS}"
                )
            if (profile := self.machine.profile) is not None:
                note_refused(self.directory, refused, jobs.refusal, profile.queue)
                note_ended(self.directory, [point.id for point in points], profile.queue)
        self._update_points()

    def _jobs(self, points: Sequence[ScanPoint], prefix: str) -> Jobs:
        """Write the batches of points; return their jobs, none of which has started."""
        batches = self.machine.batches(points, prefix)
        profile = self.machine.profile
        for batch in batches:
            path = self.directory / layout.BATCHES / f"{batch.id}.json"
            cluster: dict[str, Any] = {}
            if profile is not None:
                cluster["launcher"] = profile.launcher_words(batch.ranks)
                cluster["scheduler"] = profile.scheduler
            batch.write(path, figures=self.scan.figures, **cluster)
        if profile is None:
            return LocalJobs(self.directory, batches, self.machine.jobs)
        return ClusterJobs(self.directory, batches, self.machine.jobs, profile, self.scan.name)

    def _states(self, points: Sequence[ScanPoint]) -> list[tuple[bool, dict[str, Any]]]:
        return [
            (layout.is_done(self.directory, p.id), layout.state(self.directory, p.id))
            for p in points
        ]

    # ------------------------------------------------------------------ looking

    def _look(self, note: str = "") -> None:
        """Update the bar and, at intervals, table and figures."""
        self._update_points()
        failed = self._closed() - self.n_done
        parts = [note, f"{failed} failed" if failed else ""]
        if self.running:
            shown = [self.scan.distinct[name] for name in self.running][:_MOST_SHOWN]
            parts.append(
                f"now {'; '.join(f'{point.number}: {_labels_of(point)}' for point in shown)}"
            )
        ages = {name: time.time() - started for name, started in self.running.items()}
        times = self.outlook.text(list(self.open.values()), ages)
        self._bar.update(self._closed(), ", ".join(part for part in parts if part), times)
        now = time.monotonic()
        if self.changed and now - self.tabled > _TABLE_EVERY:
            write_scan_table(self.result)
            self.changed = False
            self.tabled = now
            if now - self.drawn > _FIGURES_EVERY:
                _draw(self.result, pdf=False)
                self.drawn = time.monotonic()

    def _update_points(self) -> None:
        """Update which points are done, have failed or are running."""
        self.running = {}
        for name, point in list(self.open.items()):
            done = layout.is_done(self.directory, name)
            state = {} if done else layout.state(self.directory, name)
            if done or state.get("state") == layout.FAILED:
                del self.open[name]
                self.n_done += done
                self.changed = True
                if done and (taken := layout.seconds(self.directory, name)):
                    self.outlook.done(point, taken)
            elif state.get("state") == layout.RUNNING:
                self.running[name] = state.get("started", time.time())

    def _closed(self) -> int:
        return len(self.scan.distinct) - len(self.open)

    def outcome(self) -> ScanOutcome:
        """Return the outcome of the scan."""
        # one point may have several rows in the table
        counts = Counter(
            {point.id: point.status for point in ScanResult(self.directory).points}.values()
        )
        done = counts["done"]
        failed = counts["failed"]
        missing = counts["missing"]
        if not failed and not missing:
            with contextlib.suppress(OSError):
                (self.directory / layout.unfinished(self.directory, "")).rmdir()
        return ScanOutcome(self.directory, done, failed, missing, self.stopped)


def publish(results: ResultDirectory, studies: Sequence[str], *, suite: bool = False) -> None:
    """Draw the figures of studies, and of the comparison of the scans of a suite, and write the
    report.
    """
    # the drawing library is loaded when all points are done
    from granwave.analysis.reports.inputs import read_inputs
    from granwave.analysis.reports.report import write_scan_report
    from granwave.analysis.reports.studies import report_studies
    from granwave.analysis.studies.study import draw_studies, write_rows

    directory = results.path
    inputs = read_inputs([directory], directory, studies)
    made = report_studies(inputs)
    drawn = [*made.compared, *made.of_scans] if suite else made.of_scans
    draw_studies(drawn, results)
    write_rows(drawn, results)
    write_scan_report(inputs, made, directory / SCAN_REPORT)


def _draw(result: ScanResult, *, pdf: bool = True) -> None:
    # the drawing library is loaded when first points are done, not at the start
    from granwave.analysis.scans.figures import draw_scan_figures

    draw_scan_figures(result, pdf=pdf)


def _labels_of(point: ScanPoint) -> str:
    """Return the main labels of a point."""
    shown = list(point.labels.items())[:_MOST_SHOWN]
    return ", ".join(
        f"{key.split('.')[-1]} {f'{v:.4g}' if isinstance(v, float) else v}" for key, v in shown
    )
