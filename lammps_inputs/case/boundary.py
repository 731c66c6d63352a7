"""``[boundary]`` and ``[precompression]``: bottom, sides and static load of a packing.

Supports of a moving bottom plane: ``boundary.bottom = {plate = {...}}``, ``damper``, ``half_space``
or ``bar``.

plate        a rigid plate on a spring and an optional damper
damper       a massless plate on a damper, which bears the static force: an end that absorbs waves
half_space   the surface of an elastic half-space under the packing's footprint: Lysmer's analogue, a spring
             4 G r/(1 - nu) parallel to a damper 3.4 r^2 sqrt(rho G)/(1 - nu) (Lysmer and Richart,
             1966)
bar          an elastic bar along z, of linear elements with lumped mass; its far end free, fixed or non-reflecting
"""

from __future__ import annotations

import abc
import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.material import MATERIAL, Material, read_material
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    read_table,
    refuse_unknown,
)

_SPRING = 4.0  # K (1 - nu) / (G r) of a rigid disc on a half-space, exact in statics
_DAMPER = 3.4  # C (1 - nu) / (r^2 sqrt(rho G)) (Lysmer and Richart, 1966)
BAR_COURANT_NUMBER = 0.5  # timestep over the time that a wave takes through one element of a bar
# timestep over sqrt(mass/stiffness), of a plate or the first element of a bar
PLATE_OSCILLATION = 0.05
_OF_DECAY = 0.05  # timestep over damping/stiffness of a massless surface


