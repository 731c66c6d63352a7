"""End times of the runs of a comparison, and values that depend on an earlier end."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any, Protocol

import h5py
import numpy as np

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.incomplete_values import DISSIPATED_FRACTION, incomplete_in
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import Reached
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import Mark, mark_of
from granwave.analysis.reports.comparison.curves import (
    SampledCurve,
    bottom_record,
    has_own_peak,
    has_peak_at_bottom,
)
from granwave.analysis.reports.comparison.subjects import ComparedRun, LackingError, names_in_words
from granwave.analysis.reports.setting import differing
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.run_directory import RESULT_FILE

GROWING = "zone_growing"  # directions in which the plastic zone still grows at the end
END_KEY = "run.end_time"
SETTLED = "settled"  # reason of the end of a run with an automatic end
_END = "end_time_s"
LATER = 1.01  # latest over earliest end above which runs end at different times
_CHANGE = 5e-3  # relative change up to which a value counts as final
_LAST_PART = 0.1  # fraction of the earliest run: values that still change in it are not final
_MOST_LISTED = 4  # runs that a sentence lists; of more the earliest and the latest
_EARLY = 0.5  # fraction of its own time by which a run of another case has a complete value
_LEAST_RUNS = 2
#: Keys that change what is recorded, or how ranks share the work, but no result.
_NO_RESULT = ("output.", "figures", "run.frames", "run.processors", "run.balance", END_KEY)

#: Values at the end of a run, which is arbitrary: no sentence calls them main results.
AT_THE_END = (
    "impactor_velocity_m_s", "plate_velocity_m_s", "energy_kinetic_J", "energy_rotational_J",
    "energy_elastic_J", "energy_plate_J", "energy_bar_J", "energy_incident_bar_J",
    "support_energy_J",
)  # fmt: skip
#: Values that have no dependence on the end once they exist, by patterns.
_INDEPENDENT = (
    "wave_speed_m_s", "restitution", "restitution_error", "line_*_front_speed_m_s",
    "transmission", "driven_velocity_m_s", "load_power_W", "absorbed_power_W",
    "amplitude_hysteresis", "energy_stored_J",
)  # fmt: skip

_IMPULSE = "wall_impulse_Ns"
_DYNAMIC_IMPULSE = "wall_dynamic_impulse_Ns"
#: Values of the peak force on the bottom, by patterns.
_PEAKS_AT_BOTTOM = (
    "wall_peak_force_N", "wall_dynamic_peak_force_N", "target_peak_force_N",
    "ground_peak_force_N", "base_arrival_s", "peak_reduction*", "ground_peak_reduction",
)  # fmt: skip
_OF_BOTTOM = (*_PEAKS_AT_BOTTOM, _IMPULSE, _DYNAMIC_IMPULSE)
#: Sizes of the plastic zone, by patterns, that grow in a direction of ``zone_growing``.
_GROWTH_ALONG = {
    "depth": ("plastic_zone_depth_m", "zone_depth_*", "plastic_zone_volume_m3", "zone_volume_*"),
    "radius": ("plastic_zone_radius_m", "zone_radius_*", "plastic_zone_volume_m3", "zone_volume_*"),
}
#: Counts of yielded contacts and of their spheres, by patterns.
_COUNTS = ("n_plastic_*", "n_dissipating_*")
#: Sizes of the plastic zone and counts of its parts, by patterns, which a boundary limits.
_OF_SIZE = (
    "plastic_zone_*", "zone_depth_*", "zone_radius_*", "zone_volume_*", "n_plastic_*",
    "n_dissipating_*",
)  # fmt: skip

_FRACTION = "_fraction"
_JOULES = "_J"  # end of the names of energies
_DISSIPATING = "n_dissipating_contacts"  # None where contacts cannot yield
_FRICTION = "friction"  # end of keys
_PAIRS = "pair"  # tables of laws between two materials
_DISSIPATED_ENERGY = "energy_dissipated_J"
#: Plastic dissipation, which is uncertain if the zone is.
_PLASTIC = "plastic_fraction"
_PLASTIC_ENERGY = "energy_dissipated_plastic_J"
_OF_PLASTIC = (_PLASTIC, _PLASTIC_ENERGY)
_ROTATION = "energy_rotational_J"
_OF_FRICTION = ("friction_fraction", "energy_dissipated_friction_J")
_OF_DISSIPATION = (DISSIPATED_FRACTION, _DISSIPATED_ENERGY, "energy_dissipated_wall_J")
_PARTS = ("energy_dissipated_*_J", "energy_absorbed_J")  # parts of energies, by patterns


class Course(Protocol):
    """Function that returns the course of a value in a run; it never decreases."""

    def __call__(self, run: ComparedRun) -> SampledCurve:
        """Return the course, or raise `LackingError`."""


def ends_in_words(runs: Sequence[ComparedRun]) -> str:
    """Return the end times of runs: ``a at 70 µs, b at 1 ms``; of many runs the earliest and the
    latest.
    """
    names: dict[str, list[str]] = {}
    for run in sorted(runs, key=end_of) if len(runs) > _MOST_LISTED else runs:
        names.setdefault(quantity_in(end_of(run), "s"), []).append(run.name)
    if len(runs) <= _MOST_LISTED:
        return ", ".join(f"{names_in_words(of_end)} at {end}" for end, of_end in names.items())
    texts = [f"{end} ({_few(of_end)})" for end, of_end in names.items()]
    return f"from {texts[0]} to {texts[-1]}"


def _few(names: Sequence[str]) -> str:
    """Return names, or the number of many runs."""
    return f"{len(names)} runs" if len(names) > _MOST_LISTED else names_in_words(names)


def end_of(run: ComparedRun) -> float:
    """Return the time at the end of a run, s; 0 if it is unknown."""
    return run.run.number(_END) or 0.0


def have_unlike_ends(runs: Sequence[ComparedRun]) -> bool:
    """Return True for runs that end at different times."""
    ends = [end_of(run) for run in runs]
    return max(ends, default=0.0) > LATER * min(ends, default=0.0)


def differ_in_end_only(runs: Sequence[ComparedRun]) -> bool:
    """Return True for runs of one case that differ in nothing but the time at which they stop."""
    cases = [run.run for run in runs]
    if len(runs) < _LEAST_RUNS or not have_unlike_ends(runs) or not all(run.case for run in cases):
        return False
    if len({run.kind for run in cases}) > 1:
        return False
    return not any(map(changes_results, differing(cases)))


def changes_results(key: str) -> bool:
    """Return False for keys that change what is recorded, or how ranks share the work, and for the
    end time.
    """
    return not key.startswith(_NO_RESULT)


def same_case_sentence(runs: Sequence[ComparedRun]) -> str:
    """Return the sentence on runs of one case that stop at different times."""
    return (
        f"The runs have the same case and differ only in their end times ({ends_in_words(runs)})."
    )


def truncated_names(names: Sequence[str], runs: Sequence[ComparedRun]) -> set[str]:
    """Return the values that ends of runs truncate, so that too few runs can be compared, see
    `truncated_runs` and `has_few_complete`.
    """
    truncated = truncated_runs(names, runs)
    return {name for name, cut in truncated.items() if has_few_complete(name, runs, cut)}


def has_few_complete(name: str, runs: Sequence[ComparedRun], cut: Collection[ComparedRun]) -> bool:
    """Return True if the end of a run truncates a value, and the other runs that have it are fewer
    than two or fewer than half.

    Parameters
    ----------
    cut
        Runs whose end truncates the value.
    """
    complete = [run for run in runs if run not in cut and run.run.number(name) is not None]
    return bool(cut) and len(complete) < max(_LEAST_RUNS, len(cut))


def truncated_runs(
    names: Sequence[str], runs: Sequence[ComparedRun]
) -> dict[str, frozenset[ComparedRun]]:
    """Return by value the runs whose end truncates it: an end earlier than others, or an end before
    the value is known, see `definitions`; without values that no run truncates.

    A value is complete if it is final at the earliest end in every run: the longer runs hardly
    change it afterwards, and the shortest run hardly changes it in the last tenth of its time.
    With different cases, whose waves may differ in speed, it is also complete if every run has it
    by half of its own time, and in runs that ended since they had settled. Values whose course is
    not recorded count as truncated. The runs with the earliest end are left out until the value is
    complete in the others, or the others end at the same time.

    Values of the peak force on the bottom have no common end if the cases differ: each run is
    complete if its own record includes the peak, see
    `has_own_peak`; where the record does not show this, the ends decide.
    """
    is_one_case = differ_in_end_only(runs)
    unknown = frozenset(run for run in runs if not has_peak_at_bottom(run))
    remaining: dict[tuple[Any, ...], frozenset[ComparedRun]] = {}
    truncated: dict[str, frozenset[ComparedRun]] = {}
    for name in names:
        cut = unknown if _matches(name, _OF_BOTTOM) else frozenset()
        compared = tuple(run for run in runs if run not in cut and run.run.number(name) is not None)
        if not _matches(name, _INDEPENDENT):
            lossless = tuple(run for run in runs if _is_zero_at_any_end(name, run))
            key = (_courses_of(name), compared, lossless)
            if key not in remaining:
                is_of_peak = _matches(name, _PEAKS_AT_BOTTOM)
                remaining[key] = _early_runs(*key, is_one_case=is_one_case, is_of_peak=is_of_peak)
            cut |= remaining[key]
        if cut:
            truncated[name] = cut
    return truncated


def _early_runs(
    courses: Sequence[Course],
    runs: Sequence[ComparedRun],
    complete: Collection[ComparedRun],
    *,
    is_one_case: bool,
    is_of_peak: bool,
) -> frozenset[ComparedRun]:
    """Return the runs whose end is too early for a value, as of `truncated_runs`.

    Parameters
    ----------
    courses
        Courses that determine the value; empty if they are not recorded.
    runs
        Runs that have the value.
    complete
        Runs that have the value at any end.
    is_one_case
        True if all runs of the comparison have one case.
    is_of_peak
        True for values of the peak force on the bottom.
    """
    if not have_unlike_ends(runs):
        return frozenset()
    own = is_of_peak and not is_one_case
    settled = () if is_one_case else tuple(filter(_has_settled, runs))
    unsettled = [run for run in runs if run not in settled]
    doubtful = [run for run in unsettled if run not in complete]
    doubtful = [run for run in doubtful if not (own and has_own_peak(run))]
    cut: set[ComparedRun] = set()
    while doubtful and have_unlike_ends([run for run in runs if run not in cut]):
        earliest = min(end_of(run) for run in unsettled if run not in cut)
        if courses and _are_final(courses, doubtful, earliest, is_one_case=is_one_case):
            break
        first = min(map(end_of, doubtful))
        cut.update(run for run in doubtful if end_of(run) <= LATER * first)
        doubtful = [run for run in doubtful if run not in cut]
    return frozenset(cut)


def _is_zero_at_any_end(name: str, run: ComparedRun) -> bool:
    """Return True for a dissipated energy, its fraction, or an energy of rotation that is zero at
    any end of a run: its contacts cannot yield, or have no friction.
    """
    if run.run.number(name) != 0 or not run.has_spheres:
        return False
    can_yield = run.run.summary.get(_DISSIPATING, 0) is not None
    if _matches(name, _OF_PLASTIC):
        return not can_yield
    if _matches(name, (*_OF_FRICTION, _ROTATION)):
        return not _has_friction(run)
    return _matches(name, _OF_DISSIPATION) and not can_yield and not _has_friction(run)


def _has_friction(run: ComparedRun) -> bool:
    """Return True for a run with friction between spheres, at walls or in a guide."""
    case = run.run.case
    in_keys = any(bool(value) for key, value in case.items() if key.endswith(_FRICTION))
    pairs = [pair for pair in case.get(_PAIRS) or () if isinstance(pair, Mapping)]
    return in_keys or any(pair.get(_FRICTION) for pair in pairs) or not case


def _are_final(
    courses: Sequence[Course], runs: Sequence[ComparedRun], earliest: float, *, is_one_case: bool
) -> bool:
    """Return True if the courses of a value are final at the earliest end, s, or if runs of
    different cases have each course by half of their own times.
    """
    return all(
        _is_final(course, runs, earliest) or (not is_one_case and _is_early(course, runs))
        for course in courses
    )


def limited_names(names: Sequence[str], runs: Sequence[ComparedRun]) -> set[str]:
    """Return the sizes of plastic zones, and the counts of yielded spheres and contacts, if a
    boundary limits the zone of a run.
    """
    if not any(mark_of(run.run.summary) is Mark.CUT for run in runs):
        return set()
    return {name for name in names if _matches(name, _OF_SIZE)}


def unresolved_names(names: Sequence[str], runs: Sequence[ComparedRun]) -> set[str]:
    """Return the sizes of plastic zones, and the energies dissipated in them, if the mesh of a run
    does not resolve its zone.
    """
    if not any(is_unresolved(run.run.summary) for run in runs):
        return set()
    return {name for name in names if _matches(name, (*_OF_SIZE, *_OF_DISSIPATION))}


def is_zone_size(name: str) -> bool:
    """Return True for sizes of the plastic zone and counts of its parts."""
    return _matches(name, _OF_SIZE)


def is_limited_by_end(name: str) -> bool:
    """Return True for values that ends of runs may truncate although no table of results shows
    them: values of the peak force on the bottom, sizes of the plastic zone, parts of the
    dissipated energy, values at the end.
    """
    return _matches(name, (*_OF_BOTTOM, *_OF_SIZE, *_PARTS, *AT_THE_END))


def growing_names(names: Sequence[str], runs: Sequence[ComparedRun]) -> set[str]:
    """Return the values that still grow at the end of a run: impulses on the bottom, dissipated
    energies, sizes of a plastic zone, and counts of yielded contacts that grow in the last tenth
    of the run.
    """
    patterns: list[str] = []
    for run in runs:
        patterns += _growing_impulses(run)
        patterns += _growing_energies(run)
        for direction in run.run.summary.get(GROWING) or ():
            patterns += _GROWTH_ALONG.get(direction, ())
        is_cut = mark_of(run.run.summary) is Mark.CUT  # a boundary limits its counts
        if not (is_cut or _has_settled(run) or _has_all_yielded(run)):
            patterns += _COUNTS
    return {name for name in names if _matches(name, patterns)}


def _growing_energies(run: ComparedRun) -> list[str]:
    """Return the names of the energies that still grow at the end of a run, and of their fractions
    of the input; other incomplete values have their own marks.
    """
    return [name for name in incomplete_in(run.run.summary) if name.endswith((_FRACTION, _JOULES))]


def _growing_impulses(run: ComparedRun) -> list[str]:
    """Return the names of the impulses on the bottom that still grow at the end of a run; a static
    force always adds to the impulse.
    """
    record = bottom_record(run)
    if record is None:
        return []
    names = [_DYNAMIC_IMPULSE] if record.has_growing_impulse else []
    return [*names, _IMPULSE] if names or record.has_static_force else names


def _has_all_yielded(run: ComparedRun) -> bool:
    """Return True if the number of yielded contacts hardly changes in the last tenth of a run, or
    is not recorded.
    """
    try:
        return _is_final_at(_yielded(run), (1 - _LAST_PART) * end_of(run))
    except LackingError:
        return True


def _has_settled(run: ComparedRun) -> bool:
    """Return True for a run that ended by itself, since it had settled."""
    return not run.run.is_unfinished and run.run.summary.get("end_reason") == SETTLED


def _courses_of(name: str) -> tuple[Course, ...]:
    """Return the courses that determine a value; empty if there are none."""
    for patterns, courses in _COURSES:
        if _matches(name, patterns):
            return courses
    return ()


def _matches(name: str, patterns: Sequence[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def _is_final(course: Course, runs: Sequence[ComparedRun], earliest: float) -> bool:
    """Return True if a value is final in every run at the earliest end of all runs, s."""
    for run in runs:
        is_shortest = end_of(run) <= LATER * earliest
        time = (1 - _LAST_PART) * earliest if is_shortest else earliest
        try:
            curve = course(run)
        except LackingError:
            return False
        if not _is_final_at(curve, time):
            return False
    return True


def _is_early(course: Course, runs: Sequence[ComparedRun]) -> bool:
    """Return True if a value is final in every run by half of its own time."""
    try:
        return all(_is_final_at(course(run), _EARLY * end_of(run)) for run in runs)
    except LackingError:
        return False


def _is_final_at(curve: SampledCurve, time: float) -> bool:
    """Return True if the last value of a course is reached at a time."""
    if not len(curve.x):
        return False
    return bool(np.interp(time, curve.x, curve.y) >= (1 - _CHANGE) * curve.y[-1])


# ---------------------------------------------------------------------- courses


def _dissipated(run: ComparedRun) -> SampledCurve:
    return _of_energies(run, run.run.kind.ledger["dissipated"])


def _yielded(run: ComparedRun) -> SampledCurve:
    return _of_energies(run, ("contacts_yielded",))


def _of_energies(run: ComparedRun, columns: Sequence[str]) -> SampledCurve:
    """Return the sum of columns of the energy record against time, of those that the run has."""
    try:
        with h5py.File(regular(run.run.directory / RESULT_FILE), "r") as file:
            table = file["energy"]
            time = np.asarray(table["time"][()], dtype=np.float64)
            parts = [np.asarray(table[name][()]) for name in columns if name in table]
    except (OSError, KeyError, ValueError, TypeError):
        raise LackingError(f"{RESULT_FILE} has no energies") from None
    if not parts or any(part.shape != time.shape for part in parts):
        raise LackingError(f"{RESULT_FILE} lacks {', '.join(columns)}")
    return SampledCurve(time, np.sum(parts, axis=0))


def _part_of_energy(*columns: str) -> Course:
    """Return the course of columns of the energy record."""

    def course(run: ComparedRun) -> SampledCurve:
        return _of_energies(run, columns)

    return course


def _contact_peak(run: ComparedRun) -> SampledCurve:
    """Return the largest force of all contacts between spheres so far against time: s, N."""
    return _largest_of(run, ("contacts",))


def _any_peak(run: ComparedRun) -> SampledCurve:
    """Return the largest force of all contacts so far against time: s, N."""
    return _largest_of(run, ("contacts", "wall_contacts"))


def _largest_of(run: ComparedRun, tables: Sequence[str]) -> SampledCurve:
    times: list[Array] = []
    forces: list[Array] = []
    with run.opened() as result:
        for table in tables:
            if f"{table}/time_peak" in result:
                times.append(result[f"{table}/time_peak"])
                forces.append(result[f"{table}/peak_force"])
    if not times:
        raise LackingError("the times of its peak forces are not recorded")
    time = np.concatenate(times)
    force = np.concatenate(forces)
    reached = np.flatnonzero(np.isfinite(time) & (force > 0))
    order = reached[np.argsort(time[reached], kind="stable")]
    return _so_far(time[order], force[order])


def _bottom_peak(run: ComparedRun) -> SampledCurve:
    """Return the largest rise of the force on the bottom so far against time: s, N."""
    return _of_bottom(run, lambda record: record.force - record.static_force)


def _bottom_impulse(run: ComparedRun) -> SampledCurve:
    """Return the largest impulse on the bottom so far against time: s, N s."""
    return _of_bottom(run, lambda record: record.impulse)


def _of_bottom(run: ComparedRun, values: Callable[[Reached], Array]) -> SampledCurve:
    record = bottom_record(run)
    if record is None or not record.is_reached:
        raise LackingError("the wave does not reach its bottom, or the force is not recorded")
    return _so_far(record.time, values(record))


def _so_far(time: Array, values: Array) -> SampledCurve:
    """Return the largest of some values so far, from zero at time zero."""
    if not len(time):
        return SampledCurve(np.zeros(1), np.zeros(1))
    largest = np.maximum.accumulate(values)
    return SampledCurve(np.append(0.0, time), np.append(0.0, largest))


#: Courses by the patterns of the values that they determine; the first match counts.
_COURSES: tuple[tuple[tuple[str, ...], tuple[Course, ...]], ...] = (
    (("n_plastic_*", "plastic_zone_*"), (_yielded,)),
    (("n_dissipating_*", "zone_*_99_*"), (_dissipated, _yielded)),
    (("zone_*", *_OF_PLASTIC, *_OF_DISSIPATION), (_dissipated,)),
    (_OF_FRICTION, (_part_of_energy("friction"),)),
    (("viscous_fraction", "energy_dissipated_viscous_J"), (_part_of_energy("viscous"),)),
    (("holder_fraction", "energy_dissipated_holder_J"), (_part_of_energy("holder"),)),
    (("rolling_fraction", "energy_dissipated_rolling_J"), (_part_of_energy("rolling"),)),
    (("twisting_fraction", "energy_dissipated_twisting_J"), (_part_of_energy("twisting"),)),
    (("adhesion_fraction", "energy_dissipated_adhesion_J"), (_part_of_energy("adhesion"),)),
    (("absorbed_fraction", "energy_absorbed_J"), (_part_of_energy("absorbed"),)),
    (("peak_force_with_walls_N",), (_any_peak,)),
    (("peak_force_N", "peak_force_error_N", "peak_overlap_m"), (_contact_peak,)),
    ((_IMPULSE,), (_bottom_impulse,)),
    (_PEAKS_AT_BOTTOM, (_bottom_peak,)),
)  # fmt: skip
