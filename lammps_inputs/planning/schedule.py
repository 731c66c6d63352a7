"""Schedule of a run, in counts of LAMMPS's step counter.

With an automatic timestep (fix gran/timestep of the plugin) a count is a tick, and a step is a power of two of them. A
tick is shortened until the end time (or a block, for ``end_time = "auto"``) is a whole number of ledger intervals: the
run ends exactly when asked, and its last step is in the ledger. All that is recorded falls on multiples of the longest
step, but for snapshots at given times. With a timestep given by the user a count is that step, and the end time is
rounded up by as few steps as possible.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import AUTO_END_TIME, DEFAULT_FRAMES, FRAMES_OF_A_FILM
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.motion import chain_history, line_history
from granwave.lammps_inputs.planning.timestep import Limit, auto_timestep, largest_timestep, timestep_limits

BLOCK_TIME = 50e-6  # s, of end_time = "auto"
BLOCK_THRESHOLD = 1e-4  # of the input energy: a block that dissipates less is the last
_TICKS_OF_FIRST = 4  # the timestep can fall to a quarter of what was expected
_LONGEST_OF_FIRST = 8  # and rise to 8 times as much: 232 ns of the reference, whose walls are recorded as often
_LEDGER_ROWS = 500  # aimed at, of a run with an end time
_LEDGER_ROWS_IN_BLOCK = 250  # the run may end after one block, and a balance over fewer instants is no balance
_AUTO_PROBE_STEPS = 5
_WALL_STEPS = 10  # some 0.3 us in the reference case; LAMMPS evaluates all energies whenever it records anything
MOST_STEPS = 2e9
_MOST_UNEVEN_FRAMES = 10_000  # each snapshot evaluates a formula with a term for each of them: 40 s in total
_AUTO_FRAME_SPAN = 1e-3  # s, time over which `frames` snapshots are spread if the end is not known


@dataclasses.dataclass(frozen=True)
class Schedule:
    """A run in counts of the step counter: timesteps, or ticks of an automatic timestep.

    Attributes
    ----------
    timestep
        Time of a count, s.
    n_steps
        Counts of the run; with ``block_steps`` the most there can be.
    block_steps
        Counts of a block of ``end_time = "auto"``; 0 if the run has an end time.
    ledger_every
        Counts between rows of the energy ledger.
    wall_every
        Counts between rows of the wall forces; the last step of the run has one.
    probe_every
        Counts between rows of the probes.
    frame_every
        Counts between snapshots if they are evenly spaced, else 0.
    frame_steps
        Counts at the snapshots after the first, at 0, if they are not evenly spaced.
    history_every
        Counts between the instants at which a whole chain is recorded; 0: never.
    line_every
        Counts between the instants at which lines of grains are recorded; 0: never.
    first_step, longest_step
        Ticks of the first and the longest timestep; both 1 with a fixed timestep.
    energy_tolerance
        Largest error of the energy balance that the timestep is chosen for, over the input; 0 with a fixed timestep.
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
    line_every: int = 0
    first_step: int = 1
    longest_step: int = 1
    energy_tolerance: float = 0.0

    @property
    def adaptive(self) -> bool:
        """The timestep follows the error of the energy balance."""
        return self.energy_tolerance > 0

    @property
    def first_timestep(self) -> float:
        """The timestep of the run, or the first one, s."""
        return self.first_step * self.timestep

    @property
    def largest_timestep(self) -> float:
        """The largest timestep that the run can take, s."""
        return self.longest_step * self.timestep

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
        s; a fixed one, in the place of ``run.timestep``.
    """
    assembly = assemble(case)
    case = assembly.case
    steps = _steps_of(assembly, timestep)
    span, blocks = _span(case, steps.unit * steps.tick * steps.n_units), isinstance(case.run.end_time, str)
    even = not isinstance(case.run.frames, tuple) if blocks else _even_frames(case, steps) > 0
    _check_counts(case, max(1, round(span * steps.per_first / (steps.unit * steps.tick))), even=even)
    frame_every, frame_steps = _frames(case, steps)
    interval, instants = case.output.probe_interval, chain_history(assembly)
    probe = steps.records(_AUTO_PROBE_STEPS) if isinstance(interval, str) else steps.units(interval)
    return Schedule(
        timestep=steps.tick,
        n_steps=steps.unit * steps.n_units,
        block_steps=steps.unit * steps.in_block if blocks else 0,
        ledger_every=steps.unit * steps.in_ledger,
        wall_every=steps.unit * steps.records(_WALL_STEPS),
        probe_every=steps.unit * probe,
        frame_every=frame_every,
        frame_steps=frame_steps,
        history_every=steps.unit * steps.units(span / instants) if instants else 0,
        line_every=steps.unit * steps.units(span / line_history(assembly)) if case.line else 0,
        first_step=steps.unit // steps.per_first,
        longest_step=steps.unit,
        energy_tolerance=case.run.energy_tolerance if steps.adaptive else 0.0,
    )


def _span(case: Case, end: float) -> float:
    """Return the time over which records are spread: up to the end, or a typical one if that is not known, s."""
    return _AUTO_FRAME_SPAN if isinstance(case.run.end_time, str) else end


class _Steps(NamedTuple):
    """Units that a run is made of: the timestep, or the longest one, whose multiples all records are."""

    tick: float  # time of a count of the step counter, s
    unit: int  # counts of a unit
    per_first: int  # first timesteps in a unit
    in_ledger: int  # units between rows of the ledger
    in_block: int  # units of a block, or of the run, if it has an end time
    n_units: int  # units of the run
    adaptive: bool

    def units(self, time: float) -> int:
        """Units of a time, one or more."""
        return max(1, round(time / (self.unit * self.tick)))

    def records(self, most: int) -> int:
        """Units between records that are at most so many first timesteps apart, and divide a block."""
        units = range(1, max(1, most // self.per_first) + 1)
        return max(every for every in units if self.in_block % every == 0)


def _steps_of(assembly: Assembly, given: float | None) -> _Steps:
    """Find the units of a run.

    Parameters
    ----------
    given
        s; a fixed timestep, in the place of ``run.timestep``.
    """
    case = assembly.case
    run = case.run
    in_blocks = isinstance(run.end_time, str)
    duration = BLOCK_TIME if isinstance(run.end_time, str) else run.end_time
    rows = _LEDGER_ROWS_IN_BLOCK if in_blocks else _LEDGER_ROWS
    fixed = run.timestep if given is None else given
    if not isinstance(fixed, str):
        check_steps(case.name, duration, fixed)
        n_steps = max(1, math.ceil(duration / fixed * (1 - 1e-9)))
        candidates = range(max(1, n_steps // (2 * rows)), max(1, 2 * n_steps // rows) + 1)
        every = min(candidates, key=lambda every: (-n_steps % every, abs(every - n_steps / rows)))
        n_steps += -n_steps % every
        n_blocks = max(1, round(AUTO_END_TIME / (n_steps * fixed))) if in_blocks else 1
        return _Steps(fixed, 1, 1, every, n_steps, n_steps * n_blocks, adaptive=False)
    bounds = _bounds(assembly)
    first, shortest, longest = (step * min(1.0, duration / rows / bounds[0]) for step in bounds)
    if duration / shortest > MOST_STEPS:
        check_steps(case.name, duration, shortest, timestep_limits(assembly, run.energy_tolerance)[0])
    per_first = round(longest / first)
    bound = min(duration / rows, _WALL_STEPS * first, *_intervals(assembly, first))
    interval = case.output.probe_interval if case.probes else "auto"

    def fits(length: float) -> bool:  # a given interval of probes is a multiple of it, to half a first timestep
        if isinstance(interval, str):
            return True
        return abs(max(1, round(interval / length)) * length - interval) <= 0.5 * first

    while per_first > 1 and not (per_first * first <= bound and fits(per_first * first)):
        per_first //= 2
    unit = per_first * round(first / shortest)
    in_ledger = max(1, math.floor(duration / rows / (per_first * first) * (1 + 1e-9)))
    n_rows = math.ceil(duration / (in_ledger * per_first * first) * (1 - 1e-9))
    n_units = in_ledger * n_rows
    n_blocks = round(AUTO_END_TIME / BLOCK_TIME) if in_blocks else 1
    return _Steps(duration / (n_units * unit), unit, per_first, in_ledger, n_units, n_units * n_blocks, adaptive=True)


def _bounds(assembly: Assembly) -> tuple[float, float, float]:
    """First, shortest and longest automatic timestep, s, each a power of two times the next shorter one."""
    run = assembly.case.run
    first = auto_timestep(assembly, tolerance=run.energy_tolerance)
    limit = largest_timestep(assembly)
    if not isinstance(run.largest_timestep, str):
        limit = min(limit, run.largest_timestep)
        first = min(first, limit)
    if not isinstance(run.smallest_timestep, str):
        first = max(first, min(run.smallest_timestep, limit))
    down, up = _TICKS_OF_FIRST, _LONGEST_OF_FIRST if math.isfinite(assembly.case.load.lasts) else 1
    while not isinstance(run.smallest_timestep, str) and down > 1 and first / down < run.smallest_timestep * (1 - 1e-9):
        down //= 2
    while up > 1 and first * up > limit * (1 + 1e-9):
        up //= 2
    return first, first / down, first * up


def _intervals(assembly: Assembly, first: float) -> list[float]:
    """Times between snapshots and records of probes and a chain, which the longest timestep must not exceed, s."""
    case, found = assembly.case, [math.inf]
    span = _span(case, case.run.longest)
    if isinstance(case.run.frames, int):
        found.append(span / max(1, case.run.frames - 1))
    if case.probes:
        interval = case.output.probe_interval
        found.append(_AUTO_PROBE_STEPS * first if isinstance(interval, str) else interval)
    if chain_history(assembly):
        found.append(span / chain_history(assembly))
    if case.line:
        found.append(span / line_history(assembly))
    return found


def check_steps(name: str, duration: float, timestep: float, limit: Limit | None = None) -> None:
    """Raise InputError if a run has more steps than `MOST_STEPS`.

    Parameters
    ----------
    limit
        Bound that sets an automatic timestep.

    Raises
    ------
    InputError
        ``duration`` (s) takes more than `MOST_STEPS` of ``timestep`` (s).
    """
    if not duration / timestep <= MOST_STEPS:
        way = "run.timestep longer" if limit is None else f"take {limit.remedy}: {limit.cause} sets the steps"
        raise InputError(
            f"{name}: run.end_time: {duration:g} s in steps of {timestep:g} s are more than {MOST_STEPS:g} steps; "
            f"make the run shorter, or {way}"
        )


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
    default = DEFAULT_FRAMES if case.figures.film == "none" else FRAMES_OF_A_FILM
    if isinstance(frames, int) and frames > max(n_steps + 1, default):
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


def _even_frames(case: Case, steps: _Steps) -> int:
    """Units between snapshots where their number divides the run into equal parts; else 0."""
    frames = case.run.frames
    if not isinstance(frames, int) or frames < 2 or steps.n_units % (frames - 1):
        return 0
    return steps.n_units // (frames - 1)


def _frames(case: Case, steps: _Steps) -> tuple[int, tuple[int, ...]]:
    """Counts between snapshots if they are evenly spaced; else 0, and the counts of those after the first."""
    frames, n_steps = case.run.frames, steps.unit * steps.n_units
    if isinstance(frames, tuple):
        wanted = np.rint(np.array(case.run.frame_times) / steps.tick)
    elif isinstance(case.run.end_time, str):
        return steps.unit * steps.units(_AUTO_FRAME_SPAN / frames), ()
    elif even := _even_frames(case, steps):
        return steps.unit * even, ()
    else:
        wanted = steps.unit * np.rint(np.linspace(0, steps.n_units, max(2, frames)))
    chosen = np.union1d(np.minimum(wanted, n_steps).astype(np.int64), [n_steps])
    found = tuple(int(step) for step in chosen if step > 0)
    if found == tuple(range(found[0], n_steps + 1, found[0])):
        return found[0], ()
    return 0, found
