"""A prescribed displacement of the impacted spheres."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from granwave._contact_laws import ContactLaw
from granwave.lammps_inputs.case import hints
from granwave.lammps_inputs.case.loads.driven import SHAPES, DrivenLoad
from granwave.lammps_inputs.case.loads.load import LoadedPacking
from granwave.lammps_inputs.case.schema import ErrorList

_JUMPS = ("half-sine", "rectangle")  # shapes whose velocity, or value, jumps at the start
_MARGIN = 2.0  # factor on the overlaps and speeds of the displacement


@dataclasses.dataclass(frozen=True, kw_only=True)
class DisplacementLoad(DrivenLoad):
    """Prescribed displacement of the impacted spheres."""

    kind: ClassVar[str] = "displacement"
    means: ClassVar[str] = "a prescribed displacement"
    prescribes_motion: ClassVar[bool] = True
    amplitude_unit: ClassVar[str] = "m"
    usual_amplitude: ClassVar[hints.Usual] = hints.DISPLACEMENT
    shown_amplitude: ClassVar[tuple[float, str]] = (1e6, "µm")
    shapes: ClassVar[tuple[str, ...]] = tuple(name for name in SHAPES if name not in _JUMPS)
    holds_last: ClassVar[bool] = True

    @property
    def may_stop(self) -> bool:
        """True for a table: its spheres may stop and return most of the energy input."""
        return bool(self.table)

    @property
    def fastest(self) -> float:
        """Largest speed, m/s."""
        if self.table:
            time, value = np.array(self.table).T
            return float(np.abs(np.diff(value) / np.diff(time)).max())
        return 2 * math.pi * self.highest_frequency * self.largest

    def speed_bound(self, packing: LoadedPacking) -> float:
        return self.fastest

    def force_on_contact(self, stiffness: float) -> float:
        return self.largest * stiffness

    def contact_energy(self, energy: float, law: ContactLaw, packing: LoadedPacking) -> float:
        """Add the work of the displacement on the first contact, and the energy of its speed."""
        work = law.loading_work(_MARGIN * self.largest)
        return energy + work + packing.sphere_mass * (_MARGIN * self.fastest) ** 2

    def sentence(self, n_strikers: int) -> str:
        direction = f"{list(self.direction or ())}" if self.slants else "z"
        moved = f"{self.struck_spheres} moved by a {self.shape} displacement"
        return f"{moved}, at most {self.largest:g} m, along {direction}."

    @property
    def no_bare_target(self) -> str:
        return "a prescribed displacement has no equivalent load on the bare target"

    def check(self, names: Sequence[str], errors: ErrorList) -> None:
        super().check(names, errors)
        first = 0.0
        if self.table:
            _, first = self.table[0]
        text = (
            f"found {first:g} m at the start, expected 0: a displacement is relative to the "
            f"initial position of the spheres; subtract {first:g} from all its values"
        )
        errors.check((first, self.amplitude_key(names), text))
