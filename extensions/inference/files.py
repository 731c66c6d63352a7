"""Files of inferred contact forces; their summary is in summary.json."""

from __future__ import annotations

from pathlib import Path

from granwave.lammps_inputs.files import read_json
from granwave.lammps_inputs.result_kinds import ResultKind
from granwave.lammps_inputs.run_directory import SUMMARY_FILE

INFERENCE = "inference"  # kind of results, also in the summary
INFERRED_FORCES = "forces.csv"
INFERRED_GRAINS = "grains.csv"
MADE_MEASUREMENT = "measurement.csv"
MADE_CASE = "measurement.toml"


def _holds_inference(directory: Path) -> bool:
    """Return True for a directory with a summary of inferred forces."""
    return (read_json(directory / SUMMARY_FILE) or {}).get("kind") == INFERENCE


RESULT_KINDS = (
    ResultKind(
        INFERENCE,
        "inferred forces",
        (INFERRED_FORCES, INFERRED_GRAINS),
        _holds_inference,
        loader="granwave.extensions.inference.notebook:load_inferred",
    ),
)
