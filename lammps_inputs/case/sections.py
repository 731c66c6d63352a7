"""The tables of a case file: typed, frozen, with a description, a unit and a default for every key."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping
from itertools import pairwise
from typing import Any, Literal

from granwave import _contact_laws
from granwave.lammps_inputs.case.loss import Loss, parse_loss
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import (
    LARGEST_COUNT,
    ValidationError,
    choice,
    custom,
    finite,
    number,
    parse_point,
    positive_or_auto,
    whole,
)
from granwave.lammps_inputs.case.si_values import (
    ACCELERATION,
    DIAMETER,
    DISPLACEMENT,
    FORCE,
    FRICTION,
    INTERVAL,
    PRESSURE,
    TIME,
)
from granwave.lammps_inputs.case.supports import Support
from granwave.lammps_inputs.case.yield_factor import DEFAULT_YIELD_FACTOR

BOTTOMS = ("wall", "fixed", "free", "periodic")
ALL_LAWS = _contact_laws.LAWS  # contact laws of the plugin, by name
LAWS = {name: law for name, law in ALL_LAWS.items() if not law.is_power}  # those of two materials
NO_FORCE = "none"  # law of materials whose grains do not touch each other
LINES = ("half-space", "plane-strain")
LINE = "line"  # law of crystals of cylinders alone: Hertz's, with lines in plane strain
LAW_CONSTANTS = tuple(_contact_laws.LAW_CONSTANTS)  # names of the constants of the elasto-plastic law
AUTO_END_TIME = 5e-3  # s, upper limit of `end_time = "auto"`
ENERGY_TOLERANCE = 3e-6  # default of `run.energy_tolerance`
LEAST_ENERGY_TOLERANCE = 1e-10  # rounding errors are some 1e-12 of the input
DEFAULT_FRAMES = 20  # default of `run.frames`; a run of fewer steps has fewer
_CONSTANT: dict[str, Any] = {"above": 0, "default": None}
_MOVE: dict[str, Any] = {"unit": "m", "above": 0, "default": None, "usual": DISPLACEMENT}
_PRESS: dict[str, Any] = {"unit": "N", "above": 0, "default": None, "usual": FORCE}
_WALLS = ("x", "y", "tube")
LARGEST_ID = LARGEST_COUNT
_SHARE = re.compile(r"(\d+(?:\.\d+)?) ?%")
_NO_LIMIT = 2**63 - 1  # the schedule limits the number to that of the steps


def _parse_frames(value: Any) -> int | tuple[float, ...] | tuple[str, ...]:
    expected = (
        'how many snapshots (from 1 up), or a list of rising times, all in s or all shares of run.end_time ("25 %")'
    )
    if not isinstance(value, list | tuple):
        return whole(value, expected, at_most=_NO_LIMIT)
    words = [one for one in value if isinstance(one, str)]
    if words and len(words) != len(value):
        raise ValidationError(expected)
    times = tuple(parse_share(word, expected) for word in words) or tuple(finite(time, expected) for time in value)
    if not times or times[0] < 0 or any(later <= earlier for earlier, later in pairwise(times)):
        raise ValidationError(expected)
    return tuple(words) or times


def parse_share(text: str, expected: str) -> float:
    """Convert a share such as ``"25 %"`` to 0.25; raise `ValidationError` if it is none from 0 to 100 %."""
    if not (found := _SHARE.fullmatch(text)) or float(found[1]) > 100:
        raise ValidationError(expected)
    return float(found[1]) / 100


_DENT_FORM = (
    "a number in m, the path of a result.h5, or tables {overlap = ...} or {force = ...} with low and high = [x, y, z]"
)


def _parse_dents(value: Any) -> float | str | tuple[Dents, ...]:
    if isinstance(value, str) and value:
        return value
    if isinstance(value, Mapping | list | tuple):
        tables = [value] if isinstance(value, Mapping) else value
        if not tables:
            raise ValidationError(_DENT_FORM)
        return tuple(_parse_dent(table) for table in tables)
    size = finite(value, _DENT_FORM)
    if size < 0:
        raise ValidationError(f"{_DENT_FORM}, not negative")
    return size


def _parse_dent(table: Any) -> Dents:
    known = {"overlap", "force", "low", "high"}
    if not isinstance(table, Mapping) or not set(table) <= known or ("overlap" in table) == ("force" in table):
        raise ValidationError(_DENT_FORM)
    size = finite(table.get("overlap", table.get("force")), _DENT_FORM)
    if size < 0:
        raise ValidationError(f"{_DENT_FORM}, not negative")
    low, high = (parse_point(table[name], _DENT_FORM) if name in table else None for name in ("low", "high"))
    if low is not None and high is not None and any(a > b for a, b in zip(low, high, strict=True)):
        raise ValidationError("low of a box of dents below its high, along each axis")
    return Dents(overlap=size, low=low, high=high) if "overlap" in table else Dents(force=size, low=low, high=high)


def _parse_history(value: Any) -> int | str:
    expected = 'a whole number from 0 up or "auto"'
    return value if value == "auto" else whole(value, expected, at_least=0, at_most=_NO_LIMIT)


def _parse_probes(value: Any) -> tuple[Probe, ...]:
    if not isinstance(value, list | tuple):
        raise ValidationError(_PROBE_FORM)
    return tuple(_parse_probe(probe) for probe in value)


def _parse_parts(value: Any) -> bool | str:
    if value == "auto" or isinstance(value, bool):
        return value
    raise ValidationError('true, false or "auto"')


_PROBE_FORM = "a list such as [{sphere = 12}, {contact = [12, 34]}]"


def _parse_probe(value: Any) -> Probe:
    if not isinstance(value, Mapping) or len(value) != 1:
        raise ValidationError(_PROBE_FORM)
    ((what, which),) = value.items()
    expected = f"{_PROBE_FORM} with ids from 1 up"
    if what == "sphere":
        return Probe(sphere=whole(which, expected))
    if what == "contact" and isinstance(which, list | tuple) and len(which) == 2:
        first, second = (whole(sphere, expected) for sphere in which)
        return Probe(contact=(first, second))
    raise ValidationError(_PROBE_FORM)


@dataclasses.dataclass(frozen=True)
class Probe:
    """Probe of one sphere or of the contact of two, recorded at its own rate."""

    sphere: int | None = None
    contact: tuple[int, int] | None = None

    @property
    def spheres(self) -> tuple[int, ...]:
        """Ids of its sphere or spheres."""
        return self.contact if self.contact is not None else (self.sphere or 0,)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dents:
    """Initial dents of the contacts in a box, given by the largest earlier overlap (m) or force (N)."""

    overlap: float | None = None
    force: float | None = None
    low: tuple[float, float, float] | None = None
    high: tuple[float, float, float] | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Contact:
    """``[contact]``: contact law and friction."""

    law: str = choice(
        'contact law; "line" is "hertz" with line = "plane-strain", for cylinders alone',
        (*ALL_LAWS, LINE),
        default="elastoplastic",
    )
    variant: Literal["continuous", "published"] = choice(
        "constants of the elasto-plastic law: made continuous, or as printed",
        ("continuous", "published"),
        default="continuous",
    )
    yield_factor: float = number(
        "C = p_y / sigma_y, contact pressure at first yield", at_least=0.1, at_most=10, default=DEFAULT_YIELD_FACTOR
    )
    constant: float | None = number("law power: K of F = K overlap^p, N/m^p", above=0, default=None)
    exponent: float | None = number("law power: p", at_least=1, default=None)
    line: str = choice(
        "contact along a line, of a cylinder on a plane or beside another: with bodies that give way over its length "
        "(half-space), or in plane strain",
        LINES,
        default="half-space",
    )
    beta: float = number("bilinear law: residual overlap over the largest overlap", at_least=0, below=1, default=0.8)
    friction: float = number(
        "coefficient of Coulomb friction between spheres", at_least=0, at_most=1e4, default=0.0, usual=FRICTION
    )
    tangential: Literal["mindlin_rescale", "mindlin"] = choice(
        "spring of friction where its circle shrinks: force scaled down with it, or kept, which can create energy",
        ("mindlin_rescale", "mindlin"),
        default="mindlin_rescale",
    )
    loss: Loss | None = custom(  # noqa: RUF009
        "loss by the rate of the overlap: by a time, by the restitution at a velocity, or by a dashpot (Tsuji)",
        parse_loss,
        default=None,
    )
    initial_overlap: float | str | tuple[Dents, ...] = custom(
        "largest overlap that the contacts had before the run, their dents: a value, values by region, or an earlier "
        "run's result.h5",
        _parse_dents,
        unit="m",
        default=0.0,
    )

    # Constants of the elasto-plastic law, for materials whose curve differs from the published one (None: published).
    # a = alpha/alpha_y; pressure in units of sigma_y, area in units of pi R* alpha_y.
    pressure_limit: float | None = number("c1 of p = c1 - (c1 - 2C/3) exp(-c2 (a-1)); 2.48 (thesis 2.8)", **_CONSTANT)
    pressure_rate: float | None = number("c2 of the same; 0.098 (thesis 2.8)", at_least=1e-4, at_most=10, default=None)
    area_switch: float | None = number(
        "a from which the area is A = c4 a - c5, a power of a below; 177.6 (thesis 2.10)", above=1, default=None
    )
    area_slope: float | None = number("c4 of the area; 2.37 (thesis 2.10)", **_CONSTANT)
    area_offset: float | None = number("c5 of the area; 59.96 (thesis 2.10)", default=None)
    residual_slope: float | None = number(
        "c6 of a_R = c6 a_max - c7 + (c7 - c6) exp(-c8 (a_max - 1)); 0.95 (thesis 2.13)", **_CONSTANT
    )
    residual_offset: float | None = number("c7 of the same; 25.94 (thesis 2.13)", default=None)
    residual_rate: float | None = number("c8 of the same; 0.015 (thesis 2.13)", **_CONSTANT)
    unloading_exponent: float | None = number(
        "n of f = f_max ((a - a_R)/(a_max - a_R))^n; 1.35 (thesis 2.12)", at_least=1, default=None
    )

    def __post_init__(self) -> None:
        """Take the law of lines for what it is."""
        if self.law == LINE:
            object.__setattr__(self, "law", "hertz")
            object.__setattr__(self, "line", "plane-strain")

    @property
    def constants(self) -> dict[str, float]:
        """Constants of the elasto-plastic law that the case gives, by name."""
        given = {name: getattr(self, name) for name in LAW_CONSTANTS}
        return {name: value for name, value in given.items() if value is not None}

    @property
    def entry(self) -> _contact_laws.LawEntry:
        """Entry of the law in the plugin's table."""
        return ALL_LAWS[self.law]

    @property
    def yields(self) -> bool:
        """True if the law needs a yield strength."""
        return bool(self.entry.yields)

    def takes(self, option: str) -> bool:
        """Return True if the law has an option: such as ``variant``, ``yield_factor`` or ``beta``."""
        return option in self.entry.options


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tube:
    """``[boundary.sides.tube]``: a tube around the axis x = y = 0 of the packing."""

    radius: float = number("inner radius of the tube, before it shrinks", unit="m", above=0, usual=DIAMETER)


