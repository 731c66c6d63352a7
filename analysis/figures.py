"""All figures of a run, by name; each leaves NAME.png, NAME.pdf and NAME.csv in ``figures``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from granwave.analysis import (
    figures_chain,
    figures_directions,
    figures_dissipation,
    figures_history,
    figures_packing,
    figures_planes,
    figures_target,
    figures_zone,
)
from granwave.analysis.figure_style import Drawing, FigureFolder, style
from granwave.analysis.result import Result

#: Each draws a figure of a result, or returns None when the figure makes no sense for it.
FIGURES: dict[str, Callable[[Result], Drawing | None]] = {
    "peak_force_principal": partial(figures_planes.peak_force_section, name="principal"),
    "peak_force_orthogonal": partial(figures_planes.peak_force_section, name="orthogonal"),
    "peak_force_depth": figures_dissipation.peak_force_depth,
    "dissipation_principal": partial(figures_planes.dissipation_section, name="principal"),
    "dissipation_orthogonal": partial(figures_planes.dissipation_section, name="orthogonal"),
    "dissipation_parts_principal": partial(figures_planes.dissipation_parts_section, name="principal"),
    "dissipation_parts_orthogonal": partial(figures_planes.dissipation_parts_section, name="orthogonal"),
    "dents_principal": partial(figures_planes.dents_section, name="principal"),
    "dents_orthogonal": partial(figures_planes.dents_section, name="orthogonal"),
    "dissipation_ranked": figures_dissipation.dissipation_ranked,
    "dissipation_cumulated": figures_dissipation.dissipation_cumulated,
    "plastic_zone_growth": figures_dissipation.plastic_zone_growth,
    "plastic_zone_size": figures_zone.plastic_zone_size,
    "energies": figures_history.energies,
    "bottom_force": figures_history.bottom_force,
    "target": figures_target.target,
    "impactor_velocity": figures_history.impactor_velocity,
    "wave_front": figures_planes.wave_front,
    "packing_3d": figures_packing.packing_3d,
    "packing_3d_dissipation": figures_packing.packing_3d_dissipation,
    "probes": figures_history.probes,
    "force_map": figures_chain.force_map,
    "force_histories": figures_chain.force_histories,
    "along_chain": figures_chain.along_chain,
    "bead_velocities": figures_chain.bead_velocities,
    "bars": figures_chain.bars,
    "sensors": figures_chain.sensors,
    "accelerations": figures_history.sensors,
    "directions": figures_directions.directions,
}


def draw_figures(
    directory: str | Path, progress: Callable[[str], None] | None = None, names: tuple[str, ...] | None = None
) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``.

    Figures that are there from before and make no sense any more are removed.

    Parameters
    ----------
    progress
        Called with the name of each figure before it is drawn.
    names
        Of the figures to draw; all if not given.

    Returns
    -------
    list of Path
        The PNG files that were written.

    Raises
    ------
    MissingOutputError
        There is no result.h5.
    KeyError
        There is no figure of that name.
    """
    folder = FigureFolder(directory)
    with Result(directory) as result, style():
        for name in FIGURES if names is None else names:
            if progress is not None:
                progress(name)
            folder.save(FIGURES[name](result), name)
    return folder.written
