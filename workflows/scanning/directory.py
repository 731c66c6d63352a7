"""Directory of a scan: whether the scan may be run there, and how it is made ready."""

from __future__ import annotations

import json
import logging
from pathlib import Path

from granwave.analysis.errors import OutputFormatError
from granwave.analysis.scans.result import ScanResult
from granwave.lammps_inputs.directories import check_directory
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replace_text
from granwave.lammps_inputs.ownership import claim, refuse_foreign, refuse_other_kind, refuse_results, results_in
from granwave.lammps_inputs.run_directory import SCAN, SCAN_FILE, SCAN_INDEX, SCAN_WORK, is_scan
from granwave.workflows.run.directory import busy
from granwave.workflows.scanning import layout, queue
from granwave.workflows.scanning.needs import check_points
from granwave.workflows.scanning.scan_file import Scan

logger = logging.getLogger(__name__)


def decide(scan: Scan, directory: Path, *, resume: bool, force: bool) -> None:
    """May the scan be run in ``directory``? Changes nothing.

    Raises
    ------
    InputError
        It holds results and neither resume nor force was given, or holds something else, or files that granwave did not
        write and would overwrite; or the case.toml of a point was changed.
    """
    check_directory(directory, resume=resume, force=force)
    refuse_other_kind(directory, SCAN)
    if not resume and not force:
        refuse_results(directory, "--resume does what is missing, --force replaces them")
    refuse_foreign(directory, [*layout.files(scan.distinct), f"{SCAN_WORK}/"])
    if resume and is_scan(directory):
        there = _index(directory)
        if there and there.name != scan.name and not {point.id for point in there.points} & set(scan.distinct):
            raise InputError(
                f"{directory}: holds another scan ({there.name}), without a point of {scan.name}; "
                "--force replaces it, or choose another directory with -o"
            )
    check_points(scan, directory, force=force)


def _index(directory: Path) -> ScanResult | None:
    """The scan that is there; None where its index is damaged, which is written anew."""
    try:
        return ScanResult(directory)
    except OutputFormatError:
        return None


def prepare(scan: Scan, directory: Path, *, on_cluster: bool) -> None:
    """Write the index of a scan, and open the points that are damaged, failed or were killed.

    Parameters
    ----------
    on_cluster
        Points of jobs that an earlier start left there stay as they are.
    """
    claim(directory, layout.files(scan.distinct), kind=SCAN)
    for name in (layout.BATCHES, layout.DONE, layout.LOGS):
        (directory / name).mkdir(parents=True, exist_ok=True)
    (directory / layout.STOP).unlink(missing_ok=True)
    replace_text(directory / SCAN_FILE, scan.text)
    replace_text(directory / SCAN_INDEX, json.dumps(scan.index(), indent=1) + "\n")
    adopted = {name for job in queue.jobs_of(directory) for name in job.points} if on_cluster else set()
    for point in scan.distinct:
        in_work = point in adopted or busy(layout.unfinished(directory, point))
        if not in_work and (fault := layout.fault(directory, point)):
            if results_in(layout.finished(directory, point)):
                logger.warning("%s; the point is analysed again, or run again", fault)
            layout.reopen(directory, point)
        state = layout.state(directory, point)
        begun = state.get("attempts") or state.get("state") == layout.FAILED
        if begun and point not in adopted:  # it failed, or was killed with its job: another chance
            layout.write_state(
                layout.unfinished(directory, point), **{**state, "state": layout.INTERRUPTED, "attempts": 0}
            )
