"""Section of results: runs side by side, tables of runs and of the points of scans, failures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, product
from pathlib import Path
from typing import Any

from granwave.analysis.document.model import (
    BLANK,
    Block,
    Cell,
    DocumentSection,
    DocumentTable,
    Group,
    Note,
    Part,
    TableColumn,
    Tone,
    case_column,
    cell_in_unit,
    column_table,
    in_unit,
    is_number,
    label_of,
    meaning_in,
    meanings,
    percent,
    spread_cell,
    unit_of_value,
    units_of_values,
    value_cell,
    value_column,
)
from granwave.analysis.formatting.numbers import column_unit
from granwave.analysis.formatting.values import grains_called_in, unique_labels, unit_in_cases
from granwave.analysis.measures.incomplete_values import incomplete_in
from granwave.analysis.measures.law_range import BEYOND_LAW_MEANING, is_beyond_law
from granwave.analysis.measures.zone_size import PERIODIC_SIDES, Mark, bounds_in_words, mark_of
from granwave.analysis.quantities import FRICTION_SHARES, SIZES_BY_LAYERS, report_columns
from granwave.analysis.reports.comparison.compared_value import MARK, footnotes_of_marks, marked
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.inputs import ReportInputs, ReportScan
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.reports.sentences import by_part, value_table
from granwave.analysis.reports.setting import differing, is_chain, target_of
from granwave.analysis.scans.table import (
    CONFIDENCE,
    COUNT,
    MEAN,
    SCAN_MEANS,
    SCAN_TABLE,
    SEED,
    scan_statistics,
)
from granwave.analysis.summary_table import has_no_pairs
from granwave.lammps_inputs.case.contact.contact import ALL_LAWS, LINE

Columns = list[tuple[TableColumn, list[Cell]]]

SLUG = "results"
MOST_SIDE_BY_SIDE = 6
MOST_OPEN = 12  # most points of a scan whose table is not folded
MOST_ROWS = 14  # most values of one run in the first section
_LONGEST = 600  # most characters of a reason
_ROUNDING = 1e-9  # relative difference of equal values
_TIMES = 10.0  # relative difference from which on it is given as a ratio
_NEARLY_NOTHING = -0.995  # relative difference that would read -100 %
_SETTINGS = ("energy_balance_accepted",)  # values of a summary that are no results
_STATUS = "Status"
_NUMBER = TableColumn("#", numeric=True, key=True)
_OF_COST = ("n_spheres", "n_elements", "end_time_s", "wall_time_s")  # values that are no results
_OF_YIELDING = (
    "plastic_fraction",
    "n_plastic_contacts",
    "n_dissipating_contacts",
    "n_plastic_spheres",
)
#: Values that the first section leaves to the section of all values.
_IN_DETAIL = ("n_dissipating_contacts",)
_FIRST = (
    "transmission",
    "driven_velocity_m_s",
    "unsteady_part",
    "plate_velocity_m_s",
    "plate_peak_force_N",
)
_NOTHING = (
    "zone_cut",
    "wave_return_share",
    "plastic_zone_radius_m",
    "zone_radius_90_m",
)  # values that are omitted where they are zero
_OF_BOTTOM = (
    "wall_peak_force_N", "wall_dynamic_peak_force_N", "wall_impulse_Ns",
    "wall_dynamic_impulse_Ns", "base_arrival_s",
    "ground_peak_force_N", "target_peak_displacement_m",
    "energy_target_J", "peak_reduction", "unprotected_peak_force_N",
)  # fmt: skip
_OF_A_TARGET = (
    "wall_peak_force_N", "unprotected_peak_force_N", "peak_reduction", "wall_impulse_Ns",
    "wall_dynamic_impulse_Ns", "ground_peak_force_N",
    "unprotected_ground_peak_force_N", "target_peak_displacement_m",
)  # fmt: skip
#: Values of contacts between spheres, and relative to the load on the bare target.
_OF_PACKINGS = {
    "peak_force_N", "peak_overlap_m", "n_plastic_contacts", "n_dissipating_contacts", "n_plastic_spheres",
    "plastic_zone_volume_m3", "plastic_zone_depth_m", "plastic_zone_radius_m", "peak_reduction",
    "unprotected_peak_force_N",
}  # fmt: skip
_OF_STRUCK = ("impactor_velocity_m_s",)
_OF_GROUND = ("ground_peak_force_N", "energy_target_J")
#: Values relative to the load on the bare target, which have no meaning where it oscillates.
_OF_TARGETS = (
    "peak_reduction",
    "unprotected_peak_force_N",
    "energy_target_J",
    "ground_peak_force_N",
    "base_arrival_s",
)
_TONES: Mapping[str, Tone] = {"done": "good", "failed": "bad", "refused": "bad", "missing": "note",
    "interrupted": "bad", "running": "note",
}  # fmt: skip
_NOT_COMPARED = ("name", "kind", "versions", PERIODIC_SIDES)
_OF_ZONE = (
    "plastic_zone",
    "zone_",
    "wave_return",
)  # keys whose values are marked where the zone reaches a boundary
#: Reasons for the colour of a doubtful value.
_COLOURED = "Coloured values"
_DOUBT_OF_LAW = f"Values {BEYOND_LAW_MEANING}."
_DOUBTS_OF_ZONE = {
    Mark.CUT: "The plastic zone reaches a boundary, which limits its size.",
    Mark.WAVE: "Part of the plastic dissipation occurred after a reflection could return.",
}
_MEANINGS_OF_COLOUR = (_DOUBT_OF_LAW, *_DOUBTS_OF_ZONE.values())


def results_section(inputs: ReportInputs, comparison: Comparison | None = None) -> DocumentSection:
    """Make the section of all values: of runs side by side, and of the points of scans, folded
    away.

    Parameters
    ----------
    comparison
        Comparison of the runs, if there are several.
    """
    blocks: list[Block] = []
    runs = [run for run in inputs.runs if run.has_balance]
    if len(runs) > 1:
        blocks.append(
            _runs_table(runs, differing(runs), _worth_showing([run.summary for run in runs]))
        )
    for alike in (runs, *by_part(inputs.runs)):
        if alike and len(alike) <= MOST_SIDE_BY_SIDE:
            blocks += _side_by_side(alike, comparison if alike is runs else None)
    for scan in inputs.scans:
        parts = _scan_blocks(scan, inputs)
        folded = len(scan.points) > MOST_OPEN
        blocks += (
            [Group(f"Points of scan {scan.label}", tuple(parts), folded=True)] if folded else parts
        )
    blocks += meanings([run.summary for run in inputs.results()])
    return DocumentSection("All values", SLUG, tuple(blocks))


def value_rows(run: ReportRun) -> DocumentTable:
    """Make a table of the main values of a run, a row each."""
    if not run.has_balance:
        return value_table([run], f"Run {run.label}")
    summary = run.summary
    driven = run.number("transmission") is not None
    plate, bottom, ground = map(
        run.number, ("plate_velocity_m_s", "wall_peak_force_N", "ground_peak_force_N")
    )
    first = [*_FIRST, *(_OF_A_TARGET if target_of(run.case) and not driven else ())]
    if is_chain(run.case):
        first.append("wave_speed_m_s")
    first = [key for key in first if run.number(key) is not None]
    left_out = {*_OF_COST, *first, *(key for key in _NOTHING if not summary.get(key))}
    left_out |= _beside_others([summary])
    if has_no_pairs(summary):
        left_out |= _OF_PACKINGS
    for told, keys in (
        (_yields(run), _OF_YIELDING),
        (plate is None and not driven, _OF_STRUCK),
        (not driven, _OF_TARGETS),
        (bottom, _OF_BOTTOM),
        (ground != bottom, _OF_GROUND),  # otherwise the bottom is at rest
    ):
        left_out |= set() if told else set(keys)
    called = grains_called_in([summary])
    rows = []
    shown = [*first, *(key for key in _worth_showing([summary]) if key not in left_out)]
    units = units_of_values(shown[:MOST_ROWS], [summary])
    for key, (unit, size) in units.items():
        label = label_of(key, called)
        name = Cell(label, label, meaning=meaning_in(key, called))
        rows.append((name, _result_cell(key, summary, size), Cell(unit)))
    columns = (
        TableColumn("Quantity", key=True),
        TableColumn("Value", numeric=True),
        TableColumn("Unit"),
    )
    return DocumentTable(
        f"Run {run.label}",
        columns,
        tuple(rows),
        captioned=False,
        by_row=True,
        footnotes=_footnotes(rows),
    )


def _beside_others(summaries: Sequence[Mapping[str, Any]]) -> set[str]:
    """Return the keys of redundant values, which the first section omits."""
    left_out = set(_IN_DETAIL)
    for by_layers, between in SIZES_BY_LAYERS.items():
        if all(summary.get(between) is not None for summary in summaries):
            left_out.add(by_layers)
    if not any(summary.get("dissipated_fraction") for summary in summaries):
        left_out |= {"dissipated_fraction", "n_dissipating_spheres"}
    if all(_no_force_at_walls(summary) for summary in summaries):
        left_out.add("peak_force_with_walls_N")
    return left_out


def _no_force_at_walls(summary: Mapping[str, Any]) -> bool:
    """Return True if no contact with a wall carried more than the contacts between spheres."""
    every = summary.get("peak_force_with_walls_N")
    return every is None or every == summary.get("peak_force_N")


def _yields(run: ReportRun) -> bool:
    """Return False if no contact of a run can yield, so that zeros are not meaningful."""
    if run.summary.get("plastic_zone_volume_m3", 0.0) is None:
        return False
    law = run.case.get("contact.law")
    return (law not in ALL_LAWS or bool(ALL_LAWS[law].yields)) and law != LINE


def _state_of(run: ReportRun) -> str:
    """Return the status of a run; of an unfinished run its state."""
    return str(run.record["state"]) if run.is_unfinished else run.status


def status_cell(status: str) -> Cell:
    """Return the cell of a status."""
    return Cell(status, status, _TONES.get(status, ""))


def _runs_table(
    runs: Sequence[ReportRun], keys: Sequence[str], shown: Sequence[str]
) -> DocumentTable:
    cases = [run.case for run in runs]
    names = TableColumn("Run", key=True), [Cell(run.label, run.label) for run in runs]
    results = _results([(_state_of(run), run.summary) for run in runs], shown)
    columns = [names, *_settings(keys, cases, cases), *results]
    return column_table("Runs", columns, sortable=True, footnotes=_footnotes_of(columns))


def _scan_blocks(scan: ReportScan, inputs: ReportInputs) -> list[Part]:
    found = [point.result for point in scan.points]
    numbers = [
        Cell(
            str(one.number),
            one.number,
            link=inputs.link(one.directory, str(one.number)) if one.directory else None,
        )
        for one in found
    ]
    results = [
        (point.run.status, point.run.summary) if point.run else (point.result.status, {})
        for point in scan.points
    ]
    columns = [
        (_NUMBER, numbers),
        *_settings(scan.source.varied, [one.labels for one in found], _cases(scan)),
        *_results(results, _worth_showing([summary for _, summary in results])),
    ]
    caption = f"Scan {scan.label}"
    footnotes = _footnotes_of(columns)
    blocks: list[Part] = [column_table(caption, columns, sortable=True, footnotes=footnotes)]
    if SEED in scan.source.varied and all(isinstance(one.summary, dict) for one in found):
        blocks += _replicates(scan)
    files = [scan.directory / name for name in (SCAN_TABLE, SCAN_MEANS)]
    if links := tuple(inputs.link(path) for path in files if path.is_file()):
        blocks.append(Note(f"All values of scan {scan.label}:", links=links))
    return blocks


def _cases(scan: ReportScan) -> list[Mapping[str, Any]]:
    """Return the cases of the finished points, by dotted key."""
    return [point.run.case for point in scan.points if point.run]


def _settings(
    keys: Iterable[str], rows: Sequence[Mapping[str, Any]], cases: Sequence[Mapping[str, Any]]
) -> Columns:
    """Return columns of keys of the case; tables are given by their labels, and an empty value is
    none.

    Parameters
    ----------
    rows
        Values by dotted key.
    cases
        Cases by dotted key, from which units follow.
    """
    columns: Columns = []
    for key in keys:
        values = [None if row.get(key, "") == "" else row[key] for row in rows]
        numbers = [is_number(value) or value is None for value in values]
        shown = zip(values, unique_labels(values), numbers, strict=True)
        cells = [
            value_cell(one) if number or one == text else Cell(text, text)
            for one, text, number in shown
        ]
        columns.append((case_column(key, unit_in_cases(key, cases), numeric=all(numbers)), cells))
    return columns


def _results(results: Sequence[tuple[str, Mapping[str, Any]]], shown: Iterable[str]) -> Columns:
    """Return columns of the status and of values, of the status and the summary of each row."""
    called = grains_called_in(summary for _, summary in results)
    columns: Columns = [(TableColumn(_STATUS), [status_cell(status) for status, _ in results])]
    summaries = [summary for _, summary in results]
    for key, (unit, size) in units_of_values(shown, summaries).items():
        cells = [_result_cell(key, summary, size) for summary in summaries]
        columns.append((value_column(key, called, unit), cells))
    return columns


def _worth_showing(summaries: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the main values that any summary has; fractions of yielding and friction only with
    friction or losses.
    """
    shares = "friction_fraction", "viscous_fraction"
    several = any(summary.get(share) for summary, share in product(summaries, shares))
    left_out = () if several else FRICTION_SHARES
    there = (
        key
        for key in report_columns()
        if any(summary.get(key) is not None for summary in summaries)
    )
    return [key for key in there if key not in left_out]


