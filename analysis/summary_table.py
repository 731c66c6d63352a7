"""Main values of a run for the terminal and notebooks, and sentences on
values of ``summary.json``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.formatting.values import grains_called_in
from granwave.analysis.measures.incomplete_values import BOTTOM_PEAKS, incomplete_in
from granwave.analysis.measures.zone_size import PERIODIC_SIDES, bounds_in_words
from granwave.analysis.quantities import FRICTION_SHARES, RUN_ROWS, SHARES, Quantity, quantity
from granwave.lammps_inputs.extensions import load
from granwave.lammps_inputs.packing.cylinders import GRAINS, in_grains

_ZONE_AFTER = "plastic_zone_radius_m"  # the row that the size of the plastic zone follows
#: Values of contacts between spheres, and relative to the bare target.
_OF_PAIRS = (
    "peak_force_N",
    "n_plastic_contacts",
    "n_dissipating_contacts",
    "n_plastic_spheres",
    "plastic_zone_depth_m",
    "plastic_zone_radius_m",
    "peak_reduction",
)
_GROWING = {
    "plastic_zone_depth_m": "depth",
    "plastic_zone_radius_m": "radius",
}  # names as `zone_growing` returns them

_STILL_GROWING = ", still growing at the end"


class SummaryRow(NamedTuple):
    """A row: label (empty: the label of the row before), value as text, and the keys of
    summary.json that it shows.
    """

    label: str
    text: str
    keys: tuple[str, ...]


def lines(rows: Sequence[tuple[str, str]]) -> str:
    """Labels and values under each other."""
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in rows)


def rows_of(reference: str) -> Sequence[Quantity]:
    """Return the quantities of a reference, as in `ResultKind.rows`; by default the quantities of a
    run.
    """
    rows: Sequence[Quantity] = load(reference) if reference else RUN_ROWS
    return rows


def summary_rows(
    summary: Mapping[str, Any], shown: Sequence[Quantity] = RUN_ROWS
) -> list[SummaryRow]:
    """Return rows of the main values of a summary, as far as there are values.

    Parameters
    ----------
    shown
        Quantities of the rows.
    """
    left_out = [] if summary.get("friction_fraction") else list(FRICTION_SHARES)
    if has_no_pairs(summary):
        left_out += _OF_PAIRS
        if not summary.get("n_contacts"):
            left_out += ("n_contacts", "n_loaded_contacts")
    rows = [SummaryRow("case", str(summary["name"]), ("name",))]
    before = ""
    called = grains_called_in([summary])
    for entry in shown:
        value = None if entry.name in left_out else summary.get(entry.name)
        if value is not None:
            text = entry.text(value) + _remark(entry.name, summary)
            if entry.name == "n_cylinders" and called != GRAINS:
                continue  # all grains are
            label = entry.short if entry.name == "n_cylinders" else in_grains(entry.short, called)
            rows.append(
                SummaryRow(
                    "" if entry.short == before else label, in_grains(text, called), (entry.name,)
                )
            )
            before = entry.short
        if entry.name == _ZONE_AFTER:
            rows += _zone_rows(summary)
    return rows


def has_no_pairs(summary: Mapping[str, Any]) -> bool:
    """Return True if no contact between spheres was loaded: the impacted spheres hit the bottom
    themselves, so that a comparison with the impact without the packing has no meaning.
    """
    return summary.get("n_loaded_contacts") == 0


def _remark(name: str, summary: Mapping[str, Any]) -> str:
    """Return the words after a value: how it was determined, or what it refers to."""
    if _GROWING.get(name) in (summary.get("zone_growing") or ()):
        return _STILL_GROWING
    if name in incomplete_in(summary) and name not in BOTTOM_PEAKS:
        return _STILL_GROWING
    if name == "wall_peak_force_N" and summary.get("wall_sample_s"):
        return f", sampled every {quantity_in(summary['wall_sample_s'], 's')}"
    if name == "peak_reduction" and summary.get("wall_dynamic_peak_force_N") is not None:
        return ", of the dynamic part"
    return ""


def summary_table(summary: Mapping[str, Any], shown: Sequence[Quantity] = RUN_ROWS) -> str:
    """Return the main values of a summary as text; see `summary_rows`."""
    return lines([(row.label, row.text) for row in summary_rows(summary, shown)])


def explanation(key: str) -> str:
    """Return label, unit and meaning of a key of summary.json."""
    entry = quantity(key)
    unit = f" ({entry.unit})" if entry.unit else ""
    return f"{key}: {entry.label}{unit}" + (f". {meaning}" if (meaning := meaning_of(key)) else "")


def _zone_rows(summary: Mapping[str, Any]) -> list[SummaryRow]:
    """Size of the plastic zone, as far as it applies, and the bounds that it reaches."""
    rows = []
    label = f"{', '.join(map(str, SHARES))} % of plastic dissipation"
    for what, unit in (("depth", "m"), ("radius", "m"), ("volume", "m3")):
        keys = tuple(f"zone_{what}_{percent}_{unit}" for percent in SHARES)
        found = [f"{summary[key]:.4g}" for key in keys if summary.get(key) is not None]
        if found:
            rows.append(SummaryRow(label, f"{what} {', '.join(found)} {unit}", keys))
            label = ""
    for what in ("depth", "radius"):
        keys = tuple(f"zone_{what}_{percent}_interpolated_m" for percent in SHARES)
        found = [f"{summary[key]:.4g}" for key in keys if summary.get(key) is not None]
        if found:
            rows.append(SummaryRow(label, f"{what}, interpolated {', '.join(found)} m", keys))
            label = ""
    if summary.get("zone_cut") is not None:
        bounds = bounds_in_words(summary["zone_cut"], periodic=summary.get(PERIODIC_SIDES))
        rows.append(SummaryRow("reaches boundaries", bounds, ("zone_cut",)))
    return rows


def meaning_of(name: str) -> str:
    """Return the sentences that explain a value of a summary; empty if there are none."""
    entry = quantity(name)
    return entry.meaning or entry.note
