"""Arrays of a finished run of a chain, in the order of the chain."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.chains.hertz_chain import ChainScales
from granwave.analysis.measures.sensors import sensor_forces
from granwave.analysis.measures.signals import Array, first_peak
from granwave.analysis.result.histories import along
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.load import Load
from granwave.lammps_inputs.contact.law import Viscous, pair_contact, sphere_contact, viscous_loss
from granwave.lammps_inputs.packing.assembly import Assembly, assemble

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw


class HasResults(Protocol):
    """A run with its case and summary."""

    directory: Path

    @property
    def case(self) -> Case:
        """The case."""

    def __getitem__(self, name: str) -> Any:
        """Return a value of the summary."""


class ChainRecord:
    """Record of a chain, beside what a finished run has.

    Contacts are numbered from the struck end, from 0, those with strikers and with the faces of bars among them; so are
    beads, strikers first.

    Attributes
    ----------
    value
        A number of the summary by its name; NaN where it does not apply.
    """

    directory: Path
    case: Case
    value: Callable[[str], float]

    @cached_property
    def assembly(self) -> Assembly:
        """All bodies of the case."""
        return assemble(self.case)

    @property
    def load(self) -> Load:
        """Load of the chain."""
        return self.case.load

    @cached_property
    def law(self) -> ContactLaw:
        """Between two beads that are not replaced."""
        return sphere_contact(self.case)

    def law_between(self, first: int, second: int) -> ContactLaw:
        """Law between two bodies by their ids, strikers after the beads."""
        return pair_contact(self.assembly, first, second)

    @cached_property
    def loss(self) -> Viscous | None:
        """Loss between two such beads: "time" and the loss time (s), or "dashpot" and its factor; None without."""
        own = self.case.material
        return viscous_loss(self.assembly, self.case.contact, own, own)

    @cached_property
    def mass(self) -> float:
        """Mass of a bead that is not replaced, kg."""
        return self.case.sphere_mass

    @cached_property
    def scales(self) -> ChainScales:
        """Units of a chain of like beads."""
        return ChainScales(self.case)

    @cached_property
    def _arrays(self) -> dict[str, NDArray]:
        return {}

    def array(self, name: str) -> NDArray:
        """An array of the result, such as ``energy/time`` and ``walls/bar/force``; read once.

        Raises
        ------
        KeyError
            The run has none of that name.
        """
        if name not in self._arrays:
            with Result(self.directory) as result:
                self._arrays[name] = result[name]
        return self._arrays[name]

    @cached_property
    def recorded(self) -> bool:
        """The chain's history was recorded."""
        with Result(self.directory) as result:
            return "chain/time" in result

    @property
    def time(self) -> Array:
        """Instants of the history: (n_times,), s."""
        return self.array("chain/time")

    @property
    def force(self) -> Array:
        """Contact forces: (n_times, n_contacts), N."""
        return self.array("chain/contact_force")

    @property
    def velocity(self) -> Array:
        """Velocity of the beads along the chain: (n_times, n_beads), m/s."""
        return self.array("chain/velocity")

    @property
    def place(self) -> Array:
        """Place of the contacts along the chain at the start, the centre of bead 1 at 0: (n_contacts,), m."""
        return self.array("chain/contact_position")

    @property
    def impulse(self) -> float:
        """Impulse that the load gives to the first bead, N s."""
        return self.mass * self.load.velocity if self.load.kind == "impact" else self.load.impulse

    @cached_property
    def passed(self) -> int:
        """The last contact, from 1, that the crest of the leading wave has passed; 0: none."""
        crest = self.force.argmax(axis=0)
        over = np.flatnonzero((crest > 0) & (crest < len(self.time) - 2))
        return int(over[-1]) + 1 if len(over) else 0

    def first_peak(self, contact: int) -> tuple[float, float]:
        """Time (s) and height (N) of the first peak at a contact, from 0."""
        return first_peak(self.time, self.force[:, contact])

    def of_contacts(self, name: str) -> Array:
        """A column of ``/contacts``, such as ``peak_force``, along the chain, contacts with bars too: (n_contacts,)."""
        with Result(self.directory) as result:
            return along(result, name)

    @cached_property
    def sensors(self) -> dict[str, Array]:
        """Force of every sensor at the instants of ``time``, by its name: (n_times,), N."""
        with Result(self.directory) as result:
            return sensor_forces(result)

    def contact_between(self, bead: int) -> int:
        """Place, in the arrays of the history, of the contact between this bead and the next."""
        i, j = self.array("chain/contact_i"), self.array("chain/contact_j")
        return int(np.flatnonzero((i == bead) & (j == bead + 1))[0])


class Chain(ChainRecord):
    """Record of a chain from a run as `granwave.load` gives it.

    Parameters
    ----------
    run
        The run; its history must have been recorded, see ``output.history``.
    """

    def __init__(self, run: HasResults) -> None:
        self.run, self.directory, self.case = run, run.directory, run.case

    def value(self, name: str) -> float:
        """Return a number of the summary; NaN where it does not apply."""
        found = self.run[name]
        return float(found) if found is not None else math.nan
