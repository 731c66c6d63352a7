"""Progress of the static stage: a bar on a terminal, lines in a batch log.

The stage is a few commands of LAMMPS that each take long. A thread reads only the last line of
thermodynamic output: LAMMPS keeps it for other threads.
"""

from __future__ import annotations

import contextlib
import math
import re
import threading
from collections.abc import Iterator, Mapping

from granwave.lammps_inputs.deck.damped_run import LARGEST_OF_ALL, LARGEST_OF_PAIRS, QUIET
from granwave.lammps_inputs.deck.minimisation import MOST_ITERATIONS
from granwave.lammps_inputs.deck.static_stage import NET_FORCE
from granwave.workflows.run.lammps_engine import Engine
from granwave.workflows.run.progress import Progress

_LOOK_EVERY = 0.5  # s
_PARTS = 1000  # steps of the progress bar
_LONG_COMMAND = re.compile(r"^((?:minimize|run) +(?!0 ).*\n)", re.MULTILINE)


class StaticProgress:
    """Progress of the static stage of a case.

    Parameters
    ----------
    engine
        LAMMPS of this rank.
    label
        Text in front of the bar.
    enabled
        False to show nothing.
    """

    def __init__(self, engine: Engine, label: str, *, enabled: bool) -> None:
        self._engine = engine
        self._label = label
        self._enabled = enabled
        self._bar: Progress | None = None
        self._first_ratio = 0.0
        self._share = 0.0

    def commands(self, text: str) -> None:
        """Execute commands, and show the progress of long commands.

        Raises
        ------
        RunError
            LAMMPS fails.
        """
        if not self._enabled:
            return self._engine.commands(text)
        try:
            for part in _LONG_COMMAND.split(text):
                with self._watched() if _LONG_COMMAND.match(part) else contextlib.nullcontext():
                    self._engine.commands(part)
            self._show("the static stage is over", 1.0, last=True)
        finally:
            if self._bar is not None:
                self._bar.close()

    @contextlib.contextmanager
    def _watched(self) -> Iterator[None]:
        """Follow the progress of a command until it ends."""
        over = threading.Event()
        thread = threading.Thread(target=self._look, args=(over,), daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def _look(self, over: threading.Event) -> None:
        """Show the last line of output from time to time."""
        while not over.wait(_LOOK_EVERY):
            values = self._engine.last_thermo()
            if self._bar is None:
                self._bar = Progress(_PARTS, f"{self._label}: static stage", enabled=True)
            self._share = max(self._share, self._share_done(values))
            self._show(note_of(values), self._share)

    def _show(self, note: str, share: float, *, last: bool = False) -> None:
        """Show a note and a fraction, if the stage takes long enough to have a bar."""
        if self._bar is not None:
            self._bar.update(int(_PARTS * share), note, last=last)

    def _share_done(self, values: Mapping[str, float]) -> float:
        """Return the completed fraction, by the decay of net forces, or by the iterations."""
        ratio = net_over_largest(values)
        self._first_ratio = max(self._first_ratio, ratio)
        if ratio > 0 and self._first_ratio > QUIET:
            decades = math.log(self._first_ratio / QUIET)
            return min(math.log(self._first_ratio / ratio) / decades, 1.0 - 1 / _PARTS)
        return min(values.get("Step", 0.0) / MOST_ITERATIONS, 1.0 - 1 / _PARTS)


def net_over_largest(values: Mapping[str, float]) -> float:
    """Return the largest net force on a grain divided by the largest contact force;
    0 if unknown.
    """
    largest = _largest(values) or 0.0
    net = values.get(NET_FORCE, 0.0)
    return net / largest if largest > 0 and net > 0 else 0.0


def _largest(values: Mapping[str, float]) -> float | None:
    """Return the largest force of a contact, N, from the available output."""
    return values.get(LARGEST_OF_ALL, values.get(LARGEST_OF_PAIRS))


def note_of(values: Mapping[str, float]) -> str:
    """Return a line of output in words."""
    words = [f"{values.get('Step', 0.0):.0f} steps"]
    largest = _largest(values)
    if largest is not None:
        words.append(f"largest force {largest:.3g} N")
    ratio = net_over_largest(values)
    if ratio:
        words.append(f"net force {ratio:.1e} of it")
    return ", ".join(words)