@dataclasses.dataclass(frozen=True)
class Backing:
    """Support behind a plane, along its normal: a node on a spring and a damper, or a bar of lumped
    masses.

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

    def longest_timestep(self, contacts: float) -> float:
        """Return the longest timestep that resolves its motion under contacts of this stiffness in
        sum (N/m), s.
        """
        if not self.mass:
            return _OF_DECAY * self.damping / contacts
        front = self.mass / self.elements / 2 if self.elements else self.mass
        return PLATE_OSCILLATION * math.sqrt(front / (self.stiffness + contacts))

    def moved_mass(self, grain: float, stiffness: float) -> float:
        """Return the mass with which the support resists a contact, kg, as in the wall fix.

        A plate or a free bar counts with its mass, and the spring and damper of a plate as at the
        frequency of the grain on a plane at rest. A surface without mass and a bar whose end is
        fixed or does not reflect belong to the ground: the mass is infinite.

        Parameters
        ----------
        grain
            Mass of the grain, kg.
        stiffness
            Stiffness of the contact, N/m.
        """
        if not self.mass:
            return math.inf
        if self.elements:
            return self.mass if self.end == "free" else math.inf
        slowness = grain / stiffness  # of the square of the angular frequency
        return self.mass + self.damping * math.sqrt(slowness) + self.stiffness * slowness


class Support(abc.ABC):
    """Support of the bottom plane: plate, damper, half-space or bar.

    Attributes
    ----------
    kind
        Its name in the case file.
    bears
        True if it can bear a static load, by a spring to the ground or as a damper.
    needs_material
        True if its values follow from the material of the surface.
    """

    kind: ClassVar[str]
    needs_material: ClassVar[bool] = False
    bears = True

    @abc.abstractmethod
    def backing(self, material: Material | None, footprint: float) -> Backing:
        """Return the mass, stiffness and damping behind the plane.

        Parameters
        ----------
        material
            Material of the surface; a plate and a damper need none.
        footprint
            Radius of the packing's footprint, m.
        """


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plate(Support):
    """Rigid plate on a spring and a damper."""

    kind = "plate"
    mass: float = schema.number("mass of the plate", hints.MASS, above=0)
    stiffness: float = schema.number(
        "stiffness of the spring between plate and ground", "N/m", above=0
    )
    damping: float = schema.number(
        "constant of the damper beside the spring", "N s/m", at_least=0, default=0.0
    )

    def backing(self, material: Material | None, footprint: float) -> Backing:
        return Backing(self.mass, self.stiffness, self.damping)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Damper(Support):
    """Plate without mass on a damper; the ground bears the force that is on it when the run begins."""

    kind = "damper"
    damping: float = schema.number(
        "force on the ground, beyond the static one, over the velocity of the plate",
        "N s/m",
        above=0,
    )

    def backing(self, material: Material | None, footprint: float) -> Backing:
        return Backing(0.0, 0.0, self.damping)


@dataclasses.dataclass(frozen=True, kw_only=True)
class HalfSpace(Support):
    """Surface of an elastic half-space under the packing, moving as a rigid disc."""

    kind = "half_space"
    needs_material = True
    radius: float | None = schema.number(
        "radius of the disc that moves; that of the packing's footprint by default",
        hints.LENGTH,
        above=0,
        default=None,
    )

    def backing(self, material: Material | None, footprint: float) -> Backing:
        assert material is not None
        radius = self.radius or footprint
        shear = material.youngs_modulus / (2 * (1 + material.poisson_ratio))
        stiffness = _SPRING * shear * radius / (1 - material.poisson_ratio)
        damping = (
            _DAMPER * radius**2 * math.sqrt(material.density * shear) / (1 - material.poisson_ratio)
        )
        return Backing(0.0, stiffness, damping)


@dataclasses.dataclass(frozen=True, kw_only=True)
class SupportBar(Support):
    """Elastic bar under the whole packing."""

    kind = "bar"
    needs_material = True
    length: float = schema.number("length of the bar", hints.LENGTH, above=0)
    area: float = schema.number("area of its cross-section", hints.AREA, above=0)
    elements: int = schema.count(
        "number of elements of equal length", at_most=10_000_000, default=200
    )
    end: str = schema.choice(
        "far end: free, fixed, or going on without an echo",
        ("free", "fixed", "infinite"),
        default="infinite",
    )

    @property
    def bears(self) -> bool:  # type: ignore[override]
        """True if its end is fixed."""
        return self.end == "fixed"

    def backing(self, material: Material | None, footprint: float) -> Backing:
        assert material is not None
        impedance = self.area * math.sqrt(material.youngs_modulus * material.density)
        return Backing(
            material.density * self.area * self.length,
            material.youngs_modulus * self.area * self.elements / self.length,
            elements=self.elements,
            end=impedance if self.end == "infinite" else self.end,
        )


SUPPORTS: dict[str, type[Support]] = {
    one.kind: one for one in (Plate, Damper, HalfSpace, SupportBar)
}
BOTTOMS = ("wall", "fixed", "free", "periodic")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tube:
    """``[boundary.sides.tube]``: a tube around the axis x = y = 0 of the packing."""

    radius: float = schema.number(
        "inner radius of the tube, before it shrinks", hints.DIAMETER, above=0
    )


def _tables_of(sections: Mapping[str, type]) -> dict[str, schema.ValueType]:
    """Return the types of tables by name."""
    return {
        name: schema.TableType(section=section, expected=f"a table [{name}]")
        for name, section in sections.items()
    }


_TOUCHED_FORM = 'a table such as {group = "cylinders"} or {material = ["aluminium", "steel"]}'
_NAMES_FORM = "a name, or a list of names"
_NAMES = schema.ListType(
    item=schema.TextType(expected=_NAMES_FORM), expected=_NAMES_FORM, at_least=0, alone=True
)


@dataclasses.dataclass(frozen=True)
class Touched:
    """Grains that side walls act on: those of these materials, and those of these groups."""

    material: tuple[str, ...] = schema.typed("names of materials", _NAMES, default=())
    group: tuple[str, ...] = schema.typed("names of groups", _NAMES, default=())


_FRICTION: dict[str, Any] = {"at_least": 0, "at_most": 1e4, "default": None, "unit": hints.FRICTION}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Boundary:
    """``[boundary]``: bottom and sides of the packing; the struck top is always free."""

    bottom: str = schema.choice(
        "what is below the last layer: a plane, the layer held in place, nothing, or (for bands) the packing again",
        BOTTOMS,
        default="wall",
        otherwise=schema.TablesType(
            expected="{material = ...} for a wall of a material; or {plate = ...}, {damper = ...}, "
            "{half_space = ...} or {bar = ...} for one that moves: tables [boundary.bottom.plate] "
            "and so on",
            inner={"material": MATERIAL} | _tables_of(SUPPORTS),
        ),
    )
    # of the bottom plane: bottom = {material = ...}; None: rigid
    bottom_material: Material | None = None
    sides: str = schema.choice(
        "what is at the sides: nothing, planes, or the packing again",
        ("free", "wall", "periodic"),
        default="free",
        otherwise=schema.TablesType(
            expected="{material = ...} for walls of a material, {tube = {radius = ...}} for a "
            "tube, or both",
            inner={"material": MATERIAL} | _tables_of({"tube": Tube}),
        ),
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
    sides_touch: Touched | None = schema.typed(
        "materials or groups of the grains that the side walls act on, and whose outermost ones the planes touch; left "
        "out: all",
        schema.TableType(section=Touched, expected=_TOUCHED_FORM),
        default=None,
    )
    # radius of a tube around the axis x = y = 0, m: sides = {tube = {radius = ...}}
    sides_tube: float | None = None
    # of a moving bottom plane: plate, damper, half_space or bar = {...}
    bottom_support: Support | None = None
    # of all side planes: sides = {material = ...}; None: rigid
    sides_material: Material | None = None
    friction: float | None = schema.number(
        "coefficient of Coulomb friction of the walls; that of the contacts by default", **_FRICTION
    )
    holder_friction: float | None = schema.number(
        "coefficient of Coulomb friction between a level chain and its holder, which bears the weight of the beads",
        **_FRICTION,
    )
    forget_gap: float = schema.number(
        "gap beyond which a dent is forgotten, never sooner",
        "diameters",
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

    def keys(self) -> dict[str, Any]:
        """Return the keys of the boundary with their values, as a case file has them."""
        keys = {field.name: getattr(self, field.name) for field in schema.key_fields(Boundary)}
        support = self.bottom_support
        tube = self.sides_tube
        bottom = {} if support is None else {support.kind: support}
        sides = {} if tube is None else {"tube": {"radius": tube}}
        for name, table in (("bottom", bottom), ("sides", sides)):
            if (material := getattr(self, f"{name}_material")) is not None:
                table["material"] = material
            keys |= {name: table} if table else {}
        return keys


def read_boundary(table: Any, errors: ErrorList) -> Boundary | None:
    """Read ``[boundary]``, with the tables that may stand for a wall; faults are added to
    ``errors``.
    """
    before = len(errors.lines)
    read = dict[str, Any]()
    for name, sections in (("bottom", SUPPORTS), ("sides", {"tube": Tube})):
        if isinstance(table, Mapping) and isinstance(table.get(name), Mapping):
            read |= _read_wall(table[name], name, sections, errors)
            table = {**table, name: "wall"}
    boundary = read_table(Boundary, table, "boundary", errors)
    return (
        None
        if boundary is None or len(errors.lines) > before
        else dataclasses.replace(boundary, **read)
    )


def _read_wall(
    table: Mapping[str, Any], name: str, sections: Mapping[str, type], errors: ErrorList
) -> dict[str, Any]:
    """Read the material of a wall, and its support or the radius of its tube, as fields of
    `Boundary`.
    """
    key = f"boundary.{name}"
    chosen = [one for one in sections if one in table]
    found = dict[str, Any]()
    refuse_unknown(table, ("material", *sections), key, errors)
    errors.check(
        (
            not table,
            key,
            f'found {{}}, expected a word, {{material = "..."}}, or {", ".join(sections)} = {{...}}',
        ),
        (len(chosen) > 1, key, f"found {' and '.join(chosen)}, expected one of them"),
    )
    if "material" in table:
        found[f"{name}_material"] = read_material(table["material"], errors, f"{key}.material")
    for one in chosen if len(chosen) == 1 else ():
        section = read_table(sections[one], table[one], f"{key}.{one}", errors)
        if isinstance(section, Tube):
            found["sides_tube"] = section.radius
        elif isinstance(section, Support):
            found[f"{name}_support"] = section
        if "material" not in table and getattr(sections[one], "needs_material", False):
            errors.add(f"{key}.material", f"missing; a {one} needs it")
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
    pressure: float | None = schema.number(
        "pressure on the faces of the packing", hints.PRESSURE, **_NONE
    )
    force: float | None = schema.number(
        "force on each sphere of the top layer (uniaxial; also beside walls)", **_PRESS
    )
    x: float | None = schema.number(
        "distance by which each of the planes across x moves in", **_MOVE
    )
    y: float | None = schema.number(
        "distance by which each of the planes across y moves in", **_MOVE
    )
    tube: float | None = schema.number("distance by which the tube's radius shrinks", **_MOVE)
    x_force: float | None = schema.number(
        "force to which each of the planes across x is moved in", **_PRESS
    )
    y_force: float | None = schema.number(
        "force to which each of the planes across y is moved in", **_PRESS
    )
    tube_force: float | None = schema.number(
        "force outward on the whole tube to which it shrinks", **_PRESS
    )
    overlaps: bool | None = schema.choice(
        "true: overlaps of grains at the start are part of it; else they are refused",
        (True, False),
        default=None,
    )
    acceleration: float = schema.number(
        "acceleration of gravity", hints.ACCELERATION, above=0, default=9.81
    )

    @property
    def moves(self) -> dict[str, float]:
        """Distances by which walls move in, by x, y or tube, m."""
        return {name: getattr(self, name) for name in _WALLS if getattr(self, name) is not None}

    @property
    def presses(self) -> dict[str, float]:
        """Forces to which walls move in, by x, y or tube, N."""
        forces = {name: getattr(self, f"{name}_force") for name in _WALLS}
        return {name: force for name, force in forces.items() if force is not None}

    @property
    def moves_walls(self) -> bool:
        """True if there is no dead load but, perhaps, a force on the top."""
        return self.kind in ("walls", "overlaps")

    @property
    def takes_overlaps(self) -> bool:
        """True if overlaps of grains at the start are part of the load."""
        return bool(self.overlaps) or self.kind == "overlaps"
