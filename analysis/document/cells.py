"""Names, units and number formats of what stands in a summary or a case."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from granwave.analysis.document.model import Cell, Column, Group, Table
from granwave.analysis.formatting.numbers import interval, plain
from granwave.analysis.formatting.units import shown_unit
from granwave.analysis.formatting.values import as_label
from granwave.analysis.measures.zone_size import SHARES

BLANK = "\u2013"  # a value that does not apply
_DIGITS = 5
_UNITS = {
    "_m_s2": "m/s²", "_m_s": "m/s", "_per_kg": "1/kg", "_per_m": "1/m", "_per_s": "1/s", "_kg": "kg", "_m3": "m³",
    "_Ns": "N s", "_J": "J", "_N": "N", "_s": "s", "_m": "m",
}  # fmt: skip

_ZONE_UNITS = {"depth": "m", "radius": "m", "volume": "m3"}

#: Columns of a table of results, in this order, as far as there are values.
MAIN = (
    "dissipated_fraction",
    "plastic_fraction",
    "friction_fraction",
    "peak_force_N",
    "n_plastic_contacts",
    "n_plastic_spheres",
    "plastic_zone_volume_m3",
    "plastic_zone_volume_ever_m3",
    "plastic_zone_depth_m",
    "plastic_zone_radius_m",
    *(f"zone_{size}_90_{unit}" for size, unit in _ZONE_UNITS.items()),
    "zone_cut",
    "wave_return_share",
    "wall_peak_force_N",
    "wall_impulse_Ns",
    "base_arrival_s",
    "unprotected_peak_force_N",
    "peak_reduction",
    "ground_peak_force_N",
    "target_peak_displacement_m",
    "energy_target_J",
    "impactor_velocity_m_s",
    "wave_speed_m_s",
    "energy_input_J",
    "energy_input_normalised",
    "velocity_normalised",
    "contacts_beyond_law",
    "energy_balance_error",
    "n_spheres",
    "n_elements",
    "end_time_s",
    "wall_time_s",
)

_LABELS = {
    "n_spheres": "Spheres",
    "n_contacts": "Contacts at the start",
    "n_loaded_contacts": "Contacts that bore a force",
    "n_elements": "Elements",
    "n_steps": "Steps",
    "n_ranks": "MPI ranks",
    "n_plastic_contacts": "Yielded contacts",
    "n_plastic_spheres": "Yielded spheres",
    "n_wall_contacts": "Wall contacts",
    "peak_force_N": "Peak contact force",
    "wall_peak_force_N": "Peak force on the bottom",
    "wall_impulse_Ns": "Impulse on the bottom",
    "impactor_velocity_m_s": "Struck sphere at the end",
    "energy_input_J": "Energy input",
    "energy_kinetic_J": "Kinetic energy",
    "energy_elastic_J": "Elastic energy",
    "energy_dissipated_J": "Dissipated energy",
    "energy_dissipated_wall_J": "Dissipated at walls",
    "energy_dissipated_plastic_J": "Dissipated by yielding",
    "energy_dissipated_friction_J": "Dissipated by friction",
    "energy_rotational_J": "Kinetic energy of rotation",
    "plastic_fraction": "Share dissipated by yielding",
    "friction_fraction": "Share dissipated by friction",
    "energy_stored_J": "Energy stored by precompression",
    "precompression_residual": "Residual of the static stage",
    "base_arrival_s": "Arrival at the bottom",
    "energy_target_J": "Work on the target",
    "support_energy_J": "Energy in the support",
    "support_lost_J": "Energy that the support's damper took",
    "ground_peak_force_N": "Peak force on the ground",
    "target_peak_displacement_m": "Largest displacement of the target",
    "unprotected_peak_force_N": "Peak force without the packing",
    "unprotected_ground_peak_force_N": "Peak force on the ground without the packing",
    "peak_reduction": "Peak reduction",
    "ground_peak_reduction": "Peak reduction on the ground",
    "peak_reduction_per_kg": "Peak reduction per mass of packing",
    "peak_reduction_per_m": "Peak reduction per height of packing",
    "packing_mass_kg": "Mass of the packing",
    "packing_height_m": "Height of the packing",
    "energy_punch_J": "Energy of the punch",
    "energy_viscous_J": "Viscous energy",
    "energy_hourglass_J": "Hourglass energy",
    "energy_input_normalised": "Energy input, normalised",
    "velocity_normalised": "Velocity, normalised",
    "plastic_zone_volume_ever_m3": "Volume that ever yielded",
    "plastic_zone_depth_m": "Outermost yield, depth",
    "plastic_zone_radius_m": "Outermost yield, radius",
    **{
        f"zone_{size}_{percent}_{unit}": f"Zone of {percent} %, {size}"
        for size, unit in _ZONE_UNITS.items()
        for percent in SHARES
    },
    "zone_cut": "Bounds that the zone reaches",
    "zone_growing": "Outermost yield that still moved out at the end",
    "wave_returned": "Bounds whose waves came back",
    "wave_return_s": "Earliest return of a wave",
    "wave_return_share": "Share dissipated after that",
    "contacts_beyond_law": "Contacts beyond the law",
    "contacts_beyond_half_law": "Contacts beyond half the law",
    "energy_balance_error": "Balance error",
    "wall_time_s": "Wall time",
    "yield_force_N": "Force at first yield",
    "yield_overlap_m": "Overlap at first yield",
}

#: What values of a granular run mean, as far as their names do not tell.
MEANINGS = {
    "n_contacts": "Pairs of spheres that touch before the run; smaller spheres on the sites of a lattice leave gaps.",
    "n_loaded_contacts": "Pairs of spheres that bore a force at any time of the run.",
    "plastic_fraction": "Energy dissipated by yielding of contacts in this run, over the input.",
    "friction_fraction": "Energy dissipated by sliding between spheres and at walls, over the input.",
    "energy_rotational_J": "Part of the kinetic energy.",
    "n_plastic_contacts": "Contacts that yielded in this run; a dent from before it counts only if it grew.",
    "plastic_zone_volume_m3": "Of all spheres that yielded; in the continuum the largest volume at yield at one "
    "instant. Not to be compared with each other.",
    "plastic_zone_depth_m": "Of the outermost sphere (element) that yielded at all, however little it dissipated.",
    "plastic_zone_radius_m": "Of the outermost sphere (element) that yielded at all, however little it dissipated.",
    "zone_depth_90_m": "Smallest depth below the struck sphere's centre (the block's face) that holds 90 % of the "
    "energy dissipated by yielding, weighed by the centres of spheres (elements), not interpolated; 50 and 99 % "
    "likewise.",
    "zone_radius_90_m": "The same of the distance from the impact axis.",
    "zone_volume_90_m3": "Volume of the fewest spheres (elements) that hold 90 % of it, those with most for their "
    "volume; without the voids between spheres.",
    "zone_cut": "A sphere (element) that yielded touches them: the outermost yield is cut there.",
    "zone_growing": "The outermost sphere in depth, or radius, yielded in the last tenth of the run.",
    "wave_returned": "A wave that they reflect can have come back, within the run, to what holds 99 %.",
    "wave_return_s": "From the first arrivals at the bound and at the zone (continuum: from the speed of compression "
    "waves).",
    "wave_return_share": "Of the energy dissipated by yielding: at most so much is owed to waves that came back.",
    "energy_stored_J": "Elastic energy in the contacts after the static stage, from which the run's energies count.",
    "precompression_residual": "Largest net force on a sphere after the static stage, over the largest contact force.",
    "base_arrival_s": "When the force on the bottom has first risen by 1 % of its largest rise.",
    "energy_target_J": "Work that the packing did on the bottom up to the end; none on a bottom that does not move.",
    "support_energy_J": "Kinetic and elastic energy of what the bottom rests on; part of the elastic energy.",
    "support_lost_J": "What its damper, or the end of a bar without an echo, took; part of the dissipated energy.",
    "ground_peak_force_N": "Out of the bottom's last spring or damper; the force on the bottom where that is at rest.",
    "unprotected_peak_force_N": "The same impact directly on the bottom, without the packing.",
    "peak_reduction": "Peak force on the bottom without the packing, over that with it (without a precompression's).",
    "ground_peak_reduction": "The same of the force on the ground.",
}


def meanings(summaries: Sequence[Mapping[str, Any]]) -> tuple[Group, ...]:
    """Meanings of the values that any of these summaries has, folded away; nothing if there are none."""
    shown = [key for key in MEANINGS if any(summary.get(key) is not None for summary in summaries)]
    if not shown:
        return ()
    title = "What these values mean"
    rows = tuple((Cell(label_of(key)), Cell(key), Cell(MEANINGS[key])) for key in shown)
    columns = (Column("Quantity", key=True), Column("In summary.json"), Column("Meaning"))
    return (Group(title, (Table(title, columns, rows, captioned=False),), folded=True),)


def label_of(key: str) -> str:
    """Name of a key of a summary for people."""
    if key in _LABELS:
        return _LABELS[key]
    suffix = next((suffix for suffix in _UNITS if key.endswith(suffix)), "")
    return readable(key.removesuffix(suffix))


def unit_of_value(key: str) -> str:
    """Unit of a key of a summary, empty where it has none."""
    return next((unit for suffix, unit in _UNITS.items() if key.endswith(suffix)), "")


def readable(name: str) -> str:
    """A file's or key's name as words."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