@dataclasses.dataclass(frozen=True)
class Touched:
    """Grains that side walls act on: those of these materials, and those of these groups."""

    material: tuple[str, ...] = ()
    group: tuple[str, ...] = ()


_TOUCHED = 'a table such as {group = "cylinders"} or {material = ["aluminium", "steel"]}'


def _parse_touched(value: Any) -> Touched:
    if not isinstance(value, Mapping) or not value or set(value) - {"material", "group"}:
        raise ValidationError(_TOUCHED)
    found = {name: tuple([names] if isinstance(names, str) else names) for name, names in value.items()
             if isinstance(names, str | list | tuple)}  # fmt: skip
    if len(found) < len(value) or not all(isinstance(one, str) and one for names in found.values() for one in names):
        raise ValidationError(_TOUCHED)
    return Touched(**found)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Boundary:
    """``[boundary]``: bottom and sides of the packing; the struck top is always free."""

    bottom: Literal["wall", "fixed", "free", "periodic"] = choice(
        "what is below the last layer: a plane, the layer held in place, nothing, or (for bands) the packing again",
        BOTTOMS,
        default="wall",
    )
    bottom_material: Material | None = None  # of the bottom plane: bottom = {material = ...}; None: rigid
    sides: Literal["free", "wall", "periodic"] = choice(
        "what is at the sides: nothing, planes, or the packing again",
        ("free", "wall", "periodic"),
        default="free",
    )
    x: Literal["free", "wall"] | None = choice(
        "the two planes across x, where they differ from sides", ("free", "wall"), default=None
    )
    y: Literal["free", "wall"] | None = choice(
        "the two planes across y, where they differ from sides", ("free", "wall"), default=None
    )
    side_gap: float | None = number(
        "gap between the side walls and the outermost spheres, none by default; negative: the walls press by as much "
        "before the run, as [precompression] of walls does",
        unit="m",
        default=None,
        usual=DISPLACEMENT,
    )
    sides_touch: Touched | None = custom(  # noqa: RUF009
        "materials or groups of the grains that the side walls act on, and whose outermost ones the planes touch; left "
        "out: all",
        _parse_touched,
        default=None,
    )
    sides_tube: float | None = None  # radius of a tube around the axis x = y = 0, m: sides = {tube = {radius = ...}}
    bottom_support: Support | None = None  # of a moving bottom plane: plate, damper, half_space or bar = {...}
    sides_material: Material | None = None  # of all side planes: sides = {material = ...}; None: rigid
    friction: float | None = number(
        "coefficient of Coulomb friction of the walls; that of the contacts by default",
        at_least=0,
        at_most=1e4,
        default=None,
        usual=FRICTION,
    )
    holder_friction: float | None = number(
        "coefficient of Coulomb friction between a level chain and its holder, which bears the weight of the beads",
        at_least=0,
        at_most=1e4,
        default=None,
        usual=FRICTION,
    )
    forget_gap: float = number(
        "gap beyond which a dent is forgotten, never sooner",
        unit="diameters",
        above=0,
        at_most=2,
        default=0.1,
    )

    @property
    def gap(self) -> float:
        """Gap between the side walls and the packing, m; negative: they press."""
        return self.side_gap or 0.0

    def has_planes(self, axis: str) -> bool:
        """True if there are planes across x or y."""
        return (getattr(self, axis) or self.sides) == "wall" and self.sides_tube is None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Precompression:
    """``[precompression]``: a static load, applied before the impact and kept during it."""

    kind: Literal["uniaxial", "uniform", "gravity", "walls", "overlaps"] = choice(
        "a load along z on the top layer, the same pressure on all free faces, the spheres' weight along +z, walls "
        "that are moved in and then held, or nothing but the overlaps of grains at the start",
        ("uniaxial", "uniform", "gravity", "walls", "overlaps"),
    )
    pressure: float | None = number(
        "pressure on the faces of the packing", unit="Pa", above=0, default=None, usual=PRESSURE
    )
    force: float | None = number(
        "force on each sphere of the top layer (uniaxial; also beside walls)",
        unit="N",
        above=0,
        default=None,
        usual=FORCE,
    )
    x: float | None = number("distance by which each of the planes across x moves in", **_MOVE)
    y: float | None = number("distance by which each of the planes across y moves in", **_MOVE)
    tube: float | None = number("distance by which the tube's radius shrinks", **_MOVE)
    x_force: float | None = number("force to which each of the planes across x is moved in", **_PRESS)
    y_force: float | None = number("force to which each of the planes across y is moved in", **_PRESS)
    tube_force: float | None = number("force outward on the whole tube to which it shrinks", **_PRESS)
    overlaps: bool | None = choice(
        "true: overlaps of grains at the start are part of it; else they are refused", (True, False), default=None
    )
    acceleration: float = number("acceleration of gravity", unit="m/s^2", above=0, default=9.81, usual=ACCELERATION)

    @property
    def moves(self) -> dict[str, float]:
        """Distances by which walls move in, by x, y or tube, m."""
        found = {name: getattr(self, name) for name in _WALLS}
        return {name: distance for name, distance in found.items() if distance is not None}

    @property
    def presses(self) -> dict[str, float]:
        """Forces to which walls move in, by x, y or tube, N."""
        found = {name: getattr(self, f"{name}_force") for name in _WALLS}
        return {name: force for name, force in found.items() if force is not None}

    @property
    def moves_walls(self) -> bool:
        """True if there is no dead load but, perhaps, a force on the top."""
        return self.kind in ("walls", "overlaps")

    @property
    def takes_overlaps(self) -> bool:
        """True if overlaps of grains at the start are part of the load."""
        return bool(self.overlaps) or self.kind == "overlaps"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Run:
    """``[run]``: end time, timestep and snapshots."""

    end_time: float | Literal["auto"] = positive_or_auto(
        "when the run ends; auto: when 50 us add less than 1e-4 of the input to dissipation, at most 5 ms",
        unit="s",
        usual=TIME,
        default=1e-3,
    )
    timestep: float | Literal["auto"] = positive_or_auto(
        "auto: follows the error of the energy balance; a number: all steps are that long",
        unit="s",
        usual=INTERVAL,
    )
    energy_tolerance: float = number(
        "largest error of the energy balance, over the input, that an automatic timestep aims at",
        at_least=LEAST_ENERGY_TOLERANCE,
        at_most=1e-3,
        default=ENERGY_TOLERANCE,
    )
    smallest_timestep: float | Literal["auto"] = positive_or_auto(
        "lower bound of an automatic timestep; auto: a quarter of that for the stiffest contact expected",
        unit="s",
        usual=INTERVAL,
    )
    largest_timestep: float | Literal["auto"] = positive_or_auto(
        "upper bound of an automatic timestep; auto: eight times that for the stiffest contact expected",
        unit="s",
        usual=INTERVAL,
    )
    frames: int | tuple[float, ...] | tuple[str, ...] = custom(
        "snapshots, the start and the end among them: how many, or the times", _parse_frames, default=DEFAULT_FRAMES
    )

    @property
    def frame_times(self) -> tuple[float, ...] | None:
        """Times of the snapshots, s, shares of the end time among them; None if only their number is given."""
        if isinstance(self.frames, int):
            return None
        return tuple(
            parse_share(time, "a share") * self.longest if isinstance(time, str) else time for time in self.frames
        )

    @property
    def adaptive(self) -> bool:
        """The timestep follows the error of the energy balance."""
        return isinstance(self.timestep, str)

    @property
    def longest(self) -> float:
        """Latest time that the run can reach, s."""
        return AUTO_END_TIME if isinstance(self.end_time, str) else self.end_time


