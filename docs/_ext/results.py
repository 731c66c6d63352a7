"""Comparison with the literature: runs suites, and writes the pages, the JSON file and the table in
the README from them.

    python docs/_ext/results.py [SUITE ...] [--runs DIR] [--no-run] [--check]

The suites are the suites of the package and of ``reproductions``. Without names, suites with stale
rows are run: rows from a version with different numbers, or from scans, cases or studies that have
changed since. Runs are kept in DIR (``build/results``), and a second call continues from the
existing runs. With ``--no-run`` all existing runs are collected and no run is made; with
``--check`` stale suites are listed and nothing is written.
"""

from __future__ import annotations

import argparse
import ast
import dataclasses
import hashlib
import importlib.util
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import results_stored
import results_table
from packaging.version import Version

import granwave
from granwave.analysis.reports.inputs import ReportInputs, read_inputs
from granwave.analysis.reports.studies import comparison_of, studies_of
from granwave.analysis.studies.registry import COMPARISON, STUDIES
from granwave.analysis.studies.study import Study
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.lammps_inputs.run_directory import SUMMARY_FILE
from granwave.workflows import library
from granwave.workflows.scanning.scan_file import load_scan
from granwave.workflows.scanning.suite import is_suite, load_suite

RUNS = results_stored.ROOT / "build" / "results"
_NO_RUN = ".venv/bin/python docs/_ext/results.py --no-run"
_COMPARED = ("thesis-5",)  # suites of reproductions with packings and blocks
#: Functions of a script of which its rows come.
_ROW_FUNCTIONS = ("rows", "select", "name", "title", "text", "verdict")
# programs whose versions are shown on the page
_PROGRAMS = ("granwave", "lammps", "numpy", "scipy")
#: Rows of this version and of later ones remain valid. It stays 1.0.0 although 1.1 has other
#: numbers: all stored rows are later than the release of 1.0.0 (2026-11-27), and were run by the
#: development of 1.1, which called itself 1.0.0. tests/golden and a fresh run of two cases hold the
#: numbers.
SAME_NUMBERS_SINCE = "1.0.0"


@dataclasses.dataclass(frozen=True)
class Suite:
    """Runs of a section of the page.

    Attributes
    ----------
    title
        Title of its section of the page.
    command
        Subcommand of granwave.
    names
        Built-in suite or scan, or cases; or the path of a suite file.
    studies
        Studies of all runs, in addition to those that scans name.
    comparison
        True if impacts on packings and blocks are compared with each other.
    """

    title: str
    command: str
    names: tuple[str, ...]
    studies: tuple[str, ...] = ()
    comparison: bool = False


def reproductions() -> dict[str, Suite]:
    """Suites of the folder ``reproductions``: the name of each file, with its first line, a
    comment, as title.
    """
    files = [
        path
        for path in sorted((results_stored.ROOT / "reproductions").rglob("*.toml"))
        if "scans" in read_toml(path)
    ]
    titles = [
        path.read_text(encoding="utf-8").partition("\n")[0].removeprefix("# ") for path in files
    ]
    return {
        str(read_toml(path)["name"]): Suite(
            title,
            "scan",
            (str(path.relative_to(results_stored.ROOT)),),
            comparison=read_toml(path)["name"] in _COMPARED,
        )
        for path, title in zip(files, titles, strict=True)
    }


SUITES = {
    **reproductions(),
    "protection": Suite("Protected targets", "scan", ("protection",), comparison=True),
    "tolerance": Suite("Tolerance and friction", "scan", ("tolerance",)),
}


def run(suite: Suite, runs: Path) -> bool:
    """Run the points that are not finished; True if all are finished."""
    command = [sys.executable, "-m", "granwave.workflows", suite.command]
    done = [
        subprocess.run(
            [*command, name, "-o", str(runs / folder), "--resume"], cwd=results_stored.ROOT
        )
        for name, folder in zip(suite.names, _folders(suite), strict=True)
    ]
    return all(one.returncode == 0 for one in done)


def _folders(suite: Suite) -> list[str]:
    """Return the directories of a suite's runs."""
    return [
        str(read_toml(results_stored.ROOT / name)["name"]) if _is_path(name) else name
        for name in suite.names
    ]


def _is_path(name: str) -> bool:
    return name.endswith(".toml")


def _study_files(suite: Suite) -> list[Path]:
    """Return the scripts next to the files of a suite."""
    folders = [(results_stored.ROOT / name).parent for name in suite.names if _is_path(name)]
    return [path for folder in folders for path in sorted(folder.glob("*.py"))]


def _solver_tables(suite: Suite) -> list[Path]:
    """Return the tables of second solvers next to the scripts of a suite."""
    folders = sorted({path.parent for path in _study_files(suite)})
    tables: list[Path] = []
    for folder in folders:
        tables += sorted(folder.glob("*.csv"))
    return tables


