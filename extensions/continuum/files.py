"""Files of runs of finite elements and of fits of the contact law."""

from __future__ import annotations

from pathlib import Path

from granwave.lammps_inputs.files import read_json, read_tables
from granwave.lammps_inputs.result_kinds import ResultKind
from granwave.lammps_inputs.run_directory import CASE_FILE, RESULT_FILE, SUMMARY_FILE

# Kinds of results.
CONTINUUM = "continuum"
FIT = "fit"

CONTACT_TABLE = "contact.csv"  # table of a contact of two finite-element spheres
FIT_TOML = "fit.toml"
FIT_PAIR = "pair.toml"
FIT_TABLE = "fit.csv"
FIT_MISFIT = "misfit.csv"
FIT_FILES = (FIT_TOML, FIT_PAIR, FIT_TABLE, FIT_MISFIT)

_TABLES = {"block", "punch", "sphere", "partner"}  # tables of the cases
_OF_ELEMENTS = "n_elements"  # in the summaries


def _holds_elements(directory: Path) -> bool:
    """Return True for a directory with the case or the summary of a finite-element run."""
    tables = read_tables(directory / CASE_FILE) or {}
    summary = read_json(directory / SUMMARY_FILE) or {}
    return not _TABLES.isdisjoint(tables) or _OF_ELEMENTS in summary


RESULT_KINDS = (
    ResultKind(
        CONTINUUM,
        "a run",
        (CONTACT_TABLE,),
        _holds_elements,
        no_run=f"is a continuum run, expected a run of spheres; h5py reads its {RESULT_FILE}",
        remedy="run the case again with resume=True",
        body="block",
        rows="granwave.extensions.continuum.quantities:CONTINUUM_ROWS",
    ),
    ResultKind(FIT, files=FIT_FILES),
)
