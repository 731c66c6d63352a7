"""Figures of chains, rows and lines of grains: forces and velocities in position and time, peaks,
transmission.
"""

from __future__ import annotations

import dataclasses
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize, SymLogNorm
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator, ScalarFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.impact_arrow import impact_arrow
from granwave.analysis.figures.series import (
    COLOURS,
    LINES,
    against_time,
    energy_unit,
    label,
    panels,
    velocity_unit,
)
from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREY,
    ORANGE,
    WAVE_MAP,
    Drawing,
    legend_above,
)
from granwave.analysis.formatting.numbers import instant
from granwave.analysis.measures.driven import (
    MULTIPLES,
    SteadyMotion,
    amplitude_sweep_of,
    transmission_of,
)
from granwave.analysis.measures.force_decay import BEFORE_END
from granwave.analysis.measures.fronts import AXIS, LineMotion, line_motions
from granwave.analysis.measures.leading_wave import leading_peaks
from granwave.analysis.measures.lines import LineRecord, lines_of, sensor_forces
from granwave.analysis.result.reader import Result

_MICRO = 1e6
_MILLI = 1e3
_KILO = 1e-3
_MOST_CURVES = 5
_DECADES = 3.0  # decades of force in the map
_LINEAR = 30.0  # largest dynamic force / force up to which the scale of the map is linear
_MOST_COLUMNS = 2000  # largest number of columns of a map
_AFTER = 2.0  # end of the diagram of a line over the last arrival
_FEWEST_TIMES = 8  # instants of a diagram of a line
_DECADES_OF_SPEED = 3.0  # decades of speed in the diagram of a line
_EDGE = [withStroke(linewidth=2.2, foreground="white")]  # visible on dark and bright colours
_ARRIVALS: dict[str, Any] = {
    "color": "black", "markersize": 2.6, "markeredgecolor": "white", "markeredgewidth": 0.4,
}  # fmt: skip
_FITTED: dict[str, Any] = {
    "color": ORANGE, "linewidth": 1.1, "path_effects": _EDGE, "zorder": 1.5
}  # fmt: skip
_MOST_OF_A_LINE = 12  # largest number of curves of a line of grains
_FEWEST = 2  # fewest contacts along which forces are drawn
_SAME = 1e-3  # relative difference of equal forces
_LEAST_FORCE = 1e-4  # fraction of the largest force: contacts that the wave reached
_WIDE_FORCES = 30.0  # largest over smallest value from which on an axis is logarithmic
_WIDE = 0.05  # smallest / largest amplitude below which the axis is logarithmic


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


def force_histories(result: Result) -> Drawing | None:
    """Draw the force histories of some of the loaded contacts, evenly spaced along the chain."""
    if "chain" not in result:
        return None
    force = result["chain/contact_force"]
    time = result["chain/time"]
    loaded = np.flatnonzero(force.max(axis=0, initial=0.0) > 0)
    if not len(loaded):
        return None
    chosen = np.unique(
        np.linspace(0, loaded[-1], min(_MOST_CURVES, loaded[-1] + 1)).round().astype(int)
    )
    figure, axes = panels(2.9)
    scale, unit = _unit(force)
    for n, line in zip(chosen, LINES, strict=False):
        against_time(axes, time, force[:, n] * scale, line, label=_name(result, n), linewidth=0.9)
    label(axes, y=f"Contact force ({unit})")
    legend_above(axes, 3, title="Contact")
    return Drawing(
        figure, {"time_s": time} | {f"contact_{_name(result, n)}_N": force[:, n] for n in chosen}
    )


