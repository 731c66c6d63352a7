"""Figures of a continuum run, each written as NAME.png, NAME.pdf and NAME.csv to ``figures``."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.dissipation import draw_zone_size
from granwave.analysis.figures.series import (
    against_time,
    label,
    legend_outside,
    limits_of_error,
    one_panel,
    panels,
)
from granwave.analysis.figures.style import (
    BLANK,
    BLUE,
    FORCE_MAP,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    Drawing,
)
from granwave.analysis.measures.zone_size import BOTTOM, SIDES
from granwave.extensions.continuum.punch.solver import AT_YIELD
from granwave.extensions.continuum.runner import ElementResult

_MICRO = 1e6
_MILLI = 1e3
_MEGA = 1e-6
_SHOWN = 1.5  # smallest depth, and width, of a section in punch diameters
_PANELS = 6
_LINES = {  # lines of the energies
    "punch": ("-", GREY), "kinetic": ("-.", BLUE), "elastic": ("--", GREEN),
    "plastic": ((0, (8, 2)), ORANGE), "viscous": ((0, (1, 1)), PURPLE),
    "hourglass": ((0, (5, 1, 1, 1, 1, 1)), SKY), "contact": ((0, (3, 3)), "black"),
}  # fmt: skip
_YIELDED_MAP = ListedColormap([BLANK, SKY, ORANGE])


class ContinuumResult(ElementResult):
    """The ``result.h5`` of a continuum run with its mesh; raise as `ElementResult`."""

    def __init__(self, directory: str | Path) -> None:
        super().__init__(directory)
        self.r = np.unique(self["nodes"][:, 0])
        self.z = np.unique(self["nodes"][:, 1])

    def grid(self, values: NDArray) -> NDArray:
        """Return the values of the elements as an array (n_z, n_r)."""
        return values.reshape(len(self.z) - 1, len(self.r) - 1)

    @property
    def centres(self) -> dict[str, NDArray[np.float64]]:
        """Radii and depths of the elements' centres, (n_elements,), m."""
        r, z = np.meshgrid((self.r[1:] + self.r[:-1]) / 2, (self.z[1:] + self.z[:-1]) / 2)
        return {"r_m": r.ravel(), "z_m": z.ravel()}


def energies(result: ContinuumResult) -> Drawing:
    """Draw all energies, and the residual of their sum."""
    time = result["energy/time"]
    energy_input = result["energy/input"]
    parts = {name: result[f"energy/{name}"] for name in _LINES}
    residual = np.abs(np.sum(list(parts.values()), axis=0) - energy_input) / energy_input
    figure, upper, lower = panels(3.6, rows=2, sharex=True, height_ratios=(3, 1))
    for name, values in parts.items():
        line, colour = _LINES[name]
        against_time(upper, time, values, line, color=colour, label=name)
    against_time(upper, time, energy_input, ":", color="black", label="input")
    label(upper, y="Energy (J)", ylim=(0, 1.45 * energy_input[0]))
    upper.legend(ncols=3, loc="upper center", columnspacing=1.0)
    against_time(lower, time, np.where(residual > 0, residual, np.nan), color=GREY, linewidth=0.8)
    label(lower, y="|Residual|\n/ input", log="y", **limits_of_error(residual))
    columns = {"time_s": time, **{f"{name}_J": values for name, values in parts.items()}}
    return Drawing(figure, columns | {"input_J": energy_input, "residual_over_input": residual})


def plastic_zone_volume(result: ContinuumResult) -> Drawing:
    """Draw the volume at yield and the volume that has yielded so far, divided by the volume of a
    sphere with the diameter of the punch.
    """
    time = result["plastic_zone/time"]
    sphere = math.pi / 6 * result.tables["punch"]["diameter"] ** 3
    now = result["plastic_zone/volume"]
    ever = result["plastic_zone/volume_ever"]
    figure, axes = one_panel(2.3, "", "Plastic volume / ($\\pi D^3/6$)")
    against_time(axes, time, now / sphere, color=ORANGE, label="at yield now")
    against_time(axes, time, ever / sphere, "--", color=BLUE, label="ever at yield")
    axes.set_ylim(bottom=0)
    axes.legend()
    return Drawing(figure, {"time_s": time, "volume_m3": now, "volume_ever_m3": ever})


def plastic_zone_size(result: ContinuumResult) -> Drawing | None:
    """Draw the fractions of plastic work beyond a depth and a radius, with the sizes of the zone;
    None without plastic work.
    """
    centres = result.centres
    ever = result.grid(result["fields/ever_yielded"])
    distances = {"depth": centres["z_m"], "radius": centres["r_m"]}
    bounds = {BOTTOM: float(result.z[-1])} if ever[-1].any() else {}
    bounds |= {SIDES: float(result.r[-1])} if ever[:, -1].any() else {}
    work = result["fields/plastic_energy"] * result["element_volume"]
    return draw_zone_size(
        work, distances, result.tables["punch"]["diameter"], "D_\\mathrm{punch}", bounds
    )


