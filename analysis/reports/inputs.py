"""What a report is about: runs, scans and continuum runs, read from their directories."""

from __future__ import annotations

import dataclasses
import itertools
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal
from urllib.parse import quote

from granwave.analysis.document.model import Link
from granwave.analysis.errors import MissingOutputError, OutputFormatError
from granwave.analysis.result.writer import RECORD_FILE, RESULT_FILE
from granwave.analysis.scans.result import POINTS, SCAN_INDEX, SUITE_INDEX, PointResult, ScanResult, is_scan
from granwave.analysis.summary import SUMMARY_FILE
from granwave.lammps_inputs.deck.deck import CASE_FILE
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.toml_files import read_toml

_OF_A_RUN = (CASE_FILE, SUMMARY_FILE, RECORD_FILE, RESULT_FILE)
_UNFINISHED = ("running", "interrupted", "failed")  # states of run.json with nothing to report
_MOST_NAMED = 5  # files that a message names

Kind = Literal["run", "continuum"]


@dataclasses.dataclass(frozen=True)
class Run:
    """A run with a summary: one that was given, or a point of a scan.

    Attributes
    ----------
    label
        What the report calls it.
    kind
        What computed it; the keys of its summary depend on that.
    status
        done; or refused, when its energy balance was.
    case
        The resolved case by the keys of its tables, such as ``load.velocity``, without ``name`` and what was derived; a
        value may be a table, as ``boundary.bottom``. Empty when there is none.
    record
        run.json; empty when there is none.
    """

    label: str
    kind: Kind
    directory: Path
    status: str
    summary: Mapping[str, Any]
    case: Mapping[str, Any]
    record: Mapping[str, Any]

    def number(self, key: str) -> float | None:
        """A value of the summary if it is a number."""
        value = self.summary.get(key)
        return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    @property
    def versions(self) -> dict[str, str]:
        """Of the programs that made it, by name."""
        found = self.summary.get("versions")
        return {str(name): str(value) for name, value in found.items()} if isinstance(found, dict) else {}


@dataclasses.dataclass(frozen=True)
class Point:
    """A point of a scan; ``run`` is None unless it is done."""

    result: PointResult
    reason: str
    run: Run | None


@dataclasses.dataclass(frozen=True)
class Scan:
    """A scan, its points in order, and the studies that its report makes of it."""

    label: str
    source: ScanResult
    points: tuple[Point, ...]
    studies: tuple[str, ...] = ()

    @property
    def directory(self) -> Path:
        """Of the scan."""
        return self.source.directory

    def count(self, status: str) -> int:
        """How many points have a status."""
        return sum(point.result.status == status for point in self.points)


@dataclasses.dataclass(frozen=True)
class Inputs:
    """All that a report is about, in the order given.

    Attributes
    ----------
    base
        Directory of the report, which paths are shown from.
    """

    items: tuple[Run | Scan, ...]
    base: Path

    @property
    def runs(self) -> tuple[Run, ...]:
        """Runs that were given by themselves."""
        return tuple(item for item in self.items if isinstance(item, Run))

    @property
    def scans(self) -> tuple[Scan, ...]:
        """Scans."""
        return tuple(item for item in self.items if isinstance(item, Scan))

    def results(self) -> Iterator[Run]:
        """All runs, finished points of scans included; points that share a run give it once."""
        for item in self.items:
            if isinstance(item, Run):
                yield item
                continue
            seen: set[Path] = set()
            for point in item.points:
                if point.run is not None and point.run.directory not in seen:
                    seen.add(point.run.directory)
                    yield point.run

    def path(self, path: Path) -> str:
        """A path as seen from the report."""
        return relative(path, self.base)

    def link(self, path: Path, text: str | None = None) -> Link:
        """A link to a file or directory."""
        shown = self.path(path)
        return Link(text or shown, quote(os.fsencode(shown)))


def relative(path: Path, base: Path) -> str:
    """A path as seen from a directory, with forward slashes."""
    return Path(os.path.relpath(path.resolve(), base.resolve())).as_posix()


def read_inputs(directories: Sequence[str | Path], base: Path) -> Inputs:
    """Read runs and scans.

    Parameters
    ----------
    directories
        Of runs and scans, in any mix, and of suites, which stand for their scans; one that is given twice counts once.
    base
        Directory of the report.

    Raises
    ------
    InputError
        A directory is missing, is neither a run nor a scan, or is damaged; every fault is named.
    """
    faults: list[str] = []
    unique: dict[Path, Path] = {}
    for directory in itertools.chain.from_iterable(map(_parts, map(Path, directories))):
        unique.setdefault(directory.resolve(), directory)
    paths = list(unique.values())
    if not paths:
        faults.append("no directory was given, expected those of runs or scans: granwave report DIR...")
    items: list[Run | Scan] = []
    for path, label in zip(paths, _labels(paths, base), strict=True):
        try:
            items.append(_read(path, label))
        except InputError as error:
            faults += error.faults
    if faults:
        raise InputError(faults)
    return Inputs(tuple(items), base)