def collect(suite: Suite, runs: Path) -> dict[str, Any] | None:
    """Results of a suite in the form in which they are stored; None if no part of it was run."""
    folders = [runs / folder for folder in _folders(suite)]
    if not all(folder.is_dir() for folder in folders):
        return None
    try:
        inputs = read_inputs(folders, runs, [str(path) for path in _study_files(suite)])
    except InputError as error:
        print("\n".join(error.errors), file=sys.stderr)
        return None
    results = list(inputs.results())
    if not results:
        return None
    newest = max((one.directory / SUMMARY_FILE).stat().st_mtime for one in results)
    versions = {
        name: sorted({one.versions[name] for one in results if name in one.versions})
        for name in _PROGRAMS
    }
    return {
        "title": suite.title,
        "command": f"granwave {suite.command} {' '.join(suite.names)}",
        "date": datetime.fromtimestamp(newest, UTC).date().isoformat(),
        "complete": _complete(suite, inputs) and versions["granwave"] == [granwave.__version__],
        "versions": {name: found for name, found in versions.items() if found},
        "digests": digests(suite),
        "studies": {
            study.name: results_stored.as_stored(study) for study in studies(inputs, suite)
        },
    }


def _complete(suite: Suite, inputs: ReportInputs) -> bool:
    """Return True if every present point of the scans and every single run is finished."""
    if suite.command != library.SCAN:
        return all(run.status == "done" for run in inputs.runs)
    done = set()
    for scan in inputs.scans:
        for point in scan.points:
            if point.run:
                done.add(point.result.id)
    scans = []
    for name in suite.names:
        file = results_stored.ROOT / name if _is_path(name) else name
        scans += (
            load_suite(file, here=False).scans if is_suite(file) else [load_scan(file, here=False)]
        )
    return all(point.id in done for scan in scans for point in scan.points)


def digests(suite: Suite) -> dict[str, str]:
    """Digests of the scans and cases of a suite, and of the studies that make rows from its
    runs.
    """
    tables = list(_tables(suite))
    names = studies_named(suite)
    modules = [module for name, module in (STUDIES | COMPARISON).items() if name in names]
    files: set[Path] = set()
    for module in modules:
        files |= _files_of(module)
    code: list[str] = []
    for file in files:
        code += _code(file)
    code = sorted([*code, *_code_of_scripts(_scripts(suite, names))])
    code += [table.read_text(encoding="utf-8") for table in _solver_tables(suite)]
    return {"runs": _digest(tables), "studies": _digest(code)}


