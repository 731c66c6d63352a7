"""Inputs of a report: runs, scans and continuum runs, read from their directories."""

from __future__ import annotations

import dataclasses
import json
import logging
import os
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from granwave.analysis.document.model import Link, is_number
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.quantities import REPORT_COLUMNS, quantity
from granwave.analysis.result.not_a_run import (
    OF_A_RUN,
    UNFINISHED,
    around,
    no_results,
    resumed,
    similar,
)
from granwave.analysis.result.reader import Result
from granwave.analysis.result.writer import BALANCE_REFUSED
from granwave.analysis.scans.keys import Means, means_of
from granwave.analysis.scans.result import PointResult, ScanResult
from granwave.analysis.studies.registry import is_study_file
from granwave.extensions.waves.spectra.files import recorded
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE
from granwave.lammps_inputs.errors import InputError, InputFault
from granwave.lammps_inputs.files import read_json, read_tables, regular
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    CASE_FILE,
    POINTS,
    RECORD_FILE,
    SCAN_INDEX,
    SPECTRA_KINDS,
    SUITE_INDEX,
    SUMMARY_FILE,
    is_scan,
)

_LOG = logging.getLogger(__name__)
_ACCEPTED = "energy_balance_accepted"
# accepted error of results of finite elements that do not record it
_ACCEPTED_OF_ELEMENTS = 2e-2
_LONGEST = 60  # characters of a faulty value in a message

Kind = Literal["run", "continuum", "spectra"]

_REFUSED = (
    BALANCE_REFUSED,
    "refused",
)  # end_reason of runs, and of finite elements, whose balance did not close


@dataclasses.dataclass(frozen=True)
class ReportRun:
    """A run with a summary, given directly or as a point of a scan.

    Attributes
    ----------
    label
        Label in the report; it says so where the run was refused.
    kind
        Kind of the run, on which the keys of its summary depend; ``spectra``: bands, modes or
        transmission, of which the summary says which.
    status
        ``done``, or ``refused`` if the energy balance did not close.
    case
        Resolved case by dotted key, such as ``load.velocity``, without ``name`` and derived values;
        a value may be a table, such as ``boundary.bottom``. Empty if unknown.
    record
        Content of run.json; empty if there is none.
    """

    label: str
    kind: Kind
    results: ResultDirectory
    status: str
    summary: Mapping[str, Any]
    case: Mapping[str, Any]
    record: Mapping[str, Any]

    @property
    def directory(self) -> Path:
        """Path of its directory."""
        return self.results.path

    @property
    def is_inference(self) -> bool:
        """True for forces inferred from measured grains, which have no energy balance and no case."""
        return self.summary.get("kind") == "inference"

    @property
    def has_balance(self) -> bool:
        """True for what was integrated in time, and so has energies."""
        return self.kind != "spectra" and not self.is_inference

    @property
    def accepted_error(self) -> float:
        """Largest error of the energy balance, over the input, with which the run was accepted.

        Results of versions that did not record it were judged by the limits of those versions.
        """
        for source in (self.summary, self.record):
            value: Any = source.get(_ACCEPTED)
            if is_number(value):
                return float(value)
        if self.kind == "continuum":
            return _ACCEPTED_OF_ELEMENTS
        aimed: Any = self.case.get("run.energy_tolerance")
        return max(BALANCE_TOLERANCE, aimed) if is_number(aimed) else BALANCE_TOLERANCE

    def number(self, key: str) -> float | None:
        """Return a value of the summary if it is a number, else None."""
        value = self.summary.get(key)
        return value if is_number(value) else None

    @cached_property
    def damaged(self) -> bool:
        """True if the result.h5 of a granular run is damaged; it may have been removed to keep only
        the summary.
        """
        if self.kind != "run":
            return False
        try:
            Result(self.results).close()
        except MissingOutputError:
            return False
        except OutputFormatError:
            return True
        return False

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the programs that produced the run, by name."""
        found = self.summary.get("versions")
        return (
            {str(name): str(value) for name, value in found.items()}
            if isinstance(found, dict)
            else {}
        )


@dataclasses.dataclass(frozen=True)
class ReportPoint:
    """A point of a scan; ``run`` is None if it is not done, for which ``reason`` tells why."""

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
        Name of the suite if the items are its scans; else empty.
    """

    items: tuple[ReportRun | ReportScan, ...]
    base: Path
    suite: str = ""

    @property
    def runs(self) -> tuple[ReportRun, ...]:
        """Runs that were given directly."""
        return tuple(item for item in self.items if isinstance(item, ReportRun))

    @property
    def scans(self) -> tuple[ReportScan, ...]:
        """Scans that were given."""
        return tuple(item for item in self.items if isinstance(item, ReportScan))

    def results(self) -> Iterator[ReportRun]:
        """Iterate over all runs, including finished points of scans; a run that points share is
        given once.
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
        """Iterate over `results` without those whose result.h5 is damaged."""
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
    directories: Sequence[str | Path], base: Path, study_files: Collection[str] = ()
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
        Files of studies that the user named just now; others that scans hold are left out, as they
        are code.

    Raises
    ------
    InputError
        A directory is missing, is neither a run nor a scan, or is damaged; the message lists all
        faults.
    """
    errors: list[str | InputFault] = []
    unique: dict[Path, Path] = {}
    for path in [part for directory in directories for part in _parts(Path(directory))]:
        unique.setdefault(path.resolve(), path)
    paths = list(unique.values())
    if not paths:
        errors.append(
            "no directory was given, expected those of runs or scans: granwave report DIR..."
        )
    names = [path.resolve().name or "/" for path in paths]
    items: list[ReportRun | ReportScan] = []
    for path, name in zip(paths, names, strict=True):
        try:
            items += _read(
                path, name if names.count(name) == 1 else relative(path, base), study_files
            )
        except InputError as error:
            errors += error.items
    if errors:
        raise InputError(errors)
    suite = read_json(Path(directories[0]) / SUITE_INDEX) if len(directories) == 1 else None
    return ReportInputs(tuple(items), base, str((suite or {}).get("name", "")))


