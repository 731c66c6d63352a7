"""Files of a search for a design; its runs are in ``points``, as in a scan."""

from __future__ import annotations

import os
from pathlib import Path

from granwave.lammps_inputs.result_kinds import ResultKind

DESIGN = "design"  # kind of results
DESIGN_STUDY = "study.json"
DESIGN_TABLE = "designs.csv"
DESIGN_OUTCOME = "design.json"
BEST_DESIGNS = tuple(f"best-{n}.toml" for n in range(1, 11))


def has_outcome(directory: Path) -> bool:
    """Return True for a search with an outcome; False if its file cannot be read."""
    return os.access(directory / DESIGN_OUTCOME, os.R_OK)


RESULT_KINDS = (
    ResultKind(
        DESIGN,
        "a search for a design",
        (DESIGN_STUDY, DESIGN_TABLE, DESIGN_OUTCOME),
        has_outcome,
        loader="granwave.extensions.design.notebook:load_designs",
    ),
)
