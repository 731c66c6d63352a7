"""Labels of what varies in a scan, for its tables and figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from granwave.analysis.formatting.values import unique_labels
from granwave.analysis.scans.result import Scalar


def labels_of(values: Sequence[Any]) -> list[Scalar]:
    """A key's values at all points as tables and figures show them.

    Parameters
    ----------
    values
        As in a case file: tables become words, different ones for each, since points of equal labels are taken for one.
    """
    return [
        value if isinstance(value, bool | int | float | str) else words
        for value, words in zip(values, unique_labels(values), strict=True)
    ]
