"""Directory of a scan: permission to run the scan there, the requirements of its remaining points,
and its preparation.
"""

from __future__ import annotations

import contextlib
import json
import logging
from functools import partial
from pathlib import Path

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.initial_dents import earlier_result
from granwave.lammps_inputs.directories import check_disk
from granwave.lammps_inputs.errors import InputError, InputFault, raise_all
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import SCAN, SCAN_FILE, SCAN_INDEX, SCAN_WORK, is_scan
from granwave.workflows.cluster.scheduler import Scheduler
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.queue import jobs_of
from granwave.workflows.scanning.scan_file import Scan, ScanPoint


def points_left(scan: Scan, directory: Path, *, fresh: bool = False) -> list[ScanPoint]:
    """Return the points still to be run or analysed again; all if the scan starts ``fresh``.

    Raises
    ------
    InputError
        The case.toml of finished points was changed.
    """
    if fresh:
        return list(scan.distinct.values())
    found = []
    errors = []
    for name, point in scan.distinct.items():
        try:
            found += [] if layout.is_whole(directory, name) else [point]
        except InputError as error:
            errors += error.items
    if errors:
        raise InputError(errors)
    return found


def check_points(scan: Scan, results: ResultDirectory, *, force: bool) -> None:
    """Check that the remaining points can be run: files that they name, and disk space.

    Parameters
    ----------
    force
        True to move existing points into NAME.old.

    Raises
    ------
    InputError
        The points cannot be run; the message lists all faults.
    """
    points = sorted(points_left(scan, results.path, fresh=force), key=lambda point: point.number)
    needed = scan.scale * sum(point.plan.disk for point in points)
    spare = layout.LEAST_FREE + max((point.plan.disk_reserve for point in points), default=0.0)
    cases = [point.case for point in points if force and isinstance(point.case, Case)]
    sources = {source: case.name for case in cases if (source := earlier_result(case)) is not None}

    def check_files() -> None:
        """Check the files that points name; a fault of all points is reported once."""
        places: dict[InputFault, list[str]] = {}
        for point in points:
            try:
                point.kind.check(point.case)
            except InputError as error:
                labels = ", ".join(f"{key} = {value}" for key, value in point.labels.items())
                for item in error.items:
                    places.setdefault(item, []).append(f"point {point.number} ({labels})")
        faults: list[InputFault] = []
        for item, of_points in places.items():
            if len(of_points) == len(points):
                faults.append(item.inside(scan.name))
            else:
                faults += [item.inside(f"{scan.name}: {place}") for place in of_points]
        if faults:
            raise InputError(faults)

    raise_all(
        [
            check_files,
            lambda: check_disk(results.path, needed, what="the points", spare=spare),
            *(partial(results.refuse_source, name, source) for source, name in sources.items()),
        ]
    )


logger = logging.getLogger(__name__)


def decide(scan: Scan, results: ResultDirectory, *, resume: bool, force: bool) -> None:
    """Decide if the scan may be run in a directory, without changing anything.

    Raises
    ------
    InputError
        It holds results and neither resume nor force was given, or holds something else, or files
        that granwave did not write and would overwrite; or the case.toml of a point was changed.
    """
    results.check(resume=resume, force=force)
    results.refuse_other_kind(SCAN)
    if not resume and not force:
        results.refuse_results("resume=True runs only the missing points, ")
    results.refuse_foreign([*layout.files(scan.distinct), f"{SCAN_WORK}/"])
    if resume and is_scan(results):
        there = None
        with contextlib.suppress(OutputFormatError):  # a damaged index is rewritten
            there = ScanResult(results)
        if (
            there
            and there.name != scan.name
            and not {point.id for point in there.points} & set(scan.distinct)
        ):
            raise InputError(
                f"{results}: holds another scan ({there.name}), without a point of {scan.name}; "
                f"{results.by_force}"
            )
    check_points(scan, results, force=force)


def prepare(scan: Scan, results: ResultDirectory, scheduler: Scheduler | None) -> None:
    """Write the index of a scan, and open the points that are damaged, failed or were killed.

    Parameters
    ----------
    scheduler
        Scheduler of the cluster, None for this machine: points of jobs that an earlier start left
        there stay as they are.
    """
    results.claim(layout.files(scan.distinct), kind=SCAN)
    directory = results.path
    for name in (layout.BATCHES, layout.DONE, layout.LOGS):
        (directory / name).mkdir(parents=True, exist_ok=True)
    (directory / layout.STOP).unlink(missing_ok=True)
    replace_text(directory / SCAN_FILE, scan.text)
    replace_text(directory / SCAN_INDEX, json.dumps(scan.index(), indent=1) + "\n")
    adopted: set[str] = set()
    if scheduler is not None:
        for job in jobs_of(directory, scheduler):
            adopted |= set(job.points)
    for point in scan.distinct:
        in_work = point in adopted or ResultDirectory(layout.unfinished(directory, point)).busy()
        if not in_work and (fault := layout.fault(directory, point)):
            if ResultDirectory(layout.finished(directory, point)).result_names():
                logger.warning("%s; the point is analysed again, or run again", fault)
            layout.reopen(directory, point)
        state = layout.state(directory, point)
        begun = state.get("attempts") or state.get("state") == layout.FAILED
        if begun and point not in adopted:  # it failed, or was killed with its job: it is run again
            layout.change_state(directory, point, state=layout.INTERRUPTED, attempts=0)
