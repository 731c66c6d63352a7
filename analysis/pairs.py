"""What the contact law is to each pair of spheres: its yield overlap, effective radius, and who takes the loss."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case import Case
from granwave.lammps_inputs.laws import pair_contact, sphere_contact

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.materials import Material


@dataclass(frozen=True, eq=False)
class PairLaws:
    """By pair; every array (n_pairs,).

    Attributes
    ----------
    yield_overlap
        alpha_y, m.
    effective_radius
        R*, m.
    share
        Of the dissipated energy, of the first sphere of the pair: half, or all of it if it is softer.
    """

    yield_overlap: NDArray[np.float64]
    effective_radius: NDArray[np.float64]
    share: NDArray[np.float64]


def pair_laws(case: Case, first: NDArray[np.int64], second: NDArray[np.int64]) -> PairLaws:
    """The laws of pairs of spheres.

    Parameters
    ----------
    first, second
        Ids: (n_pairs,) each.
    """
    assembly = case.assembly
    if assembly.plain:
        law = sphere_contact(case)
        n = len(first)
        return PairLaws(np.full(n, law.yield_overlap), np.full(n, law.effective_radius), np.full(n, 0.5))
    kinds: dict[tuple[Material, float], int] = {}
    kind = np.zeros(assembly.n_spheres + 1, dtype=np.int64)
    kinds[(case.material, case.packing.diameter)] = 0
    for sphere in {*assembly.diameters, *assembly.materials, *range(case.lattice.n_spheres + 1, len(kind))}:
        what = assembly.material_of(sphere), assembly.diameter_of(sphere)
        kind[sphere] = kinds.setdefault(what, len(kinds))
    code = kind[first] * len(kinds) + kind[second]
    _, example, which = np.unique(code, return_index=True, return_inverse=True)
    pairs = [(int(first[k]), int(second[k])) for k in example]
    laws = [pair_contact(case, *pair) for pair in pairs]

    def each(value: Callable[[ContactLaw], float]) -> NDArray[np.float64]:
        return np.array([value(law) for law in laws])[which] if laws else np.empty(0)

    shares = [dissipated_share(*(assembly.material_of(sphere) for sphere in pair)) for pair in pairs]
    return PairLaws(
        each(lambda law: law.yield_overlap),
        each(lambda law: law.effective_radius),
        np.array(shares)[which] if pairs else np.empty(0),
    )


def dissipated_share(own: Material, partner: Material | None) -> float:
    """Part of a contact's dissipated energy that a body gets: half, or all or nothing if its yield strength differs."""
    mine, theirs = (math.inf if one is None or one.yield_strength is None else one.yield_strength
                    for one in (own, partner))  # fmt: skip
    return 0.5 if mine == theirs else float(mine < theirs)
