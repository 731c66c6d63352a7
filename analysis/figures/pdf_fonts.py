"""Fonts of PDF files, embedded with the tables that a PDF needs and no others.

matplotlib embeds the glyphs in use of each font, which fontTools cuts out of the font file. With DejaVu Sans, five
sixths of the time of that go into tables for shaping and naming text (GSUB, GPOS, kern, cmap, post). A PDF stores text
as shaped glyphs with their Unicode values beside them, so that no reader looks at these tables; text remains embedded
TrueType, to be selected, searched and edited. matplotlib has no setting for it, and fontTools only one that acts after
it has read the tables. Hence the function that loads a font, a public one of fontTools, is replaced while a PDF is
written.

Of what remains, reading the outlines and widths of all 6000 glyphs takes most. It is done once for each font; every PDF
gets fresh tables of the same content, which its subset may change, and glyphs of those that it asks for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from typing import Any

from fontTools import subset
from fontTools.ttLib.tables._g_l_y_f import Glyph

# tables of an embedded TrueType font (ISO 32000-1, 9.9), and the order of its glyphs
_NEEDED = frozenset({"GlyphOrder", "glyf", "head", "hhea", "hmtx", "loca", "maxp", "cvt ", "fpgm", "prep"})


@contextmanager
def needed_tables_only() -> Iterator[None]:
    """Make matplotlib embed fonts without unneeded tables within a ``with`` block."""
    load_font = subset.load_font

    def load(file: Any, *arguments: Any, **options: Any) -> Any:
        font = _load(load_font, file, *arguments, **options)
        if "glyf" in font:
            key = (str(file), getattr(file, "face_index", 0))
            if key not in _READ:
                read = _load(load_font, file, *arguments, **options)
                outlines = {name: getattr(glyph, "data", b"") for name, glyph in read["glyf"].glyphs.items()}
                _READ[key] = (read["glyf"], outlines, read["hmtx"])
            glyphs, outlines, widths = _READ[key]
            font.tables["glyf"], font.tables["hmtx"] = copy(glyphs), copy(widths)
            font["glyf"].glyphs = _Glyphs(outlines)
            font["glyf"].glyphOrder = list(glyphs.glyphOrder)
            font["hmtx"].metrics = dict(widths.metrics)
        return font

    subset.load_font = load
    try:
        yield
    finally:
        subset.load_font = load_font


class _Glyphs(dict[str, Glyph]):
    """Glyphs by name, made of their outlines when they are asked for: of 6000 a PDF needs some 50."""

    def __init__(self, outlines: Mapping[str, bytes]) -> None:
        super().__init__()
        self._outlines = outlines

    def __contains__(self, name: object) -> bool:
        return name in self._outlines

    def __missing__(self, name: str) -> Glyph:
        self[name] = glyph = Glyph(self._outlines[name])
        return glyph


#: Table of outlines, the outlines as bytes, and table of widths of the fonts that were read, by file and face.
_READ: dict[tuple[str, int], tuple[Any, dict[str, bytes], Any]] = {}


def _load(load_font: Callable[..., Any], file: Any, *arguments: Any, **options: Any) -> Any:
    """Load a font without unneeded tables."""
    font = load_font(file, *arguments, **options)
    if "glyf" in font:  # others, as those with PostScript outlines, stay as they are
        for table in set(font.keys()) - _NEEDED:
            del font[table]
    return font
