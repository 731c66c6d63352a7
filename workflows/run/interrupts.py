"""Ctrl-C and SIGTERM as something to ask about between pieces of work."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Callable
from typing import Any, Self


class Interrupts:
    """Ctrl-C and SIGTERM, counted instead of obeyed within a ``with`` block; ``heard`` is called at each."""

    def __init__(self, heard: Callable[[], object] = lambda: None) -> None:
        self.count = 0
        self._heard = heard
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Self:
        with contextlib.suppress(ValueError):  # of another thread than the main one nobody asks anything
            for number in (signal.SIGINT, signal.SIGTERM):
                self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _note(self, *_: object) -> None:
        self.count += 1
        self._heard()
