"""Sentences on values that runs of a comparison define differently, or that a boundary or the end
of a run limits.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence

from granwave.analysis.document.model import named
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.incomplete_values import growing_values
from granwave.analysis.measures.target_record import Reached
from granwave.analysis.measures.zone_resolution import is_unresolved
from granwave.analysis.measures.zone_size import PERIODIC_SIDES, Mark, bounds_in_words, mark_of
from granwave.analysis.quantities import quantity
from granwave.analysis.reports.comparison.curves import (
    bottom_record,
    can_reach_bottom,
    static_force_at_bottom,
)
from granwave.analysis.reports.comparison.ends import GROWING
from granwave.analysis.reports.comparison.energy_inputs import have_same_input, inputs_in_words
from granwave.analysis.reports.comparison.redefined import redefinition_notes
from granwave.analysis.reports.comparison.subjects import ComparedRun
from granwave.analysis.reports.kinds import ReportRun

#: Beginnings of the names of values of the bottom, and of the plastic zone.
_OF_BOTTOM = ("wall_", "target_", "ground_", "base_", "peak_reduction")
_OF_ZONE = ("zone_", "plastic_zone_", "n_plastic_", "n_dissipating_")
_OF_DISSIPATION = (
    "dissipated_", "plastic_fraction", "friction_fraction", "viscous_fraction", "energy_dissipated",
    "absorbed_fraction", "n_plastic_", "n_dissipating_",
)  # fmt: skip
_LAW = "contact.law"
_BILINEAR = "bilinear"
_FORCE = "wall_peak_force_N"
_PEAK_FORCE = "peak_force_N"
WITH_WALLS = "peak_force_with_walls_N"
_N_WALL_CONTACTS = "n_wall_contacts"
_BOTTOM = "boundary.bottom"
_FREE = "free"
_HEIGHT = "packing_height_m"
_SAME_HEIGHT = 1.01  # largest over smallest height of packings that are equally high
_DEPTH = "zone_depth_90_m"
_DEPTHS_OF_KINDS = (
    "Depths of the plastic zone are measured from the centre of the impacted sphere in a packing, "
    "and from the loaded face in a block."
)
_FORCES_OF_KINDS = (
    "The peak contact force is the largest force between two spheres in a packing, and the force "
    "on the punch of a block, so that it has no ratio."
)
_SPHERES = "n_spheres"
_MOST_LISTED = 4  # runs that a sentence lists
#: Beginnings of sentences on values that the end of a run limits.
GROWING_ZONE = "The plastic zone still grows"
NO_ARRIVAL = "The wave does not reach the bottom"
RISING_FORCE = "The force on the bottom is largest"
LATE_PULSE = "Less than 80 % of the impact's momentum has reached the bottom"
GROWING_ENERGY = "Still growing at the end of the run"
OF_THE_END = (GROWING_ZONE, GROWING_ENERGY, NO_ARRIVAL, RISING_FORCE, LATE_PULSE)


def definition_notes(runs: Sequence[ComparedRun], names: Collection[str] = ()) -> list[str]:
    """Return sentences on values that these runs define differently.

    Parameters
    ----------
    names
        Values that are compared, which limit the subjects of the sentences; empty for all.
    """
    notes = [_inputs(runs), _static_forces(runs), *redefinition_notes(runs, names)]
    if _concerns(names, (_PEAK_FORCE,)):
        notes += [_FORCES_OF_KINDS] if _differ_in_kind(runs, _PEAK_FORCE) else []
    if _concerns(names, (WITH_WALLS,)):
        notes.append(_walls_in_some(runs))
    if _concerns(names, _OF_BOTTOM):
        notes += [_heights(runs), " ".join(_without_force(runs))]
    if _concerns(names, _OF_ZONE):
        notes.append(_yielding_of_laws(runs))
        notes += [_DEPTHS_OF_KINDS] if _differ_in_kind(runs, _DEPTH) else []
    return [note for note in notes if note]


def limit_notes(runs: Sequence[ComparedRun], names: Collection[str] = ()) -> list[str]:
    """Return sentences on values that the end of a run or a boundary limits; ``names`` as of
    `definition_notes`.
    """
    notes: list[str] = []
    if _concerns(names, _OF_BOTTOM):
        notes.append(" ".join(_limited_forces(runs, is_ranked=True)))
    if _concerns(names, _OF_DISSIPATION):
        notes += _growing_energies(runs, is_ranked=True)
    if _concerns(names, _OF_ZONE):
        parts = [*_cut_zones(runs), *_unresolved_zones(runs)]
        parts += _growing_zones(runs, is_ranked=True)
        notes.append(" ".join(parts))
    return [note for note in notes if note]


def _concerns(names: Collection[str], beginnings: tuple[str, ...]) -> bool:
    """Return True if any name, or no name at all, has one of the beginnings."""
    return not names or any(name.startswith(beginnings) for name in names)


def end_notes(runs: Sequence[ReportRun]) -> list[str]:
    """Return sentences on plastic zones and forces on the bottom that the end of a run limits."""
    numbered = [ComparedRun(run, run.label, number, number) for number, run in enumerate(runs)]
    return [
        *_growing_energies(numbered, is_ranked=False),
        *_growing_zones(numbered, is_ranked=False),
        *_limited_forces(numbered, is_ranked=False),
    ]


def _inputs(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on different inputs; empty if they are equal."""
    if have_same_input(runs):
        return ""
    first = f"Inputs differ: {inputs_in_words(runs)}. "
    if not any(run.run.number(_DEPTH) for run in runs):
        return f"{first}Forces and energies are absolute values, not relative to the input."
    return (
        f"{first}Fractions are relative to the input energy; forces, energies and sizes of the "
        "plastic zone are absolute values, so that depths of the zone are not ranked."
    )


