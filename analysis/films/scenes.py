"""Scenes of a film: a figure that is drawn again for every instant of a run, with a clock and one colour scale.

A section shows the spheres of a plane as discs, the cut packing all spheres in sight, and the chain the forces of its
contacts in space-time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from granwave.analysis.figures.run.packing3d import bar_location, can_be_cut, draw_packing
from granwave.analysis.figures.run.sections import (
    DISSIPATION_LIMITS,
    Colouring,
    colour_bar,
    cut_of,
    decades_up_to,
    disc_radii,
    draw_discs,
    force_scale,
    frame_axes,
    window_around,
)
from granwave.analysis.figures.style import BLUE, DISSIPATION_MAP, FORCE_MAP, GREY, WIDTH, new_figure
from granwave.analysis.measures.geometry import Section as PlaneSection
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError

_MICRO, _MILLI = 1e6, 1e3
_DECADES = 3.0  # of the forces of a chain
_MOST_INSTANTS = 120  # of a chain, which has up to a thousand


@dataclass(frozen=True)
class Quantity:
    """Quantity that a film shows: values of the spheres at a snapshot, and how they are coloured."""

    values: Callable[[Result, int], NDArray[np.float64]]
    label: str
    map: str


QUANTITIES: Mapping[str, Quantity] = {
    "force": Quantity(
        lambda result, number: result.frame(number, "contact_force") / force_scale(result)[0],
        "Contact force",
        FORCE_MAP,
    ),
    "velocity": Quantity(
        lambda result, number: np.linalg.norm(result.frame(number, "velocity"), axis=1), "Speed (m/s)", FORCE_MAP
    ),
    "dissipation": Quantity(
        lambda result, number: result.frame(number, "dissipated_energy") / result.energy_input,
        r"Dissipation $e_\mathrm{dis}/e_\mathrm{in}$",
        DISSIPATION_MAP,
    ),
}
PLANES = ("orthogonal", "principal", "section")
VIEWS = (*PLANES, "3d", "chain")


class Scene(ABC):
    """Pictures of a run in time.

    Attributes
    ----------
    times
        Instants, s: (n,).
    """

    times: NDArray[np.float64]

    @abstractmethod
    def draw(self, number: int) -> Figure:
        """Draw the instant of this number; the figure may be that of the call before."""


Size = tuple[float, float] | None  # width and height, inches


def scene(result: Result, quantity: str, view: str | None, size: Size = None) -> Scene:
    """Return the scene of a run.

    Parameters
    ----------
    quantity
        One of `QUANTITIES`; chains show forces.
    view
        One of `VIEWS`; None for the chain in space-time, or the first plane that the packing has.
    size
        Width and height of the pictures, inches; by default a column, as high as the view needs.

    Raises
    ------
    InputError
        The run has no such view, or nothing of this quantity.
    """
    if view == "chain" or (view is None and "chain" in result):
        return _Chain(result, size)
    if view == "3d":
        return _Packing(result, quantity, size)
    for name in PLANES if view is None else (view,):
        if (found := cut_of(result, name)) is not None:
            return _Section(result, quantity, found, size)
    if view == "section" and result.figure_options.plane is None:
        raise InputError("--view section: it is the plane of --plane, or of figures.plane in the case; give one")
    kinds = "no plane of spheres" if view is None else f"no {view} plane"
    raise InputError(f"{result.case.name}: a {result.case.packing.kind} packing has {kinds}; take --view 3d or chain")


def _colourings(result: Result, quantity: str, rows: NDArray[np.intp] | slice) -> list[Colouring]:
    """Return the colouring of every snapshot, on one scale."""
    shown = QUANTITIES[quantity]
    values = [shown.values(result, number) for number in range(len(result.frame_times))]
    largest = max(float(np.max(one[rows], initial=0.0)) for one in values)
    if not largest > 0:
        raise InputError(f"{result.case.name}: there is no {quantity} in any snapshot; take another --quantity")
    options = result.figure_options
    low, high = decades_up_to(largest, None)
    if quantity == "dissipation":
        low, high = options.dissipation_limits or (DISSIPATION_LIMITS[0], max(DISSIPATION_LIMITS[1], largest))
    elif quantity == "force":
        low, high = options.force_limits or (low, high)
    colours = options.colour_map or shown.map
    label = f"{shown.label} {force_scale(result)[1]}" if quantity == "force" else shown.label
    return [Colouring(one, label, quantity, colours, low, high) for one in values]


def _figure(height: float, size: Size) -> Figure:
    figure = new_figure(height)
    if size is not None:
        figure.set_size_inches(size)
    return figure


def _clock(figure: Figure, time: float) -> None:
    figure.text(0.98, 0.985, f"{time * _MICRO:.0f} µs", ha="right", va="top", fontsize=9)


class _Section(Scene):
    def __init__(self, result: Result, quantity: str, cut: PlaneSection, size: Size) -> None:
        self.times, self._size = result.frame_times, size
        self._result, self._cut = result, cut
        rows = cut.index
        self._colourings = _colourings(result, quantity, rows)
        reached = np.max([one.values[rows] for one in self._colourings], axis=0) >= self._colourings[0].low
        self._window = window_around(cut, reached, result.case.packing.diameter)

    def draw(self, number: int) -> Figure:
        """Draw the discs of the plane."""
        cut, colouring = self._cut, self._colourings[number]
        left, right, top, bottom = self._window
        height = (WIDTH - 0.6) * (bottom - top) / (right - left) + 1.2
        figure = _figure(min(max(height, 2.1), 6.0), self._size)
        axes = figure.subplots()
        values = colouring.values[cut.index]
        draw_discs(axes, cut, values, colouring, disc_radii(self._result, cut))
        frame_axes(axes, self._window)
        axes.set_xlabel(f"{'x' if cut.plane.down_label == 'y' else cut.plane.across_label} (mm)")
        axes.set_ylabel(f"{cut.plane.down_label} (mm)")
        axes.set_title(" ", fontsize=9)  # room for the clock
        ends = np.array([colouring.low, colouring.high])
        colour_bar(figure, [axes], colouring, ends, bar_location(self._size))
        _clock(figure, float(self.times[number]))
        return figure


class _Packing(Scene):
    def __init__(self, result: Result, quantity: str, size: Size) -> None:
        self.times, self._result, self._size = result.frame_times, result, size
        self._colourings = _colourings(result, quantity, slice(None))
        if not can_be_cut(result):
            raise InputError(f"{result.case.name}: nothing to cut open; take --view chain, or a plane")

    def draw(self, number: int) -> Figure:
        """Draw the cut packing."""
        drawing = draw_packing(self._result, self._colourings[number], self._size)
        assert drawing is not None
        _clock(drawing.figure, float(self.times[number]))
        return drawing.figure


class _Chain(Scene):
    def __init__(self, result: Result, size: Size) -> None:
        self._size, self._map = size, result.figure_options.colour_map or FORCE_MAP
        if "chain" not in result:
            raise InputError(
                f"{result.case.name}: no record of a chain in time; --view chain is for chains of five beads and more "
                "(output.history)"
            )
        time, self._force = result["chain/time"], result["chain/contact_force"]
        self._all_times, self._place = time, result["chain/contact_position"] * _MILLI
        self._largest = float(np.max(self._force, initial=0.0))
        if not self._largest > 0:
            raise InputError(f"{result.case.name}: no contact bore a force; there is nothing to film")
        self._rows = np.unique(np.linspace(0, len(time) - 1, min(_MOST_INSTANTS, len(time))).round().astype(int))
        self.times = time[self._rows]

    def draw(self, number: int) -> Figure:
        """Draw the forces now and the largest so far, above the map of all forces until now."""
        row = self._rows[number]
        figure = _figure(4.2, self._size)
        now, map_axes = figure.subplots(2, 1, sharex=True, height_ratios=(1, 1.3))
        norm = LogNorm(10**-_DECADES * self._largest, self._largest)
        now.fill_between(self._place, self._force[: row + 1].max(axis=0), color="0.85", linewidth=0)
        now.plot(self._place, self._force[row], color=BLUE)
        now.set_ylim(0, 1.05 * self._largest)
        now.set_ylabel("Force (N)")
        now.set_title(" ", fontsize=9)
        shown = np.where(self._force > norm.vmin, self._force, np.nan)
        shown[row + 1 :] = np.nan
        image = map_axes.pcolormesh(
            self._place, self._all_times * _MICRO, shown, norm=norm, cmap=self._map, rasterized=True, shading="nearest"
        )
        map_axes.axhline(self.times[number] * _MICRO, color=GREY, linewidth=0.6)
        map_axes.set_ylim(0, self._all_times[-1] * _MICRO)
        map_axes.set_xlabel("Place (mm)")
        map_axes.set_ylabel("Time (µs)")
        figure.colorbar(image, ax=map_axes, label="Force (N)")
        _clock(figure, float(self.times[number]))
        return figure
