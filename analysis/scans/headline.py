"""First sentences on a scan: the quantity that answers most to the varied keys, a second one of
another kind, and the heights of packings on whose bottoms forces are compared.
"""

from __future__ import annotations

from granwave.analysis.formatting.numbers import in_any_unit
from granwave.analysis.quantities import quantity
from granwave.analysis.scans.means import RANKED, Means
from granwave.lammps_inputs.packing.cylinders import in_grains

_HEIGHT = "packing_height_m"
_SAME_HEIGHT = 1.01  # largest over smallest height of packings that are equally high
_OF_BOTTOM = ("wall_", "ground_", "target_", "peak_reduction")
_LEAST = 2


def headline(means: Means) -> str:
    """Return the first sentences on a scan; empty if no quantity can be stated."""
    shown = [key for _, key in means.quantities()]
    if not shown:
        return ""
    main = shown[0]
    parts = [means.sentence(main)]
    second = _second(means, shown)
    if second:
        label = in_grains(quantity(second).label, means.called)
        parts.append(f"{label}: {means.range_in_words(second)}.")
    if any(name.startswith(_OF_BOTTOM) for name in (main, second)):
        parts.append(_heights(means))
    return " ".join(filter(None, parts))


def _second(means: Means, shown: list[str]) -> str:
    """Return the next quantity that varies clearly, if possible of another unit; empty without
    one, and after a value for which the scan was made.
    """
    main = shown[0]
    if main not in RANKED:
        return ""
    clear = [name for name in shown[1:] if name in RANKED and means.varies_clearly(name)]
    others = [name for name in clear if quantity(name).unit != quantity(main).unit]
    return next(iter([*others, *clear]), "")


def _heights(means: Means) -> str:
    """Return a sentence on packings of different heights; empty if they do not differ."""
    heights = [value for value in means.values.get(_HEIGHT, ()) if value]
    if len(heights) < _LEAST or max(heights) <= _SAME_HEIGHT * min(heights):
        return ""
    least, most = [in_any_unit(value, "m") for value in (min(heights), max(heights))]
    return (
        f"Packings differ in height: {least} to {most}. Forces on the bottom and arrival times "
        "depend on it."
    )
