"""One sphere-contact study, from case to figures: its summary, ``contact.csv`` and ``result.h5``.

    /history/{branch, cycle, overlap, force, face_force, contact_radius, mean_pressure, penetration}
    /energy/{kinetic, elastic, plastic, hourglass, viscous, damping, contact, input}
        at the same instants
    /loading/{overlap, force, contact_radius, mean_pressure, law_force, law_contact_radius}
    /deviation/{force, contact_radius, mean_pressure}
        from the law, as a percentage of its value
    /cycles/{peak_overlap, peak_force, residual_overlap, exponent, ...}
        a row for each cycle
    /pressure/N/{radius, pressure}
        profiles, each with its overlap as attribute
    /fields/{position, elements, body, von_mises, plastic_strain}
        at the largest overlap, (r, z) from the contact

``branch``: 0 loading, 1 unloading, 2 reloading. The root carries ``kind``, ``name``, ``case``
(TOML), ``summary`` and ``versions`` (JSON) as attributes; every data set a ``unit``.
``contact.csv`` begins with the columns that ``granwave law -o x.csv`` writes.

On loading the overlap grows by the same fraction in every step, so that every decade of overlap
takes the same time. Unloading continues until the contact force vanishes, at a rate chosen from the
elastic stiffness 2 E* a. Changes of rate are smooth. All this is slow compared with the transit
time of waves through the mesh, which is proportional to its number of elements in a row; hence the
numbers of steps in `mesh` are multiples of ``n``, the elements along a side of the mesh's core.

The overlap is measured between the flat faces; Hertz's overlap is measured between remote points in
half-spaces. A half-sphere is therefore stiffer: the elastic force at a given overlap exceeds
Hertz's by 0.3 a/R to 0.45 a/R (1 % at a = 0.03 R, 3.5 % at a = 0.08 R; a: contact radius). At yield
of brass, a = 0.011 R, the difference is 0.4 %.

The constants were chosen by convergence for brass up to 0.2 R*. The contact grows by one element at
a time, so that the force has small steps: +-0.5 % with 6000 elements beyond 50 alpha_y. Averaged
over a few of them the force changes by at most 0.2 % if the speed is halved, and by at most 0.2 %
from 6000 to 12 000 elements (0.4 % from 1500 to 6000, but 1 % below alpha_y); single values beyond
50 alpha_y differ by up to 1.2 % and 2 %, as the steps shift.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.files import CONTACT_TABLE
from granwave.extensions.continuum.material import STRAIN, Elastoplastic
from granwave.extensions.continuum.runner import (
    SUMMARY_NAMES,
    ElementRun,
    Tables,
    run_elements,
)
from granwave.extensions.continuum.sphere_contact import mesh
from granwave.extensions.continuum.sphere_contact.case import SphereContactCase
from granwave.extensions.continuum.sphere_contact.deviations import (
    COMPARED,
    LOADING,
    OF_CYCLE,
    RELOADING,
    UNLOADING,
    compare_cycles,
    compare_loading,
    worst,
)
from granwave.extensions.continuum.sphere_contact.solver import (
    SphereContactSolver,
    SurfaceContact,
)
from granwave.lammps_inputs.files import replacing

TOLERANCE = 0.02  # largest accepted error of the energy balance / work of the faces
PROFILES = (2e-3, 6e-3, 1e-2, 1.4e-2, 1.8e-2, 4e-2, 8e-2, 0.12, 0.16, 0.20)  # overlaps / R*
_ENTRIES = 200, 100  # entries of the history in an e-fold of loading and in an unloading
_AT_REST = 1e-3  # rate / loading rate at which the faces count as at rest
_MOST_KINETIC = 0.01  # fraction of the internal energy
_OF_HISTORY = {
    "overlap": "m",
    "force": "N",
    "face_force": "N",
    "contact_radius": "m",
    "penetration": "m",
}
_ENERGIES = {
    name: name for name in ("kinetic", "elastic", "plastic", "hourglass", "viscous", "damping")
} | {
    "contact": "penalty",
    "input": "work",
}
_IN_SUMMARY = (
    "work",
    "elastic",
    "plastic",
    "kinetic",
    "hourglass",
    "viscous",
    "damping",
    "penalty",
)
_OF_LOADING = {"overlap": "m", "force": "N", "contact_radius": "m", "mean_pressure": "Pa", "law_force": "N",
               "law_contact_radius": "m"}  # fmt: skip


class _Refused(Exception):
    """Return the error of an energy balance that does not close."""


class ContactRun(ElementRun):
    """Run of a sphere contact through loading and all cycles.

    Rows of its history contain the values of `SphereContactSolver.ledger`, the ``branch``
    (`LOADING`, `UNLOADING` or `RELOADING`), the number of the ``cycle`` (from 1; 0: loading),
    ``contact_radius`` and ``penetration`` (m).

    Attributes
    ----------
    profiles
        Overlap (m) and contact at which loading passes `PROFILES`.
    field
        Data sets of the fields at the largest overlap.
    """

    KIND = "sphere-contact"
    RESULTS = (*ElementRun.RESULTS, CONTACT_TABLE)
    FINISHED = ("done",)
    UNIT = " e-folds"
    PACKAGES = ("numpy", "numba", "scipy", "h5py", "matplotlib")

    def __init__(self, case: SphereContactCase) -> None:
        super().__init__(case)
        n = mesh.squares(case)
        core = mesh.core_size(case)
        number = 1 if case.identical else 2
        speed = case.run.speed
        self.solver: SphereContactSolver = SphereContactSolver(
            tuple(mesh.half_sphere(radius, core, n) for radius in case.radii[:number]),
            tuple(Elastoplastic.of(material) for material in case.materials[:number]),
            smoothing=mesh.SMOOTHING * n / speed,
            damping=mesh.DAMPING / n,
            memory=mesh.MEMORY * n,
            velocity=case.run.velocity,
        )
        self.profiles: list[tuple[float, SurfaceContact]] = []
        self.field: Tables = {}
        self._unit = case.yield_unit
        self._fold = mesh.STEPS_PER_E_FOLD * n / speed
        self._way = mesh.STEPS_PER_UNLOADING * n / speed
        self._start = mesh.START * min(self._unit, case.max_overlap)
        self._significant = min(self._unit, 0.1 * case.max_overlap)
        self._due = [share * case.law.effective_radius for share in PROFILES]
        self._report: Callable[[], None] = lambda: None
        self.total = self._place(case.max_overlap)

    def integrate(self, report: Callable[[], None] = lambda: None) -> None:
        self._report = report
        peaks = self.case.peaks
        try:
            self._enter(LOADING, 0)
            for cycle, peak in enumerate(peaks, start=1):
                self._load(peak)
                self._cycle(cycle, last=cycle == len(peaks))
            if not len(peaks):
                self._load(self.case.max_overlap, turns=False)
                self._stop()
                self._keep_field()
        except _Refused:
            self.end_reason = "refused"
            return
        self.end_reason = "done"

    def _load(self, peak: float, *, turns: bool = True) -> None:
        """Load until a turn, or a stop, would end just below the overlap ``peak``."""
        solver = self.solver
        every = max(1, round(self._fold / _ENTRIES[0]))
        while True:
            back = self._unloading_rate() if turns and solver.force > 0 else 0.0
            left = (
                peak
                - solver.overlap
                - _overrun(solver.rate, solver.target_rate, back, solver.smoothing)
            )
            steps = every if solver.rate <= 0 else min(every, math.ceil(left / solver.rate))
            if steps <= 0:
                return
            solver.advance(steps, self._start / self._fold, 1 / self._fold)
            self._enter(LOADING, 0)

    def _stop(self) -> None:
        solver = self.solver
        still = _AT_REST * solver.rate
        while solver.rate > still:
            solver.advance(max(1, round(self._fold / _ENTRIES[0])), 0.0)
            self._enter(LOADING, 0)

    def _cycle(self, cycle: int, *, last: bool) -> None:
        """Unload until the contact force vanishes, and reload to the overlap at which unloading
        began.
        """
        solver = self.solver
        rate = self._unloading_rate()
        every = max(1, round(self._way / _ENTRIES[1]))
        small = max(1, every // 5)
        while solver.rate > 0:
            solver.advance(small, -rate)
            self._enter(LOADING, 0)
        peak = solver.overlap
        if last:
            self._keep_field()
        while solver.force > 0:
            solver.advance(every, -rate)
            self._enter(UNLOADING, cycle)
        while solver.rate < 0:
            solver.advance(small, rate)
            self._enter(UNLOADING, cycle)
        while solver.overlap < peak:
            solver.advance(every, rate)
            self._enter(RELOADING, cycle)

    def _unloading_rate(self) -> float:
        """Return the change of overlap in a step that unloads the contact in about the set time,
        m.
        """
        radius = max(self.solver.contact().contact_radius, 1e-12)
        return 1.5 * self.solver.force / (2 * self.case.law.effective_modulus * radius) / self._way

    def _keep_field(self) -> None:
        solver = self.solver
        self.overlaps["fields"] = solver.overlap
        self.field = {
            "fields/position": (solver.motion[0].copy(), "m"),
            "fields/elements": (solver.elements.astype(np.int32), "1"),
            "fields/body": (solver.kind.astype(np.int32), "1"),
            "fields/von_mises": (solver.von_mises, "Pa"),
            "fields/plastic_strain": (solver.state[:, STRAIN].copy(), "1"),
        }

    def _enter(self, branch: int, cycle: int) -> None:
        ledger = self.solver.ledger()
        contact = self.solver.contact()
        radius = contact.contact_radius if ledger["force"] > 0 else 0.0
        place = {
            "branch": branch,
            "cycle": cycle,
            "contact_radius": radius,
            "penetration": contact.penetration,
        }
        self.rows.append(ledger | place)
        if branch == LOADING and self._due and ledger["overlap"] >= 0.999 * self._due[0]:
            self.overlaps[f"pressure/{len(self.profiles)}"] = ledger["overlap"]
            self.profiles.append((ledger["overlap"], contact))
            self._due = [overlap for overlap in self._due if 0.999 * overlap > ledger["overlap"]]
        self._report()
        balanced = abs(ledger["balance"]) <= TOLERANCE * abs(ledger["work"])
        if not balanced and not ledger["overlap"] < self._significant:
            raise _Refused

    def progress(self) -> tuple[float, str]:
        """Completed fraction of the loading, by the logarithm of the overlap, according to its
        rate.
        """
        last = self.rows[-1]
        note = f"overlap {last['overlap'] / self._unit:.1f} alpha_y, cycle {last['cycle']}"
        return self._place(last["overlap"]), note

    def _place(self, overlap: float) -> float:
        return math.log1p(max(0.0, overlap) / self._unit)

    @property
    def history(self) -> pd.DataFrame:
        """History with the mean pressures of the contact, Pa."""
        table = pd.DataFrame(self.rows)
        area = math.pi * table["contact_radius"] ** 2
        return table.assign(mean_pressure=(table["force"] / area).where(area > 0, 0.0))

    def values(self) -> dict[str, Any]:
        law = self.case.law
        last = self.rows[-1]
        history = self.history
        loading = compare_loading(self.case, history)
        late = history[history["overlap"] >= self._significant]
        return {
            "n_bodies": len(self.solver.bodies),
            "n_elements": self.solver.n_elements,
            "n_steps": self.solver.n_steps,
            "end_reason": self.end_reason,
            "effective_radius_m": law.effective_radius,
            "effective_modulus_Pa": law.effective_modulus,
            "yield_overlap_m": law.yield_overlap,
            "yield_force_N": law.yield_force,
            "max_overlap_m": history["overlap"].max(),
            "max_force_N": history["force"].max(),
            "contact_radius_m": history["contact_radius"].max(),
            "mean_pressure_Pa": loading["mean_pressure"].iloc[-1] if len(loading) else math.nan,
            **worst(self.case, loading),
            **_of_cycles(compare_cycles(self.case, history)),
            **_quasi_static(late),
            **{f"energy_{SUMMARY_NAMES.get(name, name)}_J": last[name] for name in _IN_SUMMARY},
            "energy_balance_error": (late["balance"] / late["work"]).abs().max(),
            "energy_balance_accepted": TOLERANCE,
            "hourglass_share": last["hourglass"] / last["work"] if last["work"] else math.nan,
        }

    def tables(self) -> Tables:
        history = self.history
        loading = compare_loading(self.case, history)
        cycles = compare_cycles(self.case, history)
        tables: dict[str, tuple[ArrayLike, str]] = {
            **{
                f"history/{name}": (history[name].astype(np.int32), "1")
                for name in ("branch", "cycle")
            },
            **{f"history/{name}": (history[name], unit) for name, unit in _OF_HISTORY.items()},
            "history/mean_pressure": (history["mean_pressure"], "Pa"),
            **{f"energy/{name}": (history[entry], "J") for name, entry in _ENERGIES.items()},
            **{f"loading/{name}": (loading[name], unit) for name, unit in _OF_LOADING.items()},
            **{f"deviation/{name}": (loading[f"{name}_deviation"], "%") for name in COMPARED},
            **{f"cycles/{name}": (cycles[name], unit) for name, unit in OF_CYCLE.items()},
        }
        for number, (_, profile) in enumerate(self.profiles):
            tables[f"pressure/{number}/radius"] = profile.radius, "m"
            tables[f"pressure/{number}/pressure"] = profile.pressure, "Pa"
        return tables | dict(self.field)

    def write(self, directory: Path, summary: Mapping[str, Any]) -> None:
        with replacing(directory / CONTACT_TABLE) as scratch:
            write_csv(contact_table(self.case, self.history), scratch)
        super().write(directory, summary)

    def warnings(self, summary: Mapping[str, Any]) -> list[str]:
        if (summary["kinetic_share_max"] or 0.0) <= _MOST_KINETIC:
            return []
        return [
            f"not quasi-static: the kinetic energy reaches {summary['kinetic_share_max']:.2g} of "
            f"the internal energy, expected at most {_MOST_KINETIC:g}; use a smaller run.speed"
        ]

    def refusal(self) -> tuple[str, str]:
        last = self.rows[-1]
        return (
            f"{100 * abs(last['balance'] / last['work']):.3g} % of the work of the faces at an "
            f"overlap of {last['overlap']:.4g} m, at most {100 * TOLERANCE:g} %",
            "Use a smaller run.speed or run.max_overlap, or more run.elements",
        )


def _overrun(rate: float, target_rate: float, back: float, smoothing: float) -> float:
    """Return the further growth of the overlap, m, if the target is ``-back`` from now on
    (`kernels.advance`).

    The rate is then ``(rate + back + (target_rate + back) t) exp(-t) - back``, with t in units of
    ``smoothing``.
    """
    if rate <= 0:
        return 0.0
    excess = rate + back
    target_excess = target_rate + back
    low = 0.0
    high = 50.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (excess + target_excess * middle) * math.exp(-middle) > back:
            low = middle
        else:
            high = middle
    decay = math.exp(-low)
    growth = excess * (1 - decay) + target_excess * (1 - (1 + low) * decay) - back * low
    return smoothing * growth


def _of_cycles(cycles: pd.DataFrame) -> dict[str, float]:
    residuals = (cycles["residual_overlap"] - cycles["law_residual_overlap"]) / cycles[
        "peak_overlap"
    ]
    return {
        "n_unloadings": len(cycles),
        "unloading_exponent_min": cycles["exponent"].min(),
        "unloading_exponent_max": cycles["exponent"].max(),
        "unloading_misfit_percent": 100 * cycles["misfit"].max(),
        "unloading_law_difference_percent": 100 * cycles["law_difference"].max(),
        "residual_overlap_deviation_percent_of_peak": 100
        * max(residuals, key=abs, default=math.nan),
        "reloading_difference_percent": 100 * cycles["reloading_difference"].max(),
        "unloading_plastic_share": cycles["plastic_share"].max(),
    }


def _quasi_static(late: pd.DataFrame) -> dict[str, float]:
    """Compare, from first yield on, kinetic and internal energy, forces at faces and contact, and
    overlaps.
    """
    loading = late[(late["branch"] == LOADING) & (late["force"] > 0)]
    difference = 100 * (loading["face_force"] / loading["force"] - 1)
    return {
        "kinetic_share_max": (late["kinetic"] / (late["elastic"] + late["plastic"])).max(),
        "face_force_difference_max_percent": difference.abs().max(),
        "face_force_difference_rms_percent": np.sqrt((difference**2).mean()),
        "face_force_difference_mean_percent": difference.mean(),
        "penetration_share_max": (late["penetration"] / late["overlap"]).max(),
    }


def contact_table(case: SphereContactCase, history: pd.DataFrame) -> dict[str, NDArray]:
    """Return the columns of contact.csv: loading, then unloading_N and reloading_N of each
    cycle.
    """
    down = history["branch"] == UNLOADING
    first = history[down & (history["branch"].shift() == LOADING)]
    begun = history.loc[first.index - 1].assign(
        branch=UNLOADING, cycle=first["cycle"].to_numpy()
    )  # where it began
    ordered = pd.concat([begun, history]).sort_values(["cycle", "branch"], kind="stable")
    names = [f"{('loading', 'unloading', 'reloading')[branch]}_{cycle}" if cycle else "loading"
             for branch, cycle in zip(ordered["branch"], ordered["cycle"], strict=True)]  # fmt: skip
    overlap, force, radius, pressure = (
        ordered[name].to_numpy() for name in ("overlap", "force", "contact_radius", "mean_pressure")
    )
    law = case.law
    yields = (
        1.0 if math.isfinite(law.yield_overlap) else math.nan
    )  # values in units of first yield are empty without it
    return {
        "branch": np.array(names),
        "overlap_m": overlap,
        "force_N": force,
        "overlap_normalised": yields * overlap / law.yield_overlap,
        "force_normalised": yields * force / law.yield_force,
        "contact_radius_m": radius,
        "mean_pressure_Pa": pressure,
        "contact_area_normalised": yields * radius**2 / (law.effective_radius * law.yield_overlap),
        "mean_pressure_normalised": yields * pressure / law.yield_strength,
        "overlap_over_effective_radius": overlap / law.effective_radius,
    }


#: Run a study, as `run_elements` does, and write contact.csv.
run_sphere_contact = partial(run_elements, ContactRun)
