"""All figures of a run by name, each written as NAME.png and NAME.csv to ``figures``."""

from __future__ import annotations

import contextlib
import dataclasses
import gc
import logging
import pickle
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from functools import cache, partial
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import BinaryIO

from granwave.analysis.figures import (
    chains,
    contacts,
    directions,
    dissipation,
    driven,
    force_map,
    histories,
    lines,
    peak_force_depth,
    plastic_zone,
    regions,
    sections,
)
from granwave.analysis.figures.side_by_side import Helpers
from granwave.analysis.figures.side_by_side import helpers as start_helpers
from granwave.analysis.figures.style import Drawing, FigureFolder, files_of, style
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.figures import Figures, figure_names
from granwave.lammps_inputs.extensions import added_by_name, load
from granwave.lammps_inputs.own_files import AnyPath
from granwave.lammps_inputs.packing.assembly import Assembly


@dataclasses.dataclass(frozen=True)
class RunFigure:
    """A figure of a run.

    Attributes
    ----------
    caption
        Its caption in reports.
    function
        Function that draws it from a result, or returns None if it does not apply.
    look
        Feature to look for: the rest of its caption in reports.
    shares_work_with
        Names of other figures that are drawn in the same process because they share computations.
    takes_long
        True if it takes so long that it is drawn first.
    adds
        Function that returns False for a result of which it repeats other figures: it is then drawn
        only on request.
    needs
        Runs that have the figure, in words; empty: the caption says enough.
    words
        Function of a result and of the path of the table of the figure, which returns caption and
        look of the figure of this run; None: they are the same for all runs.
    n_axes
        Number of the axes that ``run.figure(..., ax=)`` needs, in words.
    """

    caption: str
    function: Callable[[Result], Drawing | None]
    look: str
    shares_work_with: tuple[str, ...] = ()
    takes_long: bool = False
    adds: Callable[[Result], bool] | None = None
    needs: str = ""
    words: Callable[[Result, Path], tuple[str, str]] | None = None
    n_axes: str = "1"

    def answers(self, result: Result) -> bool:
        """Return True unless it repeats other figures of this result."""
        return self.adds is None or self.adds(result)

    def draw(self, result: Result) -> Drawing | None:
        """Draw it, with the name of the grains: spheres, cylinders or grains; None if it
        does not apply.
        """
        drawing = self.function(result)
        if drawing is not None:
            drawing.call_grains(result.assembly.grains_called)
        return drawing


