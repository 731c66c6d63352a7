"""Contacts of a run as a table of pairs: dents of one pair are merged, unloaded touching pairs are added.

Touching pairs at the start follow from positions and radii, for any packing.

A pair may have several dents: a dent is forgotten when the gap exceeds a given distance, and the next contact starts a
new one. In this table each pair is one row, with the largest peak, the sum of the energies and the earliest times.
Constants of the contact laws of pairs are yield overlap, effective radius and shares of dissipation.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.lammps_output.frame import Frame, rows_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.assembly import Species, assemble

if TYPE_CHECKING:
    from granwave._contact_laws import ContactLaw
    from granwave.lammps_inputs.case.material import Material

LISTED_FROM = 1e-6  # peak overlap over alpha_y from which on pairs that did not touch at the start are listed

Contacts = dict[str, NDArray]
_TIMES = ("time_first", "time_peak", "time_yield")
_FRICTION_COLUMNS = ("tangential_force", "elastic_tangential", "friction")
_ZERO_IF_MISSING = (*_FRICTION_COLUMNS, "initial", "viscous")
_FEW = 1000  # spheres up to which all pairs are looked at: a tree of fewer takes longer to load
_LARGE = 1.5  # radius over the median from which on the neighbours of a sphere are searched separately


def merge_dents(dents: Frame) -> Contacts:
    """Merge the dents of `granwave.analysis.lammps_output.dumps.read_contacts` into one row a pair, sorted by (i, j).

    Returns
    -------
    dict
        ``i``, ``j`` (n_pairs,), i < j; ``overlap``, ``peak_overlap``, ``initial_overlap`` (initial dent) m;
        ``force``, ``peak_force``, ``tangential_force`` N; ``elastic_energy``, ``dissipated_energy`` (of yielding,
        friction and viscous losses), ``friction_energy``, with viscous losses ``viscous_energy`` J;
        ``time_first``, ``time_peak``, ``time_yield`` s (NaN: never); ``n_dents``;
        ``grown_overlap``: largest overlap of dents that grew in this run, m.
    """
    first, second = np.sort(dents.vector("i", "j").astype(np.int64), axis=1).T
    order = np.lexsort((-dents["peak_overlap"], second, first))  # the deepest dent of a pair first
    values = {name: dents.get(name)[order] for name in (*dents.columns, *_ZERO_IF_MISSING)}
    first, second = first[order], second[order]
    new = np.ones(len(first), dtype=bool)
    new[1:] = (first[1:] != first[:-1]) | (second[1:] != second[:-1])
    starts = np.flatnonzero(new)
    live = values["live"] > 0.5

    def reduce(ufunc: np.ufunc, column: NDArray) -> NDArray:
        return ufunc.reduceat(column, starts) if len(starts) else np.empty(0)

    def now(name: str) -> NDArray:
        return np.where(live, values[name], 0.0)

    peak, initial = values["peak_overlap"], values["initial"]
    never = {name: np.where(values[name] < 0, np.inf, values[name]) for name in _TIMES}
    times = {name: reduce(np.minimum, never[name]) for name in ("time_first", "time_yield")}
    times["time_peak"] = never["time_peak"][starts]
    return {
        "i": first[starts],
        "j": second[starts],
        "overlap": reduce(np.add, now("overlap")),
        "force": reduce(np.add, now("force")),
        "tangential_force": reduce(np.add, now("tangential_force")),
        "peak_overlap": reduce(np.maximum, peak),
        "initial_overlap": reduce(np.maximum, initial),
        "grown_overlap": reduce(np.maximum, np.where(peak > initial, peak, 0.0)),
        "peak_force": reduce(np.maximum, values["peak_force"]),
        "elastic_energy": reduce(np.add, now("elastic") + now("elastic_tangential")),
        "dissipated_energy": reduce(np.add, values["dissipated"] + values["friction"] + values["viscous"]),
        "friction_energy": reduce(np.add, values["friction"]),
        **({"viscous_energy": reduce(np.add, values["viscous"])} if "viscous" in dents.columns else {}),
        **{name: np.where(np.isfinite(times[name]), times[name], np.nan) for name in _TIMES},
        "n_dents": np.diff(np.append(starts, len(first))),
    }


def list_contacts(
    merged: Contacts, touching: NDArray[np.int64], yield_overlap: float | NDArray[np.float64]
) -> Contacts:
    """Make the rows of ``/contacts``: pairs that touch at the start, and pairs loaded beyond `LISTED_FROM`.

    Parameters
    ----------
    merged
        Result of `merge_dents`.
    touching
        Pairs of ids that touch at the start, i < j: (n, 2).
    yield_overlap
        alpha_y of all pairs, or of each of ``merged``, m; if it is not finite, all loaded pairs are listed.

    Returns
    -------
    dict
        As in `merge_dents`, and ``touching`` (bool), True for pairs that touched at the start. Rows are sorted by
        (i, j).
    """
    stride = 1 + max(touching.max(initial=0), merged["j"].max(initial=0))
    dented = merged["i"] * stride + merged["j"]
    at_start = _sorted_once(touching[:, 0] * stride + touching[:, 1])
    threshold = np.where(np.isfinite(yield_overlap), LISTED_FROM * np.asarray(yield_overlap), 0.0)
    keys = _sorted_once(np.concatenate([at_start, dented[merged["peak_overlap"] > threshold]]))
    target = np.searchsorted(keys, dented)
    known = target < len(keys)
    known[known] = keys[target[known]] == dented[known]
    result: Contacts = {"i": keys // stride, "j": keys % stride}
    for name, column in merged.items():
        if name not in result:
            result[name] = np.full(len(keys), np.nan if name in _TIMES else 0, dtype=column.dtype)
            result[name][target[known]] = column[known]
    result["touching"] = np.zeros(len(keys), dtype=bool)
    result["touching"][np.searchsorted(keys, at_start)] = True
    return result


def _sorted_once(keys: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return sorted keys, each once; many times as fast as np.unique where the keys come in sorted runs."""
    keys = np.sort(keys.astype(np.int64), kind="stable")
    return keys[np.concatenate([[True], keys[1:] != keys[:-1]])] if len(keys) else keys


