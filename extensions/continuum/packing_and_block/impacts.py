"""Impacts on packings and on blocks that can be compared, as tables with a row for each run, and as
groups of runs.

Columns have the same names as in the data of the figures. Energies are normalised by F_y
alpha_y for packings, and by sigma_y^2 D^3/E for blocks, D being the diameter of the punch.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
from pandas import DataFrame

from granwave.analysis.document.model import named
from granwave.analysis.measures.impact import (
    Involved,
    QuadraticLaw,
    quadratic_law,
    spheres_involved,
)
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import AnyRun, FinishedRun
from granwave.extensions.continuum.runs import ContinuumRun
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.run_directory import RESULT_FILE

SAME = 1e-4  # relative difference of nominally equal normalised velocities and energies
_FEWEST_FITTED = 5

_FAST = 0.1  # fraction of the largest velocity
_CONSTANTS = ("youngs_modulus", "poisson_ratio", "density", "yield_strength")
_DIFFERENCES = {  # properties that distinguish substances: word, size of the unit, and unit
    "diameter": ("diameter", 1e-3, "mm"),
    "youngs_modulus": ("modulus", 1e9, "GPa"),
    "poisson_ratio": ("Poisson's ratio", 1.0, ""),
    "density": ("density", 1.0, "kg/m³"),
    "yield_strength": ("yield strength", 1e6, "MPa"),
}
_KEYS = (
    "substance",
    "shape",
    "held",
    "but_for_mass",
    "but_for_taper",
    "but_for_block",
)  # equal numbers for equal content
_MEASURED = (  # columns that an empty table has too
    "run", "label", "packing", "energy_J", "energy_normalised", "velocity_normalised", "dissipated_fraction", "struck_spheres",
    "diameter", "mass_kg", "taper", "fine",
)  # fmt: skip

Curves = dict[str, DataFrame]  # runs by name, the reference first


@dataclasses.dataclass(frozen=True, eq=False)
class Impacts:
    """All runs that can be compared: impacts on packings of elasto-plastic spheres, and of a rigid
    punch on blocks.
    """

    granular: DataFrame
    continuum: DataFrame

    @cached_property
    def reference(self) -> DataFrame:
        """The largest group of granular runs with one impacted sphere that differ only in velocity,
        in order of velocity.
        """
        single = self.granular[self.granular.struck_spheres == 1]
        return rising(largest(single, "shape", "substance"), "velocity_normalised")

    @property
    def fast(self) -> DataFrame:
        """Runs of the reference at a tenth of its largest velocity or more. At lower velocities the
        peak forces of too many contacts are near F_y, where dissipation is not quadratic in force.
        """
        velocity = self.reference.velocity_normalised
        return self.reference[velocity >= _FAST * velocity.max() * (1 - SAME)]

    @property
    def like_reference(self) -> DataFrame:
        """Granular runs on the packing of the reference, with any material, diameter and loading
        area.
        """
        return self.granular[self.granular["shape"].isin(self.reference["shape"])]

    @property
    def other_substances(self) -> DataFrame:
        """Granular runs on the packing of the reference that do not belong to it: other materials,
        diameters or loading areas.
        """
        alike = self.like_reference
        return alike[~alike["label"].isin(self.reference["label"])]

    @property
    def other_packings(self) -> DataFrame:
        """Granular runs on packings whose kind, size or boundary differs from the reference."""
        runs = self.granular
        return runs[~runs["shape"].isin(self.reference["shape"])]

    @cached_property
    def continuum_reference(self) -> DataFrame:
        """The largest group of continuum runs that differ only in the energy of the punch, in order
        of energy.
        """
        return rising(largest(self.continuum, "shape", "substance"), "energy_normalised")


def collect(runs: Iterable[AnyRun[Any]]) -> Impacts:
    """The comparable runs.

    Compared quantities: impacts on ideal packings (identical spheres, no friction) whose contacts
    yield by the elasto-plastic law, and of punches on blocks.
    """
    runs = list(runs)
    granular = [
        _granular(run) for run in runs if isinstance(run, FinishedRun) and not not_ideal(run)
    ]
    return Impacts(
        _table(granular), _table([_continuum(run) for run in runs if isinstance(run, ContinuumRun)])
    )


def not_ideal(run: FinishedRun) -> str:
    """Return why a run of grains is not compared; empty if it is."""
    case = run.case
    reasons = {
        "a chain": case.packing.rule.is_chain,
        "the load is not an impact": not case.load.gives_velocity,
        "the grains are not identical": not run.assembly.plain,
        "friction": case.has_friction,
        f"the law is {case.contact.law}": case.contact.law != "elastoplastic",
        "no energy was put in": not run.summary.get("energy_input_J"),
    }
    return ", ".join(reason for reason, applies in reasons.items() if applies)


def largest(runs: DataFrame, *keys: str) -> DataFrame:
    """The largest group of runs with equal values of these keys."""
    return max((group for _, group in runs.groupby(list(keys), sort=False)), key=len, default=runs)


def rising(runs: DataFrame, column: str) -> DataFrame:
    """Runs in rising order of a column; the first of several with nominally equal values."""
    runs = runs.sort_values(column, kind="stable")
    values = runs[column].to_numpy()
    return runs[np.append(True, values[1:] > values[:-1] * (1 + SAME))[: len(runs)]]


def equal(runs: DataFrame, others: DataFrame, column: str) -> DataFrame:
    """Pairs of runs that should be equal in a column; the columns of the second run end with an
    underscore.
    """
    pairs = runs.merge(others, how="cross", suffixes=("", "_"))
    return pairs[np.abs(pairs[column] / pairs[f"{column}_"] - 1) < SAME]


def substances(runs: DataFrame, reference: DataFrame) -> Curves:
    """The reference, and the runs of each other substance in order of energy, with their names."""
    first = reference.iloc[0]
    others = runs[runs.substance != first.substance].groupby("substance", sort=False)
    name = f"reference ({first.material})" if first.material else "reference"
    return {name: reference} | {
        differences(first, group.iloc[0]): rising(group, "energy_J") for _, group in others
    }


def differences(first: pd.Series, other: pd.Series) -> str:
    """Label of another substance for a legend: its differences from the reference, such as "modulus
    230 GPa".

    Materials with different names are distinguished by name.
    """
    if first.material and other.material and first.material != other.material:
        word, size, unit = _DIFFERENCES["diameter"]
        is_alike = first.diameter == other.diameter
        more = "" if is_alike else f", {word} {other.diameter / size:.4g} {unit}"
        return f"{other.material}{more}"
    texts = [
        f"{word} {other[key] / size:.4g} {unit}".rstrip()
        for key, (word, size, unit) in _DIFFERENCES.items()
        if first[key] != other[key]
    ]
    return ", ".join(texts) or (other.material or "other")


def energy_unit(run: pd.Series | DataFrame, diameter: float | None = None) -> Any:
    """sigma_y^2 D^3/E, J, by default with the diameter of the run."""
    return (
        run.yield_strength**2
        * (run.diameter if diameter is None else diameter) ** 3
        / run.youngs_modulus
    )


def variants(impacts: Impacts) -> Curves:
    """The reference and the groups that differ from it in material or diameter, with one impacted
    sphere; with their names.
    """
    alike = impacts.like_reference
    return substances(alike[alike.struck_spheres == 1], impacts.reference)


def materials(impacts: Impacts) -> Curves:
    """The reference of blocks and the groups that differ from it only in the material, with
    their names.
    """
    runs = impacts.continuum
    reference = impacts.continuum_reference
    return substances(runs[runs["shape"].isin(reference["shape"])], reference)


def masses(impacts: Impacts) -> Curves:
    """Groups that differ from the reference only in the mass of the punch, in ascending order."""
    runs = impacts.continuum
    alike = runs[runs.but_for_mass.isin(impacts.continuum_reference.but_for_mass[:1])].groupby(
        "mass_kg"
    )
    return {f"m = {mass:.4g} kg": rising(group, "energy_J") for mass, group in alike}


def by_area(impacts: Impacts) -> Curves:
    """Runs of the reference material by the number of impacted spheres, in rising order of
    energy.
    """
    runs = impacts.like_reference
    alike = runs[runs.substance.isin(impacts.reference.substance)].groupby("struck_spheres")
    return {f"W = {spheres}": rising(group, "energy_J") for spheres, group in alike}


def area_table(curves: Curves) -> DataFrame:
    """Dissipated fractions by normalised input energy and number of impacted spheres, for energies
    with several such numbers.
    """
    if "W = 1" not in curves:
        return DataFrame()
    pairs = equal(curves["W = 1"], pd.concat(curves.values()), "energy_J")
    table = pairs.pivot_table(
        "dissipated_fraction_", "energy_normalised", "struck_spheres_", "first"
    )
    table = table[table.notna().sum(axis=1) > 1]
    return table.loc[:, table.notna().any()]


def quadratic_fit(impacts: Impacts) -> QuadraticLaw | None:
    """Quadratic law of the fast runs of the reference, in units in which the input is ``v0^2/2``;
    v0 is normalised.
    """
    return (
        quadratic_law(*dissipation(impacts.fast)) if len(impacts.fast) >= _FEWEST_FITTED else None
    )


def involved(run: Any) -> Involved | None:
    """The spheres or elements of a run that dissipated; None if its result cannot be read, or if
    nothing was dissipated.
    """
    directory = run.run.directory
    energy = run.energy_J
    try:
        if run.what == "continuum":
            elements = _elements_involved(directory / RESULT_FILE, energy)
        else:
            with Result(directory) as result:
                elements = spheres_involved(result, energy)
    except (GranwaveError, OSError, KeyError):
        return None
    return elements if len(elements.fraction) and elements.fraction[-1] > 0 else None


def _elements_involved(path: Path, energy_input: float) -> Involved:
    """Return the elements of a block that dissipated, from the ``result.h5`` of a continuum run;
    the input is in J.

    Raise OSError if the file cannot be read, KeyError if it is not such a file.
    """
    with h5py.File(regular(path), "r") as file:
        density = file["fields/plastic_energy"][()]
        volume = file["element_volume"][()]
    order = np.argsort(-density, kind="stable")
    order = order[: np.count_nonzero(density > 0)]
    return Involved(
        np.cumsum(density[order] * volume[order]) / energy_input, np.cumsum(volume[order])
    )


def dissipation(runs: DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Normalised velocities, and dissipation in units in which the input is v0^2/2."""
    velocity = runs.velocity_normalised.to_numpy()
    return velocity, runs.dissipated_fraction.to_numpy() * (0.5 * velocity**2)


