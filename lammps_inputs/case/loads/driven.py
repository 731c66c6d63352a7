"""Loads that do work during the run: a force or a displacement by a function of time.

The functions of time are defined in `granwave.lammps_inputs.case.loads.shapes`; the plugin's fix
gran/load applies them.
"""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import load_at
from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.loads.load import DOWN, LoadLimit, Vector, Wording
from granwave.lammps_inputs.case.loads.on_spheres import LoadOnSpheres
from granwave.lammps_inputs.case.loads.shapes import POINTS, SHAPE_KEYS, SHAPES, Points
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.run_directory import LOAD_FILE
from granwave.lammps_inputs.script_words import joined, num

Array = NDArray[np.float64]

_OSCILLATING = ("harmonic", "burst", "up-and-down", "sweep", "noise")
_SEED = 1
_SHARE_OF_RAMP = 0.05  # default ramp of a sweep or noise / its duration
_CREST = 5.0  # largest value of noise / its root mean square; more is rare
_ROUNDING = 1e-12  # relative tolerance of numbers of periods
_TIME: dict[str, Any] = {"unit": hints.TIME, "default": None}
_FREQUENCY: dict[str, Any] = {"unit": hints.FREQUENCY, "above": 0, "default": None}


@dataclasses.dataclass(frozen=True, kw_only=True)
class DrivenLoad(LoadOnSpheres):
    """Force or prescribed displacement of the impacted spheres by a function of time.

    Attributes
    ----------
    usual_amplitude
        Unit and usual values of the amplitude.
    shapes
        Functions of time that the kind of load takes.
    holds_last
        True if the last value of a table lasts; it is zero afterwards otherwise.
    """

    driven: ClassVar[bool] = True
    other_keys: ClassVar[tuple[str, ...]] = ("file",)  # replaced by the points of the file
    input_formula: ClassVar[str] = "v_given+f_load"
    usual_amplitude: ClassVar[hints.Usual]
    shapes: ClassVar[tuple[str, ...]]
    holds_last: ClassVar[bool]

    direction: Vector | None = schema.typed(
        "direction of a force or displacement; default: [0, 0, 1], straight down",
        schema.vector_type(3, "[x, y, z], a vector of any nonzero length", lambda *way: any(way)),
        default=None,
    )
    shape: str | None = schema.choice(
        "shape of the force or displacement in time", tuple(SHAPES), default=None
    )
    amplitude: float | None = schema.number(
        "amplitude of the total force (N) on the impacted spheres along load.direction, or of "
        "their displacement (m); for noise, the root mean square",
        "N",
        units="N; m for a displacement",
        above=0,
        default=None,
    )
    duration: float | None = schema.number(
        "duration of a half-sine, a rectangle, a rise and fall of the amplitude, a sweep, or noise",
        above=0,
        **_TIME,
    )
    frequency: float | None = schema.number(
        "frequency of a harmonic load or a burst, first frequency of a sweep, lowest frequency of "
        "noise",
        **_FREQUENCY,
    )
    last_frequency: float | None = schema.number(
        "frequency at the end of a sweep (may be below the first), or highest frequency of noise",
        **_FREQUENCY,
    )
    cycles: float | None = schema.number(
        "number of cycles of a burst within its window", at_least=1, at_most=1e6, default=None
    )
    ramp: float | None = schema.number(
        "rise time of a harmonic load, a sweep or noise, and fall time of a sweep or noise; "
        "default: 0 for a harmonic load, otherwise a twentieth of the duration",
        at_least=0,
        **_TIME,
    )
    seed: int | None = schema.count("seed of the phases of noise; default 1", default=None)
    table: Points | None = schema.typed(
        "points of force (N) or displacement (m) against time (s)", POINTS, default=None
    )

    @property
    def way(self) -> Vector:
        """Unit vector along which the force or displacement acts."""
        if self.direction is None:
            return DOWN
        largest = max(map(abs, self.direction))
        x, y, z = (part / largest for part in self.direction)
        length = math.hypot(x, y, z)
        return x / length, y / length, z / length

    @property
    def lasts(self) -> float:
        """Time at which the load ends, s; infinite for a harmonic load."""
        if self.shape == "harmonic":
            return math.inf
        if self.shape == "burst":
            return (self.cycles or 0.0) / (self.frequency or 1.0)
        if self.table:
            last_time, _ = self.table[-1]
            return last_time
        return self.duration or 0.0

    @property
    def first_time(self) -> float:
        """Time at which the values of a table first differ from zero, s; 0 for all other shapes."""
        return next((before for (before, _), (_, size) in pairwise(self.table or ()) if size), 0.0)

    @property
    def largest(self) -> float:
        """Largest magnitude of the force, N, or of the displacement, m."""
        if self.table:
            return max(abs(size) for _, size in self.table)
        return (self.amplitude or 0.0) * (_CREST if self.shape == "noise" else 1.0)

    @property
    def oscillates(self) -> bool:
        """True for a load of given frequencies."""
        return self.shape in _OSCILLATING

    @property
    def keeps_oscillating(self) -> bool:
        """True for a load of given frequencies, except a short burst."""
        return self.oscillates and self.shape != "burst"

    @property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest frequency of a load that oscillates, Hz."""
        first = self.frequency or 0.0
        last = self.last_frequency or first
        return min(first, last), max(first, last)

    @property
    def highest_key(self) -> str:
        """Key of the highest frequency."""
        rises = self.last_frequency is not None and self.last_frequency == self.highest_frequency
        return "load.last_frequency" if rises else "load.frequency"

    @property
    def rise(self) -> float:
        """Ramp of a harmonic load, of a sweep or of noise, s."""
        return _SHARE_OF_RAMP * (self.duration or 0.0) if self.ramp is None else self.ramp

    @property
    def numbers(self) -> list[float]:
        """Numbers of the shape in the form of fix gran/load; empty for a table."""
        if self.shape is None or self.table:
            return []
        ramp = None if self.shape == "harmonic" and not self.rise else self.rise
        defaults = {"ramp": ramp, "seed": _SEED if self.seed is None else self.seed}
        needed, possible = SHAPES[self.shape]
        values = [defaults.get(name, getattr(self, name)) for name in (*needed, *possible)]
        return [value for value in values if value is not None]

    def at(self, time: Array) -> Array:
        """Return the force, N, or the displacement, m, at instants (s): (n_times,)."""
        if self.table:
            times, sizes = np.array(self.table).T
            after = sizes[-1] if self.holds_last else 0.0
            before = sizes[0] if self.holds_last else 0.0
            return np.interp(time, times, sizes, left=before, right=after)
        return np.asarray(load_at(self.shape or "", self.numbers, time))

    @abstractmethod
    def force_on_contact(self, stiffness: float) -> float:
        """Return the largest force on a first contact of this stiffness (N/m), N."""

    def commands(self, group: str) -> list[str]:
        axes = [axis for axis, part in zip("xyz", self.way, strict=True) if part]
        along = f"vector {joined(map(num, self.direction or self.way))}"
        if len(axes) == 1 and sum(self.way) > 0:
            along = axes[0]
        words = joined(map(num, self.numbers)) or LOAD_FILE
        return [f"fix             load {group} gran/load {along} {self.kind} {self.shape} {words}"]

    def timestep_limit(self, share: float) -> LoadLimit | None:
        if self.oscillates:
            highest = self.highest_frequency
            cause = f"{self.highest_key} = {highest:g} Hz"
            return LoadLimit(share / highest, cause, "a lower frequency")
        if self.duration:
            cause = f"load.duration = {self.duration:g} s"
            return LoadLimit(share * self.duration, cause, "a longer load")
        return None

    @property
    def label(self) -> str:
        along = f"along {list(self.direction or ())}" if self.slants else "on top"
        return f"{self.kind} {along}"

    @classmethod
    def phrase(cls, case: Mapping[str, Any], write: Wording) -> str:
        if "load.amplitude" not in case:
            return super().phrase(case, write)
        size = write.quantity(case["load.amplitude"], cls.amplitude_unit)
        parts = [str(case.get("load.shape", "")), cls.kind, f"of {size}"]
        if duration := case.get("load.duration"):
            parts.append(f"for {write.quantity(duration, 's')}")
        if frequency := case.get("load.frequency"):
            parts.append(f"at {write.quantity(frequency, 'Hz')}")
        if direction := case.get("load.direction"):
            parts.append(f"along {write.number(direction)}")
        return " ".join(filter(None, parts))

    def amplitude_key(self, names: Sequence[str]) -> str:
        """Return the key of the case file that gives the amplitude."""
        if not self.table:
            return "load.amplitude"
        return "load.file" if "file" in names else "load.table"

    def check(self, names: Sequence[str], errors: ErrorList) -> None:
        super().check(names, errors)
        if self.shape is None or self.shape not in self.shapes:
            found = "missing" if self.shape is None else f'found "{self.shape}"'
            needed = f"a {self.kind} needs one of {', '.join(map(show, self.shapes))}"
            errors.add("load.shape", f"{found}; {needed}")
        else:
            self._check_keys_of_shape(self.shape, errors)
            if self.shape in ("sweep", "noise"):
                self._check_band(self.shape, errors)
        key = self.amplitude_key(names)
        errors.check_size(key, self.largest, self.usual_amplitude, f"{self.largest:g}")

    def _check_keys_of_shape(self, shape: str, errors: ErrorList) -> None:
        needed, possible = SHAPES[shape]
        takes = (*needed, *possible)
        present = [name for name in SHAPE_KEYS if getattr(self, name) is not None]
        for name in needed:
            instead = " (or load.file)" if name == "table" else ""
            text = f'missing; shape "{shape}" requires it{instead}'
            errors.check((name not in present, f"load.{name}", text))
        for name in present:
            text = f'cannot be used with shape "{shape}", whose keys are {", ".join(takes)}'
            errors.check((name not in takes, f"load.{name}", text))

    def _check_band(self, shape: str, errors: ErrorList) -> None:
        """Check frequencies and duration of a sweep or of noise."""
        duration = self.duration
        first = self.frequency
        last = self.last_frequency
        if not (duration and first and last):
            return
        lowest, highest = self.frequencies
        band = highest - lowest or highest
        most = math.floor(highest * duration * (1 + _ROUNDING))
        least = max(1, math.ceil(lowest * duration * (1 - _ROUNDING)))
        is_noise = shape == "noise"
        errors.check(
            (
                2 * self.rise > duration,
                "load.ramp",
                Mismatch(f"{self.rise:g} s", f"at most half of load.duration, {duration / 2:g} s"),
            ),
            (
                not is_noise and duration * lowest < 1,
                "load.duration",
                Mismatch(f"{duration:g} s, which is less than a period at {lowest:g} Hz", "more"),
            ),
            (
                is_noise and first > last,
                "load.last_frequency",
                Mismatch(f"{last:g}", f"more than load.frequency, {highest:g}"),
            ),
            (
                is_noise and first <= last and most < least,
                "load.duration",
                Mismatch(
                    f"{duration:g} s; no multiple of {1 / duration:g} Hz lies between "
                    f"{lowest:g} and {highest:g} Hz",
                    f"at least {1 / band:g} s",
                ),
            ),
        )
