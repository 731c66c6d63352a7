"""All figures of a run by name, each written as NAME.png, NAME.pdf and NAME.csv to ``figures``."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from granwave.analysis.figures import (
    chain,
    directions,
    dissipation,
    histories,
    packing3d,
    sections,
    target,
    timestep,
    zone,
)
from granwave.analysis.figures.style import Drawing, FigureFolder, style
from granwave.analysis.result.reader import Result

#: Functions that draw a figure of a result, or return None if it does not apply.
FIGURES: dict[str, Callable[[Result], Drawing | None]] = {
    "peak_force_principal": partial(sections.peak_force_section, name="principal"),
    "peak_force_orthogonal": partial(sections.peak_force_section, name="orthogonal"),
    "peak_force_depth": dissipation.peak_force_depth,
    "dissipation_principal": partial(sections.dissipation_section, name="principal"),
    "dissipation_orthogonal": partial(sections.dissipation_section, name="orthogonal"),
    "dissipation_parts_principal": partial(sections.dissipation_parts_section, name="principal"),
    "dissipation_parts_orthogonal": partial(sections.dissipation_parts_section, name="orthogonal"),
    "dents_principal": partial(sections.dents_section, name="principal"),
    "dents_orthogonal": partial(sections.dents_section, name="orthogonal"),
    "dissipation_ranked": dissipation.dissipation_ranked,
    "dissipation_cumulated": dissipation.dissipation_cumulated,
    "plastic_zone_growth": dissipation.plastic_zone_growth,
    "plastic_zone_size": zone.plastic_zone_size,
    "energies": histories.energies,
    "timestep": timestep.timestep,
    "bottom_force": histories.bottom_force,
    "target": target.target,
    "impactor_velocity": histories.impactor_velocity,
    "wave_front": sections.wave_front,
    "packing_3d": packing3d.packing_3d,
    "packing_3d_dissipation": packing3d.packing_3d_dissipation,
    "probes": histories.probes,
    "force_map": chain.force_map,
    "force_histories": chain.force_histories,
    "along_chain": chain.along_chain,
    "bead_velocities": chain.bead_velocities,
    "bars": chain.bars,
    "sensors": chain.sensors,
    "accelerations": histories.sensors,
    "directions": directions.directions,
}


def draw_figures(
    directory: str | Path, progress: Callable[[str], None] | None = None, names: tuple[str, ...] | None = None
) -> list[Path]:
    """Draw the figures of a run from its ``result.h5``.

    Earlier figures that no longer apply are removed.

    Parameters
    ----------
    progress
        Function called with the name of each figure before it is drawn.
    names
        Names of the figures to draw; by default all.

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
    """
    folder = FigureFolder(directory)
    with Result(directory) as result, style():
        for name in FIGURES if names is None else names:
            if progress is not None:
                progress(name)
            folder.save(FIGURES[name](result), name)
    return folder.written
