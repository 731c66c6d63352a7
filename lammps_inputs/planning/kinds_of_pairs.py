"""Kinds of touching pairs and of spheres at walls: those that differ in material, diameter or shape."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.places import Places

if TYPE_CHECKING:
    from granwave.lammps_inputs.packing.sites import Sites


_MOST_KINDS, _NEAR = 50, 1.1  # kinds of spheres that are distinguished; if more, diameters in this ratio count as one


@dataclasses.dataclass(frozen=True, eq=False)
class _Kinds:
    """Kinds of spheres at the sites of a lattice.

    Attributes
    ----------
    of
        Kind by site: (n_sites,); -1 for vacant ones.
    example
        Id of a sphere of each kind.
    """

    of: NDArray[np.int64]
    example: NDArray[np.int64]


def kinds_of_grains(sites: Sites) -> _Kinds:
    """Classify spheres by material and diameter, or by ranges of diameters if there are too many."""
    diameters, size = np.unique(sites.diameter, return_inverse=True)
    if len(diameters) * len(sites.bodies) > _MOST_KINDS:
        size = (np.log(sites.diameter / diameters[0]) / math.log(_NEAR)).astype(np.int64)
    code = np.where(sites.present, sites.body * (size.max() + 1) + size, -1)
    order = np.lexsort((sites.diameter, code))  # the smallest of each kind first
    codes, first = np.unique(code[order], return_index=True)
    example = order[first][codes >= 0] + 1
    return _Kinds(np.searchsorted(codes[codes >= 0], code) - (code < 0), example)


def kinds_of_last_layer(assembly: Assembly) -> list[int]:
    """Return a sphere of each kind in the last layer."""
    sites = assembly.sites
    if sites is None:
        return [assembly.lattice.n_spheres]
    kinds = kinds_of_grains(sites)
    there = np.unique(kinds.of[assembly.lattice.last_layer - 1])
    return kinds.example[there[there >= 0]].tolist()


def kinds_of_pairs(assembly: Assembly) -> list[tuple[int, int]]:
    """Return one pair for each kind of neighbours, and one of unmodified spheres if there are two."""
    sites = assembly.sites
    pairs: list[tuple[int, int]] = []
    if sites is None:
        pairs += [(1, 1)] if assembly.lattice.n_spheres > 1 else []
    else:
        kinds = kinds_of_grains(sites)
        n = len(kinds.example)
        codes = {
            int(code) for near, _ in sites.neighbours() for code in np.unique(kinds.of[near - 1] @ np.array([n, 1]))
        }
        if isinstance(assembly.lattice, Places):  # any two grains may meet
            codes = {first * n + second for first in range(n) for second in range(first, n)}
        pairs += [(int(kinds.example[code // n]), int(kinds.example[code % n])) for code in sorted(codes)]
        plain = np.flatnonzero(sites.present & (sites.kind == 0) & (sites.diameter == assembly.lattice.diameter)) + 1
        pairs += [(int(plain[0]), int(plain[0]))] if len(plain) > 1 else []
    for number, (striker, _) in enumerate(assembly.strikers, start=assembly.lattice.n_spheres + 1):
        pairs += [(number, touched) for touched in striker.touches]
    alike = {
        frozenset((assembly.material_of(k), assembly.diameter_of(k), assembly.shape_of(k)) for k in pair): pair
        for pair in pairs
    }
    return list(alike.values())
