"""``[boundary]``: bottom and sides of a packing.

Supports of a moving bottom plane: ``boundary.bottom = {plate = {...}}``, ``damper``, ``half_space``
or ``bar``.

plate        a rigid plate on a spring and an optional damper
damper       a massless plate on a damper, which carries the static force: an end that absorbs waves
half_space   the surface of an elastic half-space under the packing's footprint: Lysmer's analogue,
             a spring 4 G r/(1 - nu) parallel to a damper 3.4 r^2 sqrt(rho G)/(1 - nu) (Lysmer and
             Richart, 1966)
bar          an elastic bar along z, of linear elements with lumped mass; its far end free, fixed or
             non-reflecting
"""

from __future__ import annotations

import abc
import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.bounds import BOTTOMS, SIDES, Bottom, Sides
from granwave.lammps_inputs.case.material import MATERIAL, Material, read_material
from granwave.lammps_inputs.case.schema import (
    ErrorList,
    read_table,
    refuse_unknown,
)
from granwave.lammps_inputs.errors import Mismatch

_SPRING = 4.0  # K (1 - nu) / (G r) of a rigid disc on a half-space, exact in statics
_DAMPER = 3.4  # C (1 - nu) / (r^2 sqrt(rho G)) (Lysmer and Richart, 1966)
BAR_COURANT_NUMBER = 0.5  # timestep over the travel time of a wave through one element of a bar
# timestep over sqrt(mass/stiffness), of a plate or the first element of a bar
PLATE_OSCILLATION = 0.05
_SQUARE_CM = 1e4
_OF_DECAY = 0.05  # timestep over damping/stiffness of a massless surface


@dataclasses.dataclass(frozen=True)
class Backing:
    """Support behind a plane, along its normal: a node on a spring and a damper, or a bar of lumped
    masses.

    Attributes
    ----------
    mass
        Mass of the node, 0 for a surface without inertia, or total mass of the bar, kg.
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

    @property
    def is_damper(self) -> bool:
        """True for a damper without a mass or a spring."""
        return not self.mass and not self.stiffness

    @property
    def remedy(self) -> str:
        """Describe a support with a longer timestep."""
        if self.mass:
            return "a heavier or softer support"
        return "more damping" if self.is_damper else "a larger radius"

    def longest_timestep(self, contacts: float) -> float:
        """Return the longest timestep, s, that resolves the motion of the support under contacts
        with this total stiffness, N/m.
        """
        if not self.mass:
            return _OF_DECAY * self.damping / contacts
        front = self.mass / self.elements / 2 if self.elements else self.mass
        return PLATE_OSCILLATION * math.sqrt(front / (self.stiffness + contacts))

    def moved_mass(self, grain: float, stiffness: float) -> float:
        """Return the mass with which the support resists a contact, kg, as in the wall fix.

        A plate or a free bar counts with its mass; spring and damper of a plate count with their
        effect at the frequency of the grain on a plane at rest. A surface without mass and a bar
        whose end is fixed or does not reflect belong to the ground: the mass is infinite.

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
        slowness = grain / stiffness  # inverse square of the angular frequency
        return self.mass + self.damping * math.sqrt(slowness) + self.stiffness * slowness


class Support(abc.ABC):
    """Support of the bottom plane: plate, damper, half-space or bar.

    Attributes
    ----------
    kind
        Its name in the case file.
    bears
        True if it can carry a static load, by a spring to the ground or as a damper.
    needs_material
        True if its values follow from the material of the surface.
    absorbs
        True if it absorbs steady waves by its damping only.
    """

    kind: ClassVar[str]
    needs_material: ClassVar[bool] = False
    absorbs: ClassVar[bool] = False
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

    def absorber(self, material: Material | None) -> tuple[float, float] | None:
        """Return spring (N/m) and damper (N s/m) of a surface without reflections; None for others.

        Parameters
        ----------
        material
            Material of the surface.
        """
        return None

    @abc.abstractmethod
    def label(self, material: str) -> str:
        """Return the name of the support in tables and titles: ``plate of 0.5 kg, 314 µs``.

        Parameters
        ----------
        material
            Name of the material of the surface.
        """


