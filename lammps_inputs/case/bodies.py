"""Bodies other than the equal spheres of a packing, sensors, and spheres that absorb waves.

    [[replace]]                  spheres of another material or diameter
    [[striker]]                  a sphere placed against given spheres, resting or moving
    [bar], [incident_bar]        elastic bars at the far and at the impacted end of a chain
    [[hold]]                     grains that do not move
    [[guide]]                    grains that move in some directions only, as in a groove
    [[line]]                     a line of grains whose motion is recorded and measured
    [[sensor]]                   a sphere whose mean contact force (chains) or acceleration is
                                 recorded

Spheres of a chain are numbered from 1 at the impacted end. Strikers follow the spheres of the
packing, in the order of the file.
"""

from __future__ import annotations

import dataclasses

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.hints import AREA, DIAMETER, LENGTH, SPIN, VELOCITY, Usual
from granwave.lammps_inputs.case.ids import INDEX, INDEX_FORM
from granwave.lammps_inputs.case.material import (
    AXIS,
    SHAPES,
    Material,
    Shape,
    Vector,
    length_field,
    material_field,
    shape_of,
)

_POINT_FORM = "[x, y, z] in m"
_OFFSET = Usual("m", 1e-9, 1.0, ("mm", "µm"))


CENTRE = "centre"  # value for the sphere at the centre of the top
_NO_DIRECTION = "none"
_ALONG_Y = (0.0, 1.0, 0.0)
ALL_GRAINS = "all"  # value for all grains of a line


_DIRECTIONS_FORM = 'some of the letters x, y and z, such as "xy"; or "none" to block only rotations'
_FREE_FORM = 'one or two of the letters x, y and z, such as "z"'


def _letters(value: str) -> str:
    wrong = set(value) - set("xyz") or len(set(value)) < len(value)
    schema.refuse_if(wrong, _DIRECTIONS_FORM)
    return "".join(sorted(value))


def _free_letters(value: str) -> str:
    wrong = set(value) - set("xyz") or len(set(value)) < len(value)
    schema.refuse_if(wrong or len(value) == len("xyz"), _FREE_FORM)
    return "".join(sorted(value))


_DIRECTIONS = schema.or_word(
    _NO_DIRECTION,
    schema.TextType(expected=_DIRECTIONS_FORM, finish=_letters),
    form=_DIRECTIONS_FORM,
)
_FREE = schema.TextType(expected=_FREE_FORM, finish=_free_letters)
#: Return ids; empty for the sphere at the centre of the top, which follows from the packing.
_TOUCHED = schema.or_word(CENTRE, INDEX, form=f'{INDEX_FORM}; or "{CENTRE}"', finish=lambda _: ())


@dataclasses.dataclass(frozen=True, kw_only=True)
class Replace:
    """``[[replace]]``: spheres that differ from the rest; a later entry overrides an earlier one.

    They are selected by ``index``, by a box from ``low`` to ``high`` around their lattice sites
    (for a chain, the sites of equal spheres), or as a random fraction ``share`` of all spheres. A
    larger sphere needs space around it: vacancies or smaller neighbours. The beads of a chain are
    moved apart.
    """

    index: tuple[int, ...] | None = schema.typed("ids of the spheres", INDEX, default=None)
    low: tuple[float, float, float] | None = schema.typed(
        "corner of a box", schema.vector_type(3, _POINT_FORM), unit="m", default=None
    )
    high: tuple[float, float, float] | None = schema.typed(
        "opposite corner", schema.vector_type(3, _POINT_FORM), unit="m", default=None
    )
    share: float | None = schema.number(
        "fraction of the spheres, chosen at random", above=0, at_most=1, default=None
    )
    diameter: float | None = schema.number(
        "diameter of these spheres", DIAMETER, above=0, default=None
    )
    material: Material | None = material_field()


@dataclasses.dataclass(frozen=True, kw_only=True)
class Striker:
    """``[[striker]]``: sphere or cylinder touching grains of the packing, or earlier strikers."""

    touches: tuple[int, ...] = schema.typed(
        'ids of the spheres that the striker touches; "centre": the sphere at the centre of the '
        "top, as for an "
        "impact; in a disordered packing, the most central grain on which the striker can rest "
        "without touching another grain",
        _TOUCHED,
    )
    velocity: tuple[float, float, float] = schema.vector("velocity of the striker", VELOCITY)
    spin: tuple[float, float, float] = schema.vector("angular velocity of the striker", SPIN)
    diameter: float | None = schema.number(
        "diameter of the striker; default: the diameter of the packing",
        DIAMETER,
        above=0,
        default=None,
    )
    offset: tuple[float, float, float] = schema.vector(
        "offset of the striker perpendicular to its direction of motion; the striker is then "
        "moved along its direction until it touches the first sphere",
        _OFFSET,
    )
    misalignment: tuple[float, float, float] = schema.typed(
        "largest random displacement along x, y, z in addition to the offset, uniformly "
        "distributed in both directions, with the seed packing.seed",
        schema.vector_type(
            3,
            _POINT_FORM,
            lambda *extent: min(extent) >= 0,
            f"{_POINT_FORM}, none of them negative",
        ),
        unit=_OFFSET,
        default=(0.0, 0.0, 0.0),
    )
    walls: bool | None = schema.choice(
        "true: the planes at the bottom and the sides also act on the striker; by default it "
        "passes through them",
        (True, False),
        default=None,
    )
    shape: str | None = schema.choice(
        "shape of the striker; a sphere by default", SHAPES, default=None
    )
    length: float | None = length_field()
    axis: Vector | None = schema.typed(
        "direction of the axis of a cylinder; default: the axis of the cylinders of the "
        "packing, or y",
        AXIS,
        default=None,
    )
    material: Material | None = material_field()

    @property
    def body(self) -> Shape:
        """Shape of the striker."""
        return shape_of(self)

    @property
    def moves(self) -> bool:
        """True if the striker has a velocity or a spin."""
        return any(self.velocity) or any(self.spin)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bar:
    """``[bar]``, ``[incident_bar]``: an elastic bar along the chain, with linear elements."""

    length: float = schema.number("length of the bar", LENGTH, above=0)
    area: float = schema.number("area of its cross-section", AREA, above=0)
    elements: int = schema.count(
        "number of elements of equal length", at_most=10_000_000, default=1000
    )
    material: Material | None = material_field()


