"""Animation of a run, from its ``result.h5``: a frame for every instant, with a clock and one
colour scale.
"""

from __future__ import annotations

import contextlib
import errno
import os
import re
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import NDArray
from PIL import Image

from granwave.analysis.errors import did_you_mean
from granwave.analysis.figures import sections
from granwave.analysis.figures.colouring import (
    DISSIPATION_LIMITS,
    Colouring,
    colour_bar,
    decades_up_to,
    disc_colours,
    force_scale,
)
from granwave.analysis.figures.force_map import space_time_map
from granwave.analysis.figures.grain_discs import disc_radii, draw_discs
from granwave.analysis.figures.style import (
    BLUE,
    DISSIPATION_MAP,
    FORCE_MAP,
    GREY,
    WIDTH,
    new_figure,
    style,
)
from granwave.analysis.measures.geometry import SpheresOnPlane as PlaneSection
from granwave.analysis.result.reader import Result
from granwave.extensions.pictures.packing3d import bar_location, draw_packing, packing_pixels
from granwave.lammps_inputs.case.figures import Figures
from granwave.lammps_inputs.directories import refuse_other_file
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replacing

_MICRO = 1e6
_MILLI = 1e3
_DECADES = 3.0  # decades of the forces of a chain
_MOST_INSTANTS = 120  # most instants of a chain, which has up to a thousand
_WHITE = 255


#: Content of an animation: values of the spheres at a snapshot, label of the colour bar, and colour
#: map.
QUANTITIES: Mapping[str, tuple[Callable[[Result, int], NDArray[np.float64]], str, str]] = {
    "force": (
        lambda result, number: result.frame(number, "contact_force") / force_scale(result)[0],
        "Contact force",
        FORCE_MAP,
    ),
    "velocity": (
        lambda result, number: np.linalg.norm(result.frame(number, "velocity"), axis=1), "Speed (m/s)", FORCE_MAP
    ),
    "dissipation": (
        lambda result, number: result.frame(number, "dissipated_energy") / result.energy_input,
        r"Dissipation $e_\mathrm{dis}/e_\mathrm{in}$",
        DISSIPATION_MAP,
    ),
}  # fmt: skip
PLANES = ("principal", "orthogonal", "section")  # chains of touching spheres are in the first
VIEWS = (*PLANES, "3d", "chain")


@dataclass(frozen=True, eq=False)
class Scene:
    """Frames of a run in time: one figure in which some artists change.

    Attributes
    ----------
    times
        Instants, s: (n,).
    figure
        The figure.
    moving
        The artists that change, from back to front.
    show
        Function that sets them to the instant with a number.
    """

    times: NDArray[np.float64]
    figure: Figure
    moving: Sequence[Artist]
    show: Callable[[int], None]

    def draw(self, number: int) -> Figure:
        """Return the figure at the instant with this number."""
        self.show(number)
        return self.figure


Size = tuple[float, float] | None  # width and height, inches


def scene(result: Result, quantity: str, view: str | None, size: Size = None) -> Scene:
    """Return the scene of a run.

    Parameters
    ----------
    quantity
        One of `QUANTITIES`; chains show forces.
    view
        One of `VIEWS`; None for the chain in space-time, or the first plane of the packing.
    size
        Width and height of the frames, inches; by default a column, with the height of the view.

    Raises
    ------
    InputError
        The run has no such view, or nothing of this quantity.
    """
    if view == "chain" or (view is None and "chain" in result):
        return _of_chain(result, size)
    if view == "3d":
        return _of_packing(result, quantity, size)
    for name in PLANES if view is None else (view,):
        if (found := sections.cut_of(result, name)) is not None:
            return _of_section(result, quantity, found, size)
    if view == "section" and result.figure_options.plane is None:
        raise InputError(
            "--view section: requires a plane; set --plane, or figures.plane in the case"
        )
    kinds = "no plane of spheres" if view is None else f"no {view} plane"
    raise InputError(
        f"{result.case.name}: a {result.case.packing.kind} packing has {kinds}; use --view 3d or "
        "chain"
    )


