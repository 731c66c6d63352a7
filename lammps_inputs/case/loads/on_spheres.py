"""Loads on chosen spheres of the packing."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.ids import INDEX
from granwave.lammps_inputs.case.loads.load import Load, LoadedPacking
from granwave.lammps_inputs.case.schema import ErrorList, show
from granwave.lammps_inputs.errors import Mismatch


@dataclasses.dataclass(frozen=True, kw_only=True)
class LoadOnSpheres(Load):
    """Load on spheres at the centre of the top, or on spheres that the case names."""

    hits_spheres: ClassVar[bool] = True

    spheres: int = schema.choice("number of impacted spheres", (1, 3, 7), default=1)
    index: tuple[int, ...] | None = schema.typed(
        "ids of the impacted spheres; default: the spheres at the centre of the top layer",
        INDEX,
        default=None,
    )

    def named(self, at_centre: Callable[[int], tuple[int, ...]]) -> tuple[str, Sequence[int]]:
        if self.index is not None:
            return "load.index", self.index
        return "load.spheres", at_centre(self.spheres)

    def struck(self, packing: LoadedPacking) -> tuple[int, ...]:
        return packing.at_centre(self.spheres) if self.index is None else self.index

    @property
    def struck_spheres(self) -> str:
        """Impacted spheres in words: ``3 spheres of the top layer``."""
        if self.index is not None:
            return f"{len(self.index)} chosen sphere{'s' if len(self.index) > 1 else ''}"
        return f"{self.spheres} sphere{'s' if self.spheres > 1 else ''} of the top layer"

    def check(self, names: Sequence[str], errors: ErrorList) -> None:
        index = self.index or ()
        twice = f"found {show(list(index))}, expected each id once"
        errors.check(
            (
                index and "spheres" in names,
                "load.index",
                Mismatch("together with load.spheres", remedy="specify only one of them"),
            ),
            (len(set(index)) < len(index), "load.index", twice),
        )

    def keys(self) -> dict[str, Any]:
        left_out = "spheres" if self.index is not None else ""
        return {name: value for name, value in super().keys().items() if name != left_out}
