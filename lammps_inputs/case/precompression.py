"""``[precompression]``: static load before and during the impact."""

from __future__ import annotations

import dataclasses
from typing import Any, Literal

from granwave.lammps_inputs.case.schema import choice, number
from granwave.lammps_inputs.case.si_values import ACCELERATION, DISPLACEMENT, FORCE, PRESSURE

_MOVE: dict[str, Any] = {"unit": "m", "above": 0, "default": None, "usual": DISPLACEMENT}
_PRESS: dict[str, Any] = {"unit": "N", "above": 0, "default": None, "usual": FORCE}
_WALLS = ("x", "y", "tube")


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
