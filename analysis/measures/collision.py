"""Coefficient of restitution of a single collision."""

from __future__ import annotations

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.packing.motion import velocities_of

#: Fraction of the input stored in contacts; bodies that store less have separated.
TOUCHING_ENERGY = 1e-6


def restitution(result: Result) -> float | None:
    """Coefficient of restitution of a single collision: of two free spheres, or of a sphere and the
    bottom wall.

    For two equal spheres, one at rest, the impactor keeps (1 - e)/2 of its velocity; from a wall it
    rebounds with -e times its velocity, in an oblique impact with -e times the normal component.
    None for every other packing, and as long as the bodies touch.
    """
    case = result.case
    boundary = result.case.boundary
    load = result.case.load
    bottom = boundary.bottom_rule
    moves = boundary.bottom_material is not None or boundary.bottom_support is not None
    if (
        not load.gives_velocity
        or not result.assembly.plain
        or moves
        or case.precompression is not None
    ):
        return None
    if (load.angle and result.n_spheres > 1) or result["energy/elastic"][
        -1
    ] > TOUCHING_ENERGY * result.energy_input:
        return None
    left = (
        float(result["energy/struck_velocity"][-1])
        / velocities_of(result.assembly)[result.struck[0]][2]
    )
    if result.n_spheres == 2 and case.packing.rule.is_chain and not bottom.bears:
        return 1 - 2 * left
    return -left if result.n_spheres == 1 and bottom.has_plane else None
