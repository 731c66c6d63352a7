"""Ctrl-C, SIGTERM and the end of the terminal, which are postponed or counted instead of stopping
the program at once.
"""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable, Iterator
from typing import Any, Self


def stop_signals() -> list[signal.Signals]:
    """Return the signals that ask a program to stop: Ctrl-C, SIGTERM, and SIGHUP, of a terminal
    that is closed, unless nohup ignores it.
    """
    hangs_up = signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN
    return [signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hangs_up else [])]


class Interrupts:
    """Ctrl-C, SIGTERM and SIGHUP, which do not stop the program within a ``with`` block.

    Parameters
    ----------
    on_signal
        Function called at each signal.
    """

    def __init__(self, on_signal: Callable[[], object] = lambda: None) -> None:
        self.numbers: list[int] = []  # numbers of the received signals
        self._on_signal = on_signal
        self._before: dict[int, Any] = {}

    @property
    def count(self) -> int:
        """Number of received signals."""
        return len(self.numbers)

    def __enter__(self) -> Self:
        with contextlib.suppress(ValueError):  # only the main thread can handle signals
            for number in stop_signals():
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, number: int, _: object) -> None:
        self.numbers.append(number)
        self._on_signal()


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Let Ctrl-C and SIGTERM wait for the end of the block."""
    waiting = Interrupts()
    try:
        with waiting:
            yield
    finally:
        for number in waiting.numbers[:1]:
            signal.raise_signal(number)
