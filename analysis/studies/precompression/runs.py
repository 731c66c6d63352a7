"""Finished runs whose spheres have a past, and their twins without it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import BLANK, value_cell
from granwave.analysis.document.model import Cell, Column, Table
from granwave.analysis.measures.target import Reached, reached, risen
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun, all_but
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.contact.static_load import force_of_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw

Array = NDArray[np.float64]


class PastRun(FinishedRun):
    """A finished run of an impact, on spheres with or without a past."""

    @cached_property
    def law(self) -> ContactLaw:
        """Between two spheres that are not replaced."""
        return sphere_contact(self.case)

    @property
    def static_force(self) -> float:
        """What the dead loads make each contact of the lattice that carries them bear, N; 0 without any."""
        return force_of_contact(self.assembly) if self.case.precompression else 0.0

    @property
    def dissipated(self) -> float:
        """Share of the input."""
        return float(self.summary["dissipated_fraction"])

    @property
    def transmitted(self) -> float:
        """Largest force that the impact adds to the static one at the bottom, N; NaN with nothing there."""
        _, force = self.bottom
        return float(np.max(force)) if len(force) else np.nan

    @property
    def arrival(self) -> float:
        """When that force arrives, s; NaN: never. See `granwave.analysis.measures.target.Reached.arrival`."""
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

    def of_prestage(self, name: str) -> float:
        """What the static stage left, such as ``contacts`` that bear force; NaN without such a stage."""
        with Result(self.directory) as result:
            return float(result[f"prestage/{name}"][-1]) if f"prestage/{name}" in result else np.nan


def collect(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> tuple[PastRun, ...]:
    """Of finished runs, given by label, directory and summary, those of impacts."""
    runs = PastRun.among(found, lambda case: case.load.kind == "impact")
    return tuple(run for run in runs if run.summary.get("dissipated_fraction") is not None)


def groups(runs: Iterable[PastRun], *varying: str) -> list[list[PastRun]]:
    """Runs that differ in the named tables or keys alone, such as ``precompression`` or ``load.velocity``.

    How long and how finely a run was followed does not count.
    """
    found: dict[str, list[PastRun]] = {}
    for run in runs:
        found.setdefault(all_but(run.case, *varying), []).append(run)
    return list(found.values())


def rising(runs: Sequence[PastRun], key: Callable[[PastRun], float]) -> list[PastRun]:
    """In rising order of a key; of equal ones the first."""
    unique: dict[float, PastRun] = {}
    for run in runs:
        unique.setdefault(key(run), run)
    return [unique[value] for value in sorted(unique)]


def freed_words(runs: Iterable[PastRun]) -> str:
    """A further sentence of how more than all of the input is dissipated; empty where none of the runs does so."""
    if not any(run.dissipated > 1 for run in runs):
        return ""
    return (
        " More than 100 % is no error: energies count from the static state, and the impact also sets free what "
        "contacts had stored there, and lets the static load do work."
    )


def values_table(
    caption: str, heads: Sequence[tuple[str, str, float, str]], columns: Mapping[str, Sequence[float]]
) -> Table:
    """A table of the numbers that a figure shows.

    Parameters
    ----------
    heads
        Of each column: heading, unit, what the values are multiplied by for it, and its name in ``columns``.
    """
    shown = [[scale * value for value in columns[name]] for _, _, scale, name in heads]
    rows = tuple(tuple(value_cell(value) if np.isfinite(value) else Cell(BLANK) for value in row)
                 for row in zip(*shown, strict=True))  # fmt: skip
    return Table(caption, tuple(Column(text, unit, numeric=True) for text, unit, _, _ in heads), rows, sortable=True)
