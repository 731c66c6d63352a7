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

from granwave.analysis.figures import contacts, dissipation, histories, rows, sections
from granwave.analysis.figures.side_by_side import Helpers
from granwave.analysis.figures.side_by_side import helpers as start_helpers
from granwave.analysis.figures.style import Drawing, FigureFolder, files_of, style
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.run import Figures, figure_names, usual_figure_names
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
        What to look for in it: the rest of its caption in reports.
    shares_work_with
        Names of other figures that are drawn in the same process, since they share the work.
    takes_long
        True if it takes so long that it is drawn first.
    """

    caption: str
    function: Callable[[Result], Drawing | None]
    look: str
    shares_work_with: tuple[str, ...] = ()
    takes_long: bool = False

    def draw(self, result: Result) -> Drawing | None:
        """Draw it, with the grains called what they are: spheres, cylinders or grains; None if it
        does not apply.
        """
        drawing = self.function(result)
        if drawing is not None:
            drawing.call_grains(result.assembly.grains_called)
        return drawing


#: Figures of the core: name, function, caption, what to look for; with * on each of the three planes.
_TABLE: tuple[tuple[str, Callable[..., Drawing | None], str, str], ...] = (
    ("peak_force_*", sections.peak_force_section, "Peak contact force, walls left out",
     "Bright lines are rows of contacts that carry the wave."),
    ("peak_force_depth", dissipation.peak_force_depth, "Peak contact force against depth, walls left out",
     "On a logarithmic axis a straight line is an exponential decay; marks are the preferred directions."),
    ("dissipation_*", sections.dissipation_section, "Dissipation",
     "How far from the impact spheres are coloured is the size of the plastic zone."),
    ("dissipation_parts_*", sections.dissipation_parts_section, "Dissipation by yielding, friction and viscous losses",
     "The panels have one scale: compare where spheres yield with where they slide or are damped."),
    ("dents_*", sections.dents_section, "Dents from before the run",
     "A contact is elastic up to the force that dented it."),
    ("dissipation_ranked", dissipation.dissipation_ranked, "Dissipation of spheres in descending order",
     "The steeper the fall, the fewer spheres take the energy. Spheres that yielded and dissipated nothing are left out."),
    ("dissipation_cumulated", dissipation.dissipation_cumulated, "Cumulated dissipation against the volume involved",
     "Where the curve is steep, little energy is spread over much volume."),
    ("plastic_zone_growth", dissipation.plastic_zone_growth, "Growth of the plastic zone",
     "Yielded counts, dissipation or not. Level curves: the zone is fully grown; rising ones ask for a longer run."),
    ("plastic_zone_size", dissipation.plastic_zone_size,
     "Size of the plastic zone: energy of yielding that lies farther out",
     "Where a curve falls to 0.1 is the size that holds 90 %; a boundary cuts a curve that ends abruptly."),
    ("energies", histories.energies, "Energies and the error of their balance",
     "Where the dissipated energy is level, the impact is over; the residual is the error of the balance."),
    ("timestep", histories.timestep, "Timestep, and the error of the energy balance that it follows",
     "Steps are short while contacts are stiff; the line is the tolerance that the steps aim at."),
    ("bottom_force", histories.bottom_force, "Force and impulse on the bottom",
     "The first rise is the arrival of the wave; the impulse is the area below the force."),
    ("target", histories.target, "What reaches the target, and the force there without the packing",
     "Compare the two peaks of force: their ratio is the peak reduction."),
    ("impactor_velocity", histories.impactor_velocity, "Velocity of the sphere that is struck or loaded",
     "Below zero the sphere rebounds; where the curve is level, it touches nothing."),
    ("probes", histories.probes, "Probes",
     "The delay from curve to curve gives the speed of the wave, and the height of the peaks its decay."),
    ("wave_front", sections.wave_front, "Wave front",
     "The edge of the coloured region is the front: how far it is in each direction shows where the wave is fast."),
    ("force_map", rows.force_map, "Contact force in place and time",
     "A wave is a slanted line, the faster the flatter; it decays where its colour fades, and is reflected "
     "where it turns back."),
    ("force_histories", rows.force_histories, "Forces of single contacts",
     "Equal pulses one after the other are a steady wave; pulses that become lower and longer lose energy."),
    ("along_chain", rows.along_chain, "Peak force and dissipation along the chain",
     "Level dots are a wave that keeps its force; falling ones are its decay."),
    ("bead_velocities", rows.bead_velocities, "Velocities along the chain",
     "Each curve is the whole row at one instant: the front goes to the right, and its height tells the decay."),
    ("transmission", rows.transmission,
     "Amplitude along the row, or transmission against frequency, of a load that oscillates",
     "Where the curve is near zero, nothing comes through."),
    ("amplitude_sweep", rows.amplitude_sweep, "Answer of the row against the amplitude of its load",
     "A jump, or two curves apart, means two states of the row at one amplitude."),
    ("bars", rows.bars, "Bars: contact force and energy",
     "A second peak is a reflected pulse; the energies are those in each bar."),
    ("sensors", rows.sensors, "Sensors",
     "The delay from curve to curve gives the speed of the wave, and the height of the peaks its decay."),
    ("line_speeds", rows.line_speeds, "Speeds along lines of grains",
     "The first peak of each grain is the wave; what follows is rattling and what walls send back."),
    ("line_decay", rows.line_decay, "Peak speed along lines of grains, and its decay in two regions",
     "A straight line is an exponential decay; where the two lines meet, it changes."),
    ("accelerations", histories.sensors, "Accelerations of the sensors",
     "Compare sensors that lie alike: ideally their curves are the same."),
    ("directions", dissipation.directions, "Energy and dissipation by direction from the impact point",
     "Peaks lie along rows of contacts; a level curve is a wave that goes everywhere alike."),
    ("contact_network", contacts.contact_network,
     "Contacts between grains, as lines as thick as their force",
     "Thick lines in a row are a force chain; the title gives the force of the thickest line."),
    ("force_distribution", contacts.force_distribution,
     "Distribution of contact forces over their mean",
     "A straight line is an exponential tail; the smaller its decay, the more uneven the forces."),
    ("line_diagram", rows.line_diagram,
     "Speed of a line of grains in place and time, with the front",
     "The front is the lower edge of the colours; dots on the fitted line mean a steady speed."),
)  # fmt: skip
_PLANES = {
    "principal": "principal plane",
    "orthogonal": "plane orthogonal to it",
    "section": "plane of the case",
}


#: Figures of the core that take long.
_LONG = ("wave_front", "directions")


def _figures() -> Iterator[tuple[str, RunFigure]]:
    """Yield the figures of the core by name."""
    for name, function, caption, look in _TABLE:
        if not name.endswith("*"):
            yield name, RunFigure(caption, function, look, takes_long=name in _LONG)
            continue
        for plane, where in _PLANES.items():
            yield (
                name.replace("*", plane),
                RunFigure(f"{caption}, {where}", partial(function, name=plane), look),
            )


@cache
def run_figures() -> dict[str, RunFigure]:
    """Return the figures by name, those of extensions too, in the order of reports."""
    figures = dict(_figures())
    for name, reference in added_by_name("figures").items():
        figures[name] = _added(reference)
    return {name: figures[name] for name in figure_names()}


def _added(reference: str) -> RunFigure:
    """Return a figure of an extension; one that cannot be loaded fails when it is drawn."""
    try:
        figure: RunFigure = load(reference)
    except Exception as error:  # of anyone's package; it costs no other figure
        return RunFigure(f"{reference}, which cannot be loaded", partial(_fail, error), "")
    return figure


def _fail(error: Exception, result: Result) -> None:
    raise error


def draw_figures(
    directory: AnyPath,
    progress: Callable[[str], None] | None = None,
    names: tuple[str, ...] | None = None,
    helpers: Helpers | None = None,
    options: Figures | None = None,
    assembly: Assembly | None = None,
) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``.

    Earlier figures that no longer apply are removed, and those that the case leaves out if all are
    drawn.

    Parameters
    ----------
    progress
        Function called with the name of each figure before it is drawn.
    names
        Names of the figures to draw; by default those of ``only`` of the options, or all
        that need not be asked for by name.
    helpers
        Processes that draw beside this one, started before; by default as many as there are cores,
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
        is wrong.
    """
    if options is None:
        with Result(directory) as result:
            options = result.figure_options
    chosen = tuple(options.only or usual_figure_names()) if names is None else names
    folder = FigureFolder(directory)
    if names is None:
        folder.remove(*(name for name in run_figures() if name not in chosen))
    started = nullcontext(helpers) if helpers else start_helpers(len(chosen))
    with painter(directory, options, assembly) as draw, started as others:
        request = (Path(directory).absolute(), chosen, options)
        outcomes = others.draw(chosen, draw, request, _shares(chosen))
        for name in chosen:
            if progress is not None:
                progress(name)
            folder.place(next(outcomes), name)
    return folder.written


def _shares(names: Sequence[str]) -> list[list[int]]:
    """Return the numbers of the figures that one process draws at a time, those that take long
    before the others.
    """
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
    """Open a run; give a function that draws the figure of a name, as contents of its files by
    suffix.

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
        Pipes: lists of numbers of figures come in; success and files of each figure go out.
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
                # what gave warnings is drawn again where they are seen
                pickle.dump((False, None) if notes.buffer else outcome, outcomes)
                outcomes.flush()


if __name__ == "__main__":
    gc.freeze()  # modules stay to the end; collections need not look at them
    pipe = sys.stdout.buffer
    sys.stdout = sys.stderr
    work(sys.stdin.buffer, pipe, *pickle.load(sys.stdin.buffer))
