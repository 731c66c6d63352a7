"""The numbers that sum a run up: ``summary.json``, SI units, null where a value does not apply.

What they are called, and where they are shown: `granwave.analysis.quantities`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.measures.driven import SteadyMotion, amplitude_sweep_of, mean_power_of, transmission_of
from granwave.analysis.measures.impact import velocity_normalised
from granwave.analysis.measures.lines import line_summary, sensor_accelerations, sensor_forces, sensor_velocities
from granwave.analysis.measures.target import protection, reached
from granwave.analysis.measures.waves import wave_speed_of
from granwave.analysis.measures.zone import HALF_LAW_LIMIT, LAW_LIMIT, PlasticZone, plastic_zone, zone_summary
from granwave.analysis.result.contacts import LISTED_FROM
from granwave.analysis.result.hdf5_file import AT_ONCE
from granwave.analysis.result.reader import Result, misfit
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.directories import changed_files
from granwave.lammps_inputs.files import plain, replace_text
from granwave.lammps_inputs.ownership import claim
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import velocities_of
from granwave.lammps_inputs.packing.walls import PLATE, SIDE_WALLS
from granwave.lammps_inputs.run_directory import SUMMARY_FILE

Summary = dict[str, Any]
_ROUNDING = 1e-12  # of the input
_TOUCH = 1e-6  # of the input, stored in contacts: bodies that store less have parted


def summarise(directory: str | Path, *, at_once: int = AT_ONCE, case: Case | None = None) -> Summary:
    """Sum up the ``result.h5`` of a run, and write the summary to ``summary.json`` beside it.

    Parameters
    ----------
    at_once
        Largest number of spheres or contacts in memory. The values do not depend on it.
    case
        Case that was run, if it was read before.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    InputError
        There is a summary.json that granwave did not write.
    """
    directory = Path(directory)
    with Result(directory, at_once, case) as result:
        summary = summary_of(result)
    text = json.dumps(plain(summary), indent=2, allow_nan=False)
    claim(directory, [SUMMARY_FILE])
    replace_text(directory / SUMMARY_FILE, text + "\n")
    return json.loads(text)


def summary_of(result: Result) -> Summary:
    """The summary of a result that is open."""
    record = result.record
    n_steps, smallest, largest = _timesteps(result)
    end_time = float(result["energy/time"][-1])
    wall_time = record.get("wall_time_s")
    return {
        "name": result.case.name,
        "n_spheres": result.n_spheres,
        "n_contacts": _count(result, "contacts/touching"),
        "n_loaded_contacts": _loaded(result),
        "timestep_s": end_time / n_steps if n_steps else None,
        "timestep_smallest_s": smallest,
        "timestep_largest_s": largest,
        "n_steps": n_steps,
        "end_time_s": end_time,
        **_energies(result),
        **_precompression(result),
        **_transmission(result),
        **_contacts(result),
        **_plasticity(result),
        **zone_summary(result),
        **_normalised(result),
        **_bottom(result),
        **_other_walls(result),
        **protection(result),
        **_bars(result),
        **_sensors(result),
        **line_summary(result),
        **_cylinders(result),
        "wave_speed_m_s": wave_speed_of(result),
        "impactor_velocity_m_s": float(result["energy/struck_velocity"][-1]),
        "restitution": restitution(result),
        "wall_time_s": wall_time,
        "sphere_steps_per_s": result.n_spheres * n_steps / wall_time if wall_time else None,
        "n_ranks": record.get("n_ranks"),
        "end_reason": record.get("end_reason"),
        "deck_changed": changed_files(result.path.parent) or None,
        "versions": result.versions,
    }


def _cylinders(result: Result) -> Summary:
    """Count the cylinders; nothing of a packing of spheres alone."""
    count = result.assembly.n_cylinders
    return {"n_cylinders": count} if count else {}


def restitution(result: Result) -> float | None:
    """Coefficient of restitution of a single collision: of two free spheres, or of one and the bottom wall.

    Of two equal spheres of which one rests, the struck one keeps (1 - e)/2 of its velocity; from a wall it returns with
    -e, of an oblique impact with the normal part. None for every other packing, and as long as the bodies touch.
    """
    case = result.case
    boundary = case.boundary
    moves = boundary.bottom_material is not None or boundary.bottom_support is not None
    if case.load.kind != "impact" or not assemble(case).plain or moves or case.precompression is not None:
        return None
    if case.load.angle and result.n_spheres > 1:
        return None
    if result["energy/elastic"][-1] > _TOUCH * result.energy_input:
        return None
    left = float(result["energy/struck_velocity"][-1]) / velocities_of(assemble(case))[result.struck[0]][2]
    if result.n_spheres == 2 and case.packing.kind == "chain" and case.boundary.bottom == "free":
        return 1 - 2 * left
    if result.n_spheres == 1 and case.boundary.bottom == "wall":
        return -left
    return None


def energy_balance_error(result: Result) -> float | None:
    """Largest error of the ledger over the largest input, see `granwave.analysis.result.reader`."""
    return float(np.max(misfit(result.ledger)) / result.largest_input) if result.largest_input else None


def zone_of(result: Result) -> PlasticZone:
    """The plastic zone at the end of the run."""
    found = []
    for positions, radii, yielded in result.blocks("spheres/position", "spheres/radius", "spheres/contacts_yielded"):
        plastic = yielded > 0
        found.append((positions[plastic], radii[plastic]))
    positions, radii = (np.concatenate(column) for column in zip(*found, strict=True))
    return plastic_zone(positions, radii, np.ones(len(radii), dtype=bool), result.origin)


def _timesteps(result: Result) -> tuple[int, float | None, float | None]:
    """Number of timesteps, and the smallest and the largest of them, s."""
    if "energy/timesteps" not in result:
        n_steps = int(result["energy/step"][-1])
        only = float(result["energy/time"][-1]) / n_steps if n_steps else None
        return n_steps, only, only
    smallest, largest = (float(result[f"energy/{which}_timestep"][-1]) for which in ("smallest", "largest"))
    return int(result["energy/timesteps"][-1]), smallest, largest


def _energies(result: Result) -> Summary:
    given = result.energy_input

    def final(name: str) -> float:
        return float(result[f"energy/{name}"][-1])

    def share(energy: float) -> float | None:
        return energy / given if given else None

    rubbed, plastic = final("friction"), float(result.yield_ledger[-1])
    if abs(plastic) < _ROUNDING * given:
        plastic = 0.0  # what is left of a difference
    holder, viscous, absorbed = (
        final(name) if f"energy/{name}" in result else None for name in ("holder", "viscous", "absorbed")
    )
    return {
        "energy_input_J": given,
        **{f"energy_{name}_J": final(name) for name in ("kinetic", "elastic", "dissipated", "rotational")},
        "energy_dissipated_wall_J": final("dissipated_wall"),
        "energy_dissipated_plastic_J": plastic,
        "energy_dissipated_friction_J": rubbed,
        "energy_dissipated_viscous_J": viscous,
        "energy_dissipated_holder_J": holder,
        "energy_absorbed_J": absorbed,
        "dissipated_fraction": share(final("dissipated")),
        "plastic_fraction": share(plastic),
        "friction_fraction": share(rubbed),
        "viscous_fraction": None if viscous is None else share(viscous),
        "holder_fraction": None if holder is None else share(holder),
        "absorbed_fraction": None if absorbed is None else share(absorbed),
        "energy_balance_error": energy_balance_error(result),
    }


def _transmission(result: Result) -> Summary:
    """Return what a row passes on of a load that oscillates."""
    found = transmission_of(result)
    swept = amplitude_sweep_of(result)
    power = mean_power_of(result)
    steady = found if isinstance(found, SteadyMotion) else None
    return {
        "transmission": steady.ratio if steady else None,
        "driven_velocity_m_s": steady.driven if steady else None,
        "load_power_W": power.given if power else None,
        "absorbed_power_W": power.absorbed if power else None,
        "amplitude_hysteresis": None if swept is None else swept.apart,
        "unsteady_part": steady.unsteady if steady else None,
    }


def _precompression(result: Result) -> Summary:
    """Return the values of the static stage before the run."""
    found = {"energy_stored_J": "stored", "precompression_residual": "residual"}
    return {
        key: float(result[f"prestage/{name}"][-1]) if f"prestage/{name}" in result else None
        for key, name in found.items()
    }


def _loaded(result: Result) -> int:
    """Pairs of spheres that bore a force in this run, those left out that were pressed by rounding alone."""
    found = 0
    for limit, overlap, force in result.blocks(
        "contacts/yield_overlap", "contacts/peak_overlap", "contacts/peak_force"
    ):
        least = LISTED_FROM * limit
        pressed = overlap > np.where(np.isfinite(least), least, 0.0)
        found += int(np.count_nonzero(pressed & (force > 0)))
    return found


def _count(result: Result, name: str) -> int:
    """Rows of a column that are not zero."""
    return sum(int(np.count_nonzero(values)) for (values,) in result.blocks(name))


def _largest(result: Result, name: str) -> float:
    """Largest value of a column, at least 0."""
    return max(float(np.max(values, initial=0.0)) for (values,) in result.blocks(name))


def _contacts(result: Result) -> Summary:
    def beyond(share: float) -> int | None:
        if result.assembly.has_cylinders:
            return int(np.count_nonzero(result.beyond_law(share)))
        if not result.has_law_limit:
            return None
        columns = result.blocks("contacts/peak_overlap", "contacts/effective_radius")
        return sum(int(np.count_nonzero(overlap > share * radius)) for overlap, radius in columns)

    return {
        "peak_force_N": _largest(result, "contacts/peak_force"),
        "peak_overlap_m": _largest(result, "contacts/peak_overlap"),
        "contacts_beyond_law": beyond(LAW_LIMIT),
        "contacts_beyond_half_law": beyond(HALF_LAW_LIMIT),
        "n_wall_contacts": len(result["wall_contacts/id"]),
    }


def _plasticity(result: Result) -> Summary:
    zone = zone_of(result)
    yields = result.yields
    return {
        "n_plastic_contacts": _count(result, "contacts/yielded"),
        "n_plastic_spheres": zone.n_spheres,
        "plastic_zone_volume_m3": zone.volume if yields else None,
        "plastic_zone_depth_m": zone.depth if yields else None,
        "plastic_zone_radius_m": zone.radius if yields else None,
    }


def _normalised(result: Result) -> Summary:
    law, case = result.law, result.case
    if not result.has_yield_force:
        return {"velocity_normalised": None, "energy_input_normalised": None}
    strength, velocity = law.yield_strength, case.load.velocity
    return {
        "velocity_normalised": velocity_normalised(velocity, law.effective_modulus, case.material.density, strength)
        if case.load.kind == "impact"
        else None,
        "energy_input_normalised": result.energy_input / (law.yield_force * law.yield_overlap),
    }


def _bottom(result: Result) -> Summary:
    found = reached(result)
    return {
        "wall_peak_force_N": found.peak_force if found else None,
        "wall_impulse_Ns": float(found.impulse[-1]) if found else None,
        "base_arrival_s": found.arrival if found else None,
    }


def _other_walls(result: Result) -> Summary:
    """Peak force and impulse of each side wall, and of a plate on the top; and how fast this is at the end."""
    found: Summary = {}
    for name in (name for name in result.names("walls") if name in SIDE_WALLS or name == PLATE):
        force, impulse = result[f"walls/{name}/force"], result[f"walls/{name}/impulse"]
        prefix = name if name == PLATE else f"wall_{name}"
        found |= {f"{prefix}_peak_force_N": float(force.max()), f"{prefix}_impulse_Ns": float(impulse[-1])}
    if f"walls/{PLATE}" in result:
        found["plate_velocity_m_s"] = -float(result[f"walls/{PLATE}/velocity"][-1])
        found["energy_plate_J"] = float(result["energy/plate"][-1])
    return found


def _bars(result: Result) -> Summary:
    """Energy in each bar at the end, kinetic and elastic."""
    names = [bar.name for bar in result.assembly.bars]
    return {f"energy_{name}_J": float(result[f"energy/{name}"][-1]) for name in names}


def _sensors(result: Result) -> Summary:
    """Largest force at each sensor of a chain; largest acceleration and speed at each of another packing."""
    if "chain" not in result:
        found = {"peak_acceleration_m_s2": sensor_accelerations(result), "peak_velocity_m_s": sensor_velocities(result)}
        return {
            f"sensor_{name}_{quantity}": float(np.linalg.norm(values, axis=1).max())
            for quantity, sensors in found.items()
            for name, values in sensors.items()
        }
    return {f"sensor_{name}_peak_force_N": float(force.max()) for name, force in sensor_forces(result).items()}
