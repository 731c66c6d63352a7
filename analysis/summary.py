"""The numbers that sum a run up: ``summary.json``, SI units, null where a value does not apply."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import numpy as np

from granwave.analysis.plasticity import HALF_LAW_LIMIT, LAW_LIMIT, PlasticZone, plastic_zone
from granwave.analysis.result import Result

SUMMARY_FILE = "summary.json"
Summary = dict[str, Any]


def summarise(directory: str | Path) -> Summary:
    """Sum up the ``result.h5`` of a run, and write the summary to ``summary.json`` beside it.

    Returns
    -------
    dict
        What summary.json holds.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    """
    directory = Path(directory)
    with Result(directory) as result:
        summary = summary_of(result)
    text = json.dumps({key: _plain(value) for key, value in summary.items()}, indent=2, allow_nan=False)
    scratch = directory / f".{SUMMARY_FILE}.{os.getpid()}"
    scratch.write_text(text + "\n", encoding="utf-8")
    os.replace(scratch, directory / SUMMARY_FILE)
    return json.loads(text)


def summary_of(result: Result) -> Summary:
    """The summary of a result that is open."""
    record = result.record
    n_steps = int(result["energy/step"][-1])
    end_time = float(result["energy/time"][-1])
    wall_time = record.get("wall_time_s")
    return {
        "name": result.case.name,
        "n_spheres": result.n_spheres,
        "n_contacts": int(np.count_nonzero(result["contacts/touching"])),
        "timestep_s": end_time / n_steps if n_steps else None,
        "n_steps": n_steps,
        "end_time_s": end_time,
        **_energies(result),
        **_contacts(result),
        **_plasticity(result),
        **_normalised(result),
        **_bottom(result),
        "impactor_velocity_m_s": float(result["energy/struck_velocity"][-1]),
        "wall_time_s": wall_time,
        "sphere_steps_per_s": result.n_spheres * n_steps / wall_time if wall_time else None,
        "n_ranks": record.get("n_ranks"),
        "end_reason": record.get("end_reason"),
        "versions": result.versions,
    }


def velocity_normalised(velocity: float, modulus: float, density: float, yield_strength: float) -> float:
    """Impact velocity in units that make materials collapse on one curve (thesis 5.11).

    ``(2/sqrt 3) (2/(1.6 pi))^2 E*^2 sqrt(rho) sigma_y^-2.5 v``; for brass 4 m/s give 37.9.

    Parameters
    ----------
    velocity
        m/s.
    modulus
        E* of two spheres, Pa.
    density
        kg/m^3.
    yield_strength
        Pa.
    """
    scale = 2 / math.sqrt(3) * (2 / (1.6 * math.pi)) ** 2
    return scale * modulus**2 * math.sqrt(density) * yield_strength**-2.5 * velocity


def energy_balance_error(result: Result) -> float | None:
    """Largest |kinetic + elastic + dissipated - input| of the ledger over the final input."""
    if not result.energy_input:
        return None
    total = result["energy/kinetic"] + result["energy/elastic"] + result["energy/dissipated"]
    return float(np.max(np.abs(total - result["energy/input"])) / result.energy_input)


def zone_of(result: Result) -> PlasticZone:
    """The plastic zone at the end of the run."""
    plastic = result["spheres/contacts_yielded"] > 0
    return plastic_zone(result["spheres/position"], result["spheres/radius"], plastic, result.origin)


def _energies(result: Result) -> Summary:
    final = {name: float(result[f"energy/{name}"][-1]) for name in ("kinetic", "elastic", "dissipated")}
    given = result.energy_input
    return {
        "energy_input_J": given,
        **{f"energy_{name}_J": value for name, value in final.items()},
        "energy_dissipated_wall_J": float(result["energy/dissipated_wall"][-1]),
        "dissipated_fraction": final["dissipated"] / given if given else None,
        "energy_balance_error": energy_balance_error(result),
    }


def _contacts(result: Result) -> Summary:
    limit = result.law.effective_radius
    overlaps = result["contacts/peak_overlap"]

    def beyond(share: float) -> int | None:
        return int(np.count_nonzero(overlaps > share * limit)) if result.has_law_limit else None

    return {
        "peak_force_N": float(np.max(result["contacts/peak_force"], initial=0.0)),
        "peak_overlap_m": float(np.max(overlaps, initial=0.0)),
        "contacts_beyond_law": beyond(LAW_LIMIT),
        "contacts_beyond_half_law": beyond(HALF_LAW_LIMIT),
        "n_wall_contacts": len(result["wall_contacts/id"]),
    }


def _plasticity(result: Result) -> Summary:
    zone = zone_of(result)
    yields = result.yields
    return {
        "n_plastic_contacts": int(np.count_nonzero(result["contacts/yielded"])),
        "n_plastic_spheres": zone.n_spheres,
        "plastic_zone_volume_m3": zone.volume if yields else None,
        "plastic_zone_depth_m": zone.depth if yields else None,
        "plastic_zone_radius_m": zone.radius if yields else None,
    }


def _normalised(result: Result) -> Summary:
    law, case = result.law, result.case
    if not result.yields:
        return {"velocity_normalised": None, "energy_input_normalised": None}
    strength = law.yield_strength
    return {
        "velocity_normalised": velocity_normalised(
            case.load.velocity, law.effective_modulus, case.material.density, strength
        ),
        "energy_input_normalised": result.energy_input / (law.yield_force * law.yield_overlap),
    }


def _bottom(result: Result) -> Summary:
    if "walls/bottom" not in result:
        return {"wall_peak_force_N": None, "wall_impulse_Ns": None}
    time, force = result["walls/bottom/time"], result["walls/bottom/force"]
    return {
        "wall_peak_force_N": float(np.max(force, initial=0.0)),
        "wall_impulse_Ns": float(np.trapezoid(force, time)),
    }


def _plain(value: Any) -> Any:
    """NaN and infinity as null, which JSON has."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
