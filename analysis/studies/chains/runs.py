"""Finished runs of chains, with their arrays in the order of the chain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.sensors import sensor_forces
from granwave.analysis.result.chain import along
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.contact.law import sphere_contact
from granwave.lammps_inputs.packing.assembly import BAR, INCIDENT_BAR, assemble

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw


class ChainRun(FinishedRun):
    """A finished run of a chain.

    Contacts are numbered from the struck end, from 0, those with strikers and with the faces of bars among them; so are
    beads, strikers first.
    """

    @property
    def load(self) -> Load:
        """What drives the chain."""
        return self.case.load

    @cached_property
    def law(self) -> ContactLaw:
        """Between two beads that are not replaced."""
        return sphere_contact(self.case)

    @cached_property
    def mass(self) -> float:
        """Of a bead that is not replaced, kg."""
        return self.case.sphere_mass

    @cached_property
    def _arrays(self) -> dict[str, NDArray]:
        wanted = ["time", "id", "position", "velocity", "displacement", "contact_i", "contact_j",
                  "contact_position", "contact_force"]  # fmt: skip
        with Result(self.directory) as result:
            arrays = {name: result[f"chain/{name}"] for name in wanted if f"chain/{name}" in result}
            for table in ("contacts", "wall_contacts", "spheres", "energy", "probes"):
                arrays |= {f"{table}/{name}": result[f"{table}/{name}"] for name in result.names(table)}
            for bar in self.assembly.bars:
                arrays |= {f"{bar.name}/{name}": result[f"bars/{bar.name}/{name}"]
                           for name in result.names(f"bars/{bar.name}")}  # fmt: skip
                arrays |= {f"walls/{bar.name}/{name}": result[f"walls/{bar.name}/{name}"] for name in ("time", "force")}
            if "walls/bottom/time" in result:
                arrays |= {f"walls/bottom/{name}": result[f"walls/bottom/{name}"] for name in ("time", "force")}
        return arrays

    def array(self, name: str) -> NDArray:
        """An array of the result: ``energy/time``, ``contacts/...``, ``bar/force``, ``walls/bar/force``, ...

        Raises
        ------
        KeyError
            The run has none of that name.
        """
        return self._arrays[name]

    @property
    def recorded(self) -> bool:
        """The chain's history was recorded."""
        return "time" in self._arrays

    @property
    def time(self) -> NDArray[np.float64]:
        """Instants of the history: (n_times,), s."""
        return self._arrays["time"]

    @property
    def force(self) -> NDArray[np.float64]:
        """Contact forces: (n_times, n_contacts), N."""
        return self._arrays["contact_force"]

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Of the beads along the chain: (n_times, n_beads), m/s."""
        return self._arrays["velocity"]

    @property
    def place(self) -> NDArray[np.float64]:
        """Of the contacts along the chain at the start, the centre of bead 1 at 0: (n_contacts,), m."""
        return self._arrays["contact_position"]

    def of_contacts(self, name: str) -> NDArray[np.float64]:
        """A column of ``/contacts``, such as ``peak_force``, along the chain, contacts with bars too: (n_contacts,)."""
        with Result(self.directory) as result:
            return along(result, name)

    @cached_property
    def sensors(self) -> dict[str, NDArray[np.float64]]:
        """Force of every sensor at the instants of ``time``, by its name: (n_times,), N."""
        with Result(self.directory) as result:
            return sensor_forces(result)

    @property
    def transmitted(self) -> float | None:
        """Energy in the bar at the end, J."""
        return self.summary.get(f"energy_{BAR}_J")

    @property
    def reflected(self) -> float | None:
        """Energy in the incident bar at the end, J."""
        return self.summary.get(f"energy_{INCIDENT_BAR}_J")


def collect(found: Iterable[tuple[str, Path, Mapping[str, Any]]]) -> tuple[ChainRun, ...]:
    """Of finished runs, given by label, directory and summary, those of chains of two beads and more."""
    return ChainRun.among(found, lambda case: case.packing.kind == "chain" and assemble(case).lattice.n_spheres > 1)


def chains(runs: Iterable[FinishedRun]) -> list[ChainRun]:
    """Runs of chains of two beads and more; none with a past, such as precompression."""
    return [
        run.seen_as(ChainRun)
        for run in runs
        if run.case.packing.kind == "chain" and run.assembly.lattice.n_spheres > 1 and not run.case.has_past
    ]


def uniform(runs: Sequence[ChainRun], law: str) -> list[ChainRun]:
    """Recorded runs of like beads under one law, without bars and strikers."""
    return [run for run in runs if run.case.contact.law == law and run.assembly.plain and run.recorded]


def columns(records: Sequence[Any], *names: str) -> list[NDArray[np.float64]]:
    """Attributes of records as arrays, one for each name: (n_records,)."""
    return [np.array([getattr(record, name) for record in records]) for name in names]
