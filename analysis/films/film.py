"""Film of a run, from its ``result.h5``."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import subprocess
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

from granwave.analysis.errors import did_you_mean
from granwave.analysis.figures.style import WIDTH, style
from granwave.analysis.films.scenes import QUANTITIES, VIEWS, Scene, scene
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.run import Figures
from granwave.lammps_inputs.directories import refuse_other_file
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import replacing

FORMS = (".mp4", ".gif", ".webp")
_OWN = rb"granwave"  # in the notes of the files that are written here
SIZES = {"slide": (1920, 1080), "page": (1200, 900)}  # pixels
USUAL_WIDTH, LEAST_WIDTH, MOST_WIDTH = 1200, 100, 4000  # pixels
_SECONDS = 6.0  # usual length
_SLOWEST, _FASTEST = 3.0, 25.0  # frames per second
_LAST = 1.5  # s that the last picture stays


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
    """Write a film of a run.

    Parameters
    ----------
    directory
        Directory of the run.
    path
        File to write: .mp4, .gif or .webp.
    quantity
        ``force`` (largest contact force of each sphere), ``velocity`` or ``dissipation``.
    view
        ``orthogonal`` or ``principal`` plane, ``section`` (the plane of the options), ``3d``, or ``chain`` (forces in
        space-time); by default what the packing has.
    width
        Width, pixels; the height follows from the view.
    size
        Width and height, pixels, in place of the width.
    options
        Colours, limits and plane of the case; by default as ``[figures]`` of the case.toml there says.
    rate
        Pictures per second; by default the film takes some six seconds.
    progress
        Function called after each picture with its number from 1 and that of all.

    Raises
    ------
    InputError
        Another form, quantity or view; or a file of that name that granwave did not write.
    MissingOutputError, OutputFormatError
        The directory holds no result, or a damaged one.
    """
    path = Path(path)
    _check(path, quantity, view, width, size, rate)
    if not path.absolute().parent.is_dir():
        raise InputError(f"-o {path}: there is no directory {path.absolute().parent}")
    refuse_other_file(path, _OWN)
    with Result(directory) as result, style():
        if options is not None:
            result.figure_options = options
        # the shorter side is a column, so that texts fit
        inches = None if size is None else (WIDTH * size[0] / min(size), WIDTH * size[1] / min(size))
        found = scene(result, quantity, view, inches)
        n = len(found.times)
        rate = rate or float(np.clip(n / _SECONDS, _SLOWEST, _FASTEST))
        with replacing(path) as scratch:
            _WRITERS[path.suffix.lower()](scratch, _pictures(found, size[0] if size else width, progress), rate)
    return path


def size_of(text: str) -> tuple[int, int]:
    """Read the size of a film: slide, page, or width x height in pixels.

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
            f"--size: found {text}, expected {', '.join(SIZES)}, or width x height in pixels, even numbers from "
            f"{LEAST_WIDTH} to {MOST_WIDTH}, as 1280x720{hint}"
        )
    return size


def _check(
    path: Path, quantity: str, view: str | None, width: int, size: tuple[int, int] | None, rate: float | None
) -> None:
    if path.suffix.lower() not in FORMS:
        raise InputError(f"-o {path}: expected a name that ends in {', '.join(FORMS)}")
    for option, word, known in (("--quantity", quantity, tuple(QUANTITIES)), ("--view", view, VIEWS)):
        if word is not None and word not in known:
            near = did_you_mean(word.lower(), known, 0.5)
            hint = f"; {near}" if near else ""
            raise InputError(f"{option}: found {word}, expected one of {', '.join(known)}{hint}")
    if size is None and not LEAST_WIDTH <= width <= MOST_WIDTH:
        raise InputError(f"--width: found {width}, expected {LEAST_WIDTH} to {MOST_WIDTH} pixels")
    if rate is not None and not 0.1 <= rate <= 100:
        raise InputError(f"--rate: found {rate:g}, expected 0.1 to 100 pictures per second")


def _pictures(film: Scene, width: int, progress: Callable[[int, int], None] | None) -> Iterator[NDArray[np.uint8]]:
    for number in range(len(film.times)):
        yield _pixels(film.draw(number), width)
        if progress is not None:
            progress(number + 1, len(film.times))


def _pixels(figure: Figure, width: int) -> NDArray[np.uint8]:
    """Return the picture in red, green, blue: (height, width, 3), both even as films need."""
    inches = figure.get_figwidth()
    figure.set_dpi(width / inches)
    canvas = figure.canvas
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[:, :, :3]  # type: ignore[attr-defined]
    height, across = (size // 2 * 2 for size in pixels.shape[:2])
    return np.ascontiguousarray(pixels[:height, :across])


def _write_mp4(path: Path, pictures: Iterator[NDArray[np.uint8]], rate: float) -> None:
    import imageio_ffmpeg  # brings ffmpeg along

    last = next(pictures)
    read = f"-y -v error -f rawvideo -pix_fmt rgb24 -s {last.shape[1]}x{last.shape[0]} -r {rate} -i -"
    write = "-c:v libx264 -pix_fmt yuv420p -preset medium -crf 20 -metadata comment=granwave -f mp4"
    command = [imageio_ffmpeg.get_ffmpeg_exe(), *read.split(), *write.split(), str(path)]
    # a new session: Ctrl-C reaches this process alone
    ffmpeg = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        with contextlib.suppress(BrokenPipeError):  # its exit status tells why it ended
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
    if status:  # of a system error, its number below 256
        number = 256 - status if status > 128 else errno.EIO
        raise OSError(number, os.strerror(number), str(path))


def _write_moving(path: Path, pictures: Iterator[NDArray[np.uint8]], rate: float, **options: Any) -> None:
    images = [Image.fromarray(picture) for picture in pictures]
    durations = [round(1000 / rate)] * len(images)
    durations[-1] += round(1000 * _LAST)
    images[0].save(path, save_all=True, append_images=images[1:], duration=durations, loop=0, **options)


_NOTE = Image.Exif()
_NOTE[0x0131] = "granwave"  # the program that wrote it
_WRITERS: dict[str, Callable[[Path, Iterator[NDArray[np.uint8]], float], None]] = {
    ".mp4": _write_mp4,
    ".gif": partial(_write_moving, format="GIF", optimize=True, comment=b"granwave"),
    ".webp": partial(_write_moving, format="WEBP", quality=85, method=4, exif=_NOTE.tobytes()),
}
