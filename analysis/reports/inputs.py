"""Inputs of a report: runs and scans, read from their directories."""

from __future__ import annotations

import dataclasses
import logging
import os
from collections.abc import Collection, Iterator, Sequence
from functools import cached_property
from pathlib import Path
from urllib.parse import quote

from granwave.analysis.document.model import Link
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.formatting.values import distinct
from granwave.analysis.reports.kinds import (
    ReportRun,
    UnfinishedRunError,
    no_numbers,
    report_kind_in,
)
from granwave.analysis.result.not_a_run import around, similar
from granwave.analysis.scans.means import Means, means_of
from granwave.analysis.scans.result import PointResult, ScanResult
from granwave.analysis.studies.registry import STUDIES, is_study_file
from granwave.lammps_inputs.errors import InputError, InputFault
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    POINTS,
    SCAN_INDEX,
    SUITE_INDEX,
    SUMMARY_FILE,
    is_scan,
)

_LOG = logging.getLogger(__name__)


@dataclasses.dataclass(frozen=True)
class ReportPoint:
    """A point of a scan; ``run`` is None if it is not done, for the ``reason``."""

    result: PointResult
    reason: str
    run: ReportRun | None


@dataclasses.dataclass(frozen=True)
class ReportScan:
    """A scan with its points in order, and the names of its studies."""

    label: str
    source: ScanResult
    points: tuple[ReportPoint, ...]
    studies: tuple[str, ...] = ()

    @property
    def directory(self) -> Path:
        """Path of its directory."""
        return self.source.directory

    @property
    def results(self) -> ResultDirectory:
        """Its directory."""
        return self.source.results

    @cached_property
    def means(self) -> Means:
        """Means of the finished points over the seeds."""
        return means_of(self.source)

    def count(self, status: str) -> int:
        """Return the number of points with a status."""
        return sum(point.result.status == status for point in self.points)


@dataclasses.dataclass(frozen=True)
class ReportInputs:
    """Inputs of a report.

    Attributes
    ----------
    base
        Directory of the report, to which paths in it are relative.
    suite
        Name of the suite if the items are its scans; otherwise empty.
    left_out
        Messages about unfinished runs without a summary, which are not among the items.
    """

    items: tuple[ReportRun | ReportScan, ...]
    base: Path
    suite: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def runs(self) -> tuple[ReportRun, ...]:
        """Runs that were given directly."""
        return tuple(item for item in self.items if isinstance(item, ReportRun))

    @property
    def scans(self) -> tuple[ReportScan, ...]:
        """Scans that were given."""
        return tuple(item for item in self.items if isinstance(item, ReportScan))

    def results(self) -> Iterator[ReportRun]:
        """Iterate over all runs, including finished points of scans; a run shared by several points
        is yielded once.
        """
        for item in self.items:
            if isinstance(item, ReportRun):
                yield item
                continue
            seen: set[Path] = set()
            for point in item.points:
                if point.run is not None and point.run.directory not in seen:
                    seen.add(point.run.directory)
                    yield point.run

    def whole(self) -> Iterator[ReportRun]:
        """Iterate over `results` without runs whose result.h5 is damaged."""
        return (run for run in self.results() if not run.damaged)

    def path(self, path: Path) -> str:
        """Return a path relative to the report."""
        return relative(path, self.base)

    def link(self, path: Path, text: str | None = None) -> Link:
        """Return a link to a file or directory."""
        shown = self.path(path)
        return Link(text or shown, quote(os.fsencode(shown)))


def relative(path: Path, base: Path) -> str:
    """Return a path relative to a directory, with forward slashes."""
    return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()


def read_inputs(
    directories: Sequence[str | Path],
    base: Path,
    study_files: Collection[str] = (),
    *,
    repeated: bool = False,
    skip_unfinished: bool = False,
) -> ReportInputs:
    """Read runs and scans.

    Parameters
    ----------
    directories
        Directories of runs, scans, and suites, which stand for their scans; repeated ones are used
        once.
    base
        Directory of the report.
    study_files
        Files of studies that the user named for this report; files named by scans are omitted,
        because they contain code.
    repeated
        True to read a directory as often as it is given.
    skip_unfinished
        True to leave out unfinished runs that have no summary, if other runs remain.

    Raises
    ------
    InputError
        A directory is missing, is neither a run nor a scan, or is damaged; the message lists all
        faults.
    """
    errors: list[str | InputFault] = []
    paths = []
    for directory in directories:
        paths.extend(_parts(Path(directory)))
    if not repeated:
        paths = _each_once(paths)
    if not paths:
        errors.append(
            "no directory was given, expected directories of runs or scans: granwave report DIR..."
        )
    items: list[ReportRun | ReportScan] = []
    unfinished: list[str | InputFault] = []
    for path, label in zip(paths, _labels(paths, base), strict=True):
        try:
            items += _read(path, label, study_files)
        except UnfinishedRunError as error:
            unfinished += error.items
        except InputError as error:
            errors += error.items
    if errors or not (skip_unfinished and items):
        errors += unfinished
    if errors:
        raise InputError(errors)
    suite = read_json(Path(directories[0]) / SUITE_INDEX) if len(directories) == 1 else None
    name = str((suite or {}).get("name", ""))
    return ReportInputs(tuple(items), base, name, tuple(map(str, unfinished)))


