"""Kinds of bottom and of sides: the values of ``boundary.bottom`` and ``boundary.sides``.

A kind is a subclass of `Bottom` or `Sides`, listed in `BOTTOMS` or `SIDES`, whose flags describe
its effect on the packing. Nothing outside compares its name. Supports of a bottom plane that moves
are in `granwave.lammps_inputs.case.boundary`.
"""

from __future__ import annotations

from typing import Any, ClassVar


class Bottom:
    """Kind of bottom below the last layer.

    Attributes
    ----------
    name
        Value of ``boundary.bottom``.
    label
        Name in tables; ``{material}`` stands for the name of its material.
    has_plane
        True if there is a plane, which may have a material and a support.
    holds_layer
        True if the last layer is held in place.
    bears
        True if it carries a force along z.
    repeats
        True if the packing itself follows below, without end.
    """

    name: ClassVar[str]
    label: ClassVar[str]
    has_plane: ClassVar[bool] = False
    holds_layer: ClassVar[bool] = False
    bears: ClassVar[bool] = True
    repeats: ClassVar[bool] = False

    @property
    def stops(self) -> bool:
        """True if the bottom supports the packing, and is a target of impacts."""
        return self.bears and not self.repeats


class BottomPlane(Bottom):
    """A plane that touches the last layer."""

    name = "wall"
    label = "{material} wall"
    has_plane = True


class HeldLayer(Bottom):
    """The last layer, held in place."""

    name = "fixed"
    label = "fixed last layer"
    holds_layer = True


class NoBottom(Bottom):
    """Free surface below the last layer."""

    name = "free"
    label = "no bottom"
    bears = False


class EndlessBottom(Bottom):
    """Periodic repetition of the packing along z."""

    name = "periodic"
    label = "{material} wall"
    repeats = True


class Sides:
    """Kind of sides around a packing.

    Attributes
    ----------
    name
        Value of ``boundary.sides``.
    has_planes
        True if there are planes.
    repeats
        True if the packing itself follows, without end.
    """

    name: ClassVar[str]
    has_planes: ClassVar[bool] = False
    repeats: ClassVar[bool] = False

    @property
    def is_free(self) -> bool:
        """True if the sides are free surfaces."""
        return not self.has_planes and not self.repeats


class NoSides(Sides):
    """Free surfaces at the sides."""

    name = "free"


class SidePlanes(Sides):
    """Planes that touch the outermost spheres."""

    name = "wall"
    has_planes = True


class EndlessSides(Sides):
    """Periodic repetition of the packing along x and y."""

    name = "periodic"
    repeats = True


def is_target(bottom: Any) -> bool:
    """Return True for a value of ``boundary.bottom`` that is a target of impacts.

    True for tables of a material or a support, and for unknown words.
    """
    rule = BOTTOMS.get(bottom) if isinstance(bottom, str) else None
    return rule is None or rule.stops


BOTTOMS: dict[str, Bottom] = {
    bottom.name: bottom for bottom in (BottomPlane(), HeldLayer(), NoBottom(), EndlessBottom())
}
SIDES: dict[str, Sides] = {sides.name: sides for sides in (NoSides(), SidePlanes(), EndlessSides())}
