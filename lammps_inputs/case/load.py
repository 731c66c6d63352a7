"""``[load]``: the load on a packing.

    impact         initial velocity of the struck spheres
    striker        velocities of the [[striker]]s only
    force          force on the struck spheres, or on the free end of the incident bar
    displacement   prescribed displacement of the struck spheres
    plate          a rigid plate on the free top, with a mass and a velocity
    grains         velocities of the grains of packing.file only

Time functions of forces and displacements, with amplitude A, duration T and frequency f:

    half-sine      A sin(pi t / T) up to T
    rectangle      A up to T
    harmonic       A sin(2 pi f t), risen over a ramp R by sin^2(pi t / 2R) if there is one
    burst          A sin^2(pi t / T) sin(2 pi f t) up to T = n/f: n cycles under a window (Hann)
    up-and-down    A (1 - |2t/T - 1|) sin(2 pi f t) up to T
    sweep          A sin(2 pi (f t + (f_last - f) t^2 / 2T)) up to T, with a ramp at either end
    noise          sines at all multiples of 1/T from f to f_last, alike in size, of random phase, with the root mean
                   square A; up to T, with a ramp at either end
    table          linear interpolation between given points; a force is zero before and after, a displacement begins
                   at 0 and keeps its last value
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import load_at
from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.ids import INDEX
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, read_table, show
from granwave.lammps_inputs.files import read_number, read_text

_TABLE_FORM = "rows [time in s, value], at least two, times rising from 0 on"


def _rising(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    schema.refuse_if(
        rows[0][0] < 0 or any(later[0] <= earlier[0] for earlier, later in pairwise(rows)),
        _TABLE_FORM,
    )
    if expected := hints.impossible([time for time, _ in rows], "s"):
        raise ValidationError(f"times of {expected}")
    schema.refuse_if(not any(size for _, size in rows), "a value other than zero")
    return rows


_ROWS = schema.ListType(
    item=schema.vector_type(2, _TABLE_FORM), expected=_TABLE_FORM, at_least=2, finish=_rising
)


def _read_rows(path: Path) -> tuple[tuple[float, float], ...]:
    """Read the two columns of a file of a load; raise ValueError with the fault."""
    form = f"two columns of numbers, {_TABLE_FORM}"
    rows = []
    try:
        text = read_text(path)
    except ValueError as error:
        raise ValueError(f"{error}; expected {form}") from None
    for n, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        try:
            rows += [
                [read_number(time), read_number(size)] for time, size in ([words] if words else [])
            ]
        except ValueError:
            raise ValueError(
                f"found {show(' '.join(words))} in line {n}; expected {form}"
            ) from None
    try:
        return _ROWS.read(rows)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise ValueError(f"found {show(rows)}, expected {error}") from None


Array = NDArray[np.float64]

DEFAULT_VELOCITY = 5.0  # m/s
_SHAPES: dict[
    str, tuple[tuple[str, ...], tuple[str, ...]]
] = {  # keys that a shape needs, and those that it may have
    "half-sine": (("amplitude", "duration"), ()),
    "rectangle": (("amplitude", "duration"), ()),
    "harmonic": (("amplitude", "frequency"), ("ramp",)),
    "burst": (("amplitude", "frequency", "cycles"), ()),
    "up-and-down": (("amplitude", "frequency", "duration"), ()),
    "sweep": (("amplitude", "frequency", "last_frequency", "duration"), ("ramp",)),
    "noise": (("amplitude", "frequency", "last_frequency", "duration"), ("ramp", "seed")),
    "table": (("table",), ()),
}
_OF_DISPLACEMENT = tuple(
    name for name in _SHAPES if name not in ("half-sine", "rectangle")
)  # the others jump
_OF_SHAPES = (
    "amplitude",
    "duration",
    "frequency",
    "last_frequency",
    "cycles",
    "ramp",
    "seed",
    "table",
)
_OF_KIND = {  # keys of each kind of load
    "impact": ("kind", "spheres", "index", "velocity", "angle", "spin"),
    "striker": ("kind",),
    "force": ("kind", "spheres", "index", "direction", "shape", *_OF_SHAPES, "file"),
    "displacement": ("kind", "spheres", "index", "direction", "shape", *_OF_SHAPES, "file"),
    "plate": ("kind", "mass", "velocity"),
    "grains": ("kind",),
}
_SEED = 1
_SHARE_OF_RAMP = 0.05  # of the duration of a sweep or noise, if none is given
_CREST = 5.0  # largest value of noise over its root mean square; more is rare
_TIME: dict[str, Any] = {"unit": hints.TIME, "default": None}
_FREQUENCY: dict[str, Any] = {"unit": hints.FREQUENCY, "above": 0, "default": None}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Load:
    """``[load]``: the load on a packing."""

    kind: str = schema.choice(
        "velocity of the struck spheres, the strikers alone, a force, a prescribed displacement, a rigid plate on the "
        "free top, or the velocities of the grains of a file alone",
        tuple(_OF_KIND),
        default="impact",
    )
    mass: float | None = schema.number("mass of the plate", hints.MASS, above=0, default=None)
    velocity: float = schema.number(
        "velocity of the struck spheres, or of the plate, into the packing",
        hints.VELOCITY,
        above=0,
        default=DEFAULT_VELOCITY,
    )
    angle: float = schema.number(
        "angle of an impact between the velocity and +z, towards +x",
        "degrees",
        at_least=0,
        below=90,
        default=0.0,
    )
    spin: tuple[float, float, float] = schema.vector(
        "angular velocity of the struck spheres at the start", hints.SPIN
    )
    spheres: int = schema.choice("how many spheres are struck", (1, 3, 7), default=1)
    index: tuple[int, ...] | None = schema.typed(
        "ids of the struck spheres, instead of those at the centre of the top layer",
        INDEX,
        default=None,
    )
    direction: tuple[float, float, float] | None = schema.typed(
        "direction of a force or displacement; [0, 0, 1], straight down, by default",
        schema.vector_type(3, "[x, y, z], a vector of any length but 0", lambda *way: any(way)),
        default=None,
    )
    shape: str | None = schema.choice(
        "shape of the force or displacement in time", tuple(_SHAPES), default=None
    )
    amplitude: float | None = schema.number(
        "amplitude of the force on all struck spheres together, along load.direction; of a displacement, in m; "
        "of noise its root mean square",
        "N",
        units="N; m for a displacement",
        above=0,
        default=None,
    )
    duration: float | None = schema.number(
        "duration of a half-sine, a rectangle, a rise and fall of the amplitude, a sweep or noise",
        above=0,
        **_TIME,
    )
    frequency: float | None = schema.number(
        "frequency of a harmonic load or a burst, first frequency of a sweep, lowest of noise",
        **_FREQUENCY,
    )
    last_frequency: float | None = schema.number(
        "frequency at the end of a sweep, which may fall, or highest of noise", **_FREQUENCY
    )
    cycles: float | None = schema.number(
        "number of cycles of a burst under its window", at_least=1, at_most=1e6, default=None
    )
    ramp: float | None = schema.number(
        "time over which a harmonic load, a sweep or noise rises; a sweep and noise also fall in it; "
        "default 0 for a harmonic load, else a twentieth of the duration",
        at_least=0,
        **_TIME,
    )
    seed: int | None = schema.count("seed of the phases of noise; default 1", default=None)
    table: tuple[tuple[float, float], ...] | None = schema.typed(
        "points of force (N) or displacement (m) against time (s)", _ROWS, default=None
    )

    FURTHER_KEYS: ClassVar[dict[str, Any]] = {
        "file": schema.path(
            "the table as a file: two columns, time (s) and force (N) or displacement (m)",
            default=None,
        )
    }

    @property
    def hits_spheres(self) -> bool:
        """True if the load acts on spheres of the packing that the case chooses."""
        return self.kind not in ("striker", "plate", "grains")

    @property
    def plate(self) -> tuple[float, float] | None:
        """Mass (kg) and velocity (m/s) of a plate; None for other loads."""
        return (self.mass or 0.0, self.velocity) if self.kind == "plate" else None

    @property
    def driven(self) -> bool:
        """True for a force or displacement, which does work during the run."""
        return self.kind in ("force", "displacement")

    @property
    def initial_velocity(self) -> tuple[float, float, float]:
        """Initial velocity (x, y, z) of the struck spheres of an impact, m/s."""
        angle = math.radians(self.angle)
        return self.velocity * math.sin(angle), 0.0, self.velocity * math.cos(angle)

    @property
    def way(self) -> tuple[float, float, float]:
        """Unit vector along which a force or displacement acts."""
        if self.direction is None:
            return 0.0, 0.0, 1.0
        largest = max(map(abs, self.direction))
        x, y, z = (part / largest for part in self.direction)
        length = math.hypot(x, y, z)
        return x / length, y / length, z / length

    @property
    def slants(self) -> bool:
        """True for a force or displacement that does not act straight down."""
        return self.way != (0.0, 0.0, 1.0)

    @property
    def lasts(self) -> float:
        """Time at which a force or displacement ends, s; 0 for other loads, infinite for a harmonic
        one.
        """
        if not self.driven:
            return 0.0
        if self.shape == "harmonic":
            return math.inf
        if self.shape == "burst":
            return (self.cycles or 0.0) / (self.frequency or 1.0)
        return self.table[-1][0] if self.table else self.duration or 0.0

    @property
    def first_time(self) -> float:
        """Time at which a table leaves zero, s; 0 for all other loads."""
        return next((before for (before, _), (_, size) in pairwise(self.table or ()) if size), 0.0)

    @property
    def largest(self) -> float:
        """Largest magnitude of the force, N, or of the displacement, m."""
        if self.table:
            return max(abs(size) for _, size in self.table)
        return (self.amplitude or 0.0) * (_CREST if self.shape == "noise" else 1.0)

    @property
    def may_stop(self) -> bool:
        """True for a displacement by a table: the moved spheres may give back most of the energy
        put in.
        """
        return self.kind == "displacement" and bool(self.table)

    @property
    def oscillates(self) -> bool:
        """True for a load of given frequencies."""
        return self.shape in ("harmonic", "burst", "up-and-down", "sweep", "noise")

    @property
    def frequencies(self) -> tuple[float, float]:
        """Lowest and highest frequency of a load that oscillates, Hz."""
        both = self.frequency or 0.0, self.last_frequency or self.frequency or 0.0
        return min(both), max(both)

    @property
    def rise(self) -> float:
        """Ramp of a harmonic load, of a sweep or of noise, s."""
        return _SHARE_OF_RAMP * (self.duration or 0.0) if self.ramp is None else self.ramp

    @property
    def numbers(self) -> list[float]:
        """Numbers of the shape, as fix gran/load takes them; empty for a table."""
        if self.shape is None or self.table:
            return []
        ramp = None if self.shape == "harmonic" and not self.rise else self.rise
        defaults = {"ramp": ramp, "seed": _SEED if self.seed is None else self.seed}
        names = [name for needed_or_not in _SHAPES[self.shape] for name in needed_or_not]
        values = [defaults.get(name, getattr(self, name)) for name in names]
        return [value for value in values if value is not None]

    def at(self, time: Array) -> Array:
        """Return the force, N, or the displacement, m, at some times, s: (n_times,)."""
        if self.table:
            given = np.array(self.table)
            ends = {"left": 0.0, "right": 0.0} if self.kind == "force" else {}
            return np.interp(time, given[:, 0], given[:, 1], **ends)
        return np.asarray(load_at(self.shape or "", self.numbers, time))

    @property
    def impulse(self) -> float:
        """Largest magnitude of the impulse up to any time, N s; one that oscillates reaches it
        after half a period.
        """
        if self.table:
            time, size = np.array(self.table).T
            parts = np.diff(time) * (size[1:] + size[:-1]) / 2
            return float(np.abs(np.cumsum(parts)).max())
        if self.oscillates:
            return self.largest / (math.pi * self.frequencies[0])
        amplitude = self.amplitude or 0.0
        return (
            amplitude * (self.duration or 0.0) * (2 / math.pi if self.shape == "half-sine" else 1.0)
        )

    @property
    def fastest(self) -> float:
        """Largest speed of a prescribed displacement, m/s."""
        if self.table:
            time, size = np.array(self.table).T
            return float(np.abs(np.diff(size) / np.diff(time)).max())
        return 2 * math.pi * self.frequencies[1] * self.largest

    def keys(self) -> dict[str, Any]:
        """Return the keys that apply to this kind of load, with their values."""
        given = {name: getattr(self, name) for name in _OF_KIND[self.kind] if name != "file"}
        return (
            given
            if self.index is None
            else {name: value for name, value in given.items() if name != "spheres"}
        )


def read_load(table: Any, errors: ErrorList) -> Load | None:
    """Read ``[load]``; missing and wrong values are added to ``errors``.

    The points of ``load.file`` become ``load.table``, so that the case is complete without the
    file.
    """
    before = len(errors.lines)
    names = list(table) if isinstance(table, Mapping) else []
    if "file" in names:
        expected = "the path of a file of two columns, time and value"
        errors.check(("table" in names, "load.file", "found beside load.table; give one of them"))
        rows = (
            None
            if "table" in names
            else schema.read_named("load.file", table["file"], expected, _read_rows, errors)
        )
        if rows is None:
            return None
        table = {"shape": "table", "table": rows} | {
            name: table[name] for name in names if name != "file"
        }
    load = read_table(Load, table, "load", errors)
    if load is None:
        return None
    index = load.index or ()
    kinds = {name: [kind for kind, keys in _OF_KIND.items() if name in keys] for name in names}
    errors.check(
        *((load.kind not in kinds[name], f"load.{name}", "belongs to a load of kind "
           f'{" or ".join(map(show, kinds[name]))}; found load.kind = "{load.kind}"') for name in names),
        (index and "spheres" in names, "load.index", "found beside load.spheres; give one of them"),
        (len(set(index)) < len(index), "load.index", f"found {show(list(index))}, expected each id once"),
        (load.kind == "plate" and load.mass is None, "load.mass", "missing; a plate needs a mass, in kg"),
    )  # fmt: skip
    if load.driven:
        _check_shape(load, errors)
        key = ("load.file" if "file" in names else "load.table") if load.table else "load.amplitude"
        unit = hints.FORCE if load.kind == "force" else hints.DISPLACEMENT
        first = load.table[0][1] if load.table else 0.0
        errors.check_size(key, load.largest, unit, f"{load.largest:g}")
        errors.check(
            (load.kind == "displacement" and first, key,
             f"found {first:g} m at first, expected 0: a displacement counts from where the spheres rest at the "
             f"start; subtract {first:g} from all its values"),
        )  # fmt: skip
    return load if len(errors.lines) == before else None


def _check_shape(load: Load, errors: ErrorList) -> None:
    options = _OF_DISPLACEMENT if load.kind == "displacement" else tuple(_SHAPES)
    shape = load.shape
    if shape is None or shape not in options:
        found = "missing" if shape is None else f'found "{shape}"'
        errors.add(
            "load.shape", f"{found}; a {load.kind} needs one of {', '.join(map(show, options))}"
        )
        return
    needed, possible = _SHAPES[shape]
    taken = (*needed, *possible)
    given = [name for name in _OF_SHAPES if getattr(load, name) is not None]
    errors.check(
        *((name not in given, f"load.{name}",
           f'missing; shape "{shape}" needs it{" (or load.file)" if name == "table" else ""}') for name in needed),
        *((name not in taken, f"load.{name}", f'does not belong to shape "{shape}", which takes {", ".join(taken)}')
          for name in given),
    )  # fmt: skip
    duration = load.duration
    first = load.frequency
    last = load.last_frequency
    if shape not in ("sweep", "noise") or not (duration and first and last):
        return
    lowest, highest = load.frequencies
    band = highest - lowest or highest
    lines = math.floor(highest * duration * (1 + 1e-12)) - max(
        1, math.ceil(lowest * duration * (1 - 1e-12))
    )
    errors.check(
        (2 * load.rise > duration, "load.ramp",
         f"found {load.rise:g} s, expected at most half of load.duration, {duration / 2:g} s"),
        (shape == "sweep" and duration * lowest < 1, "load.duration",
         f"found {duration:g} s, less than a period at {lowest:g} Hz; expected more"),
        (shape == "noise" and first > last, "load.last_frequency",
         f"found {last:g}, expected more than load.frequency, {highest:g}"),
        (shape == "noise" and first <= last and lines < 0, "load.duration",
         f"found {duration:g} s; no multiple of {1 / duration:g} Hz lies between {lowest:g} and {highest:g} Hz; "
         f"expected at least {1 / band:g} s"),
    )  # fmt: skip
