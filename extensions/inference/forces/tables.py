"""Summary and main values of inferred forces, as values and in words; numbers of several instants
are lists.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.quantities import Quantity
from granwave.analysis.summary_table import lines
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.rounding import without_rounding

if TYPE_CHECKING:
    from granwave.extensions.inference.forces.infer import Inference

ENTRIES = (
    Quantity("name"),
    Quantity("kind"),
    Quantity("measurement", meaning="File of measured grains, or directory of the run."),
    Quantity("state", meaning="Relation of strains and stresses."),
    Quantity("n_instants", "Instants"),
    Quantity("time_s", "Instant", "Time of the instant; null for a table without times."),
    Quantity("n_grains", "Grains"),
    Quantity("n_contacts", "Candidate contacts", "Pairs of grains, and grains at walls, within "
        "the tolerance."),
    Quantity("n_loaded_contacts", "Loaded contacts"),
    Quantity("n_significant_contacts", "Contacts with a force above two standard errors",
             "Number of contacts with a normal force above two standard errors, because noise "
             "causes small forces at most of the candidate contacts. Null without standard "
             "errors."),
    Quantity("n_equations", "Equations"),
    Quantity("n_unknowns", "Components of forces"),
    Quantity("condition_number", meaning="Ratio of the extreme singular values of the equations."),
    Quantity("weights", meaning="Weights of the equations: equal, white or correlated."),
    Quantity("friction", "Coefficient of friction"),
    Quantity("largest_force_N", "Largest contact force"),
    Quantity("mean_normal_force_N", "Mean normal force", "Mean over the loaded contacts."),
    Quantity("n_sliding_contacts", "Sliding contacts", "Contacts with a tangential force within "
                                                       "0.1 % of friction times normal force."),
    Quantity("residual_fraction", "Unexplained fraction of the data",
             "Root of the sum of squares of the residuals, relative to the data."),
    Quantity("chi2_per_equation", "Chi squared per degree of freedom",
             "Weighted sum of squared residuals, divided by its expectation for the given noise "
             "(about the number of equations minus the number of free force components; a sliding "
             "contact counts one unknown less): near 1 if noise and friction are correct; null "
             "without known noise."),
    Quantity("standard_error_fraction", "Standard error of the forces",
             "Root of the sum of squares of the standard errors, relative to the forces, from "
             "repetitions with noise."),
    Quantity("repetitions", meaning="Number of repetitions with noise."),
    Quantity("youngs_modulus_Pa", "Young's modulus", "Modulus of the first grain, given or "
                                                     "determined. "
        "Null for measured stresses."),
    Quantity("youngs_modulus_error_Pa", "Standard error of Young's modulus", "Error of the "
        "determined modulus; null if "
        "the modulus was given."),
    Quantity("true_force_error", "Error of the forces relative to the true forces",
             "For synthetic measurements of a run: root of the sum of squares of the errors, "
             "relative to the true forces; mean over all repetitions."),
    Quantity("noise", "Noise of strains and accelerations",
             "For synthetic measurements of a run: noise relative to the root mean square, or a "
             "list."),
    Quantity("frame_rate_Hz", meaning="For synthetic measurements of a run: frames per second of "
        "the camera."),
    Quantity("position_noise_m", meaning="For synthetic measurements of a run: error of measured "
        "positions."),
    Quantity("acceleration_error", "Error of the accelerations",
             "For synthetic measurements of a run: defined like the error of the forces, and "
             "caused by frame rate and position errors."),
    Quantity("notes", meaning="Assumptions for quantities that were not measured."),
    Quantity("versions"),
)  # fmt: skip
QUANTITIES = {entry.name: entry for entry in ENTRIES}

_SLIDING = 1e-3  # fraction of the limit of friction
_ERRORS = 2.0  # standard errors that a normal force must exceed to be significant
_LOADED = 1e-6  # fraction of the largest force; smaller forces are errors of the solver
KIND = "inference"


def instant_summary(one: Inference, time: float) -> dict[str, Any]:
    """Return the values of one instant."""
    size = np.linalg.norm(one.force, axis=1)
    loaded = size > _LOADED * size.max(initial=0.0)
    friction = one.settings.friction_of(one.contacts)
    shear = np.linalg.norm(one.force[:, 1:], axis=1)
    sliding = loaded & (friction > 0) & (shear >= (1 - _SLIDING) * friction * one.force[:, 0])
    known = one.spread is not None or one.settings.deviations.complete(one.grains)
    weighted = known and one.weights != "equal" and one.n_free > 0
    modulus = None if one.grains.modulus is None else float(one.grains.modulus[0]) * one.factor
    values = {
        "time_s": time,
        "n_grains": len(one.grains),
        "n_contacts": len(one.contacts),
        "n_loaded_contacts": int(np.count_nonzero(loaded)),
        "n_significant_contacts": _n_significant(one, loaded),
        "n_equations": one.equations.n_equations,
        "n_unknowns": one.n_unknowns,
        "condition_number": one.condition,
        "largest_force_N": float(size.max(initial=0.0)),
        "mean_normal_force_N": float(one.force[loaded, 0].mean()) if loaded.any() else 0.0,
        "n_sliding_contacts": int(np.count_nonzero(sliding)),
        "residual_fraction": one.relative_residual,
        "chi2_per_equation": one.chi2 / one.n_free if weighted else None,
        "standard_error_fraction": _standard_error(one),
        "youngs_modulus_Pa": modulus,
        "youngs_modulus_error_Pa": _modulus_error(one, modulus),
    }
    return without_rounding(values)


def _n_significant(one: Inference, loaded: NDArray[np.bool_]) -> int | None:
    """Return the number of loaded contacts whose normal force is clearly above its standard error;
    None without errors.
    """
    if one.spread is None:
        return None
    clear = one.force[:, 0] > _ERRORS * one.spread[:, 0]
    return int(np.count_nonzero(loaded & clear))


def _standard_error(one: Inference) -> float | None:
    """Return the relative standard error of all forces; None without errors or forces."""
    total = float(np.linalg.norm(one.force))
    if one.spread is None or total <= 0:
        return None
    return float(np.linalg.norm(one.spread)) / total


def _modulus_error(one: Inference, modulus: float | None) -> float | None:
    """Return the error of the Young's modulus, Pa; None where none was sought."""
    if one.search is None or modulus is None:
        return None
    return modulus * one.search.error


