"""Log messages that are given once."""

from __future__ import annotations

import logging
from collections.abc import Callable


def each_warning_once() -> Callable[[logging.LogRecord], bool]:
    """A filter, for a logger or a handler, that holds back warnings it has let through before."""
    seen: set[str] = set()

    def fresh(record: logging.LogRecord) -> bool:
        text = record.getMessage()
        known = record.levelno == logging.WARNING and text in seen
        seen.add(text)
        return not known

    return fresh
