"""Content of a report, apart from its format: sections of tables, figures and notes, and cells of
values.

The content is built once (`granwave.analysis.reports.outline`); HTML, Markdown and PDF are three
writers of this model. All texts are plain: a writer escapes what its format needs.

Cells and columns have names, units and numbers as text of a summary or a case, without clutter.
Clutter means columns and rows without a value, and digits that are only rounding.

A number is rounding if it is below 1e-12 of the scale of its quantity, or below 1e-100. The scale
is the largest number with the same unit in the same run (its energies, for example). If a number is
the only one with its unit, or has no unit, the scale is the largest number of all runs.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, TypeVar

import numpy as np

from granwave.analysis.formatting.numbers import column_unit, interval, plain
from granwave.analysis.formatting.values import as_label, grains_called_in, printed_unit
from granwave.analysis.quantities import entries, quantity
from granwave.analysis.summary_table import meaning_of
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains

_ENERGY = "J"  # unit of the values that have one unit in a table

Tone = Literal["", "lead", "good", "note", "bad"]
_COLUMN = 4.3  # inches: a column of a journal, and a quarter
Model = TypeVar("Model")


@dataclasses.dataclass(frozen=True)
class Link:
    """A file next to the report: its displayed name, and its path from the report, quoted as in a
    URL.
    """

    text: str
    href: str


@dataclasses.dataclass(frozen=True)
class Cell:
    """One cell of a table.

    Attributes
    ----------
    text
        Text that is shown.
    value
        Value by which rows are sorted; None comes last.
    meaning
        A sentence that explains it, shown on hover.
    """

    text: str
    value: float | str | None = None
    tone: Tone = ""
    link: Link | None = None
    meaning: str = ""


@dataclasses.dataclass(frozen=True)
class TableColumn:
    """Head of a column; ``key`` columns identify a row, and are repeated if a table is too wide
    for a page.

    ``meaning`` is a sentence that explains the quantity, shown on hover.
    """

    heading: str
    unit: str = ""
    numeric: bool = False
    key: bool = False
    meaning: str = ""

    @property
    def title(self) -> str:
        """The heading with its unit."""
        return f"{self.heading} ({self.unit})" if self.unit else self.heading


@dataclasses.dataclass(frozen=True)
class DocumentTable:
    """Rows of cells, one cell for each column.

    Attributes
    ----------
    captioned
        False: the heading above says enough.
    by_row
        True if each row is a quantity, False if each column is.
    footnotes
        Remarks below the table, each with its mark.
    """

    caption: str
    columns: tuple[TableColumn, ...]
    rows: tuple[tuple[Cell, ...], ...]
    sortable: bool = False
    captioned: bool = True
    by_row: bool = False
    footnotes: tuple[str, ...] = ()
    kind: Literal["table"] = "table"

    def keeping(self, columns: Sequence[int], **changes: Any) -> DocumentTable:
        """The table with only the columns of these numbers; ``changes``: as of
        ``dataclasses.replace``.
        """
        rows = tuple(tuple(row[n] for n in columns) for row in changes.pop("rows", self.rows))
        return dataclasses.replace(
            self, columns=tuple(self.columns[n] for n in columns), rows=rows, **changes
        )


@dataclasses.dataclass(frozen=True)
class Figure:
    """A picture.

    Attributes
    ----------
    name
        Of a file for it, without a suffix: letters, digits, dots and hyphens only.
    size
        Width and height, pixels.
    data
        The numbers that it shows.
    inches
        Width that it was drawn for; 0 where that is not known.
    csv
        Table of the drawn numbers, stored in the page; empty if there are too many.
    """

    name: str
    caption: str
    alt: str
    png: bytes
    size: tuple[int, int]
    data: Link | None = None
    inches: float = 0.0
    csv: bytes = b""

    @property
    def wide(self) -> bool:
        """True for a figure wider than a column, such as panels side by side; it fills a row."""
        return self.inches > _COLUMN if self.inches else self.size[0] > 2 * self.size[1]


@dataclasses.dataclass(frozen=True)
class Gallery:
    """Pictures side by side."""

    figures: tuple[Figure, ...]
    kind: Literal["gallery"] = "gallery"


@dataclasses.dataclass(frozen=True)
class Note:
    """A sentence: important, the answer (``lead``), or, without a tone, a plain paragraph.
    ``section`` is the section with the details.
    """

    text: str
    tone: Tone = ""
    section: str = ""
    links: tuple[Link, ...] = ()
    kind: Literal["note"] = "note"


@dataclasses.dataclass(frozen=True)
class Beside:
    """A figure and a table side by side; one below the other on narrow pages."""

    gallery: Gallery
    table: DocumentTable
    kind: Literal["beside"] = "beside"


Part = DocumentTable | Gallery | Note | Beside


@dataclasses.dataclass(frozen=True)
class Group:
    """Blocks under a heading; folded if the format supports it."""

    title: str
    blocks: tuple[Part, ...]
    folded: bool = False
    kind: Literal["group"] = "group"


Block = Part | Group


@dataclasses.dataclass(frozen=True)
class DocumentSection:
    """A section; ``slug`` is its name in links."""

    title: str
    slug: str
    blocks: tuple[Block, ...]


@dataclasses.dataclass(frozen=True)
class Badge:
    """A state in a few words, at the top of a report; ``section`` is the section
    with the details.
    """

    text: str
    tone: Tone
    section: str = ""


@dataclasses.dataclass(frozen=True)
class Report:
    """A complete report."""

    title: str
    lead: str
    sections: tuple[DocumentSection, ...]
    badges: tuple[Badge, ...] = ()


def cleaned(part: Model) -> Model:
    """Return the report with texts that any format can hold: control characters and lone surrogates
    are replaced.
    """

    def printable(text: str) -> str:
        kept = "".join(c if c in "\n\t" or c.isprintable() else "\ufffd" for c in text)
        return kept.encode("utf-8", "replace").decode("utf-8")

    return changed(part, str, printable)


def changed(part: Any, kind: type, change: Callable[[Any], Any]) -> Any:
    """Return the report with all its parts of a kind changed."""
    if isinstance(part, kind):
        return change(part)
    if isinstance(part, tuple):
        return tuple(changed(item, kind, change) for item in part)
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        names = [field.name for field in dataclasses.fields(part)]
        return dataclasses.replace(
            part, **{name: changed(getattr(part, name), kind, change) for name in names}
        )
    return part


BLANK = "\u2013"  # a value that does not apply
_EMPTY = ("", BLANK)
_DIGITS = 5
_ROUNDING = 1e-12
_LEAST = 1e-100
_UNIT = "Unit"  # heading of the column that has the units where each row is a quantity


def label_of(key: str, called: str = SPHERES) -> str:
    """Label of a value of a summary; ``called``: name of the grains of its runs."""
    return in_grains(quantity(key).label, called)


def meaning_in(key: str, called: str = SPHERES) -> str:
    """Meaning of a value of a summary; ``called`` as of `label_of`."""
    return in_grains(meaning_of(key), called)


def meanings(summaries: Sequence[Mapping[str, Any]]) -> tuple[Group, ...]:
    """Meanings of the values in these summaries, folded away; nothing if there are none."""
    explained = [entry for entry in entries() if entry.meaning]
    shown = [
        entry
        for entry in explained
        if any(summary.get(entry.name) is not None for summary in summaries)
    ]
    if not shown:
        return ()
    title = "What these values mean"
    called = grains_called_in(summaries)
    heads = ("Quantity", "In summary.json", "Meaning")
    rows = [
        (in_grains(entry.label, called), entry.name, in_grains(entry.meaning, called))
        for entry in shown
    ]
    return (Group(title, (text_table(title, heads, rows, captioned=False),), folded=True),)


def text_table(
    caption: str, heads: Sequence[str], rows: Iterable[Sequence[str | Cell]], **options: Any
) -> DocumentTable:
    """Table of texts, the first of each row its key; ``options``: as of `DocumentTable`."""
    cells = []
    for row in rows:
        cells.append(tuple(text if isinstance(text, Cell) else Cell(text) for text in row))
    columns = (TableColumn(heads[0], key=True), *map(TableColumn, heads[1:]))
    return DocumentTable(caption, columns, tuple(cells), **options)


def column_table(
    caption: str, columns: Iterable[tuple[TableColumn, Sequence[Cell]]], **options: Any
) -> DocumentTable:
    """Table from its columns, each with its cells; ``options``: as of `DocumentTable`."""
    heads, cells = zip(*columns, strict=True)
    return DocumentTable(caption, heads, tuple(zip(*cells, strict=True)), **options)


def unit_of_value(key: str) -> str:
    """Unit of a key of a summary, empty if it has none."""
    return printed_unit(quantity(key).unit)


def value_column(key: str, called: str = SPHERES, unit: str | None = None) -> TableColumn:
    """Column of a value of the summary.

    Parameters
    ----------
    called
        Name of the grains of its runs.
    unit
        Unit of the numbers of the column; by default the SI unit.
    """
    shown = unit_of_value(key) if unit is None else unit
    meaning = meaning_in(key, called)
    return TableColumn(label_of(key, called), shown, numeric=True, meaning=meaning)


def units_of_values(
    keys: Iterable[str], summaries: Sequence[Mapping[str, Any]]
) -> dict[str, tuple[str, float]]:
    """Return by key the unit in which values of summaries are read best in one table, and its size
    in the SI unit; all energies of the table have one unit.
    """
    rows: dict[str, tuple[str, list[object]]] = {}
    for key in keys:
        rows[key] = (unit_of_value(key), [summary.get(key) for summary in summaries])
    return shared_units(rows)


def shared_units(
    rows: Mapping[str, tuple[str, Sequence[object]]],
) -> dict[str, tuple[str, float]]:
    """Return by name the unit of the rows of a table, and its size in the SI unit, from their SI
    units and values; all energies have one unit.
    """
    energies: list[object] = []
    for unit, values in rows.values():
        if unit == _ENERGY:
            energies += values
    common = column_unit(_ENERGY, energies)
    return {
        name: common if unit == _ENERGY else column_unit(unit, values)
        for name, (unit, values) in rows.items()
    }


def value_cells(key: str, values: Sequence[Any]) -> tuple[str, list[Cell]]:
    """Return the unit in which values of the summary are read best, and their cells in it."""
    unit, size = column_unit(unit_of_value(key), values)
    return unit, [cell_in_unit(value, size) for value in values]


def cell_in_unit(value: Any, size: float, **more: Any) -> Cell:
    """Return the cell of a value in a unit of a size, which sorts by the SI value."""
    text = value_cell(in_unit(value, size)).text
    return dataclasses.replace(value_cell(value, **more), text=text)


def in_unit(value: Any, size: float) -> Any:
    """Return a number in a unit of a size; other values stay."""
    return value / size if size != 1.0 and is_number(value) else value


def case_column(key: str, unit: str, *, numeric: bool) -> TableColumn:
    """Column of a key of the case, with its unit in print."""
    return TableColumn(key, unit, numeric=numeric, key=True)


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
    if isinstance(value, dict) or (
        isinstance(value, (list, tuple)) and any(isinstance(item, dict) for item in value)
    ):
        return as_label(value)
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(show(item) for item in value) + "]"
    return str(value)


def named(labels: Sequence[str], most: int = 6) -> str:
    """A list of runs, cut when it is long; points of one scan are named by their numbers after the
    first.
    """
    texts = []
    before = None
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
    """Cell of a mean with its interval or deviation, if known, with significant digits only."""
    if mean is None or not half_width or not math.isfinite(half_width):
        return value_cell(mean)
    return Cell(interval(mean, half_width), mean)


def is_number(value: Any) -> bool:
    """Return True for an integer or a float, and False for a truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def significant(value: float, digits: int) -> str:
    """A number with a given number of significant digits."""
    return _float(value, digits)


