"""An impact: the impacted spheres start with a velocity and a spin."""

from __future__ import annotations

import dataclasses
import math
from typing import ClassVar

from granwave.lammps_inputs.case import hints, schema
from granwave.lammps_inputs.case.loads.load import LoadedPacking, Vector, velocity_field
from granwave.lammps_inputs.case.loads.on_spheres import LoadOnSpheres


@dataclasses.dataclass(frozen=True, kw_only=True)
class ImpactLoad(LoadOnSpheres):
    """Initial velocity of the impacted spheres."""

    kind: ClassVar[str] = "impact"
    means: ClassVar[str] = "velocity of the impacted spheres"
    gives_velocity: ClassVar[bool] = True
    strikes: ClassVar[bool] = True

    velocity: float = velocity_field()
    angle: float = schema.number(
        "angle between the velocity of the impact and +z, towards +x",
        "degrees",
        at_least=0,
        below=90,
        default=0.0,
    )
    spin: tuple[float, float, float] = schema.vector(
        "angular velocity of the impacted spheres at the start", hints.SPIN
    )

    def start_velocity(self, packing: LoadedPacking) -> Vector:
        angle = math.radians(self.angle)
        return self.velocity * math.sin(angle), 0.0, self.velocity * math.cos(angle)

    def start_speed(self, packing: LoadedPacking) -> float:
        return self.velocity

    def impulse_on(self, mass: float) -> float:
        return mass * self.velocity

    def sentence(self, n_strikers: int) -> str:
        return f"{self.struck_spheres} impacted at {self.velocity:g} m/s along +z."
