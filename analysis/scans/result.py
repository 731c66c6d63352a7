"""Reader of the directory of a scan: points, their status and their summaries.

A scan has ``scan.json`` (its points and varied keys), ``points/ID`` (directories of finished runs)
and ``unfinished/ID`` (of running or failed runs). In both, ``point.json`` records the number of
attempts and the reason of a failure. An ID is a hash of the resolved case and the versions that it
was run with.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.values import AMPLITUDE, LOAD_KIND, amplitude_unit, unit_of
from granwave.lammps_inputs.files import read_json, read_tables, regular
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.result_directory import ResultDirectory, case_digest
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    POINT_FILE,
    POINTS,
    SCAN_INDEX,
    SUMMARY_FILE,
    UNFINISHED,
)

SEED = "packing.seed"  # points that differ only in this key are replicates

Scalar = bool | int | float | str
Status = Literal["done", "failed", "missing"]


@dataclasses.dataclass(frozen=True)
class PointResult:
    """Result of a point.

    Attributes
    ----------
    number
        Number in the order of the scan, from 1.
    id
        Name of its directory; equal points share one.
    labels
        Values of the varied keys, by dotted key; lists and tables as text.
    status, reason
        Status, and the reason of a failure or the damaged file; empty otherwise.
    directory
        Directory of its run; None if it was never started.
    summary
        Content of summary.json, empty unless done.
    """

    number: int
    id: str
    labels: dict[str, Scalar]
    status: Status
    reason: str
    attempts: int
    directory: Path | None
    summary: dict[str, Any]


class ScanResult:
    """Present state of a scan; summaries of finished points are cached.

    Parameters
    ----------
    directory
        Directory of the scan.

    Raises
    ------
    MissingOutputError
        The directory does not hold a scan.
    OutputFormatError
        The index of the scan is damaged.
    """

    def __init__(self, directory: AnyPath) -> None:
        self.results = ResultDirectory.at(directory)
        self.directory = self.results.path
        path = self.directory / SCAN_INDEX
        try:
            index = json.loads(regular(path).read_text(encoding="utf-8"))
            self.name: str = index["name"]
            self.case_name: str = index["case"]
            self.varied: tuple[str, ...] = tuple(index["varied"])
            self._points: list[dict[str, Any]] = [_checked(point) for point in index["points"]]
            self.studies: tuple[str, ...] = tuple(index.get("study", ()))
        except FileNotFoundError:
            raise MissingOutputError(
                f"{path} is missing: expected the directory of a scan"
            ) from None
        except KeyError as error:
            raise OutputFormatError(
                f"{path} lacks {error}; run the scan again with resume=True"
            ) from None
        except (OSError, ValueError, TypeError) as error:
            raise OutputFormatError(
                f"{path} cannot be read ({error}); run the scan again with resume=True"
            ) from None
        self._summaries: dict[str, dict[str, Any]] = {}

    @property
    def points(self) -> tuple[PointResult, ...]:
        """Present state of all points, in order."""
        return tuple(self._point(entry) for entry in self._points)

    @property
    def units(self) -> dict[str, str]:
        """SI units of the varied keys that have a unit."""
        units = {
            key: amplitude_unit(self._load_kinds()) if key == AMPLITUDE else unit_of(key)
            for key in self.varied
        }
        return {key: unit for key, unit in units.items() if unit}

    def _load_kinds(self) -> set[str]:
        """Return the kinds of the loads: of all points if they vary, otherwise of the first point
        that was started.
        """
        if LOAD_KIND in self.varied:
            return {str(point["labels"].get(LOAD_KIND)) for point in self._points}
        for point, folder in itertools.product(self._points, (POINTS, UNFINISHED)):
            tables = read_tables(self.directory / folder / point["id"] / CASE_FILE) or {}
            load = tables.get("load")
            if isinstance(load, dict) and "kind" in load:
                return {str(load["kind"])}
        return set()

    def _point(self, entry: dict[str, Any]) -> PointResult:
        name = entry["id"]
        finished = self.directory / POINTS / name
        unfinished = self.directory / UNFINISHED / name
        status: Status = "missing"
        summary = self._summary(name, finished)
        directory = None
        if summary:
            directory = finished
        elif unfinished.is_dir():
            directory = unfinished
        record = read_point(directory) if directory else {}
        reason = ""
        if summary:
            status = "done"
        elif record.get("state") == "failed":
            status = "failed"
            reason = record.get("reason") or ""
        elif finished.is_dir():
            fault = "damaged" if (finished / SUMMARY_FILE).exists() else "missing"
            reason = f"its {SUMMARY_FILE} is {fault}"
        attempts = record.get("attempts", 0)
        return PointResult(
            entry["number"], name, entry["labels"], status, reason, attempts, directory, summary
        )

    def _summary(self, name: str, finished: Path) -> dict[str, Any]:
        """Return the summary of a point, read once; empty if it is not finished."""
        if name not in self._summaries:
            fault = other_point(finished)
            if fault:
                raise OutputFormatError(fault)
            summary = ResultDirectory(finished).summary()
            if summary:
                self._summaries[name] = summary
        return self._summaries.get(name, {})


def _checked(entry: dict[str, Any]) -> dict[str, Any]:
    """Check a point of the index; raise KeyError, TypeError or ValueError if it is incomplete."""
    number = entry["number"]
    name = entry["id"]
    labels = entry["labels"]
    if not isinstance(number, int) or not isinstance(name, str) or not isinstance(labels, dict):
        raise ValueError(f"a point has no number, id or labels: {entry}")
    return entry


def other_point(directory: Path) -> str:
    """Return the message for a directory of a finished point that holds another point or another
    run; empty if it holds neither.
    """
    record = read_point(directory)
    remedy = "move it elsewhere: resume=True then runs the point again"
    name = record.get("id", directory.name)
    if name != directory.name:
        return (
            f"{directory}: holds the point {name} of the scan; move it to its own directory, "
            f"or {remedy}"
        )
    tables = ResultDirectory(directory).tables_as_run() if "case" in record else None
    if tables is not None and case_digest(tables) != record["case"]:
        return f"{directory}: contains a run of another case; {remedy}"
    return ""


def read_point(directory: Path) -> dict[str, Any]:
    """Read the record of a point: ``state``, ``attempts``, ``reason``; empty if there is none."""
    return read_json(directory / POINT_FILE) or {}


REDUCTION = "peak_reduction"
_TARGET = "boundary.bottom"
_MOVES = "target_peak_displacement_m"  # value of targets that move
_WORTH = 1e-3  # deviation of the reduction from 1 below which a packing does not protect


def protects(varied: Sequence[str], summaries: Iterable[Mapping[str, Any]]) -> bool:
    """Return True for a scan of protected targets: the target varies, or moves.

    Parameters
    ----------
    varied
        Keys that vary in the scan.
    summaries
        Summaries of its finished points.
    """
    protected = [
        summary for summary in summaries if isinstance(summary.get(REDUCTION), int | float)
    ]
    varies_target = any(key == _TARGET or key.startswith(f"{_TARGET}.") for key in varied)
    targets_move = bool(protected) and all(summary.get(_MOVES) is not None for summary in protected)
    if not varies_target and not targets_move:
        return False
    return any(abs(summary[REDUCTION] - 1) > _WORTH for summary in protected)
