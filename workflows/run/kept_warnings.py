"""Warnings that the record of a run keeps, so that reports repeat them."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator

_LOGGER = "granwave"  # parent of all loggers of granwave


class _Keeper(logging.Handler):
    """Handler that adds the warnings about a case to a list, each once and without its name."""

    def __init__(self, name: str, kept: list[str]) -> None:
        super().__init__(logging.WARNING)
        self.start = f"{name}: "
        self.kept = kept

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.levelno != logging.WARNING or not text.startswith(self.start):
            return
        text = text.removeprefix(self.start)
        if text not in self.kept:
            self.kept.append(text)


@contextlib.contextmanager
def keeping_warnings(name: str, kept: list[str]) -> Iterator[None]:
    """Add the warnings about a case that are logged within a ``with`` block to a list.

    Parameters
    ----------
    name
        Name of the case, with which its warnings begin.
    """
    logger = logging.getLogger(_LOGGER)
    keeper = _Keeper(name, kept)
    logger.addHandler(keeper)
    try:
        yield
    finally:
        logger.removeHandler(keeper)