def touching_pairs(
    ids: NDArray[np.int64],
    positions: NDArray[np.float64],
    radii: NDArray[np.float64],
    tolerance: float,
    periods: tuple[float, float, float] = (0.0, 0.0, 0.0),
    low: NDArray[np.float64] | None = None,
) -> NDArray[np.int64]:
    """Find the pairs of spheres that touch.

    Parameters
    ----------
    ids
        Ids of the spheres: (n_spheres,), rising.
    positions
        Centres: (n_spheres, 3), m.
    radii
        Radii: (n_spheres,), m.
    tolerance
        Largest gap of touching spheres, m; overlapping ones are included.
    periods
        Length of the box along periodic axes, 0 along others, m.
    low
        Lowest coordinates of all spheres, if these are a part of them: (3,), m.

    Returns
    -------
    ndarray
        Pairs of ids, i < j, sorted: (n_contacts, 2).
    """
    lengths = np.array(periods)
    along = lengths > 0
    places = positions - np.minimum(positions.min(axis=0, initial=0.0) if low is None else low, 0.0)
    places[:, along] %= lengths[along]
    places[:, along] *= places[:, along] < lengths[along]  # a remainder may round up to the length
    if len(places) <= _FEW:
        pairs = np.stack(np.triu_indices(len(places), 1), axis=1)
    else:
        pairs = _near_pairs(places, radii, tolerance, lengths if along.any() else None)
    step = places[pairs[:, 1]] - places[pairs[:, 0]]
    step[:, along] -= lengths[along] * np.round(step[:, along] / lengths[along])
    gap = np.sqrt(np.einsum("ij,ij->i", step, step)) - radii[pairs].sum(axis=1)
    touching = ids[pairs[gap <= tolerance]]
    return touching[np.lexsort((touching[:, 1], touching[:, 0]))]


