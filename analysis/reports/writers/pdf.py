"""Report as PDF, A4 landscape, without a browser; wide tables are split, and each part repeats the key columns."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from xml.sax.saxutils import escape

import matplotlib as mpl
from reportlab.lib.colors import HexColor
from reportlab.lib.pagesizes import A4, landscape
from reportlab.lib.styles import ParagraphStyle
from reportlab.lib.units import mm
from reportlab.pdfbase import pdfmetrics
from reportlab.pdfbase.ttfonts import TTFont
from reportlab.pdfgen.canvas import Canvas
from reportlab.platypus import CondPageBreak, Flowable, Image, KeepTogether, Paragraph, SimpleDocTemplate, Spacer
from reportlab.platypus import Table as Grid

from granwave.analysis.document.model import Beside, Block, Cell, Column, Figure, Gallery, Group, Note, Report, Table

_REGULAR, _BOLD = "GranwaveSans", "GranwaveSans-Bold"
_FILES = {_REGULAR: "DejaVuSans.ttf", _BOLD: "DejaVuSans-Bold.ttf"}  # come with matplotlib
_PAGE = landscape(A4)
_MARGIN = 14 * mm
_WIDTH, _HEIGHT = _PAGE[0] - 2 * _MARGIN, _PAGE[1] - 2 * _MARGIN
_TEXT, _SMALL = 9.0, 6.5  # font sizes of text and of tables, points
_PAD = 3.5  # padding of the text of a cell, points
_CELL = (9 * mm, 52 * mm)  # narrowest and widest column; columns are wider only if there is space
_LONGEST = 400  # characters of a cell
_ACROSS = 3  # figures in a row
_FIGURE_HEIGHT = 95 * mm
_GAP = 6 * mm
_ROOM = 35 * mm  # height below a heading that keeps it on the page

_INK, _SOFT, _LINE, _WASH = (HexColor(c) for c in ("#1d2328", "#5a6570", "#d5dbe0", "#f4f6f8"))
_TONES = {"good": HexColor("#146c3f"), "note": HexColor("#8a5300"), "bad": HexColor("#a8201a")}
_GROUNDS = {"good": HexColor("#eef6f1"), "note": HexColor("#fdf6ea"), "bad": HexColor("#fcefee")}
_GRID = (
    ("LINEBELOW", (0, 0), (-1, -1), 0.4, _LINE),
    ("VALIGN", (0, 0), (-1, -1), "TOP"),
    ("LEFTPADDING", (0, 0), (-1, -1), _PAD),
    ("RIGHTPADDING", (0, 0), (-1, -1), _PAD),
    ("TOPPADDING", (0, 0), (-1, -1), _PAD / 2.5),
    ("BOTTOMPADDING", (0, 0), (-1, -1), _PAD / 2.5),
)


def pdf_file(report: Report) -> bytes:
    """Return the PDF; it has no date, so that equal reports give equal bytes."""
    _fonts()
    stream = io.BytesIO()
    document = SimpleDocTemplate(
        stream,
        pagesize=_PAGE,
        leftMargin=_MARGIN,
        rightMargin=_MARGIN,
        topMargin=_MARGIN,
        bottomMargin=_MARGIN,
        title=report.title,
        author="granwave",
        creator="granwave",
        invariant=1,
    )
    document.build(list(_story(report)), onFirstPage=_number, onLaterPages=_number)
    return stream.getvalue()


@cache
def _fonts() -> None:
    folder = Path(mpl.get_data_path()) / "fonts" / "ttf"
    for name, file in _FILES.items():
        pdfmetrics.registerFont(TTFont(name, folder / file))
    pdfmetrics.registerFontFamily(_REGULAR, normal=_REGULAR, bold=_BOLD, italic=_REGULAR, boldItalic=_BOLD)


def _style(size: float = _TEXT, *, bold: bool = False, **more: object) -> ParagraphStyle:
    font = _BOLD if bold else _REGULAR
    options = {"leading": 1.3 * size, "textColor": _INK, "splitLongWords": 1} | more
    return ParagraphStyle("", fontName=font, fontSize=size, **options)


def _number(canvas: Canvas, document: SimpleDocTemplate) -> None:
    canvas.setFont(_REGULAR, 7)
    canvas.setFillColor(_SOFT)
    canvas.drawString(_MARGIN, 7 * mm, _cut(document.title, 120))
    canvas.drawRightString(_PAGE[0] - _MARGIN, 7 * mm, str(document.page))


def _story(report: Report) -> Iterator[Flowable]:
    yield Paragraph(escape(_cut(report.title)), _style(18, bold=True, spaceAfter=4))
    yield Paragraph(escape(report.lead), _style(textColor=_SOFT, spaceAfter=4))
    for section in report.sections:
        yield CondPageBreak(_room(section.blocks))
        yield Paragraph(escape(section.title), _style(13, bold=True, spaceBefore=14, spaceAfter=5))
        for block in section.blocks:
            yield from _block(block)


def _block(block: Block) -> Iterator[Flowable]:
    if isinstance(block, Note):
        yield _note(block)
    elif isinstance(block, Table):
        yield from _tables(block)
    elif isinstance(block, Gallery):
        yield from _gallery(block.figures)
    elif isinstance(block, Beside):
        yield from _block(block.gallery)
        yield from _block(block.table)
    elif isinstance(block, Group):
        yield CondPageBreak(_room(block.blocks))
        yield Paragraph(escape(_cut(block.title)), _style(10, bold=True, spaceBefore=8, spaceAfter=4))
        for part in block.blocks:
            yield from _block(part)


def _room(blocks: Sequence[Block]) -> float:
    """Return the height that a heading and the start of its content need."""
    if isinstance(blocks[0], Group):
        return 10 * mm + _room(blocks[0].blocks)
    return _FIGURE_HEIGHT + 20 * mm if isinstance(blocks[0], Gallery | Beside) else _ROOM


def _note(note: Note) -> Flowable:
    text = " ".join([note.text, ", ".join(link.text for link in note.links)]).strip()
    if note.tone == "lead":
        return Paragraph(escape(text), _style(11, bold=True, spaceAfter=6))
    if not note.tone:
        return Paragraph(escape(text), _style(textColor=_SOFT, spaceAfter=4))
    colour, ground = _TONES[note.tone], _GROUNDS[note.tone]
    style = _style(
        textColor=colour, backColor=ground, borderPadding=(3, 5, 3, 5), spaceBefore=5, spaceAfter=7, leftIndent=5,
        rightIndent=5, bold=note.tone == "bad",
    )  # fmt: skip
    return Paragraph(escape(text), style)


def _tables(table: Table) -> Iterator[Flowable]:
    wanted = [_width(column, [row[n] for row in table.rows]) for n, column in enumerate(table.columns)]
    widths = [min(width, _CELL[1]) for width in wanted]
    for part, columns in enumerate(_parts(table.columns, widths)):
        head = [_head(table.columns[n]) for n in columns]
        rows = [head, *([_cell(row[n], table.columns[n]) for n in columns] for row in table.rows)]
        style = list(_GRID)
        first = 0
        if part or table.captioned:
            caption = _cut(table.caption) + (", continued" if part else "")
            rows.insert(0, [Paragraph(escape(caption), _style(8, bold=True)), *[""] * (len(columns) - 1)])
            style += [("SPAN", (0, 0), (-1, 0)), ("LINEBELOW", (0, 0), (-1, 0), 0, _WASH)]
            first = 1
        style += [("BACKGROUND", (0, first), (-1, first), _WASH), ("VALIGN", (0, first), (-1, first), "BOTTOM")]
        fitted = _fitted([widths[n] for n in columns], [wanted[n] for n in columns])
        yield Grid(rows, colWidths=fitted, repeatRows=first + 1, hAlign="LEFT", style=style, spaceBefore=4)
        yield Spacer(1, 8)


def _parts(columns: Sequence[Column], widths: Sequence[float]) -> list[list[int]]:
    """Split columns into parts that fit the page; return their indices, key columns first in every part."""
    keys = [n for n, column in enumerate(columns) if column.key]
    if sum(widths[n] for n in keys) > _WIDTH / 2:
        keys = keys[:1]
    parts, part = [], list(keys)
    for n in range(len(columns)):
        if n in keys:
            continue
        if len(part) > len(keys) and sum(widths[m] for m in part) + widths[n] > _WIDTH:
            parts.append(part)
            part = list(keys)
        part.append(n)
    return [*parts, part]


def _width(column: Column, cells: Sequence[Cell]) -> float:
    words = [word for word in f"{column.heading} {column.unit}".split()]
    longest = max([_length(word, _BOLD) for word in words] + [_length(cell.text, _REGULAR) for cell in cells])
    return max(longest + 2 * _PAD + 1, _CELL[0])


def _length(text: str, font: str) -> float:
    return max((pdfmetrics.stringWidth(_cut(line), font, _SMALL) for line in text.split("\n")), default=0.0)


def _fitted(widths: Sequence[float], wanted: Sequence[float]) -> list[float]:
    """Fit widths to the page: enlarge them up to ``wanted`` if there is space, or else reduce them in proportion."""
    total, missing = sum(widths), sum(wanted) - sum(widths)
    if total >= _WIDTH or not missing:
        return [width * min(1.0, _WIDTH / total) for width in widths]
    share = min(1.0, (_WIDTH - total) / missing)
    return [width + share * (more - width) for width, more in zip(widths, wanted, strict=True)]


def _head(column: Column) -> Paragraph:
    unit = f"<br/>{escape(column.unit)}" if column.unit else ""
    return Paragraph(f"<b>{escape(column.heading)}</b>{unit}", _aligned(column))


def _cell(cell: Cell, column: Column) -> Paragraph:
    text = escape(_cut(cell.text)).replace("\n", "<br/>")
    if cell.tone in _TONES:
        text = f'<font color="{_TONES[cell.tone].hexval().replace("0x", "#")}">{text}</font>'
    return Paragraph(text, _aligned(column))


@cache
def _aligned(column: Column) -> ParagraphStyle:
    return _style(_SMALL, alignment=2 if column.numeric else 0)


def _gallery(figures: Sequence[Figure]) -> Iterator[Flowable]:
    """Arrange pictures in rows, wide ones after the others and in fewer columns."""
    yield from _rows([figure for figure in figures if not figure.wide], _ACROSS)
    yield from _rows([figure for figure in figures if figure.wide], _ACROSS - 1)


def _rows(figures: Sequence[Figure], most: int) -> Iterator[Flowable]:
    across = min(most, max(len(figures), 2))
    width = (_WIDTH - (across - 1) * _GAP) / across
    for start in range(0, len(figures), across):
        row = figures[start : start + across]
        cells = [[_picture(figure, width), _caption(figure)] for figure in row]
        grid = Grid([cells], colWidths=[width + _GAP] * len(cells), hAlign="LEFT")
        grid.setStyle(
            [
                ("VALIGN", (0, 0), (-1, -1), "TOP"),
                ("LEFTPADDING", (0, 0), (-1, -1), 0),
                ("RIGHTPADDING", (0, 0), (-1, -1), _GAP),
            ]
        )
        yield KeepTogether([grid])


def _picture(figure: Figure, width: float) -> Image:
    scale = min(width / figure.size[0], _FIGURE_HEIGHT / figure.size[1])
    return Image(io.BytesIO(figure.png), figure.size[0] * scale, figure.size[1] * scale, hAlign="CENTER")


def _caption(figure: Figure) -> Paragraph:
    data = f'<br/><font color="#5a6570">Data: {escape(_cut(figure.data.text))}</font>' if figure.data else ""
    return Paragraph(escape(_cut(figure.caption)) + data, _style(7, alignment=1, spaceBefore=2))


def _cut(text: str, longest: int = _LONGEST) -> str:
    return text if len(text) <= longest else text[: longest - 1] + "…"