def _parts(directory: Path) -> list[Path]:
    """The scans of a suite, as far as they were begun; of anything else itself."""
    index = read_json(directory / SUITE_INDEX)
    names = index.get("scans") if index else None
    begun = [directory / str(name) for name in names if is_scan(directory / str(name))] if names else []
    return begun or [directory]


def _labels(paths: Sequence[Path], base: Path) -> list[str]:
    """The directories' own names, or the way to them where two have one name."""
    names = [path.resolve().name or "/" for path in paths]
    return [name if names.count(name) == 1 else relative(path, base) for name, path in zip(names, paths, strict=True)]


def _read(path: Path, label: str) -> Run | Scan:
    if not path.exists():
        raise InputError(f"{path}: no such directory; expected the directory of a run or of a scan")
    if not path.is_dir():
        raise InputError(f"{path}: is a file, expected the directory of a run or of a scan")
    if is_scan(path):
        return _read_scan(path, label)
    try:
        found = sorted(entry.name for entry in path.iterdir())
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if not any(name in found for name in _OF_A_RUN):
        raise InputError(_neither(path, found))
    if SUMMARY_FILE not in found:
        state = _record(path).get("state")
        if state in _UNFINISHED:
            raise InputError(
                f"{path}: the run is not finished (state {state}), so there is no {SUMMARY_FILE}; "
                "go on with  granwave run CASE -o DIR --resume"
            )
        raise InputError(f"{path}: a run without {SUMMARY_FILE}; make it with  granwave analyse {path}")
    return _read_run(path, label, _summary(path))


def _neither(path: Path, found: Sequence[str]) -> str:
    inside = [name for name in found if (path / name / SUMMARY_FILE).is_file() or is_scan(path / name)]
    if inside:
        return f"{path}: is neither a run nor a scan, but holds some ({_few(inside)}); give those"
    holds = f"it holds {_few(found)}" if found else "it is empty"
    return f"{path}: is neither a run nor a scan: {holds}; expected {SUMMARY_FILE} or {SCAN_INDEX} in it"


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + (", ..." if len(names) > _MOST_NAMED else "")


def _summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads((path / SUMMARY_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise InputError(
            f"{path / SUMMARY_FILE}: cannot be read ({error}); make it anew with  granwave analyse {path}"
        ) from None
    if not isinstance(summary, dict):
        raise InputError(
            f"{path / SUMMARY_FILE}: found a {type(summary).__name__}, expected a table of values; "
            f"make it anew with  granwave analyse {path}"
        )
    return summary


def _read_run(path: Path, label: str, summary: Mapping[str, Any]) -> Run:
    case, record = _case(path), _record(path)
    continuum = "n_elements" in summary or any(key.startswith(("punch.", "block.")) for key in case)
    return Run(
        label=label,
        kind="continuum" if continuum else "run",
        directory=path,
        status="refused" if record.get("state") == "refused" else "done",
        summary=summary,
        case=case,
        record=record,
    )


def _record(path: Path) -> dict[str, Any]:
    return read_json(path / RECORD_FILE) or {}


def _case(path: Path) -> dict[str, Any]:
    try:
        tables = read_toml(path / CASE_FILE)
    except InputError:
        return {}
    return dict(_flat({name: value for name, value in tables.items() if name not in ("name", "resolved")}))


def _flat(tables: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in tables.items():
        if isinstance(value, dict):
            yield from ((f"{name}.{key}", part) for key, part in value.items())
        else:
            yield name, value


def _read_scan(path: Path, label: str) -> Scan:
    try:
        source = ScanResult(path)
        results = source.points
    except (MissingOutputError, OutputFormatError) as error:
        raise InputError(str(error)) from None
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"{path / SCAN_INDEX}: a point lacks what it needs ({error!r}); run the scan again with --resume"
        ) from None
    runs: dict[str, Run] = {}
    points = []
    for result in results:
        run = None
        if result.status == "done" and result.directory is not None:
            if result.id not in runs:
                place = result.directory
                runs[result.id] = _read_run(place, f"{label} #{result.number}", result.summary)
            run = runs[result.id]
        points.append(_point(result, path, run))
    suite = read_json(path.parent / SUITE_INDEX) or {}
    of_suite = suite.get("study", ()) if path.name in suite.get("scans", ()) else ()
    return Scan(label, source, tuple(points), tuple(dict.fromkeys([*source.studies, *of_suite])))


def _point(result: PointResult, scan: Path, run: Run | None) -> Point:
    if run is not None:
        return Point(result, "", run)
    finished = scan / POINTS / result.id
    if (finished / SUMMARY_FILE).is_file():
        reason = f"its {SUMMARY_FILE} is damaged; make it anew with  granwave analyse"
        broken = dataclasses.replace(result, status="missing", directory=finished)
        return Point(broken, reason, None)
    if result.status == "failed":
        return Point(result, str(result.reason or "no reason was recorded"), None)
    return Point(result, "begun, not finished" if result.directory else "not begun", None)