def summary_of(
    name: str,
    measurement: str,
    state: str,
    found: Sequence[Inference],
    times: Sequence[float],
    notes: Sequence[str],
) -> dict[str, Any]:
    """Return the content of summary.json; values of several instants are lists."""
    each = [instant_summary(one, time) for one, time in zip(found, times, strict=True)]
    values = dict(each[0])
    if len(each) > 1:
        for key in values:
            values[key] = [one[key] for one in each]
    settings = found[0].settings
    summary = values | {
        "name": name,
        "kind": KIND,
        "measurement": measurement,
        "state": state,
        "n_instants": len(found),
        "weights": found[0].weights,
        "friction": settings.friction,
        "repetitions": settings.repetitions if found[0].spread is not None else 0,
        "notes": list(notes),
        "versions": versions_of(["numpy", "scipy", "clarabel"]),
    }
    return {key: summary[key] for key in QUANTITIES if key in summary}


def in_words(summary: Mapping[str, Any]) -> str:
    """Return the main values, a line each."""

    def shown(key: str, form: str, factor: float = 1.0) -> str:
        values = summary.get(key)
        if not isinstance(values, list):
            values = [values]
        numbers = [
            value if factor == 1 else factor * value
            for value in values
            if isinstance(value, int | float)
        ]
        if not numbers:
            return ""
        low = format(min(numbers), form)
        high = format(max(numbers), form)
        return low if low == high else f"{low} to {high}"

    significant = shown("n_significant_contacts", "d")
    counted = ("n_significant_contacts" if significant else "n_loaded_contacts", "d")
    above = " above two standard errors" if significant else ""
    rows = [
        ("grains", shown("n_grains", "d")),
        ("contacts", f"{shown('n_contacts', 'd')}, {shown(*counted)} of them carry a force{above}"),
        (
            "equations",
            f"{shown('n_equations', 'd')} for {shown('n_unknowns', 'd')} unknowns, {summary['weights']} weights",
        ),
        ("largest force", f"{shown('largest_force_N', '.4g')} N"),
        ("residuals", f"{shown('residual_fraction', '.2g', 100)} % of the data"),
    ]
    if instants := summary["n_instants"] - 1:
        rows.insert(0, ("instants", str(instants + 1)))
    modulus = shown("youngs_modulus_Pa", ".4g", 1e-6)
    for label, key, form, factor, words in (
        (
            "chi^2",
            "chi2_per_equation",
            ".3g",
            1,
            "{} per degree of freedom (1: consistent with the noise)",
        ),
        (
            "standard error",
            "standard_error_fraction",
            ".2g",
            100,
            "{} % of the forces, from {repetitions} repetitions",
        ),
        ("Young's modulus", "youngs_modulus_error_Pa", ".2g", 1e-6, "{modulus} +- {} MPa"),
        ("accelerations", "acceleration_error", ".2g", 100, "error {} %"),
        ("forces", "true_force_error", ".2g", 100, "error {} % of the true forces"),
    ):
        if text := shown(key, form, factor):
            rows.append((label, words.format(text, modulus=modulus, **summary)))
    return lines([*rows, *(("note", note) for note in summary["notes"])])