def _each_once(paths: Sequence[Path]) -> list[Path]:
    """Return the first of the paths to each directory."""
    unique: dict[Path, Path] = {}
    for path in paths:
        unique.setdefault(path.resolve(), path)
    return list(unique.values())


def _labels(paths: Sequence[Path], base: Path) -> list[str]:
    """Return a label for each directory: its name, or its path if names are equal; a repeated
    directory has a number.
    """
    names = [path.resolve().name or "/" for path in _each_once(paths)]
    labels: list[str] = []
    for path in paths:
        name = path.resolve().name or "/"
        label = name if names.count(name) == 1 else relative(path, base)
        labels.append(distinct(label, labels))
    return labels


def _parts(directory: Path) -> list[Path]:
    """Return the scans of a suite that were started; other directories are returned unchanged."""
    names = (read_json(directory / SUITE_INDEX) or {}).get("scans") or ()
    return [directory / str(name) for name in names if is_scan(directory / str(name))] or [
        directory
    ]


def _read(path: Path, label: str, study_files: Collection[str]) -> list[ReportRun | ReportScan]:
    """Read a directory, which may hold several runs."""
    if not path.exists():
        raise InputError(
            f"{path}: no such directory{similar(path)}; expected the directory of a run or of a scan"
        )
    if not path.is_dir():
        raise InputError(
            f"{path}: is a file, expected the directory of a run or of a scan{around(path)}"
        )
    if is_scan(path):
        return [_read_scan(path, label, study_files)]
    results = ResultDirectory(path)
    try:
        return [*report_kind_in(results).read(results, label)]
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _read_scan(path: Path, label: str, study_files: Collection[str]) -> ReportScan:
    try:
        source = ScanResult(path)
        results = source.points
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"{path / SCAN_INDEX}: a point is incomplete; it needs ({error!r}); run the scan "
            "again with resume=True"
        ) from None
    runs: dict[str, ReportRun] = {}
    points: list[ReportPoint] = []
    errors: list[InputFault] = []
    for result in results:
        done = (
            result.status == "done"
            and result.directory is not None
            and not no_numbers(result.summary)
        )
        whole = result.directory if done else None
        if whole and result.id not in runs:
            try:
                place = ResultDirectory(whole)
                kind = report_kind_in(place)
                runs[result.id] = kind.run_of(place, f"{label} #{result.number}", result.summary)
            except InputError as error:
                errors += error.items
                continue
        points.append(ReportPoint(result, "", runs[result.id]) if whole else _undone(result, path))
    if errors:
        raise InputError(dict.fromkeys(errors))
    suite = read_json(path.parent / SUITE_INDEX) or {}
    of_suite = suite.get("study", ()) if path.name in suite.get("scans", ()) else ()
    named = dict.fromkeys(str(name) for name in [*source.studies, *of_suite])
    unknown = [name for name in named if not is_study_file(name) and name not in STUDIES]
    for name in unknown:
        _LOG.warning("%s: its study %s is omitted: no installed extension provides it", path, name)
    unasked = [name for name in named if is_study_file(name) and name not in study_files]
    for name in unasked:
        _LOG.warning(
            "%s: its study %s is omitted, since reports load external code only on request; add  "
            "--study %s",
            path,
            name,
            name,
        )
    return ReportScan(
        label,
        source,
        tuple(points),
        tuple(name for name in named if name not in {*unknown, *unasked}),
    )


def _undone(result: PointResult, scan: Path) -> ReportPoint:
    """Return a point that is not done, with the reason."""
    finished = scan / POINTS / result.id
    if (finished / SUMMARY_FILE).is_file():
        result = dataclasses.replace(result, status="missing", directory=finished)
        return ReportPoint(
            result, f"its {SUMMARY_FILE} is damaged; recreate it with  granwave analyse", None
        )
    if result.status == "failed":
        return ReportPoint(result, str(result.reason or "no reason was recorded"), None)
    return ReportPoint(result, "started, not finished" if result.directory else "not started", None)
