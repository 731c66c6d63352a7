"""Figure of energy and dissipation by direction from the point of impact."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from numpy.typing import NDArray

from granwave.analysis.figures.series import panels
from granwave.analysis.figures.style import BLUE, DISSIPATION_MAP, FORCE_MAP, ORANGE, WIDTH, Drawing
from granwave.analysis.formatting.numbers import instant
from granwave.analysis.measures import waves
from granwave.analysis.measures.geometry import preferred_directions
from granwave.analysis.result.reader import Result

_LEAST_SPHERES = 8
_TITLE_HEIGHT = 0.7  # inches
_LEAST_OF_EVEN = 0.1  # fraction relative to isotropic, at the dark end of the scale


def directions(result: Result) -> Drawing | None:
    """Draw the fractions of travelling energy and dissipation by direction: polar for a layer, else
    stereographic.

    Crystals in the x-z plane have no such figure: their grains do not surround the impact in a
    layer, and would be on a line in a stereographic view.
    """
    if not result.case.packing.rule.has_faces:
        return None
    if result.n_spheres < _LEAST_SPHERES or result.n_frames < 2:
        return None
    frame = waves.travelling_frame(result)
    time = result.frame_times[frame]
    spreads = {
        f"Energy at {instant(time)}": waves.spread(result, waves.energy_of_spheres(result, frame)),
        "Dissipation": waves.spread(result, result["spheres/dissipated_energy"]),
    }
    shown = {name: spread for name, spread in spreads.items() if spread is not None}
    if not shown:
        return None
    layer = waves.is_layer(result)
    height = (
        (WIDTH / 2 if len(shown) > 1 else 0.7 * WIDTH) + _TITLE_HEIGHT + (0.0 if layer else 0.5)
    )
    polar = {"projection": "polar"}
    figure, *row = panels(height, len(shown), width=WIDTH, subplot_kw=polar)
    draw = _draw_layer if layer else _draw_half_sphere
    columns: dict[str, NDArray] = {}
    for axes, (name, spread), colours in zip(
        row, shown.items(), ((BLUE, FORCE_MAP), (ORANGE, DISSIPATION_MAP)), strict=False
    ):
        title = f"{name}\n{100 * spread.along:.0f} % along contacts\n(isotropic: {100 * spread.even:.0f} %)"
        columns |= draw(result, axes, spread, *colours)
        axes.set_title(title)
        axes.set_xticks(np.deg2rad([0, 90, 180, 270]), ["x", "y", "", ""])
        columns[f"{name.split()[0].lower()}_share"] = spread.cells.ravel()
    return Drawing(figure, columns)


def _draw_layer(
    _: Result, axes: Any, spread: waves.Spread, colour: str, __: str
) -> dict[str, NDArray]:
    """Draw the fractions of a layer as bars; return the columns of the directions."""
    angle = np.arange(waves.LAYER_BINS) * 360 / waves.LAYER_BINS - 180
    axes.bar(
        np.deg2rad(angle), 100 * spread.cells, np.deg2rad(360 / waves.LAYER_BINS), color=colour
    )
    axes.yaxis.set_major_formatter("{x:.0f} %")
    axes.yaxis.get_major_locator().base.set_params(nbins=3)
    return {"angle_deg": angle}


def _draw_half_sphere(
    result: Result, axes: Any, spread: waves.Spread, _: str, colours: str
) -> dict[str, NDArray]:
    """Draw the fractions below the impact in a stereographic view; return the columns of the
    directions.
    """
    edges = np.deg2rad(
        np.arange(waves.PER_RING + 1) * 360 / waves.PER_RING - 180 - 180 / waves.PER_RING
    )
    depth = 1 - np.arange(waves.RINGS + 1) / waves.RINGS  # cosine of the angle to the impact axis
    axis = preferred_directions(result.case.packing.kind)
    norm = LogNorm(_LEAST_OF_EVEN, max(float(spread.relative.max()), 1 / _LEAST_OF_EVEN))
    colours = result.figure_options.colour_map or colours
    radius = 2 * np.tan(np.arccos(depth) / 2)
    shown = np.maximum(spread.relative, _LEAST_OF_EVEN)
    mesh = axes.pcolormesh(edges, radius, shown, cmap=colours, norm=norm, rasterized=True)
    ring: dict[str, Any] = {"markerfacecolor": "none", "markeredgecolor": "white", "markersize": 9}
    axes.plot(
        np.arctan2(axis[:, 1], axis[:, 0]), 2 * np.tan(np.arccos(axis[:, 2]) / 2), "o", **ring
    )
    axes.set_yticks(2 * np.tan(np.deg2rad([30, 60]) / 2), ["30°", "60°"], color="white")
    axes.set_rlabel_position(90)
    axes.grid(alpha=0.3)
    axes.figure.colorbar(
        mesh,
        ax=axes,
        orientation="horizontal",
        label="Relative to isotropic",
        pad=0.12,
        extend="min",
    )
    return {
        "axis_angle_deg": np.repeat(
            np.rad2deg(np.arccos((depth[1:] + depth[:-1]) / 2)), waves.PER_RING
        ),
        "azimuth_deg": np.tile(np.rad2deg((edges[1:] + edges[:-1]) / 2), waves.RINGS),
    }