@dataclasses.dataclass(frozen=True, kw_only=True)
class Output:
    """``[output]``: form of the snapshots, and records besides snapshots and energies."""

    dump_format: Literal["binary", "text"] = choice(
        "form of the dump of snapshots: binary is written and read ten times as fast, text is read by every program",
        ("binary", "text"),
        default="binary",
    )
    probes: tuple[Probe, ...] = custom("spheres and contacts recorded at their own rate", _parse_probes, default=())
    probe_interval: float | Literal["auto"] = positive_or_auto(
        "time between records of probes and walls; auto: five timesteps",
        unit="s",
        usual=INTERVAL,
    )
    history: int | Literal["auto"] = custom(
        "instants at which the velocity of every bead of a chain and the force of every contact are recorded; "
        "auto: 1000 (fewer with long bars) for chains of five beads and more; the same for each [[line]], auto: 2000",
        _parse_history,
        default="auto",
    )
    contact_forces: bool = choice(
        "forces of all contacts at every snapshot, with forces and spins of the spheres; for granwave infer",
        (False, True),
        default=False,
    )
    parts: bool | Literal["auto"] = custom(
        "files of snapshots and contacts, one from each rank instead of one from all; auto: from 10 million spheres on",
        _parse_parts,
        default="auto",
    )
