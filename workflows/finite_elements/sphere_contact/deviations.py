"""Deviations of finite-element contacts from the contact law, on loading and for each unload-reload cycle."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.study import LOADING, RELOADING, UNLOADING, History, yield_unit

RESOLVED = 0.3  # overlap over alpha_y below which the contact has too few elements for a comparison
#: ranges of the overlap over alpha_y, by name
RANGES = {"elastic": (RESOLVED, 1.0), "1_to_10": (1.0, 10.0), "10_to_50": (10.0, 50.0), "50_to_178": (50.0, 177.6),
          "beyond_178": (177.6, math.inf)}  # fmt: skip
_NEAR_ZERO = 0.05  # force over the largest one: the last part of unloading, which gives the residual overlap
_FITTED = 0.02  # force over the largest one from which on the exponent is fitted

Array = NDArray[np.float64]


@dataclasses.dataclass(frozen=True, eq=False)
class Loading:
    """First loading compared with the law; all arrays are (n_entries,).

    Attributes
    ----------
    overlap, force, contact_radius, mean_pressure
        Overlaps, m, forces, N, contact radii, m, and mean contact pressures, Pa.
    law_force, law_contact_radius
        Forces, N, and contact radii, m, of the law at these overlaps.
    unit
        Overlap that scales the ranges, m; see `yield_unit`.
    """

    overlap: Array
    force: Array
    contact_radius: Array
    mean_pressure: Array
    law_force: Array
    law_contact_radius: Array
    unit: float

    @property
    def deviations(self) -> dict[str, Array]:
        """Deviations from the law by quantity, per cent of its value."""
        law_pressure = self.law_force / (math.pi * self.law_contact_radius**2)
        return {
            "force": 100 * (self.force / self.law_force - 1),
            "contact_radius": 100 * (self.contact_radius / self.law_contact_radius - 1),
            "mean_pressure": 100 * (self.mean_pressure / law_pressure - 1),
        }

    def worst(self) -> dict[str, float]:
        """Return the largest and root mean square deviations, per cent, over all resolved overlaps and by range."""
        found: dict[str, float] = {}
        scaled = self.overlap / self.unit
        for name, values in self.deviations.items():
            for label, (low, high) in {"": (RESOLVED, math.inf), **RANGES}.items():
                part = values[(scaled >= low) & (scaled < high)]
                key = f"{name}_deviation_{label}_" if label else f"{name}_deviation_"
                found[f"{key}max_percent"] = float(part[np.abs(part).argmax()]) if len(part) else math.nan
                found[f"{key}rms_percent"] = float(np.sqrt(np.mean(part**2))) if len(part) else math.nan
        return found


@dataclasses.dataclass(frozen=True)
class Cycle:
    """One unloading and reloading.

    Attributes
    ----------
    number
        Number of the cycle, from 1.
    peak_overlap, peak_force
        Overlap, m, and force, N, at the start of unloading.
    residual_overlap
        Overlap at which the force vanishes, m.
    exponent
        n of ``F/F_max = ((alpha - alpha_R)/(alpha_max - alpha_R))^n``, fitted.
    misfit
        Largest deviation from this fit over F_max.
    reloading_difference
        Largest difference between reloading and unloading at the same overlap over F_max.
    plastic_share
        Plastic work of the cycle over the elastic energy released.
    law_residual_overlap, law_exponent
        Residual overlap, m, and exponent of the law for the same peak overlap.
    law_difference
        Largest difference between unloading and the law over the law's F_max.
    """

    number: int
    peak_overlap: float
    peak_force: float
    residual_overlap: float
    exponent: float
    misfit: float
    reloading_difference: float
    plastic_share: float
    law_residual_overlap: float
    law_exponent: float
    law_difference: float


def compare_loading(case: SphereContactCase, history: History) -> Loading:
    """Compare first loading with the law."""
    rows = history.rows(LOADING)
    overlap, force = history.column("overlap")[rows], history.column("force")[rows]
    radius = np.array(history.contact_radii)[rows]
    kept = (overlap > 0) & (radius > 0)
    overlap, force, radius = overlap[kept], force[kept], radius[kept]
    return Loading(
        overlap=overlap,
        force=force,
        contact_radius=radius,
        mean_pressure=force / (math.pi * radius**2),
        law_force=case.law.loading_force(overlap),
        law_contact_radius=case.law.contact_radius(overlap),
        unit=yield_unit(case),
    )


def compare_cycles(case: SphereContactCase, history: History) -> list[Cycle]:
    """Compare with the law the cycles that were completed and began under load."""
    force = history.column("force")
    ended = [n for n in range(1, max(history.cycles, default=0) + 1) if len(history.rows(RELOADING, n))]
    return [_cycle(case, history, n) for n in ended if (force[history.rows(UNLOADING, n)] > 0).any()]


def _cycle(case: SphereContactCase, history: History, number: int) -> Cycle:
    down, up = history.rows(UNLOADING, number), history.rows(RELOADING, number)
    start = down[0] - 1
    overlap, force = history.column("overlap"), history.column("force")
    plastic, elastic = history.column("plastic"), history.column("elastic")
    peak, most = float(overlap[start]), float(force[start])
    down = np.concatenate([[start], down])
    law = case.law
    residual = _residual(overlap[down], force[down], most)
    fitted = down[force[down] >= _FITTED * most]
    scaled = np.clip((overlap[fitted] - residual) / (peak - residual), 1e-9, None)
    exponent = float(least_squares(lambda n: scaled ** n[0] - force[fitted] / most, 1.4).x[0])
    pressing = up[force[up] > 0]
    order = np.argsort(overlap[down])
    before = np.interp(overlap[pressing], overlap[down][order], force[down][order])
    of_law = law.force(overlap[down], np.full(len(down), peak))
    released = elastic[start] - elastic[down].min()
    return Cycle(
        number=number,
        peak_overlap=peak,
        peak_force=most,
        residual_overlap=residual,
        exponent=exponent,
        misfit=float(np.abs(scaled**exponent - force[fitted] / most).max()),
        reloading_difference=float(np.abs(force[pressing] - before).max() / most) if len(pressing) else math.nan,
        plastic_share=float((plastic[up[-1]] - plastic[start]) / released),
        law_residual_overlap=float(law.residual_overlap(peak)),
        law_exponent=float(law.unloading_exponent(peak)),
        law_difference=float(np.abs(force[down] - of_law).max() / of_law.max()),
    )


def _residual(overlap: Array, force: Array, most: float) -> float:
    """Extrapolate unloading to zero force, by a line through F^(2/3) (Hertz) in the last part."""
    near = (force > 0) & (force < _NEAR_ZERO * most)
    if near.sum() < 2:
        return float(overlap[force > 0].min())
    slope, level = np.polyfit(overlap[near], force[near] ** (2 / 3), 1)
    return float(-level / slope)
