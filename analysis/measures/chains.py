"""Records of chains, and of chains with further grains next to them: rings in a tube, cylinders
between walls.
"""

from __future__ import annotations

import math
import re
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from granwave._contact_laws import ContactLaw
from granwave.analysis.measures.hertz_lattices import ChainScales
from granwave.analysis.measures.lines import sensor_forces
from granwave.analysis.measures.signals import Array, first_peak
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.loads.load import Load
from granwave.lammps_inputs.contact.law import (
    ContactLoss,
    pair_contact,
    sphere_contact,
    viscous_loss,
)
from granwave.lammps_inputs.packing.assembly import Assembly, assemble

_ON_AXIS = 1e-6  # distance over a diameter, of grains on the axis
_PROBE = re.compile(r"contact_(\d+)_(\d+)_force")


class HasResults(Protocol):
    """A run with its case and summary."""

    directory: Path

    @property
    def case(self) -> Case:
        """The case."""

    def __getitem__(self, name: str) -> Any:
        """Return a value of the summary."""


class Chain:
    """Record of a chain from a run that `granwave.load` returned.

    Contacts, including contacts with strikers and with the faces of bars, are numbered from the
    impacted end, from 0. Beads are numbered in the same way, strikers first.

    Parameters
    ----------
    run
        The run; its history must have been recorded, see ``output.history``.
    """

    def __init__(self, run: HasResults) -> None:
        self.run = run
        self.directory = run.directory
        self.case = run.case
        self._arrays: dict[str, NDArray] = {}

    def value(self, name: str) -> float:
        """Return a number of the summary; NaN if it does not apply."""
        return math.nan if self.run[name] is None else float(self.run[name])

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
    def loss(self) -> ContactLoss | None:
        """Loss between two beads that are not replaced: "time" and the loss time (s), "dashpot" and
        its factor, or "prony" and weight and time (s) of each branch; None without.
        """
        own = self.case.material
        return viscous_loss(self.assembly, self.case.contact, own, own)

    @cached_property
    def mass(self) -> float:
        """Mass of a bead that is not replaced, kg."""
        return self.case.sphere_mass

    @cached_property
    def scales(self) -> ChainScales:
        """Units of a chain of identical beads."""
        return ChainScales(self.case)

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
        """True if the history of the chain was recorded."""
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
        """Initial positions of the contacts along the chain, with the centre of bead 1 at 0:
        (n_contacts,), m.
        """
        return self.array("chain/contact_position")

    @property
    def impulse(self) -> float:
        """Impulse that the load gives to the first bead, N s."""
        return self.load.impulse_on(self.mass)

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
        """A column of ``/contacts``, such as ``peak_force``, along the chain, including contacts
        with bars: (n_contacts,).
        """
        with Result(self.directory) as result:
            return result.along_chain(name)

    @cached_property
    def sensors(self) -> dict[str, Array]:
        """Force of every sensor at the instants of ``time``, by its name: (n_times,), N."""
        with Result(self.directory) as result:
            return sensor_forces(result)

    def contact_between(self, bead: int) -> int:
        """Index, in the arrays of the history, of the contact between this bead and the next."""
        i = self.array("chain/contact_i")
        j = self.array("chain/contact_j")
        return int(np.flatnonzero((i == bead) & (j == bead + 1))[0])


class GrainRow(Chain):
    """Record of the grains on the axis x = y = 0, and of the grains next to it; no history of
    a chain is required.

    Grains and contacts of the row are numbered from 1, along z: contact k joins grains k and k + 1.

    Attributes
    ----------
    ids, beside
        Ids of the grains on the axis, along it, and of the others.
    """

    def __init__(self, run: HasResults) -> None:
        super().__init__(run)
        place = self.array("spheres/position")
        ids = self.array("spheres/id")
        on_axis = np.hypot(*place[:, :2].T) < _ON_AXIS * self.case.packing.diameter
        self.ids = ids[on_axis][np.argsort(place[on_axis, 2])]
        self.beside = ids[~on_axis]
        self._number = {one: k for k, one in enumerate(self.ids.tolist(), start=1)}

    @property
    def struck(self) -> int:
        """Number of the first impacted grain."""
        return self._number[(self.load.index or (int(self.ids[0]),))[0]]

    def of_contacts(self, name: str) -> Array:
        """A column of ``/contacts``, such as ``peak_force``, along the chain; 0 for contacts
        that never carried a force.
        """
        with Result(self.directory) as result:
            return result.of_pairs(name, self.ids[:-1], self.ids[1:])

    @cached_property
    def passed(self) -> int:
        """The last contact that the crest of the leading wave has passed."""
        force = self.of_contacts("peak_force")
        time = self.of_contacts("time_peak")
        done = (
            (time[:-1] < time[1:])
            & (time[1:] < self.value("end_time_s") * (1 - 1e-6))
            & (force[:-1] > 0)
        )
        after = np.flatnonzero(~done[self.struck :])
        return self.struck + (int(after[0]) if len(after) else len(done) - self.struck)

    @cached_property
    def contact_forces(self) -> dict[int, Array]:
        """Forces of the contacts of the row that ``output.probes`` names, at the instants
        ``probes/time``, N.
        """
        with Result(self.directory) as result:
            probes = [match for name in result.names("probes") if (match := _PROBE.fullmatch(name))]
            numbers = [
                sorted(self._number.get(int(one), -1) for one in match.groups()) for match in probes
            ]
            found = {
                low: result[f"probes/{match[0]}"]
                for match, (low, high) in zip(probes, numbers, strict=True)
                if low > 0 and high == low + 1
            }
        return dict(sorted(found.items()))

    @cached_property
    def inward(self) -> float:
        """Mean displacement of the grains next to the chain towards its axis before the load,
        m.
        """
        with Result(self.directory) as result:
            rows = result.rows(self.beside)
            place = result["spheres/position"][rows, :2]
            moved = result.frame(0, "displacement")[rows, :2]
        return -float(
            (moved * place).sum(axis=1) @ (1 / np.linalg.norm(place, axis=1)) / len(place)
        )
