"""Values of a planned run, beside those of its `Plan`, and all of them for ``granwave check --json``."""

from __future__ import annotations

import dataclasses
from collections import Counter
from typing import Any

import numpy as np

from granwave.analysis.measures.target.bare_target import no_bare_target
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import Viscous, viscous_loss
from granwave.lammps_inputs.packing.assembly import Assembly, assemble
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing.motion import struck_site, written_in_parts
from granwave.lammps_inputs.plane_lattices import is_plane_crystal
from granwave.lammps_inputs.planning.cost import ANALYSED_AT_ONCE
from granwave.lammps_inputs.planning.plan import Plan

_LARGEST_OF_LAW = 0.2  # overlap over R* where the contact law ends


@dataclasses.dataclass(frozen=True)
class Coordination:
    """Contacts of the grains of a file or of a plane crystal: their mean, and the numbers of grains by contacts."""

    mean: float
    grains: dict[int, int]


def coordination_of(case: Case) -> Coordination | None:
    """Return the contacts found at the start in a file of grains or a plane crystal; None for other lattices."""
    if case.packing.grains is None and not is_plane_crystal(case.packing.kind):
        return None
    assembly = assemble(case)
    found = Counter(assembly.contacts().ravel().tolist())
    grains = Counter(found.values()) | Counter({0: assembly.n_spheres - len(found)})
    mean = sum(found.values()) / assembly.n_spheres
    return Coordination(mean, {number: n for number, n in sorted(grains.items()) if n})


@dataclasses.dataclass(frozen=True)
class Size:
    """Mass of a packing, kg, its height, and its widths along x and y, m; strikers and bars left out."""

    mass: float
    height: float
    width: tuple[float, float]


def size_of(assembly: Assembly) -> Size:
    """Return the size of a packing with its grains where they are placed."""
    case, lattice, sites = assembly.case, assembly.lattice, assembly.sites
    if sites is None:
        reach = extents(np.array([lattice.diameter / 2]), [case.packing.of_grain])
        low, high = lattice.bounds() + np.concatenate([-reach, reach])
        mass = lattice.n_spheres * case.sphere_mass
    else:
        there = sites.present
        shapes = assembly.grain_shapes()[: lattice.n_spheres]
        reach = extents(sites.diameter / 2, shapes)[there]
        place = sites.positions(1, lattice.n_spheres)[there]
        low, high = (place - reach).min(axis=0), (place + reach).max(axis=0)
        mass = float(assembly.sphere_masses()[: int(there.sum())].sum())  # without strikers
    x, y, z = (high - low).tolist()
    return Size(mass, z, (x, y))


@dataclasses.dataclass(frozen=True)
class Struck:
    """Sphere of the packing that the load hits first.

    Attributes
    ----------
    sphere
        Its id.
    aside_m
        Distance from the middle of the top, m; 0 of a sphere next to it.
    below_m
        Depth below the top, m.
    where
        Words on its place on the top: at a corner, an edge or an end; else empty.
    """

    sphere: int
    aside_m: float
    below_m: float
    where: str


def struck_place(assembly: Assembly) -> Struck | None:
    """Return the sphere that the load hits; None if it hits none in particular."""
    lattice, sphere = assembly.lattice, struck_site(assembly)
    if sphere is None or assembly.case.load.kind in ("plate", "grains") or assembly.case.incident_bar:
        return None
    place, top = lattice.positions(sphere, sphere)[0], lattice.top_layer
    at_top = lattice.positions(1, int(top.max()))[top - 1]
    if sphere not in top:
        return Struck(sphere, 0.0, float(place[2] - at_top[:, 2].min()), "")
    across = [axis for axis in (0, 1) if np.ptp(at_top[:, axis]) > lattice.diameter / 2]
    ends = sum(bool(np.abs(place[axis] - [at_top[:, axis].min(), at_top[:, axis].max()]).min() < lattice.diameter / 2)
               for axis in across)  # fmt: skip
    aside = float(np.linalg.norm(place[:2] - at_top[:, :2].mean(axis=0)))
    where = ("", "at an edge of the top" if len(across) > 1 else "at an end of the top", "at a corner of the top")
    return Struck(sphere, aside if aside > lattice.diameter else 0.0, 0.0, where[ends])


