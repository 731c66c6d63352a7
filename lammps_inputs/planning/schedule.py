"""Schedule of a run, in counts of LAMMPS's step counter.

With an automatic timestep (fix gran/timestep of the plugin) a count is a tick, and a step is a
power of two of ticks. A tick is shortened until the end time (or a block, for ``end_time =
"auto"``) is a whole number of intervals of the energy record: the run ends exactly at the requested
time, and its last step is in the record of energies. All records fall on multiples of the longest
step, except snapshots at given times. With a timestep given by the user a count is one step, and
the end time is rounded up by as few steps as possible.
"""

from __future__ import annotations

import dataclasses
import math
from typing import NamedTuple

import numpy as np

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.run import AUTO, AUTO_END_TIME
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import chain_history, line_history
from granwave.lammps_inputs.planning.arrival import expected_arrival
from granwave.lammps_inputs.planning.blocks import block_time
from granwave.lammps_inputs.planning.timestep import (
    TimestepLimit,
    auto_timestep,
    largest_timestep,
    timestep_limits,
)

_TICKS_OF_FIRST = 4  # the timestep can fall to a quarter of what was expected
# and can rise to 8 times the first one: 232 ns in the reference case, with records of walls at this
# interval
_LONGEST_OF_FIRST = 8
_LEDGER_ROWS = 500  # aimed at, of a run with an end time
# the run may end after one block, and a balance over fewer instants is no balance
_LEDGER_ROWS_IN_BLOCK = 250
_AUTO_PROBE_STEPS = 5
# some 0.3 µs in the reference case; LAMMPS evaluates all energies whenever it records anything
_WALL_STEPS = 10
MOST_STEPS = 2e9
# each snapshot evaluates a formula with a term for each of them: 40 s in total
_MOST_UNEVEN_FRAMES = 10_000
_AUTO_FRAME_SPAN = 1e-3  # s, time over which `frames` snapshots are spread if the end is not known
# for run.frames = "auto": fraction of the snapshots until the wave reaches the bottom, and that
# time / expected arrival
_DENSE_PART = 2 / 3
_DENSE_UNTIL = 1.1


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
        Counts between rows of the energy record.
    wall_every
        Counts between rows of the wall forces; the last step of the run has one.
    probe_every
        Counts between rows of the probes.
    frame_every
        Counts between snapshots if they are evenly spaced, else 0.
    frame_steps
        Counts at the snapshots after the first, at 0, if they are not evenly spaced.
    history_every
        Counts between the instants at which a complete chain is recorded; 0: never.
    line_every
        Counts between the instants at which lines of grains are recorded; 0: never.
    first_step, longest_step
        Ticks of the first and the longest timestep; both 1 with a fixed timestep.
    energy_tolerance
        Largest error of the energy balance that the timestep is chosen for / input; 0 with
        a fixed timestep.
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
        """True if the timestep follows the error of the energy balance."""
        return self.energy_tolerance > 0

    @property
    def first_timestep(self) -> float:
        """Fixed timestep of the run, or its first timestep, s."""
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

    def n_frames_until(self, time: float) -> int:
        """Return the number of snapshots until a time, s, including the start."""
        if self.frame_every:
            return min(self.n_frames, 1 + math.floor(time / (self.frame_every * self.timestep)))
        return 1 + sum(step * self.timestep <= time for step in self.frame_steps)


def make_schedule(assembly: Assembly, timestep: float | None = None) -> Schedule:
    """Make the schedule of a run.

    Parameters
    ----------
    timestep
        s; a fixed one, in the place of ``run.timestep``.
    """
    case = assembly.case
    run = case.run
    output = case.output
    in_blocks = isinstance(run.end_time, str)
    # length of a block, or of the run
    duration = block_time(assembly) if isinstance(run.end_time, str) else run.end_time
    rows = _LEDGER_ROWS_IN_BLOCK if in_blocks else _LEDGER_ROWS
    fixed = run.timestep if timestep is None else timestep
    if isinstance(fixed, str):
        units = _automatic(assembly, duration, rows)
        tolerance = run.energy_tolerance
    else:
        check_steps(case.name, duration, fixed)
        units = _equal_steps(duration, fixed, rows)
        tolerance = 0.0
    n_units = units.in_block
    if in_blocks:
        n_units *= max(1, round(AUTO_END_TIME / (units.in_block * units.length)))
    # time over which records are spread, s
    span = _AUTO_FRAME_SPAN if in_blocks else units.length * n_units
    n_steps = round(span / units.length * units.first_steps)
    frame_every, frame_steps = _frames(assembly, units.tick, units.ticks, n_units, n_steps)
    interval = output.probe_interval
    if isinstance(interval, str):
        probe_every = units.between_records(_AUTO_PROBE_STEPS)
    else:
        probe_every = units.ticks_in(interval)
    instants = chain_history(assembly)
    return Schedule(
        timestep=units.tick,
        n_steps=units.ticks * n_units,
        block_steps=units.ticks * units.in_block if in_blocks else 0,
        ledger_every=units.ticks * units.in_ledger,
        wall_every=units.between_records(_WALL_STEPS),
        probe_every=probe_every,
        frame_every=frame_every,
        frame_steps=frame_steps,
        history_every=units.ticks_in(span / instants) if instants else 0,
        line_every=units.ticks_in(span / line_history(assembly)) if case.line else 0,
        first_step=units.ticks // units.first_steps,
        longest_step=units.ticks,
        energy_tolerance=tolerance,
    )


