"""Figures against time: energies, forces on bottom and target, timestep, probes and sensors."""

from __future__ import annotations

import re

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from granwave.analysis.figures.series import energy_unit, velocity_unit
from granwave.analysis.figures.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    YELLOW,
    Drawing,
    legend_above,
    new_figure,
)
from granwave.analysis.measures.lines import sensor_accelerations, sensor_velocities
from granwave.analysis.measures.target import reached, unprotected
from granwave.analysis.result.reader import Result, misfit, moved_mass, work_on_packing

_NANO, _MICRO, _MILLI = 1e9, 1e6, 1e3  # of a second, of a metre
_MOST_POINTS = 20_000  # of a curve; the CSV file has all
_PROBE = re.compile(r"(?P<name>(sphere|contact)_\d+(_\d+)?)_(?P<quantity>\w+)")
_QUANTITIES = {
    "u": ("Displacement (µm)", 1e6),
    "v": ("Velocity (m/s)", 1.0),
    "f": ("Force (N)", 1.0),
    "overlap": ("Overlap (µm)", 1e6),
    "force": ("Contact force (N)", 1.0),
}
_BROWN, _WINE, _PALE, _NAVY = "#8C5A2B", "#882255", "#C9C2B2", "#1B2A49"
_COLOURS = (BLUE, ORANGE, GREEN, PURPLE, GREY)
#: Parts of the energy and their colours, from the bottom of the figure up.
_AREAS = {
    "dissipated": ORANGE, "yielding": ORANGE, "friction": YELLOW, "viscous losses": _WINE, "holder": _BROWN,
    "support's damper": GREY, "absorbed": _PALE, "support": PURPLE,
    "elastic": GREEN, "rotation": SKY, "kinetic": BLUE, "plate": _NAVY,
}  # fmt: skip
#: Energies that are dissipated, but not by yielding: label and column of the ledger.
_LOST_OTHERWISE = {
    "friction": "friction", "viscous losses": "viscous", "holder": "holder", "support's damper": "support_lost",
    "absorbed": "absorbed",
}  # fmt: skip
_ROUNDING = 1e-9  # of the input: yielding of laws that cannot yield, left by subtraction
_NEGLIGIBLE = 1e-3  # negative energy over the input that counts as rounding
_IN_PANEL = 4  # sensors in a panel


def energies(result: Result) -> Drawing | None:
    """Draw all energies, and the residual of their sum."""
    given = result.energy_input
    if not given:
        return None
    time = result["energy/time"]
    parts = _energy_parts(result)
    residual = np.abs(sum(parts.values()) - result["energy/input"]) / result.largest_input
    figure = new_figure(3.6)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    unit, name = energy_unit(given)
    as_areas = len(parts) > 3 and min(float(values.min()) for values in parts.values()) > -_NEGLIGIBLE * given
    if as_areas:
        colours = [_AREAS[part] for part in parts]
        upper.stackplot(
            time * _MICRO, np.stack(list(parts.values())) * unit, labels=list(parts), colors=colours, linewidth=0
        )
    else:
        for part, values in parts.items():
            line = {"linestyle": "--", "zorder": 3} if part == "elastic" else {}  # often as large as the kinetic energy
            upper.plot(time * _MICRO, values * unit, color=_AREAS[part], label=part, **line)
    upper.plot(time * _MICRO, result["energy/input"] * unit, color="black", linestyle=":", label="input")
    upper.set_ylabel(f"Energy ({name})")
    upper.set_ylim(0 if as_areas or len(parts) == 3 else None, 1.05 * given * unit)
    legend_above(upper, 3, handlelength=1.0 if as_areas else 1.6)
    lower.semilogy(time * _MICRO, np.where(residual > 0, residual, np.nan), color=GREY, linewidth=0.8)
    lower.set_ylabel("|Residual|\n/ input")
    time_axis(lower, time)
    columns = {"time_s": time, **{f"{_column(part)}_J": values for part, values in parts.items()}}
    columns |= {f"{part}_wall_J": result[f"energy/{part}_wall"] for part in ("elastic", "dissipated")}
    return Drawing(figure, columns | {"input_J": result["energy/input"], "residual_over_input": residual})


