"""Figures of a continuum run, each written as NAME.png, NAME.pdf and NAME.csv to ``figures``."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.plastic_zone import draw_zone_size
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
from granwave.analysis.formatting.numbers import quantity_in
from granwave.analysis.measures.zone_size import BOTTOM, SIDES
from granwave.extensions.continuum.punch.solver import AT_YIELD
from granwave.extensions.continuum.runner import ElementResult

_MICRO = 1e6
_MILLI = 1e3
_MEGA = 1e-6
_SHOWN = 1.5  # smallest depth, and width, of a section in punch diameters
_SMALL = 0.1  # fraction of this depth below which only the plastic zone is shown
_AROUND = 3.0  # half width, and depth, of this part in sizes of the zone
_ABOVE = 0.075  # height of the punch over the width of the part
_PANELS = 6
_IN_ROW = 3  # panels side by side
_NEARLY_ALL = 0.99  # fraction of the plastic dissipation at the last panel
_AFTER_CONTACT = 1.5  # time shown, over the duration of the contact
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
    """Draw the force on the punch and its velocity during the contact; the data are of the whole
    run.
    """
    time, force, velocity = (result[f"punch/{name}"] for name in ("time", "force", "velocity"))
    figure, upper, lower = panels(3.0, rows=2, sharex=True)
    shown = time <= _AFTER_CONTACT * _end_of_contact(time, force)
    against_time(upper, time[shown], force[shown] / 1e3, color=BLUE)
    label(upper, y="Force (kN)")
    lower.axhline(0, color="black", linewidth=0.5)
    against_time(lower, time[shown], velocity[shown], color=ORANGE)
    label(lower, y="Velocity (m/s)")
    if not shown.all():
        upper.set_title(f"contact; the run ends at {quantity_in(float(time[-1]), 's')}")
    columns = {"time_s": time, "force_N": force, "velocity_m_s": velocity}
    return Drawing(figure, columns | {"displacement_m": result["punch/displacement"]})


def _end_of_contact(time: NDArray, force: NDArray) -> float:
    """Return the time from which on the punch does not touch, s; the end of the run if it does."""
    loaded = np.flatnonzero(force > 0)
    if not len(loaded):
        return float(time[-1])
    return float(time[min(int(loaded[-1]) + 1, len(time) - 1)])


def von_mises(result: ContinuumResult) -> Drawing:
    """Draw the von Mises stress in a section, at the instant of the largest plastic zone, or of the
    largest stress if nothing yields.
    """
    times = result["fields/time"]
    volume = result["plastic_zone/volume"]
    if volume.any():
        largest = result["plastic_zone/time"][volume.argmax()]
        frame = int(np.abs(times - largest).argmin())
        instant = "largest plastic zone"
    else:
        frame = int(result["fields/von_mises"].max(axis=1).argmax())
        instant = "largest stress"
    stress = result["fields/von_mises"][frame]
    scale = Normalize(0, result.tables["material"]["yield_strength"] * _MEGA)
    figure, axes = _section_with_bar(
        result, _whole(result), stress * _MEGA, FORCE_MAP, scale, "Von Mises stress (MPa)"
    )
    axes.set_title(f"{times[frame] * _MICRO:.3g} µs, {instant}")
    return Drawing(figure, result.centres | {"von_mises_Pa": stress})


def plastic_zone(result: ContinuumResult) -> Drawing | None:
    """Draw the elements at yield, now and earlier, at several times of the growth of the zone and
    after it; None if nothing yields.
    """
    times = result["fields/time"]
    stresses = result["fields/von_mises"]
    at_yield = stresses >= AT_YIELD * result.tables["material"]["yield_strength"]
    frames = _frames_of_growth(result, at_yield)
    if not len(frames):
        return None
    window = _zone_window(result)
    ever = result["fields/ever_yielded"] > 0
    rows = math.ceil(len(frames) / _IN_ROW)
    figure, *grid = panels(0.3 + 1.35 * rows, _IN_ROW, rows, width=5.2, sharex=True, sharey=True)
    columns = result.centres
    for axes, frame in zip(grid, frames, strict=False):
        is_last = frame == frames[-1]
        earlier = ever if is_last else at_yield[: frame + 1].any(axis=0)
        state = np.where(at_yield[frame], 2, np.where(earlier, 1, 0))
        _section(axes, result, window, state, _YIELDED_MAP, Normalize(0, 2))
        until = " to the end" if is_last else ""
        axes.set_title(f"{times[frame] * _MICRO:.3g} µs{until}")
        columns[f"state_{times[frame] * _MICRO:.2f}us"] = state
    for n, axes in enumerate(grid):
        axes.set_visible(n < len(frames))
        axes.label_outer()
        if n + _IN_ROW >= len(frames):
            axes.tick_params(labelbottom=True)
            axes.set_xlabel("r (mm)")
    for colour, name in ((ORANGE, "at yield"), (SKY, "yielded earlier"), (BLANK, "elastic")):
        grid[0].plot([], [], "s", color=colour, markersize=5, label=name)
    legend_outside(figure, 3)
    return Drawing(figure, columns)


def _frames_of_growth(result: ContinuumResult, at_yield: NDArray) -> NDArray[np.int64]:
    """Return snapshots from the first yield to the instant at which nearly all plastic dissipation
    has taken place, at nearly equal intervals, one of them at the largest zone; and the next one
    without elements at yield.
    """
    active = np.flatnonzero(at_yield.any(axis=1))
    if not len(active):
        return active
    times = result["fields/time"]
    plastic = result["energy/plastic"]
    grown = int((plastic >= _NEARLY_ALL * plastic[-1]).argmax())
    end = max(float(result["energy/time"][grown]), float(times[active[0]]))
    last = min(int(np.searchsorted(times, end)), len(times) - 1)
    wanted = np.linspace(times[active[0]], times[last], _PANELS - 1)
    frames = [int(np.abs(times - instant).argmin()) for instant in wanted]
    largest = result["plastic_zone/time"][result["plastic_zone/volume"].argmax()]
    nearest = int(np.abs(times - largest).argmin())
    if active[0] <= nearest <= last:
        frames[int(np.abs(wanted - largest).argmin())] = nearest
    at_rest = np.flatnonzero(~at_yield[last:].any(axis=1))
    after = last + int(at_rest[0]) if len(at_rest) else len(times) - 1
    return np.unique([*frames, after])


def plastic_strain(result: ContinuumResult) -> Drawing | None:
    """Draw the final equivalent plastic strain in a section; None if nothing yielded."""
    strain = result["fields/plastic_strain"]
    if not strain.any():
        return None
    largest = float(np.quantile(strain[strain > 0], 0.99))
    scale = Normalize(0, 100 * largest)
    label = "Equivalent plastic strain (%)"
    figure, _ = _section_with_bar(
        result, _zone_window(result), 100 * strain, "inferno", scale, label, extend="max"
    )
    return Drawing(figure, result.centres | {"plastic_strain": strain})


class _Window(NamedTuple):
    """Part of a section: radii and depth, m; negative radii are on the other side of the axis."""

    inner: float
    outer: float
    depth: float


def _whole(result: ContinuumResult) -> _Window:
    """Return the part below the punch with the plastic zone, on both sides of the axis."""
    diameter = result.tables["punch"]["diameter"]
    zone = max(result.summary["plastic_zone_depth_m"], result.summary["plastic_zone_radius_m"])
    reach = max(_SHOWN * diameter / 2, 1.3 * zone)
    return _Window(-reach, reach, reach)


def _zone_window(result: ContinuumResult) -> _Window:
    """Return the part with the plastic zone: if it is small, only the part at the edge of the
    punch.
    """
    whole = _whole(result)
    ever = result.grid(result["fields/ever_yielded"]).astype(bool)
    columns = np.flatnonzero(ever.any(axis=0))
    if not len(columns):
        return whole
    inner = float(result.r[columns[0]])
    outer = float(result.r[columns[-1] + 1])
    size = max(result.summary["plastic_zone_depth_m"], outer - inner)
    if size > _SMALL * whole.depth:
        return whole
    middle = (inner + outer) / 2
    return _Window(max(middle - _AROUND * size, 0.0), middle + _AROUND * size, _AROUND * size)


def _section_with_bar(
    result: ContinuumResult,
    window: _Window,
    values: NDArray,
    colours: str,
    scale: Normalize,
    label: str,
    **options: Any,
) -> tuple[Figure, Axes]:
    figure, axes = one_panel(2.1, "", "")
    _section(axes, result, window, values, colours, scale)
    figure.colorbar(ScalarMappable(scale, colours), ax=axes, label=label, shrink=0.8, **options)
    return figure, axes


def _section(
    axes: Axes,
    result: ContinuumResult,
    window: _Window,
    values: NDArray,
    colours: str | ListedColormap,
    scale: Normalize,
) -> None:
    """Draw a part of a section, mirrored at the axis, below the punch."""
    diameter = result.tables["punch"]["diameter"]
    columns = int(np.searchsorted(result.r, window.outer)) + 1
    rows = int(np.searchsorted(result.z, window.depth)) + 1
    r = result.r[:columns] * _MILLI
    z = result.z[:rows] * _MILLI
    part = result.grid(values)[: len(z) - 1, : len(r) - 1]
    for side in (-1, 1):
        axes.pcolormesh(side * r, z, part, cmap=colours, norm=scale, rasterized=True)
    half = diameter / 2 * _MILLI
    top = -_ABOVE * (window.outer - window.inner) * _MILLI
    axes.fill_between([-half, half], 0, top, color=GREY, linewidth=0)
    axes.set(
        xlim=(window.inner * _MILLI, window.outer * _MILLI),
        ylim=(window.depth * _MILLI, top),
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
