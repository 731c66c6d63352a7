"""Summary of a sphere contact for ``summary.json``, in SI units; deviations in per cent."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.versions import versions_of
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.deviations import Cycle, compare_cycles, compare_loading
from granwave.workflows.finite_elements.sphere_contact.solver import Solver
from granwave.workflows.finite_elements.sphere_contact.study import LOADING, History, yield_unit

_PACKAGES = ("numpy", "numba", "scipy", "h5py", "matplotlib")


def summarise(case: SphereContactCase, solver: Solver, history: History, wall_time: float) -> dict[str, Any]:
    """Return the values of summary.json.

    Parameters
    ----------
    wall_time
        Wall time of the time integration, s.
    """
    law, last = case.law, history.ledgers[-1]
    loading = compare_loading(case, history)
    summary: dict[str, Any] = {
        "name": case.name,
        "kind": "sphere-contact",
        "n_bodies": len(solver.bodies),
        "n_elements": solver.n_elements,
        "n_steps": solver.n_steps,
        "end_reason": history.end_reason,
        "effective_radius_m": law.effective_radius,
        "effective_modulus_Pa": law.effective_modulus,
        "yield_overlap_m": law.yield_overlap,
        "yield_force_N": law.yield_force,
        "max_overlap_m": float(history.column("overlap").max()),
        "max_force_N": float(history.column("force").max()),
        "contact_radius_m": max(history.contact_radii),
        "mean_pressure_Pa": float(loading.mean_pressure[-1]) if len(loading.mean_pressure) else math.nan,
        **loading.worst(),
        **_of_cycles(compare_cycles(case, history)),
        **_quasi_static(case, history),
        "energy_input_J": last.work,
        "energy_elastic_J": last.elastic,
        "energy_dissipated_J": last.plastic,
        "energy_kinetic_J": last.kinetic,
        "energy_hourglass_J": last.hourglass,
        "energy_viscous_J": last.viscous,
        "energy_damping_J": last.damping,
        "energy_contact_J": last.penalty,
        "energy_balance_error": _balance_error(case, history),
        "hourglass_share": last.hourglass / last.work if last.work else math.nan,
        "wall_time_s": wall_time,
        "element_steps_per_s": solver.n_elements * solver.n_steps / wall_time,
        "n_ranks": 1,
        "versions": versions_of(_PACKAGES),
    }
    return summary


def significant(case: SphereContactCase, history: History) -> NDArray[np.bool_]:
    """Return True for entries beyond first yield (0.1 of the largest overlap if nothing yields), (n_entries,)."""
    return history.column("overlap") >= min(yield_unit(case), 0.1 * case.max_overlap)


def _of_cycles(cycles: list[Cycle]) -> dict[str, float]:
    exponents = [cycle.exponent for cycle in cycles]
    residuals = [(c.residual_overlap - c.law_residual_overlap) / c.peak_overlap for c in cycles]

    def most(name: str) -> float:
        return max((getattr(cycle, name) for cycle in cycles), default=math.nan)

    return {
        "n_unloadings": len(cycles),
        "unloading_exponent_min": min(exponents, default=math.nan),
        "unloading_exponent_max": max(exponents, default=math.nan),
        "unloading_misfit_percent": 100 * most("misfit"),
        "unloading_law_difference_percent": 100 * most("law_difference"),
        "residual_overlap_deviation_percent_of_peak": 100 * max(residuals, key=abs, default=math.nan),
        "reloading_difference_percent": 100 * most("reloading_difference"),
        "unloading_plastic_share": most("plastic_share"),
    }


def _quasi_static(case: SphereContactCase, history: History) -> dict[str, float]:
    """Compare, from first yield on, kinetic and internal energy, forces at face and contact, and penetrations."""
    kept = significant(case, history)
    loading = kept & (np.array(history.branches) == LOADING) & (history.column("force") > 0)
    internal = history.column("elastic") + history.column("plastic")
    difference = 100 * (history.column("face_force")[loading] / history.column("force")[loading] - 1)
    penetrations = np.array(history.penetrations)[kept] / history.column("overlap")[kept]
    kinetic = history.column("kinetic")[kept] / internal[kept]
    any_loading = bool(loading.any())
    return {
        "kinetic_share_max": float(kinetic.max()) if len(kinetic) else math.nan,
        "face_force_difference_max_percent": float(np.abs(difference).max()) if any_loading else math.nan,
        "face_force_difference_rms_percent": float(np.sqrt(np.mean(difference**2))) if any_loading else math.nan,
        "face_force_difference_mean_percent": float(np.mean(difference)) if any_loading else math.nan,
        "penetration_share_max": float(penetrations.max()) if len(kinetic) else math.nan,
    }


def _balance_error(case: SphereContactCase, history: History) -> float:
    """Return the largest error of the energy balance over the work done so far, from first yield on."""
    kept = significant(case, history)
    if not kept.any():
        return math.nan
    return float(np.abs(history.column("balance")[kept] / history.column("work")[kept]).max())