def _table(rows: Sequence[dict[str, Any]]) -> DataFrame:
    table = DataFrame(rows, columns=None if rows else [*_KEYS, *_MEASURED])
    for key in set(_KEYS) & set(table):
        table[key] = pd.factorize(table[key])[0]
    return table


def omitted_in_words(
    impacts: Impacts, drawn: DataFrame, otherwise: str = "another velocity"
) -> str:
    """Return the names of the runs of packings that a figure does not show, with the differences
    from the reference as reasons; empty if it shows all.

    Parameters
    ----------
    drawn
        Runs that the figure shows.
    otherwise
        Reason of runs that belong to the reference.
    """
    runs = impacts.granular
    omitted: dict[str, list[str]] = {}
    for _, run in runs[~runs["label"].isin(drawn["label"])].iterrows():
        omitted.setdefault(_why_apart(impacts.reference, run) or otherwise, []).append(run.label)
    return "; ".join(f"{named(labels)} ({reason})" for reason, labels in omitted.items())


def _why_apart(reference: DataFrame, run: pd.Series) -> str:
    """Return the differences of a run of a packing from the reference; without one the run of the
    reference with the same velocity; empty for a run of the reference.
    """
    first = reference.iloc[0]
    reasons: list[str] = []
    if run.packing != first.packing:
        reasons.append(run.packing)
    elif run["shape"] != first["shape"]:
        reasons.append("another boundary, static load or direction of the impact")
    if run.substance != first.substance:
        reasons.append(differences(first, run))
    if run.struck_spheres != 1:
        reasons.append(f"{run.struck_spheres} impacted spheres")
    if reasons:
        return ", ".join(reasons)
    gaps = (reference.velocity_normalised / run.velocity_normalised - 1).abs()
    nearest = reference.loc[gaps.idxmin()]
    if gaps.min() >= SAME or nearest.label == run.label:
        return ""
    return f"same impact as {nearest.label}"


