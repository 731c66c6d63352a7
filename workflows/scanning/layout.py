"""Where things are in the directory of a scan; what users and reports read is in `granwave.analysis.scans.result`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from granwave.analysis.scans.result import POINT_FILE, POINTS, SCAN_FILE, SCAN_INDEX, UNFINISHED, read_point
from granwave.analysis.summary import SUMMARY_FILE
from granwave.lammps_inputs.files import replace_text

DRIVER = "GRANWAVE_SCAN_DRIVER"  # variable: process of the driver, on this machine, without which a job ends
WORK = ".scan"  # of the engine: batches, marks of finished batches, logs
BATCHES, DONE, LOGS = f"{WORK}/batches", f"{WORK}/done", f"{WORK}/logs"
STOP = f"{WORK}/stop"  # its presence asks all workers to stop; its text says why
RESULTS = (
    SCAN_FILE,
    SCAN_INDEX,
    POINTS,
    UNFINISHED,
    "scan.csv",
    "scan.h5",
    "scan_mean.csv",
    "figures",
    "report.html",
    WORK,
)

# states of a point
RUNNING, INTERRUPTED, FAILED, DONE_STATE = "running", "interrupted", "failed", "done"
MOST_ATTEMPTS = 2

LEAST_FREE = 50e6  # bytes of disk, beside what a point is expected to write


def finished(directory: Path, point: str) -> Path:
    """The directory of a point that is done."""
    return directory / POINTS / point


def unfinished(directory: Path, point: str) -> Path:
    """The directory of a point in work."""
    return directory / UNFINISHED / point


def is_done(directory: Path, point: str) -> bool:
    """The point was run to its end and analysed."""
    try:
        # an empty file is what a machine may leave that went down
        return (finished(directory, point) / SUMMARY_FILE).stat().st_size > 0
    except OSError:
        return False


def state(directory: Path, point: str) -> dict[str, Any]:
    """The record of a point that is not done; empty if it was never begun."""
    return read_point(unfinished(directory, point))


def seconds(directory: Path, point: str) -> float | None:
    """Wall time of a point that is done, s; None where nobody wrote it down."""
    return read_point(finished(directory, point)).get("seconds")


def write_state(place: Path, **record: Any) -> None:
    """Replace the record of a point, all or nothing."""
    place.mkdir(parents=True, exist_ok=True)
    replace_text(place / POINT_FILE, json.dumps(record, indent=1) + "\n")


def is_final(directory: Path, point: str) -> bool:
    """The point is done, or has failed as often as it is tried."""
    return is_done(directory, point) or state(directory, point).get("state") == FAILED
