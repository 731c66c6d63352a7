"""Checks of walls of regions: ``[[wall]]``."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.schema import ErrorList, numbered, show
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls
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
    positions = assembly.positions()[assembly.present]
    radii = assembly.sphere_diameters() / 2
    is_around = False
    for number, (key, entry) in enumerate(numbered("wall", case.wall).items(), start=1):
        region = f"wall{number}"
        faces = [wall for wall in walls(assembly) if wall.face and wall.face.region == region]
        gaps = np.min([face.gaps(positions, radii) for face in faces], axis=0)
        is_around = is_around or bool(np.isfinite(gaps).any())
        deepest = int(np.argmin(gaps))
        depth = -float(gaps[deepest])
        if depth > TOUCHING * case.packing.diameter:
            sphere = f"grain {assembly.ids[deepest]} stands {depth:.3g} m deep in its wall"
            fault = Mismatch(f"{show(entry.region)}: {sphere}", remedy="move the grain or the wall")
            errors.add(f"{key}.region", fault)
    if not is_around:
        found = f"{show(case.wall[0].region)}, in which there is no grain"
        errors.add("wall.1.region", Mismatch(found, "a region around grains"))
