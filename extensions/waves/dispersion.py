"""Space-time transform of the velocities of a run under a static load, with its bands: the figure
``dispersion``.

The velocities along a chain, or the means of the layers or columns of a packing, are transformed in
space and time. A weak impact contains all frequencies, and the transform has ridges on the bands of
the static state; the ridges of a strong impact, with nonlinear contacts, leave the bands.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.patheffects import withStroke

from granwave.analysis.errors import MissingDataError
from granwave.analysis.figures.run_figures import RunFigure
from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import ORANGE, Drawing, legend_above
from granwave.analysis.measures.line_waves import (
    SpaceTime,
    space_time_transform,
    velocities_along,
)
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result
from granwave.extensions.waves.spectra.band_structure import BandStructure, band_structure
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly

STRONGEST = 0.05  # fraction of the largest amplitude, for a ridge
_FEWEST_PLACES = 2
_POINTS = 101  # wave vectors of the bands
_FREQUENCIES = 601
_LEAST_LEVEL = -60.0  # dB
_KILO = 1e-3  # kilohertz in a hertz
_GREYS = "Greys"  # colour map of the amplitude
#: Line style of a band, visible on dark and bright colours.
_BAND: dict[str, Any] = {
    "color": ORANGE, "linewidth": 0.9, "linestyle": "--",
    "path_effects": [withStroke(linewidth=2.0, foreground="white")],
}  # fmt: skip


def is_along_x(case: Case) -> bool:
    """Return True if the line of a packing is along x, in a packing of one layer."""
    return "z" not in case.packing.rule.axes


def has_bands(case: Case, assembly: Assembly) -> bool:
    """Return True for chains and lattices under a static load along the line of their waves.

    Lattices with layers have periodic sides; lattices of one layer have free sides.
    """
    if case.precompression is None or case.packing.grains is not None:
        return False
    rule = case.packing.rule
    stage = case.precompression.rule
    if rule.is_layer:
        return bool(stage.on_all_faces and assembly.plain)
    if not stage.on_top:
        return False
    unlike = case.packing.vacancies or case.replace or case.striker
    return bool(rule.is_chain or (case.boundary.periodic and not unlike))


def structure_along(case: Case, packing: Assembly) -> BandStructure:
    """Return the bands of a packing along its line.

    Parameters
    ----------
    case
        Case of the run.
    packing
        Its bodies, or substitutes such as identical spheres.

    Raises
    ------
    InputError
        The packing is not periodic, or carries no load.
    """
    spacing = 1.0 if is_along_x(case) else case.packing.rule.layer_spacing
    edge = math.pi / (spacing * case.packing.diameter)
    path = f"0,0,0; {edge!r},0,0" if is_along_x(case) else f"0,0,0; 0,0,{edge!r}"
    return band_structure(packing, path, points=_POINTS, allow_floppy=True)


def transform_along(result: Result, structure: BandStructure) -> SpaceTime:
    """Return the transform of the velocities along the line, over the Brillouin zone of the line.

    Raises
    ------
    MissingDataError
        The run of a chain has no history.
    ValueError
        The positions along the line are not uniform, or there is only one.
    """
    time, place, velocity = velocities_along(result, 0 if is_along_x(result.case) else 2)
    if len(place) < _FEWEST_PLACES:
        raise ValueError(f"found {len(place)} place along the line, expected two or more")
    top = 1.2 * float(np.nanmax(structure.bands.frequency))
    k = np.linspace(0.02, 1, 99) * math.pi / float(np.diff(place).mean())
    return space_time_transform(time, place, velocity, k, np.linspace(0, top, _FREQUENCIES))


def transform_drawing(transform: SpaceTime, structure: BandStructure, title: str = "") -> Drawing:
    """Draw a transform in grey, and the bands on it."""
    figure, axes = panels(2.6)
    bands = structure.bands
    edge = transform.k[-1]
    level = 20 * np.log10(np.maximum(transform.amplitude, 1e-6))
    image = axes.pcolormesh(
        transform.k / edge,
        _KILO * transform.frequency,
        np.maximum(level, _LEAST_LEVEL),
        cmap=_GREYS,
        rasterized=True,
        shading="nearest",
    )
    figure.colorbar(image, ax=axes, label="Amplitude (dB)")
    columns: dict[str, Array] = {
        "k_rad_per_m": transform.k,
        "ridge_Hz": transform.ridge(STRONGEST),
        "band_k_rad_per_m": bands.path.distance,
    }
    place = bands.path.distance / edge
    for n, frequency in enumerate(bands.frequency.T, start=1):
        name = "bands of small waves" if n == 1 else None
        axes.plot(place, _KILO * frequency, color=ORANGE, linewidth=0.8, linestyle="--", label=name)
        columns[f"band{n}_Hz"] = frequency
    axes.set(xlabel="Wave number (π/spacing)", ylabel="Frequency (kHz)", xlim=(0, 1))
    axes.set_ylim(0, _KILO * transform.frequency[-1])
    if title:
        axes.set_title(title)
    else:
        legend_above(axes, 1)
    return Drawing(figure, columns)


def dispersion(result: Result) -> Drawing | None:
    """Draw the transform of a run with its bands; None without bands along its line, or without a
    history.
    """
    case = result.case
    if case.striker or not has_bands(case, result.assembly):
        return None
    if case.packing.diameter_scatter > 0:
        return None
    try:
        structure = structure_along(case, result.assembly)
        transform = transform_along(result, structure)
    except (InputError, MissingDataError, ValueError):
        return None
    return transform_drawing(transform, structure)


DISPERSION = RunFigure(
    "Transform of the motion in space and time, with the bands of small waves",
    dispersion,
    "Dark ridges on the dashed lines are waves of the linear theory; ridges off the lines come "
    "from large forces.",
    takes_long=True,
)
