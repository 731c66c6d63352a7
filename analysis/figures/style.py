"""Style of figures, and saving as PNG and PDF with the data as CSV."""

from __future__ import annotations

import io
import logging
import math
import re
import traceback
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from itertools import chain, zip_longest
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import ArrayLike

from granwave.analysis.figures.legends import uncover_curves
from granwave.analysis.figures.scales import least_span, long_times_in_ms, plain_powers
from granwave.analysis.figures.titles import break_long_titles
from granwave.analysis.figures.user_axes import user_figure
from granwave.lammps_inputs.directories import refuse_other_file
from granwave.lammps_inputs.errors import GranwaveError, InputError
from granwave.lammps_inputs.files import replace_bytes, replacing, write_csv_rows
from granwave.lammps_inputs.own_files import AnyPath, figure_files
from granwave.lammps_inputs.packing.cylinders import SPHERES, in_grains
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.lammps_inputs.run_directory import (
    FIGURE_SUFFIXES,
    FIGURES_DIRECTORY,
    NOT_DRAWN_SUFFIX,
)

logger = logging.getLogger(__name__)

WIDTH = 3.4  # inches, one column of a journal
_INCH = 0.0254  # m
_PASSES = 2  # adjustments of the height of a figure to its panels
RESOLUTION = 300  # dots per inch
# compression of PNG files by runs of equal pixels, which are frequent in figures; the default
# settings take twice as long
_COMPRESSION: dict[str, Any] = {"compress_level": 3, "compress_type": zlib.Z_RLE}
_MAKER = "granwave"  # program name in the metadata of images
_METADATA: dict[str, dict[str, Any]] = {
    "pdf": {"CreationDate": None, "Creator": _MAKER},
    "svg": {"Date": None, "Creator": _MAKER},
}
OWN_PICTURES = {
    ".png": rb"tEXtSoftware\x00granwave",
    ".pdf": rb"/Creator \(granwave\)",
}  # values in the files

# Okabe and Ito's colours, which colour-blind readers can distinguish
BLUE = "#0072B2"
ORANGE = "#D55E00"
GREEN = "#009E73"
PURPLE = "#CC79A7"
SKY = "#56B4E9"
GREY = "#767676"
YELLOW = "#F0C000"  # for areas, too pale for lines
FORCE_MAP = "viridis"
BOTH_SIDES_MAP = "RdBu_r"  # discs with values above and below zero; lower values are marked
WAVE_MAP = "cividis"  # maps of values above and below zero, whose ends differ in grey prints
DISSIPATION_MAP = "inferno-to-orange"  # ends below white, which is zero, in grey prints too
_INFERNO = 0.8  # part of inferno with which it begins
DENT_MAP = "cividis"
BLANK = "#dcdcdc"  # spheres without a value

STYLE: dict[Any, Any] = {
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8,
    "hatch.linewidth": 0.5,
    "axes.titlesize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.2,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.width": 0.4,
    "ytick.minor.width": 0.4,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-4, 5),
    "savefig.dpi": RESOLUTION,
    "pdf.fonttype": 42,
    # also read for PDF: otherwise characters such as superscripts add a second font
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "granwave",  # identical files for identical figures
}

_DISSIPATION_COLOURS = mpl.colormaps["inferno"](np.linspace(0.0, _INFERNO, 256))
mpl.colormaps.register(ListedColormap(_DISSIPATION_COLOURS, name=DISSIPATION_MAP), force=True)

Columns = Mapping[str, ArrayLike]
Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class Drawing:
    """Figure with its data.

    Attributes
    ----------
    figure
        Figure of matplotlib.
    columns
        Data: arrays by name, with the unit at the end of the name; shorter ones are padded with
        blanks.
    """

    figure: Figure
    columns: Columns

    def call_grains(self, called: str) -> None:
        """Use the word for the grains in the texts of the figure: spheres, cylinders or grains."""
        if called != SPHERES:
            for text in self.figure.findobj(Text):
                text.set_text(in_grains(text.get_text(), called))


