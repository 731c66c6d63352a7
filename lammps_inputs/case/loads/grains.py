"""The velocities of the grains of a file, as the only load."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

from granwave.lammps_inputs.case.loads.load import Load, LoadedPacking


@dataclasses.dataclass(frozen=True, kw_only=True)
class GrainsLoad(Load):
    """Velocities of the grains of ``packing.file`` only."""

    kind: ClassVar[str] = "grains"
    means: ClassVar[str] = "only the velocities of grains in a file"
    hits_one_place: ClassVar[bool] = False
    moves_grains: ClassVar[bool] = True

    def struck(self, packing: LoadedPacking) -> tuple[int, ...]:
        return packing.moving_grains

    def sentence(self, n_strikers: int) -> str:
        return "moved by the velocities of grains."
