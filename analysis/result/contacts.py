"""Contacts of a run as a table of pairs: the dents of a pair are merged, and unloaded touching
pairs are added.

Touching pairs at the start follow from positions and radii, for any packing.

A pair may have several dents: a dent is forgotten when the gap exceeds a given distance, and the
next contact starts a new dent. In this table each pair is one row, with the largest peak, the sum
of the energies and the earliest times. Constants of the contact laws of pairs are yield overlap,
effective radius and fractions of dissipation.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.lammps_output.frame import Frame
from granwave.analysis.result.hdf5_file import rows_of, sorted_once
from granwave.lammps_inputs.case.material import Material
from granwave.lammps_inputs.contact.law import law_between
from granwave.lammps_inputs.packing.assembly import Assembly

# peak overlap over alpha_y from which on pairs that did not touch at the start are listed
LISTED_FROM = 1e-6
# fraction of the largest force of a contact that marks the arrival of the wave, as in the plugin
ARRIVED = 0.1

Contacts = dict[str, NDArray]
_TIMES = ("time_first", "time_peak", "time_yield")
# tolerance of the overlap of touching grains over their coordinates: last digits of both and of
# their distance
_ROUNDING = 4 * float(np.finfo(np.float64).eps)
# spheres up to which all pairs are checked: building a tree takes longer for few spheres
_FEW = 1000
# radius over the median from which on the neighbours of a sphere are searched separately
_LARGE = 1.5


def merge_dents(dents: Frame) -> Contacts:
    """Merge the dents of `granwave.analysis.lammps_output.dumps.contacts_at_end` into one row a
    pair, sorted by (i, j).

    Returns
    -------
    dict
        ``i``, ``j`` (n_pairs,), i < j; ``overlap``, ``peak_overlap``, ``initial_overlap`` (initial
        dent) m; ``force``, ``peak_force``, ``tangential_force`` N; ``elastic_energy``,
        ``dissipated_energy`` (of yielding, friction and viscous losses), ``friction_energy``, with
        viscous losses ``viscous_energy`` J; ``time_first`` (arrival at a tenth of the largest force
        of the run, which may be of a later wave), ``time_peak``, ``time_yield`` s (NaN: never);
        ``n_dents``; ``grown_overlap``: largest overlap of dents that grew in this run, m.
    """
    first, second = dents.pairs.T
    # the deepest indentation of a pair comes first
    order = np.lexsort((-dents["peak_overlap"], second, first))
    first = first[order]
    second = second[order]
    new = np.ones(len(first), dtype=bool)
    new[1:] = (first[1:] != first[:-1]) | (second[1:] != second[:-1])
    starts = np.flatnonzero(new)
    live = dents["live"][order] > 0.5
    rows = _DentRows(dents, order, starts, live)
    # one column at a time: there are many rows
    merged: Contacts = {"i": first[starts], "j": second[starts]}
    merged["overlap"] = rows.added(rows.live("overlap"))
    merged["force"] = rows.added(rows.live("force"))
    merged["tangential_force"] = rows.added(rows.live("tangential_force"))
    merged["peak_overlap"] = rows.largest(rows.all("peak_overlap"))
    merged["initial_overlap"] = rows.largest(rows.all("initial"))
    merged["grown_overlap"] = rows.largest(rows.grown_overlap())
    merged["peak_force"] = rows.largest(rows.all("peak_force"))
    merged["elastic_energy"] = rows.added(rows.live("elastic", "elastic_tangential"))
    merged["dissipated_energy"] = rows.added(rows.all("dissipated", "friction", "viscous"))
    merged["friction_energy"] = rows.added(rows.all("friction"))
    if "viscous" in dents.columns:
        merged["viscous_energy"] = rows.added(rows.all("viscous"))
    merged["time_first"] = rows.earliest(rows.arrival_time())
    merged["time_yield"] = rows.earliest(rows.time("time_yield"))
    merged["time_peak"] = rows.time("time_peak")[starts]
    for name in _TIMES:
        merged[name] = _or_never(merged[name])
    merged["n_dents"] = rows.n_of_pair()
    return merged


@dataclasses.dataclass(frozen=True, eq=False)
class _DentRows:
    """Dents, one pair after the other.

    Attributes
    ----------
    dents
        Dents in the order of the output.
    order
        Rows of the dents by pair: (n,).
    starts
        Position of the first dent of each pair in `order`: (n_pairs,).
    is_live
        True for dents that are in contact: (n,).
    """

    dents: Frame
    order: NDArray[np.int64]
    starts: NDArray[np.int64]
    is_live: NDArray[np.bool_]

    def all(self, *names: str) -> NDArray[np.float64]:
        """Return the sum of columns."""
        values = self.dents.get(names[0])[self.order]
        for name in names[1:]:
            values = values + self.dents.get(name)[self.order]
        return values

    def live(self, *names: str) -> NDArray[np.float64]:
        """Return the sum of columns, 0 for dents that are not in contact."""
        values = np.where(self.is_live, self.all(names[0]), 0.0)
        for name in names[1:]:
            values = values + np.where(self.is_live, self.all(name), 0.0)
        return values

    def time(self, name: str) -> NDArray[np.float64]:
        """Return a column of times, infinite for events that did not occur."""
        time = self.all(name)
        return np.where(time < 0, np.inf, time)

    def arrival_time(self) -> NDArray[np.float64]:
        """Return times of arrival, infinite for dents whose force is small for their pair."""
        force = self.all("peak_force")
        largest = np.repeat(self.largest(force), self.n_of_pair())
        return np.where(force >= ARRIVED * largest, self.time("time_first"), np.inf)

    def grown_overlap(self) -> NDArray[np.float64]:
        """Return the peak overlaps, 0 for dents that did not grow in this run."""
        peak = self.all("peak_overlap")
        return np.where(peak > self.all("initial"), peak, 0.0)

    def n_of_pair(self) -> NDArray[np.int64]:
        """Return the number of dents of each pair: (n_pairs,)."""
        return np.diff(np.append(self.starts, len(self.order)))

    def added(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the sum over the dents of each pair: (n_pairs,)."""
        return self._joined(np.add, values)

    def largest(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the largest value of each pair: (n_pairs,)."""
        return self._joined(np.maximum, values)

    def earliest(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the smallest value of each pair: (n_pairs,)."""
        return self._joined(np.minimum, values)

    def _joined(self, function: np.ufunc, values: NDArray[np.float64]) -> NDArray[np.float64]:
        if not len(self.starts):  # reduceat needs a start
            return np.empty(0)
        joined: NDArray[np.float64] = function.reduceat(values, self.starts)
        return joined


def _or_never(time: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times, with NaN for events that did not occur."""
    return np.where(np.isfinite(time), time, np.nan)


def list_contacts(
    merged: Contacts, touching: NDArray[np.int64], yield_overlap: float | NDArray[np.float64]
) -> Contacts:
    """Make the rows of ``/contacts``: pairs that touch at the start, and pairs loaded beyond
    `LISTED_FROM`.

    Parameters
    ----------
    merged
        Result of `merge_dents`.
    touching
        Pairs of ids that touch at the start, i < j: (n, 2).
    yield_overlap
        alpha_y of all pairs, or of each of ``merged``, m; if it is not finite, all loaded pairs are
        listed.

    Returns
    -------
    dict
        As in `merge_dents`, and ``touching`` (bool), True for pairs that touched at the start. Rows
        are sorted by (i, j).
    """
    stride = 1 + max(touching.max(initial=0), merged["j"].max(initial=0))
    dented = merged["i"] * stride + merged["j"]
    first, second = touching.T
    at_start = sorted_once(first * stride + second)
    threshold = np.where(np.isfinite(yield_overlap), LISTED_FROM * np.asarray(yield_overlap), 0.0)
    keys = sorted_once(np.concatenate([at_start, dented[merged["peak_overlap"] > threshold]]))
    target = np.searchsorted(keys, dented)
    known = target < len(keys)
    known[known] = keys[target[known]] == dented[known]
    result: Contacts = {
        "i": keys // stride,
        "j": keys % stride,
        "touching": np.zeros(len(keys), dtype=bool),
    }
    for name, column in merged.items():
        if name not in result:
            result[name] = np.full(len(keys), np.nan if name in _TIMES else 0, dtype=column.dtype)
            result[name][target[known]] = column[known]
    result["touching"][np.searchsorted(keys, at_start)] = True
    return result


def is_loaded(
    overlap: NDArray[np.float64], yield_overlap: NDArray[np.float64], force: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """Return True for loaded contacts: (n_contacts,).

    The force is positive, and the overlap exceeds `LISTED_FROM` of the yield overlap: grains that
    touch overlap by the rounding of their coordinates. Without a finite yield overlap any positive
    force counts.

    Parameters
    ----------
    overlap, yield_overlap
        Largest overlap and alpha_y: (n_contacts,), m.
    force
        Largest force: (n_contacts,), N.
    """
    least = np.where(np.isfinite(yield_overlap), LISTED_FROM * yield_overlap, 0.0)
    return (overlap > least) & (force > 0)


def leave_out_rounding(contacts: Contacts, box: NDArray[np.float64]) -> None:
    """Remove the time of arrival of contacts with an overlap that never exceeded the rounding of
    coordinates in the box, (3, 2), m: no wave has reached them.
    """
    untouched = contacts["peak_overlap"] <= _ROUNDING * np.abs(box).max()
    contacts["time_first"][untouched] = np.nan


def touching_pairs(
    ids: NDArray[np.int64],
    positions: NDArray[np.float64],
    radii: NDArray[np.float64],
    tolerance: float,
    periods: tuple[float, float, float] = (0.0, 0.0, 0.0),
    low: NDArray[np.float64] | None = None,
) -> NDArray[np.int64]:
    """Find the pairs of spheres that touch: ids, i < j, sorted, (n_contacts, 2).

    Parameters
    ----------
    ids, positions, radii
        Ids of the spheres, rising, (n_spheres,), centres, (n_spheres, 3), m, and radii,
        (n_spheres,), m.
    tolerance
        Largest gap of touching spheres, m; overlapping ones are included.
    periods
        Length of the box along periodic axes, 0 along others, m.
    low
        Lowest coordinates of all spheres, if these are a part of them: (3,), m.
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
    first, second = pairs.T
    step = places[second] - places[first]
    step[:, along] -= lengths[along] * np.round(step[:, along] / lengths[along])
    gap = np.sqrt(np.einsum("ij,ij->i", step, step)) - radii[pairs].sum(axis=1)
    touching = ids[pairs[gap <= tolerance]]
    first, second = touching.T
    return touching[np.lexsort((second, first))]


def _near_pairs(
    places: NDArray[np.float64],
    radii: NDArray[np.float64],
    tolerance: float,
    boxsize: NDArray[np.float64] | None,
) -> NDArray[np.int64]:
    """Find the pairs of spheres that may touch: rows, (n_pairs, 2)."""
    from scipy.spatial import cKDTree  # imported on demand: slow to load

    large = np.flatnonzero(radii > _LARGE * np.median(radii))
    small = np.flatnonzero(radii <= _LARGE * np.median(radii))
    tree = cKDTree(places[small], boxsize=boxsize)
    found = [
        small[
            tree.query_pairs(2 * radii[small].max(initial=0.0) + tolerance, output_type="ndarray")
        ]
    ]
    if len(large):
        everyone = cKDTree(places, boxsize=boxsize)
        near = everyone.query_ball_point(places[large], radii[large] + radii.max() + tolerance)
        found += [
            np.stack([np.full(len(others), one), others], axis=1)
            for one, others in zip(large, near, strict=True)
        ]
    pairs = np.sort(np.concatenate(found), axis=1)
    if not len(large):
        return pairs
    first, second = pairs.T
    return np.unique(pairs[first < second], axis=0)


def sphere_values(
    ids: NDArray[np.int64], contacts: Contacts, share: float | NDArray[np.float64] = 0.5
) -> dict[str, NDArray]:
    """Sum up the contacts of each sphere, rows by id.

    Parameters
    ----------
    ids
        Ids of the spheres, rising: (n_spheres,).
    contacts
        Result of `list_contacts`, and ``yielded``, True for contacts that have: (n_contacts,).
    share
        Fraction of the first sphere in the energy dissipated by yielding; (n_contacts,) or one for
        all. Dissipation by friction and viscous losses is halved.

    Returns
    -------
    dict
        ``peak_force`` of the largest single contact, N; ``peak_overlap``, m; ``dissipated_energy``
        and its part ``friction_energy``, with viscous losses ``viscous_energy``, J;
        ``contacts_yielded``; ``coordination`` at the start; ``time_first``, the earliest arrival
        at a contact that carries at least `ARRIVED` of the largest force, and ``time_yield`` of
        the earliest contact, s (NaN: never). Each (n_spheres,).
    """
    n_spheres = len(ids)
    ends = rows_of(ids, np.concatenate([contacts["i"], contacts["j"]]))
    loaded = np.tile(contacts["peak_overlap"] > 0, 2)

    def extreme(ufunc: np.ufunc, name: str, start: float, which: NDArray[np.bool_]) -> NDArray:
        result = np.full(n_spheres, start)
        values = np.nan_to_num(np.tile(contacts[name], 2)[which], nan=start)
        ufunc.at(result, ends[which], values)
        return result

    def count(mask: NDArray) -> NDArray:
        return np.bincount(ends[np.tile(mask, 2)], minlength=n_spheres)

    halved = {
        name: contacts[name] for name in ("friction_energy", "viscous_energy") if name in contacts
    }
    lost = sum(halved.values())
    plastic = contacts["dissipated_energy"] - lost
    lost = np.concatenate([part * plastic + 0.5 * lost for part in (share, 1 - share)])
    peak_force = extreme(np.maximum, "peak_force", 0.0, loaded)
    carries = loaded & (np.tile(contacts["peak_force"], 2) >= ARRIVED * peak_force[ends])
    return {
        "peak_force": peak_force,
        "peak_overlap": extreme(np.maximum, "peak_overlap", 0.0, loaded),
        "dissipated_energy": np.bincount(ends, lost, minlength=n_spheres),
        **{
            name: np.bincount(ends, 0.5 * np.tile(part, 2), minlength=n_spheres)
            for name, part in halved.items()
        },
        "contacts_yielded": count(contacts["yielded"]),
        "coordination": count(contacts["touching"]),
        "time_first": _or_never(extreme(np.minimum, "time_first", np.inf, carries)),
        "time_yield": _or_never(extreme(np.minimum, "time_yield", np.inf, loaded)),
    }


def pair_laws(
    assembly: Assembly, types: NDArray[np.int64], radii: NDArray[np.float64]
) -> dict[str, NDArray[np.float64]]:
    """Return the constants of pairs of spheres; every array is (n_pairs,).

    The law of two materials is made once; alpha_y is proportional to R*, which may differ between
    pairs. The law of cylinders is computed for each pair of radii.

    Parameters
    ----------
    types
        LAMMPS types of the spheres, which give their materials: (n_pairs, 2).
    radii
        Radii of the spheres: (n_pairs, 2), m.

    Returns
    -------
    dict
        ``yield_overlap`` alpha_y and ``effective_radius`` R*, m; ``yielded_from``, the peak overlap
        beyond which a contact has yielded, m, infinite if the law does not yield; ``share`` of the
        first sphere in the dissipation by yielding: half, or all or none if yield strengths differ.
    """
    case = assembly.case
    species = assembly.species
    usual = case.packing.diameter / 2
    found = {name: np.empty(len(types)) for name in ("yield_overlap", "yielded_from", "share")}
    found["effective_radius"] = radii.prod(axis=1) / radii.sum(axis=1)
    kind = types @ [len(species) + 1, 1]
    for number in np.unique(kind).tolist():
        rows = np.flatnonzero(kind == number)
        first, second = (species[one - 1] for one in divmod(number, len(species) + 1))
        materials = (first.material, second.material)
        shapes = (first.shape, second.shape)
        found["share"][rows] = dissipated_share(*materials)
        sizes = np.array([[usual, usual]])
        size = np.zeros(len(rows), dtype=np.int64)
        if any(shapes):
            sizes, size = np.unique(radii[rows], axis=0, return_inverse=True)
        for n, (r1, r2) in enumerate(sizes.tolist()):
            law = law_between(case.contact_between(*materials), materials, (r1, r2), shapes=shapes)
            chosen = rows[size.ravel() == n]
            if any(shapes):
                found["effective_radius"][chosen] = law.effective_radius
            scale = 1.0 if any(shapes) else found["effective_radius"][chosen] / (usual / 2)
            found["yield_overlap"][chosen] = law.yield_overlap * scale
            found["yielded_from"][chosen] = law.elastic_limit * scale
    return found


def dissipated_share(own: Material, partner: Material | None) -> float:
    """Return a body's fraction of the plastic dissipation of a contact: half, or all or none if
    yield strengths differ.
    """
    mine, theirs = (math.inf if one is None or one.yield_strength is None else one.yield_strength
                    for one in (own, partner))  # fmt: skip
    return 0.5 if mine == theirs else float(mine < theirs)
