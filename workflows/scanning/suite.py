"""Suites: several scans run in sequence in one directory, with a common report.

name = "packings"
scans = ["velocity-fcc", "velocity-hcp"]  # built-in scans, or scan files
cases = ["half-space"]                    # single runs, each as a scan of one point
study = ["tolerance"]                     # studies of all runs, in addition to those of scans
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.packing.made_packing import PackingNotMadeError, PackingToMake
from granwave.lammps_inputs.case.schema import ErrorList, read_table
from granwave.lammps_inputs.directories import results_directory
from granwave.lammps_inputs.errors import InputError, Mismatch, fault_of
from granwave.lammps_inputs.files import read_toml, replace_text
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    SCAN_FILE,
    SCAN_REPORT,
    STUDY_ROWS,
    SUITE,
    SUITE_INDEX,
)
from granwave.workflows.run.directory import held
from granwave.workflows.scanning.directory import decide
from granwave.workflows.scanning.driver import ScanOutcome, publish, run_scan
from granwave.workflows.scanning.header import STUDIES_TYPE, studies_beside
from granwave.workflows.scanning.scan_file import Scan, find_scan, load_scan, scan_of_case

_SCANS = "scans"
_FILES = (SCAN_FILE, SUITE_INDEX, SCAN_REPORT, STUDY_ROWS)


_STUDIES_FORM = "a list of names of built-in studies and of files"
_STUDIES = schema.ListType(item=schema.TextType(expected=_STUDIES_FORM), expected=_STUDIES_FORM)


@dataclasses.dataclass(frozen=True, kw_only=True)
class SuiteFile:
    """Keys of a suite file."""

    name: str = schema.typed("name of the suite", schema.PLAIN_NAME, default="")
    scans: tuple[str, ...] = schema.typed(
        "built-in scans, or scan files (paths relative to this file)", _STUDIES
    )
    cases: tuple[str, ...] = schema.typed(
        "built-in cases, or case files (paths relative to this file)", _STUDIES, default=()
    )
    study: tuple[str, ...] = schema.typed(
        "study, or list of studies, of all runs", STUDIES_TYPE, default=()
    )


@dataclasses.dataclass(frozen=True)
class Suite:
    """A checked suite; each scan runs in a subdirectory of its name."""

    name: str
    scans: tuple[Scan, ...]
    text: str
    study: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class SuiteOutcome:
    """Outcome of a suite; scans that were not started have no outcome."""

    directory: Path
    scans: tuple[ScanOutcome, ...]
    complete: bool
    stopped: str | None


def is_suite(file: str | Path) -> bool:
    """Return True if a file, or built-in study, is a suite of scans.

    Raises
    ------
    InputError
        There is no such scan.
    """
    return _SCANS in read_toml(find_scan(file))


def load_suite(file: str | Path, *, here: bool = True) -> Suite:
    """Read a suite and all its scans.

    Parameters
    ----------
    file
        Path of the file, or name of a built-in suite.
    here
        As in `load_scan`.

    Raises
    ------
    InputError
        The file or any of its scans is invalid; the message lists all faults.
    PackingNotMadeError
        Packings of its scans are not made, and this is within `nothing_made`.
    """
    path = find_scan(file)
    data = read_toml(path)
    errors = ErrorList(str(path))
    header = read_table(SuiteFile, {"name": path.stem, **data}, "", errors)
    studies = studies_beside(header.study, path, errors) if header else ()
    if header is None or errors.items:
        raise InputError(errors.items)
    scans: list[Scan] = []
    to_make: dict[Path, PackingToMake] = {}
    for key, entry in [(_SCANS, entry) for entry in header.scans] + [
        ("cases", entry) for entry in header.cases
    ]:
        try:
            if key == _SCANS:
                scans.append(load_scan(find_scan(entry, path.parent), here=here))
            else:
                scans.append(scan_of_case(entry, path, here=here))
        except PackingNotMadeError as error:
            to_make.update({packing.file: packing for packing in error.packings})
        except InputError as error:
            known = f"{entry}: " if key == _SCANS else f"{path}: case: {entry}: "
            errors.extend(
                fault_of(f"{key}: {entry}: {str(item).removeprefix(known)}", source=str(path))
                for item in error.items
            )
    names = [scan.name for scan in scans]
    for twice in sorted({name for name in names if names.count(name) > 1}):
        errors.add(
            _SCANS,
            Mismatch(
                f"two scans of the name {twice}", "different names, since each is a directory"
            ),
        )
    if errors.items:
        raise InputError(errors.items)
    if to_make:
        raise PackingNotMadeError(
            f"{path}: packings of its scans that are not made yet: {len(to_make)}",
            list(to_make.values()),
        )
    return Suite(header.name, tuple(scans), path.read_text(encoding="utf-8"), studies)


def run_suite(
    suite: Suite,
    directory: str | Path,
    *,
    resume: bool = False,
    force: bool = False,
    slowness: Mapping[str, float] | None = None,
    **options: Any,
) -> SuiteOutcome:
    """Run all scans of a suite, and make the common report.

    Parameters
    ----------
    directory
        Directory of the suite, with a subdirectory for each scan.
    resume, force
        As in `run_scan`, for every scan.
    slowness
        As in `run_scan`, for each scan by name.
    options
        Further options of `run_scan`.

    Raises
    ------
    InputError, RunError
        As in `run_scan`; no scan was run if any directory holds other results.
    """
    results = ResultDirectory(results_directory(directory))
    directory = results.path
    with held(results):
        check_suite(suite, results, resume=resume, force=force)
        if force:
            _make_room(suite, results)
        results.claim(_FILES, kind=SUITE)
        replace_text(directory / SCAN_FILE, suite.text)
        names = [scan.name for scan in suite.scans]
        index = {
            "name": suite.name,
            "scans": names,
            "study": list(suite.study),
            "versions": versions_of(()),
        }
        replace_text(directory / SUITE_INDEX, json.dumps(index, indent=1) + "\n")
        outcomes: list[ScanOutcome] = []
        options |= {"resume": resume, "force": force}
        for scan in suite.scans:
            pace = (slowness or {}).get(scan.name, 1.0)
            outcomes.append(run_scan(scan, directory / scan.name, slowness=pace, **options))
            if outcomes[-1].stopped:
                break
        stopped = outcomes[-1].stopped
        if not stopped:
            studies = [*suite.study]
            for scan in suite.scans:
                studies += scan.study
            publish(results, studies, suite=True)
        complete = len(outcomes) == len(suite.scans) and all(
            outcome.complete for outcome in outcomes
        )
        return SuiteOutcome(directory, tuple(outcomes), complete, stopped)


def check_suite(suite: Suite, results: ResultDirectory, *, resume: bool, force: bool) -> None:
    """Raise InputError if a suite cannot be run in a directory, see `decide`, without changing
    anything.
    """
    results.check(force=force)
    results.refuse_other_kind(SUITE)
    scans = {scan.name: ResultDirectory(results / scan.name) for scan in suite.scans}
    if force and any(scan.result_names() for scan in scans.values()):
        results.refuse_immovable()
    for scan in suite.scans:
        decide(scan, scans[scan.name], resume=resume, force=force)
    results.refuse_foreign(_FILES)


def _make_room(suite: Suite, results: ResultDirectory) -> None:
    """Move an existing suite, with its scans, into NAME.old."""
    old = results.free_old_path()
    results.make_room(force=True)
    for scan in suite.scans:
        ResultDirectory(results / scan.name).set_aside(into=old / scan.name)
