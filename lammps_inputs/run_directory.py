"""File and folder names of a run, and the marker that lists the files that granwave wrote.

A directory of results holds a marker, ``.granwave`` (JSON): the kind of results, the case that was run, and all files
that granwave wrote there. A file that the marker does not list is never overwritten and never deleted, even with
``--force``. A folder is removed only when it is empty, and links are not followed.

The rules that follow from the marker are in `granwave.lammps_inputs.ownership`. Directories of version 0.1.0 have no
marker; `recognise` tells them by the content of their files.
"""

from __future__ import annotations

import dataclasses
import glob
import json
import os
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

from granwave import __version__
from granwave.lammps_inputs.files import head, read_json, read_tables, replace_text

MARKER, LOCK_FILE = ".granwave", ".granwave-lock"
#: Of all results; it grows when earlier versions could not read what is written. Versions 0.1 and 0.2 gave none.
FORMAT = 1

# Of a run: deck, output of LAMMPS, and results of the analysis.
CASE_FILE, DATA_FILE, SCRIPT_FILE = "case.toml", "data.granwave", "in.granwave"
DENTS_FILE = "dents.txt"  # initial dents
LOAD_FILE = "load.txt"  # points of a load given as a table
DEAD_LOAD_FILE = "preload_{}.txt"  # dead loads along x, y or z
LOG_FILE, RECORD_FILE = "log.lammps", "run.json"
RESULT_FILE, SUMMARY_FILE = "result.h5", "summary.json"
CONTACT_TABLE = "contact.csv"  # of two finite-element spheres
CHECKPOINT_FILE = "checkpoint-{}.restart"  # with the step
FIGURES_DIRECTORY, EXPORT_DIRECTORY = "figures", "export"
FIGURES_TABLE = "figures"  # of case.toml; it changes no result, and may be edited after a run
FIGURE_SUFFIXES = (".png", ".pdf", ".csv")  # raster image, vector image, data
NOT_DRAWN_SUFFIX = ".txt"  # of the reason why a figure could not be drawn
MORE_FIGURE_SUFFIXES = (".svg", NOT_DRAWN_SUFFIX)  # of vector images that are asked for, and in place of all
VIEW_FILE, FILM_FILE = "view.html", "film.{}"  # page to turn and cut the packing; film, with its form

# In DUMPS.
DUMPS = "dumps"
ENERGY_FILE, WALLS_FILE, PROBES_FILE = "energy.txt", "walls.txt", "probes.txt"
FRAMES_FILES = {"binary": "spheres.bin", "text": "spheres.dump"}  # by `output.dump_format`
FRAMES_RESUMED = {"binary": "spheres-{}.bin", "text": "spheres-{}.dump"}  # with the step that it was resumed from
HISTORY_FILE, FORCES_FILE, LINES_FILE = "history.dump", "forces.dump", "lines.dump"
FRAME_FORCES_FILE = "contact_forces.dump"  # contact forces of every snapshot
CONTACTS_FILE, WALL_CONTACTS_FILE = "contacts.dump", "wall_{}.dump"  # with the name of the wall's fix
COUNT_FILE = "contacts.txt"  # number of contacts, where each rank writes its own
RANK = "%"  # in the name of a dump, stands for the number of the rank that writes it
STATIC_STAGE_FILE, STATIC_FILE = "prestage.txt", "static.lmp"
# forces of contacts after the static stage: of pairs, of walls by the name of the fix, and the number of pairs
INITIAL_FORCES_FILE, INITIAL_WALL_FORCES_FILE = "initial_forces.dump", "initial_forces_{}.dump"
INITIAL_COUNT_FILE = "initial_forces.txt"  # where each rank writes its own
MOVED_WALLS_FILE = "moved-walls.lmp"  # distances of walls that were moved to a force

# Of a scan, of a suite of scans, and of a point beside its run.
SCAN_FILE, SCAN_INDEX, SUITE_INDEX = "scan.toml", "scan.json", "suite.json"
SCAN_TABLE, SCAN_DATA, SCAN_MEANS, SCAN_REPORT = "scan.csv", "scan.h5", "scan_mean.csv", "report.html"
STUDY_ROWS = "study_rows.csv"  # of a scan or suite: what its studies compare
POINTS, UNFINISHED = "points", "unfinished"
SCAN_WORK = ".scan"  # batches, marks and logs of the engine
POINT_FILE, POINT_CASE, POINT_LOG, POINT_STOP = "point.json", "point.toml", "point.log", ".stop"
POINT_FILES = (POINT_FILE, POINT_CASE, POINT_LOG, POINT_STOP)

# Of a search for a design, whose report is SCAN_REPORT and whose runs are in POINTS.
DESIGN_STUDY, DESIGN_TABLE, DESIGN_OUTCOME = "study.json", "designs.csv", "design.json"
BEST_DESIGNS = tuple(f"best-{n}.toml" for n in range(1, 11))

# Of a fit of the contact law.
FIT_TOML, FIT_PAIR, FIT_TABLE, FIT_MISFIT = FIT_FILES = ("fit.toml", "pair.toml", "fit.csv", "misfit.csv")

