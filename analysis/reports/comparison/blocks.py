"""A comparison as the first section of a report: sentence, tables and figures."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from functools import partial

from granwave.analysis.document.model import (
    Block,
    Cell,
    DocumentTable,
    Figure,
    Gallery,
    Group,
    Link,
    Note,
    TableColumn,
    cell_in_unit,
    percent,
    shared_units,
    text_table,
)
from granwave.analysis.figures.style import Drawing, NotDrawn, attempt, style
from granwave.analysis.formatting.numbers import interval, quantity_in
from granwave.analysis.reports.comparison.cases import Difference
from granwave.analysis.reports.comparison.compared_value import (
    ComparedValue,
    factor,
    footnotes_of_marks,
    marked,
    marked_beyond_law,
)
from granwave.analysis.reports.comparison.comparison import Comparison
from granwave.analysis.reports.comparison.deviations import (
    NEGLIGIBLE,
    ROUNDING,
    Deviation,
    unranked_reasons,
)
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve
from granwave.analysis.reports.comparison.measured_words import relative_text
from granwave.analysis.reports.comparison.subjects import (
    MOST_SIDE_BY_SIDE,
    ComparedRun,
    names_with_cases,
)
from granwave.analysis.reports.comparison.values import shown_values
from granwave.analysis.reports.figures import picture_of

_BETWEEN_SENTENCES = r"(?<=\.) (?=[A-Z])"
_TWO_LINES = 240  # characters on two lines of a note
_MOST_VALUES = 10  # rows of the table of values
_MOST_OPEN = 12  # rows of a table of keys that is not folded
_OF_VALUES = "Largest differences of results"
_OF_ONE_RUN = "Results"
_OF_CASES = "Differences between the cases"
_OF_NUMERICS = "Differences in output and run control"
_QUANTITY = TableColumn("Quantity", key=True)
_UNIT = TableColumn("Unit", key=True)
#: Columns of the table of differences from a measured curve, after the run.
MISFIT_HEADS = (
    "rms",
    "rms / measured peak",
    "Peak in the range",
    "at",
    "Difference of the peaks",
    "Points",
)
_TIMES = 10.0  # relative difference above which it is given as a ratio
_NO_RANGE = "no common range"
#: The same for a curve that only rises.
_HEADS_WITHOUT_PEAK = ("rms", "rms / largest measured value", "Points")


def comparison_blocks(comparison: Comparison, data: Link | None = None) -> list[Block]:
    """Return the blocks of a comparison.

    Parameters
    ----------
    data
        Link to the folder with the data of the figures, where they were saved.
    """
    paragraphs = comparison.paragraphs
    leads = comparison.measured_sentences or comparison.protection or paragraphs
    blocks: list[Block] = [Note(text, "lead" if text in leads else "") for text in paragraphs]
    blocks += _note_blocks(comparison)
    blocks += misfit_tables(comparison)
    if comparison.values:
        blocks.append(value_table(comparison))
    blocks += case_tables(comparison)
    with style():
        blocks += _pictures(comparison)
    if data is not None:
        blocks.append(Note("Figures as PNG and PDF, with their data:", links=(data,)))
    return blocks


def _note_blocks(comparison: Comparison) -> list[Block]:
    """Return the notes: of each subject at most two lines, and further sentences folded."""
    blocks: list[Block] = []
    for title, notes in comparison.notes_by_subject.items():
        if not title:
            blocks += [Note(text, "note") for text in notes]
            continue
        if not notes:
            continue
        shown, rest = _first_lines(notes)
        blocks.append(Note(shown, "note"))
        if rest:
            blocks.append(Group(f"{title}: {len(rest)} more", tuple(map(Note, rest)), folded=True))
    return blocks


def _first_lines(notes: Sequence[str]) -> tuple[str, list[str]]:
    """Return the first notes on two lines, or the first sentences of a long first note, and the
    other notes.
    """
    n_notes = _n_on_two_lines(notes)
    if n_notes > 1 or len(notes[0]) <= _TWO_LINES:
        return " ".join(notes[:n_notes]), list(notes[n_notes:])
    sentences = re.split(_BETWEEN_SENTENCES, notes[0])
    n_shown = _n_on_two_lines(sentences)
    left = " ".join(sentences[n_shown:])
    return " ".join(sentences[:n_shown]), [left, *notes[1:]] if left else list(notes[1:])


def _n_on_two_lines(sentences: Sequence[str]) -> int:
    """Return the number of sentences that fit on two lines, at least one."""
    n_fitting = 0
    length = 0
    for sentence in sentences:
        length += len(sentence) + 1
        if n_fitting and length > _TWO_LINES:
            break
        n_fitting += 1
    return n_fitting


def value_table(comparison: Comparison) -> DocumentTable:
    """Return the table of values; for many runs the smallest and the largest of each value."""
    values = shown_values(
        comparison.values,
        _MOST_VALUES,
        asked=bool(comparison.quantities),
        stated=comparison.stated_names,
    )
    if len(comparison.runs) > MOST_SIDE_BY_SIDE:
        return _ranges(comparison.runs, values)
    heads = [TableColumn(run.name, numeric=True) for run in comparison.runs]
    units = _units(values)
    rows = [_value_row(value, *units[value.name]) for value in values]
    columns = [_QUANTITY, _UNIT, *heads]
    if len(comparison.runs) > 1:
        columns.append(TableColumn(_ratio_name(comparison.runs), numeric=True))
    return DocumentTable(
        _caption(comparison),
        tuple(columns),
        tuple(rows),
        by_row=True,
        footnotes=footnotes_of_marks(rows),
    )


def _caption(comparison: Comparison) -> str:
    """Return the caption of the table of values; a single run has no differences."""
    return _OF_VALUES if len(comparison.runs) > 1 else _OF_ONE_RUN


def _units(values: Sequence[ComparedValue]) -> dict[str, tuple[str, float]]:
    """Return by name the unit in which values are read best, and its size in the SI unit."""
    return shared_units({value.name: (value.unit, value.values) for value in values})


def _value_row(value: ComparedValue, unit: str, size: float) -> tuple[Cell, ...]:
    """Return label, unit, values and ratio, in a unit of a size."""
    cells = [_marked_cell(value, place, size) for place in range(len(value.values))]
    if len(cells) > 1:
        cells.append(_ratio(value))
    return (Cell(value.label, value.label), Cell(unit), *cells)


def _marked_cell(value: ComparedValue, place: int, size: float) -> Cell:
    """Return the cell of a value of a run with its marks."""
    cell = marked(_value_cell(value, place, size), is_marked=place in value.marked_places)
    return marked_beyond_law(cell, is_beyond=place in value.beyond_law)


def _value_cell(value: ComparedValue, place: int, size: float) -> Cell:
    """Return the cell of a value of a run in a unit of a size, with a large uncertainty."""
    number = value.values[place]
    error = value.error_at(place)
    if number is None or error is None:
        return cell_in_unit(number, size)
    return dataclasses.replace(
        cell_in_unit(number, size), text=interval(number / size, error / size)
    )


def _ranges(runs: Sequence[ComparedRun], values: Sequence[ComparedValue]) -> DocumentTable:
    """Return smallest and largest value of all runs, with the runs that have them."""
    names = names_with_cases(runs)
    units = _units(values)
    rows: list[tuple[Cell, ...]] = []
    for value in values:
        named = [
            (number, name)
            for place, (number, name) in enumerate(zip(value.values, names, strict=True))
            if number is not None and place not in value.places_left_out
        ]
        if not named:
            continue
        least = min(named)
        most = max(named)
        unit, size = units[value.name]
        smallest = _end_cell(value, least[0], size)
        largest = _end_cell(value, most[0], size)
        ends = (smallest, Cell(least[1]), largest, Cell(most[1]))
        rows.append((Cell(value.label, value.label), Cell(unit), *ends, _ratio(value)))
    columns = (
        _QUANTITY,
        _UNIT,
        TableColumn("Smallest", numeric=True),
        TableColumn("of"),
        TableColumn("Largest", numeric=True),
        TableColumn("of run"),
        TableColumn("Ratio", numeric=True),
    )
    return DocumentTable(_OF_VALUES, columns, tuple(rows), by_row=True)


def _end_cell(value: ComparedValue, number: float, size: float) -> Cell:
    """Return the cell of the smallest or the largest value."""
    is_beyond = value.values.index(number) in value.beyond_law
    return marked_beyond_law(cell_in_unit(number, size), is_beyond=is_beyond)


def _ratio(value: ComparedValue) -> Cell:
    if value.without_ratio:
        return Cell(value.without_ratio)
    return Cell("") if value.ratio is None else Cell(factor(value.ratio), value.ratio)


def _ratio_name(runs: Sequence[ComparedRun]) -> str:
    return f"{runs[1].name} / {runs[0].name}" if len(runs) == 2 else "Largest / smallest"


def case_tables(comparison: Comparison) -> list[Block]:
    """Return the differences of the cases: physics unfolded, output and run control folded."""
    rows = comparison.case_rows
    physical = [row for row in rows if not row.is_numerical]
    numerical = [row for row in rows if row.is_numerical]
    blocks: list[Block] = []
    if not physical and comparison.differs and len(comparison.runs) > 1:
        blocks.append(Note("The cases do not differ in their physics."))
    if physical:
        table = _case_table(_OF_CASES, physical, comparison.runs)
        is_long = len(physical) > _MOST_OPEN
        blocks.append(_folded(table) if is_long else table)
    if numerical:
        blocks.append(_folded(_case_table(_OF_NUMERICS, numerical, comparison.runs)))
    return blocks


def _folded(table: DocumentTable) -> Group:
    """Return a table folded away under its caption."""
    bare = dataclasses.replace(table, captioned=False)
    return Group(table.caption, (bare,), folded=True)


def _case_table(
    caption: str, rows: Sequence[Difference], runs: Sequence[ComparedRun]
) -> DocumentTable:
    """Return a row for each key; for many runs a row for each run."""
    names = [run.name for run in runs]
    if len(runs) <= MOST_SIDE_BY_SIDE:
        texts = [(row.what, *row.values) for row in rows]
        return text_table(caption, ("Key", *names), texts)
    columns = [row.values for row in rows]
    texts = list(zip(names, *columns, strict=True))
    return text_table(caption, ("Run", *(row.what for row in rows)), texts)


def misfit_tables(comparison: Comparison) -> list[DocumentTable]:
    """Return the differences from measured curves, a table each."""
    blocks: list[DocumentTable] = []
    for name, curve in comparison.measured.items():
        heads = MISFIT_HEADS if curve.has_peak else _HEADS_WITHOUT_PEAK
        no_cells = ("",) * (len(heads) - 1)
        rows = [_measured_row(curve, _units_of(name))]
        deviations = comparison.deviations(name)
        reasons = unranked_reasons(
            {run.name: found for run, found in deviations.items() if found is not None}
        )
        for run, difference in deviations.items():
            cells: tuple[str, ...] = (_NO_RANGE, *no_cells)
            if difference is not None:
                reason = reasons.get(run.name, "")
                cells = misfit_cells(difference, _units_of(name), curve.peak, reason)
                cells = cells if curve.has_peak else (*cells[:2], cells[-1])
            rows.append((run.name, *cells))
        for run, why in comparison.data(name).lacking.items():
            rows.append((run.name, why, *no_cells))
        blocks.append(text_table(f"Difference from {curve.source}", ("Run", *heads), rows))
    return blocks


def _units_of(name: str) -> tuple[str, str]:
    """Return the units of a figure over which a measured curve is drawn."""
    units = FIGURES[name].units
    assert units is not None  # a measured curve cannot be drawn over it
    return units


def _measured_row(curve: MeasuredCurve, units: tuple[str, str]) -> tuple[str, ...]:
    """Return the row of the measured curve itself."""
    n_points = str(len(curve.x))
    if not curve.has_peak:
        return ("measured", "", "", n_points)
    peak = quantity_in(curve.peak, units[1])
    place = quantity_in(curve.peak_at, units[0])
    return ("measured", "", "", peak, place, "", n_points)


def misfit_cells(
    difference: Deviation, units: tuple[str, str], measured_peak: float, unranked: str = ""
) -> tuple[str, ...]:
    """Return the difference from a measured curve in words, below the `MISFIT_HEADS`.

    Parameters
    ----------
    unranked
        Reason for which the run is not ranked, which stands in place of percentages; empty if it
        is ranked.
    """
    x_unit, y_unit = units
    peak = quantity_in(difference.peak, y_unit)
    place = quantity_in(difference.peak_at, x_unit)
    if abs(difference.peak) < NEGLIGIBLE * abs(measured_peak):
        peak = "0"
        place = ""
    relative = relative_text(difference.relative_rms).removesuffix(" of")
    rms = quantity_in(difference.rms, y_unit)
    if difference.relative_rms < ROUNDING:
        rms = "0"
    return (
        rms,
        f"not ranked: {unranked}" if unranked else relative,
        peak,
        place,
        "" if unranked else _peak_text(difference.peak_difference),
        str(difference.n_points),
    )


def _peak_text(difference: float) -> str:
    """Return the relative difference of the peaks in words; a large one as their ratio; empty for
    NaN.
    """
    if math.isnan(difference):
        return ""
    if difference < _TIMES:
        return percent(100 * difference)
    return f"{1 + difference:.3g} times"


def _pictures(comparison: Comparison) -> list[Block]:
    """Return the figures with their tables, and the figures that could not be drawn."""
    figures: list[Figure] = []
    tables: list[Block] = []
    failed: list[NotDrawn] = []
    for name in comparison.wanted_figures:
        drawing = comparison.drawing(name)
        if isinstance(drawing, Drawing):
            slug = f"compared-{name.replace('_', '-')}"
            make = partial(picture_of, drawing, slug, comparison.caption(name))
            picture = attempt(f"figure {name}", make)
            failed.append(picture) if isinstance(picture, NotDrawn) else figures.append(picture)
            tables += comparison.tables_of(name)
        elif isinstance(drawing, NotDrawn):
            failed.append(drawing)
    blocks: list[Block] = [Gallery(tuple(figures))] if figures else []
    return blocks + tables + [Note(f"The {reason}.", "bad") for reason in failed]
