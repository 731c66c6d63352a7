"""Results against the sources: runs all suites, and makes the page, the JSON file and the README's table of them.

    python docs/_ext/results.py [SUITE ...] [--runs DIR] [--no-run]

Runs are kept in DIR (``build/results``), and a second call goes on with what is there. Suites that are not named, or
whose runs are missing, stay as they are stored, with the date of their own run.
"""

from __future__ import annotations

import argparse
import dataclasses
import subprocess
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import results_table

from granwave.analysis.reports.inputs import Inputs, read_inputs
from granwave.analysis.reports.sections.comparison import comparison_of
from granwave.analysis.reports.sections.sources import source_rows
from granwave.analysis.reports.sections.studies import studies_of
from granwave.analysis.studies.study import Row, Study
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.run_directory import SUITE_INDEX, SUMMARY_FILE, is_scan

RUNS = results_table.ROOT / "build" / "results"
_PROGRAMS = ("granwave", "lammps", "numpy", "scipy")  # whose versions stand on the page


@dataclasses.dataclass(frozen=True)
class Suite:
    """Runs of a part of the page.

    Attributes
    ----------
    title
        Of its part of the page.
    command
        Subcommand of granwave.
    names
        Built-in suite or scan, or cases.
    studies
        Studies of all runs, in addition to those that scans name.
    """

    title: str
    command: str
    names: tuple[str, ...]
    studies: tuple[str, ...] = ()


SUITES = {
    "fcc-impact": Suite("The reference impact", "run", ("fcc-impact",)),
    "sphere-contacts": Suite("The contact law", "scan", ("sphere-contacts",)),
    "chains": Suite("Chains", "scan", ("chains",)),
    "square": Suite("Square packings", "scan", ("square",)),
    "square-defects": Suite("Square packings that are not ideal", "scan", ("square-defects",)),
    "prestress": Suite("Precompressed, settled and preconditioned packings", "scan", ("prestress",)),
    "protection": Suite("Protected targets", "scan", ("protection",)),
    "tolerance": Suite("Tolerance and friction", "scan", ("tolerance",)),
    "confined": Suite("Confined rows", "scan", ("confined",)),
    "lateral": Suite("Plane crystals between walls", "scan", ("lateral",)),
    "filter": Suite("A row that filters waves", "scan", ("filter",)),
    "filter-maps": Suite("The filter over diameter, length and approach", "scan", ("filter-maps",)),
    "switch": Suite("A row that switches", "scan", ("switch",)),
    "interstitial-fcc": Suite("Small grains in the holes of a packing", "scan", ("interstitial-fcc",)),
    "bands": Suite("Waves in frequency", "scan", ("bands",)),
    "granular-continuum": Suite("Packings beside a continuum", "scan", ("granular-continuum",)),
}


def run(suite: Suite, runs: Path) -> bool:
    """Run what is not yet done; True if all is."""
    done = [
        subprocess.run(
            [sys.executable, "-m", "granwave.workflows", suite.command, name, "-o", str(runs / name), "--resume"]
        )
        for name in suite.names
    ]
    return all(one.returncode == 0 for one in done)


def collect(suite: Suite, runs: Path) -> dict[str, Any] | None:
    """Results of a suite as they are stored; None if nothing of it was run."""
    folders = [runs / name for name in suite.names]
    if not all(folder.is_dir() for folder in folders):
        return None
    try:
        inputs = read_inputs(folders, runs)
    except InputError as error:
        print("\n".join(error.errors), file=sys.stderr)
        return None
    results = list(inputs.results())
    if not results:
        return None
    newest = max((one.directory / SUMMARY_FILE).stat().st_mtime for one in results)
    versions = {name: sorted({one.versions[name] for one in results if name in one.versions}) for name in _PROGRAMS}
    return {
        "title": suite.title,
        "command": f"granwave {suite.command} {' '.join(suite.names)}",
        "date": datetime.fromtimestamp(newest, UTC).date().isoformat(),
        "complete": _complete(inputs, folders),
        "versions": {name: found for name, found in versions.items() if found},
        "studies": {study.name: results_table.as_stored(study) for study in studies(inputs, suite)},
    }


def _complete(inputs: Inputs, folders: Sequence[Path]) -> bool:
    """Return True if every point of every scan is done."""
    suites = [(folder, read_json(folder / SUITE_INDEX) or {}) for folder in folders]
    begun = all(is_scan(folder / name) for folder, index in suites for name in index.get("scans", ()))
    return begun and all(point.run for scan in inputs.scans for point in scan.points)


def studies(inputs: Inputs, suite: Suite) -> list[Study]:
    """Studies of runs, values of the sources for their cases among them."""
    found = [*studies_of(inputs, suite.studies), *comparison_of(inputs)]
    if rows := _once(source_rows(inputs)):
        title, text = "Single values", "Values for single cases; the remark says which."
        found.insert(0, Study(f"{suite.names[0]}-values", title, text, rows))
    return found


def _once(rows: Sequence[Row]) -> tuple[Row, ...]:
    """Rows without those that occurred before."""
    return tuple(dict.fromkeys(rows))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and collect; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suites", nargs="*", metavar="SUITE", help=f"of {', '.join(SUITES)}; all if none is named")
    parser.add_argument("--runs", type=Path, default=RUNS, help="directory of the runs (default: build/results)")
    parser.add_argument("--no-run", action="store_true", help="collect what is there, and run nothing")
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.suites if name not in SUITES]:
        parser.error(f"found {', '.join(unknown)}, expected some of {', '.join(SUITES)}")
    options.runs.mkdir(parents=True, exist_ok=True)
    stored, failed = results_table.read_stored(), []
    for name in options.suites or SUITES:
        if not options.no_run and not run(SUITES[name], options.runs.resolve()):
            failed.append(name)
        if found := collect(SUITES[name], options.runs.resolve()):
            stored["suites"][name] = found
        else:
            print(f"{name}: no runs in {options.runs}; the stored rows stay")
        stored["suites"] = {one: stored["suites"][one] for one in SUITES if one in stored["suites"]}
        stored["absent"] = [suite.title for one, suite in SUITES.items() if one not in stored["suites"]]
        results_table.write_all(stored)
    for name in failed:
        print(f"{name}: not all runs are done; see {options.runs / name}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
