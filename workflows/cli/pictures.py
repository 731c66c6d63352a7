"""Commands that make pictures of a run: figures, films and pages; each function returns the exit status."""

from __future__ import annotations

import argparse
import difflib
import sys

from granwave.lammps_inputs.case.run import FIGURE_NAMES
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.commands import Arguments, as_wrong_input
from granwave.workflows.cli.figure_options import FILM_OPTIONS, apply_options


def figures(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave figures``."""
    from granwave.analysis.figures.side_by_side import USUAL_FIGURES, helpers
    from granwave.workflows.run.directory import held

    wanted = options.only
    if unknown := [name for name in wanted or () if name not in FIGURE_NAMES]:
        near = difflib.get_close_matches(unknown[0], FIGURE_NAMES, n=1)
        hint = f"; did you mean {near[0]}?" if near else f", expected some of {', '.join(FIGURE_NAMES)}"
        raise InputError(f"--only: found {unknown[0]}{hint}")
    if not options.directory.is_dir():
        raise InputError(f"{options.directory}: no such directory; run a case into it first")
    with (
        held(options.directory.absolute(), way=""),
        as_wrong_input(),
        helpers(len(wanted) if wanted else USUAL_FIGURES) as others,
    ):
        # loaded while the helpers load them too
        from granwave.analysis.figures.run_figures import draw_figures
        from granwave.analysis.figures.style import FigureFolder
        from granwave.analysis.result.reader import Result

        with Result(options.directory) as result:
            chosen = apply_options(options, result.figure_options)
        drawn = draw_figures(options.directory, names=wanted, helpers=others, options=chosen)
    for path in drawn:
        print(path)
    failed = FigureFolder(options.directory).not_drawn()
    if failed.keys() & set(wanted or failed):
        return 1
    if left := [name for name in wanted or () if name not in {path.stem for path in drawn}]:
        raise InputError(f"--only: {', '.join(left)}: does not apply to this run, which has nothing of the kind")
    return 0


def film(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave film``."""
    from tqdm import tqdm

    from granwave.analysis.films.film import size_of, write_film
    from granwave.analysis.result.reader import Result

    with tqdm(desc="film", unit="picture", disable=None, leave=False) as bar:

        def report(done: int, of: int) -> None:
            bar.total = of
            bar.update(done - bar.n)

        chosen = {name: getattr(options, name) for name in ("quantity", "view", "width", "rate")}
        size = None if options.size is None else size_of(options.size)
        if options.plane is not None and options.view is None:
            chosen["view"] = "section"
        with as_wrong_input():
            with Result(options.directory) as result:
                colours = apply_options(options, result.figure_options, *FILM_OPTIONS)
            path = write_film(options.directory, options.output, progress=report, size=size, options=colours, **chosen)
    print(path)
    return 0


def view(options: argparse.Namespace, _: Arguments) -> int:
    """Execute ``granwave view``."""
    from granwave.analysis.view.page import MOST_SPHERES, write_view
    from granwave.workflows.run.directory import held

    if not options.directory.is_dir():
        raise InputError(f"{options.directory}: no such directory; run a case into it first")
    spheres = sys.maxsize if options.all else options.spheres or MOST_SPHERES
    frames = sys.maxsize if options.all and options.frames is None else options.frames
    with held(options.directory.absolute(), way=""), as_wrong_input():
        page = write_view(options.directory, options.output, spheres=spheres, frames=frames)
    print(page.path)
    print(f"{page.size / 1e6:.1f} MB, {page.n_spheres} {page.called}, {page.n_frames} snapshots")
    if page.note:
        print(f"granwave: {page.note}; --all shows all", file=sys.stderr)
    return 0
