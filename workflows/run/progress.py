"""Messages during a run: a bar on a terminal or in a notebook, lines in a batch log, warnings
once.
"""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable

from granwave.analysis.formatting.numbers import duration
from granwave.analysis.progress_bar import in_notebook, progress_bar
from granwave.lammps_inputs.planning.plan import Plan
from granwave.lammps_inputs.streams import is_terminal

_LOG = logging.getLogger("granwave")
_LONG = 60.0  # s of expected wall time above which a run reports it before it starts


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
    return f"not enough memory ({why}); granwave check shows the memory required by a case"


def announce(expected: Plan, label: str) -> None:
    """Announce the expected duration of a long run, and the reason for its short steps, before it
    starts.

    Parameters
    ----------
    label
        Name of the run in messages.
    """
    if expected.slowness:
        _LOG.warning("%s: about %s: %s", label, duration(expected.wall_time), expected.slowness)
    elif expected.wall_time > _LONG:
        _LOG.info("%s: about %s", label, duration(expected.wall_time))


_LINE_EVERY = 30.0  # s between lines of a batch log


class Progress:
    """Progress display with steps and a note; silent unless enabled (other ranks, library use).

    Parameters
    ----------
    total
        Total number of steps.
    label
        Text in front of the bar.
    enabled
        False to show nothing.
    done
        Steps that are done at the start.
    at_most
        True if there may be fewer steps than ``total``.
    """

    def __init__(
        self, total: int, label: str, *, enabled: bool, done: int = 0, at_most: bool = False
    ) -> None:
        shows_bar = enabled and (is_terminal(sys.stderr) or in_notebook())
        self._lines = enabled and not shows_bar
        self._total = total
        self._label = label
        self._done = done
        self._about = "at most" if at_most else "about"
        self._begin = self._last = time.monotonic()
        self._first = done
        self._bar = progress_bar(
            shows_bar,
            total=total,
            initial=done,
            desc=label,
            leave=True,
            miniters=0,  # the note also changes between steps
            bar_format="{desc} {percentage:3.0f}%|{bar}|{postfix}",
        )

    def update(self, done: int, note: str, times: str | None = None, *, last: bool = False) -> None:
        """Update the display.

        Parameters
        ----------
        done
            Steps done so far.
        note
            Description of the state.
        times
            Elapsed and remaining time; by default extrapolated from the steps.
        last
            True if the run has ended, possibly before ``total``.
        """
        if last and done != self._total:
            self._bar.reset(total=done)  # a widget has a copy of the total
            self._total = done
            self._done = 0
        now = time.monotonic()
        if times is None:
            passed = now - self._begin
            left = passed * (self._total - done) / max(1, done - self._first)
            times = duration(passed) + (
                f", {self._about} {duration(left)} left" if done < self._total else ""
            )
        text = f"{note} [{times}]".lstrip()
        self._bar.set_postfix_str(text, refresh=False)
        self._bar.update(done - self._done)
        ended = done == self._total and (last or done != self._done)
        self._done = done
        if self._lines and (now - self._last > _LINE_EVERY or ended):
            self._last = now
            _LOG.info("%s %3.0f %% %s", self._label, 100 * done / self._total, text)

    def close(self) -> None:
        """Close the bar."""
        self._bar.close()