def _near_pairs(
    places: NDArray[np.float64], radii: NDArray[np.float64], tolerance: float, boxsize: NDArray[np.float64] | None
) -> NDArray[np.int64]:
    """Find the pairs of spheres that may touch: rows, (n_pairs, 2)."""
    from scipy.spatial import cKDTree  # takes longer to load than small packings to analyse

    large = np.flatnonzero(radii > _LARGE * np.median(radii))
    small = np.flatnonzero(radii <= _LARGE * np.median(radii))
    tree = cKDTree(places[small], boxsize=boxsize)
    found = [small[tree.query_pairs(2 * radii[small].max(initial=0.0) + tolerance, output_type="ndarray")]]
    if len(large):
        everyone = cKDTree(places, boxsize=boxsize)
        near = everyone.query_ball_point(places[large], radii[large] + radii.max() + tolerance)
        found += [
            np.stack([np.full(len(others), one), others], axis=1) for one, others in zip(large, near, strict=True)
        ]
    pairs = np.sort(np.concatenate(found), axis=1)
    return np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0) if len(large) else pairs


def sphere_values(
    ids: NDArray[np.int64], contacts: Contacts, yielded: NDArray[np.bool_], share: float | NDArray[np.float64] = 0.5
) -> dict[str, NDArray]:
    """Sum up the contacts of each sphere, rows by id.

    Parameters
    ----------
    ids
        Ids of the spheres, rising: (n_spheres,).
    contacts
        Result of `list_contacts`.
    yielded
        True for contacts that have yielded: (n_contacts,).
    share
        Share of the first sphere in the energy dissipated by yielding; (n_contacts,) or one for all. Dissipation by
        friction and viscous losses is halved.

    Returns
    -------
    dict
        ``peak_force`` of the largest single contact, N; ``peak_overlap``, m; ``dissipated_energy`` and its part
        ``friction_energy``, with viscous losses ``viscous_energy``, J; ``contacts_yielded``; ``coordination`` at the
        start; ``time_first``, ``time_yield`` of the earliest contact, s (NaN: never). Each (n_spheres,).
    """
    n_spheres = len(ids)
    ends = rows_of(ids, np.concatenate([contacts["i"], contacts["j"]]))

    def both(column: NDArray) -> NDArray:
        return np.concatenate([column, column])

    def extreme(ufunc: np.ufunc, name: str, start: float) -> NDArray:
        result = np.full(n_spheres, start)
        loaded = contacts["peak_overlap"] > 0
        ufunc.at(result, ends[both(loaded)], both(np.nan_to_num(contacts[name][loaded], nan=start)))
        return result

    def count(mask: NDArray) -> NDArray:
        return np.bincount(ends[both(mask)], minlength=n_spheres)

    times = {name: extreme(np.minimum, name, np.inf) for name in ("time_first", "time_yield")}
    friction = contacts["friction_energy"]
    viscous = {name: contacts[name] for name in ("viscous_energy",) if name in contacts}
    halved = sum(viscous.values(), start=friction)
    plastic = contacts["dissipated_energy"] - halved
    lost = np.concatenate([part * plastic + 0.5 * halved for part in (share, 1 - share)])
    return {
        "peak_force": extreme(np.maximum, "peak_force", 0.0),
        "peak_overlap": extreme(np.maximum, "peak_overlap", 0.0),
        "dissipated_energy": np.bincount(ends, lost, minlength=n_spheres),
        "friction_energy": np.bincount(ends, 0.5 * both(friction), minlength=n_spheres),
        **{name: np.bincount(ends, 0.5 * both(lost), minlength=n_spheres) for name, lost in viscous.items()},
        "contacts_yielded": count(yielded),
        "coordination": count(contacts["touching"]),
        **{name: np.where(np.isfinite(time), time, np.nan) for name, time in times.items()},
    }


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
