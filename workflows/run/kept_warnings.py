"""Warnings that the record of a run keeps, so that reports repeat them."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterable, Iterator

_LOGGER = "granwave"  # parent of all loggers of granwave


class _Keeper(logging.Handler):
    """Handler that adds the warnings about a case to a list, each once and without its name."""

    def __init__(self, names: Iterable[str], kept: list[str]) -> None:
        super().__init__(logging.WARNING)
        self.starts = [f"{name}: " for name in names]
        self.kept = kept

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        start = next(filter(text.startswith, self.starts), None)
        if record.levelno != logging.WARNING or start is None:
            return
        text = text.removeprefix(start)
        if text not in self.kept:
            self.kept.append(text)


@contextlib.contextmanager
def keeping_warnings(names: Iterable[str], kept: list[str]) -> Iterator[None]:
    """Add the warnings about a case that are logged within a ``with`` block to a list.

    Parameters
    ----------
    names
        Name of the case, and its label with the directory: its warnings begin with either.
    """
    logger = logging.getLogger(_LOGGER)
    keeper = _Keeper(names, kept)
    logger.addHandler(keeper)
    try:
        yield
    finally:
        logger.removeHandler(keeper)