def _parts(directory: Path) -> list[Path]:
    """Return the scans of a suite that were started; other directories are returned unchanged."""
    names = (read_json(directory / SUITE_INDEX) or {}).get("scans") or ()
    return [directory / str(name) for name in names if is_scan(directory / str(name))] or [
        directory
    ]


def _read(path: Path, label: str, study_files: Collection[str]) -> list[ReportRun | ReportScan]:
    """Read a directory; several for bands, modes and transmission in one."""
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
    try:
        found = sorted(entry.name for entry in path.iterdir())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not any(name in found for name in OF_A_RUN):
        if kinds := [name for name in SPECTRA_KINDS if f"{name}.json" in found]:
            return [
                _read_spectrum(path, label if len(kinds) == 1 else f"{label} ({name})", name)
                for name in kinds
            ]
        expected = f"expected {SUMMARY_FILE} or {SCAN_INDEX} in it"
        raise InputError(no_results(path, found, "neither a run nor a scan", expected))
    if SUMMARY_FILE not in found:
        state = (read_json(path / RECORD_FILE) or {}).get("state")
        if state in UNFINISHED:
            raise InputError(
                f"{path}: the run is not finished (state {state}), so there is no {SUMMARY_FILE}; "
                f"go on with  {resumed(path)}"
            )
        raise InputError(
            f"{path}: a run without {SUMMARY_FILE}; make it with  granwave analyse {path}"
        )
    results = ResultDirectory(path)
    return [_read_run(results, label, _summary(results))]


def _read_spectrum(path: Path, label: str, kind: str) -> ReportRun:
    """Read bands, modes or a transmission; the case and the versions are those of spectra.h5."""
    tables, versions = recorded(path)
    values = read_json(path / f"{kind}.json")
    if values is None:
        raise InputError(
            f"{path / f'{kind}.json'}: cannot be read; make it anew with  granwave {kind} CASE -o {path} --force"
        )
    return ReportRun(
        label,
        "spectra",
        ResultDirectory(path),
        "done",
        {**values, "kind": kind, "versions": versions},
        by_key(tables),
        {},
    )


