"""Deferred handling of Ctrl-C and SIGTERM."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable
from typing import Any, Self


class Interrupts:
    """Counter of Ctrl-C and SIGTERM, which do not stop the program within a ``with`` block.

    Parameters
    ----------
    on_signal
        Function called at each signal.
    """

    def __init__(self, on_signal: Callable[[], object] = lambda: None) -> None:
        self.count = 0
        self._on_signal = on_signal
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        with contextlib.suppress(ValueError):  # only the main thread can handle signals
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, *_: object) -> None:
        self.count += 1
        self._on_signal()
