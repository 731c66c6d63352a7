"""Maps of a layer of spheres: discs at their places, coloured by a value at several instants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from granwave.analysis.figures.style import FORCE_MAP, Drawing, new_figure
from granwave.analysis.measures.impact.regions import Snapshots

_MILLI = 1e3  # mm in a metre


def speed_maps(seen: Snapshots, diameter: float, times: Sequence[float]) -> Drawing:
    """Speed of the spheres of a square packing at the snapshots nearest to times, s.

    Parameters
    ----------
    diameter
        Of the spheres, m.
    """
    n, radius = seen.size[0] * seen.size[1], _MILLI * diameter / 2
    place = _MILLI * seen.position[:, :2]
    frames = [int(np.abs(seen.time - time).argmin()) for time in times]
    speeds = [np.linalg.norm(seen.velocity[frame], axis=1) for frame in frames]
    norm = Normalize(0, max(float(speed[:n].max()) for speed in speeds) or 1.0)
    low, high = place[:n].min(axis=0) - radius, place[:n].max(axis=0) + radius
    figure = new_figure(2.6)
    columns: dict[str, NDArray] = {"id": np.arange(1, len(place) + 1)}
    columns |= {"x_m": seen.position[:, 0], "y_m": seen.position[:, 1]}
    panels = figure.subplots(1, len(times), sharey=True, squeeze=False)[0]
    for axes, time, speed in zip(panels, seen.time[frames], speeds, strict=True):
        size = np.full(n, 2 * radius)
        discs = EllipseCollection(
            size, size, np.zeros(n), units="xy", offsets=place[:n], offset_transform=axes.transData, array=speed[:n],
            cmap=FORCE_MAP, norm=norm,
        )  # fmt: skip
        axes.add_collection(discs)
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal", xlabel="x (mm)")
        axes.set_title(f"{1e3 * time:.2f} ms")
        columns[f"speed_at_{1e6 * time:.0f}_us_m_s"] = speed
    panels[0].set_ylabel("y (mm)")
    figure.colorbar(discs, ax=list(panels), label="Speed (m/s)", location="bottom", shrink=0.8)
    return Drawing(figure, columns)
