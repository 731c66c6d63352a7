"""Force, impulse and energy at the target, the bottom of the packing, and how much less they are than without it.

Peak reduction: the largest force on the target without the packing (`granwave.analysis.measures.bare_target`)
over the largest with it. The ground is what the target itself rests on: the force on it is that out of the last spring
or damper, and the force on the target where that does not move. Of a precompressed packing what it presses with from
the start is no part of what the impact brings.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.analysis.measures.bare_target import bare_target_peak
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.hdf5_file import pairwise_sum
from granwave.lammps_inputs.packing.bodies import BAR

if TYPE_CHECKING:
    from granwave.analysis.result.reader import Result
    from granwave.lammps_inputs.case.boundary import Plate

ARRIVED = 0.01  # of the largest force that the impact brings to the bottom
_NOISE = 1e-6  # of the force from before the impact: how exact a static stage is


@dataclasses.dataclass(frozen=True, eq=False)
class Reached:
    """Record of the target; every array (n_times,).

    Attributes
    ----------
    time
        s.
    force
        Of the packing on the target, N.
    ground_force
        Of the target on the ground, N; None for a bar at a chain's end, whose far end is not recorded.
    displacement
        Of the target, outward from its place before the impact, m; None where it does not move.
    """

    time: Array
    force: Array
    ground_force: Array | None
    displacement: Array | None

    @property
    def impulse(self) -> Array:
        """Impulse of the force on the target so far, N s."""
        return np.concatenate([[0.0], np.cumsum(np.diff(self.time) * (self.force[1:] + self.force[:-1]) / 2)])

    @property
    def peak_force(self) -> float:
        """Largest force on the target, N."""
        return float(np.max(self.force, initial=0.0))

    @property
    def ground_peak_force(self) -> float | None:
        """Largest force on the ground, N."""
        return None if self.ground_force is None else float(np.max(self.ground_force, initial=0.0))

    @property
    def arrival(self) -> float | None:
        """Time at which the force has first risen by 1 % of its largest rise, s; None if it never does."""
        rise = risen(self.force)
        felt = np.flatnonzero(rise > max(ARRIVED * float(rise.max()), _NOISE * abs(float(self.force[0]))))
        return float(self.time[felt[0]]) if len(felt) else None


def risen(force: Array) -> Array:
    """A force less what it is at the start: what the impact brings."""
    return force - force[0]


def reached(result: Result) -> Reached | None:
    """Return the record of the bottom of a packing, or of the bar at a chain's end; None where there is neither."""
    name = next((name for name in ("bottom", BAR) if f"walls/{name}" in result), None)
    if name is None:
        return None
    group = f"walls/{name}"
    time, force = result[f"{group}/time"], result[f"{group}/force"]
    moved, ground = (result.get(f"{group}/{one}") for one in ("displacement", "ground_force"))
    if ground is None and name != BAR:
        ground = force
    return Reached(time, force, ground, None if moved is None else moved - moved[0])


def period_of(plate: Plate) -> float:
    """Return the period of a plate on its spring, undamped, s."""
    return 2 * math.pi * math.sqrt(plate.mass / plate.stiffness)


def protection(result: Result) -> dict[str, Any]:
    """The part of the summary that is about the target; null where it does not apply."""
    found = reached(result)
    mass, height = _mass(result), _height(result)
    without = bare_target_peak(result.case, float(result["energy/time"][-1])) if found else None
    reduction = ground_reduction = None
    if found is not None and without is not None:
        if found.force.argmax() < len(found.force) - 1:  # else it still rises: the peak is not known
            reduction = _ratio(without[0], found.force)
        ground_reduction = None if found.ground_force is None else _ratio(without[1], found.ground_force)

    def final(name: str) -> float | None:
        values = result.get(f"energy/{name}")
        return None if values is None else float(values[-1])

    at_rest = 0.0 if "walls/bottom" in result else None  # what does not move takes no energy
    return {
        "target_peak_force_N": found.peak_force if found else None,
        "ground_peak_force_N": found.ground_peak_force if found else None,
        "target_peak_displacement_m": float(np.abs(found.displacement).max())
        if found is not None and found.displacement is not None
        else None,
        "energy_target_J": at_rest if final("target") is None else final("target"),
        "support_energy_J": final("support"),
        "support_lost_J": final("support_lost"),
        "unprotected_peak_force_N": without[0] if without else None,
        "unprotected_ground_peak_force_N": without[1] if without and found and found.ground_force is not None else None,
        "peak_reduction": reduction,
        "ground_peak_reduction": ground_reduction,
        "packing_mass_kg": mass,
        "packing_height_m": height,
        "peak_reduction_per_kg": None if reduction is None else reduction / mass,
        "peak_reduction_per_m": None if reduction is None else reduction / height,
    }


def _mass(result: Result) -> float:
    """Mass of the packing, strikers left out, which come last, kg."""
    n_sites = result.assembly.lattice.n_spheres
    inside = sum(int(np.count_nonzero(ids <= n_sites)) for (ids,) in result.blocks("spheres/id"))
    return pairwise_sum(lambda rows: result.rows_read("spheres/mass", rows), inside, result.at_once)


def _height(result: Result) -> float:
    """Height of the packing, strikers left out, m."""
    top, bottom = np.inf, -np.inf
    for part in result.parts():
        inside = part.in_packing
        if inside.any():
            depth, radii = part["spheres/position"][inside, 2], part["spheres/radius"][inside]
            top, bottom = min(top, (depth - radii).min()), max(bottom, (depth + radii).max())
    return float(bottom - top)


def _ratio(without: float, force: Array) -> float | None:
    largest = float(risen(force).max())
    return without / largest if largest > 0 and without > 0 else None