class _Units(NamedTuple):
    """Units of time of a run: the intervals of all records are multiples of a unit.

    Attributes
    ----------
    tick
        Time of a tick, s.
    ticks
        Ticks of a unit.
    first_steps
        First timesteps in a unit.
    in_ledger
        Units between rows of the ledger.
    in_block
        Units of the run or a block.
    """

    tick: float
    ticks: int
    first_steps: int
    in_ledger: int
    in_block: int

    @property
    def length(self) -> float:
        """Length of a unit, s."""
        return self.ticks * self.tick

    def ticks_in(self, time: float) -> int:
        """Return the ticks of the whole units in a time, s, at least one unit."""
        return self.ticks * max(1, round(time / self.length))

    def between_records(self, most: int) -> int:
        """Return the ticks between records that are at most so many first timesteps apart, and
        divide a block.
        """
        numbers = range(1, max(1, most // self.first_steps) + 1)
        return self.ticks * max(number for number in numbers if self.in_block % number == 0)


def _equal_steps(duration: float, timestep: float, rows: int) -> _Units:
    """Return the units of a run of equal timesteps, each of which is a unit.

    Parameters
    ----------
    duration
        Of the run or a block, s.
    timestep
        s.
    rows
        Rows of the energy record in that time, which may become half as many or twice as many so
        that they divide it.
    """
    n = max(1, math.ceil(duration / timestep * (1 - 1e-9)))
    candidates = range(max(1, n // (2 * rows)), max(1, 2 * n // rows) + 1)
    in_ledger = min(candidates, key=lambda every: (-n % every, abs(every - n / rows)))
    return _Units(timestep, 1, 1, in_ledger, n + -n % in_ledger)


def _frames(
    assembly: Assembly, tick: float, unit: int, n_units: int, n_steps: int
) -> tuple[int, tuple[int, ...]]:
    """Return the counts between snapshots if they are evenly spaced; otherwise 0 and the count of
    each snapshot after the first.

    Parameters
    ----------
    tick
        Time of a count, s.
    unit
        Counts that records are multiples of.
    n_units
        Units of the run, or the most that there can be.
    n_steps
        First timesteps over which snapshots are spread.
    """
    run = assembly.case.run
    in_blocks = isinstance(run.end_time, str)
    length = unit * tick
    last = unit * n_units
    dense = _dense_times(assembly)
    gaps = 0 if isinstance(run.frames, tuple) or dense else max(1, assembly.case.n_frames - 1)
    between = n_units // gaps if gaps and assembly.case.n_frames != 1 and n_units % gaps == 0 else 0
    if in_blocks and gaps:
        between = max(1, round(_AUTO_FRAME_SPAN / assembly.case.n_frames / length))
    _check_counts(assembly.case, max(1, n_steps), even=between > 0)
    if between:
        return unit * between, ()
    if isinstance(run.frames, tuple):
        wanted = np.rint(np.array(run.frame_times) / tick)
    elif dense:
        wanted = unit * np.rint(np.array(dense) / length)
    else:
        wanted = unit * np.rint(np.linspace(0, n_units, gaps + 1 if gaps > 1 else 2))
    chosen = np.union1d(np.minimum(wanted, last).astype(np.int64), [last])
    steps = tuple(chosen[chosen > 0].tolist())
    if steps == tuple(range(steps[0], last + 1, steps[0])):
        return steps[0], ()
    return 0, steps


def _dense_times(assembly: Assembly) -> tuple[float, ...]:
    """Return the times of the snapshots of ``run.frames = "auto"``, s, two thirds of them until the
    wave is at the bottom; empty if they are evenly spaced.  They are evenly spaced if the arrival
    is unknown, or if at least two thirds of evenly spaced times are before the arrival.
    """
    run = assembly.case.run
    if run.frames != AUTO:
        return ()
    in_blocks = isinstance(run.end_time, str)
    span = _AUTO_FRAME_SPAN if in_blocks else run.longest
    gaps = assembly.case.n_frames - 1
    dense = round(_DENSE_PART * gaps)
    arrival = expected_arrival(assembly)
    if arrival is None or _DENSE_UNTIL * arrival >= span * dense / gaps:
        return ()
    until = _DENSE_UNTIL * arrival
    sparse = (span - until) / (gaps - dense)
    later = math.floor((run.longest - until) / sparse * (1 + 1e-9))
    before = np.linspace(0.0, until, dense + 1)
    return (*before.tolist(), *(until + sparse * np.arange(1, later + 1)).tolist())


def _automatic(assembly: Assembly, duration: float, rows: int) -> _Units:
    """Find the units of a run with a timestep that follows the error of the energy balance, from
    its longest timesteps.

    Parameters
    ----------
    duration
        Of the run or a block, s.
    rows
        Of the energy record in that time.
    """
    case = assembly.case
    run = case.run
    smallest = 0.0 if isinstance(case.run.smallest_timestep, str) else case.run.smallest_timestep
    first = auto_timestep(assembly, tolerance=run.energy_tolerance)
    limit = largest_timestep(assembly)
    if not isinstance(run.largest_timestep, str):
        limit = min(limit, run.largest_timestep)
        first = min(first, limit)
    first = max(first, min(smallest, limit))
    down = _TICKS_OF_FIRST
    up = _LONGEST_OF_FIRST if math.isfinite(case.load.lasts) else 1
    while down > 1 and first / down < smallest * (1 - 1e-9):
        down //= 2
    while up > 1 and first * up > limit * (1 + 1e-9):
        up //= 2
    first *= min(1.0, duration / rows / first)
    if duration / (first / down) > MOST_STEPS:
        check_steps(
            case.name, duration, first / down, timestep_limits(assembly, run.energy_tolerance)[0]
        )
    # the longest timestep must not exceed the times between records
    longest = min(duration / rows, *_intervals(assembly, first))
    probes = _probe_interval(assembly)
    while up > 1 and (up * first > longest or not _divides(up * first, probes, 0.5 * first)):
        up //= 2
    in_ledger = max(1, math.floor(duration / rows / (up * first) * (1 + 1e-9)))
    n_units = in_ledger * math.ceil(duration / (in_ledger * up * first) * (1 - 1e-9))
    return _Units(duration / (n_units * up * down), up * down, up, in_ledger, n_units)


def _intervals(assembly: Assembly, first: float) -> list[float]:
    """Return the times between records of a run, s, other than those of the energies.

    Parameters
    ----------
    first
        First timestep, s.
    """
    case = assembly.case
    run = case.run
    span = _AUTO_FRAME_SPAN if isinstance(run.end_time, str) else run.longest
    intervals = [_WALL_STEPS * first]
    if not isinstance(run.frames, tuple):
        times = _dense_times(assembly)
        intervals.append(times[1] if times else span / max(1, case.n_frames - 1))
    if case.probes:
        intervals.append(_probe_interval(assembly) or _AUTO_PROBE_STEPS * first)
    if chain_history(assembly):
        intervals.append(span / chain_history(assembly))
    if case.line:
        intervals.append(span / line_history(assembly))
    return intervals


def _probe_interval(assembly: Assembly) -> float | None:
    """Return the interval of probes that a case sets, s; None if it sets none or has no probes."""
    interval = assembly.case.output.probe_interval
    if isinstance(interval, str) or not assembly.case.probes:
        return None
    return interval


def _divides(length: float, interval: float | None, tolerance: float) -> bool:
    """Return True if an interval (s; None: any) is a multiple of a length, to a tolerance."""
    if interval is None:
        return True
    return abs(max(1, round(interval / length)) * length - interval) <= tolerance


def check_steps(
    name: str, duration: float, timestep: float, limit: TimestepLimit | None = None
) -> None:
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
        way = (
            "run.timestep longer"
            if limit is None
            else f"use {limit.remedy}: {limit.cause} limits the timestep"
        )
        raise InputError(
            f"{name}: run.end_time: {duration:g} s in steps of {timestep:g} s are more than "
            f"{MOST_STEPS:g} steps; use a shorter run, or {way}"
        )


def _check_counts(case: Case, n_steps: int, *, even: bool) -> None:
    """Raise InputError for more snapshots, or records of a chain, than possible, before they are
    computed.

    Parameters
    ----------
    n_steps
        Steps over which they are spread.
    even
        True if the snapshots are evenly spaced.
    """
    frames = case.run.frames
    history = case.output.history
    errors = []
    each_step = f"expected at most {n_steps + 1}: one at the start and one per step"
    if isinstance(frames, int) and frames > max(n_steps + 1, case.n_auto_frames):
        errors.append(f"run.frames: found {frames}, {each_step}")
    elif frames != AUTO and case.n_frames > _MOST_UNEVEN_FRAMES and not even:
        errors.append(
            f"run.frames: found {case.n_frames}, expected at most {_MOST_UNEVEN_FRAMES} unless "
            f"they divide the {n_steps} steps evenly; output.probes and output.history record "
            "more often"
        )
    if isinstance(history, int) and history > n_steps + 1:
        errors.append(f"output.history: found {history}, {each_step}")
    if errors:
        raise InputError(f"{case.name}: {fault}" for fault in errors)
