"""Tables and summary of inferred forces."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from granwave.analysis.figures.style import Columns
from granwave.analysis.inference.infer import Inference
from granwave.analysis.inference.quantities import QUANTITIES
from granwave.analysis.versions import versions_of

_SLIDING = 1e-3  # of the limit of friction
_ERRORS = 2.0  # standard errors that a normal force exceeds to count as found
_LOADED = 1e-6  # of the largest force; smaller ones are errors of the solver
KIND = "inference"


def force_columns(found: Sequence[Inference], times: Sequence[float]) -> Columns:
    """Return the columns of forces.csv: a row for each candidate contact.

    ``i`` is the id of the grain that the normal points into, ``j`` that of its partner or the name of a wall. In the
    plane a tangential force is positive along (-ny, nx); in space its vector is given. Forces act on ``i``.
    """
    first = found[0]
    dimension = first.grains.dimension
    columns: dict[str, list[Any]] = {}

    def add(name: str, values: Any) -> None:
        columns.setdefault(name, []).extend(np.asarray(values).tolist())

    for one, time in zip(found, times, strict=True):
        contacts, ids, force = one.contacts, one.grains.ids, one.force
        if not math.isnan(time):
            add("time_s", np.full(len(contacts), time))
        add("i", ids[contacts.first])
        pairs = zip(contacts.second.tolist(), contacts.wall.tolist(), strict=True)
        columns.setdefault("j", []).extend(str(ids[j]) if j >= 0 else contacts.walls[wall] for j, wall in pairs)
        for axis in range(dimension):
            add(f"n{'xyz'[axis]}", contacts.normal[:, axis])
        tangential = force[:, 1] if dimension == 2 else np.linalg.norm(force[:, 1:], axis=1)
        add("normal_force_N", force[:, 0])
        add("tangential_force_N", tangential)
        if one.spread is not None:
            add("normal_error_N", one.spread[:, 0])
            size = np.linalg.norm(one.spread[:, 1:], axis=1) / math.sqrt(dimension - 1)
            add("tangential_error_N", size)
        vectors, points = contacts.vectors(force), one.grains.position[contacts.first] + contacts.arm
        for axis in range(dimension):
            add(f"f{'xyz'[axis]}_N", vectors[:, axis])
        for axis in range(dimension):
            add(f"{'xyz'[axis]}_m", points[:, axis])
    return {name: np.array(values, dtype=np.str_ if name == "j" else None) for name, values in columns.items()}


def grain_columns(found: Sequence[Inference], times: Sequence[float]) -> Columns:
    """Return the columns of grains.csv: residuals of the equations of each grain, NaN where nothing was measured."""
    columns: dict[str, list[Any]] = {}
    for one, time in zip(found, times, strict=True):
        motion, stress = one.residual_of_grains()
        values = {"id": one.grains.ids, "residual_motion_N": motion, "residual_stress_N": stress}
        if not math.isnan(time):
            values = {"time_s": np.full(len(one.grains), time), **values}
        for name, column in values.items():
            columns.setdefault(name, []).extend(column.tolist())
    return {name: np.array(values) for name, values in columns.items()}


def instant_summary(one: Inference, time: float) -> dict[str, Any]:
    """Return the values of one instant."""
    size = np.linalg.norm(one.force, axis=1)
    loaded = size > _LOADED * size.max(initial=0.0)
    friction = np.full(len(size), one.settings.friction)
    if one.settings.wall_friction is not None:
        friction[one.contacts.second < 0] = one.settings.wall_friction
    shear = np.linalg.norm(one.force[:, 1:], axis=1)
    sliding = loaded & (friction > 0) & (shear >= (1 - _SLIDING) * friction * one.force[:, 0])
    clear = loaded if one.spread is None else one.force[:, 0] > _ERRORS * one.spread[:, 0]
    known = one.spread is not None or one.settings.noise.complete(one.grains)
    modulus = None if one.grains.modulus is None else float(one.grains.modulus[0]) * one.factor
    total = float(np.linalg.norm(one.force))
    return {
        "time_s": time,
        "n_grains": len(one.grains),
        "n_contacts": len(one.contacts),
        "n_loaded_contacts": int(np.count_nonzero(loaded)),
        "n_significant_contacts": None if one.spread is None else int(np.count_nonzero(loaded & clear)),
        "n_equations": one.equations.n_equations,
        "n_unknowns": one.n_unknowns,
        "condition_number": one.condition,
        "largest_force_N": float(size.max(initial=0.0)),
        "mean_normal_force_N": float(one.force[loaded, 0].mean()) if loaded.any() else 0.0,
        "n_sliding_contacts": int(np.count_nonzero(sliding)),
        "residual_fraction": one.relative_residual,
        "chi2_per_equation": one.chi2 / one.n_free if known and one.weights != "equal" and one.n_free > 0 else None,
        "standard_error_fraction": (
            float(np.linalg.norm(one.spread)) / total if one.spread is not None and total > 0 else None
        ),
        "youngs_modulus_Pa": modulus,
        "youngs_modulus_error_Pa": (
            modulus * one.search.error if one.search is not None and modulus is not None else None
        ),
    }


def summary_of(
    name: str, measurement: str, state: str, found: Sequence[Inference], times: Sequence[float], notes: Sequence[str]
) -> dict[str, Any]:
    """Return the content of summary.json; values of several instants are lists."""
    each = [instant_summary(one, time) for one, time in zip(found, times, strict=True)]
    values = {key: each[0][key] if len(each) == 1 else [one[key] for one in each] for key in each[0]}
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