def time_label(seconds: float) -> str:
    """``314 µs``, ``6.28 ms``."""
    return f"{1e3 * seconds:.3g} ms" if seconds >= 1e-3 else f"{1e6 * seconds:.3g} µs"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Plate(Support):
    """Rigid plate on a spring and a damper."""

    kind = "plate"
    mass: float = schema.number("mass of the plate", hints.MASS, above=0)
    stiffness: float = schema.number(
        "stiffness of the spring between plate and ground", "N/m", above=0
    )
    damping: float = schema.number(
        "constant of the damper parallel to the spring", "N s/m", at_least=0, default=0.0
    )

    def backing(self, material: Material | None, footprint: float) -> Backing:
        return Backing(self.mass, self.stiffness, self.damping)

    @property
    def period(self) -> float:
        """Period of the plate on its spring, undamped, s."""
        return 2 * math.pi * math.sqrt(self.mass / self.stiffness)

    def label(self, material: str) -> str:
        damped = ", damped" if self.damping else ""
        return f"plate of {self.mass:g} kg, {time_label(self.period)}{damped}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Damper(Support):
    """Massless plate on a damper; the ground carries the initial force on the plate."""

    kind = "damper"
    absorbs = True
    damping: float = schema.number(
        "dynamic force on the ground divided by the velocity of the plate",
        "N s/m",
        above=0,
    )

    def backing(self, material: Material | None, footprint: float) -> Backing:
        return Backing(0.0, 0.0, self.damping)

    def label(self, material: str) -> str:
        return f"damper of {self.damping:g} N s/m"