def _files_of(module: str) -> set[Path]:
    """Return the file of a study's module, and the files of its folder that it imports."""
    package = _package_of(module)
    files: set[Path] = set()
    modules = [module]
    while modules:
        specification = importlib.util.find_spec(modules.pop())
        if specification is None or specification.origin is None:
            continue
        file = Path(specification.origin)
        if file in files:
            continue
        files.add(file)
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module == package:
                modules += [f"{package}.{alias.name}" for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and _package_of(node.module or "") == package:
                modules.append(str(node.module))
    return files


def _scripts(suite: Suite, names: set[str]) -> list[Path]:
    """Return the scripts that a suite names, and the scripts of their folder that they import."""
    beside = {path.stem: path for path in _study_files(suite)}
    found: dict[str, Path] = {}
    stems = [Path(name).stem for name in names if name.endswith(".py")]
    while stems:
        stem = stems.pop()
        if stem not in beside or stem in found:
            continue
        found[stem] = beside[stem]
        for node in ast.walk(ast.parse(beside[stem].read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                stems.append(str(node.module))
            elif isinstance(node, ast.Import):
                stems += [alias.name for alias in node.names]
    return sorted(found.values())


def _package_of(module: str) -> str:
    return module.rpartition(".")[0]


def studies_named(suite: Suite) -> set[str]:
    """Return the names of all studies of a suite."""
    names = {*suite.studies, *(COMPARISON if suite.comparison else ())}
    for table in _tables(suite):
        named = table.get("study", ())
        names |= {named} if isinstance(named, str) else set(named)
    return names


def _tables(suite: Suite) -> Iterator[Mapping[str, Any]]:
    """Iterate over the content of the scan and case files of a suite."""
    kind = library.SCANS if suite.command == library.SCAN else library.CASES
    files = [
        results_stored.ROOT / name if _is_path(name) else library.find(name, kind)
        for name in suite.names
    ]
    for file in files:
        table = read_toml(file)
        yield table
        files += [library.find(name, library.SCANS, file.parent) for name in table.get("scans", ())]
        cases = [*table.get("cases", ()), *([table["case"]] if "case" in table else [])]
        files += [
            found
            for name in cases
            if (found := library.find(name, library.CASES, file.parent)) not in files
        ]


def _code(file: Path) -> list[str]:
    """Return the definitions of a module that affect rows.

    Imports, comments, docstrings, the layout of the text, the functions `pictures` and `tables`,
    and the text `NEEDS` of a message are left out.
    """
    return [ast.unparse(node) for node in _definitions(file)]


def _definitions(file: Path) -> list[ast.stmt]:
    """Return the definitions of a module, as `_code` has them."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    for node in ast.walk(tree):
        if isinstance(node, documented) and ast.get_docstring(node, clean=False) is not None:
            node.body[0] = ast.Pass()
    left_out = (ast.Import, ast.ImportFrom, ast.If, ast.Pass)
    return [
        node
        for node in tree.body
        if not isinstance(node, left_out)
        and getattr(node, "name", "") not in ("pictures", "tables")
        and not (isinstance(node, ast.Assign) and "NEEDS" in _names_defined(node))
    ]


def _code_of_scripts(files: Sequence[Path]) -> list[str]:
    """Return the definitions of scripts that are reached, by name, from the functions that make
    rows.

    Other definitions, such as a table of words for a figure, make no row stale.
    """
    definitions: list[ast.stmt] = []
    for file in files:
        definitions += _definitions(file)
    names = set(_ROW_FUNCTIONS)
    reached: list[ast.stmt] = []
    while more := [
        node for node in definitions if node not in reached and _names_defined(node) & names
    ]:
        reached += more
        for node in more:
            names |= {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}
            names |= {part.attr for part in ast.walk(node) if isinstance(part, ast.Attribute)}
    return [ast.unparse(node) for node in reached]


def _names_defined(node: ast.stmt) -> set[str]:
    """Return the names that a statement of a module defines."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    stored = (part for part in ast.walk(node) if isinstance(part, ast.Name))
    return {part.id for part in stored if isinstance(part.ctx, ast.Store)}


def _digest(content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:12]


def stale(stored: Mapping[str, Any], names: Sequence[str] = tuple(SUITES)) -> dict[str, str]:
    """Return the reason why stored rows are stale, and the command to run, for each stale suite."""
    found = {}
    for name in names:
        suite = stored["suites"].get(name)
        now = digests(SUITES[name])
        if suite is None:
            why = "no rows are stored"
        elif not all(_same_numbers(version) for version in suite["versions"]["granwave"]):
            why = (
                f"run by granwave {'/'.join(suite['versions']['granwave'])}, and this is {granwave.__version__}, "
                f"with the numbers of {SAME_NUMBERS_SINCE} and later"
            )
        elif not suite["complete"]:
            why = "not all of its runs are done"
        elif suite.get("digests", {}).get("runs") != now["runs"]:
            why = "its scans or cases have changed since"
        elif suite["digests"] != now:
            found[name] = (
                f"its studies have changed since; run {_NO_RUN} {name} if its runs are there, else make results"
            )
            continue
        else:
            continue
        found[name] = f"{why}; run make results"
    return found


def _same_numbers(version: str) -> bool:
    """Return True if runs of a version have the same numbers as runs of this version."""
    since, made, now = (Version(one) for one in (SAME_NUMBERS_SINCE, version, granwave.__version__))
    return since <= made <= now


def studies(inputs: ReportInputs, suite: Suite) -> list[Study]:
    """Studies of the runs of a suite."""
    return [
        *studies_of(inputs, suite.studies),
        *(comparison_of(inputs) if suite.comparison else ()),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and collect; return the exit status."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "suites", nargs="*", metavar="SUITE", help=f"of {', '.join(SUITES)}; all if none is named"
    )
    parser.add_argument(
        "--runs", type=Path, default=RUNS, help="directory of the runs (default: build/results)"
    )
    parser.add_argument(
        "--no-run", action="store_true", help="collect what is there, and run nothing"
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="name what is stale, and do nothing; exit status 1 if any is",
    )
    options = parser.parse_args(arguments)
    if unknown := [name for name in options.suites if name not in SUITES]:
        parser.error(f"found {', '.join(unknown)}, expected some of {', '.join(SUITES)}")
    old = stale(results_stored.read_stored(), options.suites or tuple(SUITES))
    for name, why in old.items():
        print(f"{name}: {why}", flush=True)
    if options.check:
        return 1 if old else 0
    options.runs.mkdir(parents=True, exist_ok=True)
    stored = results_stored.read_stored()
    failed = []
    for name in options.suites or (SUITES if options.no_run else old):
        if not options.no_run and not run(SUITES[name], options.runs.resolve()):
            failed.append(name)
        found = collect(SUITES[name], options.runs.resolve())
        before = stored["suites"].get(name, {}).get("studies", {})
        if found and options.no_run and (lost := sorted(before.keys() - found["studies"].keys())):
            print(
                f"{name}: {', '.join(lost)} would lose rows, as their files are elsewhere; the stored ones stay"
            )
            failed.append(name)
        elif found:
            stored["suites"][name] = found
        else:
            print(f"{name}: no runs in {options.runs}; the stored rows stay")
        stored["suites"] = {one: stored["suites"][one] for one in SUITES if one in stored["suites"]}
        stored["absent"] = [
            suite.title for one, suite in SUITES.items() if one not in stored["suites"]
        ]
        results_table.write_all(stored)
    for name in failed:
        print(f"{name}: not all runs are done; see {options.runs / name}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
