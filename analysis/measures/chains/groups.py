"""Records, objects of one kind with attributes, as arrays and in groups."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from granwave.analysis.measures.signals import Array


def columns(records: Sequence[Any], *names: str) -> list[Array]:
    """Attributes of records as arrays, one for each name: (n_records,)."""
    return [np.array([getattr(record, name) for record in records]) for name in names]


def clustered(records: Iterable[Any], key: str, share: float) -> list[list[Any]]:
    """Records together whose values of an attribute differ by less than a share, in its rising order."""
    groups: list[list[Any]] = []
    for record in sorted(records, key=lambda record: float(getattr(record, key))):
        if not groups or getattr(record, key) > (1 + share) * getattr(groups[-1][0], key):
            groups.append([])
        groups[-1].append(record)
    return groups
