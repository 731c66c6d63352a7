"""Files of figures: pictures, and text and fonts of PDFs."""

from __future__ import annotations

import io
import re
import zlib

import numpy as np
import pytest
from fontTools import subset
from fontTools.ttLib import TTFont
from PIL import Image

from granwave.analysis.figures import style
from granwave.analysis.figures.pdf_fonts import needed_tables_only


def drawing() -> style.Drawing:
    figure = style.new_figure(2.0)
    axes = figure.subplots()
    axes.semilogy([1, 20, 300], [1e-3, 1, 1e4], label="first AV fi")
    axes.set_xlabel(r"Place $x/\alpha_\mathrm{y}$ (µm)")
    style.legend_above(axes, 1)
    return style.Drawing(figure, {"x_m": [1, 2]})


def streams(pdf: bytes) -> list[bytes]:
    return [zlib.decompress(found) for found in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)]


def fonts(pdf: bytes) -> list[TTFont]:
    return [TTFont(io.BytesIO(one)) for one in streams(pdf) if one.startswith(b"\0\1\0\0")]


def unicode_maps(pdf: bytes) -> list[bytes]:
    return [one for one in streams(pdf) if b"beginbfrange" in one]


def outlines(font: TTFont) -> set[tuple[bytes, int]]:
    """Outline and width of each glyph."""
    glyphs = {name: font["glyf"][name] for name in font.getGlyphOrder()}
    return {
        (glyph.getCoordinates(font["glyf"])[0].array.tobytes(), font["hmtx"][name][0]) for name, glyph in glyphs.items()
    }


@pytest.fixture
def saved(tmp_path):
    with style.style():
        style.save(drawing(), tmp_path / "plot")
    return tmp_path / "plot"


def test_saved_as_matplotlib_saves_it(saved, tmp_path):
    """The same picture, though the layout is computed once and not by each file."""
    with style.style():
        drawing().figure.savefig(tmp_path / "usual.png")
    with Image.open(saved.with_suffix(".png")) as ours, Image.open(tmp_path / "usual.png") as usual:
        np.testing.assert_array_equal(np.asarray(ours), np.asarray(usual)[..., :3])
        assert (np.asarray(usual)[..., 3] == 255).all()  # opaque: ours does without alpha
        assert ours.info["dpi"] == usual.info["dpi"]
        assert ours.info["Software"] == "granwave"


def test_layout_of_the_pdf_is_that_of_the_png(tmp_path):
    with style.style():
        one = drawing()
        style.save(one, tmp_path / "plot")
        places = [axes.get_position().bounds for axes in one.figure.axes]
        usual = drawing()
        usual.figure.savefig(tmp_path / "usual.png")
    assert places == [axes.get_position().bounds for axes in usual.figure.axes]


def test_fonts_of_a_pdf_are_truetype_without_further_tables(saved):
    pdf = saved.with_suffix(".pdf").read_bytes()
    assert b"/CIDFontType2" in pdf and b"/Type3" not in pdf
    found = fonts(pdf)
    assert len(found) >= 2  # upright and slanted
    for font in found:
        assert {"glyf", "loca", "head", "hhea", "hmtx", "maxp"} <= set(font.keys())
        assert not {"GSUB", "GPOS", "GDEF", "kern", "cmap", "post", "name"} & set(font.keys())


def test_text_and_glyphs_of_a_pdf_are_those_of_matplotlib(saved, tmp_path):
    """The same text; and no glyph that it would not have, which has ligatures beside those in use."""
    with style.style():
        usual = drawing()
        usual.figure.savefig(tmp_path / "usual.png")
        usual.figure.savefig(tmp_path / "usual.pdf")
    ours, theirs = saved.with_suffix(".pdf").read_bytes(), (tmp_path / "usual.pdf").read_bytes()
    assert unicode_maps(ours) == unicode_maps(theirs) != []
    for mine, its in zip(fonts(ours), fonts(theirs), strict=True):
        assert outlines(mine) <= outlines(its)
    assert len(ours) < len(theirs)


def test_fonts_are_cut_as_before_afterwards():
    before = subset.Subsetter
    with pytest.raises(KeyError), needed_tables_only():
        assert subset.Subsetter is not before
        raise KeyError
    assert subset.Subsetter is before