def _heights(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on packings of different heights whose forces on the bottom are compared;
    empty if there are none.
    """
    heights = {run: run.run.number(_HEIGHT) for run in runs if run.run.number(_FORCE)}
    known = {run: height for run, height in heights.items() if height}
    if len(known) < 2 or max(known.values()) <= _SAME_HEIGHT * min(known.values()):
        return ""
    listed = _listed(list(known), lambda run: quantity_in(known[run], "m"))
    return (
        f"Packings differ in height: {listed}. Forces on the bottom and arrival times depend on it."
    )


def _static_forces(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on static forces below peak forces; empty if there are none."""
    static = {run: static_force_at_bottom(run) for run in runs}
    loaded = [run for run, force in static.items() if force]
    if not loaded:
        return ""
    listed = _listed(loaded, lambda run: quantity_in(static[run], "N"))
    return (
        "Peak forces and impulses in the tables include static forces; on the bottom, before the "
        f"impact: {listed}. Dynamic forces and impulses do not."
    )


def _yielding_of_laws(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on laws that count yielded contacts differently; empty for one law."""
    laws = {str(run.run.case.get(_LAW)) for run in runs if run.has_spheres}
    if len(laws) < 2 or _BILINEAR not in laws:
        return ""
    bilinear = [run for run in runs if run.run.case.get(_LAW) == _BILINEAR]
    return (
        "With the bilinear law every loaded contact counts as yielded: "
        f"{', '.join(run.name for run in bilinear[:_MOST_LISTED])}."
    )


def has_walls_in_some(runs: Sequence[ComparedRun]) -> bool:
    """Return True if grains touch walls, plates or bars in some of the runs, but not in all."""
    return 0 < len(_with_walls(runs)) < len([run for run in runs if run.has_spheres])


def _with_walls(runs: Sequence[ComparedRun]) -> list[ComparedRun]:
    """Return the runs in which grains touch walls, plates or bars, or may,
    since they have a bottom.
    """
    return [
        run
        for run in runs
        if run.has_spheres
        and (run.run.number(_N_WALL_CONTACTS) != 0 or run.run.number(_FORCE) is not None)
    ]


def _walls_in_some(runs: Sequence[ComparedRun]) -> str:
    """Return a sentence on runs without walls next to runs with walls; empty if there are none."""
    if not has_walls_in_some(runs):
        return ""
    with_walls = _with_walls(runs)
    without = [run for run in runs if run.has_spheres and run not in with_walls]
    return (
        "The peak contact force including walls is the largest force between grains where no grain "
        f"touches a wall, so that it has no ratio: {_named(without)}."
    )


def _differ_in_kind(runs: Sequence[ComparedRun], name: str) -> bool:
    """Return True if both packings and blocks have a value."""
    return len({run.has_spheres for run in runs if run.run.number(name)}) > 1


def _cut_zones(runs: Sequence[ComparedRun]) -> list[str]:
    """Return a sentence on plastic zones that a boundary limits; nothing if there are none."""
    cut = [run for run in runs if mark_of(run.run.summary) is Mark.CUT]
    if not cut:
        return []
    listed = _listed(cut, lambda run: _joined(run, "zone_cut"))
    return [
        f"The plastic zone reaches a boundary, which limits its size: {listed}. The depths of "
        "these zones are not ranked, and their sizes and counts have no ratio."
    ]


def _unresolved_zones(runs: Sequence[ComparedRun]) -> list[str]:
    """Return a sentence on plastic zones of too few parts; nothing if there are none."""
    names = [run.name for run in runs if is_unresolved(run.run.summary)]
    if not names:
        return []
    return [
        f"The plastic zone of {named(names, _MOST_LISTED)} is not resolved, so that its size and "
        "the dissipated energy have no ratio."
    ]


def _growing_energies(runs: Sequence[ComparedRun], *, is_ranked: bool) -> list[str]:
    """Return a sentence on dissipated energies, numbers of yielded contacts and impulses that still
    grow at the end of a run, with the remedy; nothing if there are none. ``is_ranked`` as of
    `_growing_zones`.
    """
    labels = {run: _labels_of_growing(run) for run in runs}
    growing = [run for run in runs if labels[run]]
    if not growing:
        return []
    listed = _listed(growing, lambda run: labels[run])
    more = " Values that still grow have no ratio." if is_ranked else ""
    return [f"{GROWING_ENERGY}: {listed}.{more} Increase run.end_time for final values."]


def _labels_of_growing(run: ComparedRun) -> str:
    """Return the labels of the values that still grow at the end of a run."""
    labels = [quantity(name).label for name in growing_values(run.run.summary)]
    *first, last = [f"{label[:1].lower()}{label[1:]}" for label in labels] or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _growing_zones(runs: Sequence[ComparedRun], *, is_ranked: bool) -> list[str]:
    """Return a sentence on plastic zones that the end of a run limits; nothing if there are none.

    Parameters
    ----------
    is_ranked
        True in a comparison, which ranks runs by the depth of the zone.
    """
    growing = [run for run in runs if run.run.summary.get(GROWING)]
    if not growing:
        return []
    listed = _listed(growing, lambda run: _joined(run, GROWING))
    more = " Sizes that still grow are not ranked and have no ratio." if is_ranked else ""
    return [f"{GROWING_ZONE} at the end of the run: {listed}.{more}"]


def _limited_forces(runs: Sequence[ComparedRun], *, is_ranked: bool) -> list[str]:
    """Return sentences on forces on the bottom that do not reach their peak within a run.

    Parameters
    ----------
    is_ranked
        True in a comparison, which ranks runs by these forces.
    """
    unloaded: list[ComparedRun] = []
    rising: list[ComparedRun] = []
    late: dict[ComparedRun, Reached] = {}
    for run in runs:
        record = bottom_record(run)
        if record is None:
            continue
        if not record.is_reached:
            if can_reach_bottom(run):
                unloaded.append(run)
        elif record.rises_at_end:
            rising.append(run)
        elif record.awaits_momentum:
            late[run] = record
    notes = [_late_pulses(late, is_ranked=is_ranked)] if late else []
    if unloaded:
        listed = _listed(unloaded, _end)
        notes.append(f"{NO_ARRIVAL} before the end of the run: {listed}.")
    if rising:
        listed = _listed(rising, _end)
        unranked = "such forces are not ranked, and " if is_ranked else ""
        unknown = f"{unranked}the arrival of the wave is not known"
        notes.append(
            f"{RISING_FORCE} at the end of the run, and may rise further: {listed}. "
            f"{unknown[0].upper()}{unknown[1:]}."
        )
    return notes


def _late_pulses(records: Mapping[ComparedRun, Reached], *, is_ranked: bool) -> str:
    """Return a sentence on runs after whose end a larger force on the bottom may follow."""
    listed = _listed(list(records), lambda run: records[run].arrived_in_words)
    more = " Forces on the bottom of these runs are not ranked." if is_ranked else ""
    return (
        f"{LATE_PULSE} by the end of the run, so that a later pulse may be larger: {listed}.{more}"
    )


def _without_force(runs: Sequence[ComparedRun]) -> list[str]:
    """Return sentences on runs that cannot be ranked by the force below a packing, next to runs
    that can.
    """
    single = [run for run in runs if run.run.number(_SPHERES) == 1]
    packings = [run for run in runs if run not in single]
    missing = [run for run in packings if run.run.number(_FORCE) is None]
    if len(missing) == len(packings):
        return []
    notes: list[str] = []
    if single:
        names = _named(single)
        notes.append(f"Not ranked, since a single sphere is the impact without a packing: {names}.")
    free = [run for run in missing if run.run.case.get(_BOTTOM) == _FREE]
    if free:
        names = _named(free)
        notes.append(f"Not ranked by the force on the bottom, since there is no bottom: {names}.")
    unrecorded = [run for run in missing if run not in free]
    if unrecorded:
        names = _named(unrecorded)
        notes.append(f"Not ranked by the force on the bottom, which is not recorded: {names}.")
    return notes


def _end(run: ComparedRun) -> str:
    """Return the time at the end of a run, in words."""
    return f"at {quantity_in(run.run.number('end_time_s') or 0.0, 's')}"


def _joined(run: ComparedRun, name: str) -> str:
    """Return a list of names in the summary of a run, in words."""
    summary = run.run.summary
    words = bounds_in_words(summary[name], periodic=summary.get(PERIODIC_SIDES))
    return words.replace(", ", " and ")


def _listed(runs: Sequence[ComparedRun], text: Callable[[ComparedRun], str]) -> str:
    """Return texts with the runs that have them, each text once; of many texts the first ones, and
    of many runs with one text the first names.
    """
    names: dict[str, list[str]] = {}
    for run in runs:
        names.setdefault(text(run), []).append(run.name)
    parts = [f"{what} in {named(of_text, _MOST_LISTED)}" for what, of_text in names.items()]
    is_simple = len(parts) == len(runs)
    return _first(parts, ", " if is_simple else "; ")


def _named(runs: Sequence[ComparedRun]) -> str:
    """Return the names of runs; for many runs, the first ones and the number of the others."""
    return named([run.name for run in runs], _MOST_LISTED)


def _first(parts: Sequence[str], between: str = ", ") -> str:
    left = len(parts) - _MOST_LISTED
    more = f" and {left} more" if left > 0 else ""
    return f"{between.join(parts[:_MOST_LISTED])}{more}"
