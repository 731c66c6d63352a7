"""Files of small waves about a static state.

Each command writes NAME.csv, NAME.json, and a group in a common file.
"""

from __future__ import annotations

from pathlib import Path

from granwave.lammps_inputs.result_kinds import ResultKind
from granwave.lammps_inputs.run_directory import SUMMARY_FILE

SPECTRA = "spectra"  # kind of results
SPECTRA_FILE = "spectra.h5"
#: Commands of small waves; each writes its values to a file with its name, .json.
SPECTRA_KINDS = ("bands", "modes", "transmission")


def spectra_in(directory: Path) -> list[str]:
    """Return the commands of `SPECTRA_KINDS` whose values are in a directory."""
    return [name for name in SPECTRA_KINDS if (directory / f"{name}.json").is_file()]


def _holds_spectra(directory: Path) -> bool:
    """Return True for a directory of small waves that is not the directory of a run."""
    return bool(spectra_in(directory)) and not (directory / SUMMARY_FILE).exists()


RESULT_KINDS = (
    ResultKind(
        SPECTRA,
        "bands or modes",
        (SPECTRA_FILE, *(f"{name}.json" for name in SPECTRA_KINDS)),
        _holds_spectra,
        loader="granwave.extensions.waves.datasets:load_spectra",
    ),
)