def _load_of(case: Case) -> tuple[str, ...]:
    """Return what distinguishes loads of equal velocity: static load, angle and spin."""
    load = case.load
    values = (case.precompression, getattr(load, "angle", 0.0), getattr(load, "spin", None))
    return tuple(map(repr, values))


def _granular(run: FinishedRun) -> dict[str, Any]:
    """Row of an impact on a packing."""
    case = run.case
    law = sphere_contact(run.case)
    packing = case.packing
    boundary = case.boundary
    energy = run.value("energy_input_J")
    constants = {name: getattr(case.material, name) for name in _CONSTANTS}
    return {
        **constants, "what": "granular", "run": run, "label": run.label, "material": case.material.name,
        "diameter": packing.diameter, "energy_J": energy,
        "energy_normalised": energy / (law.yield_force * law.yield_overlap),
        "velocity_normalised": run.value("velocity_normalised"),
        "dissipated_fraction": run.value("dissipated_fraction"), "struck_spheres": int(case.load.spheres),
        "yield_force": law.yield_force, "solid_fraction": packing.rule.solid_fraction,
        "n_spheres": run.assembly.lattice.n_spheres,
        "packing": f"{packing.kind} {' × '.join(map(str, packing.size))}",
        "substance": (*constants.values(), packing.diameter, case.contact),
        "shape": (packing.kind, packing.size, boundary, *_load_of(case)),
        "held": (packing.kind, boundary, *_load_of(case)),
    }  # fmt: skip