@dataclasses.dataclass(frozen=True, kw_only=True)
class HalfSpace(Support):
    """Surface of an elastic half-space under the packing, moving as a rigid disc."""

    kind = "half_space"
    needs_material = True
    radius: float | None = schema.number(
        "radius of the disc that moves; default: the radius of the packing's footprint",
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

    def absorber(self, material: Material | None) -> tuple[float, float] | None:
        if self.radius is None:  # it depends on the packing
            return None
        behind = self.backing(material, self.radius)
        return behind.stiffness, behind.damping

    def label(self, material: str) -> str:
        disc = f", disc of {1e3 * self.radius:g} mm" if self.radius else ""
        return f"{material} half-space{disc}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class SupportBar(Support):
    """Elastic bar under the complete packing."""

    kind = "bar"
    needs_material = True
    length: float = schema.number("length of the bar", hints.LENGTH, above=0)
    area: float = schema.number("area of its cross-section", hints.AREA, above=0)
    elements: int = schema.count(
        "number of elements of equal length", at_most=10_000_000, default=200
    )
    end: str = schema.choice(
        "far end: free, fixed, or non-reflecting",
        ("free", "fixed", "infinite"),
        default="infinite",
    )

    @property
    def bears(self) -> bool:  # type: ignore[override]
        """True if its end is fixed."""
        return self.end == "fixed"

    def backing(self, material: Material | None, footprint: float) -> Backing:
        assert material is not None
        impedance = self._impedance(material)
        return Backing(
            material.density * self.area * self.length,
            material.youngs_modulus * self.area * self.elements / self.length,
            elements=self.elements,
            end=impedance if self.end == "infinite" else self.end,
        )

    def absorber(self, material: Material | None) -> tuple[float, float] | None:
        if self.end != "infinite" or material is None:
            return None
        return 0.0, self._impedance(material)

    def _impedance(self, material: Material) -> float:
        return self.area * math.sqrt(material.youngs_modulus * material.density)

    def label(self, material: str) -> str:
        end = "" if self.end == "infinite" else f", far end {self.end}"
        return f"{material} bar of {_SQUARE_CM * self.area:.3g} cm²{end}"


SUPPORTS: dict[str, type[Support]] = {
    one.kind: one for one in (Plate, Damper, HalfSpace, SupportBar)
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tube:
    """``[boundary.sides.tube]``: a tube around the axis x = y = 0 of the packing."""

    radius: float = schema.number(
        "inner radius of the tube before precompression", hints.DIAMETER, above=0
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
    """Grains that side walls act on, selected by material and by group."""

    material: tuple[str, ...] = schema.typed("names of materials", _NAMES, default=())
    group: tuple[str, ...] = schema.typed("names of groups", _NAMES, default=())


_FRICTION: dict[str, Any] = {"at_least": 0, "at_most": 1e4, "default": None, "unit": hints.FRICTION}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Boundary:
    """``[boundary]``: bottom and sides of the packing; the impacted top is always free."""

    bottom: str = schema.choice(
        "boundary below the last layer: a plane, the layer itself held in place, none, or "
        "(for bands) periodic",
        tuple(BOTTOMS),
        default="wall",
        otherwise=schema.TablesType(
            expected="{material = ...} for a wall of a material; or {plate = ...}, {damper = "
            "...}, {half_space = ...} or {bar = ...} for a support that moves (see the "
            "tables [boundary.bottom.plate] and so on); to absorb the wave, use the table "
            "[[absorb]]",
            inner={"material": MATERIAL} | _tables_of(SUPPORTS),
        ),
    )
    # bottom plane: bottom = {material = ...}; None: rigid
    bottom_material: Material | None = None
    sides: str = schema.choice(
        "boundaries at the sides: none, planes, or periodic",
        tuple(SIDES),
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
        "gap between the side walls and the outermost spheres, 0 by default; negative: the walls "
        "press the packing by this distance before the run, as with [precompression] of "
        "kind walls",
        hints.DISPLACEMENT,
        default=None,
    )
    sides_touch: Touched | None = schema.typed(
        "materials or groups of the grains on which the side walls act; the planes touch the "
        "outermost of these grains; default: all grains",
        schema.TableType(section=Touched, expected=_TOUCHED_FORM),
        default=None,
    )
    # radius of a tube around the axis x = y = 0, m: sides = {tube = {radius = ...}}
    sides_tube: float | None = None
    # moving bottom plane: plate, damper, half_space or bar = {...}
    bottom_support: Support | None = None
    # side planes: sides = {material = ...}; None: rigid
    sides_material: Material | None = None
    friction: float | None = schema.number(
        "coefficient of Coulomb friction of the walls; default: the contact friction", **_FRICTION
    )
    holder_friction: float | None = schema.number(
        "coefficient of Coulomb friction between a level chain and its guide, which supports the beads",
        **_FRICTION,
    )
    forget_gap: float = schema.number(
        "gap beyond which the plastic indentation of a contact is forgotten",
        "diameters",
        above=0,
        at_most=2,
        default=0.1,
    )

    @property
    def bottom_rule(self) -> Bottom:
        """Properties of the kind of bottom."""
        return BOTTOMS[self.bottom]

    @property
    def sides_rule(self) -> Sides:
        """Properties of the kind of sides."""
        return SIDES[self.sides]

    @property
    def periodic(self) -> bool:
        """True if the packing is periodic along x and y."""
        return self.sides_rule.repeats

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
    """Read ``[boundary]``, with the tables that define a wall; faults are added to
    ``errors``.
    """
    before = len(errors.items)
    read = dict[str, Any]()
    for name, sections in (("bottom", SUPPORTS), ("sides", {"tube": Tube})):
        if isinstance(table, Mapping) and isinstance(table.get(name), Mapping):
            read |= _read_wall(table[name], name, sections, errors)
            table = {**table, name: "wall"}
    boundary = read_table(Boundary, table, "boundary", errors)
    return (
        None
        if boundary is None or len(errors.items) > before
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
            Mismatch("{}", f'a word, {{material = "..."}}, or {", ".join(sections)} = {{...}}'),
        ),
        (len(chosen) > 1, key, Mismatch(f"{' and '.join(chosen)}", "one of them")),
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
            errors.add(f"{key}.material", f"missing; a {one} requires it")
    return found
