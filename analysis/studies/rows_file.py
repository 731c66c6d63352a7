"""Rows of studies as records, and as a CSV file beside the report of a scan or suite."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.studies.study import Row, Study
from granwave.lammps_inputs.files import replace_text, write_csv_rows
from granwave.lammps_inputs.ownership import claim, clear
from granwave.lammps_inputs.run_directory import STUDY_ROWS


def record_of(row: Row) -> dict[str, Any]:
    """Return a row by name of the column; None where a value is missing."""
    return {
        "kind": row.kind,
        "quantity": row.quantity,
        "unit": row.unit,
        "source": row.source,
        "granwave": row.ours,
        "difference": row.deviation,
        "theory": row.theory,
        "where": row.where,
        "remark": row.remark,
    }


def write_rows(found: Sequence[Study], directory: Path) -> Path | None:
    """Write the rows of all studies into ``study_rows.csv``; None, and no file, if there are none.

    Raises
    ------
    InputError
        A file of this name exists, and granwave did not write it.
    """
    records = [{"study": study.name} | record_of(row) for study in found for row in study.rows]
    if not records:
        clear(directory, [STUDY_ROWS])
        return None
    text = io.StringIO()
    write_csv_rows(text, [list(records[0]), *(record.values() for record in records)])
    claim(directory, [STUDY_ROWS])
    replace_text(directory / STUDY_ROWS, text.getvalue())
    return directory / STUDY_ROWS
