"""One sphere-contact study, from case to figures: its summary, ``contact.csv`` and ``result.h5``.

    /history/{branch, cycle, overlap, force, face_force, contact_radius, mean_pressure, penetration}
    /energy/{kinetic, elastic, plastic, hourglass, viscous, damping, contact, input}     at the same instants
    /loading/{overlap, force, contact_radius, mean_pressure, law_force, law_contact_radius}
    /deviation/{force, contact_radius, mean_pressure}                                    per cent of the law's
    /cycles/{peak_overlap, peak_force, residual_overlap, exponent, ...}                  a row a cycle
    /pressure/N/{radius, pressure}                                     profiles, each with its overlap as attribute
    /fields/{position, elements, body, von_mises, plastic_strain}      at the largest overlap, (r, z) from the contact

``branch``: 0 loading, 1 unloading, 2 reloading. The root carries ``kind``, ``name``, ``case`` (TOML), ``summary`` and
``versions`` (JSON) as attributes; every data set a ``unit``. ``contact.csv`` begins with the columns that
``granwave law -o x.csv`` writes.
"""

from __future__ import annotations

import dataclasses
import logging
import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import write_csv
from granwave.analysis.versions import versions_of
from granwave.lammps_inputs.directories import note_files
from granwave.lammps_inputs.errors import RunError
from granwave.lammps_inputs.files import replacing
from granwave.lammps_inputs.run_directory import CONTACT_TABLE
from granwave.workflows.finite_elements.runner import ElementRun, Tables, run_elements, write_result
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.deviations import Cycle, compare_cycles, compare_loading
from granwave.workflows.finite_elements.sphere_contact.solver import Solver
from granwave.workflows.finite_elements.sphere_contact.study import (
    LOADING,
    RELOADING,
    TOLERANCE,
    UNLOADING,
    History,
    integrate,
    make_solver,
    yield_unit,
)

logger = logging.getLogger("granwave")

_PACKAGES = ("numpy", "numba", "scipy", "h5py", "matplotlib")
_ENERGIES = {name: name for name in ("kinetic", "elastic", "plastic", "hourglass", "viscous", "damping")} | {
    "contact": "penalty",
    "input": "work",
}
_OF_LOADING = {
    "overlap": "m",
    "force": "N",
    "contact_radius": "m",
    "mean_pressure": "Pa",
    "law_force": "N",
    "law_contact_radius": "m",
}
_UNITS = {"peak_overlap": "m", "residual_overlap": "m", "law_residual_overlap": "m", "peak_force": "N"}
_MOST_KINETIC = 0.01  # of the internal energy


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


def contact_table(case: SphereContactCase, history: History) -> dict[str, NDArray]:
    """The columns of contact.csv: loading, then unloading_N and reloading_N of each cycle."""
    names, rows = [], []
    branches = [(LOADING, 0, "loading")]
    for cycle in range(1, max(history.cycles, default=0) + 1):
        branches += [(UNLOADING, cycle, f"unloading_{cycle}"), (RELOADING, cycle, f"reloading_{cycle}")]
    for branch, cycle, name in branches:
        found = history.rows(branch, cycle)
        if branch == UNLOADING and len(found):
            found = np.concatenate([[found[0] - 1], found])  # from where it began
        names += [name] * len(found)
        rows.append(found)
    order = np.concatenate(rows)
    overlap, force = history.column("overlap")[order], history.column("force")[order]
    radius, law = np.array(history.contact_radii)[order], case.law
    pressure = _mean_pressure(force, radius)
    yields = math.isfinite(law.yield_overlap)
    nothing = np.full(len(order), math.nan)
    return {
        "branch": np.array(names),
        "overlap_m": overlap,
        "force_N": force,
        "overlap_normalised": overlap / law.yield_overlap if yields else nothing,
        "force_normalised": force / law.yield_force if yields else nothing,
        "contact_radius_m": radius,
        "mean_pressure_Pa": pressure,
        "contact_area_normalised": radius**2 / (law.effective_radius * law.yield_overlap) if yields else nothing,
        "mean_pressure_normalised": pressure / law.yield_strength if yields else nothing,
        "overlap_over_effective_radius": overlap / law.effective_radius,
    }


def _mean_pressure(force: NDArray[np.float64], radius: NDArray[np.float64]) -> NDArray[np.float64]:
    area = math.pi * radius**2
    return np.divide(force, area, out=np.zeros_like(force), where=area > 0)


