"""Figures of a chain: maps of forces in space and time, histories of contacts, peak forces, bars and sensors."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from granwave.analysis.figures.style import (
    BLUE,
    FORCE_MAP,
    GREEN,
    ORANGE,
    PURPLE,
    SKY,
    Drawing,
    legend_above,
    new_figure,
)
from granwave.analysis.measures.sensors import sensor_forces
from granwave.analysis.result.chain import along
from granwave.analysis.result.reader import Result

_MICRO, _MILLI, _KILO = 1e6, 1e3, 1e-3
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, SKY)
_DECADES = 3.0  # range of the colour scale of forces
_MOST_COLUMNS = 2000  # of a map


def force_map(result: Result) -> Drawing | None:
    """Draw the contact force, and the magnitude of the force in bars, in space and time."""
    if "chain" not in result or not np.any(result["chain/contact_force"]):
        return None
    time = result["chain/time"]
    panels = [("chain", result["chain/contact_position"], result["chain/contact_force"])]
    for bar in result.assembly.bars:
        nodes = result[f"bars/{bar.name}/position"]
        panel = (bar.name.replace("_", " "), 0.5 * (nodes[1:] + nodes[:-1]), np.abs(result[f"bars/{bar.name}/force"]))
        panels.insert(0 if bar.face == bar.last else len(panels), panel)
    largest = max(float(force.max()) for _, _, force in panels)
    norm = LogNorm(10**-_DECADES * largest, largest)
    widths = [1.0 if name == "chain" else 0.7 for name, _, _ in panels]
    figure = new_figure(3.2, 3.4 if len(panels) == 1 else 6.6)
    row = figure.subplots(1, len(panels), sharey=True, squeeze=False, width_ratios=widths)[0]
    pictures = []
    for axes, (name, place, force) in zip(row, panels, strict=True):
        step = max(1, len(place) // _MOST_COLUMNS)
        shown = np.where(force[:, ::step] > norm.vmin, force[:, ::step], np.nan)
        mesh = {"norm": norm, "cmap": FORCE_MAP, "rasterized": True, "shading": "nearest"}
        pictures.append(axes.pcolormesh(place[::step] * _MILLI, time * _MICRO, shown, **mesh))
        axes.set_xlabel("Place (mm)")
        if len(panels) > 1:
            axes.set_title(name)
    row[0].set_ylabel("Time (µs)")
    figure.colorbar(pictures[-1], ax=row[-1], label="Force (N)")
    columns = {"time_s": time}
    for name, place, force in panels:
        every = max(1, len(place) // 20)
        label = name.replace(" ", "_")
        columns |= {f"{label}_at_{1e3 * z:.4g}_mm_N": force[:, n] for n, z in list(enumerate(place))[::every]}
    return Drawing(figure, columns)


def force_histories(result: Result) -> Drawing | None:
    """Draw the force history of some contacts, evenly spread over the loaded ones."""
    if "chain" not in result:
        return None
    force, time = result["chain/contact_force"], result["chain/time"]
    loaded = np.flatnonzero(force.max(axis=0, initial=0.0) > 0)
    if not len(loaded):
        return None
    chosen = np.unique(np.linspace(0, loaded[-1], min(len(_COLOURS), loaded[-1] + 1)).round().astype(int))
    figure = new_figure(2.9)
    axes = figure.subplots()
    scale, unit = _unit(force)
    for n, colour in zip(chosen, _COLOURS, strict=False):
        axes.plot(time * _MICRO, force[:, n] * scale, color=colour, label=_name(result, n), linewidth=0.9)
    _time_axes(axes, time)
    axes.set_ylabel(f"Contact force ({unit})")
    legend_above(axes, 3, title="Contact")
    return Drawing(figure, {"time_s": time} | {f"contact_{_name(result, n)}_N": force[:, n] for n in chosen})


def along_chain(result: Result) -> Drawing | None:
    """Draw peak force and dissipated energy of every contact along the chain."""
    if "chain" not in result:
        return None
    peak, lost = (along(result, name) for name in ("peak_force", "dissipated_energy"))
    if not np.any(peak):
        return None
    number = np.arange(1, len(peak) + 1)
    dissipates = bool(np.any(lost > 0))
    figure = new_figure(3.6 if dissipates else 2.2)
    stack = figure.subplots(2 if dissipates else 1, 1, sharex=True, squeeze=False)[:, 0]
    scale, unit = _unit(peak)
    curves = [(stack[0], peak * scale, f"Peak force ({unit})")]
    if dissipates:
        energy, name = (1e3, "mJ") if lost.max() < 1 else (1.0, "J")
        curves.append((stack[1], lost * energy, f"Dissipated ({name})"))
    for axes, values, label in curves:
        shown = values > 0
        axes.plot(number[shown], values[shown], ".", color=BLUE, markersize=3)
        axes.set_ylabel(label)
        if shown.any() and values[shown].max() > 30 * values[shown].min():
            axes.set_yscale("log")
        else:
            axes.set_ylim(bottom=0)
    stack[-1].set_xlabel("Contact, from the struck end")
    stack[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
    ids = {"i": result["chain/contact_i"], "j": result["chain/contact_j"]}
    return Drawing(figure, {"contact": number, **ids, "peak_force_N": peak, "dissipated_energy_J": lost})


def bead_velocities(result: Result) -> Drawing | None:
    """Draw the velocity along the chain at four instants."""
    if "chain" not in result:
        return None
    time, velocity = result["chain/time"], result["chain/velocity"]
    chosen = np.unique(np.linspace(0, len(time) - 1, 5).round().astype(int))[1:]
    figure = new_figure(2.6)
    axes = figure.subplots()
    bead = np.arange(1, velocity.shape[1] + 1)
    for n, colour in zip(chosen, _COLOURS, strict=False):
        axes.plot(bead, velocity[n], color=colour, linewidth=0.9, label=f"{time[n] * _MICRO:.4g} µs")
    axes.axhline(0, color="black", linewidth=0.5)
    axes.set_xlabel("Bead, from the struck end")
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylabel("Velocity (m/s)")
    legend_above(axes, 2)
    return Drawing(figure, {"bead": bead} | {f"velocity_at_{time[n]:.6g}_s_m_s": velocity[n] for n in chosen})


def bars(result: Result) -> Drawing | None:
    """Draw the contact force on each bar, and its energy."""
    found = result.assembly.bars
    if not found:
        return None
    figure = new_figure(3.4)
    upper, lower = figure.subplots(2, 1, sharex=True)
    columns: dict[str, NDArray] = {"energy_time_s": result["energy/time"]}
    for bar, colour in zip(found, _COLOURS, strict=False):
        name, label = bar.name, bar.name.replace("_", " ")
        time, force = result[f"walls/{name}/time"], result[f"walls/{name}/force"]
        upper.plot(time * _MICRO, force * _KILO, color=colour, label=label, linewidth=0.9)
        lower.plot(result["energy/time"] * _MICRO, result[f"energy/{name}"], color=colour, label=label)
        columns |= {
            f"{name}_time_s": time,
            f"{name}_contact_force_N": force,
            f"{name}_energy_J": result[f"energy/{name}"],
        }
    upper.set_ylabel("Contact force\non the bar (kN)")
    lower.set_ylabel("Energy in the bar (J)")
    lower.legend()
    _time_axes(lower, result["energy/time"])
    return Drawing(figure, columns)


def sensors(result: Result) -> Drawing | None:
    """Draw the mean contact force of the beads with a sensor."""
    if "chain" not in result or not result.case.sensor:
        return None
    time, forces = result["chain/time"], sensor_forces(result)
    scale, unit = _unit(np.stack(list(forces.values())))
    figure = new_figure(2.2)
    axes = figure.subplots()
    for (name, force), colour in zip(forces.items(), _COLOURS * len(forces), strict=False):
        axes.plot(time * _MICRO, force * scale, color=colour, label=name, linewidth=0.9)
    _time_axes(axes, time)
    axes.set_ylabel(f"Sensor force ({unit})")
    axes.legend()
    return Drawing(figure, {"time_s": time} | {f"{name}_N": force for name, force in forces.items()})


def _name(result: Result, contact: int) -> str:
    """Return the label of a contact from the numbers of its beads, S for strikers and "bar" for bars."""
    n, spheres = result.assembly.lattice.n_spheres, result.assembly.n_spheres
    ids = (int(result["chain/contact_i"][contact]), int(result["chain/contact_j"][contact]))
    words = [str(one) if one <= n else f"S{one - n}" if one <= spheres else "bar" for one in ids]
    return "-".join(words)


def _unit(force: NDArray[np.float64]) -> tuple[float, str]:
    return (_KILO, "kN") if np.max(force, initial=0.0) >= 1e4 else (1.0, "N")


def _time_axes(axes, time: NDArray[np.float64]) -> None:
    axes.set_xlabel("Time (µs)")
    axes.set_xlim(0, float(time[-1]) * _MICRO or 1.0)
