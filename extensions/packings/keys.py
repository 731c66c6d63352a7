"""Keys of ``[packing]`` of the kinds that this extension adds."""

from __future__ import annotations

import dataclasses

from granwave.extensions.packings.sizes import DIAMETERS, SizeDistribution
from granwave.lammps_inputs.case import hints, schema

_BOX_FORM = "[along x, along y] in m, both above 0"
_PROPORTIONS_FORM = "three numbers above 0"
_MOST_GRAINS = 100_000


@dataclasses.dataclass(frozen=True, kw_only=True)
class PouredSection:
    """Grains poured into a box or a tube, settled under gravity."""

    kind: str = schema.choice(
        "kind of packing: grains that are poured and settle under gravity", ("poured",)
    )
    grains: int = schema.count("number of grains", at_most=_MOST_GRAINS)
    diameter: SizeDistribution = schema.typed(
        "diameter of all grains, or its distribution", DIAMETERS, unit=hints.DIAMETER
    )
    box: tuple[float, float] | None = schema.typed(
        "widths of the box along x and y; its sides are walls, or periodic with boundary.sides = "
        '"periodic"',
        schema.vector_type(2, _BOX_FORM, lambda x, y: min(x, y) > 0),
        unit=hints.LENGTH,
        default=None,
    )
    tube: float | None = schema.number(
        "radius of a tube around x = y = 0, instead of a box", hints.LENGTH, above=0, default=None
    )
    friction: float | None = schema.number(
        "coefficient of friction of grains and walls while the grains settle; default: the "
        "value of [contact]",
        at_least=0,
        at_most=10,
        default=None,
    )
    rolling: float = schema.number(
        "coefficient of rolling resistance while the grains settle, which stops slow rolling",
        at_least=0,
        at_most=1,
        default=0.01,
    )
    restitution: float = schema.number(
        "coefficient of restitution while the grains settle", above=0, at_most=1, default=0.5
    )
    seed: int = schema.count("seed of diameters and positions", at_least=0, default=0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class CompressedSection:
    """Random grains in a box that shrinks to a solid fraction or a pressure."""

    kind: str = schema.choice(
        "kind of packing: random grains, compressed to a solid fraction or a pressure",
        ("compressed",),
    )
    grains: int = schema.count("number of grains", at_most=_MOST_GRAINS)
    diameter: SizeDistribution = schema.typed(
        "diameter of all grains, or its distribution", DIAMETERS, unit=hints.DIAMETER
    )
    solid_fraction: float | None = schema.number(
        "volume of the grains divided by the volume of the box",
        at_least=0.25,
        at_most=0.8,
        default=None,
    )
    pressure: float | None = schema.number(
        "final pressure, instead of a solid fraction", hints.PRESSURE, above=0, default=None
    )
    proportions: tuple[float, float, float] = schema.typed(
        "proportions of the box along x, y and z; sides are periodic or planes, as set in "
        "[boundary]",
        schema.vector_type(3, _PROPORTIONS_FORM, lambda x, y, z: min(x, y, z) > 0),
        default=(1.0, 1.0, 1.0),
    )
    friction: float | None = schema.number(
        "coefficient of friction of grains and walls during the compression; default: the value "
        "of [contact]",
        at_least=0,
        at_most=10,
        default=None,
    )
    seed: int = schema.count("seed of diameters and positions", at_least=0, default=0)
