"""Suppression of repeated log messages."""

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
