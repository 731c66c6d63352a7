"""Case file of an inference (TOML): material of the grains, and their measurement."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from granwave.extensions.inference.forces.equations import WEIGHTS, Noise, Weights
from granwave.extensions.inference.forces.grains import (
    STATES,
    Array,
    CandidateContacts,
    StraightWall,
)
from granwave.lammps_inputs.case.hints import DENSITY, FRICTION, LENGTH, TIME, YOUNGS_MODULUS
from granwave.lammps_inputs.case.material import Material, read_material
from granwave.lammps_inputs.case.schema import (
    CountType,
    ErrorList,
    ListType,
    NumberType,
    ValidationError,
    ValueType,
    choice,
    count,
    finite,
    keys_of,
    number,
    read_table,
    refuse_if,
    refuse_unknown,
    show,
    typed,
)
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.files import read_toml

_WALL_NAME = re.compile(r"[^\W\d_][\w-]*")
GIVEN = "given"
FIND = "find"
#: Axis and sign of the normal of walls by name, by dimension; a number is their place along the axis.
NAMED_WALLS: dict[int, dict[str, tuple[int, int]]] = {
    2: {"left": (0, 1), "right": (0, -1), "floor": (1, 1), "top": (1, -1)},
    3: {
        "left": (0, 1),
        "right": (0, -1),
        "front": (1, 1),
        "back": (1, -1),
        "floor": (2, 1),
        "top": (2, -1),
    },
}
_WALL_FORM = (
    "walls by name: the position (m) of left, right, floor, top (in space also front, back), or "
    "{point = [x, y], normal = [nx, ny]} under any name"
)
_NOISE_FORM = "a table of standard deviations above 0: strain, stress (Pa), acceleration (m/s^2), angular_acceleration"
#: Smallest and largest standard deviations: rounding of a measurement, and above the modulus of all
#: measured grains.
NOISE = {
    "strain": (1e-15, 1.0),
    "stress": (1e-6, 1e12),
    "acceleration": (1e-12, 1e12),
    "angular_acceleration": (1e-12, 1e15),
}

Place = (
    float | tuple[tuple[float, ...], tuple[float, ...]]
)  # along the axis of its name; or point and normal


@dataclasses.dataclass(frozen=True)
class WallsType(ValueType):
    """Type of a table of walls by name; some names imply the position of the wall."""

    kind: ClassVar[str] = "object"
    expected: str = _WALL_FORM

    def read(self, value: Any) -> tuple[tuple[str, Place], ...]:
        """Return the walls by name."""
        refuse_if(not isinstance(value, Mapping), self.expected)
        return tuple((name, self._place(name, place)) for name, place in value.items())

    def _place(self, name: str, value: Any) -> Place:
        """Return the place of a wall along its axis, or its point and unit normal."""
        if not isinstance(value, Mapping):
            refuse_if(name not in NAMED_WALLS[3], self.expected)
            return finite(value, self.expected)
        refuse_if(set(value) != {"point", "normal"}, self.expected)
        if not _WALL_NAME.fullmatch(name):
            raise ValidationError(
                "names of walls of letters, digits, _ and -, the first a letter (found "
                f"{show(name)}), since a number is the id of a grain in tables of forces"
            )
        point = _VECTOR.read(value["point"])
        normal = _VECTOR.read(value["normal"])
        size = math.hypot(*normal)
        refuse_if(
            len(point) != len(normal) or not size,
            f"{_WALL_FORM}; point and normal with the same number of components, the normal not "
            "zero",
        )
        return point, tuple(component / size for component in normal)

    @property
    def json(self) -> dict[str, Any]:
        """A table of numbers, and of tables with point and normal."""
        oblique = {
            "type": "object",
            "additionalProperties": False,
            "properties": {"point": _VECTOR.json, "normal": _VECTOR.json},
            "required": ["point", "normal"],
        }
        return {"type": "object", "additionalProperties": {"anyOf": [{"type": "number"}, oblique]}}


def _vector_type(form: str) -> ListType:
    """Make the type of a vector in the plane or in space."""
    return ListType(item=NumberType(form=form), expected=form, at_least=2, at_most=3)


_VECTOR = _vector_type(_WALL_FORM)
_GRAVITY = _vector_type("[gx, gy], in space [gx, gy, gz], in m/s^2")


@dataclasses.dataclass(frozen=True)
class NoiseType(ValueType):
    """Type of the table of standard deviations."""

    kind: ClassVar[str] = "object"
    expected: str = _NOISE_FORM

    def read(self, value: Any) -> Noise:
        """Return the standard deviations."""
        refuse_if(not isinstance(value, Mapping) or not set(value) <= set(NOISE), self.expected)
        sizes = {name: finite(size, self.expected) for name, size in value.items()}
        for name, size in sizes.items():
            low, high = NOISE[name]
            is_within = low <= size <= high
            refuse_if(not is_within, f"{self.expected}; {name} from {low:g} to {high:g}")
        return Noise(**sizes)

    @property
    def json(self) -> dict[str, Any]:
        """A table of positive numbers."""
        deviations = {
            name: {"type": "number", "minimum": low, "maximum": high}
            for name, (low, high) in NOISE.items()
        }
        return {"type": "object", "additionalProperties": False, "properties": deviations}


def _odd(n_frames: int) -> int:
    refuse_if(n_frames % 2 == 0, _WINDOW_FORM)
    return n_frames


_WINDOW_FORM = "an odd number of frames from 3 up"
_WINDOW = CountType(at_least=3, form=_WINDOW_FORM, finish=_odd)


@dataclasses.dataclass(frozen=True, kw_only=True)
class GrainMaterial:
    """``[material]``: density and elastic constants of the grains."""

    density: float = number("mass density", DENSITY, above=0)
    poisson_ratio: float = number(
        "Poisson's ratio; not used with measured stresses", above=-1, below=0.5, default=0.0
    )
    youngs_modulus: float | None = number(
        "Young's modulus; optional with measured stresses, and if infer.modulus determines it",
        YOUNGS_MODULUS,
        above=0,
        default=None,
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Infer:
    """``[infer]``: measurement of the grains, and unknowns of the inference."""

    state: Literal["plane-stress", "plane-strain", "space"] = choice(
        "relation of strains and stresses: cylinders with free faces (plane-stress) or fixed "
        "faces (plane-strain), or spheres (space)",
        STATES,
        default="plane-stress",
    )
    friction: float = number(
        "coefficient of friction between grains; an overestimate is safer than an underestimate",
        FRICTION,
        at_least=0,
        at_most=1e4,
    )
    wall_friction: float | None = number(
        "coefficient of friction of the walls; default: the coefficient of the grains",
        FRICTION,
        at_least=0,
        at_most=1e4,
        default=None,
    )
    thickness: float = number(
        "length of the cylinders; 1: forces are per metre of length", LENGTH, above=0, default=1.0
    )
    contact_tolerance: float = number(
        "largest gap of possible contacts, relative to the sum of the radii; use the error of "
        "the measured positions",
        at_least=0,
        at_most=0.5,
        default=1e-3,
    )
    walls: tuple[tuple[str, Place], ...] = typed(
        "straight walls", WallsType(), unit="m", default=()
    )
    gravity: tuple[float, ...] = typed(
        "acceleration of gravity", _GRAVITY, unit="m/s^2", default=()
    )
    noise: Noise | None = typed(
        "standard deviations of the measured values", NoiseType(), default=None
    )
    weights: Weights | None = choice(  # noqa: RUF009
        "weights of the equations: equal, by the standard deviation of each equation (white), "
        "or also by the correlation of the stress components calculated from strains "
        "(correlated); default: white if noise is given, otherwise equal",
        WEIGHTS,
        default=None,
    )
    modulus: str = choice(
        "Young's modulus: given, or determined from the accelerations", (GIVEN, FIND), default=GIVEN
    )
    repetitions: int = count(
        "repetitions with noise, for standard errors; 0: none",
        at_least=0,
        at_most=100_000,
        default=30,
    )
    ridge: float = number(
        "weight of the regularisation towards small forces, relative to the equations, if the "
        "equations do not determine all forces",
        at_least=0,
        at_most=1.0,
        default=0.0,
    )
    frame_rate: float | None = number(
        "frames per second of a series whose rows have a frame number instead of a time",
        "Hz",
        above=0,
        default=None,
    )
    window: int = typed(
        "number of frames in the parabolic fit for accelerations of a series; 3: second "
        "differences",
        _WINDOW,
        default=3,
    )
    time: float | None = number(
        "instant of a series (the nearest frame is used); default: all instants",
        TIME,
        default=None,
    )
    seed: int = count("seed of the noise of repetitions", at_least=0, default=1)

    @property
    def deviations(self) -> Noise:
        """Standard deviations of the measured quantities."""
        return self.noise or Noise()

    @property
    def finds_modulus(self) -> bool:
        """True if Young's modulus is to be found."""
        return self.modulus == FIND

    def friction_of(self, contacts: CandidateContacts) -> Array:
        """Return the coefficients of friction of contacts: (m,)."""
        friction = np.full(len(contacts), self.friction)
        if self.wall_friction is not None:
            friction[contacts.second < 0] = self.wall_friction
        return friction