@dataclasses.dataclass(frozen=True, kw_only=True)
class Hold:
    """``[[hold]]``: grains that do not move."""

    index: tuple[int, ...] | None = schema.typed("which grains", INDEX, default=None)
    group: str | None = schema.typed(
        "the grains of this group of packing.file", schema.LABEL, default=None
    )
    directions: str = schema.typed(
        "directions in which the grains do not move, from x, y and z", _DIRECTIONS, default="xyz"
    )
    rotation: bool = schema.choice("true: rotation is held too", (True, False), default=True)

    @property
    def axes(self) -> str:
        """Letters of the directions in which they do not move."""
        return "" if self.directions == _NO_DIRECTION else self.directions


def _line_name(value: str) -> str:
    name = schema.plain_name(value)
    plain = all(one.isascii() and (one.isalnum() or one in "_-") for one in name)
    schema.refuse_if(not plain, "a name that contains only letters, digits, _ and -")
    return name


_LINE_NAME = schema.TextType(expected=schema.PLAIN_NAME.expected, finish=_line_name)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Line:
    """``[[line]]``: grains in a line, for the arrival, speed, decay and width of a wave."""

    name: str = schema.typed("name of the line", _LINE_NAME)
    start: int | None = schema.typed(
        "id of the first grain; default: the impacted sphere",
        schema.CountType(form="an id from 1 up"),
        default=None,
    )
    direction: tuple[float, float, float] = schema.typed(
        "direction of the line, which includes grains up to a quarter of a diameter away",
        schema.vector_type(
            3,
            "[x, y, z], a vector of any nonzero length, such as [0, 0, 1] for straight down",
            lambda *way: any(way),
        ),
        default=(0.0, 0.0, 1.0),
    )
    index: tuple[int, ...] | str | None = schema.typed(
        'ids of its grains in order, instead of start and direction; "all": every grain of '
        "the packing",
        schema.or_word(ALL_GRAINS, INDEX, form=f'{INDEX_FORM}; or "{ALL_GRAINS}"'),
        default=None,
    )
    leave_out: int | str = schema.typed(
        "grains at its end that are excluded from the fit of the decay; auto: grains within three "
        "diameters of a floor that does not move",
        schema.or_word(
            "auto", schema.CountType(at_least=0), form='a whole number from 0 up, or "auto"'
        ),
        default="auto",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Guide:
    """``[[guide]]``: grains that move only in some directions, without friction, as in a groove."""

    index: tuple[int, ...] | None = schema.typed(
        "which grains; all if neither index nor group is given", INDEX, default=None
    )
    group: str | None = schema.typed(
        "the grains of this group of packing.file or [[grains]]", schema.LABEL, default=None
    )
    free: str = schema.typed("directions in which the grains may move, from x, y and z", _FREE)
    rotation: bool = schema.choice("false: the grains do not rotate", (False, True), default=True)

    def hold(self, n_grains: int) -> Hold:
        """Return the ids that it selects among all grains."""
        index = self.index
        if index is None and self.group is None:
            index = tuple(range(1, n_grains + 1))
        held = "".join(axis for axis in "xyz" if axis not in self.free)
        return Hold(
            index=index,
            group=self.group,
            directions=held or _NO_DIRECTION,
            rotation=not self.rotation,
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sensor:
    """``[[sensor]]``: a sphere with an embedded transducer, whose signals are recorded.

    In a chain the mean of its two contact forces is recorded; in other packings its acceleration.
    """

    name: str = schema.typed("name of the sensor", schema.PLAIN_NAME)
    id: int = schema.typed("id of its sphere", schema.CountType(form="an id from 1 up"))


MATCHED = "matched"
_TOWARDS = ("+z", "-z", "+x", "-x", "+y", "-y", "none")
_RATE = Usual("1/s", 1.0, 1e8)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Absorb:
    """``[[absorb]]``: damped spheres that absorb the waves.

    ``rate`` damps motion in all directions, and rotation, by m rate v: a layer that becomes
    stronger with depth reflects little over many frequencies. ``impedance`` is a dashpot along z on
    each sphere: the end of a row, without reflection where it is the impedance of the row.
    """

    index: tuple[int, ...] | None = schema.typed("ids of the spheres", INDEX, default=None)
    layers: int | None = schema.count(
        "number of last layers of the packing; for a chain, number of last spheres", default=None
    )
    rate: float | None = schema.number(
        "largest damping rate: the force is mass × rate × velocity", _RATE, above=0, default=None
    )
    towards: str = schema.choice(
        'direction in which the rate rises from zero, as the square of the depth; "none": a '
        "uniform rate",
        _TOWARDS,
        default="+z",
    )
    impedance: float | str | None = schema.typed(
        "force along z divided by velocity, for each sphere; matched: the impedance for long "
        "waves under the precompression",
        schema.or_word(
            MATCHED, schema.NumberType(above=0), form=f'a number above 0, or "{MATCHED}"'
        ),
        unit="N s/m",
        default=None,
    )
