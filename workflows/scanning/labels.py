"""Labels of the varied values of a scan, for tables and figures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from granwave.analysis.formatting.values import unique_labels
from granwave.analysis.scans.result import Scalar


def labels_of(values: Sequence[Any]) -> list[Scalar]:
    """Return the labels of the values of a key at all points.

    Parameters
    ----------
    values
        Values as in a case file; tables get unique text labels, since points of equal labels count as one.
    """
    return [
        value if isinstance(value, bool | int | float | str) else words
        for value, words in zip(values, unique_labels(values), strict=True)
    ]