@dataclasses.dataclass(frozen=True)
class InferCase:
    """Case of an inference.

    Attributes
    ----------
    source
        Name of the file, for messages.
    material
        None in a case for a run, whose material holds.
    """

    source: str
    material: GrainMaterial | None
    infer: Infer

    SECTIONS: ClassVar[dict[str, type]] = {"material": GrainMaterial, "infer": Infer}

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return 3 if self.infer.state == "space" else 2

    @property
    def walls(self) -> dict[str, StraightWall]:
        """Walls by name."""
        planes = {}
        for name, place in self.infer.walls:
            if isinstance(place, tuple):
                planes[name] = StraightWall(*place)
                continue
            axis, sign = NAMED_WALLS[self.dimension][name]
            unit = np.eye(self.dimension)[axis]
            planes[name] = StraightWall(
                tuple((place * unit).tolist()), tuple((sign * unit).tolist())
            )
        return planes

    @property
    def gravity(self) -> tuple[float, ...]:
        """Acceleration of gravity, m/s^2."""
        return self.infer.gravity or (0.0,) * self.dimension


def read_infer_case(path: str | Path, *, of_run: bool = False) -> InferCase:
    """Read a case of an inference.

    Parameters
    ----------
    of_run
        True for measurements of a run, whose material holds.

    Raises
    ------
    InputError
        The file cannot be read or is invalid; all faults are listed.
    """
    tables = read_toml(path)
    errors = ErrorList(str(path), vocabulary=keys_of(InferCase.SECTIONS))
    refuse_unknown(tables, ["name", *InferCase.SECTIONS], "", errors)
    material = None
    if "material" in tables:
        material = _material(tables["material"], errors)
    elif not of_run:
        errors.add(
            "material", "missing; expected [material] with density and poisson_ratio, or a preset"
        )
    infer = read_table(Infer, tables.get("infer", {}), "infer", errors)
    if infer is not None:
        _check(infer, errors)
    errors.report(Path(path).stem)
    assert infer is not None
    return InferCase(str(path), material, infer)


