"""Fonts of PDF files, embedded with the tables that a PDF needs and no others.

matplotlib embeds the glyphs in use of each font, which fontTools cuts out of the font file. With DejaVu Sans, five
sixths of the time of that go into tables for shaping and naming text (GSUB, GPOS, kern, cmap, post). A PDF stores text
as shaped glyphs with their Unicode values beside them, so that no reader looks at these tables; text remains embedded
TrueType, to be selected, searched and edited. matplotlib has no setting for it, and fontTools only one that acts after
it has read the tables. Hence the function that loads a font, a public one of fontTools, is replaced while a PDF is
written.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from fontTools import subset

# tables of an embedded TrueType font (ISO 32000-1, 9.9), and the order of its glyphs
_NEEDED = frozenset({"GlyphOrder", "glyf", "head", "hhea", "hmtx", "loca", "maxp", "cvt ", "fpgm", "prep"})


@contextmanager
def needed_tables_only() -> Iterator[None]:
    """Make matplotlib embed fonts without unneeded tables within a ``with`` block."""
    load_font = subset.load_font

    def load(*arguments: Any, **options: Any) -> Any:
        font = load_font(*arguments, **options)
        if "glyf" in font:  # others, as those with PostScript outlines, stay as they are
            for table in set(font.keys()) - _NEEDED:
                del font[table]
        return font

    subset.load_font = load
    try:
        yield
    finally:
        subset.load_font = load_font
