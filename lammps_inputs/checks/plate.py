"""Checks of a rigid plate on the free top, and of a gap between the packing and its side walls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from granwave.lammps_inputs.case.boundary import Boundary
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.precompression import Precompression
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.contact.initial_dents import LARGEST
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import materials_on_top


def check_plate(parts: Mapping[str, Any], errors: ErrorList) -> None:
    """Check that nothing else is on the top that a plate strikes."""
    load: Load | None = parts.get("load")
    if load is None or load.kind != "plate":
        return
    for name in ("striker", "incident_bar"):
        if parts.get(name):
            errors.add(name, 'found beside load.kind = "plate", which covers the whole top; take one of them out')
    stage: Precompression | None = parts.get("precompression")
    if stage is not None and stage.kind != "walls":
        errors.add(
            "precompression.kind",
            f'found {show(stage.kind)} beside load.kind = "plate", expected "walls": the plate is held while the walls '
            "move in, and would bear any other load",
        )


def check_side_gap(packing: PackingSection, boundary: Boundary, errors: ErrorList) -> None:
    """Check that there are side walls to leave a gap to, and that a negative gap leaves room for the packing."""
    gap, key = boundary.gap, "boundary.side_gap"
    if not gap:
        return
    if not (boundary.has_planes("x") or boundary.has_planes("y")):
        errors.add(key, f'found {gap:g} m, but there are no side walls; expected boundary.sides = "wall"')
    elif gap < -(most := LARGEST * packing.diameter / 2):
        errors.add(key, f"found {gap:g} m, expected {-most:g} m or more: the walls press at most {LARGEST} radii")


def check_top(assembly: Assembly, errors: ErrorList) -> None:
    """Check that a plate rests on spheres of one material, as each material has a fix of its own."""
    if assembly.case.load.plate is None:
        return
    names = [material.name or "?" for material in materials_on_top(assembly)]
    if len(names) != 1:
        errors.add(
            "load.kind",
            f'found "plate" on spheres of {" and ".join(names) or "no material"}, expected a top layer of one material',
        )