def _energy_parts(result: Result) -> dict[str, NDArray]:
    """Return the energies that add up to the input; rotation and kinds of dissipation separately, if any."""
    kinetic, elastic, dissipated = (result[f"energy/{name}"] for name in ("kinetic", "elastic", "dissipated"))
    parts = {"kinetic": kinetic, "elastic": elastic, "dissipated": dissipated}
    if result.has("energy/rotational"):
        rotational = result["energy/rotational"]
        parts = {"kinetic": kinetic - rotational, "rotation": rotational, "elastic": elastic, "dissipated": dissipated}
    if result.has("energy/plate"):
        parts["kinetic"] = parts["kinetic"] - result["energy/plate"]
        parts["plate"] = result["energy/plate"]
    if result.has("energy/support"):
        parts["elastic"] = elastic - result["energy/support"]
        parts["support"] = result["energy/support"]
    for name, source in _LOST_OTHERWISE.items():
        if result.has(f"energy/{source}"):
            parts["dissipated"] = parts["dissipated"] - result[f"energy/{source}"]
            parts[name] = result[f"energy/{source}"]
    if any(part in parts for part in _LOST_OTHERWISE):
        parts = {"yielding" if name == "dissipated" else name: values for name, values in parts.items()}
        if not result.yields and float(np.abs(parts["yielding"]).max()) <= _ROUNDING * result.energy_input:
            del parts["yielding"]
    return dict(sorted(parts.items(), key=lambda item: list(_AREAS).index(item[0])))


def _column(part: str) -> str:
    return part.replace("'s ", "_").replace(" ", "_")


def bottom_force(result: Result) -> Drawing | None:
    """Draw the force on the bottom and its impulse."""
    if "walls/bottom" not in result:
        return None
    time, force = result["walls/bottom/time"], result["walls/bottom/force"]
    if not np.any(force):
        return None
    steps = 0.5 * (force[1:] + force[:-1]) * np.diff(time)
    impulse = np.concatenate([[0.0], np.cumsum(steps)])
    figure = new_figure(2.3)
    axes = figure.subplots()
    shown = thinned(force)
    axes.plot(time[shown] * _MICRO, force[shown], color=BLUE, linewidth=0.8)
    axes.update_datalim([(0.0, 0.0)])  # so that a force that hardly changes does not lie on the frame
    axes.autoscale_view()
    axes.set_ylabel("Force on the bottom (N)", color=BLUE)
    time_axis(axes, time)
    beside = axes.twinx()
    beside.plot(time * _MICRO, impulse * 1e3, color=ORANGE, linestyle="--")
    beside.set_ylabel("Impulse (mN s)", color=ORANGE)
    _common_zero(axes, beside)
    return Drawing(figure, {"time_s": time, "force_N": force, "impulse_Ns": impulse})


def impactor_velocity(result: Result) -> Drawing | None:
    """Draw the velocity of the struck, or loaded, sphere along the impact direction; None if it is zero throughout."""
    time, velocity = result["energy/time"], result["energy/struck_velocity"]
    if not np.any(velocity):
        return None
    figure = new_figure(2.1)
    axes = figure.subplots()
    axes.axhline(0, color="black", linewidth=0.5)
    scale, unit = velocity_unit(float(np.abs(velocity).max()))
    axes.plot(time * _MICRO, velocity * scale, color=BLUE)
    axes.set_ylabel(f"Velocity of the\n{'loaded' if result.case.load.driven else 'struck'} sphere ({unit})")
    time_axis(axes, time)
    return Drawing(figure, {"time_s": time, "velocity_m_s": velocity})


