"""Symbols that the texts, tables and figures of a report use."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

from granwave.analysis.document.model import (
    Beside,
    Block,
    DocumentSection,
    DocumentTable,
    Figure,
    Gallery,
    Group,
    Note,
    Part,
)

_COMPARED = "compared-"  # beginning of the names of figures of comparisons, which use no symbols
#: Columns of the data of a figure whose axes or colour scales use a symbol.
_COLUMNS = {
    "F_y": r"yield_force|_Fy_",
    "alpha_y": r"alpha_y",
    "F_y alpha_y": r"Fy_alpha_y|energy_input_normalised",
    "F_max": r"largest_force|peak_force",
    "e_in": r"(dissipated|yielding|friction|viscous)_over_input"
    r"|dissipated_fraction|energy_input_normalised",
    "v\u0304_0": r"velocity_normalised",
}


def uses_symbol(symbol: str, parts: Iterable[Part]) -> bool:
    """Return True if a text, a table or a figure among blocks uses a symbol.

    A figure whose data are not in the page may use every symbol.
    """
    parts = list(parts)
    word = re.compile(rf"(?<![\w.]){re.escape(symbol)}(?!\w)")
    if any(word.search(text) for text in chain.from_iterable(map(_texts, parts))):
        return True
    return any(_draws(symbol, figure) for figure in chain.from_iterable(map(_figures, parts)))


def parts_of(blocks: Sequence[Block]) -> Iterator[Part]:
    """Iterate over blocks, including the blocks of groups."""
    for block in blocks:
        if isinstance(block, Group):
            yield from block.blocks
        else:
            yield block


def parts_of_sections(sections: Sequence[DocumentSection]) -> Iterator[Part]:
    """Iterate over all blocks of sections, including the blocks of groups."""
    for section in sections:
        yield from parts_of(section.blocks)


def _figures(part: Part) -> tuple[Figure, ...]:
    if isinstance(part, Gallery):
        return part.figures
    return part.gallery.figures if isinstance(part, Beside) else ()


def _draws(symbol: str, figure: Figure) -> bool:
    """Return True if the axes or colour scales of a figure use a symbol."""
    if figure.name.startswith(_COMPARED):
        return False
    head = figure.csv.partition(b"\n")[0].decode("utf-8", "replace")
    pattern = _COLUMNS.get(symbol, "")
    return not head or re.search(pattern, head) is not None


def _texts(part: Part) -> Iterator[str]:
    """Iterate over the texts of a block."""
    if isinstance(part, Note):
        yield part.text
    if isinstance(part, Beside):
        part = part.table
    if isinstance(part, DocumentTable):
        yield part.caption
        yield from part.footnotes
        for column in part.columns:
            yield f"{column.heading} {column.meaning}"
        for row in part.rows:
            yield from (cell.text for cell in row)
    if isinstance(part, Gallery):
        yield from (figure.caption for figure in part.figures)
