"""Tables of the files that the core reads: heading, dataclass of the keys, and description.

A description that is empty is the first line of the dataclass.
"""

from __future__ import annotations

from granwave.lammps_inputs.case.case import CaseHead, case_tables
from granwave.lammps_inputs.case.contact.contact import Pair
from granwave.lammps_inputs.case.packing.made_packing import packing_makers
from granwave.workflows.cluster.profile import Profile, SlurmProfile
from granwave.workflows.scanning.header import RanksBySize, ScanHeader
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
    made = {f"[packing.{kind}]": (maker.section, "") for kind, maker in packing_makers().items()}
    return {"": (CaseHead, HEAD), **tables, **made, PAIR: (Pair, "")}


def scan_sections() -> Sections:
    """Return the tables of a scan file."""
    return {
        "": (ScanHeader, "top-level keys and the tables of varied keys"),
        "[ranks]": (RanksBySize, ""),
    }


def suite_sections() -> Sections:
    """Return the tables of a suite."""
    return {"": (SuiteFile, "")}


def profile_sections() -> Sections:
    """Return the tables of a profile of a cluster."""
    return {
        "[cluster]": (Profile, "use of the cluster; all keys are optional"),
        "[slurm]": (SlurmProfile, "the same for Slurm only; all keys are optional"),
    }
