"""Checks of times: end, timestep, frames, histories and probes of a run."""

from __future__ import annotations

import math

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.loads.driven import DrivenLoad
from granwave.lammps_inputs.case.run import RunSettings
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import Mismatch

_STEPS_IN_A_PERIOD = 10  # at least
_BOUNDS_OF_TIMESTEP = ("smallest_timestep", "largest_timestep", "energy_tolerance")


def check_times(case: Case, errors: ErrorList) -> None:
    """Check times against the end of the run, and the bounds of an automatic
    timestep.
    """
    run = case.run
    end = run.longest
    ends = f"run.end_time, {run.longest:g} s"
    step = 0.0 if isinstance(run.timestep, str) else run.timestep
    last = run.frame_times[-1] if run.frame_times else 0.0
    in_shares = isinstance(run.frames, tuple) and isinstance(run.frames[0], str)
    no_end = in_shares and isinstance(run.end_time, str)
    bounds = {}
    for name in _BOUNDS_OF_TIMESTEP:
        value = getattr(run, name)
        if value != getattr(RunSettings, name):
            bounds[name] = value
    least = bounds.get("smallest_timestep", 0.0)
    most = bounds.get("largest_timestep", math.inf)
    errors.check(
        (step > end, "run.timestep", Mismatch(f"{step:g} s", f"at most {ends}")),
        (
            least > most,
            "run.smallest_timestep",
            Mismatch(f"{least:g} s", f"at most run.largest_timestep, {most:g} s"),
        ),
        *(
            (
                not run.adaptive,
                f"run.{name}",
                Mismatch(
                    f"{value:g} together with a fixed run.timestep of {step:g} s",
                    remedy="remove one of them",
                ),
            )
            for name, value in bounds.items()
        ),
        (
            no_end,
            "run.frames",
            Mismatch(
                "fractions of an unknown end: use times in s, or set run.end_time to a number "
                'instead of "auto"'
            ),
        ),
        (
            not no_end and last > end,
            "run.frames",
            Mismatch(f"a time of {last:g} s", f"none beyond {ends}"),
        ),
    )


def check_probe_interval(case: Case, errors: ErrorList) -> None:
    """Check that probes are recorded before the end of the run."""
    interval = case.output.probe_interval
    end = case.run.longest
    if not isinstance(interval, str) and interval > end:
        errors.add(
            "output.probe_interval",
            Mismatch(f"{interval:g} s", f"at most run.end_time, {end:g} s"),
        )


def check_resolution(case: Case, errors: ErrorList) -> None:
    """Check that a fixed timestep resolves the oscillation of the load."""
    load = case.load
    step = case.run.timestep
    if not isinstance(load, DrivenLoad) or not load.oscillates or isinstance(step, str):
        return
    highest = load.highest_frequency
    most = 1 / (_STEPS_IN_A_PERIOD * step)
    errors.check(
        (
            highest > most,
            load.highest_key,
            Mismatch(
                f"{highest:g} Hz",
                f"at most {most:.4g} Hz, a period of {_STEPS_IN_A_PERIOD} timesteps of {step:g} s",
                'use a shorter run.timestep, or "auto"',
            ),
        ),
    )


def check_history(case: Case, errors: ErrorList) -> None:
    """Check that there is a chain or line to record a history of."""
    history = case.output.history
    has_one = case.packing.rule.is_chain or case.line
    found = Mismatch(
        f"{history} for {case.packing.kind}", "0: only chains and [[line]] have a history"
    )
    errors.check((not has_one and history not in (0, "auto"), "output.history", found))
