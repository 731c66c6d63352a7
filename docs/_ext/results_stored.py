"""The stored results of all suites, ``docs/explanation/results.json``: reading, and the stored form
of studies.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granwave.analysis.document.model import (
    Cell,
    DocumentTable,
    TableColumn,
)
from granwave.analysis.studies.study import Row, Study, record_of

ROOT = Path(__file__).parents[2]
STORED = ROOT / "docs" / "explanation" / "results.json"


def read_stored(path: Path = STORED) -> dict[str, Any]:
    """Read the stored results; without a file, there are none."""
    if not path.is_file():
        return {"suites": {}}
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def as_stored(study: Study) -> dict[str, Any]:
    """Return a study for the JSON file: rows with all digits, and its tables as text."""
    return {
        "title": study.title,
        "text": study.text,
        "verdict": list(study.verdict),
        "rows": [record_of(row) | {"digits": row.digits, "bound": row.bound} for row in study.rows],
        "tables": [
            _table(one) if isinstance(one, DocumentTable) else one.text for one in study.tables
        ],
    }


def row_of(record: Mapping[str, Any]) -> Row:
    """Return a stored row."""
    return Row(
        record["quantity"],
        record["unit"],
        record["source"],
        record["granwave"],
        record["where"],
        record["remark"],
        record["theory"],
        record["kind"] == "verification",
        record["digits"],
        record.get("bound", False),
    )


def _table(table: DocumentTable) -> dict[str, Any]:
    columns = [[column.heading, column.unit, column.numeric] for column in table.columns]
    rows = []
    for row in table.rows:
        rows.append([cell.text for cell in row])
    return {"caption": table.caption, "columns": columns, "rows": rows}


def read_table(stored: Mapping[str, Any]) -> DocumentTable:
    columns = tuple(
        TableColumn(heading, unit, numeric=numeric) for heading, unit, numeric in stored["columns"]
    )
    rows: Sequence[Sequence[str]] = stored["rows"]
    return DocumentTable(stored["caption"], columns, tuple(tuple(map(Cell, row)) for row in rows))