@dataclass(frozen=True)
class NotDrawn:
    """Figure, or part of a study, that could not be made, with the reason."""

    what: str
    reason: str

    def __str__(self) -> str:
        return f"{self.what} could not be made: {self.reason}"


def attempt(what: str, draw: Callable[[], Made]) -> Made | NotDrawn:
    """Draw a figure; if this fails, warn and return the reason, so that the other figures are still
    drawn.
    """
    try:
        return draw()
    except Exception as error:
        return not_made(what, error)


def not_made(what: str, error: Exception, *, file: str | None = None) -> NotDrawn:
    """Warn of a figure or file that could not be made, and return it with the reason.

    Damaged files, full disks and lack of memory affect all figures, and are raised.

    Parameters
    ----------
    file
        File of the user's whose last line in the traceback the reason names; by default the reason
        names the line that raised the error.
    """
    if isinstance(error, GranwaveError | OSError | MemoryError):
        raise error
    frames = traceback.extract_tb(error.__traceback__)
    place = next((frame for frame in reversed(frames) if frame.filename == file), frames[-1])
    reason = f"{type(error).__name__}: {error} ({Path(place.filename).name}, line {place.lineno})"
    not_drawn = NotDrawn(what, " ".join(reason.split()))
    logger.warning("%s", not_drawn)
    return not_drawn


_scale: ContextVar[float] = ContextVar("scale", default=1.0)  # scale of the size of figures


@contextmanager
def style(width: float | None = None) -> Iterator[None]:
    """Apply `STYLE` within a ``with`` block, without changing global settings.

    All other settings are matplotlib's defaults: settings files of the user or the working
    directory change no figure.

    Parameters
    ----------
    width
        Width of figures of one column, m; wider ones grow in proportion. By default `WIDTH`.
    """
    token = _scale.set(1.0 if width is None else width / (WIDTH * _INCH))
    try:
        with mpl.rc_context():
            mpl.rcdefaults()
            mpl.rcParams.update(STYLE)
            yield
    finally:
        _scale.reset(token)