def value_column(key: str) -> Column:
    """Column of a value of the summary."""
    return Column(label_of(key), unit_of_value(key), numeric=True)


def case_column(key: str, *, numeric: bool) -> Column:
    """Column of a key of the case."""
    return Column(key, unit_of_key(key), numeric=numeric, key=True)


def unit_of_key(key: str) -> str:
    """Unit of a key of the case, empty where it has none."""
    return shown_unit(key)


def show(value: Any) -> str:
    """A value of a summary or a case as text; numbers with five digits."""
    if value is None:
        return BLANK
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return _float(value)
    if isinstance(value, dict) or (isinstance(value, (list, tuple)) and any(isinstance(item, dict) for item in value)):
        return as_label(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(show(item) for item in value) + "]"
    return str(value)


def named(labels: Sequence[str], most: int = 6) -> str:
    """A list of runs, cut when it is long; points of one scan are named by their numbers after the first."""
    texts, before = [], None
    for label in labels[:most]:
        scan, _, number = label.rpartition(" #")
        texts.append(f"#{number}" if scan and scan == before else label)
        before = scan
    more = f" and {len(labels) - most} more" if len(labels) > most else ""
    return ", ".join(texts) + more


def percent(value: float) -> str:
    """A difference in per cent, with its sign."""
    text = f"{value:+.2g}" if abs(value) < 1 else f"{value:+.3g}"
    return "0 %" if value == 0 else f"{plain(text)} %"


def value_cell(value: Any, **more: Any) -> Cell:
    """Cell of a value; numbers sort as such."""
    sort = value
    if isinstance(value, bool):
        sort = float(value)
    elif isinstance(value, (int, float)):
        sort = float(value) if -1e300 < value < 1e300 else None  # NaN too
    elif value is not None:
        sort = show(value)
    return Cell(show(value), sort, **more)


def spread_cell(mean: float | None, half_width: float | None) -> Cell:
    """Cell of a mean with its interval or deviation, where there is one, and no digit beyond those it tells."""
    if mean is None or not half_width or not math.isfinite(half_width):
        return value_cell(mean)
    return Cell(interval(mean, half_width), mean)


def is_number(value: Any) -> bool:
    """An integer or a float, but no truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _float(value: float) -> str:
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "infinite"
    text = f"{value:.{_DIGITS}g}"
    if 1e5 <= abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return plain(text)
