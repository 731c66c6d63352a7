"""Check of a ``result.h5`` when it is opened, and messages about paths without the result of a
granular run.

Messages state the content of a path, and the required path.
"""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Container, Sequence
from pathlib import Path

import h5py

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs import run_directory as files
from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.result_directory import ResultDirectory

OF_A_RUN = (files.CASE_FILE, files.SUMMARY_FILE, files.RECORD_FILE, files.RESULT_FILE)
_RUNNING = "running"
UNFINISHED = (_RUNNING, "interrupted", "failed")  # states of run.json with nothing to report
_MOST_NAMED = 5  # files in a message


def why_no_run(path: Path) -> str:
    """Describe in one line why ``path`` cannot be read as the directory of a run, or as its
    result.h5.
    """
    if not path.exists():
        return f"{path}: no such directory{similar(path)}; expected the directory of a run"
    if not path.is_dir():
        return f"{path}: is a file, expected the directory of a run{around(path)}"
    if (path / files.SCAN_INDEX).exists() or (path / files.SUITE_INDEX).exists():
        scans = (
            [path]
            if files.is_scan(path)
            else sorted(place for place in path.iterdir() if files.is_scan(place))
        )
        points = []
        for scan in scans:
            points.extend(sorted((scan / files.POINTS).glob("*")))
        done = next((place for place in points if (place / files.RESULT_FILE).is_file()), None)
        if done is None:
            return f"{path}: is a scan of which no point is done; run it first (granwave scan ... -o {path} --resume)"
        which = f"{files.SCAN_TABLE} lists the points"
        return (
            f"{path}: is a scan, expected a run; use the directory of a point, such as {done} "
            f"({which})"
        )
    if reason := ResultDirectory(path).kind.why_no_run:
        return f"{path}: {reason}"
    found = sorted(entry.name for entry in path.iterdir())
    if not any(name in found for name in OF_A_RUN):
        expected = f"expected {files.RESULT_FILE} in it, written by  granwave run CASE -o {path}"
        return no_results(path, found, "no run", expected)
    if files.CASE_FILE not in found:
        return f"{path}: {files.CASE_FILE} is missing, so the run there cannot be read; run the case again with force=True"
    if stop := where_stopped(path):
        return f"{path}: {stop}; {way_on(path)}"
    return f"{path / files.RESULT_FILE} is missing: make it with  granwave analyse {path}"


def where_stopped(path: Path) -> str:
    """Describe where an unfinished run stopped; empty for a run that is finished."""
    record = read_json(path / files.RECORD_FILE) or {}
    has_output = (path / files.DUMPS / files.ENERGY_FILE).exists()
    is_own = (path / files.MARKER).exists()
    if is_own and not record and not has_output and not (path / files.RESULT_FILE).exists():
        return "the run stopped before its first output"
    state = record.get("state")
    if state not in UNFINISHED:
        return ""
    time = record.get("end_time_s")
    reached = f"reached {quantity_in(time, 's')}; " if time else ""
    return f"{reached}the run is not finished ({state_in_words(path, state)})"


def state_in_words(path: Path, state: str) -> str:
    """Return the state of the record of an unfinished run in words: a record of a running run whose
    directory no process has locked is that of a killed run.
    """
    if state != _RUNNING:
        return f"state {state}"
    return "still running" if ResultDirectory(path).busy() else "killed"


def way_on(path: Path) -> str:
    """Return the advice for an unfinished run: to wait, or the command that resumes it."""
    if ResultDirectory(path).busy():
        return "wait for its end"
    return f"resume with  granwave run {path / files.CASE_FILE} -o {path} --resume"


def no_results(path: Path, found: Sequence[str], what: str, expected: str) -> str:
    """Describe the content of a directory that has no results.

    Parameters
    ----------
    found
        Names of all files in the directory.
    what
        Description of the failure, such as ``neither a run nor a scan``.
    expected
        Description of the expected content.
    """
    inside = [
        name
        for name in found
        if any((path / name / file).is_file() for file in (*OF_A_RUN, files.SCAN_INDEX))
    ]
    if inside:
        return f"{path}: is {what}, but contains some ({few(inside)}); use these directories"
    holds = f"it holds {few(found)}" if found else "it is empty"
    return f"{path}: is {what}: {holds}; {expected}{around(path)}"