def new_figure(height: float, width: float = WIDTH) -> Figure:
    """Make an empty figure with constrained layout; sizes in inches, for columns of `WIDTH`.

    Within `drawing_into` it is the figure of the user instead.
    """
    own = user_figure()
    if own is not None:
        return cast(Figure, own)
    scale = _scale.get()
    figure = Figure(figsize=(scale * width, scale * height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def trim_height(figure: Figure, panels: Sequence[Axes]) -> None:
    """Reduce the height of a figure by the gaps above and below panels of equal scales, which are
    lower than their places in the layout.

    Figures of the user keep their size.
    """
    if user_figure() is not None:
        return
    engine = figure.get_layout_engine()
    for _ in range(_PASSES):
        assert engine is not None
        engine.execute(figure)
        gaps: dict[int, float] = {}
        for axes in panels:
            place = axes.get_subplotspec()
            assert place is not None
            gap = axes.get_position(original=True).height - axes.get_position().height
            row = place.rowspan.start
            gaps[row] = min(gaps.get(row, gap), gap)
        width, height = figure.get_size_inches()
        figure.set_size_inches(width, height * (1 - sum(gaps.values())))


def legend_above(axes: Axes, ncols: int, **options: Any) -> None:
    """Put the legend above the axes."""
    place: dict[str, Any] = {
        "loc": "lower center",
        "bbox_to_anchor": (0.5, 1.0),
        "columnspacing": 1.0,
    }
    axes.legend(ncols=ncols, **(place | options))


def save(drawing: Drawing, path: Path, *, formats: Sequence[str] = ("pdf",)) -> None:
    """Save a drawing as path.png, path.csv and further formats.

    Parameters
    ----------
    path
        Path without a suffix; its directory must exist. Existing files are replaced.
    formats
        As in `contents`.
    """
    for suffix, content in contents(drawing, formats).items():
        replace_bytes(path.with_name(path.name + suffix), content)


def contents(drawing: Drawing, formats: Sequence[str] = ("pdf",)) -> dict[str, bytes]:
    """Return the contents of the files of a drawing by suffix: .png, .csv and further formats.

    Parameters
    ----------
    formats
        Any of ``pdf`` and ``svg``; each takes as long as the rest.
    """
    lay_out(drawing.figure, RESOLUTION)
    png = io.BytesIO()
    drawing.figure.savefig(
        png, format="png", metadata={"Software": _MAKER}, pil_kwargs=_COMPRESSION
    )
    files = {".png": png.getvalue()}
    for name in formats:
        stream = io.BytesIO()
        with _needed_tables_only():
            drawing.figure.savefig(stream, format=name, metadata=_METADATA[name])
        files[f".{name}"] = stream.getvalue()
    return files | {".csv": _csv(drawing.columns)}


# tables of an embedded TrueType font (ISO 32000-1, 9.9), and the order of its glyphs
_NEEDED = frozenset(
    {"GlyphOrder", "glyf", "head", "hhea", "hmtx", "loca", "maxp", "cvt ", "fpgm", "prep"}
)


@contextmanager
def _needed_tables_only() -> Iterator[None]:
    """Embed fonts without tables for shaping and naming text, which no reader of a PDF needs and
    which take longest. matplotlib has no setting for this, so that the function by which fontTools
    loads a font is replaced meanwhile.
    """
    from fontTools import subset  # imported on demand: slow to load

    load_font = subset.load_font

    def load(*arguments: Any, **options: Any) -> Any:
        font = load_font(*arguments, **options)
        # other fonts, such as fonts with PostScript outlines, are embedded completely
        if "glyf" in font:
            for table in set(font.keys()) - _NEEDED:
                del font[table]
        return font

    subset.load_font = load
    try:
        yield
    finally:
        subset.load_font = load_font


def files_of(
    draw: Callable[[], Drawing | NotDrawn | None], name: str, formats: Sequence[str] = ("pdf",)
) -> dict[str, bytes] | None:
    """Draw a figure; return the contents of its files as `contents`, or the reason why it could not
    be drawn.
    """

    def draw_files() -> dict[str, bytes] | NotDrawn | None:
        drawing = draw()
        return contents(drawing, formats) if isinstance(drawing, Drawing) else drawing

    files = attempt(f"figure {name}", draw_files)
    if isinstance(files, NotDrawn):
        return {NOT_DRAWN_SUFFIX: f"{files.reason}\n".encode()}
    return files


def lay_out(figure: Figure, resolution: float) -> None:
    """Compute the layout once, at a resolution in dots per inch; saving with a layout engine would
    draw twice.

    Powers of ten on logarithmic axes become plain text, and times beyond 5 ms are in ms.
    """
    engine = figure.get_layout_engine()
    if engine is not None:
        least_span(figure)
        plain_powers(figure)
        long_times_in_ms(figure)
        for axes in figure.axes:
            for artist in (axes.patch, *axes.spines.values()):
                artist.set_in_layout(False)  # inside the axes, which the layout leaves free anyway
        figure.dpi = resolution
        engine.execute(figure)
        if break_long_titles(figure):
            engine.execute(figure)
        if uncover_curves(figure):
            engine.execute(figure)
        figure.set_layout_engine(None)


def save_as(path: Path, columns: Columns, draw: Callable[[], Drawing]) -> None:
    """Save a table (.csv), or a figure with its table (.png or .pdf; both are written), under a
    name given by the user.

    Raises
    ------
    InputError
        A file of such a name exists, and granwave did not write it.
    """
    files = [path]
    if path.suffix != ".csv":
        files = [path.with_suffix(suffix) for suffix in FIGURE_SUFFIXES]
    own = {**OWN_PICTURES, ".csv": rb"\A" + re.escape(",".join(columns).encode()) + rb"\n"}
    for file in files:
        refuse_other_file(file, own[file.suffix])
    if path.suffix != ".csv":
        with style():
            save(draw(), path.with_suffix(""))
        return
    with replacing(path) as scratch:
        write_csv(columns, scratch)


class FigureFolder:
    """Folder ``figures`` of a directory of results, which may also hold other files.

    Parameters
    ----------
    directory
        Directory of the results; the folder is created with the first figure.

    Attributes
    ----------
    written
        Paths of the PNG files that were saved.
    """

    def __init__(self, directory: AnyPath) -> None:
        self.results = ResultDirectory.at(directory)
        self.written: list[Path] = []

    def save(
        self, drawing: Drawing | NotDrawn | None, name: str, *, formats: Sequence[str] = ("pdf",)
    ) -> None:
        """Save a drawing as in `save`; if it is None, remove the earlier figure of this name.

        If granwave did not write an existing file of this name, warn and do not save. If a figure
        could not be drawn, the reason is saved instead.
        """
        self.draw(lambda: drawing, name, formats=formats)

    def draw(
        self,
        draw: Callable[[], Drawing | NotDrawn | None],
        name: str,
        *,
        formats: Sequence[str] = ("pdf",),
    ) -> None:
        """Draw a figure and save it."""
        self.place(files_of(draw, name, formats), name)

    def place(self, files: Mapping[str, bytes] | None, name: str) -> None:
        """Save a figure from the contents of its files by suffix, as `contents` returns them."""
        if files is None:
            self.remove(name)
            return
        own = {PurePosixPath(file).suffix: file for file in figure_files(name)}
        self.results.clear([own[suffix] for suffix in own.keys() - files.keys()])
        try:
            self.results.claim([own[suffix] for suffix in files])
        except InputError as error:
            logger.warning("%s: not drawn: %s", name, error)
            return
        (self.results / FIGURES_DIRECTORY).mkdir(exist_ok=True)
        for suffix, content in files.items():
            replace_bytes(self.results / own[suffix], content)
        if ".png" in files:
            self.written.append(self.results / own[".png"])

    def remove(self, *names: str) -> None:
        """Remove earlier figures."""
        self.results.clear(list(chain.from_iterable(map(figure_files, names))))

    def names(self) -> list[str]:
        """Return the names of the figures in the folder, with figures that could not be drawn."""
        return [path.stem for path in self._files() if path.suffix in (".png", NOT_DRAWN_SUFFIX)]

    def not_drawn(self) -> dict[str, NotDrawn]:
        """Return the figures that could not be drawn, by name."""
        paths = [self.results / path for path in self._files() if path.suffix == NOT_DRAWN_SUFFIX]
        reasons = {
            path.stem: path.read_text("utf-8", "replace").strip()
            for path in paths
            if path.is_file()
        }
        return {name: NotDrawn(f"figure {name}", reason) for name, reason in reasons.items()}

    def _files(self) -> list[PurePosixPath]:
        files = [PurePosixPath(name) for name in self.results.marker.files]
        return [path for path in files if str(path.parent) == FIGURES_DIRECTORY]


def write_csv(columns: Columns, path: Path, *, exact: bool = False) -> None:
    """Write columns as CSV with a header; columns may differ in length.

    Parameters
    ----------
    exact
        True for all digits of numbers, so that they are read back unchanged; 10 otherwise.
    """
    path.write_bytes(_csv(columns, exact=exact))


def _csv(columns: Columns, *, exact: bool = False) -> bytes:
    text = io.StringIO()
    cells = zip_longest(*(_texts(values, exact) for values in columns.values()), fillvalue="")
    write_csv_rows(text, chain([columns], cells))
    return text.getvalue().encode("utf-8")


def _texts(values: ArrayLike, exact: bool) -> list[str]:
    array = np.asarray(values)
    if array.dtype.kind != "f":
        return [str(value) for value in array.tolist()]
    return [_number(value, exact) for value in array.tolist()]


def _number(value: float, exact: bool) -> str:
    """Return the text of a number with all digits, or with 10; empty for NaN."""
    if math.isnan(value):
        return ""
    return repr(value) if exact else f"{value:.10g}"
