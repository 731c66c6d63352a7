"""Plastic zones that are not those of an endless packing or block: they reach a bound, or a wave came back from one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import IntEnum
from typing import Any

NOTED_SHARE = 0.01  # of the energy, dissipated after the first wave came back: from here on it is marked


class Mark(IntEnum):
    """Influence of the finite packing or block on its plastic zone."""

    NONE = 0
    WAVE = 1  # a wave that came back had a part in more than `NOTED_SHARE` of the dissipation
    CUT = 2  # the zone reaches a bound


#: What a mark says, beside a marker in a figure or a table.
LABELS = {Mark.CUT: "zone reaches a bound", Mark.WAVE: "reflected wave came back"}


def mark_of(summary: Mapping[str, Any]) -> Mark:
    """Return the mark of a run; none where its summary has no plastic zone, or for a collision of two spheres."""
    if summary.get("n_spheres") in (1, 2):
        return Mark.NONE
    if summary.get("zone_cut"):
        return Mark.CUT
    share = summary.get("wave_return_share")
    return Mark.WAVE if isinstance(share, int | float) and share > NOTED_SHARE else Mark.NONE


def _is_chain(summary: Mapping[str, Any]) -> bool:
    """Return True if the plastic zone has a depth and no radius."""
    radius = summary.get("zone_radius_99_m", 0.0)
    return radius is None and summary.get("zone_depth_99_m") is not None


def bounds_in_words(bounds: object) -> str:
    """Return a list of bounds, or of other names, as words: ``bottom, sides``, or ``none`` where it is empty."""
    return (", ".join(map(str, bounds)) or "none") if isinstance(bounds, list | tuple) else ""


def zone_warning(summary: Mapping[str, Any]) -> str:
    """Return what a reader of the sizes of a plastic zone must know, in a line; empty if nothing."""
    what = "block" if summary.get("kind") == "continuum" else "packing"
    if summary.get("n_spheres") in (1, 2) or _is_chain(summary):  # a collision, or a pulse that goes from end to end
        return ""
    found = []
    if summary.get("zone_cut"):
        found.append(f"the plastic zone reaches {_with_articles(summary['zone_cut'])} of the {what}")
    share = summary.get("wave_return_share")
    if isinstance(share, int | float) and share > NOTED_SHARE:
        came = f"a wave came back from {_with_articles(summary.get('wave_returned') or ())}"
        found.append(f"up to {100 * share:.3g} % was dissipated after {came} ({1e6 * summary['wave_return_s']:.3g} us)")
    return f"{', '.join(found)}; a larger {what} does without" if found else ""


def _with_articles(names: Iterable[str]) -> str:
    return " and ".join(f"the {name}" for name in names)