def _float(value: float, digits: int = _DIGITS) -> str:
    if math.isnan(value):
        return "not a number"
    if math.isinf(value):
        return "infinite"
    text = f"{value:.{digits}g}"
    if 1e5 <= abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return plain(text)


def tidied(report: Report) -> Report:
    """The report with all its tables tidied."""
    found: Report = changed(report, DocumentTable, tidied_table)
    return found


def tidied_table(table: DocumentTable) -> DocumentTable:
    """The table without empty columns and rows, and with ``< 1e-16`` for rounding errors."""
    rows = _without_rounding(table)
    numbers = _columns_of_numbers(table)
    if table.by_row and numbers:
        rows = [row for row in rows if any(row[n].text not in _EMPTY for n in numbers)] or rows
    kept = [
        n
        for n in range(len(table.columns))
        if not rows or any(row[n].text not in _EMPTY for row in rows)
    ]
    return table.keeping(kept, rows=rows)


def _columns_of_numbers(table: DocumentTable) -> list[int]:
    return [n for n, column in enumerate(table.columns) if column.numeric and not column.key]


def _without_rounding(table: DocumentTable) -> list[list[Cell]]:
    """Return the cells by row and column, with a bound in place of each rounding error."""
    rows = [list(row) for row in table.rows]
    shown = _columns_of_numbers(table)
    if not rows or not shown:
        return rows
    sizes = np.array(
        [[max(map(abs, _numbers(row[n])), default=0.0) for n in shown] for row in rows]
    )
    units = [table.columns[n].unit for n in shown]
    if table.by_row:  # then a quantity is a row
        of_units = [n for n, column in enumerate(table.columns) if column.heading == _UNIT]
        units = [row[of_units[0]].text if of_units else "" for row in rows]
        sizes = sizes.T
    scales = np.empty_like(sizes)  # scale of each run and quantity
    for unit in set(units):
        alike = np.array([one == unit for one in units])
        of_a_run = unit != "" and alike.sum() > 1
        scales[:, alike] = sizes[:, alike].max(axis=1 if of_a_run else 0, keepdims=True)
    limits = np.maximum(_ROUNDING * scales, _LEAST)
    rounding = (sizes > 0) & (sizes < limits)
    if table.by_row:
        limits = limits.T
        rounding = rounding.T
    for row, n in np.argwhere(rounding):
        bound = f"< 1e{math.ceil(math.log10(limits[row, n]) - 1e-9)}"  # the power of ten above
        rows[row][shown[n]] = dataclasses.replace(rows[row][shown[n]], text=bound)
    return rows


def _numbers(cell: Cell) -> tuple[float, ...]:
    """Return a value, ``0.7``, or a mean and its half-width, ``0.70 ± 0.25``; nothing for other
    texts.
    """
    try:
        found = tuple(map(float, cell.text.split(" ± ")))
    except ValueError:
        return ()
    return found if all(map(math.isfinite, found)) else ()
