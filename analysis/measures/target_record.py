"""Record of the force on the target: the bottom of a packing, or the bar at the end of a chain.

It shows whether the wave has arrived, whether the peak is in the record, and how much of the
momentum of the impact has reached the target.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from granwave.analysis.measures.impact_momentum import impact_momentum
from granwave.analysis.measures.signals import Array, arrival
from granwave.lammps_inputs.packing.bodies import BAR

if TYPE_CHECKING:  # loads h5py, which `granwave check` does without
    from granwave.analysis.result.reader import Result
    from granwave.lammps_inputs.packing.assembly import Assembly

#: Fraction of the momentum of an impact: as long as the impulse on the bottom is smaller, a later
#: pulse may be larger than the pulses so far.
_MOST_MOMENTUM = 0.8
_PERCENT = 100.0
_TENTHS = 10.0
_LAST_PART = 0.1  # fraction of the record in which an impulse may still grow ...
_GROWTH = 0.01  # ... by more than this fraction of its value
_LEAST_RECORDS = 2
ARRIVED = 0.01  # fraction of the largest dynamic force on the bottom
_STATIC = 1e-6  # fraction of the peak force: touching grains overlap by rounding at the start
_NEGLIGIBLE = 1e-6  # fraction of the momentum of the impact
_NOISE = 1e-6  # fraction of the initial force: precision of a static stage


@dataclasses.dataclass(frozen=True, eq=False)
class Reached:
    """Record of the target; every array (n_times,)."""

    time: Array  # s
    force: Array  # force on the target from the packing, or from the impactor without a packing, N
    ground_force: (
        Array | None
        # force of the target on the ground, N; None for a bar at a chain's end, where it is not
        # recorded
    )
    # outward displacement since the impact, m; None for a fixed target
    displacement: Array | None = None
    # largest force in any step, N, where it is known: the records may miss it
    largest_force: float | None = None
    momentum: float = 0.0  # magnitude of the momentum of the impact, N s
    # momentum of the impact towards the target, which only the target takes up, N s; None if other
    # bodies do, or without an impact
    momentum_down: float | None = None

    @property
    def impulse(self) -> Array:
        """Impulse of the force on the target so far, including the static force, N s."""
        return _integral(self.time, self.force)

    @property
    def dynamic_impulse(self) -> Array:
        """Impulse of the change of the force on the target since the start so far, N s."""
        return _integral(self.time, self.force - self.static_force)

    @property
    def peak_force(self) -> float:
        """Largest force on the target, N: in any step if a single contact carries it, otherwise in
        the records.
        """
        recorded = float(np.max(self.force, initial=0.0))
        return recorded if self.largest_force is None else max(recorded, self.largest_force)

    @property
    def is_fixed(self) -> bool:
        """True if the ground carries the force on the target itself, as below a bottom at rest."""
        return self.ground_force is self.force

    @property
    def ground_dynamic_peak_force(self) -> float | None:
        """Largest rise of the force on the ground above its static value, N."""
        if self.is_fixed:
            return self.dynamic_peak_force
        if self.ground_force is None or not len(self.ground_force):
            return None
        return float((self.ground_force - self.ground_force[0]).max())

    @property
    def static_force(self) -> float:
        """Force on the target at the start, N."""
        return float(self.force[0]) if len(self.force) else 0.0

    @property
    def has_static_force(self) -> bool:
        """True if the target carries a force at the start, beyond the rounding of contacts."""
        return self.static_force > _STATIC * self.peak_force

    @property
    def dynamic_peak_force(self) -> float:
        """Largest rise of the force on the target above its static value, N; 0 before the wave
        arrives.
        """
        return self.peak_force - self.static_force if self.is_reached else 0.0

    @property
    def is_reached(self) -> bool:
        """True if the force rises above its static value by more than the precision of a static
        stage.

        A force that still rises at the end of the record, and whose impulse is negligible compared
        with the momentum of the impact, is the start of a front that has not arrived: in a chain of
        elastic spheres such a front has no sharp edge.
        """
        if self._is_largest_at_end:
            impulse = float(self.dynamic_impulse[-1])
            if impulse < _NEGLIGIBLE * self.momentum:
                return False
        rise = self.force - self.static_force
        return bool(np.any(rise > _NOISE * abs(self.static_force)))

    @property
    def rises_at_end(self) -> bool:
        """True if the force is largest at the end of the record, so that it may rise further."""
        return self.is_reached and self._is_largest_at_end

    @property
    def arrived_momentum(self) -> float | None:
        """Impulse on the target at the end of the record, above the static force, divided by the
        momentum of the impact; None if that is unknown.
        """
        if not self.momentum_down or not len(self.force):
            return None
        return float(self.dynamic_impulse[-1]) / self.momentum_down

    @property
    def arrived_in_words(self) -> str:
        """The same fraction in per cent; one that is below 80 % is not rounded to it."""
        percent = _PERCENT * (self.arrived_momentum or 0.0)
        limit = _PERCENT * _MOST_MOMENTUM
        text = f"{percent:.2g}"
        if percent < limit <= float(text):
            text = f"{percent:.3g}"
        if percent < limit <= float(text):
            text = f"{math.floor(_TENTHS * percent) / _TENTHS:.1f}"
        return f"{text} %"

    @property
    def awaits_momentum(self) -> bool:
        """True if the force has passed a peak, but less than 80 % of the momentum of the impact has
        reached the target, so that a later pulse may be larger.
        """
        arrived = self.arrived_momentum
        if arrived is None or not self.is_reached or self.rises_at_end:
            return False
        return arrived < _MOST_MOMENTUM

    @property
    def has_known_peak(self) -> bool:
        """True if the target is reached, and the record includes the largest force."""
        return self.is_reached and not self.rises_at_end and not self.awaits_momentum

    @property
    def has_growing_impulse(self) -> bool:
        """True if the impulse above the static force still grows at the end: more than 1 % of it
        belongs to the last tenth of the record.
        """
        impulse = self.dynamic_impulse
        if not self.is_reached or len(impulse) < _LEAST_RECORDS:
            return False
        start = self.time[0] + (1 - _LAST_PART) * (self.time[-1] - self.time[0])
        before = float(np.interp(start, self.time, impulse))
        return abs(float(impulse[-1]) - before) > _GROWTH * abs(float(impulse[-1]))

    @property
    def _is_largest_at_end(self) -> bool:
        return len(self.force) > 0 and int(self.force.argmax()) == len(self.force) - 1

    @property
    def ground_peak_force(self) -> float | None:
        """Largest force on the ground, N."""
        if self.is_fixed:
            return self.peak_force
        return None if self.ground_force is None else float(np.max(self.ground_force, initial=0.0))

    @property
    def arrival(self) -> float | None:
        """Time at which the force has first risen by 1 % of its largest rise in the record, s,
        interpolated between records; None if it never does.

        As long as the force rises, so does the level, see `known_arrival`.
        """
        if not self.is_reached:
            return None
        rise = self.force - self.force[0]
        level = max(ARRIVED * float(rise.max()), _NOISE * abs(float(self.force[0])))
        if not np.any(rise > level):
            return None
        return arrival(self.time, rise, level)

    @property
    def known_arrival(self) -> float | None:
        """`arrival`; None while the force still rises at the end of the record, since the arrival
        would depend on the end.
        """
        return None if self.rises_at_end else self.arrival


def _integral(time: Array, force: Array) -> Array:
    """Return the integral of a force over time up to each time: (n_times,), N s."""
    steps = np.diff(time) * (force[1:] + force[:-1]) / 2
    return np.concatenate([[0.0], np.cumsum(steps)])


def reached(result: Result) -> Reached | None:
    """Return the record of the bottom of a packing, or of the bar at a chain's end; None if there
    is neither.
    """
    name = next((name for name in ("bottom", BAR) if f"walls/{name}" in result), None)
    if name is None:
        return None
    group = f"walls/{name}"
    time = result[f"{group}/time"]
    force = result[f"{group}/force"]
    moved, ground = (result.get(f"{group}/{one}") for one in ("displacement", "ground_force"))
    if ground is None and name != BAR:
        ground = force
    displacement = None if moved is None else moved - moved[0]
    largest = _largest_of_one_contact(result, name)
    scale = _momentum_scale(result)
    down = impact_momentum(result.assembly)
    return Reached(time, force, ground, displacement, largest, scale, down)


def _momentum_scale(result: Result) -> float:
    """Return the magnitude of the momentum of the impact, N s: input energy / largest speed of the
    loaded grain; 0 if that never moves.
    """
    speed = float(np.max(np.abs(result["energy/struck_velocity"]), initial=0.0))
    return result.energy_input / speed if speed else 0.0


def _largest_of_one_contact(result: Result, name: str) -> float | None:
    """Return the largest force in any step on a target that a single contact loads, N; None for
    several contacts, whose largest forces occur at different times.
    """
    if "wall_contacts/wall" not in result:
        return None
    forces = result["wall_contacts/peak_force"][result["wall_contacts/wall"] == name]
    return float(forces[0]) if len(forces) == 1 else None


def rising_force_warning(directory: Path, assembly: Assembly | None = None) -> str:
    """Return a warning if the force on the bottom may rise further after the end of a run, in a
    line; empty if it does not, or is not recorded.

    Parameters
    ----------
    assembly
        All bodies of its case, if they are known; otherwise they are assembled.
    """
    from granwave.analysis.result.reader import Result  # loads h5py

    with Result(directory, assembly=assembly) as result:
        record = reached(result)
    if record is None:
        return ""
    remedy = "Increase run.end_time to record its peak."
    if record.rises_at_end:
        return (
            "the force on the bottom is largest at the end of the run, and may rise further. Its "
            f"arrival and the peak reduction are not known. {remedy}"
        )
    if record.awaits_momentum:
        return f"{momentum_in_words(record)}. {remedy}"
    return ""


def momentum_in_words(record: Reached) -> str:
    """Return a clause on a force on the bottom that may become larger, since little of the momentum
    of the impact has arrived.
    """
    return (
        f"only {record.arrived_in_words} of the impact's momentum has reached the bottom by the "
        "end of the run, so that a later pulse may be larger"
    )
