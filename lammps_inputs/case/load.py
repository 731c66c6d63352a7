"""``[load]``: the load on a packing.

    impact         initial velocity of the struck spheres
    striker        velocities of the [[striker]]s only
    force          force on the struck spheres, or on the free end of the incident bar
    displacement   prescribed displacement of the struck spheres
    plate          a rigid plate on the free top, with a mass and a velocity
    grains         velocities of the grains of packing.file only

Time functions of forces and displacements, with amplitude A, duration T and frequency f:

    half-sine      A sin(pi t / T) up to T (thesis 2.21)
    rectangle      A up to T (thesis 4.2)
    harmonic       A sin(2 pi f t)
    table          linear interpolation between given points; zero before and after
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from granwave.lammps_inputs.case.ids import parse_index
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    choice,
    custom,
    finite,
    number,
    read_table,
    show,
    vector,
)
from granwave.lammps_inputs.case.si_values import (
    DISPLACEMENT,
    FORCE,
    FREQUENCY,
    MASS,
    SPIN,
    TIME,
    VELOCITY,
    impossible,
    unusual,
)
from granwave.lammps_inputs.files import read_regular

DEFAULT_VELOCITY = 5.0  # m/s
_KINDS = ("impact", "striker", "force", "displacement", "plate", "grains")
_SHAPES = ("half-sine", "rectangle", "harmonic", "table")
_NEEDS: dict[str, tuple[str, ...]] = {
    "half-sine": ("amplitude", "duration"),
    "rectangle": ("amplitude", "duration"),
    "harmonic": ("amplitude", "frequency"),
    "table": ("table",),
}
_OF_SHAPES = ("shape", "amplitude", "duration", "frequency", "table", "file")
_OF_KIND = {
    "impact": ("kind", "spheres", "index", "velocity", "angle", "spin"),
    "striker": ("kind",),
    "force": ("kind", "spheres", "index", *_OF_SHAPES),
    "displacement": ("kind", "spheres", "index", *_OF_SHAPES),
    "plate": ("kind", "mass", "velocity"),
    "grains": ("kind",),
}
_OF_DISPLACEMENT = ("harmonic", "table")
_TABLE_FORM = "rows [time in s, value], at least two, times rising from 0 on"


def _parse_table(value: Any) -> tuple[tuple[float, float], ...]:
    if not isinstance(value, list | tuple) or len(value) < 2:
        raise ValidationError(_TABLE_FORM)
    if any(not isinstance(row, list | tuple) or len(row) != 2 for row in value):
        raise ValidationError(_TABLE_FORM)
    rows = tuple((finite(time, _TABLE_FORM), finite(size, _TABLE_FORM)) for time, size in value)
    if rows[0][0] < 0 or any(later[0] <= earlier[0] for earlier, later in pairwise(rows)):
        raise ValidationError(_TABLE_FORM)
    if expected := impossible([time for time, _ in rows], "s"):
        raise ValidationError(f"times of {expected}")
    if not any(size for _, size in rows):
        raise ValidationError("a value other than zero")
    return rows


@dataclasses.dataclass(frozen=True, kw_only=True)
class Load:
    """``[load]``: the load on a packing."""

    kind: Literal["impact", "striker", "force", "displacement", "plate", "grains"] = choice(
        "velocity of the struck spheres, the strikers alone, a force, a prescribed displacement, a rigid plate on the "
        "free top, or the velocities of the grains of a file alone",
        _KINDS,
        default="impact",
    )
    mass: float | None = number("mass of the plate", unit="kg", above=0, default=None, usual=MASS)
    velocity: float = number(
        "velocity of the struck spheres, or of the plate, into the packing",
        unit="m/s",
        above=0,
        default=DEFAULT_VELOCITY,
        usual=VELOCITY,
    )
    angle: float = number(
        "angle of an impact between the velocity and +z, towards +x", unit="degrees", at_least=0, below=90, default=0.0
    )
    spin: tuple[float, float, float] = vector(
        "angular velocity of the struck spheres at the start", unit="rad/s", usual=SPIN
    )
    spheres: Literal[1, 3, 7] = choice("how many spheres are struck", (1, 3, 7), default=1)
    index: tuple[int, ...] | None = custom(
        "ids of the struck spheres, instead of those at the centre of the top layer", parse_index, default=None
    )
    shape: Literal["half-sine", "rectangle", "harmonic", "table"] | None = choice(
        "shape of the force or displacement in time", _SHAPES, default=None
    )
    amplitude: float | None = number(
        "amplitude of the force on all struck spheres together, along +z; of a displacement, in m",
        unit="N",
        above=0,
        default=None,
    )
    duration: float | None = number(
        "duration of a half-sine or a rectangle", unit="s", above=0, default=None, usual=TIME
    )
    frequency: float | None = number(
        "frequency of a harmonic force or displacement", unit="Hz", above=0, default=None, usual=FREQUENCY
    )
    table: tuple[tuple[float, float], ...] | None = custom(
        "points of force (N) or displacement (m) against time (s)", _parse_table, default=None
    )

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
    def lasts(self) -> float:
        """Time at which a force or displacement ends, s; 0 for other loads, infinite for a harmonic one."""
        if not self.driven:
            return 0.0
        if self.shape == "harmonic":
            return math.inf
        return self.table[-1][0] if self.table else self.duration or 0.0

    @property
    def largest(self) -> float:
        """Largest magnitude of the force, N, or of the displacement, m."""
        return max(abs(size) for _, size in self.table) if self.table else self.amplitude or 0.0

    @property
    def impulse(self) -> float:
        """Largest magnitude of the impulse up to any time, N s; a harmonic force reaches it after half a period."""
        if self.table:
            time, size = np.array(self.table).T
            parts = np.diff(time) * (size[1:] + size[:-1]) / 2
            return float(np.abs(np.cumsum(parts)).max())
        amplitude = self.amplitude or 0.0
        if self.shape == "harmonic":
            return amplitude / (math.pi * (self.frequency or 1.0))
        return amplitude * (self.duration or 0.0) * (2 / math.pi if self.shape == "half-sine" else 1.0)

    @property
    def fastest(self) -> float:
        """Largest speed of a prescribed displacement, m/s."""
        if self.table:
            time, size = np.array(self.table).T
            return float(np.abs(np.diff(size) / np.diff(time)).max())
        return 2 * math.pi * (self.frequency or 0.0) * (self.amplitude or 0.0)

    def keys(self) -> dict[str, Any]:
        """Return the keys that apply to this kind of load, with their values."""
        given = {name: getattr(self, name) for name in _OF_KIND[self.kind] if name != "file"}
        return given if self.index is None else {name: value for name, value in given.items() if name != "spheres"}


def read_load(table: Any, errors: ErrorList) -> Load | None:
    """Read ``[load]``; missing and wrong values are added to ``errors``.

    The points of ``load.file`` become ``load.table``, so that the case is complete without the file.
    """
    before, names = len(errors.lines), list(table) if isinstance(table, Mapping) else []
    if isinstance(table, Mapping) and "file" in table:
        rest = {name: value for name, value in table.items() if name != "file"}
        table = {"shape": "table"} | rest | _from_file(table, errors)
        if len(errors.lines) > before:
            return None
    load = read_table(Load, table, "load", errors)
    if load is None:
        return None
    for name in names:
        if name not in _OF_KIND[load.kind]:
            belongs = " or ".join(f'"{kind}"' for kind in _KINDS if name in _OF_KIND[kind])
            errors.add(f"load.{name}", f'belongs to a load of kind {belongs}; found load.kind = "{load.kind}"')
    if load.index is not None and "spheres" in names:
        errors.add("load.index", "found beside load.spheres; give one of them")
    if load.index is not None and len(set(load.index)) < len(load.index):
        errors.add("load.index", f"found {show(list(load.index))}, expected each id once")
    if load.kind == "plate" and load.mass is None:
        errors.add("load.mass", "missing; a plate needs a mass, in kg")
    if load.driven:
        _check_shape(load, errors)
        unit, usual = ("N", FORCE) if load.kind == "force" else ("m", DISPLACEMENT)
        key = "load.table" if load.table else "load.amplitude"
        if expected := impossible(load.largest, unit):
            errors.add(key, f"found {load.largest:g}, expected {expected}")
        elif odd := unusual(load.largest, unit, usual):
            errors.notes.append(f"{key}: {odd}")
    return load if len(errors.lines) == before else None


def _check_shape(load: Load, errors: ErrorList) -> None:
    options = _OF_DISPLACEMENT if load.kind == "displacement" else _SHAPES
    if load.shape not in options:
        found = "missing" if load.shape is None else f'found "{load.shape}"'
        errors.add("load.shape", f"{found}; a {load.kind} needs one of " + ", ".join(f'"{one}"' for one in options))
        return
    needed = _NEEDS[str(load.shape)]
    for name in needed:
        if getattr(load, name) is None:
            alternative = " (or load.file)" if name == "table" else ""
            errors.add(f"load.{name}", f'missing; shape "{load.shape}" needs it{alternative}')
    for name in ("amplitude", "duration", "frequency", "table"):
        if name not in needed and getattr(load, name) is not None:
            errors.add(f"load.{name}", f'does not belong to shape "{load.shape}", which takes {", ".join(needed)}')


def _from_file(table: Mapping[str, Any], errors: ErrorList) -> dict[str, Any]:
    name = table["file"]
    if "table" in table:
        errors.add("load.file", "found beside load.table; give one of them")
        return {}
    if not isinstance(name, str) or not name:
        errors.add("load.file", f"found {show(name)}, expected the path of a file of two columns, time and value")
        return {}
    try:
        rows = _numbers(read_regular(Path(name)).decode("utf-8-sig").splitlines())
    except OSError as error:
        errors.add("load.file", f"{name}: cannot be read: {error.strerror or error}")
        return {}
    except ValueError as error:
        errors.add("load.file", f"{name}: {error}; expected two columns of numbers, {_TABLE_FORM}")
        return {}
    try:
        return {"table": _parse_table(rows)}
    except ValidationError as error:
        errors.add("load.file", f"{name}: found {show(rows)}, expected {error}")
        return {}


def _numbers(lines: Sequence[str]) -> list[list[float]]:
    """Read two numbers from each line; raise ValueError naming the first line that has others."""
    rows = []
    for n, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        try:
            time, size = map(float, words)
        except ValueError:
            raise ValueError(f"found {show(line.strip())} in line {n}") from None
        rows.append([time, size])
    return rows