#: Figures of the core: name, function, caption, what to look for; with * on each of the three planes.
_TABLE: tuple[tuple[str, Callable[..., Drawing | None], str, str], ...] = (
    ("peak_force_*", sections.peak_force_section, "Peak contact force, excluding walls",
     "Bright lines are chains that carry the wave. White: no force."),
    ("peak_force_depth", peak_force_depth.peak_force_depth,
     "Peak contact force of the first wave against depth, excluding walls",
     "A straight line is exponential. Squares: after a reflection. Crosses: still rising. Circles: "
     "contacts, at their lower sphere."),
    ("dissipation_*", sections.dissipation_section, "Dissipation",
     "Coloured: the extent of the plastic zone. White: no dissipation."),
    ("dissipation_parts_*", sections.dissipation_parts_section, "Dissipation by yielding, "
        "friction and viscous losses",
     "All panels have one scale: compare where contacts yield and slide. "
     "White: none of this kind."),
    ("dents_*", sections.dents_section, "Plastic indentations before the run",
     "A contact is elastic up to the force that caused its indentation. White: no indentation."),
    ("dissipation_ranked", dissipation.dissipation_ranked, "Dissipation of spheres in descending order",
     "A steep decrease means that few spheres dissipate most of the energy. Spheres that "
     "yielded without dissipation are excluded."),
    ("dissipation_cumulated", dissipation.dissipation_cumulated, "Cumulative dissipation against "
        "volume",
     "If a curve rises early, few spheres dissipate most of the energy."),
    ("plastic_zone_growth", plastic_zone.plastic_zone_growth, "Growth of the plastic zone",
     "All yielded spheres are counted. If the curves are constant at the end, the zone is "
     "complete; if they rise, use a longer run."),
    ("plastic_zone_size", plastic_zone.plastic_zone_size,
     "Size of the plastic zone: plastic dissipation beyond a depth, and beyond a radius about the "
     "impact axis",
     "The curves reach 0.1 at the 90 % depth and radius of whole layers and shells. The axis ends "
     "where less than 1e-5 is beyond."),
    ("energies", histories.energies, "Energies and the error of their balance",
     "A constant dissipated energy shows that no contact dissipates any more; the residual is the "
     "error of the balance."),
    ("timestep", histories.timestep, "Timestep, and the error of the energy balance that controls "
        "it",
     "Steps are short while contacts are stiff; the line is the tolerance for the error."),
    ("bottom_force", histories.bottom_force, "Force and impulse on the bottom",
     "The first rise is the arrival of the wave; the impulse is the area under the force, above "
     "its static value."),
    ("target", histories.target, "Force on the target with and without the packing",
     "The ratio of the two force peaks is the peak reduction. A target that can move has a panel "
     "with the work on it."),
    ("impactor_velocity", histories.impactor_velocity, "Velocity of the impacted or loaded sphere",
     "Negative values are a rebound; where the velocity is constant, the sphere moves freely."),
    ("probes", histories.probes, "Probes",
     "The delay between curves gives the wave speed, and the height of the peaks gives the decay."),
    ("wave_front", sections.wave_front, "Wave front",
     "The edge of the coloured region is the front: there forces pass 10 % of their peaks. White: "
     "not reached, or no force."),
    ("force_map", force_map.force_map, "Contact force in space and time",
     "A wave is an inclined line; its slope gives the speed, fading colours show decay, and a "
     "reversal is a reflection."),
    ("force_histories", chains.force_histories, "Forces of individual contacts",
     "Equal pulses are a steady wave. If the peaks differ much, each curve is divided by its peak "
     "in the legend."),
    ("along_chain", chains.along_chain, "Peak force of the first wave above the static force, "
        "and dissipation, along the chain; crosses: larger forces later in the run",
     "Constant values: no decay. Open circles: a larger pulse may follow. Open squares: one "
     "followed. Triangles: still rising."),
    ("bead_velocities", chains.bead_velocities, "Velocities along the chain",
     "Each curve is the whole chain when the speed of one bead is first largest. The heights at "
     "these beads show the decay."),
    ("transmission", driven.transmission,
     "Amplitude along the chain, or transmission against frequency, for an oscillating load",
     "Where the curve is near zero, no wave is transmitted."),
    ("amplitude_sweep", driven.amplitude_sweep, "Response of the chain against the load amplitude",
     "A jump, or separate curves, shows two states of the chain at one amplitude."),
    ("bars", chains.bars, "Bars: contact force and energy",
     "A pulse in a bar returns from the far end after twice its length divided by its wave speed; "
     "other peaks come from the chain."),
    ("sensors", chains.sensors, "Sensors",
     "The delay between curves gives the wave speed, and the height of the peaks gives the decay."),
    ("line_speeds", lines.line_speeds, "Speeds along lines of grains",
     "The first peak of each grain is the wave; later peaks are rattling and reflections from "
     "walls."),
    ("line_decay", lines.line_decay, "Peak speed along lines of grains, and its decay in two regions",
     "A straight line is an exponential decay; its rate changes where the two lines meet."),
    ("accelerations", histories.sensors, "Accelerations of the sensors",
     "Sensors at equivalent positions ideally have the same curve."),
    ("directions", directions.directions, "Energy and dissipation by direction from the impact point",
     "Views from above: large values lie along chains of contacts (white rings); equal values are "
     "an isotropic wave."),
    ("contact_network", contacts.contact_network,
     "Contacts between grains as lines, whose width is proportional to the force",
     "Consecutive thick lines are a force chain; the title gives the force of the thickest line."),
    ("force_distribution", contacts.force_distribution,
     "Distribution of contact forces relative to their mean",
     "A straight line is an exponential tail: only the densities are logarithmic. Forces below "
     "1e-4 of the largest are left out."),
    ("line_diagram", lines.line_diagram,
     lines.DIAGRAM, lines.LOOK_OF_DIAGRAM),
    ("force_at_depths", regions.force_at_depths, "Force through planes at several depths",
     "Delays give the speed, peaks the decay. Dissimilar curves are divided by their peaks, and "
     "oscillations are shifted."),
    ("energy_by_region", regions.energy_by_region, "Energy in regions of the packing",
     "A region gains energy when its area grows; the sum of all areas is the energy input."),
)  # fmt: skip
#: End of the text of sections through the perpendicular plane, which alone have such spheres.
_BEHIND = {"orthogonal": "Pale spheres lie behind the plane."}
_PLANES = {
    "principal": "principal plane",
    "orthogonal": "perpendicular plane",
    "section": "plane of the case",
}