def _colourings(result: Result, quantity: str, rows: NDArray[np.intp] | slice) -> list[Colouring]:
    """Return the colouring of every snapshot, on one scale."""
    value_of, label, usual_map = QUANTITIES[quantity]
    values = [value_of(result, number) for number in range(len(result.frame_times))]
    largest = max(float(np.max(one[rows], initial=0.0)) for one in values)
    if not largest > 0:
        raise InputError(
            f"{result.case.name}: no snapshot contains {quantity}; use another --quantity"
        )
    options = result.figure_options
    low, high = decades_up_to(largest, None)
    if quantity == "dissipation":
        low, high = options.dissipation_limits or (
            DISSIPATION_LIMITS[0],
            max(DISSIPATION_LIMITS[1], largest),
        )
    elif quantity == "force":
        low, high = options.force_limits or (low, high)
    colours = options.colour_map or usual_map
    label += f" {force_scale(result)[1]}" if quantity == "force" else ""
    return [Colouring(one, label, quantity, colours, low, high) for one in values]


def _figure(height: float, size: Size) -> Figure:
    figure = new_figure(height)
    if size is not None:
        figure.set_size_inches(size)
    return figure


def _clock(figure: Figure) -> Text:
    return figure.text(0.98, 0.985, "", ha="right", va="top", fontsize=9)


def _reading(time: float) -> str:
    """Return the text of the clock at a time, s."""
    return f"{time * _MICRO:.0f} µs"


def _of_section(result: Result, quantity: str, cut: PlaneSection, size: Size) -> Scene:
    """Return the scene of a plane: its spheres as discs."""
    colourings = _colourings(result, quantity, cut.index)
    first = colourings[0]
    reached = np.max([one.values[cut.index] for one in colourings], axis=0) >= first.low
    window = sections.window_around(cut, reached, result.case.packing.diameter)
    left, right, top, bottom = window
    height = (WIDTH - 0.6) * (bottom - top) / (right - left) + 1.2
    figure = _figure(min(max(height, 2.1), 6.0), size)
    axes = figure.subplots()
    radii = disc_radii(result, cut)
    discs = draw_discs(axes, cut, first.values[cut.index], first, radii)
    sections.frame_axes(axes, window)
    axes.set_xlabel(f"{'x' if cut.plane.down_label == 'y' else cut.plane.across_label} (mm)")
    axes.set_ylabel(f"{cut.plane.down_label} (mm)")
    axes.set_title(" ", fontsize=9)  # room for the clock
    ends = np.array([0.0, first.low, first.high])  # white grains in some snapshot
    colour_bar(figure, [axes], first, ends, bar_location(size))
    clock = _clock(figure)

    def show(number: int) -> None:
        colouring = colourings[number]
        faces, edges = disc_colours(colouring.values[cut.index], colouring)
        discs.set(facecolor=faces, edgecolor=edges)
        clock.set_text(_reading(float(result.frame_times[number])))

    return Scene(result.frame_times, figure, (discs, clock), show)


def _of_packing(result: Result, quantity: str, size: Size) -> Scene:
    """Return the scene of the cut packing."""
    colourings = _colourings(result, quantity, slice(None))
    drawing = draw_packing(result, colourings[0], size)
    if drawing is None:
        raise InputError(
            f"{result.case.name}: the packing cannot be cut open; use --view chain, or a plane"
        )
    figure = drawing.figure
    (image,) = figure.axes[0].images
    clock = _clock(figure)

    def show(number: int) -> None:
        image.set_data(packing_pixels(result, colourings[number]))
        clock.set_text(_reading(float(result.frame_times[number])))

    return Scene(result.frame_times, figure, (image, clock), show)


def _of_chain(result: Result, size: Size) -> Scene:
    """Return the scene of a chain: present forces and largest forces so far, above the map of all
    forces until now.
    """
    if "chain" not in result:
        raise InputError(
            f"{result.case.name}: no record of a chain in time; --view chain is for chains of five beads and more "
            "(output.history)"
        )
    times = result["chain/time"]
    force = result["chain/contact_force"]
    place = result["chain/contact_position"] * _MILLI
    largest = float(np.max(force, initial=0.0))
    if not largest > 0:
        raise InputError(
            f"{result.case.name}: no contact carried a force, so there is nothing to show"
        )
    rows = np.unique(
        np.linspace(0, len(times) - 1, min(_MOST_INSTANTS, len(times))).round().astype(int)
    )
    colours = result.figure_options.colour_map or FORCE_MAP
    figure = _figure(4.2, size)
    now, map_axes = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1.3))
    norm = LogNorm(10**-_DECADES * largest, largest)
    so_far = now.fill_between(place, force[0], color="0.85", linewidth=0)
    (present,) = now.plot(place, force[0], color=BLUE)
    now.set(ylim=(0, 1.05 * largest), ylabel="Force (N)")
    now.set_title(" ", fontsize=9)
    seen = np.where(force > norm.vmin, force, np.nan)
    image = space_time_map(map_axes, result["chain/contact_position"], times, seen, norm, colours)
    here = map_axes.axhline(times[0] * _MICRO, color=GREY, linewidth=0.6)
    map_axes.set(ylim=(0, times[-1] * _MICRO), ylabel="Time (µs)")
    figure.colorbar(image, ax=map_axes, label="Force (N)")
    clock = _clock(figure)

    def show(number: int) -> None:
        row = rows[number]
        so_far.set_data(place, force[: row + 1].max(axis=0), np.zeros(len(place)))
        present.set_ydata(force[row])
        shown = seen.copy()
        shown[row + 1 :] = np.nan
        image.set_array(shown)
        here.set_ydata([times[row] * _MICRO] * 2)
        clock.set_text(_reading(float(times[row])))

    return Scene(times[rows], figure, (so_far, present, image, here, clock), show)


