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
        texts = {_body(striker, case, write) for striker in strikers}
        if len(texts) == 1:
            number = f"{len(strikers)} × " if len(strikers) > 1 else ""
            return f"struck by {number}{texts.pop()}"
        fastest = max(math.hypot(*striker.get("velocity", ())) for striker in strikers)
        return f"struck by {len(strikers)} spheres at up to {write.number(fastest)} m/s"


def _body(striker: Mapping[str, Any], case: Mapping[str, Any], write: Wording) -> str:
    """Return a striker in words: ``steel, 20 mm, 1 m/s``; its material and diameter are those of
    the packing unless the table gives them.
    """
    material = striker.get("material") or case.get("material.name")
    name = material.get("name") if isinstance(material, Mapping) else material
    diameter = striker.get("diameter") or case.get("packing.diameter")
    size = write.quantity(diameter, "m") if isinstance(diameter, float | int) else ""
    speed = f"{write.number(math.hypot(*striker.get('velocity', ())))} m/s"
    return ", ".join(filter(None, [str(name or ""), size, speed]))