def _tables(case: SphereContactCase, solver: Solver, history: History) -> Tables:
    """Return the data sets of ``result.h5``."""
    column, loading, cycles = history.column, compare_loading(case, history), compare_cycles(case, history)
    force, radius, field = column("force"), np.array(history.contact_radii), history.field
    tables: dict[str, tuple[ArrayLike, str]] = {
        "history/branch": (np.array(history.branches, dtype=np.int32), "1"),
        "history/cycle": (np.array(history.cycles, dtype=np.int32), "1"),
        "history/overlap": (column("overlap"), "m"),
        "history/force": (force, "N"),
        "history/face_force": (column("face_force"), "N"),
        "history/contact_radius": (radius, "m"),
        "history/mean_pressure": (_mean_pressure(force, radius), "Pa"),
        "history/penetration": (history.penetrations, "m"),
        **{f"energy/{name}": (column(entry), "J") for name, entry in _ENERGIES.items()},
        **{f"loading/{name}": (getattr(loading, name), unit) for name, unit in _OF_LOADING.items()},
        **{f"deviation/{name}": (values, "%") for name, values in loading.deviations.items()},
    }
    for entry in dataclasses.fields(Cycle):
        values = [float(getattr(cycle, entry.name)) for cycle in cycles]
        tables[f"cycles/{entry.name}"] = values, _UNITS.get(entry.name, "1")
    for number, (_, profile) in enumerate(history.profiles):
        tables[f"pressure/{number}/radius"] = profile.radius, "m"
        tables[f"pressure/{number}/pressure"] = profile.pressure, "Pa"
    if field is not None:
        tables["fields/position"] = field.position, "m"
        tables["fields/elements"] = solver.elements.astype(np.int32), "1"
        tables["fields/body"] = solver.kind.astype(np.int32), "1"
        tables["fields/von_mises"] = field.von_mises, "Pa"
        tables["fields/plastic_strain"] = field.plastic_strain, "1"
    return tables


class _Run(ElementRun):
    RESULTS = (*ElementRun.RESULTS, CONTACT_TABLE)
    FINISHED = ("done",)
    UNIT = " e-folds"

    def __init__(self, case: SphereContactCase) -> None:
        self.case, self.solver, self.history = case, make_solver(case), History()
        self._unit = yield_unit(case)
        self.total = self._place(case.max_overlap)

    @staticmethod
    def figures() -> ModuleType:
        from granwave.workflows.finite_elements.sphere_contact import figures

        return figures

    def integrate(self, report: Callable[[], None]) -> None:
        integrate(self.case, self.solver, self.history, lambda _: report())

    def progress(self) -> tuple[float, str]:
        """Share of the loading that is done, by the logarithm of the overlap, as its rate goes."""
        overlap = self.history.ledgers[-1].overlap
        return self._place(overlap), f"overlap {overlap / self._unit:.1f} alpha_y, cycle {self.history.cycles[-1]}"

    def _place(self, overlap: float) -> float:
        return math.log1p(max(0.0, overlap) / self._unit)

    def summarise(self, wall_time: float) -> dict[str, Any] | None:
        return summarise(self.case, self.solver, self.history, wall_time) if len(self.history.ledgers) > 1 else None

    def write(self, directory: Path, summary: dict[str, Any]) -> None:
        with replacing(directory / CONTACT_TABLE) as scratch:
            write_csv(contact_table(self.case, self.history), scratch)
        overlaps = {f"pressure/{number}": overlap for number, (overlap, _) in enumerate(self.history.profiles)}
        if self.history.field is not None:
            overlaps["fields"] = self.history.field.overlap
        tables = _tables(self.case, self.solver, self.history)
        write_result(directory, "sphere-contact", self.case, summary, tables, overlaps)
        note_files(directory, [CONTACT_TABLE])

    def conclude(self, directory: Path, summary: Mapping[str, Any], draw: Callable[[], None]) -> None:
        if self.history.end_reason == "refused":
            last = self.history.ledgers[-1]
            raise RunError(
                f"{self.case.name}: the energy balance is off by {100 * abs(last.balance / last.work):.3g} % of the "
                f"work of the faces at an overlap of {last.overlap:.4g} m, at most {100 * TOLERANCE:g} % is accepted; "
                f"what was computed is kept in {directory}. Take a smaller run.speed or run.max_overlap, or more "
                "run.elements"
            )
        if (summary.get("kinetic_share_max") or 0.0) > _MOST_KINETIC:
            logger.warning(
                "%s: not quasi-static: the kinetic energy reaches %.2g of the internal energy, expected at most %g; "
                "take a smaller run.speed",
                self.case.name,
                summary["kinetic_share_max"],
                _MOST_KINETIC,
            )
        draw()


#: Run a study, as `run_elements` does; leaves contact.csv besides.
run_sphere_contact = partial(run_elements, _Run)
