"""Recognition of results of version 0.1.0, whose directories have no marker, by the content of their files.

Names prove nothing: other programs may write a ``case.toml`` or a ``figures``. Deck and output of LAMMPS are
recognised by the header of ``in.granwave`` or the table ``[resolved]`` of ``case.toml``; ``run.json``,
``summary.json``, ``result.h5`` and the files of a scan by their keys, or, if damaged, by other files of granwave beside
them; figures by a PDF of matplotlib without a date.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from granwave.lammps_inputs import run_directory as names
from granwave.lammps_inputs.files import head, read_json, read_tables
from granwave.lammps_inputs.run_directory import Marker

_VERSION = "0.1.0"
_DECK = (names.CASE_FILE, names.SCRIPT_FILE, names.DATA_FILE, names.LOG_FILE)
_BESIDE_DECK = re.compile(r"dents\.txt|load\.txt|preload_[xyz]\.txt|checkpoint-\d+\.restart")
_DUMPS = re.compile(
    r"(energy|walls|probes|prestage)\.txt|(spheres|history|forces|contacts|wall_\w+)\.dump|spheres(-\d+)?\.bin|static\.lmp"
)
_SCAN_FILES = (
    names.SCAN_FILE, names.SCAN_INDEX, names.SCAN_TABLE, names.SCAN_DATA, names.SCAN_MEANS, names.SCAN_REPORT,
)  # fmt: skip
_SUITE_FILES = (names.SCAN_FILE, names.SUITE_INDEX, names.SCAN_REPORT)
_OF_SCANS = re.compile(r"\w+_vs_\w+|collapse_\w+|\w+_map")  # figures of scans, without PDF until all points are done
_EXPORTS = re.compile(
    r"(spheres|contacts|wall_contacts|energy|probes|prestage|snapshots|points|(walls|snapshot|chain|bar)_\w+)\.csv"
    r"|result\.nc|(spheres|contacts)(\.pvd|_\d{4,}\.vtp)|open_in_ovito\.py"
)


def recognise(directory: Path) -> Marker | None:
    """Return the marker that version 0.1.0 would have written; None if granwave wrote nothing."""
    case = ""
    if found := _scan(directory):
        kind = names.SCAN
    elif found := _suite(directory):
        kind = names.SUITE
    elif found := _fit(directory):
        kind = names.FIT
    else:
        kind, case, found = _run(directory)
    if not found:
        return None
    there = [name for name in (*found, *_figures(directory)) if _is_there(directory, name)]
    return Marker(kind, _VERSION, case, dict.fromkeys(there))


def _is_there(directory: Path, name: str) -> bool:
    path = directory / name
    return path.is_dir() if name.endswith("/") else path.is_file()


def _scan(directory: Path) -> list[str]:
    index = read_json(directory / names.SCAN_INDEX)
    ours = index is not None and {"name", "case", "varied", "points"} <= index.keys()
    if not ours and not (directory / names.SCAN_WORK / "batches").is_dir():
        return []
    points = [
        f"{folder}/{path.name}/"
        for folder in (names.POINTS, names.UNFINISHED)
        for path in (directory / folder).glob("*")
        if (path / names.POINT_FILE).is_file()
    ]
    return [*_SCAN_FILES, *points]


def _suite(directory: Path) -> list[str]:
    index = read_json(directory / names.SUITE_INDEX)
    return [*_SUITE_FILES] if index is not None and {"name", "scans"} <= index.keys() else []


def _fit(directory: Path) -> list[str]:
    ours = head(directory / names.FIT_TOML, 99).startswith(b"# Elasto-plastic contact law fitted to ")
    return [*names.FIT_FILES] if ours else []


def _run(directory: Path) -> tuple[str, str, list[str]]:
    """Return the kind, the text of the case and the file names of a LAMMPS or finite-element run."""
    tables = read_tables(directory / names.CASE_FILE) or {}
    script = head(directory / names.SCRIPT_FILE, 4096)
    deck = b"\n# Written by granwave from case.toml.\n" in script or "struck" in tables.get("resolved", {})
    point = "attempts" in (read_json(directory / names.POINT_FILE) or {})
    summary = read_json(directory / names.SUMMARY_FILE)
    record = read_json(directory / names.RECORD_FILE)
    whole, case = _result(directory / names.RESULT_FILE)
    own = {
        names.SUMMARY_FILE: "granwave" in ((summary or {}).get("versions") or {}),
        names.RECORD_FILE: "n_steps" in (record or {}),
        names.RESULT_FILE: bool(case),
    }
    if not deck and not point and not any(own.values()):
        return names.RUN, "", []
    damaged = {names.SUMMARY_FILE: summary is None, names.RECORD_FILE: record is None, names.RESULT_FILE: not whole}
    found = [name for name in own if own[name] or damaged[name]]
    if deck:
        found += [*_DECK, *(path.name for path in directory.iterdir() if _BESIDE_DECK.fullmatch(path.name))]
        found += [f"{names.DUMPS}/{name}" for name in _inside(directory / names.DUMPS, _DUMPS)]
    if point:
        found += [names.CASE_FILE, *names.POINT_FILES]
    elif case and tables == tomllib.loads(case):
        found.append(names.CASE_FILE)
    if head(directory / names.CONTACT_TABLE, 99).startswith(b"branch,overlap_m,force_N,"):
        found.append(names.CONTACT_TABLE)
    found += [f"{names.EXPORT_DIRECTORY}/{name}" for name in _inside(directory / names.EXPORT_DIRECTORY, _EXPORTS)]
    if not case and names.CASE_FILE in found and tables:
        case = (directory / names.CASE_FILE).read_text(encoding="utf-8")
    return names.RUN if deck or own[names.RECORD_FILE] else names.CONTINUUM, case, found


def _result(path: Path) -> tuple[bool, str]:
    """Return True if a file is missing or readable as HDF5, and the text of the case in it, empty if it has none."""
    if not path.is_file():
        return True, ""
    import h5py  # takes longer to load than most commands need

    try:
        with h5py.File(path, "r") as file:
            case = str(file.attrs["case"]) if {"case", "versions"} <= file.attrs.keys() else ""
            return True, case if tomllib.loads(case) else ""
    except (OSError, ValueError):
        return False, ""


def _figures(directory: Path) -> Iterator[str]:
    """Iterate over the names of figures and their data."""
    folder = directory / names.FIGURES_DIRECTORY
    for name in _inside(folder, re.compile(r".+\.png")):
        stem = name.removesuffix(".png")
        pdf = folder / f"{stem}.pdf"
        drawn = _is_undated(pdf) if pdf.exists() else _OF_SCANS.fullmatch(stem) is not None
        if drawn and (folder / f"{stem}.csv").is_file():
            yield from (f"{names.FIGURES_DIRECTORY}/{stem}{suffix}" for suffix in (".png", ".pdf", ".csv"))


def _is_undated(pdf: Path) -> bool:
    content = head(pdf)
    return b"/Producer (Matplotlib pdf backend" in content and b"/CreationDate" not in content


def _inside(folder: Path, pattern: re.Pattern[str]) -> list[str]:
    """Return the names of files in a folder that match a pattern."""
    if not folder.is_dir() or folder.is_symlink():
        return []
    return sorted(path.name for path in folder.iterdir() if pattern.fullmatch(path.name))
