"""Distribution of energy and dissipation over directions from the impact point."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, DISSIPATION_MAP, FORCE_MAP, ORANGE, WIDTH, Drawing, new_figure
from granwave.analysis.measures.geometry import preferred_directions
from granwave.analysis.measures.waves import (
    LAYER_BINS,
    PER_RING,
    RINGS,
    Spread,
    energy_of_spheres,
    is_layer,
    spread,
    travelling_frame,
)
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.plane_lattices import is_plane_crystal

_MICRO = 1e6
_LEAST_SPHERES = 8
_TITLE_HEIGHT = 0.7  # inches


def directions(result: Result) -> Drawing | None:
    """Draw the shares of travelling energy and dissipation by direction: polar for a layer, else stereographic.

    Not of crystals in the x-z plane, which are no layer about the impact, and would be a line in a stereographic view.
    """
    kind = result.case.packing.kind
    if kind == "chain" or is_plane_crystal(kind) or not len(preferred_directions(kind)):
        return None
    if result.n_spheres < _LEAST_SPHERES or result.n_frames < 2:
        return None
    frame = travelling_frame(result)
    time = result.frame_times[frame]
    found = {
        f"Energy at {time * _MICRO:.0f} µs": spread(result, energy_of_spheres(result, frame)),
        "Dissipation": spread(result, result["spheres/dissipated_energy"]),
    }
    panels = {name: one for name, one in found.items() if one is not None}
    if not panels:
        return None
    return _layer(result, panels) if is_layer(result) else _half_sphere(result, panels)


def _title(name: str, one: Spread) -> str:
    return f"{name}\n{100 * one.along:.0f} % along contacts\n(even spread: {100 * one.even:.0f} %)"


def _layer(result: Result, panels: dict[str, Spread]) -> Drawing:
    figure = new_figure(WIDTH / 2 + _TITLE_HEIGHT if len(panels) > 1 else 0.7 * WIDTH + _TITLE_HEIGHT)
    angle = np.arange(LAYER_BINS) * 360 / LAYER_BINS - 180
    columns: dict[str, NDArray] = {"angle_deg": angle}
    all_axes = figure.subplots(1, len(panels), subplot_kw={"projection": "polar"}, squeeze=False)[0]
    for axes, (name, one), colour in zip(all_axes, panels.items(), (BLUE, ORANGE), strict=False):
        axes.bar(np.deg2rad(angle), 100 * one.cells, np.deg2rad(360 / LAYER_BINS), color=colour)
        axes.set_title(_title(name, one))
        axes.set_xticks(np.deg2rad([0, 90, 180, 270]), ["x", "y", "", ""])
        axes.yaxis.set_major_formatter("{x:.0f} %")
        axes.yaxis.get_major_locator().base.set_params(nbins=3)  # type: ignore[union-attr]
        columns[f"{name.split()[0].lower()}_share"] = one.cells
    return Drawing(figure, columns)


def _half_sphere(result: Result, panels: dict[str, Spread]) -> Drawing:
    figure = new_figure(WIDTH / 2 + _TITLE_HEIGHT + 0.5 if len(panels) > 1 else 0.7 * WIDTH + _TITLE_HEIGHT + 0.5)
    edges = np.deg2rad(np.arange(PER_RING + 1) * 360 / PER_RING - 180 - 180 / PER_RING)
    depth = 1 - np.arange(RINGS + 1) / RINGS  # cosine of the angle to the impact axis
    radius = 2 * np.tan(np.arccos(depth) / 2)
    chosen = result.figure_options.colour_map
    maps = (chosen or FORCE_MAP, chosen or DISSIPATION_MAP)
    axis = preferred_directions(result.case.packing.kind)
    columns: dict[str, NDArray] = {
        "axis_angle_deg": np.repeat(np.rad2deg(np.arccos((depth[1:] + depth[:-1]) / 2)), PER_RING),
        "azimuth_deg": np.tile(np.rad2deg((edges[1:] + edges[:-1]) / 2), RINGS),
    }
    all_axes = figure.subplots(1, len(panels), subplot_kw={"projection": "polar"}, squeeze=False)[0]
    for axes, (name, one), colours in zip(all_axes, panels.items(), maps, strict=False):
        shown = one.relative
        mesh = axes.pcolormesh(
            edges, radius, shown, cmap=colours, norm=Normalize(0, float(shown.max())), rasterized=True
        )
        axes.plot(
            np.arctan2(axis[:, 1], axis[:, 0]), 2 * np.tan(np.arccos(axis[:, 2]) / 2), "o",
            markerfacecolor="none", markeredgecolor="white", markersize=9,
        )  # fmt: skip
        axes.set_title(_title(name, one))
        axes.set_xticks(np.deg2rad([0, 90, 180, 270]), ["x", "y", "", ""])
        axes.set_yticks(2 * np.tan(np.deg2rad([30, 60]) / 2), ["30°", "60°"], color="white")
        axes.set_rlabel_position(90)
        axes.grid(alpha=0.3)
        figure.colorbar(mesh, ax=axes, orientation="horizontal", label="Share over even spread", pad=0.12)
        columns[f"{name.split()[0].lower()}_share"] = one.cells.ravel()
    return Drawing(figure, columns)
