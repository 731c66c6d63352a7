"""Rows and pictures of scripts of the reproductions, from runs of tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import granwave as gw
from granwave.analysis.studies.study import Row, Study, make_studies

FOLDER = Path(__file__).parents[3] / "reproductions"


def study_of(script: str, runs: Sequence[gw.Run]) -> Study:
    """Make the study of a script, such as ``thesis/chapter_4/pulses.py``."""
    (study,) = make_studies({str(FOLDER / script): runs})
    assert not study.failed, study.failed
    return study


def row(study: Study, start: str) -> Row:
    """Return the row whose quantity begins with a text."""
    (found,) = [row for row in study.rows if row.quantity.startswith(start)]
    return found


def columns(study: Study) -> dict[str, Any]:
    """Return the data of the only picture."""
    (picture,) = study.pictures
    return dict(picture.drawing.columns)