# Of an inference of contact forces; its summary is SUMMARY_FILE.
INFERRED_FORCES, INFERRED_GRAINS, MADE_MEASUREMENT = "forces.csv", "grains.csv", "measurement.csv"
MADE_CASE = "measurement.toml"

# Of small waves about a static state; each command leaves NAME.csv and NAME.json, and a group in the file.
SPECTRA_FILE = "spectra.h5"
#: Commands of small waves; each leaves its values in a file of its name, .json.
SPECTRA_KINDS = ("bands", "modes", "transmission")

# Kinds of results.
RUN, CONTINUUM, SCAN, SUITE, FIT, OTHER = "run", "continuum", "scan", "suite", "fit", "other"
INFERENCE, SPECTRA = "inference", "spectra"
DESIGN = "design"


@dataclasses.dataclass
class Marker:
    """Record of the files that granwave wrote into a directory.

    Attributes
    ----------
    kind
        Kind of the results, such as `RUN`.
    version
        Version of granwave that last wrote there.
    case
        Text of case.toml at the start of the run; empty if there is none.
    files
        Sizes in bytes by name relative to the directory; None for files whose size was not noted. A name that ends
        in "/" is a directory of results with a marker of its own; one with "%" stands for the files of all ranks.
    digests
        Digests of the files of the deck as granwave wrote them, by name.
    sums
        CRC-32 of finished files by name, as their sizes in ``files``.
    format
        Format of the results; 0 of versions that gave none.
    """

    kind: str
    version: str = __version__
    case: str = ""
    files: dict[str, int | None] = dataclasses.field(default_factory=dict)
    digests: dict[str, str] = dataclasses.field(default_factory=dict)
    sums: dict[str, int] = dataclasses.field(default_factory=dict)
    format: int = FORMAT

    def write(self, directory: Path) -> None:
        """Replace the marker in ``directory`` atomically."""
        self.version, self.format = __version__, FORMAT
        self.digests = {name: digest for name, digest in self.digests.items() if name in self.files}
        self.sums = {name: one for name, one in self.sums.items() if self.files.get(name) is not None}
        replace_text(directory / MARKER, json.dumps(dataclasses.asdict(self), indent=1) + "\n")


def newer_format(found: object, version: object) -> str:
    """Describe why results cannot be read if their format is beyond `FORMAT`; empty if they can.

    Parameters
    ----------
    found
        Format of the results, a number or its digits; anything else counts as none.
    version
        Version of granwave that wrote them.
    """
    number = int(found) if isinstance(found, int) or (isinstance(found, str) and found.isdecimal()) else 0
    if number <= FORMAT:
        return ""
    return f"found results of format {number}, of granwave {version}, expected at most {FORMAT}: install that version"


def of_each_rank(name: str) -> str:
    """Return the name of a dump of which each rank writes a part, such as ``spheres.%.bin``."""
    path = PurePosixPath(name)
    return str(path.with_suffix(f".{RANK}{path.suffix}"))


def files_of(directory: Path, name: str) -> list[str]:
    """Return the names of the files that a name stands for: itself, or those of all ranks that there are, in order."""
    if RANK not in name:
        return [name]
    folder, (before, after) = (directory / name).parent, PurePosixPath(name).name.split(RANK)
    found = {}
    for path in folder.glob(f"{glob.escape(before)}*{glob.escape(after)}"):
        number = path.name.removeprefix(before).removesuffix(after)
        if number.isascii() and number.isdecimal():
            found[int(number)] = str(PurePosixPath(name).with_name(path.name))
    return [found[number] for number in sorted(found)]


def is_scan(directory: str | Path) -> bool:
    """Return True for the directory of a scan."""
    return (Path(directory) / SCAN_INDEX).is_file()


def is_design(directory: str | Path) -> bool:
    """Return True for the directory of a search for a design; False where it cannot be looked into."""
    return os.access(Path(directory) / DESIGN_OUTCOME, os.R_OK)


_VERSION = "0.1.0"
_SCAN_FILES = (SCAN_FILE, SCAN_INDEX, SCAN_TABLE, SCAN_DATA, SCAN_MEANS, SCAN_REPORT)
_SUITE_FILES = (SCAN_FILE, SUITE_INDEX, SCAN_REPORT)
_DECK = re.compile(
    r"(case\.toml|in\.granwave|data\.granwave|log\.lammps|(dents|load|preload_[xyz])\.txt|checkpoint-\d+\.restart)"
    r"|dumps/((energy|walls|probes|prestage)\.txt|(spheres|history|forces|contacts|wall_\w+)\.dump|spheres(-\d+)?\.bin"
    r"|static\.lmp)"
)
_EXPORTS = re.compile(
    r"export/((spheres|contacts|wall_contacts|energy|probes|prestage|snapshots|points|(walls|snapshot|chain|bar)_\w+)\.csv"
    r"|result\.nc|(spheres|contacts)(\.pvd|_\d{4,}\.vtp)|open_in_ovito\.py)"
)
_OF_SCANS = re.compile(r"\w+_vs_\w+|collapse_\w+|\w+_map")  # figures of scans, without PDF until all points are done