#: Ends of the names of figures whose plane does not depend on ``figures.plane``.
FIXED_PLANES = ("_principal", "_orthogonal")
#: Figures of the core that take long.
_LONG = ("wave_front", "directions")
#: Figures of the core that repeat others of some runs.
_ADDS = {"target": histories.target_moves}
#: Words for figures of the core that depend on the run.
_WORDS = {
    "along_chain": chains.words_along_chain,
    "bars": chains.words_on_bars,
    "impactor_velocity": histories.words_on_velocity,
    "line_diagram": lines.words_on_diagram,
    "peak_force_depth": peak_force_depth.words_on_depths,
}
#: Number of the axes of figures of the core with several panels.
_PANELS = {
    "dissipation_parts_*": "1 for each kind",
    "energies": "2",
    "timestep": "2",
    "target": "1, or 2 for a target that can move",
    "plastic_zone_growth": "2",
    "along_chain": "1, or 2 with dissipation",
    "bars": "2",
    "probes": "1 for each quantity",
    "accelerations": "1 for four sensors",
    "line_speeds": "1 for each line",
    "line_decay": "1 for each line",
    "line_diagram": "1 for each line",
    "force_map": "1 for the chain, each bar",
    "directions": "1 or 2, polar",
    "contact_network": "1 for each state",
    "wave_front": "4",
}
_CHAINS = "a chain"
#: Runs that have a figure of the core, for those that not all runs have.
_NEEDS = {
    "along_chain": _CHAINS,
    "force_map": _CHAINS,
    "bead_velocities": _CHAINS,
    "force_histories": _CHAINS,
    "bars": "a chain with [bar]",
    "probes": "a run with output.probes",
    "accelerations": "a run with [[sensor]]",
    "line_decay": "a run with [[line]]",
    "line_speeds": "a run with [[line]]",
    "force_at_depths": "a run with output.contact_forces = true, or a chain",
    "contact_network": "a packing; along_chain shows the forces of a chain",
    "force_distribution": "a packing with at least ten loaded contacts",
    "target": "a force on a bottom that moves, or that the load could also hit without the packing",
    "transmission": "a load that oscillates",
}


def _figures() -> Iterator[tuple[str, RunFigure]]:
    """Yield the figures of the core by name."""
    for name, function, caption, look in _TABLE:
        if not name.endswith("*"):
            adds = _ADDS.get(name)
            yield (
                name,
                RunFigure(
                    caption,
                    function,
                    look,
                    takes_long=name in _LONG,
                    adds=adds,
                    needs=_NEEDS.get(name, ""),
                    words=_WORDS.get(name),
                    n_axes=_PANELS.get(name, "1"),
                ),
            )
            continue
        for plane, where in _PLANES.items():
            yield (
                name.replace("*", plane),
                RunFigure(
                    f"{caption}, {where}",
                    partial(function, name=plane),
                    f"{look} {_BEHIND.get(plane, '')}".rstrip(),
                    n_axes=_PANELS.get(name, "1"),
                ),
            )


@cache
def run_figures() -> dict[str, RunFigure]:
    """Return the figures by name, those of extensions too, in the order of reports."""
    figures = dict(_figures())
    for name, reference in added_by_name("figures").items():
        figures[name] = _added(reference)
    return {name: figures[name] for name in figure_names()}


def why_not_drawn(name: str) -> str:
    """Describe why a figure does not apply to a run."""
    figure = run_figures()[name]
    if figure.needs:
        return f"does not apply to this run; expected {figure.needs}"
    return f"does not apply to this run ({figure.caption})"


def _added(reference: str) -> RunFigure:
    """Return a figure of an extension; if it cannot be loaded, it fails when it is drawn."""
    try:
        figure: RunFigure = load(reference)
    except Exception as error:  # an error in someone's extension; the other figures are drawn
        return RunFigure(f"{reference}, which cannot be loaded", partial(_fail, error), "")
    return figure


def _fail(error: Exception, result: Result) -> None:
    raise error


