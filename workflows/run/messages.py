"""Messages of a run: suppression of repeated ones, how long it will take, and the one that says that memory ran out."""

from __future__ import annotations

import logging
from collections.abc import Callable

from granwave.analysis.formatting.numbers import duration
from granwave.lammps_inputs.planning.plan import Plan

_LOG = logging.getLogger("granwave")
_LONG = 60.0  # s of wall time that a run tells before it starts


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


def announce(expected: Plan) -> None:
    """Tell how long a long run will take, and what makes its steps short, before it starts."""
    if expected.slowness:
        _LOG.warning("%s: about %s: %s", expected.name, duration(expected.wall_time), expected.slowness)
    elif expected.wall_time > _LONG:
        _LOG.info("%s: about %s", expected.name, duration(expected.wall_time))