def _result_cell(key: str, summary: Mapping[str, Any], size: float = 1.0) -> Cell:
    """Return the cell of a value of a summary in a unit of a size, marked if it is doubtful, or if
    the end of the run truncates it; a list holds names of boundaries.
    """
    if not summary:
        return Cell("")
    value = summary.get(key)
    reason = _doubt(key, summary)
    if isinstance(value, list):
        value = bounds_in_words(value, periodic=summary.get(PERIODIC_SIDES))
    cell = cell_in_unit(value, size, tone="note" if reason else "", meaning=reason)
    return marked(cell, is_marked=key in incomplete_in(summary))


def _doubt(key: str, summary: Mapping[str, Any]) -> str:
    """Return the reason for which a value of a summary is doubtful; empty for other values."""
    value = summary.get(key)
    is_count = key == "contacts_beyond_law" and isinstance(value, (int, float)) and value > 0
    if is_count or is_beyond_law(key, summary):
        return _DOUBT_OF_LAW
    if key.startswith(_OF_ZONE) and value is not None:
        return _DOUBTS_OF_ZONE.get(mark_of(summary), "")
    return ""


def _side_by_side(runs: Sequence[ReportRun], comparison: Comparison | None) -> list[Block]:
    """Make a table of all values of the summaries, with a column for each run, and the difference
    of two runs; with marks of the values that the end of their run truncates, and a footnote on
    them.

    Parameters
    ----------
    comparison
        Comparison of these runs, which limits the differences; None without one.
    """
    pair = len(runs) == 2
    without_ratio = {} if comparison is None else comparison.without_ratio
    truncated = {} if comparison is None or pair else comparison.truncated
    names = dict.fromkeys(chain.from_iterable(run.summary for run in runs))
    keys = [key for key in names if key not in _NOT_COMPARED]
    numbers = [*(run.label for run in runs), *["Difference"] * pair]
    columns = [
        TableColumn("Quantity", key=True),
        TableColumn("Unit", key=True),
        *(TableColumn(one, numeric=True) for one in numbers),
    ]
    rows = []
    called = grains_called_in([run.summary for run in runs])
    for key, (unit, size) in units_of_values(keys, [run.summary for run in runs]).items():
        cut = [one.run for one in truncated.get(key, ())]
        cells = [_cell_among(run, cut, _result_cell(key, run.summary, size)) for run in runs]
        label = runs[0].kind.label(runs[0], key) or label_of(key, called)
        row = [
            Cell(label, label, meaning=meaning_in(key, called)),
            Cell(unit),
            *cells,
        ]
        if pair:
            row.append(_difference_of(key, runs, without_ratio.get(key, "")))
        rows.append(tuple(row))
    caption = "Values side by side" if len(runs) > 1 else f"Run {runs[0].label}"
    footnotes = _footnotes(rows)
    return [DocumentTable(caption, tuple(columns), tuple(rows), by_row=True, footnotes=footnotes)]