def chosen_figures(result: Result, options: Figures) -> tuple[str, ...]:
    """Return the names of the requested figures; by default without figures that repeat
    others.
    """
    if options.only or options.all:
        return options.chosen
    return tuple(name for name in options.chosen if run_figures()[name].answers(result))


def draw_figures(
    directory: AnyPath,
    progress: Callable[[str], None] | None = None,
    names: tuple[str, ...] | None = None,
    helpers: Helpers | None = None,
    options: Figures | None = None,
    assembly: Assembly | None = None,
) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``.

    Earlier figures that no longer apply are removed.

    Parameters
    ----------
    progress
        Function called with the name of each figure before it is drawn.
    names
        Names of the figures to draw; by default the figures requested by the options, and the
        existing figures. Where the options name figures, others are removed.
    helpers
        Processes that draw next to this one, started before; by default as many as there are cores,
        up to four.
    options
        How they are drawn; by default as ``[figures]`` of the case.toml there says.
    assembly
        All bodies of the case that was run, if it was read before.

    Returns
    -------
    list of Path
        Paths of the PNG files.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    KeyError
        There is no figure of that name.
    InputError
        The environment does not give a number of processes, or ``[figures]`` of the case.toml there
        is invalid.
    """
    folder = FigureFolder(directory)
    with Result(directory, assembly=assembly) as result:
        options = options or result.figure_options
        if names is None:
            names = chosen_figures(result, options)
            if options.only:
                folder.remove(*(name for name in run_figures() if name not in names))
            else:
                wanted = {*names, *folder.names()}
                names = tuple(name for name in run_figures() if name in wanted)
    started = nullcontext(helpers) if helpers else start_helpers(len(names))
    with painter(directory, options, assembly) as draw, started as others:
        request = (Path(directory).absolute(), names, options)
        outcomes = others.draw(names, draw, request, _shares(names))
        for name in names:
            if progress is not None:
                progress(name)
            folder.place(next(outcomes), name)
    return folder.written


def _shares(names: Sequence[str]) -> list[list[int]]:
    """Return the numbers of the figures that one process draws at a time, slow figures first."""
    numbers = {name: number for number, name in enumerate(names)}
    figures = {name: run_figures()[name] for name in names}
    shares: list[list[int]] = []
    left = sorted(names, key=lambda name: not figures[name].takes_long)
    while left:
        together = [left[0], *figures[left[0]].shares_work_with]
        shares.append([numbers[name] for name in together if name in numbers])
        left = [name for name in left if name not in together]
    return shares


@contextmanager
def painter(
    directory: AnyPath, options: Figures, assembly: Assembly | None = None
) -> Iterator[Callable[[str], dict[str, bytes] | None]]:
    """Open a run; return a function that draws the figure of a name and returns the contents of its
    files by suffix.

    Parameters
    ----------
    options
        How figures are drawn.
    assembly
        As of `draw_figures`.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    """

    def draw(name: str) -> dict[str, bytes] | None:
        return files_of(partial(run_figures()[name].draw, result), name, options.formats)

    with Result(directory, assembly=assembly) as result, style(options.width):
        result.figure_options = options
        yield draw


def work(
    requests: BinaryIO, outcomes: BinaryIO, directory: Path, names: Sequence[str], options: Figures
) -> None:
    """Draw figures for another process; see `granwave.analysis.figures.side_by_side`.

    Parameters
    ----------
    requests, outcomes
        Pipes: it reads lists of numbers of figures, and writes success and files of each figure.
    directory
        Directory of the run.
    names
        Names of all figures.
    options
        How they are drawn.
    """
    notes = BufferingHandler(sys.maxsize)
    notes.setLevel(logging.WARNING)
    logging.getLogger().addHandler(notes)
    logging.captureWarnings(True)
    with painter(directory, options) as draw, contextlib.suppress(EOFError):
        while True:
            for number in pickle.load(requests):
                notes.buffer.clear()
                try:
                    outcome = True, draw(names[number])
                except Exception:
                    outcome = False, None
                # figures with warnings are drawn again where warnings are visible
                pickle.dump((False, None) if notes.buffer else outcome, outcomes)
                outcomes.flush()


if __name__ == "__main__":
    gc.freeze()  # modules remain until the end; the garbage collector can skip them
    pipe = sys.stdout.buffer
    sys.stdout = sys.stderr
    work(sys.stdin.buffer, pipe, *pickle.load(sys.stdin.buffer))
