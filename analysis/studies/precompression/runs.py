"""Finished runs whose spheres have a past, and their twins without it."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.precompressed.loaded_line import Line, line_of
from granwave.analysis.measures.target.record import Reached, reached, risen
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.contact.initial_dents import largest_dent
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import force_of_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

Array = NDArray[np.float64]


class DentedRun(FinishedRun):
    """A finished run of an impact, on spheres with or without a past."""

    @cached_property
    def law(self) -> ContactLaw:
        """Between two spheres that are not replaced."""
        return sphere_contact(self.case)

    @cached_property
    def line(self) -> Line:
        """The line that a precompressed chain, or the layers of a packing, are for long waves."""
        return line_of(self.case, self.law)

    @cached_property
    def level(self) -> float:
        """Force up to which the contacts were pressed before, N; 0: never; NaN where it is not the same for all."""
        given = self.case.contact.initial_overlap
        regions = given if isinstance(given, tuple) else ()
        if isinstance(given, str) or len(regions) > 1 or any(one.low or one.high for one in regions):
            return np.nan
        return float(self.law.loading_force(np.array([largest_dent(self.case, self.law)]))[0])

    @cached_property
    def static_force(self) -> float:
        """Force of each contact of the lattice under the dead loads, N; 0 without any."""
        return force_of_contact(self.assembly) if self.case.precompression else 0.0

    @property
    def pressure(self) -> float:
        """Static one on the faces of an fcc or hcp packing, by the force of a contact, Pa."""
        return float(2 * np.sqrt(2) * self.static_force / self.case.packing.diameter**2)

    @property
    def dissipated(self) -> float:
        """Share of the input."""
        return self.value("dissipated_fraction")

    @property
    def transmitted(self) -> float:
        """Largest force that the impact adds to the static one at the bottom, N; NaN with nothing there."""
        _, force = self.bottom
        return float(np.max(force)) if len(force) else np.nan

    @property
    def arrival(self) -> float:
        """Arrival of that force, s; NaN: never. See `granwave.analysis.measures.target.record.Reached.arrival`."""
        found = self._reached.arrival if self._reached else None
        return np.nan if found is None else found

    @property
    def bottom(self) -> tuple[Array, Array]:
        """Time, s, and the force at the bottom beyond the static one, N."""
        found = self._reached
        return (found.time, risen(found.force)) if found else (np.empty(0), np.empty(0))

    @cached_property
    def _reached(self) -> Reached | None:
        with Result(self.directory) as result:
            return reached(result)

    def of_static_stage(self, name: str) -> float:
        """Value of the static stage, such as ``contacts`` that bear force; NaN without such a stage."""
        with Result(self.directory) as result:
            return float(result[f"prestage/{name}"][-1]) if f"prestage/{name}" in result else np.nan


def past_runs(runs: Iterable[FinishedRun]) -> list[DentedRun]:
    """Runs of impacts."""
    return [
        run.seen_as(DentedRun)
        for run in runs
        if run.case.load.kind == "impact" and run.summary.get("dissipated_fraction") is not None
    ]


def released_energy_note(runs: Iterable[DentedRun]) -> str:
    """A further sentence of how more than all of the input is dissipated; empty where none of the runs does so."""
    if not any(run.dissipated > 1 for run in runs):
        return ""
    return (
        " More than 100 % is no error: energies count from the static state, and the impact also sets free what "
        "contacts had stored there, and lets the static load do work."
    )
