"""Tables: CSV and text of any program, such as lethe, Chrono and spreadsheets."""

from __future__ import annotations

from granwave.lammps_inputs.readers.columns import (
    PLACE,
    QUANTITIES,
    ColumnReader,
    find_columns,
    quantity_of,
    require_columns,
)
from granwave.lammps_inputs.readers.grain_table import GrainTable
from granwave.lammps_inputs.readers.source import FileOptions, GrainSource
from granwave.lammps_inputs.tables.layout import (
    Layout,
    is_number,
    layout_from,
    layout_of,
    with_decimal_point,
    without_count,
)
from granwave.lammps_inputs.tables.text_table import text_table_of

NAME = "table"
LABEL = "table"
_LEAST_COLUMNS = 3
_LARGEST_TITLE = 20  # rows that may be above the names of the columns
_NOTHING = (
    f"found no grain, expected a line of names ({', '.join(QUANTITIES)}) and a row for each grain"
)


def recognises(source: GrainSource) -> bool:
    """Return True for a line with the name of a coordinate, or for lines with equally many cells
    with numbers.
    """
    if source.is_binary:
        return False
    layout = without_count(layout_of(source.whole_lines))
    if not layout.rows or _row_of_names(layout):
        return True
    try:
        first = layout.cells(0)
        second = layout.cells(min(1, len(layout.rows) - 1))
    except ValueError:
        return False
    if any(quantity_of(head)[0] == PLACE[0] for head in first):
        return True
    n_numbers = sum(is_number(with_decimal_point(cell)) for cell in second)
    return len(first) == len(second) >= _LEAST_COLUMNS <= n_numbers


def has_names(source: GrainSource) -> bool:
    """Return True for a table whose columns have names of positions."""
    layout = without_count(layout_of(source.whole_lines))
    if source.is_binary or not layout.rows:
        return False
    if _row_of_names(layout):
        return True
    try:
        return any(quantity_of(head)[0] == PLACE[0] for head in layout.cells(0))
    except ValueError:
        return False


def read(source: GrainSource) -> GrainTable:
    """Read a table of grains; raise ValueError with the line of the fault."""
    return read_table_text(source.text, source.options)


def read_table_text(text: str, options: FileOptions) -> GrainTable:
    """Read the text of a table of grains; raise ValueError with the line of the fault."""
    layout = without_count(layout_of(text))
    if not layout.rows:
        raise ValueError(_NOTHING)
    notes: list[str] = []
    if not options.heads and (n_above := _row_of_names(layout)):
        last = layout.numbers[n_above - 1]
        layout = layout_from(layout, n_above)
        notes.append(f"text down to line {last} above the names of the columns ignored")
    table = text_table_of(layout, options.heads)
    columns = find_columns(table, options, notes)
    require_columns(table, columns, options)
    if not len(table):
        raise ValueError("found no grain, expected a row for each below the line of names")
    return ColumnReader(table, columns, options).grains(LABEL, notes)


def _row_of_names(layout: Layout) -> int:
    """Return the row with the names of the columns, if there are other rows above
    it; otherwise 0.
    """
    for row in range(min(len(layout.rows), _LARGEST_TITLE)):
        try:
            cells = layout_from(layout, row).cells(0)
        except ValueError:
            return 0
        quantities = {quantity_of(cell)[0] for cell in cells}
        if {*PLACE[:2]} <= quantities:
            return row
        if sum(map(is_number, cells)) >= _LEAST_COLUMNS:
            return 0
    return 0
