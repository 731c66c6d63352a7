"""``[precompression]``: static load of a packing, and its kinds.

A kind of static load is a subclass of `StaticLoad`, listed in `STATIC_LOADS`: its texts, its keys,
and flags that state where it acts. Its forces are a class of
`granwave.lammps_inputs.contact.static_load`.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.packing.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch

PRECOMPRESSION = "precompression"
_KIND = f"{PRECOMPRESSION}.kind = "
_NONE: dict[str, Any] = {"above": 0, "default": None}
_MOVE = _NONE | {"unit": hints.DISPLACEMENT}
_PRESS = _NONE | {"unit": hints.FORCE}
_WALLS = ("x", "y", "tube")
_SIZES = {"pressure": "Pa", "force": "N"}  # keys of the size of a load, and their units


class StaticLoad:
    """Kind of static load.

    Attributes
    ----------
    name
        Value of ``precompression.kind``.
    summary
        Definition, for the description of this key.
    phrase
        Effect on the packing, in a line about a case.
    sizes
        The keys among ``pressure`` and ``force`` that belong to it.
    instead
        Keys to use instead of others.
    takes_acceleration
        True if ``acceleration`` and ``strikers`` belong to it.
    takes_moves
        True if distances and forces of walls belong to it.
    moves_walls
        True if there is no dead load except, possibly, a force on the top.
    from_overlaps
        True if the overlaps of grains at the start are all of it.
    on_all_faces
        True if it acts on all free faces, which have to be known.
    on_top
        True if it acts on the top layer, along z.
    across_alone
        True if it loads contacts across z.
    is_even
        True if it loads all layers with the same, known force.
    grows_with_depth
        True if each layer carries more than the layer above.
    holds_layers
        True if it keeps the spheres of a layer together.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    phrase: ClassVar[str] = "precompressed"
    sizes: ClassVar[tuple[str, ...]] = ()
    instead: ClassVar[str] = "x, y or tube, in m, or force, in N, on the top"
    takes_acceleration: ClassVar[bool] = False
    takes_moves: ClassVar[bool] = False
    moves_walls: ClassVar[bool] = False
    from_overlaps: ClassVar[bool] = False
    on_all_faces: ClassVar[bool] = False
    on_top: ClassVar[bool] = False
    across_alone: ClassVar[bool] = False
    is_even: ClassVar[bool] = False
    grows_with_depth: ClassVar[bool] = False
    holds_layers: ClassVar[bool] = False

    def check_keys(self, stage: Precompression, packing: PackingSection, errors: ErrorList) -> None:
        """Check that a load has the keys of its kind, and no others."""
        moving = [*stage.moves, *(f"{name}_force" for name in stage.presses)]
        by_gravity = {
            "acceleration": stage.acceleration != Precompression.acceleration,
            "strikers": stage.strikers,
        }
        for name in () if self.takes_moves else moving:
            errors.add(
                f"{PRECOMPRESSION}.{name}", f'belongs to {_KIND}"walls"; found {show(self.name)}'
            )
        for name in self._foreign_sizes(stage):
            errors.add(f"{PRECOMPRESSION}.{name}", self._refusal_of_size())
        for name, is_given in by_gravity.items():
            if is_given and not self.takes_acceleration:
                found = f'belongs to {_KIND}"gravity"; found "{self.name}"'
                errors.add(f"{PRECOMPRESSION}.{name}", found)

    def check_bounds(self, packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
        """Check that the boundary can support a load that moves no walls."""
        support = boundary.bottom_support
        self._check_bottom(packing, boundary, errors)
        errors.check(
            (
                support is not None and not support.bears,
                "boundary.bottom.bar.end",
                Mismatch(
                    f"{show(getattr(support, 'end', ''))} under a precompression",
                    '"fixed": such a bar yields to a constant load',
                ),
            ),
        )

    def size_of(self, stage: Precompression) -> tuple[str, str]:
        """Return the key of the size of a load, and its unit."""
        name = "pressure" if stage.force is None else "force"
        return name, _SIZES[name]

    def words(self, stage: Precompression) -> list[str]:
        """Return phrases on static loads other than walls, pressure and force, in the
        plan of a case.
        """
        return []

    def _check_bottom(self, packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
        unborne = packing.rule.is_lattice and not boundary.bottom_rule.bears
        found = f'found "free" under a {self.name} precompression, which requires a support'
        errors.check((unborne, "boundary.bottom", found))

    def _foreign_sizes(self, stage: Precompression) -> list[str]:
        return [name for name in stage.sizes if name not in self.sizes]

    def _refusal_of_size(self) -> str:
        return f"cannot be used with {_KIND}{show(self.name)}; use {self.instead}"


class LoadOnFaces(StaticLoad):
    """Pressure on faces of the packing, or a force on each sphere of a face."""

    is_even = True

    def check_keys(self, stage: Precompression, packing: PackingSection, errors: ErrorList) -> None:
        super().check_keys(stage, packing, errors)
        given = stage.sizes
        single = len(given) == 1 or bool(self._foreign_sizes(stage))
        has_faces = packing.rule.has_faces or not packing.rule.is_lattice
        count = "found both pressure and force" if given else "found neither pressure nor force"
        errors.check(
            (not single, PRECOMPRESSION, f"{count}, expected one of them"),
            (
                given == ["pressure"] and not has_faces,
                f"{PRECOMPRESSION}.pressure",
                Mismatch(f"for {packing.rule.noun}, which has no faces", "a force"),
            ),
        )

    def _refusal_of_size(self) -> str:
        return f"found with {_KIND}{show(self.name)}, expected a pressure"


class Uniaxial(LoadOnFaces):
    """The same force along z on each sphere of the top layer."""

    name = "uniaxial"
    summary = "a load along z on the top layer"
    sizes = ("pressure", "force")
    on_top = True

    def _check_bottom(self, packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
        if not packing.rule.is_chain:  # without a bottom, the opposite force acts on the last bead
            super()._check_bottom(packing, boundary, errors)
        layer = 'found "uniaxial" for square, a single layer; expected "uniform" or "gravity"'
        errors.check((packing.rule.is_layer, f"{PRECOMPRESSION}.kind", layer))


class Uniform(LoadOnFaces):
    """The same pressure on all free faces."""

    name = "uniform"
    summary = "the same pressure on all free faces"
    sizes = ("pressure",)
    on_all_faces = True
    holds_layers = True

    def _check_bottom(self, packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
        rule = packing.rule
        called = rule.noun if rule.is_chain else packing.kind
        repeats = boundary.bottom_rule.repeats
        beside = rule.has_faces and not repeats and not boundary.sides_rule.is_free
        errors.check(
            (
                rule.is_lattice and not rule.has_faces,
                f"{PRECOMPRESSION}.kind",
                Mismatch(f'"uniform" for {called}', '"uniaxial" with a force'),
            ),
            (
                beside,
                "boundary.sides",
                Mismatch(
                    f'{show(boundary.sides)} with precompression.kind = "uniform"',
                    '"free": the pressure is on the sides too',
                ),
            ),
        )


class Gravity(StaticLoad):
    """The weight of the spheres, along z."""

    name = "gravity"
    summary = "the spheres' weight along +z"
    phrase = "under gravity"
    instead = "acceleration"
    takes_acceleration = True
    grows_with_depth = True

    def size_of(self, stage: Precompression) -> tuple[str, str]:
        return "acceleration", "m/s^2"

    def words(self, stage: Precompression) -> list[str]:
        words = [f"weight at {stage.acceleration:.4g} m/s^2"]
        if stage.strikers:
            words.append("strikers fall as well")
        return words


class MovedWalls(StaticLoad):
    """Walls that are moved in, and then held."""

    name = "walls"
    summary = "walls that are moved in and then held"
    phrase = "pressed by walls"
    sizes = ("force",)
    takes_moves = True
    moves_walls = True
    across_alone = True


class Overlaps(StaticLoad):
    """The overlaps of grains at the start."""

    name = "overlaps"
    summary = "only the initial overlaps of the grains"
    sizes = ("force",)
    moves_walls = True
    from_overlaps = True


STATIC_LOADS: dict[str, StaticLoad] = {
    load.name: load for load in (Uniaxial(), Uniform(), Gravity(), MovedWalls(), Overlaps())
}
_SUMMARIES = ", ".join(f"{load.name} ({load.summary})" for load in STATIC_LOADS.values())


@dataclasses.dataclass(frozen=True, kw_only=True)
class Precompression:
    """``[precompression]``: a static load, applied before the impact and kept during it."""

    kind: str = schema.choice(f"kind of static load: {_SUMMARIES}", tuple(STATIC_LOADS))
    pressure: float | None = schema.number(
        "pressure on the faces of the packing", hints.PRESSURE, **_NONE
    )
    force: float | None = schema.number(
        "force on each sphere of the top layer (uniaxial; also together with walls)", **_PRESS
    )
    x: float | None = schema.number(
        "distance by which each of the planes across x moves in", **_MOVE
    )
    y: float | None = schema.number(
        "distance by which each of the planes across y moves in", **_MOVE
    )
    tube: float | None = schema.number("distance by which the tube's radius shrinks", **_MOVE)
    x_force: float | None = schema.number(
        "force on each of the planes across x, which move in until they carry this force", **_PRESS
    )
    y_force: float | None = schema.number(
        "force on each of the planes across y, which move in until they carry this force", **_PRESS
    )
    tube_force: float | None = schema.number(
        "total outward force on the tube, which shrinks until it carries this force", **_PRESS
    )
    overlaps: bool | None = schema.choice(
        "true: initial overlaps of grains are part of the precompression; otherwise they are "
        "rejected",
        (True, False),
        default=None,
    )
    acceleration: float = schema.number(
        "acceleration of gravity", hints.ACCELERATION, above=0, default=9.81
    )
    strikers: bool = schema.choice(
        "true: gravity also acts on strikers, from the impact onwards", (False, True), default=False
    )

    @property
    def rule(self) -> StaticLoad:
        """Properties of its kind."""
        return STATIC_LOADS[self.kind]

    @property
    def sizes(self) -> list[str]:
        """Keys ``pressure`` and ``force`` that are set."""
        return [name for name in _SIZES if getattr(self, name) is not None]

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
        """True if there is no dead load except, possibly, a force on the top."""
        return self.rule.moves_walls

    @property
    def takes_overlaps(self) -> bool:
        """True if overlaps of grains at the start are part of the load."""
        return bool(self.overlaps) or self.rule.from_overlaps

    @property
    def is_overlaps_alone(self) -> bool:
        """True if overlaps of grains at the start are all of the load."""
        if not self.takes_overlaps or not self.moves_walls:
            return False
        return not (self.moves or self.presses or self.force)