def _continuum(run: ContinuumRun) -> dict[str, Any]:
    """Row of an impact of a rigid punch on a block."""
    material, punch, mesh = (run.case[table] for table in ("material", "punch", "run"))
    constants = {name: material.get(name) for name in _CONSTANTS}
    block = (run.case["block"]["diameter"], run.case["block"]["height"])
    block_volume = math.pi * block[0] ** 2 * block[1] / 4
    volume = math.pi * punch["diameter"] ** 3 / 6
    rest = (block, mesh["elements"], *constants.values())
    return {
        **constants, "what": "continuum", "run": run, "label": run.label, "material": material.get("name"),
        "packing": "",
        "diameter": punch["diameter"], "energy_J": run.value("energy_input_J"),
        "energy_normalised": run.value("energy_input_normalised"),
        "dissipated_fraction": run.value("dissipated_fraction"), "mass_kg": punch["mass"], "taper": punch["taper"],
        "volume_over_sphere_volume": run.value("plastic_zone_volume_m3") / volume,
        "volume_ever_over_sphere_volume": run.value("plastic_zone_volume_ever_m3") / volume, "solid_fraction": 1.0,
        "resolved": not is_unresolved(run.summary),
        "fine": not isinstance(mesh["edge_size"], str), "substance": tuple(constants.values()),
        "shape": (punch["diameter"], punch["mass"], punch["taper"], block, mesh["elements"], mesh["edge_size"]),
        "but_for_mass": (punch["diameter"], punch["taper"], *rest),
        "but_for_taper": (punch["diameter"], punch["mass"], punch["velocity"], *rest),
        "but_for_block": (punch["diameter"], punch["mass"], punch["taper"], *constants.values()),
        "block_volume": block_volume,
    }  # fmt: skip
