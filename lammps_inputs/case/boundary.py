"""``[boundary]`` and ``[precompression]``: bottom, sides and static load of a packing.

Supports of a moving bottom plane: ``boundary.bottom = {plate = {...}}``, ``damper``, ``half_space`` or ``bar``.

plate        a rigid plate on a spring and an optional damper
damper       a massless plate on a damper, which bears the static force: an end that absorbs waves
half_space   the surface of an elastic half-space under the packing's footprint: Lysmer's analogue, a spring
             4 G r/(1 - nu) parallel to a damper 3.4 r^2 sqrt(rho G)/(1 - nu) (Lysmer and Richart, 1966)
bar          an elastic bar along z, of linear elements with lumped mass; its far end free, fixed or non-reflecting
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.material import Material, read_material
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, read_table, refuse_unknown, show

_SPRING = 4.0  # K (1 - nu) / (G r) of a rigid disc on a half-space, exact in statics
_DAMPER = 3.4  # C (1 - nu) / (r^2 sqrt(rho G)) (Lysmer and Richart, 1966)
BAR_COURANT_NUMBER = 0.5  # timestep over the time that a wave takes through one element of a bar
PLATE_OSCILLATION = 0.05  # timestep over sqrt(mass/stiffness), of a plate or the first element of a bar
_OF_DECAY = 0.05  # timestep over damping/stiffness of a massless surface


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plate:
    """Rigid plate on a spring and a damper."""

    mass: float = schema.number("mass of the plate", hints.MASS, above=0)
    stiffness: float = schema.number("stiffness of the spring between plate and ground", "N/m", above=0)
    damping: float = schema.number("constant of the damper beside the spring", "N s/m", at_least=0, default=0.0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Damper:
    """Plate without mass on a damper; the ground bears the force that is on it when the run begins."""

    damping: float = schema.number(
        "force on the ground, beyond the static one, over the velocity of the plate", "N s/m", above=0
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class HalfSpace:
    """Surface of an elastic half-space under the packing, moving as a rigid disc."""

    radius: float | None = schema.number(
        "radius of the disc that moves; that of the packing's footprint by default", hints.LENGTH, above=0, default=None
    )

    def stiffness(self, material: Material, radius: float) -> float:
        """Return the stiffness of a rigid disc of this radius (m) on the half-space, N/m."""
        return _SPRING * _shear_modulus(material) * radius / (1 - material.poisson_ratio)

    def damping(self, material: Material, radius: float) -> float:
        """Return the radiation damping, N s/m."""
        return (
            _DAMPER * radius**2 * math.sqrt(material.density * _shear_modulus(material)) / (1 - material.poisson_ratio)
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class SupportBar:
    """Elastic bar under the whole packing."""

    length: float = schema.number("length of the bar", hints.LENGTH, above=0)
    area: float = schema.number("area of its cross-section", hints.AREA, above=0)
    elements: int = schema.count("number of elements of equal length", at_most=10_000_000, default=200)
    end: str = schema.choice(
        "far end: free, fixed, or going on without an echo", ("free", "fixed", "infinite"), default="infinite"
    )

    def mass(self, material: Material) -> float:
        """Return the mass of the whole bar, kg."""
        return material.density * self.area * self.length

    def stiffness(self, material: Material) -> float:
        """Return the stiffness of an element, N/m."""
        return material.youngs_modulus * self.area * self.elements / self.length


@dataclasses.dataclass(frozen=True)
class Backing:
    """Support behind a plane, along its normal: a node on a spring and a damper, or a bar of lumped masses.

    Attributes
    ----------
    mass
        Mass of the node, 0 for a surface without inertia, or of the whole bar, kg.
    stiffness
        Stiffness of the spring, or of an element of the bar, N/m.
    damping
        Damping constant, N s/m.
    elements
        Number of elements of a bar; 0 for a node.
    end
        Far end of a bar: ``free``, ``fixed``, or the impedance of a non-reflecting end, N s/m.
    """

    mass: float
    stiffness: float
    damping: float = 0.0
    elements: int = 0
    end: float | str = "free"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Support:
    """Support of the bottom plane: exactly one of plate, damper, half-space and bar."""

    plate: Plate | None = None
    damper: Damper | None = None
    half_space: HalfSpace | None = None
    bar: SupportBar | None = None

    @property
    def kind(self) -> str:
        """Name of the support, as in the case file."""
        return next(name for name in SUPPORTS if getattr(self, name))

    @property
    def bears(self) -> bool:
        """True if the support can bear a static load, by a spring to the ground or as a damper."""
        return self.bar is None or self.bar.end == "fixed"

    def backing(self, material: Material | None, footprint: float) -> Backing:
        """Return the mass, stiffness and damping behind the plane.

        Parameters
        ----------
        material
            Material of the surface; a plate and a damper need none.
        footprint
            Radius of the packing's footprint, m.
        """
        if self.plate:
            return Backing(self.plate.mass, self.plate.stiffness, self.plate.damping)
        if self.damper:
            return Backing(0.0, 0.0, self.damper.damping)
        assert material is not None
        if self.half_space:
            radius = self.half_space.radius or footprint
            return Backing(0.0, self.half_space.stiffness(material, radius), self.half_space.damping(material, radius))
        assert self.bar is not None
        impedance = self.bar.area * math.sqrt(material.youngs_modulus * material.density)
        end = impedance if self.bar.end == "infinite" else self.bar.end
        return Backing(self.bar.mass(material), self.bar.stiffness(material), elements=self.bar.elements, end=end)

    def longest_timestep(self, material: Material | None, footprint: float, contacts: float) -> float:
        """Return the longest timestep that resolves the motion of the support, s.

        Parameters
        ----------
        material, footprint
            As in `backing`.
        contacts
            Sum of the stiffnesses of all contacts with the plane, N/m.
        """
        behind = self.backing(material, footprint)
        if not behind.mass:
            return _OF_DECAY * behind.damping / contacts
        front = behind.mass / behind.elements / 2 if behind.elements else behind.mass
        oscillation = PLATE_OSCILLATION * math.sqrt(front / (behind.stiffness + contacts))
        if self.bar is None or material is None:
            return oscillation
        element = self.bar.length / self.bar.elements
        return min(BAR_COURANT_NUMBER * element * math.sqrt(material.density / material.youngs_modulus), oscillation)


_BEARS_ITSELF = ("plate", "damper", "tube")  # need no material
SUPPORTS: dict[str, type] = {"plate": Plate, "damper": Damper, "half_space": HalfSpace, "bar": SupportBar}


def _shear_modulus(material: Material) -> float:
    return material.youngs_modulus / (2 * (1 + material.poisson_ratio))


BOTTOMS = ("wall", "fixed", "free", "periodic")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tube:
    """``[boundary.sides.tube]``: a tube around the axis x = y = 0 of the packing."""

    radius: float = schema.number("inner radius of the tube, before it shrinks", hints.DIAMETER, above=0)


@dataclasses.dataclass(frozen=True)
class Touched:
    """Grains that side walls act on: those of these materials, and those of these groups."""

    material: tuple[str, ...] = ()
    group: tuple[str, ...] = ()


_TOUCHED = 'a table such as {group = "cylinders"} or {material = ["aluminium", "steel"]}'


def _parse_touched(value: Any) -> Touched:
    schema.refuse_if(not isinstance(value, Mapping) or not value or set(value) - {"material", "group"}, _TOUCHED)
    found = {name: tuple([names] if isinstance(names, str) else names) for name, names in value.items()
             if isinstance(names, str | list | tuple)}  # fmt: skip
    if len(found) < len(value) or not all(isinstance(one, str) and one for names in found.values() for one in names):
        raise ValidationError(_TOUCHED)
    return Touched(**found)


_FRICTION: dict[str, Any] = {"at_least": 0, "at_most": 1e4, "default": None, "unit": hints.FRICTION}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Boundary:
    """``[boundary]``: bottom and sides of the packing; the struck top is always free."""

    bottom: str = schema.choice(
        "what is below the last layer: a plane, the layer held in place, nothing, or (for bands) the packing again",
        BOTTOMS,
        default="wall",
    )
    bottom_material: Material | None = None  # of the bottom plane: bottom = {material = ...}; None: rigid
    sides: str = schema.choice(
        "what is at the sides: nothing, planes, or the packing again", ("free", "wall", "periodic"), default="free"
    )
    x: str | None = schema.choice(
        "the two planes across x, where they differ from sides", ("free", "wall"), default=None
    )
    y: str | None = schema.choice(
        "the two planes across y, where they differ from sides", ("free", "wall"), default=None
    )
    side_gap: float | None = schema.number(
        "gap between the side walls and the outermost spheres, none by default; negative: the walls press by as much "
        "before the run, as [precompression] of walls does",
        hints.DISPLACEMENT,
        default=None,
    )
    sides_touch: Touched | None = schema.custom(
        "materials or groups of the grains that the side walls act on, and whose outermost ones the planes touch; left "
        "out: all",
        _parse_touched,
        default=None,
    )
    sides_tube: float | None = None  # radius of a tube around the axis x = y = 0, m: sides = {tube = {radius = ...}}
    bottom_support: Support | None = None  # of a moving bottom plane: plate, damper, half_space or bar = {...}
    sides_material: Material | None = None  # of all side planes: sides = {material = ...}; None: rigid
    friction: float | None = schema.number(
        "coefficient of Coulomb friction of the walls; that of the contacts by default", **_FRICTION
    )
    holder_friction: float | None = schema.number(
        "coefficient of Coulomb friction between a level chain and its holder, which bears the weight of the beads",
        **_FRICTION,
    )
    forget_gap: float = schema.number(
        "gap beyond which a dent is forgotten, never sooner", "diameters", above=0, at_most=2, default=0.1
    )

    @property
    def gap(self) -> float:
        """Gap between the side walls and the packing, m; negative: they press."""
        return self.side_gap or 0.0

    def has_planes(self, axis: str) -> bool:
        """True if there are planes across x or y."""
        return (getattr(self, axis) or self.sides) == "wall" and self.sides_tube is None


def read_boundary(table: Any, errors: ErrorList) -> Boundary | None:
    """Read ``[boundary]``, with the tables that may stand for a wall; faults are added to ``errors``."""
    before, read = len(errors.lines), dict[str, Any]()
    if isinstance(table, Mapping):
        for name, sections, forms in (
            ("bottom", SUPPORTS, f', {{material = "..."}}, or one of {", ".join(SUPPORTS)}'),
            ("sides", {"tube": Tube}, ', or {material = "..."} for a wall'),
        ):
            if isinstance(table.get(name), Mapping):
                found = _read_wall(table[name], f"boundary.{name}", sections, f"a word{forms}", errors)
                read |= {f"{name}_{what}": value for what, value in found.items()}
                table = {**table, name: "wall"}
    boundary = read_table(Boundary, table, "boundary", errors)
    return None if boundary is None or len(errors.lines) > before else dataclasses.replace(boundary, **read)


def _read_wall(
    table: Mapping[str, Any], key: str, sections: Mapping[str, type], expected: str, errors: ErrorList
) -> dict[str, Any]:
    """Read the material of a wall, and its support or the radius of its tube."""
    refuse_unknown(table, ("material", *sections), key, errors)
    chosen = [name for name in sections if name in table]
    errors.check(
        (not table, key, f"found {show(table)}, expected {expected}"),
        (len(chosen) > 1, key, f"found {' and '.join(chosen)}, expected one of them"),
    )
    if len(chosen) > 1:
        return {}
    found: dict[str, Any] = {}
    if "material" in table:
        found["material"] = read_material(table["material"], errors, f"{key}.material")
    for name in chosen:
        if "material" not in table and name not in _BEARS_ITSELF:
            errors.add(f"{key}.material", f"missing; a {name} needs it")
        section = read_table(sections[name], table[name], f"{key}.{name}", errors)
        if isinstance(section, Tube):
            found["tube"] = section.radius
        elif section is not None:
            found["support"] = Support(**{name: section})
    return found


_NONE: dict[str, Any] = {"above": 0, "default": None}
_MOVE = _NONE | {"unit": hints.DISPLACEMENT}
_PRESS = _NONE | {"unit": hints.FORCE}
_WALLS = ("x", "y", "tube")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Precompression:
    """``[precompression]``: a static load, applied before the impact and kept during it."""

    kind: str = schema.choice(
        "a load along z on the top layer, the same pressure on all free faces, the spheres' weight along +z, walls "
        "that are moved in and then held, or nothing but the overlaps of grains at the start",
        ("uniaxial", "uniform", "gravity", "walls", "overlaps"),
    )
    pressure: float | None = schema.number("pressure on the faces of the packing", hints.PRESSURE, **_NONE)
    force: float | None = schema.number("force on each sphere of the top layer (uniaxial; also beside walls)", **_PRESS)
    x: float | None = schema.number("distance by which each of the planes across x moves in", **_MOVE)
    y: float | None = schema.number("distance by which each of the planes across y moves in", **_MOVE)
    tube: float | None = schema.number("distance by which the tube's radius shrinks", **_MOVE)
    x_force: float | None = schema.number("force to which each of the planes across x is moved in", **_PRESS)
    y_force: float | None = schema.number("force to which each of the planes across y is moved in", **_PRESS)
    tube_force: float | None = schema.number("force outward on the whole tube to which it shrinks", **_PRESS)
    overlaps: bool | None = schema.choice(
        "true: overlaps of grains at the start are part of it; else they are refused", (True, False), default=None
    )
    acceleration: float = schema.number("acceleration of gravity", hints.ACCELERATION, above=0, default=9.81)

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
