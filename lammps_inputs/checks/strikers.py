"""Checks of strikers, and of the walls and the bottom that they may meet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import check_shape
from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing.walls import Wall, walls

_OVERLAP = 1e-6  # diameters; largest overlap of a striker with the bottom, for rounding


def check_strikers(case: Case, errors: ErrorList) -> None:
    """Check shapes of strikers, and that shifts from their positions are across their way."""
    no_effect = (
        "a striker starts in contact, so a shift along its direction of motion has no effect"
    )
    for key, striker in numbered("striker", case.striker).items():
        check_shape(striker, key, errors)
        for name, shift in (("offset", striker.offset), ("misalignment", striker.misalignment)):
            if any(striker.velocity) and any(shift) and not np.cross(shift, striker.velocity).any():
                expected = f"a component perpendicular to it: {no_effect}"
                errors.add(
                    f"{key}.{name}",
                    Mismatch(f"{show(shift)} along its direction of motion", expected),
                )


def check_below(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no striker overlaps the wall or bar below a chain; walls of other packings do not
    act on strikers.
    """
    case = assembly.case
    has_plane = case.boundary.bottom_rule.has_plane or case.bar is not None
    if not case.packing.rule.is_chain or not has_plane:
        return
    obstacle = "bar" if case.bar is not None else "wall at the bottom"
    for n, (_, centre) in enumerate(assembly.strikers, start=1):
        radius = assembly.diameter_of(assembly.lattice.n_spheres + n) / 2
        depth = centre[2] + radius - assembly.bottom()
        if depth > _OVERLAP * case.packing.diameter:
            fault = f"the {obstacle} overlaps it by {depth:.3g} m; remove one of them"
            errors.add(f"striker.{n}", fault)


def check_held_strikers(assembly: Assembly, errors: ErrorList) -> None:
    """Check that walls can hold strikers with ``walls = true``: the walls are at rest, act on all
    grains, and do not touch the strikers at the start.
    """
    case = assembly.case
    first = assembly.lattice.n_spheres + 1
    planes = [wall for wall in walls(assembly) if not wall.held_layer]
    stage = case.precompression
    for number, (striker, centre) in enumerate(assembly.strikers):
        if not striker.walls:
            continue
        depths = _depths_in_walls(assembly, planes, first + number, centre)
        deepest = max(depths, key=depths.__getitem__, default="")
        depth = depths.get(deepest, 0.0)
        key = f"striker.{number + 1}.walls"
        errors.check_first(
            (not planes, key, Mismatch("true, but there are no walls", "false")),
            (
                case.boundary.sides_touch is not None,
                key,
                Mismatch(
                    "true together with boundary.sides_touch, whose walls act only on selected "
                    "grains of the packing"
                ),
            ),
            (
                stage is not None and (stage.moves or stage.presses),
                key,
                Mismatch(
                    "true together with walls that move in (precompression), which would also "
                    "press the striker"
                ),
            ),
            (
                depth > _OVERLAP * case.packing.diameter,
                key,
                Mismatch(
                    f"true, but the striker overlaps the wall {deepest} by {depth:.3g} m",
                    remedy="place it inside, or remove this key",
                ),
            ),
        )


def _depths_in_walls(
    assembly: Assembly, planes: Sequence[Wall], sphere: int, centre: NDArray[np.float64]
) -> dict[str, float]:
    """Return the overlap of a striker with each wall, m, by name; negative for a gap."""
    radius = np.array([assembly.diameter_of(sphere) / 2])
    reach = extents(radius, [assembly.shape_of(sphere)])[0]
    depths = {}
    for wall in planes:
        towards = reach[:1] if wall.tube or wall.face else reach[wall.axis : wall.axis + 1]
        depths[wall.name] = -float(wall.gaps(centre[None], towards)[0])
    return depths
