"""Tables of the files that the core reads: heading, dataclass of the keys, and description.

A description that is empty is the first line of the dataclass.
"""

from __future__ import annotations

from granwave.lammps_inputs.case.case import CaseHead, case_tables
from granwave.lammps_inputs.case.contact import Pair
from granwave.workflows.scanning.header import RanksBySize, ScanHeader
from granwave.workflows.scanning.slurm import Profile
from granwave.workflows.scanning.suite import SuiteFile

#: Tables of a file by heading: dataclass and description.
Sections = dict[str, tuple[type, str]]

#: Description of the keys above all tables of a case.
HEAD = "name, material and the tables below"
CONTACT = "[contact]"
PAIR = "[[pair]]"


def case_sections() -> Sections:
    """Return the tables of a case."""
    tables = {heading: (section, "") for heading, section in case_tables().items()}
    return {"": (CaseHead, HEAD), **tables, PAIR: (Pair, "")}


def scan_sections() -> Sections:
    """Return the tables of a scan file."""
    return {
        "": (ScanHeader, "top-level keys and the tables of what varies"),
        "[ranks]": (RanksBySize, ""),
    }


def suite_sections() -> Sections:
    """Return the tables of a suite."""
    return {"": (SuiteFile, "")}


def profile_sections() -> Sections:
    """Return the tables of a profile of a cluster."""
    return {"[slurm]": (Profile, "how the cluster is used; every key may be left out")}
