"""Table of labelled rows."""

from __future__ import annotations

from granwave.analysis.summary_table import lines
from granwave.workflows.check_part import Rows

GIB = 2**30  # bytes


def table(rows: Rows) -> str:
    """Return a table of the rows that have a text."""
    return lines([(label, text) for label, text in rows if text])
