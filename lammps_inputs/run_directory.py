"""Every file and folder name of a run, and the marker that says which files are granwave's.

A directory of results holds a marker, ``.granwave`` (JSON): the kind of results, the case that was run, and every file
that granwave wrote there. A file that the marker does not list is somebody else's: it is never overwritten and never
deleted, also under ``--force``. A folder is removed only when nothing is left in it, and links are not followed.

What the marker allows and refuses is in `granwave.lammps_inputs.ownership`. Directories of version 0.1.0 have no
marker; `granwave.lammps_inputs.unmarked_results` recognises them by what their files hold.
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

from granwave import __version__
from granwave.lammps_inputs.files import replace_text

MARKER, LOCK_FILE = ".granwave", ".granwave-lock"

# Of a run: the deck, what LAMMPS writes, and what is made of it.
CASE_FILE, DATA_FILE, SCRIPT_FILE = "case.toml", "data.granwave", "in.granwave"
DENTS_FILE = "dents.txt"  # dents from before the run
LOAD_FILE = "load.txt"  # points of a load given as a table
DEAD_LOAD_FILE = "preload_{}.txt"  # dead loads, for each direction in which there are some
LOG_FILE, RECORD_FILE = "log.lammps", "run.json"
RESULT_FILE, SUMMARY_FILE = "result.h5", "summary.json"
CONTACT_TABLE = "contact.csv"  # of two finite-element spheres
CHECKPOINT_FILE = "checkpoint-{}.restart"  # the step
FIGURES_DIRECTORY, EXPORT_DIRECTORY = "figures", "export"
FIGURE_SUFFIXES = (".png", ".pdf", ".csv")  # picture, the same for print, and its data

# In DUMPS.
DUMPS = "dumps"
ENERGY_FILE, WALLS_FILE, PROBES_FILE = "energy.txt", "walls.txt", "probes.txt"
FRAMES_FILE, HISTORY_FILE, FORCES_FILE = "spheres.dump", "history.dump", "forces.dump"
CONTACTS_FILE, WALL_CONTACTS_FILE = "contacts.dump", "wall_{}.dump"  # the fix of the wall
STATIC_STAGE_FILE, STATIC_FILE = "prestage.txt", "static.lmp"

# Of a scan, of a suite of scans, and of a point beside its run.
SCAN_FILE, SCAN_INDEX, SUITE_INDEX = "scan.toml", "scan.json", "suite.json"
SCAN_TABLE, SCAN_DATA, SCAN_MEANS, SCAN_REPORT = "scan.csv", "scan.h5", "scan_mean.csv", "report.html"
POINTS, UNFINISHED = "points", "unfinished"
SCAN_WORK = ".scan"  # batches, marks and logs of the engine
POINT_FILE, POINT_CASE, POINT_LOG, POINT_STOP = "point.json", "point.toml", "point.log", ".stop"
POINT_FILES = (POINT_FILE, POINT_CASE, POINT_LOG, POINT_STOP)

# Of a fit of the contact law.
FIT_TOML, FIT_PAIR, FIT_TABLE, FIT_MISFIT = FIT_FILES = ("fit.toml", "pair.toml", "fit.csv", "misfit.csv")

# Kinds of results.
RUN, CONTINUUM, SCAN, SUITE, FIT, OTHER = "run", "continuum", "scan", "suite", "fit", "other"


@dataclasses.dataclass
class Marker:
    """Record of the files that granwave wrote into a directory.

    Attributes
    ----------
    kind
        Of the results, such as `RUN`.
    version
        Of granwave that wrote there last.
    case
        Text of case.toml as the run began with it; empty where there is none.
    files
        Names relative to the directory, and sizes in bytes of those that are finished (None: not noted). A name that
        ends in "/" is a directory of results with a marker of its own.
    """

    kind: str
    version: str = __version__
    case: str = ""
    files: dict[str, int | None] = dataclasses.field(default_factory=dict)

    def write(self, directory: Path) -> None:
        """Replace the marker in ``directory``, all or nothing."""
        self.version = __version__
        replace_text(directory / MARKER, json.dumps(dataclasses.asdict(self), indent=1) + "\n")


def is_scan(directory: str | Path) -> bool:
    """The directory is that of a scan."""
    return (Path(directory) / SCAN_INDEX).is_file()
