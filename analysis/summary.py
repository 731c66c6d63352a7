"""Summary of a run: ``summary.json``, SI units, null if a value does not apply.

Their names, and where they are shown: `granwave.analysis.quantities`.
"""

from __future__ import annotations

import json
import logging
import math
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.measures.collision import restitution
from granwave.analysis.measures.driven import (
    SteadyMotion,
    amplitude_sweep_of,
    mean_power_of,
    transmission_of,
)
from granwave.analysis.measures.impactor import impactor_velocity
from granwave.analysis.measures.incomplete_values import INCOMPLETE, incomplete_values
from granwave.analysis.measures.law_errors import law_errors
from granwave.analysis.measures.lines import (
    line_summary,
    sensor_accelerations,
    sensor_forces,
    sensor_velocities,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target import unprotected
from granwave.analysis.measures.target_record import Reached, reached
from granwave.analysis.measures.waves import wave_speed_of
from granwave.analysis.measures.zone_size import HALF_LAW_LIMIT, LAW_LIMIT, zone_summary
from granwave.analysis.quantities import ENTRIES
from granwave.analysis.result.contacts import is_loaded
from granwave.analysis.result.hdf5_file import AT_ONCE
from granwave.analysis.result.reader import Result, misfit
from granwave.lammps_inputs.contact.law import velocity_normalised
from granwave.lammps_inputs.extensions import joined, loaded
from granwave.lammps_inputs.files import plain, replace_text
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.motion import start_speed
from granwave.lammps_inputs.packing.walls import PLATE, SIDE_WALLS
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.rounding import without_rounding
from granwave.lammps_inputs.run_directory import SUMMARY_FILE

logger = logging.getLogger(__name__)

Summary = dict[str, Any]
_ROUNDING = 1e-12  # fraction of the input
_ENERGIES = ("kinetic", "elastic", "dissipated", "rotational", "dissipated_wall")
_DISSIPATED = ("plastic", "friction", "viscous", "holder")
# for contacts with resistance to rolling or twisting, or with cohesion
_RESISTED = ("rolling", "twisting", "adhesion")
_CONTACT_COLUMNS = (
    "peak_overlap",
    "peak_force",
    "effective_radius",
    "yield_overlap",
    "touching",
    "yielded",
    "dissipated_energy",
)
_OTHER_LOSSES = ("friction_energy", "viscous_energy")  # losses of contacts, where present


def summarise(
    directory: AnyPath,
    *,
    at_once: int = AT_ONCE,
    assembly: Assembly | None = None,
    processes: Processes = ALONE,
) -> Summary:
    """Sum up the ``result.h5`` of a run, and write the summary to ``summary.json`` next to it.

    Parameters
    ----------
    at_once
        Largest number of spheres or contacts in memory. The values do not depend on it.
    assembly
        All bodies of the case that was run, if it was read before.
    processes
        Processes that read the contacts.

    Returns
    -------
    dict
        Content of summary.json.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    InputError
        There is a summary.json that granwave did not write.
    """
    results = ResultDirectory.at(directory)
    with Result(results, at_once, assembly) as result:
        summary = summary_of(result, processes)
        summary |= _added_values(result, summary)
    text = json.dumps(without_rounding(plain(summary)), indent=2, allow_nan=False)
    results.claim([SUMMARY_FILE])
    replace_text(results / SUMMARY_FILE, text + "\n")
    return json.loads(text)


def summary_of(result: Result, processes: Processes = ALONE) -> Summary:
    """The summary of a result that is open."""
    of_contacts = _of_contacts(result, processes)
    largest_overlap = of_contacts["peak_overlap"]
    rebound = restitution(result)
    record = result.record
    n_cylinders = result.assembly.n_cylinders
    n_clumps = len(result.assembly.clumps)
    end_time = float(result["energy/time"][-1])
    wall_time = record.get("wall_time_s")
    n_steps = int(result["energy/timesteps" if "energy/timesteps" in result else "energy/step"][-1])
    timestep = end_time / n_steps if n_steps else None
    return {
        "name": result.case.name,
        "n_spheres": result.n_spheres,
        "n_contacts": of_contacts["touching"],
        "n_loaded_contacts": of_contacts["loaded"],
        "timestep_s": timestep,
        "timestep_smallest_s": _last(result, "energy/smallest_timestep", timestep),
        "timestep_largest_s": _last(result, "energy/largest_timestep", timestep),
        "n_steps": n_steps,
        "end_time_s": end_time,
        **_energies(result),
        "energy_stored_J": _last(result, "prestage/stored"),
        "precompression_residual": _last(result, "prestage/residual"),
        **_transmission(result),
        "peak_force_N": of_contacts["peak_force"],
        "peak_force_with_walls_N": max(
            of_contacts["peak_force"],
            float(result["wall_contacts/peak_force"].max(initial=0.0)),
        ),
        "peak_overlap_m": largest_overlap if largest_overlap > 0 else None,
        "contacts_beyond_law": of_contacts["beyond_law"],
        "contacts_beyond_half_law": of_contacts["beyond_half_law"],
        "n_wall_contacts": len(result["wall_contacts/id"]),
        "n_plastic_contacts": of_contacts["yielded"],
        "n_dissipating_contacts": of_contacts["dissipating"] if result.yields else None,
        **_plasticity(result),
        **zone_summary(result),
        **_normalised(result),
        **_walls(result),
        **{
            f"energy_{bar.name}_J": float(result[f"energy/{bar.name}"][-1])
            for bar in result.assembly.bars
        },
        **_sensors(result),
        **line_summary(result),
        **({"n_cylinders": n_cylinders} if n_cylinders else {}),
        **({"n_clumps": n_clumps} if n_clumps else {}),
        "wave_speed_m_s": wave_speed_of(result),
        "impactor_velocity_m_s": impactor_velocity(result),
        "restitution": rebound,
        **law_errors(result, rebounds=rebound is not None),
        "wall_time_s": wall_time,
        "sphere_steps_per_s": result.n_spheres * n_steps / wall_time if wall_time else None,
        "n_ranks": record.get("n_ranks"),
        "end_reason": record.get("end_reason"),
        "energy_balance_accepted": record.get("energy_balance_accepted"),
        INCOMPLETE: incomplete_values(result),
        "deck_changed": result.results.changed_deck() or None,
        "versions": result.versions,
    }


def check_value_names() -> None:
    """Check that no two values of summary.json have the same name, as far as extensions declare
    their values; to be called before a run.

    Raises
    ------
    InputError
        Two values have the same name, or an extension cannot be loaded.
    """
    names = loaded("quantities")
    added = {}
    for extension in loaded("summary"):
        added[extension] = {entry.name: entry for entry in names.get(extension, ())}
    joined("value of summary.json", {entry.name: entry for entry in ENTRIES}, added)


def _added_values(result: Result, own: Summary) -> Summary:
    """Return the values of extensions by name; those of one that fails are omitted.

    Raises
    ------
    InputError
        Two values have the same name.
    """
    values = {}
    for extension, summary_values in loaded("summary").items():
        try:
            found = dict(summary_values(result))
            json.dumps(plain(found), allow_nan=False)
            values[extension] = found
        except Exception as error:  # an error in someone's extension; the other values are computed
            reason = f"{type(error).__name__}: {error}"
            logger.warning("values of the extension %s are omitted: %s", extension, reason)
    added = joined("value of summary.json", dict.fromkeys(own), values)
    return {name: added[name] for name in added if name not in own}


def _last(result: Result, name: str, default: float | None = None) -> float | None:
    """Return the last value of a column, or the default if the run does not have it."""
    return float(result[name][-1]) if name in result else default


def _energies(result: Result) -> Summary:
    """Energies at the end, fractions of the input, and the largest error of the energy balance
    divided by the largest input.
    """
    given = result.energy_input
    plastic = float(result.yield_ledger[-1])
    largest = result.largest_input
    lost = [*_DISSIPATED, *(name for name in _RESISTED if f"energy/{name}" in result)]
    final = {
        name: _last(result, f"energy/{name}")
        for name in (*_ENERGIES, *lost, "dissipated", "absorbed")
    }
    final["plastic"] = (
        0.0 if abs(plastic) < _ROUNDING * given else plastic
    )  # remainder of a difference
    shares = {name: final[name] for name in ("dissipated", *lost, "absorbed")}
    return {
        "energy_input_J": given,
        **{f"energy_{name}_J": final[name] for name in _ENERGIES},
        **{f"energy_dissipated_{name}_J": final[name] for name in _DISSIPATED},
        "energy_absorbed_J": final["absorbed"],
        **{f"energy_dissipated_{name}_J": final[name] for name in lost},
        **{f"{name}_fraction": energy / given if given and energy is not None else None
           for name, energy in shares.items()},
        "energy_balance_error": float(np.max(misfit(result.ledger)) / largest) if largest else None,
    }  # fmt: skip


def _transmission(result: Result) -> Summary:
    """Return the transmission of an oscillating load along a chain."""
    found = transmission_of(result)
    swept = amplitude_sweep_of(result)
    steady = found if isinstance(found, SteadyMotion) else None
    given, absorbed = mean_power_of(result) or (None, None)
    return {
        "transmission": steady.ratio if steady else None,
        "driven_velocity_m_s": steady.driven if steady else None,
        "load_power_W": given,
        "absorbed_power_W": absorbed,
        "amplitude_hysteresis": None if swept is None else swept.apart,
        "unsteady_part": steady.unsteady if steady else None,
    }


def _of_contacts(result: Result, processes: Processes) -> dict[str, Any]:
    """Return numbers of contacts, and the largest force and overlap; a large table is divided among
    processes.
    """
    n_rows = len(result.file["contacts/i"])
    size = result.at_once
    if n_rows <= size:
        parts = [_of_rows(_columns(result))]
    else:
        parts = list(
            processes.map(
                partial(_of_block, result.path, size, result.assembly), range(0, n_rows, size)
            )
        )
    found: dict[str, Any] = {
        name: (max if name.startswith("peak") else sum)(part[name] for part in parts)
        for name in parts[0]
    }
    for name, share in (("beyond_law", LAW_LIMIT), ("beyond_half_law", HALF_LAW_LIMIT)):
        if result.assembly.has_cylinders:
            found[name] = int(np.count_nonzero(result.beyond_law(share)))
        elif not result.has_law_limit:
            found[name] = None
    return found


def _of_block(path: Path, size: int, assembly: Assembly, first: int) -> dict[str, float]:
    with Result(path, size, assembly, checked=True) as result:
        return _of_rows(_columns(result, slice(first, first + size)))


def _columns(result: Result, rows: slice | tuple[()] = ()) -> dict[str, Array]:
    """Return the columns of some contacts, and the columns of other losses, if there are any."""
    others = [name for name in _OTHER_LOSSES if f"contacts/{name}" in result]
    names = (*_CONTACT_COLUMNS, *others)
    if rows == ():
        return {name: result[f"contacts/{name}"] for name in names}
    return {name: result.read(f"contacts/{name}", rows) for name in names}


def _of_rows(columns: dict[str, Array]) -> dict[str, float]:
    """Return the contribution of some contacts to the counts; pairs that overlap only by rounding
    are not loaded.
    """
    overlap = columns["peak_overlap"]
    force = columns["peak_force"]
    radius = columns["effective_radius"]
    yielded = columns["yielded"] > 0
    lost = columns["dissipated_energy"]
    by_yielding = lost - sum(columns[name] for name in _OTHER_LOSSES if name in columns)
    counted = {
        "touching": columns["touching"],
        "yielded": yielded,
        "dissipating": yielded & (by_yielding > _ROUNDING * lost),
        "loaded": is_loaded(overlap, columns["yield_overlap"], force),
        "beyond_law": overlap > LAW_LIMIT * radius,
        "beyond_half_law": overlap > HALF_LAW_LIMIT * radius,
    }
    largest = {
        "peak_force": float(force.max(initial=0.0)),
        "peak_overlap": float(overlap.max(initial=0.0)),
    }
    return {name: int(np.count_nonzero(values)) for name, values in counted.items()} | largest


def _plasticity(result: Result) -> Summary:
    """Number of contacts and spheres that yielded, and volume and extent of these spheres."""
    found = [
        (positions[yielded > 0], radii[yielded > 0])
        for positions, radii, yielded in result.blocks(
            "spheres/position", "spheres/radius", "spheres/contacts_yielded"
        )
    ]
    dissipating = [
        np.count_nonzero(energy > 0) for (energy,) in result.blocks("spheres/dissipated_energy")
    ]
    positions, radii = (np.concatenate(column) for column in zip(*found, strict=True))
    below = positions[:, 2] - result.origin[2]
    from_axis = result.distance_from_axis(positions)
    yields = result.yields
    return {
        "n_plastic_spheres": len(radii),
        "n_dissipating_spheres": int(sum(dissipating)),
        "plastic_zone_volume_m3": float(np.sum(4 / 3 * np.pi * radii**3)) if yields else None,
        "plastic_zone_depth_m": float(np.max(below, initial=0.0)) if yields else None,
        "plastic_zone_radius_m": float(np.max(from_axis, initial=0.0)) if yields else None,
    }


def _normalised(result: Result) -> Summary:
    """Velocity and energy divided by their values at first yield."""
    law = result.law
    case = result.case
    speed = None
    energy = None
    if result.has_yield_force:
        energy = result.energy_input / (law.yield_force * law.yield_overlap)
        if case.load.gives_velocity:
            material = law.effective_modulus, case.material.density, law.yield_strength
            speed = velocity_normalised(start_speed(result.assembly), *material)
    return {"velocity_normalised": speed, "energy_input_normalised": energy}


def _walls(result: Result) -> Summary:
    """Return the forces and energies at the target, the bottom and other walls, and their reduction
    by the packing.

    Peak reduction: the largest force on the target without the packing divided by the largest force
    with it. The initial force of a precompressed packing is not part of the dynamic force.
    """
    target = reached(result)
    bare = unprotected(result.assembly, float(result["energy/time"][-1])) if target else None
    ground_rise = target.ground_dynamic_peak_force if target else None
    bare_ground_peak = bare.ground_peak_force if bare and ground_rise is not None else None
    reduction = None
    if target and bare:
        reduction = _reduction(target, bare.peak_force, target.dynamic_peak_force)
    mass, height = _mass_and_height(result)
    energy_of_fixed = 0.0 if "walls/bottom" in result else None
    return {
        **_impulse_on(target),
        **_side_walls(result),
        **_plate(result),
        "target_peak_force_N": target.peak_force if target else None,
        "ground_peak_force_N": target.ground_peak_force if target else None,
        "target_peak_displacement_m": _largest_displacement(target),
        "energy_target_J": _last(result, "energy/target", energy_of_fixed),
        "support_energy_J": _last(result, "energy/support"),
        "support_lost_J": _last(result, "energy/support_lost"),
        "unprotected_peak_force_N": bare.peak_force if bare else None,
        "unprotected_ground_peak_force_N": bare_ground_peak,
        "peak_reduction": reduction,
        "ground_peak_reduction": _reduction(target, bare_ground_peak, ground_rise),
        "packing_mass_kg": mass,
        "packing_height_m": height,
        "peak_reduction_per_kg": None if reduction is None else reduction / mass,
        "peak_reduction_per_m": None if reduction is None else reduction / height,
    }


def _impulse_on(target: Reached | None) -> Summary:
    """Return the peak force and the impulse on the target, and when the force arrives."""
    if target is None:
        return dict.fromkeys(("wall_peak_force_N", "wall_impulse_Ns", "base_arrival_s"))
    under_static = target.has_static_force
    is_sampled = target.largest_force is None and len(target.time) > 1
    return {
        "wall_peak_force_N": target.peak_force,
        **({"wall_dynamic_peak_force_N": target.dynamic_peak_force} if under_static else {}),
        **({"wall_sample_s": _record_interval(target)} if is_sampled else {}),
        "wall_impulse_Ns": float(target.impulse[-1]),
        **({"wall_dynamic_impulse_Ns": float(target.dynamic_impulse[-1])} if under_static else {}),
        "base_arrival_s": target.known_arrival,
    }


def _record_interval(target: Reached) -> float:
    """Return the longest time between two records of the force on the target, s."""
    return float(np.diff(target.time).max())


def _side_walls(result: Result) -> Summary:
    """Return the peak force and the impulse on each side wall and on a moving plate."""
    summary: Summary = {}
    for name in result.names("walls"):
        if name in SIDE_WALLS or name == PLATE:
            prefix = name if name == PLATE else f"wall_{name}"
            summary[f"{prefix}_peak_force_N"] = float(result[f"walls/{name}/force"].max())
            summary[f"{prefix}_impulse_Ns"] = float(result[f"walls/{name}/impulse"][-1])
    return summary


def _plate(result: Result) -> Summary:
    """Return the velocity of a moving plate into the packing at the end, and its energy."""
    if f"walls/{PLATE}" not in result:
        return {}
    return {
        "plate_velocity_m_s": -float(result[f"walls/{PLATE}/velocity"][-1]),
        "energy_plate_J": float(result["energy/plate"][-1]),
    }


def _largest_displacement(target: Reached | None) -> float | None:
    """Return the largest displacement of the target, m; None for a fixed one."""
    if target is None or target.displacement is None:
        return None
    return float(np.abs(target.displacement).max())


def _reduction(target: Reached | None, bare_peak: float | None, rise: float | None) -> float | None:
    """Return peak force without the packing / largest dynamic force with it; None without these
    forces, before the wave arrives, or while the force on the target still rises at the end.
    """
    if target is None or not target.is_reached or target.rises_at_end:
        return None
    if not bare_peak or not rise or rise <= 0:
        return None
    return bare_peak / rise


def _mass_and_height(result: Result) -> tuple[float, float]:
    """Mass (kg) and height (m) of the packing, without strikers."""
    masses = []
    top = np.inf
    bottom = -np.inf
    for part in result.parts():
        inside = part.in_packing
        depth = part["spheres/position"][inside, 2]
        radii = part["spheres/radius"][inside]
        top = (depth - radii).min(initial=top)
        bottom = (depth + radii).max(initial=bottom)
        masses += part["spheres/mass"][inside].tolist()
    return math.fsum(masses), float(
        bottom - top
    )  # the same to the last digit for any division of the packing


def _sensors(result: Result) -> Summary:
    """Largest force at each sensor of a chain; largest acceleration and speed at each sensor of
    another packing.
    """
    if "chain" in result:
        return {
            f"sensor_{name}_peak_force_N": float(force.max())
            for name, force in sensor_forces(result).items()
        }
    found = {
        "peak_acceleration_m_s2": sensor_accelerations(result),
        "peak_velocity_m_s": sensor_velocities(result),
    }
    peaks = {}
    for quantity, sensors in found.items():
        for name, values in sensors.items():
            peaks[f"sensor_{name}_{quantity}"] = float(np.linalg.norm(values, axis=1).max())
    return peaks
