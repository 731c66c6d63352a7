"""Contact law of each pair of spheres: its yield overlap, effective radius, and who takes the loss."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.assembly import assemble

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case.material import Material


@dataclass(frozen=True, eq=False)
class PairLaws:
    """By pair; every array (n_pairs,).

    Attributes
    ----------
    yield_overlap
        alpha_y, m.
    yielded_from
        Largest overlap from which on a contact has yielded, m; infinite where the law knows no yielding.
    effective_radius
        R*, m.
    share
        Of the energy dissipated by yielding, of the first sphere of the pair: half, or all of it if it is softer.
    """

    yield_overlap: NDArray[np.float64]
    yielded_from: NDArray[np.float64]
    effective_radius: NDArray[np.float64]
    share: NDArray[np.float64]


def pair_laws(case: Case, types: NDArray[np.int64], radii: NDArray[np.float64]) -> PairLaws:
    """The laws of pairs of spheres.

    The law of two materials is made once; alpha_y is in proportion to R*, so that every pair may have radii of its own.

    Parameters
    ----------
    types
        LAMMPS types of the spheres, which tell their materials: (n_pairs, 2).
    radii
        (n_pairs, 2), m.
    """
    materials = [species.material for species in assemble(case).species]
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
    return PairLaws(
        each(lambda law: law.yield_overlap) * scale,
        each(lambda law: law.elastic_limit) * scale,
        effective_radius,
        shares[kind] if laws else np.empty(0),
    )


def dissipated_share(own: Material, partner: Material | None) -> float:
    """Part of a contact's yielding that a body does: half, or all or nothing if its yield strength differs."""
    mine, theirs = (math.inf if one is None or one.yield_strength is None else one.yield_strength
                    for one in (own, partner))  # fmt: skip
    return 0.5 if mine == theirs else float(mine < theirs)
