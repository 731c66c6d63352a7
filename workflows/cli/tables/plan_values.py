"""Values of a planned run, in addition to its `Plan`, as ``granwave check --json`` prints them."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter
from typing import Any

import numpy as np

from granwave.analysis.measures.target import no_bare_target
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.contact import Contact
from granwave.lammps_inputs.contact.contact_advice import advice_on
from granwave.lammps_inputs.contact.law import ContactLoss, viscous_loss
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.cylinders import extents
from granwave.lammps_inputs.packing.found_contacts import period_of
from granwave.lammps_inputs.packing.motion import struck_site, written_in_parts
from granwave.lammps_inputs.planning.arrival import expected_arrival
from granwave.lammps_inputs.planning.cost import ANALYSED_AT_ONCE
from granwave.lammps_inputs.planning.encounters import encounters
from granwave.lammps_inputs.planning.plan import Plan
from granwave.workflows.cli.tables.grain_file_values import grain_file_values

_LARGEST_OF_LAW = 0.2  # overlap / R* where the contact law ends


def _size(assembly: Assembly) -> dict[str, Any]:
    """Return mass, height and widths along x and y of the initial packing; without strikers and
    bars.
    """
    case = assembly.case
    lattice = assembly.lattice
    sites = assembly.sites
    if sites.uniform:
        reach = extents(np.array([lattice.diameter / 2]), [case.packing.of_grain])
        low, high = lattice.bounds() + np.concatenate([-reach, reach])
        mass = lattice.n_spheres * case.sphere_mass
    else:
        there = sites.present
        shapes = assembly.grain_shapes()[: lattice.n_spheres]
        reach = extents(sites.diameter / 2, shapes)[there]
        place = sites.positions(1, lattice.n_spheres)[there]
        low = (place - reach).min(axis=0)
        high = (place + reach).max(axis=0)
        mass = float(assembly.sphere_masses()[: int(there.sum())].sum())  # without strikers
    x, y, z = (high - low).tolist()
    return {"packing_mass_kg": mass, "packing_height_m": z, "packing_width_m": [x, y]}


def _struck(assembly: Assembly) -> dict[str, Any] | None:
    """Return the sphere that the load hits first, and its position; None if it hits none in
    particular.

    ``aside_m`` is the distance of the sphere from the middle of the top, 0 for a sphere next to the
    middle. ``below_m`` is its depth below the top. ``where`` states whether it is at a corner, an
    edge or an end of the top.
    """
    lattice = assembly.lattice
    sphere = struck_site(assembly)
    if sphere is None or not assembly.case.load.hits_one_place or assembly.case.incident_bar:
        return None
    place = lattice.positions(sphere, sphere)[0]
    top = lattice.top_layer
    at_top = lattice.positions(1, int(top.max()))[top - 1]
    if sphere not in top:
        below = float(place[2] - at_top[:, 2].min())
        return {"sphere": sphere, "aside_m": 0.0, "below_m": below, "where": ""}
    low = at_top[:, :2].min(axis=0)
    high = at_top[:, :2].max(axis=0)
    near = lattice.diameter / 2
    wide = high - low > near
    ends = np.count_nonzero(wide & (np.minimum(place[:2] - low, high - place[:2]) < near))
    aside = float(np.linalg.norm(place[:2] - at_top[:, :2].mean(axis=0)))
    where = (
        "",
        "at an edge of the top" if wide.all() else "at an end of the top",
        "at a corner of the top",
    )[ends]
    return {
        "sphere": sphere,
        "aside_m": aside if aside > lattice.diameter else 0.0,
        "below_m": 0.0,
        "where": where,
    }


def _contacts_found(case: Case) -> dict[str, Any] | None:
    """Return the effect of each value of ``packing.contacts`` on grains of a file; None if there
    are none, or if all of them just touch.
    """
    packing = case.packing
    if packing.grains is None:
        return None
    grains = packing.grains.found or packing.grains
    advice = advice_on(case, grains, period_of(packing, case.boundary))
    if packing.contacts is None and not advice.n_overlapping:
        return None
    return {
        "way": packing.contacts,
        "last_place_m": advice.last_place,
        "tolerance_m": advice.tolerance,
        "n_within": advice.n_within,
        "n_beyond": advice.n_beyond,
        "n_overlapping": advice.n_overlapping,
        "largest_overlap_m": advice.largest_overlap,
        "touch_moves_m": advice.moved,
        "touch_leaves_m": advice.remaining,
        "largest_force_N": advice.largest_force,
        "choices": advice.choices,
    }


def _loss_values(contact: Contact, loss: ContactLoss | None) -> dict[str, Any] | None:
    """Return the size of a loss and its tangential ratio; None without a loss."""
    if loss is None or contact.loss is None:
        return None
    if loss[0] == "prony":
        return {
            "weights": list(contact.loss.weights or ()),
            "times_s": list(contact.loss.times or ()),
        }
    kind, size = loss
    values = {"time_s" if kind == "time" else "dashpot": size}
    if contact.loss.damps_surface and contact.friction:
        values["tangential"] = contact.loss.tangential
    return values


def packing_values(assembly: Assembly, plan: Plan) -> dict[str, Any]:
    """Return the values of the plan of a packing; units are part of the names."""
    case = assembly.case
    schedule = plan.schedule
    arrival = expected_arrival(assembly)
    zone = plan.zone
    stage = case.precompression
    no_reduction = no_bare_target(assembly)
    coordination = None
    rate = None
    held = {
        "dissimilar or missing spheres": not assembly.sites.uniform,
        "strikers": bool(assembly.strikers),
    }
    # a specified restitution is computed
    loss = viscous_loss(assembly, case.contact, case.material, case.material)
    rule = case.packing.rule
    if rule.is_plane_crystal or not rule.is_lattice:  # contacts of other lattices are known
        found = Counter(assembly.contacts().ravel().tolist())
        grains = Counter(found.values()) | Counter({0: assembly.n_spheres - len(found)})
        numbers = {number: n for number, n in sorted(grains.items()) if n}
        coordination = {"mean": sum(found.values()) / assembly.n_spheres, "grains": numbers}
    if assembly.has_rate and (hits := encounters(assembly)):
        # factor of the yield strength in the fastest collision, with whose velocity the contact
        # approaches
        velocity, fastest = max(
            ((math.sqrt(4 * one.energy / one.mass), one) for one in hits), key=lambda hit: hit[0]
        )
        law = fastest.law
        overlaps = np.array([law.yield_overlap, max(fastest.overlap, law.yield_overlap)])
        first, last = law.rate_factor(overlaps, velocity).tolist()
        rate = {
            "velocity_m_s": velocity,
            "factor_at_yield": first,
            "factor_at_largest_overlap": last,
        }
    return {
        **_size(assembly),
        "struck": _struck(assembly),
        "nulls": {"peak_reduction": no_reduction} if no_reduction else {},
        "n_cylinders": assembly.n_cylinders,
        "n_clumps": len(assembly.clumps),
        "n_grains_in_clumps": len(assembly.in_clumps),
        "n_contacts": plan.n_contacts,
        "coordination": coordination,
        "packing_file": grain_file_values(assembly),
        "contacts_found": _contacts_found(case),
        "precompression": None
        if stage is None
        else {
            "kind": stage.kind,
            "moves_m": stage.moves,
            "presses_N": stage.presses,
            "pressure_Pa": stage.pressure,
            "force_N": stage.force,
            "acceleration_m_s2": stage.acceleration if stage.rule.takes_acceleration else None,
            "takes_overlaps": stage.takes_overlaps,
        },
        "n_ranks": plan.n_ranks,
        "memory_first_rank_bytes": plan.first_rank,
        "memory_other_rank_bytes": plan.other_rank if plan.n_ranks > 1 else None,
        "timestep_s": schedule.first_timestep,
        "timestep_largest_s": schedule.largest_timestep
        if schedule.adaptive
        else schedule.first_timestep,
        "timestep_set_by": plan.limit.cause if plan.limit else None,
        "energy_tolerance": schedule.energy_tolerance if schedule.adaptive else None,
        "n_steps": schedule.n_steps // schedule.first_step,
        "end_time_s": schedule.end_time,
        "ends_by_itself": bool(schedule.block_steps),
        "n_frames": schedule.n_frames,
        "expected_arrival_s": arrival,
        "n_frames_before_arrival": None if arrival is None else schedule.n_frames_until(arrival),
        "output_in_parts": written_in_parts(assembly),
        # reasons for holding all sites of a large packing at once
        "held_by_first_rank": [
            cause for cause, holds in held.items() if holds and plan.n_spheres > ANALYSED_AT_ONCE
        ],
        "wall_time_longest_s": plan.times.longest,
        "wall_time_parts_s": dataclasses.asdict(plan.times),
        "peak_overlap_m": plan.peak_overlap,
        "peak_overlap_over_yield": plan.peak_overlap_yield,
        "peak_overlap_over_radius": plan.peak_overlap_radius,
        "peak_overlap_beyond_law": case.contact.entry.fitted
        and plan.peak_overlap_radius > _LARGEST_OF_LAW,
        "loss": _loss_values(case.contact, loss),
        "rate": rate,
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