def _cell_among(run: ReportRun, truncated: Sequence[ReportRun], cell: Cell) -> Cell:
    """Return the cell of a value of a run, marked if the run is one of those that truncate it."""
    is_marked = any(run is other for other in truncated)
    return marked(cell, is_marked=is_marked and not cell.text.endswith(MARK))


def _footnotes(rows: Iterable[Sequence[Cell]]) -> tuple[str, ...]:
    """Return the meanings of the mark of truncated values, and of coloured values, if any cell has
    them.
    """
    cells = list(chain.from_iterable(rows))
    notes = [*footnotes_of_marks([cells])]
    given = " ".join(dict.fromkeys(cell.meaning for cell in cells))
    reasons = [f"{text[0].lower()}{text[1:-1]}" for text in _MEANINGS_OF_COLOUR if text in given]
    if reasons:
        notes.append(f"{_COLOURED}: {'; '.join(reasons)}.")
    return tuple(notes)


def _footnotes_of(columns: Columns) -> tuple[str, ...]:
    """Return the footnotes of a table from its columns."""
    return _footnotes([cells for _, cells in columns])


def _difference_of(key: str, runs: Sequence[ReportRun], without_ratio: str) -> Cell:
    """Return the cell of the difference of a value of two runs, or the reason for which it has
    none; empty if a run lacks the value, and for settings.
    """
    first, second = [run.summary.get(key) for run in runs]
    if first is None or second is None or key in _SETTINGS:
        return Cell("")
    return Cell(without_ratio) if without_ratio else _difference(first, second)


