"""Files of figures: bitmaps, and text and fonts of PDFs."""

from __future__ import annotations

import io
import re
import zlib
from itertools import pairwise

import numpy as np
import pytest
from fontTools import subset
from fontTools.ttLib import TTFont
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from PIL import Image

from granwave.analysis.figures import style
from granwave.analysis.figures.scales import plain_powers
from tests.helpers.selection import with_every_test


def drawing() -> style.Drawing:
    figure = style.new_figure(2.0)
    axes = figure.subplots()
    axes.semilogy([1, 20, 300], [1e-3, 1, 1e4], label="first AV fi")
    axes.set_xlabel(r"Place $x/\alpha_\mathrm{y}$ (µm)")
    style.legend_above(axes, 1)
    return style.Drawing(figure, {"x_m": [1, 2]})


def usual_drawing() -> style.Drawing:
    """The same figure with the labels that granwave adds when it saves a figure."""
    found = drawing()
    plain_powers(found.figure)
    return found


def streams(pdf: bytes) -> list[bytes]:
    return [
        zlib.decompress(found)
        for found in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, re.DOTALL)
    ]


def fonts(pdf: bytes) -> list[TTFont]:
    return [TTFont(io.BytesIO(one)) for one in streams(pdf) if one.startswith(b"\0\1\0\0")]


def unicode_maps(pdf: bytes) -> list[bytes]:
    return [one for one in streams(pdf) if b"beginbfrange" in one]


def outlines(font: TTFont) -> set[tuple[bytes, int]]:
    """Outline and width of each glyph."""
    glyphs = {name: font["glyf"][name] for name in font.getGlyphOrder()}
    return {
        (glyph.getCoordinates(font["glyf"])[0].array.tobytes(), font["hmtx"][name][0])
        for name, glyph in glyphs.items()
    }


@pytest.fixture
def saved(tmp_path):
    with style.style():
        style.save(drawing(), tmp_path / "plot")
    return tmp_path / "plot"


def test_saved_as_matplotlib_saves_it(saved, tmp_path):
    """The picture is unchanged although the layout is computed only once and not for each file."""
    with style.style():
        usual_drawing().figure.savefig(tmp_path / "usual.png")
    with Image.open(saved.with_suffix(".png")) as ours, Image.open(tmp_path / "usual.png") as usual:
        np.testing.assert_array_equal(np.asarray(ours), np.asarray(usual))
        assert ours.info["dpi"] == usual.info["dpi"]
        assert ours.info["Software"] == "granwave"


def test_fonts_of_a_pdf_are_truetype_without_further_tables(saved):
    pdf = saved.with_suffix(".pdf").read_bytes()
    assert b"/CIDFontType2" in pdf and b"/Type3" not in pdf
    found = fonts(pdf)
    assert len(found) == 3  # upright, its ligatures, and slanted, whatever the characters
    for font in found:
        assert {"glyf", "loca", "head", "hhea", "hmtx", "maxp"} <= set(font.keys())
        assert not {"GSUB", "GPOS", "GDEF", "kern", "cmap", "post", "name"} & set(font.keys())


def test_text_and_glyphs_of_a_pdf_are_those_of_matplotlib(saved, tmp_path):
    """The text is unchanged, and the font contains no unused glyphs, such as ligatures."""
    with style.style():
        usual = usual_drawing()
        usual.figure.savefig(tmp_path / "usual.png")
        usual.figure.savefig(tmp_path / "usual.pdf")
    ours = saved.with_suffix(".pdf").read_bytes()
    theirs = (tmp_path / "usual.pdf").read_bytes()
    assert unicode_maps(ours) == unicode_maps(theirs) != []
    for mine, its in zip(fonts(ours), fonts(theirs), strict=True):
        assert outlines(mine) <= outlines(its)
    assert len(ours) < len(theirs)


def test_fonts_are_loaded_as_before_afterwards():
    before = subset.load_font
    with pytest.raises(KeyError), style._needed_tables_only():
        assert subset.load_font is not before
        raise KeyError
    assert subset.load_font is before


