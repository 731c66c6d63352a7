"""Fonts of PDF files, embedded with the tables that a PDF needs and no others.

matplotlib embeds the glyphs in use of each font, which fontTools cuts out of the font file. With DejaVu Sans, nearly
all of the time of that goes into tables for shaping and naming text (GSUB, GPOS, kern, cmap, post), and into objects
made of the outlines of all 6000 glyphs. A PDF stores text as shaped glyphs with their Unicode values beside them, so
that no reader looks at these tables; text remains embedded TrueType, to be selected, searched and edited. matplotlib
has no setting for it, and fontTools only one that acts after it has read the tables. Hence the class that cuts fonts, a
public one of fontTools, is replaced while a PDF is written: by one that copies the bytes of outlines and widths as they
stand in the file, which is quick.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from fontTools import subset
from fontTools.ttLib import TTFont
from fontTools.ttLib.tables.DefaultTable import DefaultTable
from numpy.typing import NDArray

# tables of an embedded TrueType font (ISO 32000-1, 9.9): those that are cut, and those that are copied
_CUT = frozenset({"glyf", "loca", "hmtx", "head", "hhea", "maxp"})
_COPIED = frozenset({"cvt ", "fpgm", "prep"})
_FIRST_GLYPHS = 4  # kept in every subset: the one for missing glyphs, without its outline, and white space

# places in tables (OpenType specification 1.9)
_LONG_OFFSETS = 50  # head: format of loca
_METRICS = 34  # hhea: number of widths
_GLYPHS = 4  # maxp: number of glyphs
# flags of the parts of a composite glyph
_WORDS, _SCALE, _MORE, _SCALES, _MATRIX = 0x1, 0x8, 0x20, 0x40, 0x80


@contextmanager
def needed_tables_only() -> Iterator[None]:
    """Make matplotlib embed fonts without unneeded tables within a ``with`` block."""
    usual = subset.Subsetter
    subset.Subsetter = _Subsetter
    try:
        yield
    finally:
        subset.Subsetter = usual


class _Subsetter(subset.Subsetter):  # type: ignore[misc]
    """Subset of a TrueType font by the numbers of glyphs; of other fonts, as fontTools makes it."""

    def subset(self, font: TTFont) -> None:
        """Reduce a font to the glyphs asked for; ``glyph_index_map`` tells their new numbers."""
        if self.unicodes_requested or self.glyph_names_requested or not _CUT.issubset(font.keys()):
            super().subset(font)
            return
        source = _source(font)
        kept = source.closure({*range(min(_FIRST_GLYPHS, source.n_glyphs)), *self.glyph_ids_requested})
        self.glyph_index_map = {glyph: number for number, glyph in enumerate(kept)}
        tables = source.tables(kept, self.glyph_index_map)
        for name in set(font.keys()) - _CUT - _COPIED - {"GlyphOrder"}:
            del font[name]
        for name, data in tables.items():
            font[name] = DefaultTable(name)
            font[name].data = data


class _Source:
    """Outlines and widths of a font file.

    Parameters
    ----------
    font
        The font, as it was opened.
    """

    def __init__(self, font: TTFont) -> None:
        self.data: dict[str, bytes] = {name: font.getTableData(name) for name in _CUT}
        self.n_glyphs: int = struct.unpack_from(">H", self.data["maxp"], _GLYPHS)[0]
        long = struct.unpack_from(">h", self.data["head"], _LONG_OFFSETS)[0]
        offsets = np.frombuffer(self.data["loca"], dtype=">u4" if long else ">u2", count=self.n_glyphs + 1)
        self.offsets: NDArray[np.int64] = offsets.astype(np.int64) * (1 if long else 2)
        self.n_widths: int = struct.unpack_from(">H", self.data["hhea"], _METRICS)[0]

    def outline(self, glyph: int) -> bytes:
        """Return the outline of a glyph, as in the file."""
        return self.data["glyf"][self.offsets[glyph] : self.offsets[glyph + 1]]

    def width(self, glyph: int) -> bytes:
        """Return width and bearing of a glyph, as in the file."""
        table, last = self.data["hmtx"], 4 * (self.n_widths - 1)
        if glyph < self.n_widths:
            return table[4 * glyph : 4 * glyph + 4]
        bearing = last + 4 + 2 * (glyph - self.n_widths)
        return table[last : last + 2] + table[bearing : bearing + 2]

    def closure(self, glyphs: Iterable[int]) -> list[int]:
        """Return glyphs with those that they are composed of, rising."""
        found, left = set[int](), set(glyphs)
        while left:
            found |= left
            left = {part for glyph in left for _, part in _parts(self.outline(glyph))} - found
        return sorted(found)

    def tables(self, kept: list[int], numbers: dict[int, int]) -> dict[str, bytes]:
        """Return the tables of a font that has the kept glyphs only, in their new numbers."""
        outlines = [_renumbered(self.outline(glyph), numbers) if glyph else b"" for glyph in kept]  # 0: a missing one
        outlines = [outline + b"\0" * (-len(outline) % 4) for outline in outlines]
        offsets = np.concatenate([[0], np.cumsum([len(outline) for outline in outlines])])
        return {
            "glyf": b"".join(outlines),
            "loca": offsets.astype(">u4").tobytes(),
            "hmtx": b"".join(self.width(glyph) for glyph in kept),
            "head": _changed(self.data["head"], _LONG_OFFSETS, 1),
            "hhea": _changed(self.data["hhea"], _METRICS, len(kept)),
            "maxp": _changed(self.data["maxp"], _GLYPHS, len(kept)),
        }


#: Font files that were read, by file and place in it.
_READ: dict[tuple[str, int], _Source] = {}


def _source(font: TTFont) -> _Source:
    reader: Any = font.reader
    key = (str(reader.file.name), int(reader.tables["glyf"].offset))  # a file may hold several fonts
    if key not in _READ:
        _READ[key] = _Source(font)
    return _READ[key]


def _parts(outline: bytes) -> Iterator[tuple[int, int]]:
    """Yield place and glyph of each part of a composite glyph; nothing of a simple one."""
    if len(outline) < 10 or struct.unpack_from(">h", outline)[0] >= 0:
        return
    place, flags = 10, _MORE
    while flags & _MORE:
        flags, glyph = struct.unpack_from(">HH", outline, place)
        yield place + 2, glyph
        place += 4 + (4 if flags & _WORDS else 2)
        place += 2 if flags & _SCALE else 4 if flags & _SCALES else 8 if flags & _MATRIX else 0


def _renumbered(outline: bytes, numbers: dict[int, int]) -> bytes:
    """Return an outline whose parts have their new numbers."""
    for place, glyph in list(_parts(outline)):
        outline = _changed(outline, place, numbers[glyph])
    return outline


def _changed(data: bytes, place: int, number: int) -> bytes:
    """Return bytes with another number of two bytes at a place."""
    return data[:place] + struct.pack(">H", number) + data[place + 2 :]