def _difference(first: Any, second: Any) -> Cell:
    if (
        not is_number(first)
        or not is_number(second)
        or not first
        or first != first
        or second != second
    ):
        return Cell("")
    change = second / first - 1
    value = 0.0 if abs(change) < _ROUNDING else 100 * change
    if change >= _TIMES:
        return Cell(f"{second / first:.3g} times", value)
    if second and change < _NEARLY_NOTHING:
        return Cell(f"{second / first:.2g} times", value)
    return Cell(percent(value), value)


def _replicates(scan: ReportScan) -> list[DocumentTable]:
    """Make a table of means over the seeds with confidence intervals, for points that are otherwise
    equal.
    """
    found = scan_statistics(scan.source)
    rows = [dict(zip(found, values, strict=True)) for values in zip(*found.values(), strict=True)]
    if not any(row[COUNT] > 1 for row in rows):
        return []
    columns = _settings([key for key in scan.source.varied if key != SEED], rows, _cases(scan))
    columns.append(
        (TableColumn("Replicates", numeric=True), [value_cell(row[COUNT]) for row in rows])
    )
    for key in _worth_showing(
        [{key: row.get(key + MEAN) for key in report_columns()} for row in rows]
    ):
        unit, size = column_unit(unit_of_value(key), [row[key + MEAN] for row in rows])
        means = [in_unit(row[key + MEAN], size) for row in rows]
        widths = [in_unit(row[key + CONFIDENCE], size) for row in rows]
        cells = [spread_cell(*ends) for ends in zip(means, widths, strict=True)]
        columns.append((value_column(key, unit=unit), cells))
    return [
        column_table(
            f"Scan {scan.label}: mean and 95 % confidence interval", columns, sortable=True
        )
    ]