def _material(table: Any, errors: ErrorList) -> GrainMaterial | None:
    """Read the material: a name, a table with a preset, or density and elastic constants, of which
    some are optional.
    """
    if isinstance(table, Mapping) and "preset" not in table:
        own = {
            name: value
            for name, value in table.items()
            if name not in ("name", "source", "yield_strength")
        }
        return read_table(GrainMaterial, own, "material", errors)
    material: Material | None = read_material(table, errors)
    if material is None:
        return None
    return GrainMaterial(
        density=material.density,
        poisson_ratio=material.poisson_ratio,
        youngs_modulus=material.youngs_modulus,
    )


def _check(infer: Infer, errors: ErrorList) -> None:
    """Add errors for keys that exclude one another."""
    dimension = 3 if infer.state == "space" else 2
    walls = dict(infer.walls)
    for name, place in walls.items():
        if isinstance(place, tuple) and len(place[0]) != dimension:
            errors.add(
                f"infer.walls.{name}",
                Mismatch(f"{len(place[0])} numbers", f"{dimension} for {infer.state}"),
            )
        elif not isinstance(place, tuple) and name not in NAMED_WALLS[dimension]:
            errors.add(
                f"infer.walls.{name}",
                Mismatch(f"this key in {infer.state}", 'this key only with state = "space"'),
            )
    for first, second in (("left", "right"), ("floor", "top"), ("front", "back")):
        low = walls.get(first)
        high = walls.get(second)
        if isinstance(low, float) and isinstance(high, float) and low >= high:
            errors.add(
                f"infer.walls.{first}",
                Mismatch(f"{low:g} m", f"a value below {second}, {high:g} m"),
            )
    if infer.gravity and len(infer.gravity) != dimension:
        errors.add(
            "infer.gravity",
            Mismatch(show(list(infer.gravity)), f"{dimension} numbers for {infer.state}"),
        )
