"""Checks of walls of regions: ``[[wall]]``."""

from __future__ import annotations

import numpy as np

from granwave.lammps_inputs.case.schema import ErrorList, numbered
from granwave.lammps_inputs.errors import Mismatch
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.packing_kind import TOUCHING

_OTHER_UNIT = 300.0  # ratio of the size of a surface to that of the packing


def check_region_walls(assembly: Assembly, errors: ErrorList) -> None:
    """Check that walls of regions are compatible with the case, and that no grain overlaps them."""
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
    remedy = "walls of this kind act on spheres from the start of a run"
    faults = [
        Mismatch(f"this key with {what}", remedy=remedy)
        for what, is_there in there.items()
        if is_there
    ]
    errors.check(*((True, f"wall.1.{case.wall[0].key_of_shape}", fault) for fault in faults))
    if faults:
        return
    _check_units(assembly, errors)
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
            sphere = f"grain {assembly.ids[deepest]} overlaps its wall by {depth:.3g} m"
            fault = Mismatch(f"{entry.label}: {sphere}", remedy="move the grain or the wall")
            errors.add(f"{key}.{entry.key_of_shape}", fault)
    if not is_around:
        found = f"{case.wall[0].label}, which contains no grain"
        errors.add("wall.1.region", Mismatch(found, "a region around grains"))


def _check_units(assembly: Assembly, errors: ErrorList) -> None:
    """Check that no surface is so large that its file is probably not in metres."""
    size = float(np.ptp(assembly.bounds(), axis=0).max())
    for key, entry in numbered("wall", assembly.case.wall).items():
        if entry.triangles is None or entry.units is not None:
            continue
        extent = float(np.ptp(entry.corners.reshape(-1, 3), axis=0).max())
        if not size / _OTHER_UNIT < extent < size * _OTHER_UNIT:
            found = f"a surface of {extent:.3g} m, and grains in {size:.3g} m"
            remedy = 'set the unit of the file, such as units = "mm" or units = "m"'
            errors.add(f"{key}.stl", Mismatch(found, "sizes of the same order", remedy=remedy))
