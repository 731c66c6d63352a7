"""Schedule of a run in whole timesteps.

An automatic timestep is shortened until the end time (or a block, for ``end_time = "auto"``) is a whole number of
ledger intervals: the run ends exactly at the end time, and its last step is in the ledger. A timestep given by the user
is kept, and the end time is rounded up by as few steps as possible.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from granwave.lammps_inputs.case.sections import AUTO_END_TIME, DEFAULT_FRAMES
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.planning.timestep import auto_timestep

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case

BLOCK_TIME = 50e-6  # s, length of a block of end_time = "auto"
BLOCK_THRESHOLD = 1e-4  # dissipation over energy input; a block that dissipates less is the last
_LEDGER_ROWS = 500  # target for a run with an end time
_LEDGER_ROWS_IN_BLOCK = 250  # target for a block: the run may end after the first, and the balance needs enough rows
_AUTO_PROBE_STEPS = 5
_WALL_STEPS = 10  # some 0.3 us in the reference case; LAMMPS evaluates all energies whenever it records anything
MOST_STEPS = 2e9
_MOST_UNEVEN_FRAMES = 10_000  # each snapshot evaluates a formula with a term for each of them: 40 s in total
_AUTO_FRAME_SPAN = 1e-3  # s, time over which `frames` snapshots are spread if the end is not known


@dataclasses.dataclass(frozen=True)
class Schedule:
    """Timestep, number of steps, and output intervals in steps.

    Attributes
    ----------
    timestep
        Timestep, s.
    n_steps
        Steps of the run; with ``block_steps`` the largest possible number.
    block_steps
        Steps of a block of ``end_time = "auto"``; 0 if the run has an end time.
    ledger_every
        Steps between rows of the energy ledger.
    wall_every
        Steps between rows of the wall forces; the last step of the run has one.
    probe_every
        Steps between rows of the probes.
    frame_every
        Steps between snapshots if they are evenly spaced, else 0.
    frame_steps
        Steps of the snapshots after the first, at step 0, if they are not evenly spaced.
    history_every
        Steps between records of the history of a chain; 0: none.
    """

    timestep: float
    n_steps: int
    block_steps: int
    ledger_every: int
    wall_every: int
    probe_every: int
    frame_every: int
    frame_steps: tuple[int, ...] = ()
    history_every: int = 0

    @property
    def end_time(self) -> float:
        """Time of the last step, s."""
        return self.n_steps * self.timestep

    @property
    def n_frames(self) -> int:
        """Number of snapshots of a run that reaches its last step, including the start."""
        return 1 + (len(self.frame_steps) or math.ceil(self.n_steps / self.frame_every))


def make_schedule(case: Case | Assembly, timestep: float | None = None) -> Schedule:
    """Make the schedule of a case.

    Parameters
    ----------
    timestep
        Timestep in place of ``run.timestep``, s.
    """
    assembly = assemble(case)
    case = assembly.case
    given = timestep if timestep is not None else case.run.timestep
    if isinstance(case.run.end_time, str):
        return _in_blocks(assembly, given)
    dt, n_steps, ledger_every = _fit(assembly, given, case.run.end_time, _LEDGER_ROWS)
    even = _even_frames(case, n_steps)
    _check_counts(case, n_steps, even=even > 0)
    steps = () if even else _frame_steps(case, dt, n_steps)
    if steps and steps == tuple(range(steps[0], n_steps + 1, steps[0])):
        even, steps = steps[0], ()
    return Schedule(
        timestep=dt,
        n_steps=n_steps,
        block_steps=0,
        ledger_every=ledger_every,
        wall_every=_divisor(n_steps, _WALL_STEPS),
        probe_every=_probe_every(case, dt, n_steps),
        frame_every=even,
        frame_steps=steps,
        history_every=_history_every(assembly, n_steps),
    )


def check_steps(name: str, duration: float, timestep: float) -> None:
    """Raise InputError if a run has more steps than `MOST_STEPS`.

    Raises
    ------
    InputError
        ``duration`` (s) takes more than `MOST_STEPS` of ``timestep`` (s).
    """
    if not duration / timestep <= MOST_STEPS:
        raise InputError(
            f"{name}: run.end_time: {duration:g} s in steps of {timestep:g} s are more than {MOST_STEPS:g} steps; "
            "make the run shorter, or run.timestep longer"
        )


def _in_blocks(assembly: Assembly, given: float | str) -> Schedule:
    case = assembly.case
    dt, block_steps, ledger_every = _fit(assembly, given, BLOCK_TIME, _LEDGER_ROWS_IN_BLOCK)
    n_steps = block_steps * max(1, round(AUTO_END_TIME / (block_steps * dt)))
    frames = case.run.frames
    listed = isinstance(frames, tuple)
    _check_counts(case, round(_AUTO_FRAME_SPAN / dt), even=not listed)
    every = 0 if isinstance(frames, tuple) else max(1, round(_AUTO_FRAME_SPAN / frames / dt))
    return Schedule(
        timestep=dt,
        n_steps=n_steps,
        block_steps=block_steps,
        ledger_every=ledger_every,
        wall_every=_divisor(block_steps, _WALL_STEPS),
        probe_every=_probe_every(case, dt, block_steps),
        frame_every=every,
        frame_steps=_frame_steps(case, dt, n_steps) if listed else (),
        history_every=_history_every(assembly, round(_AUTO_FRAME_SPAN / dt)),
    )


def _fit(assembly: Assembly, given: float | str, duration: float, rows: int) -> tuple[float, int, int]:
    """Return the timestep, the steps in ``duration``, and the steps between about ``rows`` rows of the ledger."""
    case = assembly.case
    step = auto_timestep(assembly) if isinstance(given, str) else given
    check_steps(case.name, duration, step)
    if isinstance(given, str):
        ledger_every = max(1, math.ceil(duration / step / rows * (1 - 1e-9)))
        return duration / (ledger_every * rows), ledger_every * rows, ledger_every
    n_steps = max(1, math.ceil(duration / given * (1 - 1e-9)))
    candidates = range(max(1, n_steps // (2 * rows)), max(1, 2 * n_steps // rows) + 1)
    ledger_every = min(candidates, key=lambda every: (-n_steps % every, abs(every - n_steps / rows)))
    return given, n_steps + -n_steps % ledger_every, ledger_every


def _divisor(n_steps: int, most: int) -> int:
    """Return the largest divisor of ``n_steps`` up to ``most``."""
    return max(every for every in range(1, most + 1) if n_steps % every == 0)


def _history_every(assembly: Assembly, n_steps: int) -> int:
    return max(1, round(n_steps / assembly.history)) if assembly.history else 0


def _probe_every(case: Case, dt: float, n_steps: int) -> int:
    interval = case.output.probe_interval
    if isinstance(interval, str):
        return _divisor(n_steps, _AUTO_PROBE_STEPS)
    return max(1, round(interval / dt))


def _check_counts(case: Case, n_steps: int, *, even: bool) -> None:
    """Raise InputError for more snapshots, or records of a chain, than possible, before they are computed.

    Parameters
    ----------
    n_steps
        Steps over which they are spread.
    even
        True if the snapshots are evenly spaced.
    """
    frames, history = case.run.frames, case.output.history
    count, errors = frames if isinstance(frames, int) else len(frames), []
    each_step = f"expected at most {n_steps + 1}: one at the start, one a step"
    if isinstance(frames, int) and frames > max(n_steps + 1, DEFAULT_FRAMES):
        errors.append(f"run.frames: found {frames}, {each_step}")
    elif count > _MOST_UNEVEN_FRAMES and not even:
        errors.append(
            f"run.frames: found {count}, expected at most {_MOST_UNEVEN_FRAMES} where they do not divide the {n_steps} "
            "steps evenly; output.probes and output.history record more often"
        )
    if isinstance(history, int) and history > n_steps + 1:
        errors.append(f"output.history: found {history}, {each_step}")
    if errors:
        raise InputError(f"{case.name}: {fault}" for fault in errors)


def _even_frames(case: Case, n_steps: int) -> int:
    """Return the steps between snapshots if they divide the run into equal parts, else 0."""
    frames = case.run.frames
    if not isinstance(frames, int) or frames < 2 or n_steps % (frames - 1):
        return 0
    return n_steps // (frames - 1)


def _frame_steps(case: Case, dt: float, n_steps: int) -> tuple[int, ...]:
    """Return the steps of the snapshots after step 0; the last step is always included."""
    if isinstance(case.run.frames, tuple):
        wanted = np.rint(np.array(case.run.frames) / dt)
    else:
        wanted = np.rint(np.linspace(0, n_steps, max(2, case.run.frames)))
    steps = np.union1d(np.minimum(wanted, n_steps).astype(np.int64), [n_steps])
    return tuple(int(step) for step in steps if step > 0)
