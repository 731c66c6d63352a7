"""All figures of a run by name, each written as NAME.png and NAME.csv to ``figures``."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from pathlib import Path

from granwave.analysis.figures.run import (
    chain,
    directions,
    dissipation,
    histories,
    lines,
    packing3d,
    sections,
    target,
    timestep,
    transmission,
    zone,
)
from granwave.analysis.figures.side_by_side import Helpers
from granwave.analysis.figures.side_by_side import helpers as start_helpers
from granwave.analysis.figures.style import Drawing, FigureFolder, files_of, settings, style
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.figures import Figures


@dataclasses.dataclass(frozen=True)
class RunFigure:
    """A figure of a run.

    Attributes
    ----------
    caption
        Its caption in reports.
    function
        Function that draws it from a result, or returns None if it does not apply.
    """

    caption: str
    function: Callable[[Result], Drawing | None]

    def draw(self, result: Result) -> Drawing | None:
        """Draw it, with the grains called what they are: spheres, cylinders or grains; None if it does not apply."""
        drawing = self.function(result)
        if drawing is not None:
            drawing.call_grains(result.assembly.grains_called)
        return drawing


#: Figures by name, in the order of reports.
FIGURES: dict[str, RunFigure] = {
    "peak_force_principal": RunFigure(
        "Peak contact force, principal plane", partial(sections.peak_force_section, name="principal")
    ),
    "peak_force_orthogonal": RunFigure(
        "Peak contact force, plane orthogonal to it", partial(sections.peak_force_section, name="orthogonal")
    ),
    "peak_force_section": RunFigure(
        "Peak contact force, plane of the case", partial(sections.peak_force_section, name="section")
    ),
    "peak_force_depth": RunFigure("Peak contact force against depth", dissipation.peak_force_depth),
    "dissipation_principal": RunFigure(
        "Dissipation, principal plane", partial(sections.dissipation_section, name="principal")
    ),
    "dissipation_orthogonal": RunFigure(
        "Dissipation, plane orthogonal to it", partial(sections.dissipation_section, name="orthogonal")
    ),
    "dissipation_section": RunFigure(
        "Dissipation, plane of the case", partial(sections.dissipation_section, name="section")
    ),
    "dissipation_parts_principal": RunFigure(
        "Dissipation by yielding, friction and viscous losses, principal plane",
        partial(sections.dissipation_parts_section, name="principal"),
    ),
    "dissipation_parts_orthogonal": RunFigure(
        "Dissipation by yielding, friction and viscous losses, plane orthogonal to it",
        partial(sections.dissipation_parts_section, name="orthogonal"),
    ),
    "dissipation_parts_section": RunFigure(
        "Dissipation by yielding, friction and viscous losses, plane of the case",
        partial(sections.dissipation_parts_section, name="section"),
    ),
    "dents_principal": RunFigure(
        "Dents from before the run, principal plane", partial(sections.dents_section, name="principal")
    ),
    "dents_orthogonal": RunFigure(
        "Dents from before the run, plane orthogonal to it", partial(sections.dents_section, name="orthogonal")
    ),
    "dents_section": RunFigure(
        "Dents from before the run, plane of the case", partial(sections.dents_section, name="section")
    ),
    "dissipation_ranked": RunFigure("Dissipation of spheres in descending order", dissipation.dissipation_ranked),
    "dissipation_cumulated": RunFigure(
        "Cumulated dissipation against the volume involved", dissipation.dissipation_cumulated
    ),
    "plastic_zone_growth": RunFigure("Growth of the plastic zone", dissipation.plastic_zone_growth),
    "plastic_zone_size": RunFigure(
        "Size of the plastic zone: energy of yielding that lies farther out", zone.plastic_zone_size
    ),
    "energies": RunFigure("Energies and the error of their balance", histories.energies),
    "timestep": RunFigure("Timestep, and the error of the energy balance that it follows", timestep.timestep),
    "bottom_force": RunFigure("Force and impulse on the bottom", histories.bottom_force),
    "target": RunFigure("What reaches the target, and the force there without the packing", target.target),
    "impactor_velocity": RunFigure("Velocity of the sphere that is struck or loaded", histories.impactor_velocity),
    "packing_3d": RunFigure("Packing cut open, peak contact force", packing3d.packing_3d),
    "packing_3d_dissipation": RunFigure("Packing cut open, dissipation", packing3d.packing_3d_dissipation),
    "probes": RunFigure("Probes", histories.probes),
    "wave_front": RunFigure("Wave front", sections.wave_front),
    "force_map": RunFigure("Contact force in place and time", chain.force_map),
    "force_histories": RunFigure("Forces of single contacts", chain.force_histories),
    "along_chain": RunFigure("Peak force and dissipation along the chain", chain.along_chain),
    "bead_velocities": RunFigure("Velocities along the chain", chain.bead_velocities),
    "transmission": RunFigure(
        "Amplitude along the row, or transmission against frequency, of a load that oscillates",
        transmission.transmission,
    ),
    "amplitude_sweep": RunFigure("Answer of the row against the amplitude of its load", transmission.amplitude_sweep),
    "bars": RunFigure("Bars: contact force and energy", chain.bars),
    "sensors": RunFigure("Sensors", chain.sensors),
    "line_speeds": RunFigure("Speeds along lines of grains", lines.line_speeds),
    "line_decay": RunFigure("Peak speed along lines of grains, and its decay in two regions", lines.line_decay),
    "accelerations": RunFigure("Accelerations of the sensors", histories.sensors),
    "directions": RunFigure("Energy and dissipation by direction from the impact point", directions.directions),
}

#: Figures that take long; the two of a packing cut open share the work of finding what is seen of it.
_LONG = (("packing_3d", "packing_3d_dissipation"), ("wave_front",), ("directions",))


def draw_figures(
    directory: str | Path,
    progress: Callable[[str], None] | None = None,
    names: tuple[str, ...] | None = None,
    helpers: Helpers | None = None,
    options: Figures | None = None,
) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``.

    Earlier figures that no longer apply are removed, and those that the case leaves out if all are drawn.

    Parameters
    ----------
    progress
        Function called with the name of each figure before it is drawn.
    names
        Names of the figures to draw; by default those of ``only`` of the options, or all.
    helpers
        Processes that draw beside this one, started before; by default as many as there are cores, up to four.
    options
        How they are drawn; by default as ``[figures]`` of the case.toml there says.

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
        The environment does not give a number of processes, or ``[figures]`` of the case.toml there is wrong.
    """
    if options is None:
        with Result(directory) as result:
            options = result.figure_options
    chosen = tuple(options.only or FIGURES) if names is None else names
    folder = FigureFolder(directory)
    if names is None:
        folder.remove(*(name for name in FIGURES if name not in chosen))
    with painter(directory, options) as draw, _helpers(len(chosen), helpers) as others:
        request = (Path(directory).absolute(), chosen, settings(), options)
        outcomes = others.draw(chosen, draw, request, _shares(chosen))
        for name in chosen:
            if progress is not None:
                progress(name)
            folder.place(next(outcomes), name)
    return folder.written


def _shares(names: Sequence[str]) -> list[list[int]]:
    """Return the numbers of the figures that one process draws at a time, those that take long before the others."""
    numbers = {name: number for number, name in enumerate(names)}
    long = [[numbers[name] for name in share if name in numbers] for share in _LONG]
    taken = {number for share in long for number in share}
    return [share for share in long if share] + [[number] for number in numbers.values() if number not in taken]


def _helpers(n_figures: int, started: Helpers | None) -> AbstractContextManager[Helpers]:
    return nullcontext(started) if started else start_helpers(n_figures)


@contextmanager
def painter(directory: str | Path, options: Figures) -> Iterator[Callable[[str], dict[str, bytes] | None]]:
    """Open a run; give a function that draws the figure of a name, as contents of its files by suffix.

    Parameters
    ----------
    options
        How figures are drawn.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    """

    def draw(name: str) -> dict[str, bytes] | None:
        return files_of(partial(FIGURES[name].draw, result), name, options.formats)

    with Result(directory) as result, style(options.width):
        result.figure_options = options
        yield draw