def loss_of(case: Case) -> Viscous | None:
    """Return the loss between two grains of the packing: that which a restitution asks for is found."""
    return viscous_loss(assemble(case), case.contact, case.material, case.material)


def beyond_law(case: Case, plan: Plan) -> bool:
    """Return True if the largest overlap is beyond the range of a law that was fitted."""
    return case.contact.entry.fitted and plan.peak_overlap_radius > _LARGEST_OF_LAW


def held_by_first_rank(assembly: Assembly) -> list[str]:
    """Return what makes the first rank hold all sites of a large packing at once; empty if nothing does."""
    if assembly.n_spheres <= ANALYSED_AT_ONCE:
        return []
    causes = {"unlike or missing spheres": assembly.sites is not None, "strikers": bool(assembly.strikers)}
    return [cause for cause, holds in causes.items() if holds]


def packing_values(case: Case, plan: Plan) -> dict[str, Any]:
    """Return the values of the plan of a packing; units are part of the names."""
    assembly, schedule, zone, coordination = assemble(case), plan.schedule, plan.zone, coordination_of(case)
    size, struck = size_of(assembly), struck_place(assembly)
    no_reduction = no_bare_target(case)
    return {
        "packing_mass_kg": size.mass,
        "packing_height_m": size.height,
        "packing_width_m": list(size.width),
        "struck": None if struck is None else dataclasses.asdict(struck),
        "nulls": {"peak_reduction": no_reduction} if no_reduction else {},
        "n_cylinders": assembly.n_cylinders,
        "n_contacts": plan.n_contacts,
        "coordination": None if coordination is None else dataclasses.asdict(coordination),
        "precompression": _static_load(case),
        "n_ranks": plan.n_ranks,
        "memory_first_rank_bytes": plan.space.first_rank,
        "memory_other_rank_bytes": plan.space.other_rank if plan.n_ranks > 1 else None,
        "timestep_s": schedule.first_timestep,
        "timestep_largest_s": schedule.largest_timestep if schedule.adaptive else schedule.first_timestep,
        "timestep_set_by": plan.limit.cause if plan.limit else None,
        "energy_tolerance": schedule.energy_tolerance if schedule.adaptive else None,
        "n_steps": schedule.n_steps // schedule.first_step,
        "end_time_s": schedule.end_time,
        "ends_by_itself": bool(schedule.block_steps),
        "n_frames": schedule.n_frames,
        "output_in_parts": written_in_parts(assembly),
        "held_by_first_rank": held_by_first_rank(assembly),
        "wall_time_longest_s": plan.times.longest,
        "wall_time_parts_s": dataclasses.asdict(plan.times),
        "peak_overlap_m": plan.peak_overlap,
        "peak_overlap_over_yield": plan.peak_overlap_yield,
        "peak_overlap_over_radius": plan.peak_overlap_radius,
        "peak_overlap_beyond_law": beyond_law(case, plan),
        "loss": None if (loss := loss_of(case)) is None else {"time_s" if loss[0] == "time" else "dashpot": loss[1]},
        "zone": None
        if zone is None
        else {
            "depth_m": min(zone.depth, zone.room["bottom"]),
            "radius_m": min(zone.radius, zone.room.get("sides", zone.radius)),
            "depth_in_larger_packing_m": zone.depth,
            "radius_in_larger_packing_m": zone.radius,
            "spread": zone.spread,
            "room_m": zone.room,
            "reaches": list(zone.reaches),
            "may_reach": list(zone.may_reach),
        },
    }


def _static_load(case: Case) -> dict[str, Any] | None:
    """Return the load before the impact."""
    stage = case.precompression
    if stage is None:
        return None
    return {
        "kind": stage.kind,
        "moves_m": stage.moves,
        "presses_N": stage.presses,
        "pressure_Pa": stage.pressure,
        "force_N": stage.force,
        "acceleration_m_s2": stage.acceleration if stage.kind == "gravity" else None,
        "takes_overlaps": stage.takes_overlaps,
    }
