"""Report as Markdown (with tables of GitHub's form), with pictures as files."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from urllib.parse import quote

from granwave.analysis.document.model import (
    Beside,
    Block,
    Cell,
    Column,
    Figure,
    Gallery,
    Group,
    Link,
    Note,
    Report,
    Table,
)

_SPECIAL = re.compile(r"([\\`*_\[\]|~#$])")
_LINE_START = re.compile(r"^(\s*)([-+>]|\d+(?=[.)]))")
_WARNINGS: Mapping[str, str] = {"bad": "**Warning:** ", "note": "**Note:** "}


def markdown(report: Report, folder: str) -> tuple[str, dict[str, bytes]]:
    """Return the text, and the pictures by file name.

    Parameters
    ----------
    folder
        Name of the directory of the pictures beside the text.
    """
    pictures: dict[str, bytes] = {}
    lines = [f"# {_escape(report.title)}", "", _paragraph(report.lead), ""]
    for section in report.sections:
        lines += [f"## {_escape(section.title)}", ""]
        for block in section.blocks:
            lines += _block(block, folder, pictures)
    return "\n".join(lines).rstrip() + "\n", pictures


def _block(block: Block, folder: str, pictures: dict[str, bytes]) -> Iterator[str]:
    if isinstance(block, Note):
        links = "".join(f" {_link(item)}" for item in block.links)
        yield from (_WARNINGS.get(block.tone, "") + _paragraph(block.text) + links, "")
    elif isinstance(block, Table):
        yield from _table(block)
    elif isinstance(block, Gallery):
        for figure in block.figures:
            yield from _figure(figure, folder, pictures)
    elif isinstance(block, Beside):
        yield from _block(block.gallery, folder, pictures)
        yield from _block(block.table, folder, pictures)
    elif isinstance(block, Group):
        yield from (f"### {_escape(block.title)}", "")
        for part in block.blocks:
            yield from _block(part, folder, pictures)


def _table(table: Table) -> Iterator[str]:
    if table.captioned:
        yield from (f"**{_escape(table.caption)}**", "")
    yield _row(_heading(column) for column in table.columns)
    yield _row("---:" if column.numeric else "---" for column in table.columns)
    for row in table.rows:
        yield _row(_cell(cell) for cell in row)
    yield ""


def _heading(column: Column) -> str:
    return _escape(f"{column.heading} ({column.unit})" if column.unit else column.heading)


def _cell(cell: Cell) -> str:
    text = _link(Link(cell.text, cell.link.href)) if cell.link else _escape(cell.text)
    return f"**{text}**" if cell.tone == "bad" and text else text


def _row(cells: Iterator[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _figure(figure: Figure, folder: str, pictures: dict[str, bytes]) -> Iterator[str]:
    name = f"{figure.name}.png"
    number = 2
    while name in pictures and pictures[name] != figure.png:
        name, number = f"{figure.name}-{number}.png", number + 1
    pictures[name] = figure.png
    data = f" Data: {_link(figure.data)}" if figure.data else ""
    yield from (f"![{_escape(figure.alt)}]({quote(folder)}/{name})", "", f"*{_escape(figure.caption)}.*{data}", "")


def _link(link: Link) -> str:
    return f"[{_escape(link.text)}]({link.href})"


def _paragraph(text: str) -> str:
    return _LINE_START.sub(r"\1\\\2", _escape(text))


def _escape(text: str) -> str:
    """Escape markup in a text, and put it on one line."""
    text = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))
