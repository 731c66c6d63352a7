"""Fall: the struck spheres start with the velocity that they have after a fall."""

import dataclasses
import math

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.loads.on_spheres import LoadOnSpheres

GRAVITY = 9.80665  # m/s^2


@dataclasses.dataclass(frozen=True, kw_only=True)
class FallLoad(LoadOnSpheres):
    """Velocity of the struck spheres after a fall from a height."""

    kind = "fall"
    means = "a height from which the struck spheres fall"
    gives_velocity = True
    strikes = True

    height: float = schema.number(
        "height from which the struck spheres fall", "m", above=0, default=0.1
    )

    def start_velocity(self, packing):
        return 0.0, 0.0, math.sqrt(2 * GRAVITY * self.height)

    def sentence(self, n_strikers):
        return f"{self.struck_spheres} fall from {self.height:g} m."


LOADS = (FallLoad,)