FORMS = (".mp4", ".gif", ".webp")
_OWN = rb"granwave"  # in the metadata of the files
SIZES = {"slide": (1920, 1080), "page": (1200, 900)}  # pixels
# pixels
USUAL_WIDTH = 1200
LEAST_WIDTH = 100
MOST_WIDTH = 4000
_SECONDS = 6.0  # usual length
# frames per second
_SLOWEST = 3.0
_FASTEST = 25.0
_LAST = 1.5  # s for which the last frame remains


def write_film(
    directory: str | Path,
    path: str | Path,
    *,
    quantity: str = "force",
    view: str | None = None,
    width: int = USUAL_WIDTH,
    size: tuple[int, int] | None = None,
    rate: float | None = None,
    options: Figures | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Write an animation of a run.

    Parameters
    ----------
    directory
        Directory of the run.
    path
        File to write: .mp4, .gif or .webp.
    quantity
        ``force`` (largest contact force of each sphere), ``velocity`` or ``dissipation``.
    view
        ``principal`` or ``orthogonal`` plane, ``section`` (the plane of the options), ``3d``, or
        ``chain`` (forces in space-time); by default that of a chain, or the
        first plane that the packing has.
    width
        Width, pixels; the height follows from the view.
    size
        Width and height, pixels, instead of the width.
    options
        Colours, limits and plane of the case; by default as ``[figures]`` of the case.toml there
        says.
    rate
        Frames per second; by default the animation takes about six seconds.
    progress
        Function called after each frame with its number from 1 and the total number.

    Raises
    ------
    InputError
        Another form, quantity or view; or a file of that name that granwave did not write.
    MissingOutputError, OutputFormatError
        The directory contains no result, or a damaged result.
    """
    path = Path(path)
    _check(path, quantity, view, width, size, rate)
    if not path.absolute().parent.is_dir():
        raise InputError(f"{path}: no such directory: {path.absolute().parent}")
    refuse_other_file(path, _OWN)
    with Result(directory) as result, style():
        if options is not None:
            result.figure_options = options
        # the shorter side is a column, so that texts fit
        inches = (
            None if size is None else (WIDTH * size[0] / min(size), WIDTH * size[1] / min(size))
        )
        found = scene(result, quantity, view, inches)
        n = len(found.times)
        rate = rate or float(np.clip(n / _SECONDS, _SLOWEST, _FASTEST))
        with replacing(path) as scratch:
            _WRITERS[path.suffix.lower()](
                scratch, film_pictures(found, size[0] if size else width, progress), rate
            )
    return path


def size_of(text: str) -> tuple[int, int]:
    """Read the size of an animation: slide, page, or width x height in pixels.

    Raises
    ------
    InputError
        It is none of them.
    """
    if text in SIZES:
        return SIZES[text]
    found = re.fullmatch(r"(\d+)\s*[xX]\s*(\d+)", text)
    size = (int(found[1]), int(found[2])) if found else (0, 0)
    if not all(LEAST_WIDTH <= one <= MOST_WIDTH and one % 2 == 0 for one in size):
        near = "" if found else did_you_mean(text.lower(), SIZES, 0.5)
        hint = f"; {near}" if near else ""
        raise InputError(
            f"--size: found {text}, expected {', '.join(SIZES)}, or width × height in pixels, even numbers from "
            f"{LEAST_WIDTH} to {MOST_WIDTH}, as 1280x720{hint}"
        )
    return size


def _check(
    path: Path,
    quantity: str,
    view: str | None,
    width: int,
    size: tuple[int, int] | None,
    rate: float | None,
) -> None:
    if path.suffix.lower() not in FORMS:
        raise InputError(f"{path}: expected a name that ends in {', '.join(FORMS)}")
    for option, word, known in (
        ("--quantity", quantity, tuple(QUANTITIES)),
        ("--view", view, VIEWS),
    ):
        if word is not None and word not in known:
            near = did_you_mean(word.lower(), known, 0.5)
            hint = f"; {near}" if near else ""
            raise InputError(f"{option}: found {word}, expected one of {', '.join(known)}{hint}")
    if size is None and not LEAST_WIDTH <= width <= MOST_WIDTH:
        raise InputError(f"--width: found {width}, expected {LEAST_WIDTH} to {MOST_WIDTH} pixels")
    if rate is not None and not 0.1 <= rate <= 100:
        raise InputError(f"--rate: found {rate:g}, expected 0.1 to 100 frames per second")


def film_pictures(
    film: Scene, width: int, progress: Callable[[int, int], None] | None = None
) -> Iterator[NDArray[np.uint8]]:
    """Yield the frames in red, green, blue: (height, width, 3), with even width and height as
    required for animations.

    The unchanging parts are drawn once, and overlaid on the changing parts.
    """
    figure = film.draw(0)
    figure.set_dpi(width / figure.get_figwidth())
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # computes the layout
    figure.set_layout_engine("none")
    still = _still(figure, canvas, film.moving)
    renderer = canvas.get_renderer()
    for number in range(len(film.times)):
        film.show(number)
        renderer.clear()
        pixels = np.asarray(renderer.buffer_rgba())
        pixels[:] = _WHITE
        for artist in film.moving:
            artist.draw(renderer)
        picture = Image.fromarray(pixels)
        picture.alpha_composite(still)
        whole = np.asarray(picture)[:, :, :3]
        height, across = (size // 2 * 2 for size in whole.shape[:2])
        yield np.ascontiguousarray(whole[:height, :across])
        if progress is not None:
            progress(number + 1, len(film.times))


def _still(figure: Figure, canvas: FigureCanvasAgg, moving: Sequence[Artist]) -> Image.Image:
    """Return the unchanging parts, on a transparent background."""
    grounds = [figure.patch, *(axes.patch for axes in figure.axes)]
    for artist in (*moving, *grounds):
        artist.set_visible(False)
    canvas.draw()
    still = Image.fromarray(np.asarray(canvas.buffer_rgba()).copy())
    for artist in (*moving, *grounds):
        artist.set_visible(True)
    return still


def _write_mp4(path: Path, pictures: Iterator[NDArray[np.uint8]], rate: float) -> None:
    import imageio_ffmpeg  # brings ffmpeg along

    last = next(pictures)
    read = (
        f"-y -v error -f rawvideo -pix_fmt rgb24 -s {last.shape[1]}x{last.shape[0]} -r {rate} -i -"
    )
    write = "-c:v libx264 -pix_fmt yuv420p -preset medium -crf 20 -metadata comment=granwave -f mp4"
    command = [imageio_ffmpeg.get_ffmpeg_exe(), *read.split(), *write.split(), str(path)]
    # a new session: Ctrl-C reaches this process only
    ffmpeg = subprocess.Popen(
        command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        with contextlib.suppress(BrokenPipeError):  # its exit status shows why it ended
            assert ffmpeg.stdin is not None
            with ffmpeg.stdin as stream:
                stream.write(last.tobytes())
                for last in pictures:
                    stream.write(last.tobytes())
                for _ in range(round(_LAST * rate)):
                    stream.write(last.tobytes())
        status = ffmpeg.wait()
    finally:
        ffmpeg.kill()
        ffmpeg.wait()
    if status:  # a system error has a number below 256
        number = 256 - status if status > 128 else errno.EIO
        raise OSError(number, os.strerror(number), str(path))


def _write_moving(
    path: Path, pictures: Iterator[NDArray[np.uint8]], rate: float, **options: Any
) -> None:
    images = [Image.fromarray(picture) for picture in pictures]
    durations = [round(1000 / rate)] * len(images)
    durations[-1] += round(1000 * _LAST)
    images[0].save(
        path, save_all=True, append_images=images[1:], duration=durations, loop=0, **options
    )


_NOTE = Image.Exif()
_NOTE[0x0131] = "granwave"  # the program that wrote it
_WRITERS: dict[str, Callable[[Path, Iterator[NDArray[np.uint8]], float], None]] = {
    ".mp4": _write_mp4,
    ".gif": partial(_write_moving, format="GIF", optimize=True, comment=b"granwave"),
    ".webp": partial(_write_moving, format="WEBP", quality=85, method=4, exif=_NOTE.tobytes()),
}