def labels(axis) -> list[str]:
    low, high = axis.get_view_interval()
    ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
    inside = [tick for tick in ticks if low <= tick.get_loc() <= high]
    texts = [tick.label1.get_text().replace("\N{MULTIPLICATION SIGN}", "x") for tick in inside]
    return [text for text in texts if text]


@pytest.mark.parametrize(
    ("low", "high", "across", "up"),
    [
        (1e-3, 1.0, {"10⁻³", "10⁻²", "10⁻¹", "10⁰"}, {"10⁻³", "10⁻²", "10⁻¹", "10⁰"}),
        (18.0, 95.0, {"20", "50", "100"}, {"20", "50", "100"}),
        (3e-5, 8e-4, {"5x10⁻⁵", "10⁻⁴", "2x10⁻⁴", "5x10⁻⁴"}, {"5x10⁻⁵", "10⁻⁴", "5x10⁻⁴"}),
    ],
)
def test_labels_of_logarithmic_axes(low, high, across, up):
    """Labels are plain text, and short numbers are written out; the horizontal axis has no more
    labels than fit.
    """
    with style.style():
        figure = style.new_figure(2.2)
        axes = figure.subplots()
        axes.loglog([low, high], [low, high])
        style.lay_out(figure, 300)
        figure.draw_without_rendering()
    assert set(labels(axes.xaxis)) == across
    assert up <= set(labels(axes.yaxis))
    assert not any("$" in text for text in labels(axes.yaxis))


@pytest.mark.parametrize("high", [1.3, 2.5, 9.0, 12.0, 52.0, 400.0, 3e4, 2e9, 1e25])
@pytest.mark.parametrize("low", with_every_test([1.0, 0.021, 3e-7], [1.0]))
def test_labels_on_narrow_panels_do_not_touch(low, high):
    """Labels of each axis, and of an axis above it, do not overlap."""
    with style.style():
        figure = style.new_figure(1.4)
        row = figure.subplots(1, 3)
        tops = []
        for axes in row:
            axes.loglog([low, low * high], [low, low * high])
            double = (lambda x: 2 * np.asarray(x), lambda x: np.asarray(x) / 2)
            tops.append(axes.secondary_xaxis("top", functions=double))
        style.lay_out(figure, 300)
        figure.draw_without_rendering()
    renderer = figure.canvas.get_renderer()
    for axis in (row[1].xaxis, row[1].yaxis, tops[1].xaxis):
        ends = sorted(axis.get_view_interval())
        shown = [
            tick.label1 if axis is not tops[1].xaxis else tick.label2
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
            if ends[0] <= tick.get_loc() <= ends[1]
        ]
        boxes = [text.get_window_extent(renderer) for text in shown if text.get_text()]
        assert len(boxes) >= (2 if 100 < high < 1e10 else 1)
        boxes.sort(key=lambda box: (box.x0, box.y0))
        assert not any(one.overlaps(other) for one, other in pairwise(boxes))


@pytest.mark.parametrize(
    ("decades", "on_axes", "on_bar"), [(1.5, True, True), (3, True, False), (5, False, False)]
)
def test_ticks_between_powers_of_ten(decades, on_axes, on_bar):
    """Minor ticks are omitted if there are many decades; for colour bars, which are small, earlier
    than for axes.
    """
    with style.style():
        figure = style.new_figure(2.0)
        axes = figure.subplots()
        axes.set_xscale("log")
        axes.set_xlim(1, 10**decades)
        bar = figure.colorbar(ScalarMappable(LogNorm(1, 10**decades)), ax=axes)
        style.lay_out(figure, 300)
    assert (len(axes.xaxis.get_minorticklocs()) > 0) == on_axes
    assert (len(bar.ax.yaxis.get_minorticklocs()) > 0) == on_bar


def test_pictures_in_a_pdf(tmp_path):
    """A rasterised artist is a bitmap in the PDF too, at its position; the other artists remain
    lines and text.
    """
    with style.style():
        figure = style.new_figure(2.0)
        figure.subplots().pcolormesh(np.eye(3), rasterized=True)
        one = style.contents(style.Drawing(figure, {}))
    assert one[".pdf"].count(b"/Subtype /Image") == 1
    assert len(fonts(one[".pdf"])) == 1