def _summary(results: ResultDirectory) -> dict[str, Any]:
    results.refuse_special()
    path = results.path
    try:
        summary = json.loads(regular(path / SUMMARY_FILE).read_text(encoding="utf-8"))
        wrong = (
            ""
            if isinstance(summary, dict)
            else f"found a {type(summary).__name__}, expected a table of values"
        )
        wrong = wrong or "".join(_no_numbers(summary)[:1])
    except (OSError, ValueError, RecursionError) as error:
        wrong = f"cannot be read ({error})"
    if wrong:
        raise InputError(
            f"{path / SUMMARY_FILE}: {wrong}; make it anew with  granwave analyse {path}"
        )
    return dict(summary)


def _no_numbers(summary: Mapping[str, Any]) -> list[str]:
    """Describe the quantities of a summary that are not numbers; null is allowed, for those that do
    not apply.
    """
    found = []
    for key, value in summary.items():
        if value is None or not (quantity(key).unit or key in REPORT_COLUMNS):
            continue
        if (
            isinstance(value, list)
            and not quantity(key).unit
            and all(isinstance(item, str) for item in value)
        ):
            continue  # words, such as the bounds that a zone reaches
        if not is_number(value) or abs(value) > sys.float_info.max:
            text = repr(value)
            more = "..." if len(text) > _LONGEST else ""
            found.append(f"{key}: found {text[:_LONGEST]}{more}, expected a number")
    return found


def _read_run(results: ResultDirectory, label: str, summary: Mapping[str, Any]) -> ReportRun:
    results.check_case()
    if changed := results.changed_result():
        raise InputError(changed)
    case = by_key(read_tables(results / CASE_FILE) or results.tables_as_run() or {})
    record = read_json(results / RECORD_FILE) or {}
    continuum = "n_elements" in summary or any(key.startswith(("punch.", "block.")) for key in case)
    refused = record.get("state") == "refused" or summary.get("end_reason") in _REFUSED
    label, status = (f"{label} (refused)", "refused") if refused else (label, "done")
    kind: Kind = "continuum" if continuum else "run"
    return ReportRun(label, kind, results, status, summary, case, record)


def by_key(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a case by dotted key."""
    found: dict[str, Any] = {}
    for name, value in tables.items():
        if isinstance(value, dict) and name != "resolved":
            found |= {f"{name}.{key}": part for key, part in value.items()}
        elif name not in ("name", "resolved"):
            found[name] = value
    return found


def _read_scan(path: Path, label: str, study_files: Collection[str]) -> ReportScan:
    try:
        source = ScanResult(path)
        results = source.points
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"{path / SCAN_INDEX}: a point lacks what it needs ({error!r}); run the scan again with resume=True"
        ) from None
    runs: dict[str, ReportRun] = {}
    points: list[ReportPoint] = []
    errors: list[InputFault] = []
    for result in results:
        done = (
            result.status == "done"
            and result.directory is not None
            and not _no_numbers(result.summary)
        )
        whole = result.directory if done else None
        if whole and result.id not in runs:
            try:
                place = ResultDirectory(whole)
                runs[result.id] = _read_run(place, f"{label} #{result.number}", result.summary)
            except InputError as error:
                errors += error.items
                continue
        points.append(ReportPoint(result, "", runs[result.id]) if whole else _undone(result, path))
    if errors:
        raise InputError(dict.fromkeys(errors))
    suite = read_json(path.parent / SUITE_INDEX) or {}
    of_suite = suite.get("study", ()) if path.name in suite.get("scans", ()) else ()
    named = dict.fromkeys(str(name) for name in [*source.studies, *of_suite])
    unasked = [name for name in named if is_study_file(name) and name not in study_files]
    for name in unasked:
        _LOG.warning(
            "%s: its study %s is left out, for reports load no code unasked; add  --study %s",
            path,
            name,
            name,
        )
    return ReportScan(
        label, source, tuple(points), tuple(name for name in named if name not in unasked)
    )


def _undone(result: PointResult, scan: Path) -> ReportPoint:
    """Return a point that is not done, with the reason."""
    finished = scan / POINTS / result.id
    if (finished / SUMMARY_FILE).is_file():
        result = dataclasses.replace(result, status="missing", directory=finished)
        return ReportPoint(
            result, f"its {SUMMARY_FILE} is damaged; make it anew with  granwave analyse", None
        )
    if result.status == "failed":
        return ReportPoint(result, str(result.reason or "no reason was recorded"), None)
    return ReportPoint(result, "begun, not finished" if result.directory else "not begun", None)