def along_chain(result: Result) -> Drawing | None:
    """Draw peak force and dissipated energy of every contact along the chain.

    The forces are those of the first wave, before the reflection from the end, above the static
    force; grey marks are the largest forces of the run where they are larger. Under a load that
    keeps oscillating they are the largest of the run only. None for a single contact.
    """
    if "chain" not in result:
        return None
    peak = result.along_chain("peak_force")
    lost = result.along_chain("dissipated_energy")
    if len(peak) < _FEWEST or not np.any(peak):
        return None
    number = np.arange(1, len(peak) + 1)
    is_first = not result.case.load.keeps_oscillating
    first = leading_peaks(result) if is_first else np.zeros(len(peak))
    has_panel_of_loss = bool(np.any(lost > 0))
    n_panels = 1 + has_panel_of_loss
    figure, upper, *lower = panels(1.0 + 1.4 * n_panels, rows=n_panels, sharex=True)
    _draw_peaks_along(upper, result, first)
    for axes in lower:
        energy, name = energy_unit(float(lost.max()))
        _dots(axes, number, lost * energy, "dissipated")
        _scale_axis(axes, lost * energy, f"Dissipated ({name})")
    label(figure.axes[-1], f"Contact, {_counted(result)}")
    figure.axes[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    ids = {"i": result["chain/contact_i"], "j": result["chain/contact_j"]}
    columns = {"contact": number, **ids, "peak_force_N": peak, "dissipated_energy_J": lost}
    if is_first:
        columns["first_wave_peak_force_N"] = first
    return Drawing(figure, columns)


def _draw_peaks_along(axes: Axes, result: Result, first: NDArray[np.float64]) -> None:
    """Draw the peak forces of the first wave along a chain, and of the run where they differ.

    Parameters
    ----------
    first
        Of the first wave, above the static force: (n_contacts,), N; 0 or NaN where not known.
    """
    peak = result.along_chain("peak_force")
    has_risen = result.along_chain("time_peak") < BEFORE_END * float(result["energy/time"][-1])
    static = np.zeros(len(peak))
    if result.case.precompression is not None:
        static = result["chain/contact_force"][0]
    scale, unit = _unit(peak)
    whole = np.where(has_risen, peak - static, 0.0) * scale
    whole = np.where(whole > _LEAST_FORCE * whole.max(initial=0.0), whole, 0.0)
    shown = np.nan_to_num(first) * scale
    number = np.arange(1, len(peak) + 1)
    differs = whole > (1 + _SAME) * shown
    if np.any(differs):
        look: Any = {"color": GREY, "markersize": 3, "label": "largest of the run"}
        axes.plot(number[differs], whole[differs], "x", **look)
    if np.any(shown > 0):
        _dots(axes, number, shown, "first wave")
    kind = "Dynamic peak force" if np.any(static > 0) else "Peak force"
    _scale_axis(axes, np.maximum(whole, shown), f"{kind} ({unit})")
    legend_above(axes, 2)


def _dots(axes: Axes, number: NDArray, values: NDArray[np.float64], name: str) -> None:
    """Draw positive values of contacts as dots."""
    shown = values > 0
    axes.plot(number[shown], values[shown], ".", color=BLUE, markersize=3, label=name)


def _scale_axis(axes: Axes, values: NDArray[np.float64], quantity: str) -> None:
    """Make an axis logarithmic if its positive values span much, otherwise linear from 0."""
    positive = values[values > 0]
    is_wide = len(positive) and positive.max() > _WIDE_FORCES * positive.min()
    label(axes, y=quantity)
    if is_wide:
        axes.set_yscale("log")
    else:
        axes.set_ylim(0, 1.05 * float(values.max()))


def bead_velocities(result: Result) -> Drawing | None:
    """Draw the velocity along the chain at four instants."""
    if "chain" not in result:
        return None
    time = result["chain/time"]
    velocity = result["chain/velocity"]
    chosen = np.unique(np.linspace(0, len(time) - 1, 5).round().astype(int))[1:]
    figure, axes = panels(2.6)
    bead = np.arange(1, velocity.shape[1] + 1)
    scale, unit = velocity_unit(float(np.abs(velocity[chosen]).max(initial=0.0)))
    for n, line in zip(chosen, LINES, strict=False):
        name = instant(time[n])
        axes.plot(bead, velocity[n] * scale, linestyle=line, linewidth=0.9, label=name)
    axes.axhline(0, color="black", linewidth=0.5)
    label(axes, f"Bead, {_counted(result)}", f"Velocity ({unit})")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend_above(axes, 2)
    return Drawing(
        figure, {"bead": bead} | {f"velocity_at_{time[n]:.6g}_s_m_s": velocity[n] for n in chosen}
    )


def bars(result: Result) -> Drawing | None:
    """Draw the contact force on each bar, and its energy."""
    bars_of_run = result.assembly.bars
    if not bars_of_run:
        return None
    figure, upper, lower = panels(3.4, rows=2, sharex=True)
    columns: dict[str, NDArray] = {"energy_time_s": result["energy/time"]}
    for bar, line in zip(bars_of_run, cycle(LINES), strict=False):
        time = result[f"walls/{bar.name}/time"]
        force = result[f"walls/{bar.name}/force"]
        energy = result[f"energy/{bar.name}"]
        against_time(upper, time, force * _KILO, line, linewidth=0.9)
        against_time(lower, result["energy/time"], energy, line, label=bar.name.replace("_", " "))
        columns |= {
            f"{bar.name}_time_s": time,
            f"{bar.name}_contact_force_N": force,
            f"{bar.name}_energy_J": energy,
        }
    label(upper, y="Contact force\non the bar (kN)")
    label(lower, y="Energy in the bar (J)")
    lower.legend()
    return Drawing(figure, columns)


def sensors(result: Result) -> Drawing | None:
    """Draw the mean contact force of the beads with a sensor."""
    if "chain" not in result or not result.case.sensor:
        return None
    time = result["chain/time"]
    forces = sensor_forces(result)
    scale, unit = _unit(np.stack(list(forces.values())))
    figure, axes = panels(2.2)
    for (name, force), line in zip(forces.items(), cycle(LINES), strict=False):
        against_time(axes, time, force * scale, line, label=name, linewidth=0.9)
    label(axes, y=f"Sensor force ({unit})")
    axes.legend()
    return Drawing(
        figure, {"time_s": time} | {f"{name}_N": force for name, force in forces.items()}
    )


def _name(result: Result, contact: int) -> str:
    """Return the label of a contact from the labels of its bodies, such as ``3-4``."""
    first = _name_of_body(result, int(result["chain/contact_i"][contact]))
    second = _name_of_body(result, int(result["chain/contact_j"][contact]))
    return f"{first}-{second}"


def _name_of_body(result: Result, number: int) -> str:
    """Return the number of a bead, ``S`` with its number for a striker, or ``bar``."""
    n_beads = result.assembly.lattice.n_spheres
    if number <= n_beads:
        return str(number)
    if number <= result.assembly.n_spheres:
        return f"S{number - n_beads}"
    return "bar"


def _counted(result: Result) -> str:
    """Return the end from which contacts and beads are counted."""
    return f"from the {'loaded' if result.case.load.driven else 'impacted'} end"


def _unit(force: NDArray[np.float64]) -> tuple[float, str]:
    return (_KILO, "kN") if np.max(force, initial=0.0) >= 1e4 else (1.0, "N")


def line_speeds(result: Result) -> Drawing | None:
    """Draw the speeds of the grains of each line against time, from first (dark) to last (light)."""
    lines = [line for line in lines_of(result) if line.straight]
    if not lines:
        return None
    figure, *stack = panels(0.7 + 1.9 * len(lines), rows=len(lines), sharex=True)
    columns = {"time_s": result[f"lines/{lines[0].name}/time"]}
    for axes, line in zip(stack, lines, strict=True):
        group = f"lines/{line.name}"
        time = result[f"{group}/time"]
        ids = result[f"{group}/id"]
        speed = np.linalg.norm(result[f"{group}/velocity"], axis=2)
        n_grains = speed.shape[1]
        last = n_grains - 1
        names = {0: "first grain", last: "last grain"}
        places = np.linspace(0, last, min(n_grains, _MOST_OF_A_LINE))
        for grain in np.unique(places.round().astype(int)):
            colour = colormaps["viridis"](0.9 * grain / max(last, 1))
            name = names.get(int(grain))
            against_time(axes, time, speed[:, grain], color=colour, linewidth=0.8, label=name)
            columns[f"{line.name}_{ids[grain]}_m_s"] = speed[:, grain]
        title = line.name if len(lines) > 1 else ""
        label(axes, y="Speed (m/s)", title=title, ylim=(0, None))
        axes.legend()
    return Drawing(figure, columns)


def line_decay(result: Result) -> Drawing | None:
    """Draw the peak speeds along each line against distance, with the broken line that is fitted to
    them.
    """
    lines = [
        line
        for line in lines_of(result)
        if line.straight and np.isfinite(line.peak_speed).sum() > 1
    ]
    if not lines:
        return None
    figure, *stack = panels(0.7 + 1.9 * len(lines), rows=len(lines))
    columns: dict[str, NDArray] = {}
    for axes, line in zip(stack, lines, strict=True):
        _draw_decay(axes, line)
        label(axes, y="Peak speed (m/s)", title=line.name if len(lines) > 1 else "", yscale="log")
        axes.yaxis.set(major_formatter=ScalarFormatter(), minor_formatter=ScalarFormatter())
        columns |= {
            f"{line.name}_distance_m": line.distance,
            f"{line.name}_peak_m_s": line.peak_speed,
            f"{line.name}_arrival_s": line.arrival,
            f"{line.name}_width_s": line.width,
            f"{line.name}_lateral_force_N": line.lateral_force,
        }
    label(stack[-1], "Distance along the line (mm)")
    return Drawing(figure, columns)


def _draw_decay(axes: Axes, line: LineRecord) -> None:
    kept = np.arange(len(line.distance)) < line.fitted.stop
    for chosen, colour, face in ((kept, BLUE, BLUE), (~kept, GREY, "white")):
        place = line.distance[chosen] * _MILLI
        speed = line.peak_speed[chosen]
        axes.plot(place, speed, "o", markersize=3, color=colour, markerfacecolor=face)
    decay = line.decay
    if decay is None:
        return

    def shape(x: NDArray[np.float64]) -> NDArray[np.float64]:
        return -decay.first * x - (decay.second - decay.first) * np.maximum(x - decay.border, 0)

    fitted = kept & np.isfinite(line.peak_speed) & (line.peak_speed > 0)
    height = np.mean(np.log(line.peak_speed[fitted]) - shape(line.distance[fitted]))
    x = np.sort(np.append(line.distance[fitted], decay.border))
    axes.plot(x * _MILLI, np.exp(shape(x) + height), color=ORANGE, linewidth=0.9)
    axes.axvline(decay.border * _MILLI, color=GREY, linestyle=":", linewidth=0.8)


def line_diagram(result: Result) -> Drawing | None:
    """Draw the speed of the grains of lines in position and time, with the arrivals of the wave and
    the line through them.

    The lines are the chain, or the grains nearest to the axis of the load, and each ``[[line]]``.
    """
    arrow = impact_arrow(result)
    motions = [
        motion
        for motion in line_motions(result, arrow.place, arrow.direction)
        if motion.velocity.any()
    ]
    if not motions:
        return None
    figure, *stack = panels(0.9 + 2.5 * len(motions), rows=len(motions))
    columns: dict[str, NDArray] = {}
    for axes, motion in zip(stack, motions, strict=True):
        image = _draw_motion(axes, motion, result.figure_options.colour_map or FORCE_MAP)
        figure.colorbar(image, ax=axes, label="Speed along the line (m/s)", extend="min")
        columns |= _columns_of_motion(motion)
    return Drawing(figure, columns)


def _draw_motion(axes: Axes, motion: LineMotion, colours: str) -> Any:
    """Draw the speed of the grains of a line by colour; return the image, for a colour bar."""
    speed = np.abs(motion.velocity)
    largest = float(speed.max())
    least = largest / 10**_DECADES_OF_SPEED
    norm = LogNorm(least, largest)
    rows = slice(None, None, max(1, len(motion.time) // _MOST_COLUMNS))
    places = slice(None, None, max(1, len(motion.place) // _MOST_COLUMNS))
    shown = speed[rows, places]
    # behind the front, grains that are slow for an instant have the lowest colour
    behind = motion.time[rows, None] >= motion.arrival[places]
    shown = np.where(behind & (shown > 0), np.maximum(shown, least), shown)
    shown = np.where(shown >= least, shown, np.nan)
    image = space_time_map(axes, motion.place[places], motion.time[rows], shown, norm, colours)
    left, _ = axes.get_xlim()
    limits = (left, _last_moved(motion, least), 0.0, _last_shown(motion))
    reached = np.isfinite(motion.arrival)
    axes.plot(
        motion.place[reached] * _MILLI,
        motion.arrival[reached] * _MICRO,
        "o",
        label="front at a grain",
        **_ARRIVALS,
    )
    if motion.front is not None:
        ends = motion.front.place[[0, -1]]
        text = f"fitted: {motion.front.speed:.4g} m/s"
        axes.plot(ends * _MILLI, motion.front.when(ends) * _MICRO, "-", label=text, **_FITTED)
    axes.axis(limits)
    title = "Distance along the load (mm)" if motion.name == AXIS else f"Along {motion.name} (mm)"
    label(axes, title, "Time (µs)")
    if reached.any():
        legend_above(axes, 2)
    return image


def _last_moved(motion: LineMotion, least: float) -> float:
    """Return the end of the axis of positions, beyond the last coloured grain, mm."""
    coloured = np.flatnonzero(np.abs(motion.velocity).max(axis=0) > least)
    last = min(int(coloured[-1]) + 1, len(motion.place) - 1)
    spacing = motion.place[last] - motion.place[last - 1]
    return float(motion.place[last] + 0.5 * spacing) * _MILLI


def _last_shown(motion: LineMotion) -> float:
    """Return the end of the axis of times, some time after the last arrival of the wave, µs."""
    end = float(motion.time[-1])
    arrived = np.isfinite(motion.arrival)
    if arrived.any():
        end = min(end, _AFTER * float(motion.arrival[arrived].max()))
    if np.count_nonzero(motion.time <= end) < _FEWEST_TIMES:
        end = float(motion.time[-1])
    return end * _MICRO


def _columns_of_motion(motion: LineMotion) -> dict[str, NDArray]:
    """Return the data of a line: a row for each grain at each instant, and for each grain."""
    n_times = len(motion.time)
    columns = {
        f"{motion.name}_time_s": np.repeat(motion.time, len(motion.place)),
        f"{motion.name}_id": np.tile(motion.ids, n_times),
        f"{motion.name}_place_m": np.tile(motion.place, n_times),
        f"{motion.name}_velocity_m_s": motion.velocity.ravel(),
        f"{motion.name}_arrival_s": motion.arrival,
    }
    if motion.front is not None:
        columns[f"{motion.name}_front_speed_m_s"] = np.array([motion.front.speed])
    return columns


def transmission(result: Result) -> Drawing | None:
    """Draw the amplitudes along a chain under a harmonic load, or the transmission of a burst, a
    sweep or noise.
    """
    response = transmission_of(result)
    if response is None:
        return None
    figure, axes = panels(2.6)
    if isinstance(response, SteadyMotion):
        bead = np.arange(1, len(response.velocity) + 1)
        size = np.abs(response.velocity)
        axes.semilogy(
            bead, np.where(size > 0, size, np.nan), ".-", color=BLUE, markersize=3, linewidth=0.8
        )
        if response.last < len(size):
            axes.axvspan(response.last + 0.5, len(size) + 0.5, color=GREY, alpha=0.2, linewidth=0)
            place = (response.last + 0.5 + (len(size) - response.last) / 2, 0.04)
            axes.text(
                *place, "absorbing", transform=axes.get_xaxis_transform(), ha="center", color=GREY
            )
        label(axes, "Bead, from the loaded end", f"Velocity at {response.frequency:.4g} Hz (m/s)")
        axes.set_xlim(0.5, len(size) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        columns = {
            "bead": bead,
            "velocity_amplitude_m_s": size,
            "phase_rad": np.angle(response.velocity),
        }
        return Drawing(figure, columns | {"left_by_fit": response.left})
    ratio = np.abs(response.ratio)
    axes.plot(response.frequency * 1e-3, ratio, color=BLUE, linewidth=0.8)
    label(
        axes,
        "Frequency (kHz)",
        f"Velocity ratio, bead {response.last} / bead {response.first}",
    )
    axes.axhline(1.0, color=GREY, linewidth=0.6)
    axes.set(**({"yscale": "log"} if ratio.min() < _WIDE * ratio.max() else {"ylim": (0, None)}))
    columns = {
        "frequency_Hz": response.frequency,
        "ratio": np.abs(response.ratio),
        "phase_rad": np.angle(response.ratio),
    }
    return Drawing(figure, columns)


def amplitude_sweep(result: Result) -> Drawing | None:
    """Draw the velocity of the last bead against the amplitude of the load, rising and falling."""
    sweep = amplitude_sweep_of(result)
    if sweep is None:
        return None
    scale, unit = result.case.load.shown_amplitude
    names = ("load's frequency", "twice", "three times", "half of it")
    figure, axes = panels(2.9)
    columns = {"load": sweep.load, "rising": sweep.rising.astype(int)}
    for number, name in enumerate(names):
        look: Any = {"color": COLOURS[number], "linewidth": 0.9}
        for chosen, line, called in ((sweep.rising, "-", name), (~sweep.rising, "--", None)):
            axes.plot(
                sweep.load[chosen] * scale, sweep.last[number][chosen], line, label=called, **look
            )
        columns[f"last_at_{MULTIPLES[number]:g}_f_m_s"] = sweep.last[number]
        columns[f"first_at_{MULTIPLES[number]:g}_f_m_s"] = sweep.first[number]
    label(
        axes,
        f"Load amplitude ({unit}; dashed: falling)",
        "Velocity of the last bead (m/s)",
        log="y",
    )
    axes.set_xlim(0, None)
    legend_above(axes, 2)
    return Drawing(figure, columns)
