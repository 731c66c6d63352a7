"""Records, objects of one kind with attributes, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from granwave.analysis.measures.signals import Array


def columns(records: Sequence[Any], *names: str) -> list[Array]:
    """Attributes of records as arrays, one for each name: (n_records,)."""
    return [np.array([getattr(record, name) for record in records]) for name in names]
