"""Section of figures: reduced images of runs and scans."""

from __future__ import annotations

import io
import re
from collections.abc import Collection
from itertools import chain
from pathlib import Path

from PIL import Image

from granwave.analysis.document.model import (
    Block,
    DocumentSection,
    Figure,
    Gallery,
    Group,
    Link,
    Note,
)
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.figures.style import Drawing, FigureFolder, lay_out
from granwave.analysis.formatting.values import as_label, grains_called_in
from granwave.analysis.quantities import readable
from granwave.analysis.reports.inputs import ReportInputs, ReportScan
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.keys import key_of
from granwave.lammps_inputs.case.figures import FILM_FORMATS
from granwave.lammps_inputs.errors import GranwaveError
from granwave.lammps_inputs.packing.cylinders import in_grains
from granwave.lammps_inputs.run_directory import (
    FIGURES_DIRECTORY,
    FILM_FILE,
    VIEW_FILE,
)

SLUG = "figures"
#: Dots per inch at which a page shows figures that take a whole row: their letters are as large as the page's.
RESOLUTION = 150
# largest width of images of runs and scans, and of points of scans, pixels
WIDTH = 900
POINT_WIDTH = 600
WIDEST = 1200  # largest width of images that fill a row, pixels
POINTS_BUDGET = 8_000_000  # most bytes of all images of points; further images are only linked
MOST_DATA = 60_000  # most bytes of a figure's table on the page; larger tables are linked
_COLOURS = 256

_OF_SCANS = {  # captions
    "collapse_dissipated_fraction": (
        "Dissipated fraction against normalised velocity, of all materials. Where similarity holds, all points lie on "
        "one curve"
    ),
    "collapse_plastic_volume": (
        "Plastic zone against normalised input energy, of all materials. Where similarity holds, all points lie on one "
        "curve"
    ),
    "dissipated_fraction_map": (
        "Dissipated fraction against both varied keys. If colours change only along one axis, the "
        "other key has little effect"
    ),
}
_QUANTITIES = {  # captions of figures of scans that do not follow from the name
    "plastic_zone_depth": "Depth of the plastic zone",
    "plastic_spheres": "Yielded spheres",
    "bottom_peak_force": "Peak force on the bottom",
    "zone_depth_90": "90 % depth of the plastic dissipation, interpolated between layers",
    "zone_radius_90": "90 % radius of the plastic dissipation, interpolated between spheres",
    "zone_volume_90": "90 % volume of the plastic dissipation",
}
_UNREADABLE = (OSError, ValueError, SyntaxError, Image.DecompressionBombError)
_AGAINST = "_vs_"  # between quantity and key in names of figures of scans


def figures_section(
    inputs: ReportInputs, above: Collection[str] = (), shown: Collection[Path] = ()
) -> DocumentSection:
    """Make the section of the report.

    Parameters
    ----------
    above
        Names of figures in other sections; scans also store the figures of their studies.
    shown
        Paths of figures in other sections, without a suffix.
    """
    blocks: list[Block] = []
    n_items = len(inputs.items)
    for number, item in enumerate(inputs.items, start=1):
        what = "scan" if isinstance(item, ReportScan) else "run"
        left_out = {
            path.stem for path in shown if path.parent == item.directory / FIGURES_DIRECTORY
        }
        left_out |= (
            set(above) if isinstance(item, ReportScan) else item.kind.figures_of_others(item)
        )
        parts = _pictures(
            item, inputs, f"{number}-{item.label}", f"{what} {item.label}", WIDTH, left_out
        )
        if parts:
            title = f"Figures of {what} {item.label}"
            folded = n_items > 2 and isinstance(item, ReportRun)
            blocks += parts if n_items == 1 else [Group(title, parts, folded=folded)]
        if isinstance(item, ReportScan):
            blocks += _points(item, inputs, number)
    if not blocks and not shown:
        blocks.append(Note("No figures."))
    return DocumentSection("Figures", SLUG, tuple(blocks))


def views(inputs: ReportInputs) -> tuple[Note, ...]:
    """Return a note with links to the 3-D views of the runs that have one."""
    files = {run.label: run.directory / VIEW_FILE for run in inputs.runs}
    links = [
        inputs.link(path, f"3-D view of {label}") for label, path in files.items() if path.is_file()
    ]
    return (Note("Rotate and cut it in a browser:", links=tuple(links)),) if links else ()


