"""A rigid plate that strikes the free top.

The plate is a wall, and has the name of the kind of load: its contacts and its motion are those of
a wall of `granwave.lammps_inputs.packing.walls`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.loads.load import (
    Load,
    LoadedPacking,
    PlateOnTop,
    Wording,
    velocity_field,
)
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.script_words import num

# energy of a contact over the plate's energy per contact: twice the mean force, in the softest
# direction
_OF_SHARE = 4.0
_REBOUND = 2.0  # speed of a sphere that a heavy plate hits, over that of the plate
_COVERS = "since it covers the whole top"


@dataclasses.dataclass(frozen=True, kw_only=True)
class PlateLoad(Load):
    """A rigid plate on the free top, with a mass and a velocity."""

    kind: ClassVar[str] = "plate"
    means: ClassVar[str] = "a rigid plate on the free top"
    excludes: ClassVar[Mapping[str, str]] = {"striker": _COVERS, "incident_bar": _COVERS}
    only_stage: ClassVar[tuple[str, str] | None] = (
        "walls",
        "the plate is fixed while the walls move in, and would carry every other static load",
    )
    hits_one_place: ClassVar[bool] = False

    mass: float = schema.number("mass of the plate", hints.MASS, above=0, default=None)
    velocity: float = velocity_field()

    @property
    def plate(self) -> PlateOnTop:
        return PlateOnTop(self.mass, self.velocity)

    def named(self, at_centre: Callable[[int], tuple[int, ...]]) -> tuple[str, Sequence[int]]:
        return "load.kind", at_centre(1)

    def struck(self, packing: LoadedPacking) -> tuple[int, ...]:
        centre = packing.at_centre(1)
        return centre + tuple(sphere for sphere in packing.top_layer if sphere not in centre)

    @property
    def start_energy(self) -> str:
        return f"0.5*{num(self.mass)}*{num(self.velocity)}^2"

    def release_commands(self) -> list[str]:
        return [f"fix_modify      {self.kind} velocity {num(self.velocity)}"]

    def energy_in(self, packing: LoadedPacking) -> float:
        return self.plate.energy

    def speed_bound(self, packing: LoadedPacking) -> float:
        return _REBOUND * self.velocity

    def contact_energy(self, energy: float, law: ContactLaw, packing: LoadedPacking) -> float:
        """Limit the energy by the energy of a sphere that the plate throws against a wall, or
        by a fraction of the plate's energy if all layers are compressed equally.
        """
        share = self.plate.energy / (len(packing.top_layer) * packing.n_layers)
        thrown = packing.masses[1] * (_REBOUND * self.velocity) ** 2 / 2
        return min(energy, max(_OF_SHARE * share, thrown))

    def sentence(self, n_strikers: int) -> str:
        return f"impacted by a rigid plate of {self.mass:g} kg at {self.velocity:g} m/s along +z."

    @property
    def no_bare_target(self) -> str:
        return (
            'load.kind = "plate" loads all grains of the top; it has no equivalent on the bare '
            "target"
        )

    @classmethod
    def phrase(cls, case: Mapping[str, Any], write: Wording) -> str:
        velocity = case.get("load.velocity")
        if not velocity:
            return "plate"
        mass = write.number(case.get("load.mass"))
        return f"plate of {mass} kg at {write.number(velocity)} m/s"

    def check(self, names: Sequence[str], errors: ErrorList) -> None:
        missing = "missing; a plate requires a mass (kg)"
        errors.check((self.mass is None, "load.mass", missing))