def recognise(directory: Path) -> Marker | None:
    """Return the marker that version 0.1.0 would have written; None if granwave wrote nothing.

    Names prove nothing: other programs may write a ``case.toml`` or a ``figures``. Deck and output of LAMMPS are
    recognised by the header of ``in.granwave`` or the table ``[resolved]`` of ``case.toml``; ``run.json``,
    ``summary.json``, ``result.h5`` and the files of a scan by their keys, or, if damaged, by other files of granwave
    beside them; figures by a PDF of matplotlib without a date.
    """
    kind, case = OTHER, ""
    if _has(directory / SCAN_INDEX, "name", "case", "varied", "points") or (directory / SCAN_WORK / "batches").is_dir():
        points = (path for folder in (POINTS, UNFINISHED) for path in (directory / folder).glob(f"*/{POINT_FILE}"))
        kind, found = SCAN, [*_SCAN_FILES, *(f"{path.parent.relative_to(directory)}/" for path in points)]
    elif _has(directory / SUITE_INDEX, "name", "scans"):
        kind, found = SUITE, list(_SUITE_FILES)
    elif head(directory / FIT_TOML, 99).startswith(b"# Elasto-plastic contact law fitted to "):
        kind, found = FIT, list(FIT_FILES)
    else:
        kind, case, found = _run(directory)
    if not found:
        return None
    there = [name for name in found if (Path.is_dir if name.endswith("/") else Path.is_file)(directory / name)]
    return Marker(kind, _VERSION, case, dict.fromkeys([*there, *_figures(directory)]))


def _has(path: Path, *keys: str) -> bool:
    """Return True if a JSON file has some keys."""
    return set(keys) <= (read_json(path) or {}).keys()


def _run(directory: Path) -> tuple[str, str, list[str]]:
    """Return the kind, the text of the case and the file names of a LAMMPS or finite-element run."""
    tables, summary = read_tables(directory / CASE_FILE) or {}, read_json(directory / SUMMARY_FILE)
    script = head(directory / SCRIPT_FILE, 4096)
    deck = b"\n# Written by granwave from case.toml.\n" in script or "struck" in tables.get("resolved", {})
    point = _has(directory / POINT_FILE, "attempts")
    case = case_of_result(directory / RESULT_FILE)
    own = {
        SUMMARY_FILE: "granwave" in ((summary or {}).get("versions") or {}),
        RECORD_FILE: _has(directory / RECORD_FILE, "n_steps"),
        RESULT_FILE: bool(case),
    }
    if not deck and not point and not any(own.values()):
        return RUN, "", []
    damaged = {
        SUMMARY_FILE: summary is None,
        RECORD_FILE: read_json(directory / RECORD_FILE) is None,
        RESULT_FILE: case is None,
    }
    found = [name for name in own if own[name] or damaged[name]]
    found += [name for name in _names(directory) if (deck and _DECK.fullmatch(name)) or _EXPORTS.fullmatch(name)]
    found += [CASE_FILE, *POINT_FILES] if point else []
    if case and tables == tomllib.loads(case):
        found.append(CASE_FILE)
    if head(directory / CONTACT_TABLE, 99).startswith(b"branch,overlap_m,force_N,"):
        found.append(CONTACT_TABLE)
    if not case and CASE_FILE in found and tables:
        case = (directory / CASE_FILE).read_text(encoding="utf-8")
    return RUN if deck or own[RECORD_FILE] else CONTINUUM, case or "", found


def case_of_result(path: Path) -> str | None:
    """Return the text of the case in a ``result.h5``; empty if it is missing or of others, None if it is damaged."""
    if not path.is_file():
        return ""
    import h5py  # takes longer to load than most commands need

    try:
        with h5py.File(path, "r") as file:
            case = str(file.attrs["case"]) if {"case", "versions"} <= file.attrs.keys() else ""
            return case if tomllib.loads(case) else ""
    except (OSError, ValueError):
        return None


def _figures(directory: Path) -> Iterator[str]:
    """Iterate over the names of figures and their data."""
    names = _names(directory)
    for name in (one for one in names if one.startswith(f"{FIGURES_DIRECTORY}/") and one.endswith(".png")):
        png, pdf, data = (name.removesuffix(".png") + suffix for suffix in FIGURE_SUFFIXES)
        content = head(directory / pdf)
        drawn = b"/Producer (Matplotlib pdf backend" in content and b"/CreationDate" not in content
        if data in names and (drawn or (pdf not in names and _OF_SCANS.fullmatch(Path(name).stem))):
            yield from (file for file in (png, pdf, data) if file in names)


def _names(directory: Path) -> list[str]:
    """Return the names of the files of a run, and of those in its folders that are no links."""
    folders = [directory / name for name in ("", DUMPS, EXPORT_DIRECTORY, FIGURES_DIRECTORY)]
    paths = (path for folder in folders[:1] + [one for one in folders[1:] if not one.is_symlink()]
             for path in sorted(folder.glob("*")) if path.is_file())  # fmt: skip
    return [path.relative_to(directory).as_posix() for path in paths]
