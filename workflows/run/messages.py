"""Messages of a run: suppression of repeated ones, and the one that says that memory ran out."""

from __future__ import annotations

import logging
from collections.abc import Callable


def each_warning_once() -> Callable[[logging.LogRecord], bool]:
    """Make a filter for a logger or a handler that suppresses repeated warnings."""
    seen: set[str] = set()

    def fresh(record: logging.LogRecord) -> bool:
        text = record.getMessage()
        known = record.levelno == logging.WARNING and text in seen
        seen.add(text)
        return not known

    return fresh


def not_enough_memory(why: str) -> str:
    """Message that memory ran out."""
    return f"there is not enough memory ({why}); granwave check tells what a case needs"
