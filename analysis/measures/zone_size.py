"""Size of the plastic zone: what holds 50, 90 and 99 % of the energy that was dissipated by yielding, and marks.

One definition for packings and the continuum. A part is a sphere of the packing, weighed by the energy that it
dissipated by yielding, or an element, weighed by its plastic work:

    depth     smallest d such that the parts whose centres lie at most d below the struck sphere's centre (packing) or
              the block's face (continuum) hold the share; a centre above counts as depth 0
    radius    the same of the distance of the centres from the impact axis
    volume    of the fewest parts that hold the share: those that dissipated most for their volume; of a packing that of
              the spheres, without the voids

Nothing is interpolated: a size is that of a part, or a sum of parts, and in a lattice the depth is that of a layer. The
outermost part that yielded at all (``plastic_zone_depth_m``) may lie many times farther out.
A zone that reaches a bound, or to which a wave came back from one, is marked: an endless packing's is another.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import IntEnum
from typing import Any

import numpy as np

from granwave.analysis.measures.signals import Array
from granwave.analysis.quantities import SHARES

BOTTOM, SIDES = "bottom", "sides"  # bounds that a zone, or a wave, may reach
WAVE_KEYS = ("wave_returned", "wave_return_s", "wave_return_share")  # of `wave_returns`
_ROUNDING = 1e-12  # of the energy: sums that reach a share but for rounding reach it


NOTED_SHARE = 0.01  # of the energy, dissipated after the first wave came back: from here on it is marked


def extent_holding(distance: Array, energy: Array, share: float) -> float:
    """Return the smallest distance within which a share of the energy lies.

    Parameters
    ----------
    distance
        Of the parts: (n,), m.
    energy
        Of the parts, none negative: (n,), J.
    share
        Of the whole energy, above 0.

    Returns
    -------
    float
        Distance of one of the parts, m; 0 where there is no energy.
    """
    order = np.lexsort((energy, distance))  # equal parts are alike, so that their order in the file does not matter
    n = _parts_holding(energy[order], share)
    return float(distance[order][n - 1]) if n else 0.0


def volume_holding(volume: Array, energy: Array, share: float) -> float:
    """Return the volume of the parts of highest energy density that together hold a share of the energy.

    Parameters
    ----------
    volume
        Of the parts: (n,), m^3.
    energy
        Of the parts, none negative: (n,), J.
    share
        Of the whole energy, above 0.

    Returns
    -------
    float
        m^3; 0 where there is no energy.
    """
    order = np.lexsort((volume, -energy / volume))
    return float(np.sum(volume[order][: _parts_holding(energy[order], share)]))


def _parts_holding(energy: Array, share: float) -> int:
    """Number of parts, from the first, that hold a share of the energy; 0 where there is none."""
    held = np.cumsum(energy)
    if not len(held) or held[-1] <= 0:
        return 0
    return int(np.searchsorted(held, (1 - _ROUNDING) * share * held[-1])) + 1


def zone_sizes(
    energy: Array | None, volume: Array | None = None, depth: Array | None = None, radius: Array | None = None
) -> dict[str, float | None]:
    """Sizes of a plastic zone, by their names in ``summary.json``.

    Parameters
    ----------
    energy
        Dissipated by yielding, of the parts: (n,), J; None where nothing can yield.
    volume
        Of the parts: (n,), m^3.
    depth, radius
        Of the parts: (n,), m; None where a packing does not extend that way.

    Returns
    -------
    dict
        ``zone_depth_50_m``, ``zone_radius_50_m``, ``zone_volume_50_m3``, ... 90, 99; None where a size does not apply.
    """
    sizes: dict[str, float | None] = {}
    for name, distance in (("depth", depth), ("radius", radius)):
        for percent in SHARES:
            sizes[f"zone_{name}_{percent}_m"] = (
                None if energy is None or distance is None else extent_holding(distance, energy, percent / 100)
            )
    for percent in SHARES:
        sizes[f"zone_volume_{percent}_m3"] = (
            None if energy is None or volume is None else volume_holding(volume, energy, percent / 100)
        )
    return sizes


def wave_returns(times: dict[str, float] | None, ledger: Array, lost: Array) -> dict[str, Any]:
    """Return the part of the summary that is about waves that come back from the bounds.

    Parameters
    ----------
    times
        Of the return to the zone, by bound, s; None where they are not known.
    ledger
        Times of the energy ledger: (n,), s.
    lost
        Energy dissipated by yielding so far: (n,), J.

    Returns
    -------
    dict
        ``wave_returned``, the bounds whose wave came back within the run; ``wave_return_s``, the earliest return;
        ``wave_return_share``, the part of the energy that was dissipated after it.
    """
    if times is None:
        return dict.fromkeys(WAVE_KEYS)
    first = min(times.values(), default=None)
    share = 0.0
    if first is not None and lost[-1] > 0:
        share = float(1 - np.interp(first, ledger, lost) / lost[-1])
    within = [name for name, time in times.items() if time < ledger[-1]]
    return dict(zip(WAVE_KEYS, (within, first, max(share, 0.0)), strict=True))


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
