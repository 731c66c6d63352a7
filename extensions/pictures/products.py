"""Products of a run: its animation, and the page with its packing in three dimensions."""

from __future__ import annotations

from granwave.analysis.products import Product
from granwave.lammps_inputs.result_directory import ResultDirectory


def make_film(results: ResultDirectory, file: str) -> None:
    """Write the animation of a run as a file of this name."""
    # it loads matplotlib, which most commands do not need
    from granwave.extensions.pictures.films import write_film

    results.claim([file])
    write_film(results.path, results / file)


def make_page(results: ResultDirectory, file: str) -> None:
    """Write the page of a run; its name is fixed."""
    from granwave.extensions.pictures.view.page import write_view

    write_view(results)


def packages_of_film(file: str) -> tuple[str, ...]:
    """Return the packages that an animation needs: single-file image formats do not need ffmpeg."""
    return ("imageio_ffmpeg",) if file.endswith(".mp4") else ()


def packages_of_page(file: str) -> tuple[str, ...]:
    """Return the packages that a page needs."""
    return ("k3d",)


PRODUCTS = (
    Product("film", make_film, packages_of_film),
    Product("view", make_page, packages_of_page),
)
