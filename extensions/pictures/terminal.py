"""Commands ``granwave film`` and ``granwave view``; each returns the exit status."""

from __future__ import annotations

import argparse
import sys
import time

from granwave.analysis.formatting.numbers import duration
from granwave.extensions.pictures.commands import FILM_KEYS
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows.cli.results import apply_options, as_wrong_input, existing
from granwave.workflows.run.directory import held

_MEASURED = 10  # frames of an animation after which the remaining time is known
_WORTH_SAYING = 5.0  # s


def film(options: argparse.Namespace) -> int:
    """Execute ``granwave film``."""
    from tqdm import tqdm

    from granwave.analysis.result.reader import Result
    from granwave.extensions.pictures.films import size_of, write_film

    with tqdm(desc="film", unit="picture", disable=None, leave=False) as bar:
        started = list[float]()

        def report(done: int, of: int) -> None:
            bar.total = of
            bar.update(done - bar.n)
            if done == 1:  # later frames take equal times
                started.append(time.monotonic())
            elif done == _MEASURED:
                rest = (of - done) * (time.monotonic() - started[0]) / (done - 1)
                if rest > _WORTH_SAYING:
                    bar.write(f"animation: {of} frames, about {duration(rest)} left", sys.stderr)

        chosen = {name: getattr(options, name) for name in ("quantity", "view", "width", "rate")}
        size = None if options.size is None else size_of(options.size)
        if options.plane is not None and options.view is None:
            chosen["view"] = "section"
        with as_wrong_input():
            with Result(options.directory) as result:
                colours = apply_options(options, result.figure_options, *FILM_KEYS)
            path = write_film(
                options.directory,
                options.output,
                progress=report,
                size=size,
                options=colours,
                **chosen,
            )
    print(path)
    return 0


def view(options: argparse.Namespace) -> int:
    """Execute ``granwave view``."""
    from granwave.extensions.pictures.view.page import MOST_SPHERES, write_view

    spheres = sys.maxsize if options.all else options.spheres or MOST_SPHERES
    frames = sys.maxsize if options.all and options.frames is None else options.frames
    results = ResultDirectory(existing(options.directory))
    with held(results, way=""), as_wrong_input():
        page = write_view(results, options.output, spheres=spheres, frames=frames)
    print(page.path)
    print(f"{page.size / 1e6:.1f} MB, {page.n_spheres} {page.called}, {page.n_frames} snapshots")
    if page.note:
        print(f"granwave: {page.note}; --all shows all", file=sys.stderr)
    return 0