def failures_section(inputs: ReportInputs) -> DocumentSection:
    """Make the section of points that failed or are missing, with reasons."""
    blocks: list[Block] = []
    for scan in inputs.scans:
        if points := [point for point in scan.points if point.run is None]:
            found = [point.result for point in points]
            columns = [
                (_NUMBER, [value_cell(one.number) for one in found]),
                *_settings(scan.source.varied, [one.labels for one in found], ()),
                (TableColumn(_STATUS), [status_cell(one.status) for one in found]),
                (
                    TableColumn("Attempts", numeric=True),
                    [value_cell(one.attempts) for one in found],
                ),
                (TableColumn("Why"), [Cell(_short(point.reason)) for point in points]),
                (TableColumn("Directory"), [_where(one.directory, inputs) for one in found]),
            ]
            blocks.append(column_table(f"Scan {scan.label}: points that are not done", columns))
    for run in inputs.runs:
        if run.status != "done":
            reason = run.record.get("reason") or "energy balance error too large"
            blocks.append(Note(f"Run {run.label} was {run.status}: {_short(str(reason))}", "bad"))
    return DocumentSection("Failed and missing", "failures", tuple(blocks))


def _where(directory: Path | None, inputs: ReportInputs) -> Cell:
    """Return the cell of the log of a point, or of its directory."""
    if directory is None:
        return Cell(BLANK)
    log = directory / "point.log"
    target = log if log.is_file() else directory
    return Cell(inputs.path(target), link=inputs.link(target))


def _short(text: str) -> str:
    text = text.strip()
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
