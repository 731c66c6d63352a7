"""Moving strikers, ``[[striker]]``, as the only load."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from granwave.lammps_inputs.case.loads.load import Load, LoadedPacking, Wording


@dataclasses.dataclass(frozen=True, kw_only=True)
class StrikerLoad(Load):
    """Velocities of the strikers only."""

    kind: ClassVar[str] = "striker"
    means: ClassVar[str] = "only the strikers"
    strikes: ClassVar[bool] = True

    def struck(self, packing: LoadedPacking) -> tuple[int, ...]:
        return packing.moving_strikers

    def sentence(self, n_strikers: int) -> str:
        spheres = f"{n_strikers} sphere{'s' if n_strikers > 1 else ''}"
        return f"impacted by {spheres} placed against it."

    @classmethod
    def phrase(cls, case: Mapping[str, Any], write: Wording) -> str:
        strikers = case.get("striker")
        if not isinstance(strikers, list) or not strikers:
            return "struck"
        fastest = max(math.hypot(*striker.get("velocity", ())) for striker in strikers)
        return f"impacted at {write.number(fastest)} m/s"
