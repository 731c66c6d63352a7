"""Content of a report, apart from its format: sections of tables, figures and notes.

The content is built once (`granwave.analysis.reports.outline`); HTML, Markdown and PDF are three writers of this model.
All texts are plain: a writer escapes what its format needs.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar

Tone = Literal["", "lead", "good", "note", "bad"]
_COLUMN = 4.3  # inches: a column of a journal, and a quarter
Model = TypeVar("Model")


@dataclasses.dataclass(frozen=True)
class Link:
    """A file beside the report: its name for people, and its path from the report, quoted as in a URL."""

    text: str
    href: str


@dataclasses.dataclass(frozen=True)
class Cell:
    """One cell of a table.

    Attributes
    ----------
    text
        What is shown.
    value
        What rows are sorted by; None sorts last.
    meaning
        A sentence that explains it, shown on hover.
    """

    text: str
    value: float | str | None = None
    tone: Tone = ""
    link: Link | None = None
    meaning: str = ""


@dataclasses.dataclass(frozen=True)
class Column:
    """Head of a column; ``key`` columns say what a row is, and are repeated where a table is too wide for a page.

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
class Table:
    """Rows of cells, as many in each as there are columns.

    Attributes
    ----------
    captioned
        False: the heading above says enough.
    by_row
        Each row is a quantity of its own; else each column is.
    """

    caption: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    sortable: bool = False
    captioned: bool = True
    by_row: bool = False
    kind: Literal["table"] = "table"

    def keeping(self, columns: Sequence[int], **changes: Any) -> Table:
        """The table with only the columns of these numbers; ``changes``: as of ``dataclasses.replace``."""
        rows = tuple(tuple(row[n] for n in columns) for row in changes.pop("rows", self.rows))
        return dataclasses.replace(self, columns=tuple(self.columns[n] for n in columns), rows=rows, **changes)


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
    """

    name: str
    caption: str
    alt: str
    png: bytes
    size: tuple[int, int]
    data: Link | None = None
    inches: float = 0.0

    @property
    def wide(self) -> bool:
        """Drawn for more than a column, as panels side by side are; it takes a row of its own."""
        return self.inches > _COLUMN if self.inches else self.size[0] > 2 * self.size[1]


@dataclasses.dataclass(frozen=True)
class Gallery:
    """Pictures side by side."""

    figures: tuple[Figure, ...]
    kind: Literal["gallery"] = "gallery"


@dataclasses.dataclass(frozen=True)
class Note:
    """A sentence: one that must not be overlooked, the answer (``lead``), or with no tone a plain paragraph.

    ``section`` is where to read on.
    """

    text: str
    tone: Tone = ""
    section: str = ""
    links: tuple[Link, ...] = ()
    kind: Literal["note"] = "note"


@dataclasses.dataclass(frozen=True)
class Beside:
    """A picture and a table side by side; one after the other where there is no room."""

    gallery: Gallery
    table: Table
    kind: Literal["beside"] = "beside"


Part = Table | Gallery | Note | Beside


@dataclasses.dataclass(frozen=True)
class Group:
    """Blocks under a heading of their own; folded where the format can fold."""

    title: str
    blocks: tuple[Part, ...]
    folded: bool = False
    kind: Literal["group"] = "group"


Block = Part | Group


@dataclasses.dataclass(frozen=True)
class Section:
    """A section; ``slug`` is its name in links."""

    title: str
    slug: str
    blocks: tuple[Block, ...]


@dataclasses.dataclass(frozen=True)
class Report:
    """A whole report."""

    title: str
    lead: str
    sections: tuple[Section, ...]


def cleaned(part: Model) -> Model:
    """The same with texts that any format can hold: control characters and lone surrogates are replaced."""

    def printable(text: str) -> str:
        kept = "".join(c if c in "\n\t" or c.isprintable() else "\ufffd" for c in text)
        return kept.encode("utf-8", "replace").decode("utf-8")

    return changed(part, str, printable)


def changed(part: Any, kind: type, change: Callable[[Any], Any]) -> Any:
    """The same with all its parts of a kind changed."""
    if isinstance(part, kind):
        return change(part)
    if isinstance(part, tuple):
        return tuple(changed(item, kind, change) for item in part)
    if dataclasses.is_dataclass(part) and not isinstance(part, type):
        names = [field.name for field in dataclasses.fields(part)]
        return dataclasses.replace(part, **{name: changed(getattr(part, name), kind, change) for name in names})
    return part
