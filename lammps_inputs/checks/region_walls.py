"""Checks of walls of regions: ``[[wall]]``."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import Wall, walls
from granwave.lammps_inputs.packing_kind import TOUCHING


def check_region_walls(assembly: Assembly, errors: ErrorList) -> None:
    """Check that walls of regions go with the rest of a case, and that no grain stands in one."""
    case = assembly.case
    if not case.wall:
        return
    stage = case.precompression
    there = {
        "precompression": stage is not None,
        'boundary.sides = "periodic"': case.boundary.periodic,
        "cylinders": assembly.has_cylinders,
        "an elastic bar": bool(assembly.bars),
        "cohesion": case.has_cohesion,
    }
    remedy = "such walls hold spheres from the start of a run"
    faults = [
        Mismatch(f"it with {what}", remedy=remedy) for what, is_there in there.items() if is_there
    ]
    errors.check(*((True, "wall.1.region", fault) for fault in faults))
    if faults:
        return
    for number, key in enumerate(numbered("wall", case.wall), start=1):
        own = [
            wall for wall in walls(assembly) if wall.face and wall.face.region == f"wall{number}"
        ]
        _check_places(assembly, own, f"{key}.region", errors)


def _check_places(assembly: Assembly, faces: list[Wall], key: str, errors: ErrorList) -> None:
    """Check that grains are inside of a region, and none stands in its faces."""
    ids = assembly.ids
    positions = assembly.positions()[assembly.present]
    radii = assembly.sphere_diameters() / 2
    gaps = np.min([face.gaps(positions, radii) for face in faces], axis=0)
    found = show(assembly.case.wall[int(key.split(".")[1]) - 1].region)
    if not np.isfinite(gaps).any():
        errors.add(key, Mismatch(f"{found}, in which there is no grain", "a region around grains"))
        return
    deepest = int(np.argmin(gaps))
    depth = -float(gaps[deepest])
    if depth > TOUCHING * assembly.case.packing.diameter:
        sphere = f"grain {ids[deepest]} stands {depth:.3g} m deep in its wall"
        errors.add(key, Mismatch(f"{found}: {sphere}", remedy="move the grain or the wall"))
