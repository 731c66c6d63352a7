"""File and folder names of runs and scans.

Which files granwave may overwrite and delete follows from the marker, see
`granwave.lammps_inputs.own_files`.
"""

from __future__ import annotations

import glob
import os
from pathlib import Path, PurePosixPath

MARKER = ".granwave"
LOCK_FILE = ".granwave-lock"
#: Format of all results; it is increased when earlier versions cannot read the files.
FORMAT = 1

# Files of a run: LAMMPS input script, output of LAMMPS, and results of the analysis.
CASE_FILE = "case.toml"
DATA_FILE = "data.granwave"
SCRIPT_FILE = "in.granwave"
DENTS_FILE = "dents.txt"  # initial dents
LOAD_FILE = "load.txt"  # points of a load given as a table
DEAD_LOAD_FILE = "preload_{}.txt"  # dead loads along x, y or z
# displacements along x, y or z by which grains start near their balance
START_FILE = "start_{}.txt"
BED_FILE = "bed.txt"  # contacts of a settled bed from which a run continues
MESH_FILE = "wall{}.stl"  # surface of triangles of an entry of [[wall]]
LOG_FILE = "log.lammps"
RECORD_FILE = "run.json"
RESULT_FILE = "result.h5"
SUMMARY_FILE = "summary.json"
CHECKPOINT_FILE = "checkpoint-{}.restart"  # name of a checkpoint, with the step
FIGURES_DIRECTORY = "figures"
EXPORT_DIRECTORY = "export"
# table of case.toml that does not affect results, and may be edited after a run
FIGURES_TABLE = "figures"
FIGURE_SUFFIXES = (".png", ".pdf", ".csv")  # raster image, vector image, data
NOT_DRAWN_SUFFIX = ".txt"  # suffix of the file with the reason why a figure could not be drawn
MORE_FIGURE_SUFFIXES = (
    ".svg",
    NOT_DRAWN_SUFFIX,
)  # requested vector images, and in place of all figures
# page to rotate and cut the packing; animation, with its format
VIEW_FILE = "view.html"
FILM_FILE = "film.{}"

# In DUMPS.
DUMPS = "dumps"
ENERGY_FILE = "energy.txt"
WALLS_FILE = "walls.txt"
PROBES_FILE = "probes.txt"
FRAMES_FILES = {"binary": "spheres.bin", "text": "spheres.dump"}  # file by `output.dump_format`
FRAMES_RESUMED = {
    "binary": "spheres-{}.bin",
    "text": "spheres-{}.dump",
}  # log of a resumed run, with the step from which it was resumed
HISTORY_FILE = "history.dump"
FORCES_FILE = "forces.dump"
LINES_FILE = "lines.dump"
FRAME_FORCES_FILE = "contact_forces.dump"  # contact forces of every snapshot
# dump of a wall, with the name of the wall's fix
CONTACTS_FILE = "contacts.dump"
WALL_CONTACTS_FILE = "wall_{}.dump"
COUNT_FILE = "contacts.txt"  # number of contacts, where the dump has several files
RANK = "%"  # part of the name of a dump that stands for the number of a file of several ranks
MOST_PARTS = 64  # files of a checkpoint, and of dumps where the number of nodes is not known
STATIC_STAGE_FILE = "prestage.txt"
STATIC_FILE = "static.lmp"
# contact forces after the static stage: of pairs, of walls by the name of the fix, and the number
# of pairs
INITIAL_FORCES_FILE = "initial_forces.dump"
INITIAL_WALL_FORCES_FILE = "initial_forces_{}.dump"
INITIAL_COUNT_FILE = "initial_forces.txt"  # where the dump has several files
MOVED_WALLS_FILE = "moved-walls.lmp"  # distances of walls that were moved to a force

# Of a scan, of a suite of scans, and of a point next to its run.
SCAN_FILE = "scan.toml"
SCAN_INDEX = "scan.json"
SUITE_INDEX = "suite.json"
SCAN_TABLE = "scan.csv"
SCAN_DATA = "scan.h5"
SCAN_MEANS = "scan_mean.csv"
SCAN_REPORT = "report.html"
STUDY_ROWS = "study_rows.csv"  # rows that the studies of a scan or suite compare
POINTS = "points"
UNFINISHED = "unfinished"
SCAN_WORK = ".scan"  # batches, marks and logs of the engine
POINT_FILE = "point.json"
POINT_CASE = "point.toml"
POINT_LOG = "point.log"
POINT_STOP = ".stop"
POINT_FILES = (POINT_FILE, POINT_CASE, POINT_LOG, POINT_STOP)

#: Files of runs and scans that are opened for reading where they are there, see
#: `granwave.lammps_inputs.result_kinds`; all others are entered in the marker.
READ_FILES = (
    MARKER,
    LOCK_FILE,
    CASE_FILE,
    DATA_FILE,
    SCRIPT_FILE,
    DENTS_FILE,
    LOAD_FILE,
    LOG_FILE,
    RECORD_FILE,
    RESULT_FILE,
    SUMMARY_FILE,
    SCAN_FILE,
    SCAN_INDEX,
    SUITE_INDEX,
    SCAN_TABLE,
    SCAN_DATA,
    STUDY_ROWS,
    *POINT_FILES,
    *(
        f"{DUMPS}/{name}"
        for name in (ENERGY_FILE, WALLS_FILE, PROBES_FILE, COUNT_FILE, STATIC_STAGE_FILE)
    ),
    *(
        f"{DUMPS}/{name}"
        for name in (*FRAMES_FILES.values(), HISTORY_FILE, FORCES_FILE, LINES_FILE, CONTACTS_FILE)
    ),
)

# Kinds of results of the core, see `granwave.lammps_inputs.result_kinds`.
RUN = "run"
SCAN = "scan"
SUITE = "suite"
OTHER = "other"


def newer_format(found: object, version: object) -> str:
    """Describe why results cannot be read if their format is beyond `FORMAT`; empty if they can.

    Parameters
    ----------
    found
        Format of the results, a number or its digits; other values count as no format.
    version
        Version of granwave that wrote them.
    """
    number = (
        int(found)
        if isinstance(found, int) or (isinstance(found, str) and found.isdecimal())
        else 0
    )
    if number <= FORMAT:
        return ""
    return f"found results of format {number}, of granwave {version}, expected at most {FORMAT}: install that version"


def of_each_rank(name: str) -> str:
    """Return the name of a dump in several files, such as ``spheres.%.bin``."""
    path = PurePosixPath(name)
    return str(path.with_suffix(f".{RANK}{path.suffix}"))


def shown_dump(path: Path) -> str:
    """Return the path of a dump for messages, with N for the number of one of several files."""
    if RANK not in path.name:
        return str(path)
    return f"{path.with_name(path.name.replace(RANK, 'N'))} (N = 0, 1, ...)"


def files_of(directory: Path, name: str) -> list[str]:
    """Return the names of the files for a name: the file itself, or all existing parts in order."""
    if RANK not in name:
        return [name]
    folder = (directory / name).parent
    before, after = PurePosixPath(name).name.split(RANK)
    found = {}
    for path in folder.glob(f"{glob.escape(before)}*{glob.escape(after)}"):
        number = path.name.removeprefix(before).removesuffix(after)
        if number.isascii() and number.isdecimal():
            found[int(number)] = str(PurePosixPath(name).with_name(path.name))
    return [found[number] for number in sorted(found)]


def is_scan(directory: str | os.PathLike[str]) -> bool:
    """Return True for the directory of a scan."""
    return (Path(directory) / SCAN_INDEX).is_file()
