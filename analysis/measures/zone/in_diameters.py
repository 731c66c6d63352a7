"""Sizes of a plastic zone as a summary tells them, in diameters: packings and blocks can be laid side by side."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from granwave.analysis.measures.zone.marks import Mark, mark_of
from granwave.analysis.measures.zone.size import SHARES


@dataclasses.dataclass(frozen=True)
class Zone:
    """Plastic zone of one run: lengths in diameters, of the spheres or of the punch, volumes in pi D^3/6.

    Attributes
    ----------
    depth, radius, volume
        That hold each of `SHARES`; NaN where a size does not apply.
    outermost
        Depth and radius of the outermost yield; NaN as above.
    open_ended
        The same of both: the run ended, or a bound cut it, before the outermost yield was reached.
    mark
        Influence of the finite packing or block.
    """

    depth: tuple[float, ...]
    radius: tuple[float, ...]
    volume: tuple[float, ...]
    outermost: tuple[float, ...]
    open_ended: tuple[bool, bool]
    mark: Mark


def zone_in_diameters(summary: Mapping[str, Any], diameter: float) -> Zone | None:
    """Return the plastic zone of a run; None where its summary, of an older version, does not tell."""
    if summary.get(f"zone_volume_{SHARES[0]}_m3") is None:
        return None

    def sizes(unit: float, *names: str) -> tuple[float, ...]:
        found = [summary.get(name) for name in names]
        return tuple(math.nan if value is None else float(value) / unit for value in found)

    cut, growing = summary.get("zone_cut") or (), summary.get("zone_growing") or ()
    return Zone(
        depth=sizes(diameter, *(f"zone_depth_{percent}_m" for percent in SHARES)),
        radius=sizes(diameter, *(f"zone_radius_{percent}_m" for percent in SHARES)),
        volume=sizes(math.pi * diameter**3 / 6, *(f"zone_volume_{percent}_m3" for percent in SHARES)),
        outermost=sizes(diameter, "plastic_zone_depth_m", "plastic_zone_radius_m"),
        open_ended=("bottom" in cut or "depth" in growing, "sides" in cut or "radius" in growing),
        mark=mark_of(summary),
    )
