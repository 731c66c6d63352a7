"""``result.h5`` and ``contact.csv`` of a sphere-contact study, each replaced whole or not at all.

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
import math
from functools import partial
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.figures.style import write_csv
from granwave.lammps_inputs.files import replacing
from granwave.lammps_inputs.run_directory import CONTACT_TABLE
from granwave.workflows.finite_elements.result_file import new_result, put_dataset
from granwave.workflows.finite_elements.sphere_contact.case import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.deviations import Cycle, compare_cycles, compare_loading
from granwave.workflows.finite_elements.sphere_contact.solver import Solver
from granwave.workflows.finite_elements.sphere_contact.study import LOADING, RELOADING, UNLOADING, History

_ENERGIES = {name: name for name in ("kinetic", "elastic", "plastic", "hourglass", "viscous", "damping")} | {
    "contact": "penalty",
    "input": "work",
}
_UNITS = {"peak_overlap": "m", "residual_overlap": "m", "law_residual_overlap": "m", "peak_force": "N"}


def write_results(
    directory: Path, case: SphereContactCase, solver: Solver, history: History, summary: dict[str, Any]
) -> None:
    """Write ``contact.csv`` and ``result.h5`` into ``directory``."""
    with replacing(directory / CONTACT_TABLE) as scratch:
        write_csv(contact_table(case, history), scratch)
    with new_result(directory, "sphere-contact", case, summary) as file:
        _write(file, case, solver, history)


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


def _write(file: h5py.File, case: SphereContactCase, solver: Solver, history: History) -> None:
    put = partial(put_dataset, file)
    force, radius = history.column("force"), np.array(history.contact_radii)
    put("history/branch", np.array(history.branches, dtype=np.int32), "1")
    put("history/cycle", np.array(history.cycles, dtype=np.int32), "1")
    put("history/overlap", history.column("overlap"), "m")
    put("history/force", force, "N")
    put("history/face_force", history.column("face_force"), "N")
    put("history/contact_radius", radius, "m")
    put("history/mean_pressure", _mean_pressure(force, radius), "Pa")
    put("history/penetration", history.penetrations, "m")
    for name, column in _ENERGIES.items():
        put(f"energy/{name}", history.column(column), "J")
    loading = compare_loading(case, history)
    for name, unit in (("overlap", "m"), ("force", "N"), ("contact_radius", "m"), ("mean_pressure", "Pa")):
        put(f"loading/{name}", getattr(loading, name), unit)
    put("loading/law_force", loading.law_force, "N")
    put("loading/law_contact_radius", loading.law_contact_radius, "m")
    for name, values in loading.deviations.items():
        put(f"deviation/{name}", values, "%")
    cycles = compare_cycles(case, history)
    for name in (field.name for field in dataclasses.fields(Cycle)):
        put(f"cycles/{name}", [float(getattr(cycle, name)) for cycle in cycles], _UNITS.get(name, "1"))
    for number, (overlap, profile) in enumerate(history.profiles):
        put(f"pressure/{number}/radius", profile.radius, "m")
        put(f"pressure/{number}/pressure", profile.pressure, "Pa")
        file[f"pressure/{number}"].attrs["overlap"] = overlap
    field = history.field
    if field is not None:
        put("fields/position", field.position, "m")
        put("fields/elements", solver.elements.astype(np.int32), "1")
        put("fields/body", solver.kind.astype(np.int32), "1")
        put("fields/von_mises", field.von_mises, "Pa")
        put("fields/plastic_strain", field.plastic_strain, "1")
        file["fields"].attrs["overlap"] = field.overlap
