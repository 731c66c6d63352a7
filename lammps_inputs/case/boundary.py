"""``[boundary]``: bottom and sides of a packing."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.case.schema import ValidationError, choice, custom, number
from granwave.lammps_inputs.case.si_values import DIAMETER, DISPLACEMENT, FRICTION
from granwave.lammps_inputs.case.supports import Support

BOTTOMS = ("wall", "fixed", "free", "periodic")


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
