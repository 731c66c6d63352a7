"""Standard output and standard error, which daemons and programs without a console lack."""

from __future__ import annotations

import contextlib
import sys
from typing import Any


def is_terminal(stream: Any) -> bool:
    """Return True if a stream is a terminal; False if it is None, closed, or unknown."""
    try:
        return bool(stream.isatty())
    except (AttributeError, ValueError):
        return False


def flush() -> None:
    """Flush standard output and standard error, if they exist."""
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(AttributeError, OSError, ValueError):
            stream.flush()
