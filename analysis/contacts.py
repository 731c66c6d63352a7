"""Contacts of a run as a table of pairs: dents of one pair merged, pairs that only touched added.

A pair can own several dents: one is forgotten when the gap exceeds the set distance, and the next meeting
starts a new one. Here a pair is one row: the largest of the peaks, the sum of the energies, the earliest of
the times.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.dumps import Frame

LISTED_FROM = 1e-6  # of alpha_y: from this peak on a pair that did not touch at the start is listed

Contacts = dict[str, NDArray]
_TIMES = ("time_first", "time_peak", "time_yield")


def merge_dents(dents: Frame) -> Contacts:
    """The dents of `granwave.analysis.dumps.read_contacts` as one row a pair, sorted by (i, j).

    Returns
    -------
    dict
        ``i``, ``j`` (n_pairs,), i < j; ``overlap``, ``peak_overlap`` m; ``force``, ``peak_force`` N;
        ``elastic_energy``, ``dissipated_energy`` J; ``time_first``, ``time_peak``, ``time_yield`` s (NaN:
        never); ``n_dents``.
    """
    first, second = np.sort(dents.vector("i", "j").astype(np.int64), axis=1).T
    order = np.lexsort((-dents["peak_overlap"], second, first))  # of a pair the deepest dent comes first
    values = {name: dents[name][order] for name in dents.columns}
    first, second = first[order], second[order]
    new = np.ones(len(first), dtype=bool)
    new[1:] = (first[1:] != first[:-1]) | (second[1:] != second[:-1])
    starts = np.flatnonzero(new)
    live = values["live"] > 0.5

    def reduce(ufunc: np.ufunc, column: NDArray) -> NDArray:
        return ufunc.reduceat(column, starts) if len(starts) else np.empty(0)

    never = {name: np.where(values[name] < 0, np.inf, values[name]) for name in _TIMES}
    times = {name: reduce(np.minimum, never[name]) for name in ("time_first", "time_yield")}
    times["time_peak"] = never["time_peak"][starts]
    return {
        "i": first[starts],
        "j": second[starts],
        "overlap": reduce(np.add, np.where(live, values["overlap"], 0.0)),
        "force": reduce(np.add, np.where(live, values["force"], 0.0)),
        "peak_overlap": reduce(np.maximum, values["peak_overlap"]),
        "peak_force": reduce(np.maximum, values["peak_force"]),
        "elastic_energy": reduce(np.add, np.where(live, values["elastic"], 0.0)),
        "dissipated_energy": reduce(np.add, values["dissipated"]),
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


def sphere_values(
    n_spheres: int, contacts: Contacts, yielded: NDArray[np.bool_], share: float | NDArray[np.float64] = 0.5
) -> dict[str, NDArray]:
    """What the contacts mean to each sphere, rows by id.

    Parameters
    ----------
    contacts
        Of `list_contacts`.
    yielded
        Which of them have yielded: (n_contacts,).
    share
        Of the dissipated energy of a contact that its first sphere gets; (n_contacts,) or one for all.

    Returns
    -------
    dict
        ``peak_force`` of the largest single contact, N; ``peak_overlap``, m; ``dissipated_energy``, J;
        ``contacts_yielded``; ``coordination`` at the start; ``time_first``, ``time_yield``: of the earliest
        contact, s (NaN: never). Each (n_spheres,).
    """
    ends = np.concatenate([contacts["i"], contacts["j"]]) - 1

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
    lost = np.concatenate([part * contacts["dissipated_energy"] for part in (share, 1 - share)])
    return {
        "peak_force": extreme(np.maximum, "peak_force", 0.0),
        "peak_overlap": extreme(np.maximum, "peak_overlap", 0.0),
        "dissipated_energy": np.bincount(ends, lost, minlength=n_spheres),
        "contacts_yielded": count(yielded),
        "coordination": count(contacts["touching"]),
        **{name: np.where(np.isfinite(time), time, np.nan) for name, time in times.items()},
    }
