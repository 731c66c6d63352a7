"""Deviations of finite-element contacts from the contact law, on loading and for each unload-reload
cycle.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import least_squares

from granwave.extensions.continuum.sphere_contact.case import SphereContactCase

LOADING, UNLOADING, RELOADING = range(3)  # branches of a history
RESOLVED = 0.3  # overlap over alpha_y below which the contact has too few elements for a comparison
#: ranges of the overlap over alpha_y, by name
RANGES = {"elastic": (RESOLVED, 1.0), "1_to_10": (1.0, 10.0), "10_to_50": (10.0, 50.0), "50_to_178": (50.0, 177.6),
          "beyond_178": (177.6, math.inf)}  # fmt: skip
_NEAR_ZERO = 0.05  # force / largest force of the part of unloading that gives the residual overlap
_FITTED = 0.02  # force / largest force above which the exponent is fitted
COMPARED = ("force", "contact_radius", "mean_pressure")
#: Quantities of a cycle with their units: its number from 1; overlap and force at the start of unloading; overlap at
#: which the force vanishes; n of ``F/F_max = ((alpha - alpha_R)/(alpha_max - alpha_R))^n``, fitted, and the largest
#: deviation from this fit over F_max; largest difference between reloading and unloading at the same overlap over
#: F_max; plastic work of the cycle / elastic energy released; residual overlap and exponent of the law for the
#: same peak overlap; largest difference between unloading and the law over the law's F_max.
OF_CYCLE = {
    "number": "1", "peak_overlap": "m", "peak_force": "N", "residual_overlap": "m", "exponent": "1", "misfit": "1",
    "reloading_difference": "1", "plastic_share": "1", "law_residual_overlap": "m", "law_exponent": "1",
    "law_difference": "1",
}  # fmt: skip


def compare_loading(case: SphereContactCase, history: pd.DataFrame) -> pd.DataFrame:
    """Compare first loading with the law.

    Returns
    -------
    DataFrame
        For each entry with contact overlap (m), force (N), contact radius (m) and mean pressure
        (Pa); ``law_force`` and ``law_contact_radius`` of the law at these overlaps;
        ``NAME_deviation`` of those `COMPARED`, per cent of the law's value.
    """
    rows = (
        (history["branch"] == LOADING) & (history["overlap"] > 0) & (history["contact_radius"] > 0)
    )
    loading = history.loc[rows, ["overlap", "force", "contact_radius"]].reset_index(drop=True)
    loading["mean_pressure"] = loading["force"] / (math.pi * loading["contact_radius"] ** 2)
    loading["law_force"] = case.law.loading_force(loading["overlap"].to_numpy())
    loading["law_contact_radius"] = case.law.contact_radius(loading["overlap"].to_numpy())
    law_pressure = loading["law_force"] / (math.pi * loading["law_contact_radius"] ** 2)
    for name, of_law in zip(
        COMPARED, (loading["law_force"], loading["law_contact_radius"], law_pressure), strict=True
    ):
        loading[f"{name}_deviation"] = 100 * (loading[name] / of_law - 1)
    return loading


def worst(case: SphereContactCase, loading: pd.DataFrame) -> dict[str, float]:
    """Return the largest and root mean square deviations, per cent, over all resolved overlaps and
    by range.
    """
    largest: dict[str, float] = {}
    scaled = (loading["overlap"] / case.yield_unit).to_numpy()
    for name in COMPARED:
        for label, (low, high) in {"": (RESOLVED, math.inf), **RANGES}.items():
            part = loading[f"{name}_deviation"].to_numpy()[(scaled >= low) & (scaled < high)]
            key = f"{name}_deviation_{label}_" if label else f"{name}_deviation_"
            largest[f"{key}max_percent"] = (
                float(part[np.abs(part).argmax()]) if len(part) else math.nan
            )
            largest[f"{key}rms_percent"] = (
                float(np.sqrt(np.mean(part**2))) if len(part) else math.nan
            )
    return largest


def compare_cycles(case: SphereContactCase, history: pd.DataFrame) -> pd.DataFrame:
    """Compare with the law the cycles that were completed and began under load: a row with
    `OF_CYCLE` for each.
    """
    ended = history.loc[history["branch"] == RELOADING, "cycle"].unique().tolist()
    down = history[(history["branch"] == UNLOADING) & (history["force"] > 0)]
    rows = [_cycle(case, history, number) for number in ended if (down["cycle"] == number).any()]
    return pd.DataFrame(rows, columns=list(OF_CYCLE), dtype=float)


def _cycle(case: SphereContactCase, history: pd.DataFrame, number: int) -> dict[str, Any]:
    own = history["cycle"] == number
    law = case.law
    up = history[own & (history["branch"] == RELOADING)]
    down = history[own & (history["branch"] == UNLOADING)]
    down = history.loc[down.index[0] - 1 : down.index[-1]]  # from the start of unloading
    start = down.iloc[0]
    peak = float(start["overlap"])
    most = float(start["force"])
    residual = _residual(down["overlap"].to_numpy(), down["force"].to_numpy(), most)
    fitted = down[down["force"] >= _FITTED * most]
    scaled = np.clip((fitted["overlap"].to_numpy() - residual) / (peak - residual), 1e-9, None)
    shares = fitted["force"].to_numpy() / most
    exponent = float(least_squares(lambda n: scaled ** n[0] - shares, 1.4).x[0])
    pressing = up[up["force"] > 0]
    rising = down.sort_values("overlap")
    before = np.interp(pressing["overlap"], rising["overlap"], rising["force"])
    of_law = law.force(down["overlap"].to_numpy(), np.full(len(down), peak))
    return {
        "number": number,
        "peak_overlap": peak,
        "peak_force": most,
        "residual_overlap": residual,
        "exponent": exponent,
        "misfit": np.abs(scaled**exponent - shares).max(),
        "reloading_difference": (pressing["force"] - before).abs().max() / most,
        "plastic_share": (up["plastic"].iloc[-1] - start["plastic"])
        / (start["elastic"] - down["elastic"].min()),
        "law_residual_overlap": float(law.residual_overlap(peak)),
        "law_exponent": float(law.unloading_exponent(peak)),
        "law_difference": np.abs(down["force"].to_numpy() - of_law).max() / of_law.max(),
    }


def _residual(overlap: np.ndarray, force: np.ndarray, most: float) -> float:
    """Extrapolate unloading to zero force, by a line through F^(2/3) (Hertz) in the last part."""
    near = (force > 0) & (force < _NEAR_ZERO * most)
    if near.sum() < 2:
        return float(overlap[force > 0].min())
    slope, level = np.polyfit(overlap[near], force[near] ** (2 / 3), 1)
    return float(-level / slope)
