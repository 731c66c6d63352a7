"""Record of a row of grains along z with other grains beside it: rings in a tube, or cylinders between walls."""

from __future__ import annotations

import re
from functools import cached_property

import numpy as np

from granwave.analysis.measures.chains.record import Chain, HasResults
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

_ON_AXIS = 1e-6  # of a diameter
_PROBE = re.compile(r"contact_(\d+)_(\d+)_force")


class GrainRow(Chain):
    """Record of the grains on the axis x = y = 0, and of those beside it; no history of a chain is needed.

    Grains and contacts of the row count from 1, along z: contact k is that of grains k and k + 1.

    Attributes
    ----------
    ids, beside
        Ids of the grains on the axis, along it, and of the others.
    """

    def __init__(self, run: HasResults) -> None:
        super().__init__(run)
        place, ids = self.array("spheres/position"), self.array("spheres/id")
        on_axis = np.hypot(*place[:, :2].T) < _ON_AXIS * self.case.packing.diameter
        self.ids = ids[on_axis][np.argsort(place[on_axis, 2])]
        self.beside = ids[~on_axis]
        self._number = {int(one): k for k, one in enumerate(self.ids, start=1)}

    @property
    def struck(self) -> int:
        """Number of the first grain that is struck."""
        return self._number[(self.load.index or (int(self.ids[0]),))[0]]

    def _contact(self, first: int, second: int) -> int:
        """Number of the contact of two grains by their ids; 0 if they are no neighbours in the row."""
        low, high = sorted((self._number.get(first, -1), self._number.get(second, -1)))
        return low if low > 0 and high == low + 1 else 0

    def of_contacts(self, name: str) -> Array:
        """A column of ``/contacts``, such as ``peak_force``, along the row; 0 of contacts that never bore a force."""
        found = np.zeros(len(self.ids) - 1)
        for one, other, value in zip(*map(self.array, ("contacts/i", "contacts/j", f"contacts/{name}")), strict=True):
            if contact := self._contact(int(one), int(other)):
                found[contact - 1] = value
        return found

    @cached_property
    def passed(self) -> int:
        """The last contact from which the crest of the leading wave has gone on."""
        force, time = self.of_contacts("peak_force"), self.of_contacts("time_peak")
        done = (time[:-1] < time[1:]) & (time[1:] < self.value("end_time_s") * (1 - 1e-6)) & (force[:-1] > 0)
        after = np.flatnonzero(~done[self.struck :])
        return self.struck + (int(after[0]) if len(after) else len(done) - self.struck)

    @cached_property
    def contact_forces(self) -> dict[int, Array]:
        """Forces of the contacts of the row that ``output.probes`` names, at the instants ``probes/time``, N."""
        found = {}
        with Result(self.directory) as result:
            for name in result.names("probes"):
                match = _PROBE.fullmatch(name)
                if match and (contact := self._contact(int(match[1]), int(match[2]))):
                    found[contact] = result[f"probes/{name}"]
        return dict(sorted(found.items()))

    @cached_property
    def inward(self) -> float:
        """Mean distance by which the grains beside the row have moved towards its axis before the load, m."""
        with Result(self.directory) as result:
            rows = result.rows(self.beside)
            place, moved = result["spheres/position"][rows, :2], result.frame(0, "displacement")[rows, :2]
        return -float((moved * place).sum(axis=1) @ (1 / np.linalg.norm(place, axis=1)) / len(place))