def punch(result: ContinuumResult) -> Drawing:
    """Draw the force on the punch and its velocity."""
    time, force, velocity = (result[f"punch/{name}"] for name in ("time", "force", "velocity"))
    figure, upper, lower = panels(3.0, rows=2, sharex=True)
    against_time(upper, time, force / 1e3, color=BLUE)
    label(upper, y="Force (kN)")
    lower.axhline(0, color="black", linewidth=0.5)
    against_time(lower, time, velocity, color=ORANGE)
    label(lower, y="Velocity (m/s)")
    columns = {"time_s": time, "force_N": force, "velocity_m_s": velocity}
    return Drawing(figure, columns | {"displacement_m": result["punch/displacement"]})


def von_mises(result: ContinuumResult) -> Drawing:
    """Draw the von Mises stress in a section, at the snapshot nearest to the time of the largest
    plastic zone.
    """
    largest = result["plastic_zone/time"][result["plastic_zone/volume"].argmax()]
    frame = int(np.abs(result["fields/time"] - largest).argmin())
    stress = result["fields/von_mises"][frame]
    scale = Normalize(0, result.tables["material"]["yield_strength"] * _MEGA)
    figure, axes = _section_with_bar(
        result, stress * _MEGA, FORCE_MAP, scale, "Von Mises stress (MPa)"
    )
    axes.set_title(f"{result['fields/time'][frame] * _MICRO:.1f} µs")
    return Drawing(figure, result.centres | {"von_mises_Pa": stress})


def plastic_zone(result: ContinuumResult) -> Drawing:
    """Draw the elements at yield, now and earlier, at several times of the growth of the zone."""
    times = result["fields/time"]
    stresses = result["fields/von_mises"]
    at_yield = stresses >= AT_YIELD * result.tables["material"]["yield_strength"]
    active = np.flatnonzero(at_yield.any(axis=1))
    last = int(active[-1]) if len(active) else len(times) - 1
    frames = np.unique(np.linspace(min(1, last), last, _PANELS).round().astype(int))
    figure, *grid = panels(3.0, 3, 2, width=5.2, sharex=True, sharey=True)
    columns = result.centres
    for axes, frame in zip(grid, frames, strict=False):
        state = np.where(at_yield[frame], 2, np.where(at_yield[: frame + 1].any(axis=0), 1, 0))
        _section(axes, result, state, _YIELDED_MAP, Normalize(0, 2))
        axes.set_title(f"{times[frame] * _MICRO:.1f} µs")
        columns[f"state_{times[frame] * _MICRO:.2f}us"] = state
    for n, axes in enumerate(grid):
        axes.set_visible(n < len(frames))
        axes.label_outer()
    for colour, name in ((ORANGE, "at yield"), (SKY, "yielded earlier"), (BLANK, "elastic")):
        grid[0].plot([], [], "s", color=colour, markersize=5, label=name)
    legend_outside(figure, 3)
    return Drawing(figure, columns)


def plastic_strain(result: ContinuumResult) -> Drawing:
    """Draw the final equivalent plastic strain in a section."""
    strain = result["fields/plastic_strain"]
    largest = float(np.quantile(strain[strain > 0], 0.99)) if np.any(strain > 0) else 1.0
    scale = Normalize(0, 100 * largest)
    label = "Equivalent plastic strain (%)"
    figure, _ = _section_with_bar(result, 100 * strain, "inferno", scale, label, extend="max")
    return Drawing(figure, result.centres | {"plastic_strain": strain})


def _section_with_bar(
    result: ContinuumResult,
    values: NDArray,
    colours: str,
    scale: Normalize,
    label: str,
    **options: Any,
) -> tuple[Figure, Axes]:
    figure, axes = one_panel(2.1, "", "")
    _section(axes, result, values, colours, scale)
    figure.colorbar(ScalarMappable(scale, colours), ax=axes, label=label, shrink=0.8, **options)
    return figure, axes


def _section(
    axes: Axes, result: ContinuumResult, values: NDArray, colours: str | ListedColormap, scale
) -> None:
    """Draw a section, mirrored at the axis, below the punch, cropped to the plastic zone."""
    diameter = result.tables["punch"]["diameter"]
    zone = max(result.summary["plastic_zone_depth_m"], result.summary["plastic_zone_radius_m"])
    reach = max(_SHOWN * diameter / 2, 1.3 * zone)
    columns, rows = (int(np.searchsorted(line, reach)) + 1 for line in (result.r, result.z))
    r = result.r[:columns] * _MILLI
    z = result.z[:rows] * _MILLI
    part = result.grid(values)[: len(z) - 1, : len(r) - 1]
    for side in (-1, 1):
        axes.pcolormesh(side * r, z, part, cmap=colours, norm=scale, rasterized=True)
    half = diameter / 2 * _MILLI
    axes.fill_between([-half, half], 0, -0.15 * reach * _MILLI, color=GREY, linewidth=0)
    axes.set(
        xlim=(-reach * _MILLI, reach * _MILLI),
        ylim=(reach * _MILLI, -0.15 * reach * _MILLI),
        aspect="equal",
    )
    axes.set(xlabel="r (mm)", ylabel="Depth (mm)")


RESULT = ContinuumResult
#: Functions that draw a figure of a result, by name.
FIGURES: dict[str, Callable[[ContinuumResult], Drawing | None]] = {
    draw.__name__: draw
    for draw in (
        energies,
        plastic_zone,
        plastic_zone_volume,
        plastic_zone_size,
        von_mises,
        plastic_strain,
        punch,
    )
}