def around(path: Path) -> str:
    """Suggest the run or scan that a file or folder belongs to; empty if there is none."""
    place = path.parent
    return (
        f"; did you mean {place}?"
        if any((place / name).is_file() for name in (*OF_A_RUN, files.SCAN_INDEX))
        else ""
    )


def few(names: Sequence[str]) -> str:
    """Join the first of some names."""
    return ", ".join(names[:_MOST_NAMED]) + (", ..." if len(names) > _MOST_NAMED else "")


def similar(path: Path) -> str:
    """Suggest a directory or file next to ``path`` with a similar name; empty if there is none."""
    parent = next(place for place in path.absolute().parents if place.is_dir())
    if parent != path.absolute().parent:
        return f" (there is no directory {path.parent})"
    near = difflib.get_close_matches(path.name, [entry.name for entry in parent.iterdir()], n=1)
    return f"; did you mean {path.with_name(near[0])}?" if near else ""


#: Columns that every result has, by table.
_COLUMNS = {
    "spheres": ("id", "position", "radius", "mass", "peak_force", "dissipated_energy"),
    "contacts": ("i", "j", "peak_force", "peak_overlap", "dissipated_energy"),
    "energy": ("step", "time", "kinetic", "elastic", "dissipated", "input"),
}
_TEXTS = ("wall",)  # columns of text


def damage_of(file: h5py.File) -> str:
    """Describe the damage of a result; empty if there is none.

    Values of data sets are not read.
    """
    try:
        _check(file)
    except (
        OSError,
        RuntimeError,
        KeyError,
        AttributeError,
        TypeError,
        ValueError,
    ) as error:  # errors of h5py and of the parsers
        return " ".join(str(error.args[0] if error.args else error).split())
    return ""


def _refuse_text(name: str, item: h5py.Dataset | h5py.Group) -> None:
    """Raise ValueError for a data set of text in place of numbers."""
    if not isinstance(item, h5py.Dataset) or name.rpartition("/")[2] in _TEXTS:
        return
    if item.dtype.kind not in "biuf":
        raise ValueError(f"{name} does not hold numbers")


def _check(file: h5py.File) -> None:
    """Raise ValueError with the damage, or an error of h5py or of the parsers."""
    tomllib.loads(file.attrs["case"])
    for name in ("run", "versions"):
        if not isinstance(json.loads(file.attrs[name]), dict):
            raise ValueError(f"its {name} is not a table")
    tables = {name: file[name] for name in (*_COLUMNS, "wall_contacts", "probes") if name in file}
    tables |= {f"walls/{name}": table for name, table in file.get("walls", {}).items()}
    for name, required in _COLUMNS.items():
        _check_columns(name, tables.get(name, ()), required)
    for name, table in tables.items():
        _check_table(name, table)
    file.visititems(_refuse_text)
    if file["spheres/position"].shape[1:] != (3,):
        raise ValueError("spheres/position does not hold vectors")
    _check_snapshots(file)


def _check_columns(name: str, table: Container[str], required: Sequence[str]) -> None:
    """Raise ValueError for a table that lacks a column."""
    missing = [column for column in required if column not in table]
    if missing:
        raise ValueError(f"it has no {name}/{missing[0]}")


def _check_table(name: str, table: h5py.Group) -> None:
    """Raise ValueError for a table whose columns differ in length."""
    lengths = {column: values.shape[0] for column, values in table.items()}
    first = next(iter(lengths), "")
    for column, length in lengths.items():
        if length != lengths[first]:
            raise ValueError(f"{name}/{column} has {length} rows, {name}/{first} {lengths[first]}")


def _check_snapshots(file: h5py.File) -> None:
    """Raise ValueError for snapshots of another number of spheres or instants."""
    n_spheres = len(file["spheres/id"])
    n_frames = len(file[f"{GROUP}/position/time"])
    if not len(file["energy/time"]) or not n_spheres:
        raise ValueError("it holds no instant or no sphere")
    for name, element in file[GROUP].items():
        if not isinstance(element, h5py.Group) or "value" not in element:
            continue
        frames, spheres = element["value"].shape[:2]
        if (frames, spheres) != (n_frames, n_spheres):
            raise ValueError(
                f"{GROUP}/{name} holds {frames} snapshots of {spheres} spheres, not {n_frames} of "
                f"{n_spheres}"
            )