def probes(result: Result) -> Drawing | None:
    """Draw the records of the probes, with a panel for each quantity."""
    wanted = {f"sphere_{probe.sphere}" for probe in result.case.output.probes if probe.sphere is not None}
    wanted |= {"contact_{}_{}".format(*probe.contact) for probe in result.case.output.probes if probe.contact}
    if "probes" not in result or not wanted:
        return None
    time = result["probes/time"]
    panels: dict[str, list[tuple[str, NDArray]]] = {}
    names = [name for name in result.names("probes") if name.rsplit("_", 1)[0] in wanted]  # without sensors
    for name in names:
        found = _PROBE.fullmatch(name)
        if found:
            quantity = found["quantity"]
            key = quantity if quantity in _QUANTITIES else quantity[0]
            axis = "" if key == quantity else f", {quantity[1:]}"
            label = found["name"].replace("_", " ", 1).replace("_", "-") + axis
            panels.setdefault(key, []).append((label, result[f"probes/{name}"]))
    figure = new_figure(0.5 + 1.5 * len(panels))
    stack = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, key in zip(stack, sorted(panels, key=list(_QUANTITIES).index), strict=True):
        curves = panels[key]
        label, scale = _QUANTITIES[key]
        for n, (name, values) in enumerate(curves):
            shown = thinned(values)
            style = ("-", "--", ":")[n // len(_COLOURS) % 3]
            axes.plot(
                time[shown] * _MICRO,
                values[shown] * scale,
                style,
                color=_COLOURS[n % len(_COLOURS)],
                label=name,
            )
        axes.set_ylabel(label)
        if len(curves) <= 2 * len(_COLOURS):
            axes.legend(ncols=1, fontsize=8, loc="best", handlelength=1.2)
    time_axis(stack[-1], time)
    units = {name: result.unit(f"probes/{name}").replace(" s-1", "_s") for name in names}
    return Drawing(figure, {"time_s": time} | {f"{name}_{units[name]}": result[f"probes/{name}"] for name in names})


def sensors(result: Result) -> Drawing | None:
    """Draw the accelerations of the spheres with a sensor, each along the direction of its largest velocity."""
    found = sensor_accelerations(result)
    if not found:
        return None
    time, velocities = result["probes/time"], sensor_velocities(result)
    names = list(found)
    groups = [names[n : n + _IN_PANEL] for n in range(0, len(names), _IN_PANEL)]
    figure = new_figure(0.5 + 1.5 * len(groups))
    stack = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
    for axes, group in zip(stack, groups, strict=True):
        for name, colour in zip(group, _COLOURS, strict=False):
            velocity = velocities[name]
            fastest = velocity[np.argmax(np.linalg.norm(velocity, axis=1))]
            along = found[name] @ fastest / (np.linalg.norm(fastest) or 1.0)
            shown = thinned(along)
            line = "--" if len(axes.lines) % 2 else "-"  # neighbours often coincide
            axes.plot(time[shown] * _MICRO, along[shown], line, color=colour, label=name, linewidth=0.9)
        axes.set_ylabel("Acceleration (m/s²)")
        axes.legend(ncols=1, fontsize=8, handlelength=1.2, loc="upper left")
    time_axis(stack[-1], time)
    columns = {f"{name}_a{axis}_m_s2": values[:, n] for name, values in found.items() for n, axis in enumerate("xyz")}
    return Drawing(figure, {"time_s": time} | columns)


def time_axis(axes: Axes, time: NDArray[np.float64]) -> None:
    """Label the time axis for times in s."""
    axes.set_xlabel("Time (µs)")
    axes.set_xlim(0, float(time[-1]) * _MICRO or 1.0)


def thinned(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the rows to draw: for long records, the lowest and highest of every bin, which give the same curve."""
    n_bins = _MOST_POINTS // 2
    if len(values) <= _MOST_POINTS:
        return np.arange(len(values))
    size = len(values) // n_bins
    whole = values[: n_bins * size].reshape(n_bins, size)
    starts = np.arange(n_bins) * size
    rows = np.concatenate([starts + whole.argmin(axis=1), starts + whole.argmax(axis=1), [len(values) - 1]])
    return np.unique(rows)


def _common_zero(first: Axes, second: Axes) -> None:
    """Align the zeros of two axes."""
    limits = [axes.get_ylim() for axes in (first, second)]
    below = max(max(-low, 0.0) / max(high, 1e-300) for low, high in limits)
    for axes, (_, high) in zip((first, second), limits, strict=True):
        axes.set_ylim(-below * high, high)


def target(result: Result) -> Drawing | None:
    """Draw force, impulse and work on the bottom against time, and the force without the packing.

    None if the bottom does not move and there is no such force: the force on the bottom has a figure of its own.
    """
    found = reached(result)
    if found is None or not np.any(found.force):
        return None
    time, end = found.time, float(result["energy/time"][-1])
    without = unprotected(result.case, end)
    moved, ground = found.displacement, found.ground_force
    moves = moved is not None
    if not moves and without is None:
        return None
    columns = {"time_s": time, "force_N": found.force, "impulse_Ns": found.impulse}
    figure = new_figure(4.8 if moves else 3.5)
    panels = figure.subplots(3 if moves else 2, 1, sharex=True)
    force, impulse = panels[:2]
    shown = thinned(found.force)
    force.plot(time[shown] * _MICRO, found.force[shown], color=BLUE, linewidth=0.9, label="on the target")
    if moved is not None and ground is not None:
        columns |= {"displacement_m": moved, "ground_force_N": ground}
        shown = thinned(ground)
        force.plot(time[shown] * _MICRO, ground[shown], color=GREEN, linewidth=0.9, label="on the ground")
    if without is not None and without.peak_force > 0:
        columns |= {"without_packing_time_s": without.time, "without_packing_force_N": without.force}
        force.plot(without.time * _MICRO, without.force, color=GREY, linestyle="--", label="target without packing")
        force.set_yscale("log")
        least = min(float(found.force.max()), without.peak_force)
        force.set_ylim(1e-2 * least, 2 * max(float(found.force.max()), without.peak_force))
    force.set_ylabel("Force (N)")
    legend_above(force, 2)
    impulse.plot(time * _MICRO, found.impulse * _MILLI, color=ORANGE)
    impulse.set_ylabel("Impulse (mN s)")
    if moves:
        ledger, energy = result["energy/time"], result.get("energy/target")
        if energy is None:
            energy = np.zeros_like(ledger)
        unit, name = energy_unit(float(np.abs(energy).max()))
        panels[2].plot(ledger * _MICRO, energy * unit, color=BLUE)
        panels[2].set_ylabel(f"Work on the\ntarget ({name})")
        columns |= {"energy_time_s": ledger, "energy_J": energy}
    time_axis(panels[-1], time)
    return Drawing(figure, columns)


_LEAST = 1e-3  # of the tolerance: where the axis of the error begins


def timestep(result: Result) -> Drawing | None:
    """Draw the timestep against time, and below it the error of the balance: measured, expected, and allowed."""
    given = result.largest_input
    if not given or not result.has("energy/timestep"):
        return None
    time, step = result["energy/time"], result["energy/timestep"]
    error = misfit(result.ledger) / given
    work = work_on_packing(result.ledger, moved_mass(result.assembly))
    expected = np.abs(result["energy/expected_error"]) * work / given
    figure = new_figure(3.2)
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.step(time * _MICRO, step * _NANO, where="pre", color=BLUE)
    upper.set_yscale("log", base=2)
    upper.yaxis.set_major_formatter("{x:.3g}")
    upper.set_ylabel("Timestep (ns)")
    for values, colour, label in ((error, GREY, "measured"), (expected, ORANGE, "expected")):
        lower.semilogy(time * _MICRO, np.where(values > 0, values, np.nan), color=colour, linewidth=0.8, label=label)
    tolerance = result.case.run.energy_tolerance
    lower.set_ylim(_LEAST * tolerance, 3 * tolerance)
    lower.axhline(tolerance, color="black", linestyle=":", linewidth=0.8, label="tolerance")
    lower.set_ylabel("|Residual|\n/ input")
    legend_above(lower, 3)
    time_axis(lower, time)
    columns = {"time_s": time, "timestep_s": step, "residual_over_input": error, "expected_over_input": expected}
    return Drawing(figure, columns)
