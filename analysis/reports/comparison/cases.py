"""Differences of the cases of several runs: keys, and grains one by one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.reports.comparison.ends import END_KEY, LATER, end_of, have_unlike_ends
from granwave.analysis.reports.comparison.grain_ids import ids_in_words
from granwave.analysis.reports.comparison.subjects import (
    ComparedRun,
    LackingError,
    comparable_keys,
    is_physical,
    value_text,
)
from granwave.analysis.reports.setting import differing, setting_of
from granwave.lammps_inputs.errors import GranwaveError

_SAME = 1e-12  # relative tolerance of equal diameters
_SAME_PLACE = 1e-9  # tolerance of equal positions, diameters
_MOST_DIAMETERS = 4  # combinations of diameters that are listed one by one
_MOST_ROWS = 12  # most rows for grains; further grains are counted
NOT_RECORDED = "not recorded"
UNNAMED = "unnamed"  # name of a material without a name
_OF_PACKING = "packing."
_REPLACED = "replace"  # key whose changes are listed by grain


@dataclass(frozen=True)
class Difference:
    """A key, or some grains, that differ between the cases of runs.

    Attributes
    ----------
    what
        Dotted key, or grains.
    values
        In words, by run: (n_runs,).
    is_numerical
        True for keys of the tables run and output, which change how a run is followed; False for
        ends that differ, which change results.
    """

    what: str
    values: tuple[str, ...]
    is_numerical: bool = False


@dataclass(frozen=True, eq=False)
class _Grains:
    """Grains of a run by id: material, diameter (m) and centre (m)."""

    ids: NDArray[np.int64]
    materials: list[str]
    diameter: NDArray[np.float64]
    position: NDArray[np.float64]


def case_differences(runs: Sequence[ComparedRun]) -> list[Difference]:
    """Return the differences between cases: kinds, physical keys, grains, then numerical keys."""
    with_case = [run.run for run in runs if run.run.case]
    keys = differing(with_case) if len(with_case) > 1 else []
    rows = _kind_rows(runs)
    if rows:  # the keys of one kind only do not apply to the other kinds
        keys = comparable_keys(keys, with_case)
    own = [key for key in keys if is_physical(key)]
    rest = [key for key in keys if not is_physical(key)]
    is_moved = any(key.startswith(_OF_PACKING) for key in own)
    grains = _grain_rows(runs, places=not is_moved)
    if grains:
        own = [key for key in own if key != _REPLACED]
    rows += [_key_row(key, runs) for key in own]
    rows += grains
    rest = [key for key in rest if key != END_KEY]
    rows += _end_rows(runs)
    rows += [_key_row(key, runs, is_numerical=True) for key in rest]
    return rows


def _kind_rows(runs: Sequence[ComparedRun]) -> list[Difference]:
    """Return rows with the kinds and the settings of the runs, if the kinds differ."""
    nouns = tuple(run.run.kind.noun for run in runs)
    if len(set(nouns)) < 2:
        return []
    settings = tuple(setting_of(run.run.case) if run.run.case else NOT_RECORDED for run in runs)
    return [Difference("kind of run", nouns), Difference("setting", settings)]


def _key_row(key: str, runs: Sequence[ComparedRun], *, is_numerical: bool = False) -> Difference:
    texts = [value_text(key, run.run.case) if run.run.case else NOT_RECORDED for run in runs]
    return Difference(key, tuple(texts), is_numerical)


def _end_rows(runs: Sequence[ComparedRun]) -> list[Difference]:
    """Return a row with the end times of runs, if the requested times or the ends differ; the time
    that a run reached stands next to the requested time where they differ.
    """
    asked = {str(run.run.case[END_KEY]) for run in runs if END_KEY in run.run.case}
    is_unlike = have_unlike_ends(runs) or any(run.unfinished for run in runs)
    if len(asked) < 2 and not is_unlike:
        return []
    texts = tuple(_end_text(run) for run in runs)
    return [Difference(END_KEY, texts, is_numerical=not is_unlike)]


def _end_text(run: ComparedRun) -> str:
    """Return the requested end time of a run: ``1 ms``; with the time at which it stopped, if it
    stopped earlier: ``70 µs of 1 ms (interrupted)``.
    """
    reached = quantity_in(end_of(run), "s")
    asked = run.run.case.get(END_KEY)
    if asked is None:
        return reached
    text = value_text(END_KEY, run.run.case)
    is_at_end = isinstance(asked, float | int) and end_of(run) * LATER >= asked
    if is_at_end and not run.run.is_unfinished:
        return text
    state = f" ({run.run.record['state']})" if run.run.is_unfinished else ""
    if isinstance(asked, str):
        return f"{text}: {reached}{state}"
    return f"{reached} of {text}{state}"


def _grain_rows(runs: Sequence[ComparedRun], *, places: bool) -> list[Difference]:
    """Return rows for grains of the same ids that differ in material, diameter or position.

    Positions are omitted without ``places``, if a key of the packing already states the difference.
    """
    grains: list[_Grains] = []
    for run in runs:
        try:
            grains.append(_grains_of(run))
        except (LackingError, GranwaveError):
            return []
    first = grains[0]
    if not all(np.array_equal(other.ids, first.ids) for other in grains):
        return []
    rows = _material_rows(grains)
    rows += _number_rows(grains, places=places)
    if len(rows) > _MOST_ROWS:
        left = len(rows) - _MOST_ROWS
        more = Difference(f"{left} more groups of grains", ("",) * len(runs))
        return [*rows[:_MOST_ROWS], more]
    return rows


def _grains_of(run: ComparedRun) -> _Grains:
    with run.opened() as result:
        assembly = result.assembly
        ids = result["spheres/id"].astype(np.int64)
        names = [species.material.name or UNNAMED for species in assembly.species]
        materials = [names[number] for number in assembly.body[ids - 1].tolist()]
        return _Grains(ids, materials, 2 * result["spheres/radius"], result["spheres/position"])


def _material_rows(grains: Sequence[_Grains]) -> list[Difference]:
    """Return a row for each combination of materials that differ, with the grains that have it."""
    groups: dict[tuple[str, ...], list[int]] = {}
    columns = [one.materials for one in grains]
    if all(column == columns[0] for column in columns):
        return []
    if all(len(set(column)) == 1 for column in columns):
        return []  # the change is listed under the key of the material
    for sphere, combination in zip(grains[0].ids.tolist(), zip(*columns, strict=True), strict=True):
        if len(set(combination)) > 1:
            groups.setdefault(combination, []).append(sphere)
    return [
        Difference(f"material of {ids_in_words(ids)}", combination)
        for combination, ids in groups.items()
    ]


def _number_rows(grains: Sequence[_Grains], *, places: bool) -> list[Difference]:
    """Return rows for diameters and positions that differ: which grains, and by how much."""
    first = grains[0]
    scale = float(first.diameter.max(initial=0.0))
    sizes = [other.diameter - first.diameter for other in grains]
    moves = [np.linalg.norm(other.position - first.position, axis=1) for other in grains]
    rows: list[Difference] = []
    if not _is_constant(sizes):  # the change is listed under another key
        rows += _diameter_rows(grains, sizes, _SAME * scale)
    if places:
        rows += _changed_row("position", first.ids, moves, _SAME_PLACE * scale)
    return rows


def _diameter_rows(
    grains: Sequence[_Grains], changes: Sequence[NDArray[np.float64]], least: float
) -> list[Difference]:
    """Return a row for each combination of diameters that differ; a row with the largest changes if
    there are many combinations.
    """
    is_changed = np.max(np.abs(changes), axis=0) > least
    columns = [_lengths(one.diameter[is_changed]) for one in grains]
    groups: dict[tuple[str, ...], list[int]] = {}
    for sphere, texts in zip(grains[0].ids[is_changed], zip(*columns, strict=True), strict=True):
        groups.setdefault(texts, []).append(int(sphere))
    if len(groups) > _MOST_DIAMETERS:
        return _changed_row("diameter", grains[0].ids, changes, least)
    return [Difference(f"diameter of {ids_in_words(ids)}", texts) for texts, ids in groups.items()]


def _lengths(values: NDArray[np.float64]) -> list[str]:
    return [quantity_in(value, "m") for value in values.tolist()]


def _changed_row(
    what: str, ids: NDArray[np.int64], changes: Sequence[NDArray[np.float64]], least: float
) -> list[Difference]:
    """Return the row of the grains that changed by more than ``least``, m; empty without any."""
    changed = ids[np.max(np.abs(changes), axis=0) > least]
    if not len(changed):
        return []
    texts = [_change_text(change) for change in changes]
    return [Difference(f"{what} of {ids_in_words(changed.tolist())}", tuple(texts))]


def _is_constant(changes: Sequence[NDArray[np.float64]]) -> bool:
    return all(np.ptp(change) <= _SAME * np.abs(change).max(initial=0.0) for change in changes)


def _change_text(change: NDArray[np.float64]) -> str:
    largest = float(np.abs(change).max(initial=0.0))
    return f"changed by up to {quantity_in(largest, 'm')}" if largest else "the reference"
