"""Constants of the contact laws of pairs of spheres: yield overlap, effective radius, shares of dissipation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.assembly import Species, assemble

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case.material import Material


@dataclass(frozen=True, eq=False)
class PairLaws:
    """Constants by pair; every array is (n_pairs,).

    Attributes
    ----------
    yield_overlap
        Yield overlaps alpha_y, m.
    yielded_from
        Peak overlap beyond which a contact has yielded, m; infinite if the law does not yield.
    effective_radius
        Effective radii R*, m.
    share
        Share of the first sphere in the dissipation by yielding: half, or all or none if yield strengths differ.
    """

    yield_overlap: NDArray[np.float64]
    yielded_from: NDArray[np.float64]
    effective_radius: NDArray[np.float64]
    share: NDArray[np.float64]


def pair_laws(case: Case, types: NDArray[np.int64], radii: NDArray[np.float64]) -> PairLaws:
    """Return the constants of pairs of spheres.

    The law of two materials is made once; alpha_y is proportional to R*, which may differ between pairs.

    Parameters
    ----------
    types
        LAMMPS types of the spheres, which give their materials: (n_pairs, 2).
    radii
        Radii of the spheres: (n_pairs, 2), m.
    """
    species = assemble(case).species
    materials = [one.material for one in species]
    effective_radius = radii[:, 0] * radii[:, 1] / radii.sum(axis=1)
    base = len(materials) + 1
    kinds, kind = np.unique(types[:, 0] * base + types[:, 1], return_inverse=True)
    pairs = [(materials[code // base - 1], materials[code % base - 1]) for code in kinds.tolist()]
    radius = case.packing.diameter / 2
    laws = [law_between(case.contact_between(*pair), pair, (radius, radius)) for pair in pairs]

    def each(value: Callable[[ContactLaw], float]) -> NDArray[np.float64]:
        return np.array([value(law) for law in laws])[kind] if laws else np.empty(0)

    shares = np.array([dissipated_share(*pair) for pair in pairs])
    scale = effective_radius / (radius / 2)
    found = PairLaws(
        each(lambda law: law.yield_overlap) * scale,
        each(lambda law: law.elastic_limit) * scale,
        effective_radius,
        shares[kind] if laws else np.empty(0),
    )
    if any(one.shape for one in species):
        _set_cylinders(case, species, types, radii, found)
    return found


def _set_cylinders(
    case: Case, species: tuple[Species, ...], types: NDArray[np.int64], radii: NDArray[np.float64], laws: PairLaws
) -> None:
    """Set the constants of the pairs with a cylinder, kind by kind."""
    kinds, kind = np.unique(np.column_stack([types, radii]), axis=0, return_inverse=True)
    for number, (one, other, r1, r2) in enumerate(kinds.tolist()):
        first, second = species[int(one) - 1], species[int(other) - 1]
        if not (first.shape or second.shape):
            continue
        materials = first.material, second.material
        law = law_between(case.contact_between(*materials), materials, (r1, r2), shapes=(first.shape, second.shape))
        rows = kind.ravel() == number
        laws.yield_overlap[rows], laws.yielded_from[rows] = law.yield_overlap, law.elastic_limit
        laws.effective_radius[rows] = law.effective_radius


def dissipated_share(own: Material, partner: Material | None) -> float:
    """Return a body's share in the yielding of a contact: half, or all or none if yield strengths differ."""
    mine, theirs = (math.inf if one is None or one.yield_strength is None else one.yield_strength
                    for one in (own, partner))  # fmt: skip
    return 0.5 if mine == theirs else float(mine < theirs)
