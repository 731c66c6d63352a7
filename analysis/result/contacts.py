"""Contacts of a run as a table of pairs: dents of one pair merged, pairs that only touched added.

Which spheres touch at the start is found from their positions and radii, whatever the packing.

A pair can own several dents: one is forgotten when the gap exceeds the set distance, and the next meeting
starts a new one. Here a pair is one row: the largest of the peaks, the sum of the energies, the earliest of
the times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from granwave.analysis.lammps_output.dumps import Frame, rows_of

LISTED_FROM = 1e-6  # of alpha_y: from this peak on a pair that did not touch at the start is listed

Contacts = dict[str, NDArray]
_TIMES = ("time_first", "time_peak", "time_yield")
_FRICTION_COLUMNS = ("tangential_force", "elastic_tangential", "friction")
_LARGE = 1.5  # median radii: from this size on a sphere's neighbours are searched for it alone


def merge_dents(dents: Frame) -> Contacts:
    """The dents of `granwave.analysis.lammps_output.dumps.read_contacts` as one row a pair, sorted by (i, j).

    Returns
    -------
    dict
        ``i``, ``j`` (n_pairs,), i < j; ``overlap``, ``peak_overlap``, ``initial_overlap`` (dent before the run) m;
        ``force``, ``peak_force``, ``tangential_force`` N; ``elastic_energy``, ``dissipated_energy`` (of yielding and
        friction), ``friction_energy`` J; ``time_first``, ``time_peak``, ``time_yield`` s (NaN: never); ``n_dents``;
        ``grown_overlap``: the deepest dent that grew in this run, m.
    """
    first, second = np.sort(dents.vector("i", "j").astype(np.int64), axis=1).T
    order = np.lexsort((-dents["peak_overlap"], second, first))  # of a pair the deepest dent comes first
    values = {name: dents.get(name)[order] for name in (*dents.columns, *_FRICTION_COLUMNS, "initial")}
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
        "dissipated_energy": reduce(np.add, values["dissipated"] + values["friction"]),
        "friction_energy": reduce(np.add, values["friction"]),
        **{name: np.where(np.isfinite(times[name]), times[name], np.nan) for name in _TIMES},
        "n_dents": np.diff(np.append(starts, len(first))),
    }


def list_contacts(
    merged: Contacts, touching: NDArray[np.int64], yield_overlap: float | NDArray[np.float64]
) -> Contacts:
    """The pairs of ``/contacts``: those that touch at the start, and those pressed beyond `LISTED_FROM`.

    Parameters
    ----------
    merged
        Of `merge_dents`.
    touching
        Pairs of ids that touch at the start, i < j: (n, 2).
    yield_overlap
        alpha_y, of all pairs or of each of ``merged``, m; where it is not finite, all pairs ever loaded are listed.

    Returns
    -------
    dict
        As `merge_dents`, and ``touching`` (bool): whether the pair touched at the start. Rows sorted by (i,
        j).
    """
    stride = 1 + max(touching.max(initial=0), merged["j"].max(initial=0))
    dented = merged["i"] * stride + merged["j"]
    at_start = np.unique(touching[:, 0] * stride + touching[:, 1]).astype(np.int64)
    threshold = np.where(np.isfinite(yield_overlap), LISTED_FROM * np.asarray(yield_overlap), 0.0)
    keys = np.union1d(at_start, dented[merged["peak_overlap"] > threshold])
    target = np.searchsorted(keys, dented)
    known = target < len(keys)
    known[known] = keys[target[known]] == dented[known]
    result: Contacts = {"i": keys // stride, "j": keys % stride}
    for name, column in merged.items():
        if name not in result:
            result[name] = np.full(len(keys), np.nan if name in _TIMES else 0, dtype=column.dtype)
            result[name][target[known]] = column[known]
    result["touching"] = np.isin(keys, at_start, assume_unique=True)
    return result


def touching_pairs(
    ids: NDArray[np.int64],
    positions: NDArray[np.float64],
    radii: NDArray[np.float64],
    tolerance: float,
    periods: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> NDArray[np.int64]:
    """Pairs of spheres that touch, found by ordinary search.

    Parameters
    ----------
    ids
        (n_spheres,), rising.
    positions
        (n_spheres, 3), m.
    radii
        (n_spheres,), m.
    tolerance
        Gap up to which two spheres touch, m; overlapping ones do too.
    periods
        Length of the box along the axes along which it goes on, 0 along the others, m.

    Returns
    -------
    ndarray
        Pairs of ids, i < j, sorted: (n_contacts, 2).
    """
    lengths = np.array(periods)
    along = lengths > 0
    places = positions - positions.min(axis=0, initial=0.0)
    places[:, along] %= lengths[along]
    places[:, along] *= places[:, along] < lengths[along]  # a remainder may round up to the length
    large = np.flatnonzero(radii > _LARGE * np.median(radii))
    small = np.flatnonzero(radii <= _LARGE * np.median(radii))
    boxsize = lengths if along.any() else None

    tree = cKDTree(places[small], boxsize=boxsize)
    found = [small[tree.query_pairs(2 * radii[small].max(initial=0.0) + tolerance, output_type="ndarray")]]
    if len(large):
        everyone = cKDTree(places, boxsize=boxsize)
        near = everyone.query_ball_point(places[large], radii[large] + radii.max() + tolerance)
        found += [
            np.stack([np.full(len(others), one), others], axis=1) for one, others in zip(large, near, strict=True)
        ]
    pairs = np.sort(np.concatenate(found), axis=1)
    pairs = np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0) if len(large) else pairs
    step = places[pairs[:, 1]] - places[pairs[:, 0]]
    step[:, along] -= lengths[along] * np.round(step[:, along] / lengths[along])
    gap = np.sqrt(np.einsum("ij,ij->i", step, step)) - radii[pairs].sum(axis=1)
    touching = ids[pairs[gap <= tolerance]]
    return touching[np.lexsort((touching[:, 1], touching[:, 0]))]


def sphere_values(
    ids: NDArray[np.int64], contacts: Contacts, yielded: NDArray[np.bool_], share: float | NDArray[np.float64] = 0.5
) -> dict[str, NDArray]:
    """Sums of the contacts of each sphere, rows by id.

    Parameters
    ----------
    ids
        Of the spheres, rising: (n_spheres,).
    contacts
        Of `list_contacts`.
    yielded
        Which of them have yielded: (n_contacts,).
    share
        Of the energy that a contact dissipates by yielding, of its first sphere; (n_contacts,) or one for all. What
        friction takes is halved.

    Returns
    -------
    dict
        ``peak_force`` of the largest single contact, N; ``peak_overlap``, m; ``dissipated_energy`` and, of that,
        ``friction_energy``, J; ``contacts_yielded``; ``coordination`` at the start; ``time_first``, ``time_yield``: of
        the earliest contact, s (NaN: never). Each (n_spheres,).
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
    rubbed = contacts["friction_energy"]
    plastic = contacts["dissipated_energy"] - rubbed
    lost = np.concatenate([part * plastic + 0.5 * rubbed for part in (share, 1 - share)])
    return {
        "peak_force": extreme(np.maximum, "peak_force", 0.0),
        "peak_overlap": extreme(np.maximum, "peak_overlap", 0.0),
        "dissipated_energy": np.bincount(ends, lost, minlength=n_spheres),
        "friction_energy": np.bincount(ends, 0.5 * both(rubbed), minlength=n_spheres),
        "contacts_yielded": count(yielded),
        "coordination": count(contacts["touching"]),
        **{name: np.where(np.isfinite(time), time, np.nan) for name, time in times.items()},
    }
