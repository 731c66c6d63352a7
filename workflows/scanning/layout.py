"""Layout of the directory of a scan; the reader is `granwave.analysis.scans.result`."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from granwave.analysis.scans.result import other_point, read_point
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_tables, replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    POINT_FILE,
    POINT_FILES,
    POINTS,
    SCAN_DATA,
    SCAN_FILE,
    SCAN_INDEX,
    SCAN_MEANS,
    SCAN_REPORT,
    SCAN_TABLE,
    SCAN_WORK,
    STUDY_ROWS,
    UNFINISHED,
)

# environment variable: process id of the local driver; jobs stop when it ends
DRIVER = "GRANWAVE_SCAN_DRIVER"
BATCHES = f"{SCAN_WORK}/batches"
DONE = f"{SCAN_WORK}/done"
LOGS = f"{SCAN_WORK}/logs"
SUBMITTED = f"{SCAN_WORK}/logs/submitted.txt"  # jobs of a cluster: id and batch in each line
STOP = f"{SCAN_WORK}/stop"  # file whose existence asks all workers to stop; its text is the reason
_FILES = (SCAN_FILE, SCAN_INDEX, SCAN_TABLE, SCAN_DATA, SCAN_MEANS, SCAN_REPORT, STUDY_ROWS)

# states of a point
RUNNING = "running"
INTERRUPTED = "interrupted"
FAILED = "failed"
DONE_STATE = "done"
MOST_ATTEMPTS = 2

LEAST_FREE = 50e6  # bytes of disk space in addition to the expected output of a point


def finished(directory: Path, point: str) -> Path:
    """Return the directory of a finished point."""
    return directory / POINTS / point


def unfinished(directory: Path, point: str) -> Path:
    """Return the directory of an unfinished point."""
    return directory / UNFINISHED / point


def files(points: Iterable[str]) -> list[str]:
    """Return the names of the results of a scan of these points, without figures."""
    names = [*_FILES]
    for point in points:
        names += [f"{POINTS}/{point}/", f"{UNFINISHED}/{point}/"]
    return names


def is_done(directory: Path, point: str) -> bool:
    """Return True if the point was finished and analysed, so that its summary can be read."""
    return bool(ResultDirectory(finished(directory, point)).summary())


def fault(directory: Path, point: str) -> str:
    """Describe the damage in the directory of a finished point; empty if none, or not finished.

    Raises
    ------
    InputError
        The case.toml of the point was changed after the run, or the directory belongs to another
        point.
    """
    place = finished(directory, point)
    if not place.is_dir():
        return ""
    results = ResultDirectory(place)
    results.check_case()
    if other := other_point(place):
        raise InputError(other)
    case = place / CASE_FILE
    if read_tables(case) is None and results.tables_as_run() is not None:
        return f"{case}: is damaged, or missing"
    return results.fault()


def is_whole(directory: Path, point: str) -> bool:
    """Return True if the point is done and none of its files is damaged; raise as `fault`."""
    return is_done(directory, point) and not fault(directory, point)


def reopen(directory: Path, point: str) -> None:
    """Move a damaged point back to the unfinished points, with its intact files.

    Raises
    ------
    InputError
        Files that granwave did not write are in the way.
    """
    _move(finished(directory, point), unfinished(directory, point))


def close(directory: Path, point: str) -> None:
    """Move a point to the finished points; raise as `reopen`."""
    _move(unfinished(directory, point), finished(directory, point))


def _move(place: Path, target: Path) -> None:
    """Move the directory of a point; results of granwave in the target are replaced."""
    if target.is_dir() and not target.is_symlink():
        replaced = ResultDirectory(target)
        replaced.clear()
        replaced.clear(POINT_FILES)
        with contextlib.suppress(OSError):
            target.rmdir()
    if os.path.lexists(target):
        raise InputError(
            f"{target}: contains files that granwave did not write; move them elsewhere, then use "
            "resume=True"
        )
    target.parent.mkdir(exist_ok=True)
    os.replace(place, target)


def state(directory: Path, point: str) -> dict[str, Any]:
    """Read the record of an unfinished point; empty if it was never started."""
    return read_point(unfinished(directory, point))


def seconds(directory: Path, point: str) -> float | None:
    """Return the wall time of a finished point, s; None if it was not recorded."""
    return read_point(finished(directory, point)).get("seconds")


def write_state(place: Path, **record: Any) -> None:
    """Replace the record of a point in one step.

    Raises
    ------
    InputError
        The file that it would replace was not written by granwave.
    """
    place.mkdir(parents=True, exist_ok=True)
    ResultDirectory(place).claim(POINT_FILES)
    replace_text(place / POINT_FILE, json.dumps({**record, "id": place.name}, indent=1) + "\n")


def change_state(directory: Path, point: str, **changes: Any) -> None:
    """Change values in the record of an unfinished point."""
    write_state(unfinished(directory, point), **{**state(directory, point), **changes})


def is_final(directory: Path, point: str) -> bool:
    """Return True if the point is done, or has failed for good."""
    return is_done(directory, point) or state(directory, point).get("state") == FAILED
