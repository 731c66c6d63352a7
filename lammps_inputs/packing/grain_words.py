"""Name of the grains of a packing in what a person reads: spheres, cylinders, or grains where there are both."""

from __future__ import annotations

import re

SPHERES, CYLINDERS, GRAINS = "spheres", "cylinders", "grains"
_WORD = re.compile(r"\b([Ss])phere(s?)\b")


def grains_called(n_grains: int, n_cylinders: int) -> str:
    """Return ``spheres``, ``cylinders`` or ``grains``."""
    if not n_cylinders:
        return SPHERES
    return CYLINDERS if n_cylinders >= n_grains else GRAINS


def in_grains(text: str, called: str) -> str:
    """Put what grains are called, in the plural, into a text that calls them spheres."""

    def other(found: re.Match[str]) -> str:
        word = called.removesuffix("s") + found[2]
        return word.capitalize() if found[1] == "S" else word

    return text if called == SPHERES else _WORD.sub(other, text)
