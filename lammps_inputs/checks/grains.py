"""Checks of grains at places of their own, of grains that are held, and of loads on chosen grains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from granwave.lammps_inputs.case.bodies import Hold
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.case.material import Material, presets
from granwave.lammps_inputs.case.packing import PackingSection
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.case.sections import Boundary, Precompression
from granwave.lammps_inputs.lattices import TOUCHING
from granwave.lammps_inputs.packing.assembly import lattice_of
from granwave.lammps_inputs.packing.places import Places, places_of
from granwave.lammps_inputs.packing.sites import sites_of

if TYPE_CHECKING:
    from granwave.lammps_inputs.case.case import Case
    from granwave.lammps_inputs.case.grains import Grains

_KEY = "packing.grains"
_OF_LATTICES = {
    "replace": "the file gives each grain its diameter and material",
    "bar": "a bar needs a chain",
    "incident_bar": "a bar needs a chain",
}


def check_grains(parts: Mapping[str, Any], packing: PackingSection, errors: ErrorList) -> None:
    """Check the grains of a file, and that nothing is asked of them that only lattices have."""
    grains = packing.grains
    if grains is None:
        return
    for name, reason in _OF_LATTICES.items():
        if parts.get(name):
            errors.add(name, f'found with packing.kind = "file": {reason}; take it out')
    stage: Precompression | None = parts.get("precompression")
    if stage is not None and stage.kind != "walls" and (packing.cell is None or stage.kind == "gravity"):
        endless = ', or "uniaxial" or "uniform" of grains with packing.cell' if packing.cell is None else ""
        errors.add(
            "precompression.kind", f'found {show(stage.kind)} with packing.kind = "file", expected "walls"{endless}'
        )
    boundary: Boundary | None = parts.get("boundary")
    if boundary is not None and boundary.sides == "periodic":
        errors.add("boundary.sides", 'found "periodic" with packing.kind = "file", expected "free" or "wall"')
    _check_materials(parts, grains, errors)
    _check_overlaps(places_of(grains, packing.diameter), errors)
    load: Load | None = parts.get("load")
    if load is None:
        return
    if load.kind == "grains" and not grains.velocity.any():
        errors.add("load.kind", 'found "grains", but no grain has a velocity; give columns vx, vy, vz')
    if load.kind == "impact":
        moving = [one for one in load.index or () if one <= len(grains) and grains.velocity[one - 1].any()]
        if moving:
            errors.add("load.index", f"found grain {moving[0]}, which has a velocity in the file; give one of them")


def check_chosen(
    load: Load | None, holds: tuple[Hold, ...], packing: PackingSection, n: int, errors: ErrorList
) -> None:
    """Check the ids of ``load.index`` and ``[[hold]]``, and that no held sphere is struck.

    Parameters
    ----------
    n
        Number of spheres of the packing, without strikers.
    """
    struck = set(load.index or ()) if load is not None else set()
    for sphere in sorted(struck):
        if sphere > n:
            errors.add("load.index", f"found {sphere}, expected an id from 1 to {n}, the end of the packing")
            break
    if load is not None and load.kind == "grains" and packing.grains is None:
        errors.add("load.kind", f'found "grains" with packing.kind = {show(packing.kind)}, expected it with "file"')
    for place, hold in enumerate(holds, start=1):
        key = f"hold.{place}"
        if (hold.index is None) == (hold.group is None):
            found = "both index and group" if hold.index else "neither index nor group"
            errors.add(key, f"found {found}, expected one of them")
            continue
        if hold.group is not None:
            groups = sorted(set(packing.grains.group) - {""}) if packing.grains is not None else []
            if hold.group not in groups:
                there = f"one of {', '.join(map(show, groups))}" if groups else "index: no grain has a group"
                errors.add(f"{key}.group", f"found {show(hold.group)}, expected {there}")
                continue
        held = hold.index or packing.grains.of_group(hold.group or "")  # type: ignore[union-attr]
        if max(held) > n:
            errors.add(f"{key}.index", f"found {max(held)}, expected ids from 1 to {n}, the end of the packing")
            continue
        if not hold.axes and not hold.rotation:
            errors.add(key, "holds nothing; give directions, or rotation = true")
        _check_motion(load, hold, held, packing.grains, key, errors)


def check_tube(case: Case, errors: ErrorList) -> None:
    """Check that the packing fits into its tube, before this shrinks."""
    tube = case.boundary.sides_tube
    if tube is None or errors.lines:
        return
    lattice = lattice_of(case)
    sites = sites_of(case, lattice)
    diameter = np.full(lattice.n_spheres, lattice.diameter) if sites is None else sites.diameter
    place = (lattice if sites is None else sites).positions(1, lattice.n_spheres)
    reach = np.hypot(place[:, 0], place[:, 1]) + diameter / 2
    if sites is not None:
        reach[~sites.present] = 0.0
    widest = int(np.argmax(reach))
    if reach[widest] > tube + TOUCHING * lattice.diameter:
        errors.add(
            "boundary.sides.tube.radius",
            f"found {tube:g} m, but sphere {widest + 1} reaches {reach[widest]:.9g} m from the axis x = y = 0",
        )


def _check_motion(
    load: Load | None, hold: Hold, held: tuple[int, ...], grains: Grains | None, key: str, errors: ErrorList
) -> None:
    """Check that held spheres have no load or velocity in a direction in which they are held."""
    both = sorted(set(held) & set((load.index or ()) if load is not None else ()))
    if both and "z" in hold.axes:
        errors.add(key, f"holds sphere {both[0]}, which load.index strikes; take it out of one of them")
    if grains is None:
        return
    rows = np.array(held) - 1
    for axis, letter in enumerate("xyz"):
        moving = rows[grains.velocity[rows, axis] != 0]
        if letter in hold.axes and len(moving):
            errors.add(key, f"holds grain {moving[0] + 1} along {letter}, along which the file gives it a velocity")
            return


def _check_materials(parts: Mapping[str, Any], grains: Grains, errors: ErrorList) -> None:
    own: list[Material | None] = [parts.get("material"), *parts.get("materials", ())]
    known = {*presets(), *(one.name for one in own if one is not None)}
    for name in dict.fromkeys(grains.material):
        if name and name not in known:
            first = grains.material.index(name) + 1
            errors.add(
                _KEY,
                f"found material {show(name)} of grain {first}, expected a preset or a table [materials.{name}]",
            )


def _check_overlaps(places: Places, errors: ErrorList) -> None:
    pairs, overlaps = places.overlapping()
    if not len(pairs):
        return
    first, second = pairs[0].tolist()
    more = f" (and {len(pairs) - 1} more pairs)" if len(pairs) > 1 else ""
    if places.apart(pairs[:1])[0] == 0:
        errors.add(_KEY, f"found grains {first} and {second} at one place{more}; expected places of their own")
    else:
        errors.add(
            _KEY, f"found grains {first} and {second}, which overlap by {overlaps[0]:.3g} m{more}; move them apart"
        )
