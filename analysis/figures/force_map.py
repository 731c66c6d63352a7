"""Force along a chain and its bars in space and time."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from numpy.typing import NDArray

from granwave.analysis.figures.series import (
    label,
    panels,
)
from granwave.analysis.figures.style import (
    FORCE_MAP,
    WAVE_MAP,
    Drawing,
)
from granwave.analysis.result.reader import Result

_MICRO = 1e6
_MILLI = 1e3
_DECADES = 3.0  # decades of force in the map
_LINEAR = 30.0  # largest dynamic force / force up to which the scale of the map is linear
_MOST_COLUMNS = 2000  # largest number of columns of a map


@dataclasses.dataclass(frozen=True)
class _ForcesAlong:
    """Forces along a chain or a bar.

    Attributes
    ----------
    name
        Name of the part.
    place
        (n_places,), m.
    force
        (n_times, n_places), N.
    """

    name: str
    place: NDArray[np.float64]
    force: NDArray[np.float64]

    @property
    def largest(self) -> float:
        """Largest magnitude of a force, N."""
        return float(np.abs(self.force).max())

    def of_wave(self) -> _ForcesAlong:
        """Return the changes since the first instant."""
        return dataclasses.replace(self, force=self.force - self.force[0])


def force_map(result: Result) -> Drawing | None:
    """Draw the contact force, and the magnitude of the force in bars, in space and time."""
    if "chain" not in result or not np.any(result["chain/contact_force"]):
        return None
    time = result["chain/time"]
    parts = _forces_along(result)
    is_small = _is_small_wave(result)
    if is_small:
        parts = [part.of_wave() for part in parts]
    largest = max(part.largest for part in parts) or 1.0
    lowest = 10**-_DECADES * largest
    norm: Normalize = LogNorm(lowest, largest)
    if is_small:
        norm = SymLogNorm(largest / _LINEAR, vmin=-largest, vmax=largest)
    colours = result.figure_options.colour_map or (WAVE_MAP if is_small else FORCE_MAP)
    widths = [1.0 if part.name == "chain" else 0.7 for part in parts]
    width = 3.4 if len(parts) == 1 else 6.6
    figure, *row = panels(3.2, len(parts), width=width, sharey=True, width_ratios=widths)
    columns = {"time_s": time}
    for axes, part in zip(row, parts, strict=True):
        step = max(1, len(part.place) // _MOST_COLUMNS)
        shown = part.force[:, ::step]
        if not is_small:
            shown = np.where(shown > lowest, shown, np.nan)
        image = space_time_map(axes, part.place[::step], time, shown, norm, colours)
        axes.set_title(part.name if len(parts) > 1 else "")
        columns |= _force_columns(part)
    label(row[0], y="Time (µs)")
    quantity = "Dynamic force (N)" if is_small else "Force (N)"
    figure.colorbar(image, ax=row[-1], label=quantity)
    return Drawing(figure, columns)


def _forces_along(result: Result) -> list[_ForcesAlong]:
    """Return the forces in the chain and in the bars before and behind it, in this order."""
    chain = _ForcesAlong("chain", result["chain/contact_position"], result["chain/contact_force"])
    parts = [chain]
    for bar in result.assembly.bars:
        nodes = result[f"bars/{bar.name}/position"]
        middles = 0.5 * (nodes[1:] + nodes[:-1])
        force = np.abs(result[f"bars/{bar.name}/force"])
        part = _ForcesAlong(bar.name.replace("_", " "), middles, force)
        if bar.face == bar.last:
            parts.insert(0, part)
        else:
            parts.append(part)
    return parts


def _is_small_wave(result: Result) -> bool:
    """Return True if contacts are pressed at the start, and their forces change by less than the
    largest static force.
    """
    force = result["chain/contact_force"]
    if result.case.precompression is None or not np.any(force[0] > 0):
        return False
    return bool(np.abs(force - force[0]).max() < force[0].max())


def _force_columns(part: _ForcesAlong) -> dict[str, NDArray[np.float64]]:
    """Return the forces at some places, evenly spaced, by the name of the column."""
    every = max(1, len(part.place) // 20)
    slug = part.name.replace(" ", "_")
    columns = {}
    for n in range(0, len(part.place), every):
        name = f"{slug}_at_{1e3 * part.place[n]:.4g}_mm_N"
        columns[name] = part.force[:, n]
    return columns


def space_time_map(
    axes: Axes,
    place: NDArray[np.float64],
    time: NDArray[np.float64],
    force: NDArray[np.float64],
    norm: Any,
    map: str,
) -> Any:
    """Draw forces (n_instants, n_places) by colour; return the image, for a colour bar."""
    axes.set_xlabel("Position (mm)")
    options: Any = {"norm": norm, "cmap": map, "rasterized": True, "shading": "nearest"}
    return axes.pcolormesh(place * _MILLI, time * _MICRO, force, **options)
