"""Output for programs: one JSON document on standard output, and nothing else there."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.files import plain


def print_json(values: Any) -> None:
    """Print a document; NaN and infinity become null."""
    print(json.dumps(plain(values), indent=2, allow_nan=False, default=_as_text))
    sys.stdout.flush()


def _as_text(value: Any) -> str:
    """Return a path as text."""
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} has no JSON form")