def picture_in(item: ReportRun | ReportScan, name: str, inputs: ReportInputs) -> Figure | None:
    """Return a figure of a run or scan by name; None if it is missing or damaged."""
    path = item.directory / FIGURES_DIRECTORY / f"{name}.png"
    try:
        return _picture(path, item, inputs, f"answer-{item.label}", item.label, WIDTH)
    except _UNREADABLE:  # or missing
        return None


def picture_of(drawing: Drawing, name: str, caption: str, data: Link | None = None) -> Figure:
    """A figure as an image; its caption is also its alternative text."""
    lay_out(drawing.figure, RESOLUTION)
    stream = io.BytesIO()
    drawing.figure.savefig(stream, format="png", dpi=RESOLUTION, metadata={"Software": None})
    with Image.open(io.BytesIO(stream.getvalue())) as image:
        size = image.size
    return Figure(
        name, caption, caption, stream.getvalue(), size, data, drawing.figure.get_figwidth()
    )


def shrunk(path: Path, width: int) -> tuple[bytes, tuple[int, int], float]:
    """Reduce an image to a PNG with at most 256 colours; return it with its size in pixels and its
    width in inches.

    Parameters
    ----------
    width
        Largest width in pixels; wide figures, which fill a row, may have more.

    Raises
    ------
    OSError, ValueError, SyntaxError
        The file is not an image.
    """
    with Image.open(path) as found:
        image = Image.new("RGB", found.size, "white")
        image.paste(found, mask=found.getchannel("A") if "A" in found.getbands() else None)
        dots = float(found.info.get("dpi", (0.0, 0.0))[0])
    inches = image.width / dots if dots > 0 else 0.0
    if Figure("", "", "", b"", image.size, inches=inches).wide:
        width = max(width, min(round(RESOLUTION * inches), WIDEST))
    if image.width > width:
        image = image.resize(
            (width, max(1, round(image.height * width / image.width))), Image.Resampling.LANCZOS
        )
    image = image.quantize(_COLOURS, method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    stream = io.BytesIO()
    image.save(stream, "PNG", optimize=True)
    return stream.getvalue(), image.size, inches


def _captions(item: ReportRun | ReportScan) -> dict[str, str]:
    """Return the captions of figures by name, in the order of a report."""
    captions = {name: figure.caption for name, figure in run_figures().items()}
    if isinstance(item, ReportRun):
        captions |= item.kind.captions
    return captions | _OF_SCANS


def _look(item: ReportRun | ReportScan, name: str) -> str:
    """Return the main feature of a figure; empty if its caption is sufficient."""
    if isinstance(item, ReportRun) and name in item.kind.looks:
        return item.kind.looks[name]
    return run_figures()[name].look if name in run_figures() else ""


def _words_of_run(item: ReportRun | ReportScan, name: str, table: Path) -> tuple[str, str] | None:
    """Return caption and look of a figure of a run that depend on the run; None for other figures,
    and if the result or the table of the figure cannot be read.
    """
    figure = run_figures().get(name)
    if figure is None or figure.words is None or not isinstance(item, ReportRun):
        return None
    try:
        with Result(item.results) as result:
            return figure.words(result, table)
    except (GranwaveError, OSError, KeyError, ValueError, IndexError):
        return None


def _caption(item: ReportRun | ReportScan, stem: str, *, in_words: bool) -> tuple[str, str]:
    """Return the caption of a figure from the name of its file, and, ``in_words``, from the
    quantity and the key of a figure of a scan.
    """
    captions = _captions(item)
    if stem in captions:
        return captions[stem], ""
    what, against, key = stem.partition(_AGAINST)
    if not against:
        return readable(stem), ""
    labels = {}
    said = ""
    if isinstance(item, ReportScan):
        columns = {
            name: [point.result.labels.get(name, "") for point in item.points]
            for name in item.source.varied
        }
        keys = [key_of(name, column) for name, column in columns.items()]
        labels = {one.slug: one.label for one in keys}
        shown = item.means.figures.get(what, "")
        if in_words and len(item.means.known_rows(shown)) > 1:
            said = f": {item.means.range_in_words(shown)}"
    quantity = _QUANTITIES.get(what, readable(what))
    comma = "," if "," in quantity else ""
    return f"{quantity}{comma} against {labels.get(key, readable(key).lower())}", said


def _points(scan: ReportScan, inputs: ReportInputs, number: int) -> list[Block]:
    """Return the pictures of the points of a scan, in folded groups, up to `POINTS_BUDGET`."""
    blocks: list[Block] = []
    left = []
    size = 0
    seen = {run.directory.resolve() for run in inputs.runs}
    for point in scan.points:
        run = point.run
        if (
            run is None
            or run.directory.resolve() in seen
            or not any((run.directory / FIGURES_DIRECTORY).glob("*.png"))
        ):
            continue
        seen.add(run.directory.resolve())
        if size > POINTS_BUDGET:
            left.append(inputs.link(run.directory / FIGURES_DIRECTORY, f"#{point.result.number}"))
            continue
        name = f"{number}-{scan.label}-{point.result.number}"
        parts = _pictures(run, inputs, name, f"run {run.label}", POINT_WIDTH)
        galleries = (part.figures for part in parts if isinstance(part, Gallery))
        size += sum(len(figure.png) for figure in chain.from_iterable(galleries))
        labels = ", ".join(
            f"{key} = {as_label(value)}" for key, value in point.result.labels.items()
        )
        title = f"Point {point.result.number} of {scan.label}" + (f": {labels}" if labels else "")
        blocks.append(Group(title, parts, folded=True))
    if left:
        blocks.append(
            Note("The figures of further points are in their directories:", links=tuple(left))
        )
    return blocks


def _pictures(
    item: ReportRun | ReportScan,
    inputs: ReportInputs,
    name: str,
    what: str,
    width: int,
    left_out: Collection[str] = (),
) -> tuple[Gallery | Note, ...]:
    """Return animations and PNG figures of a run or scan, in the order of the figures of a run,
    then by name.
    """
    order = list(_captions(item))
    paths = sorted(
        (item.directory / FIGURES_DIRECTORY).glob("*.png"),
        key=lambda path: (order.index(path.stem) if path.stem in order else len(order), path.name),
    )
    figures = []
    damaged = []
    for path in (path for path in paths if path.stem not in left_out):
        try:
            figures.append(_picture(path, item, inputs, name, what, width, in_words=True))
        except _UNREADABLE as error:
            why = (str(error).splitlines() or [type(error).__name__])[0].split(": ")[0]
            damaged.append(Note(f"{inputs.path(path)} cannot be shown: {why}", "note"))
    there = [(FILM_FILE.format(form), "Film:") for form in FILM_FORMATS]
    there = [
        one for one in there if isinstance(item, ReportRun) and (item.directory / one[0]).is_file()
    ]
    pages = [Note(text, links=(inputs.link(item.directory / name, name),)) for name, text in there]
    gallery = [Gallery(tuple(figures))] if figures else []
    failed = [Note(f"The {one}.", "bad") for one in FigureFolder(item.results).not_drawn().values()]
    return (*pages, *gallery, *damaged, *failed)


def _picture(
    path: Path,
    item: ReportRun | ReportScan,
    inputs: ReportInputs,
    name: str,
    what: str,
    width: int,
    *,
    in_words: bool = False,
) -> Figure:
    """Return a reduced picture, with its data; raise as `shrunk`.

    Parameters
    ----------
    item
        Run or scan that it is of; ``name`` and ``what``: its name in those of files, and in
        captions.
    in_words
        True to say after the caption what a figure of a scan shows.
    """
    png, size, inches = shrunk(path, width)
    runs = (
        [item] if isinstance(item, ReportRun) else [point.run for point in item.points if point.run]
    )
    called = grains_called_in(run.summary for run in runs)
    data = path.with_suffix(".csv")
    caption, said = _caption(item, path.stem, in_words=in_words)
    look = _look(item, path.stem)
    if own := _words_of_run(item, path.stem, data):
        caption, look = own
    caption = in_grains(caption, called)
    look = in_grains(look, called)
    link = inputs.link(data, f"{FIGURES_DIRECTORY}/{data.name}") if data.is_file() else None
    alone = len(inputs.items) == 1 and path.parent.parent == inputs.items[0].directory
    alt = f"{caption}: {what}"
    shown = (caption if alone else alt) + (f". {look}" if look else "") + said
    slug = re.sub(r"[^a-z0-9]+", "-", f"{name}-{path.stem}".lower()).strip("-")
    return Figure(slug, shown, alt, png, size, link, inches, _data_of(data) if link else b"")


def _data_of(path: Path) -> bytes:
    """Return the table of a figure for the page; empty if it is large, or cannot be read."""
    try:
        return path.read_bytes() if path.stat().st_size <= MOST_DATA else b""
    except OSError:
        return b""
