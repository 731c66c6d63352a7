"""Figures against time: energies, forces on bottom and target, timestep, probes and sensors."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from granwave.analysis.figures.series import (
    LINES,
    against_time,
    end_of_axis,
    energy_unit,
    label,
    legend_outside,
    limits_of_error,
    panels,
    time_axis,
    velocity_unit,
)
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
)
from granwave.analysis.figures.user_axes import SOLID
from granwave.analysis.measures.lines import sensor_accelerations, sensor_velocities
from granwave.analysis.measures.target import unprotected
from granwave.analysis.measures.target_record import reached
from granwave.analysis.result.reader import Result, misfit, moved_mass, work_on_packing
from granwave.lammps_inputs.case.case import Case

_NANO = 1e9  # nanoseconds in a second
_MICRO = 1e6  # microseconds in a second
_MILLI = 1e3  # millimetres in a metre
_PROBE = re.compile(r"(?P<name>(sphere|contact)_\d+(_\d+)?)_(?P<quantity>\w+)")
_QUANTITIES = {
    "u": ("Displacement (µm)", 1e6),
    "v": ("Velocity (m/s)", 1.0),
    "f": ("Force (N)", 1.0),
    "overlap": ("Overlap (µm)", 1e6),
    "force": ("Contact force (N)", 1.0),
}
_BROWN = "#8C5A2B"
_WINE = "#882255"
_PALE = "#C9C2B2"
_NAVY = "#1B2A49"
_OLIVE = "#999933"
_TEAL = "#44AA99"
_ROSE = "#CC6677"
#: Parts of the energy and their colours, from the bottom of the figure up.
_AREAS = {
    "dissipated": ORANGE, "yielding": ORANGE, "friction": YELLOW, "rolling": _OLIVE, "twisting": _TEAL,
    "adhesion": _ROSE, "viscous losses": _WINE, "holder": _BROWN,
    "support's damper": GREY, "absorbed": _PALE, "support": PURPLE,
    "elastic": GREEN, "rotation": SKY, "kinetic": BLUE, "plate": _NAVY,
}  # fmt: skip
#: Lines of energies that are not drawn as areas, for readers without colours.
_LINES_OF_ENERGIES = {
    "elastic": "--",
    "dissipated": "-.",
    "yielding": "-.",
    "absorbed": (0, (8, 2)),
}
#: Hatches of energies that are drawn as areas, for readers without colours.
_HATCHES = {
    "dissipated": "////", "yielding": "////", "friction": "\\\\\\\\", "viscous losses": "....",
    "absorbed": "xxxx", "support": "----", "rotation": "||||", "elastic": "oooo",
}  # fmt: skip
#: Energies that are dissipated, but not by yielding: label and column of the ledger.
_LOST_OTHERWISE = {
    "friction": "friction", "rolling": "rolling", "twisting": "twisting", "adhesion": "adhesion",
    "viscous losses": "viscous", "holder": "holder", "support's damper": "support_lost",
    "absorbed": "absorbed",
}  # fmt: skip
_ROUNDING = 1e-9  # fraction of the input: yield energy, as a difference, of laws that cannot yield
_EDGE = 0.3  # width of the lines between areas, points
_NEGLIGIBLE = 1e-3  # negative energy / input that counts as rounding
_FAR_APART = 10.0  # largest over smallest peak force above which their axis is logarithmic
_IN_PANEL = 4  # sensors in a panel
# figure of probes
_MOST_IN_LEGEND = 10  # largest number of curves with a legend
_COLUMNS = 2  # columns of a legend above all panels
_IMPULSES = ((1e3, "mN s"), (1e6, "µN s"), (1e9, "nN s"))
_LEAST_IMPULSE = 0.1  # in mN s: tenths are common there
_STEADY = 0.01  # change / range of a record that is still noticeable
_AFTER_CHANGE = 3.0  # end of an axis of times / time of the last noticeable change
_LEAST = 1e-3  # start of the axis of the error over the tolerance


def energies(result: Result) -> Drawing | None:
    """Draw all energies, and the residual of their sum."""
    energy_input = result.energy_input
    if not energy_input:
        return None
    time = result["energy/time"]
    parts = _energy_parts(result)
    residual = np.abs(sum(parts.values()) - result["energy/input"]) / result.largest_input
    figure, upper, lower = panels(3.6, rows=2, sharex=True, height_ratios=(3, 1))
    unit, name = energy_unit(energy_input)
    as_areas = (
        len(parts) > 3
        and min(float(values.min()) for values in parts.values()) > -_NEGLIGIBLE * energy_input
    )
    if as_areas:
        colours = [_AREAS[part] for part in parts]
        areas = np.stack(list(parts.values())) * unit
        drawn = upper.stackplot(
            time * _MICRO, areas, labels=list(parts), colors=colours, linewidth=_EDGE,
            edgecolor="white",
        )  # fmt: skip
        for part, area in zip(parts, drawn, strict=True):
            area.set_hatch(_HATCHES.get(part))
    else:
        for part, values in parts.items():
            line: Any = _LINES_OF_ENERGIES.get(part, "-")
            upper.plot(time * _MICRO, values * unit, color=_AREAS[part], label=part, linestyle=line)
    upper.plot(
        time * _MICRO, result["energy/input"] * unit, color="black", linestyle=":", label="input"
    )
    least = 0 if as_areas or len(parts) == 3 else None
    label(upper, y=f"Energy ({name})", ylim=(least, 1.05 * energy_input * unit))
    legend_above(upper, 3, handlelength=1.0 if as_areas else 1.6)
    lower.semilogy(
        time * _MICRO, np.where(residual > 0, residual, np.nan), color=GREY, linewidth=0.8
    )
    label(lower, y="|Residual|\n/ input", **limits_of_error(residual))
    time_axis(lower, time)
    named = {part.replace("'s ", "_").replace(" ", "_"): values for part, values in parts.items()}
    columns = {"time_s": time, **{f"{name}_J": values for name, values in named.items()}}
    columns |= {
        f"{part}_wall_J": result[f"energy/{part}_wall"] for part in ("elastic", "dissipated")
    }
    return Drawing(
        figure, columns | {"input_J": result["energy/input"], "residual_over_input": residual}
    )


def _energy_parts(result: Result) -> dict[str, NDArray]:
    """Return the energies that add up to the input; rotation and kinds of dissipation separately,
    if any.
    """
    kinetic, elastic, dissipated = (
        result[f"energy/{name}"] for name in ("kinetic", "elastic", "dissipated")
    )
    parts = {"kinetic": kinetic, "elastic": elastic, "dissipated": dissipated}
    if result.has("energy/rotational"):
        rotational = result["energy/rotational"]
        parts = {
            "kinetic": kinetic - rotational,
            "rotation": rotational,
            "elastic": elastic,
            "dissipated": dissipated,
        }
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
        parts = {
            "yielding" if name == "dissipated" else name: values for name, values in parts.items()
        }
        if (
            not result.yields
            and float(np.abs(parts["yielding"]).max()) <= _ROUNDING * result.energy_input
        ):
            del parts["yielding"]
    return dict(sorted(parts.items(), key=lambda item: list(_AREAS).index(item[0])))


def bottom_force(result: Result) -> Drawing | None:
    """Draw the force on the bottom and its impulse, under a static load of the dynamic force."""
    if "walls/bottom" not in result:
        return None
    record = reached(result)
    if record is None or not (record.is_reached or record.has_static_force):
        return None
    time = record.time
    force = record.force
    is_pressed = record.has_static_force
    impulse = record.dynamic_impulse if is_pressed else record.impulse
    figure, axes = panels(2.3)
    against_time(axes, time, force, linewidth=0.8)
    axes.update_datalim([(0.0, 0.0)])  # a nearly constant force is not drawn on the frame
    axes.autoscale_view(scalex=False)
    axes.set_ylabel(f"Force on the bottom (N){SOLID}", color=BLUE)
    beside = axes.twinx()
    unit, name = _impulse_unit(float(np.abs(impulse).max(initial=0.0)))
    beside.plot(time * _MICRO, impulse * unit, color=ORANGE, linestyle="--")
    kind = "Dynamic impulse" if is_pressed else "Impulse"
    beside.set_ylabel(f"{kind} ({name}), dashed", color=ORANGE)
    _common_zero(axes, beside)
    columns = {"time_s": time, "force_N": force, "impulse_Ns": record.impulse}
    if is_pressed:
        columns["dynamic_impulse_Ns"] = impulse
    return Drawing(figure, columns)


def _impulse_unit(largest: float) -> tuple[float, str]:
    """Return the unit of impulses up to ``largest`` (N s): the number of units in 1 N s, and its
    name.
    """
    return next((unit for unit in _IMPULSES if largest * unit[0] >= _LEAST_IMPULSE), _IMPULSES[0])


def impactor_velocity(result: Result) -> Drawing | None:
    """Draw the velocity of the impacted, or loaded, sphere along the impact direction; None if it
    is always zero.
    """
    time = result["energy/time"]
    velocity = result["energy/struck_velocity"]
    if not np.any(velocity):
        return None
    figure, axes = panels(2.1)
    axes.axhline(0, color="black", linewidth=0.5)
    scale, unit = velocity_unit(float(np.abs(velocity).max()))
    against_time(axes, time, velocity * scale)
    label(
        axes,
        y=f"Velocity of the\n{'loaded' if result.case.load.driven else 'impacted'} sphere ({unit})",
    )
    axes.set_xlim(0, _end_of_change(time, velocity) * _MICRO)
    return Drawing(figure, {"time_s": time, "velocity_m_s": velocity})


def words_on_velocity(result: Result, _: Path) -> tuple[str, str]:
    """Return caption and look of `impactor_velocity` of a run."""
    time = result["energy/time"]
    end = _end_of_change(time, result["energy/struck_velocity"])
    driven = "loaded" if result.case.load.driven else "impacted"
    look = "Negative values are a rebound; where the velocity is constant, the sphere moves freely."
    ends = end_of_axis(end, float(time[-1]))
    return f"Velocity of the {driven} sphere", f"{look} {ends}".rstrip()


def _end_of_change(time: NDArray[np.float64], values: NDArray[np.float64]) -> float:
    """Return the end of an axis of times that shows the changes of a record: some time after its
    last noticeable change, or the end of the record.
    """
    differs = np.abs(values - values[-1]) > _STEADY * float(np.ptp(values))
    last = float(time[np.flatnonzero(differs)[-1]]) if differs.any() else 0.0
    return min(_AFTER_CHANGE * last, float(time[-1])) or float(time[-1])


def probes(result: Result) -> Drawing | None:
    """Draw the records of the probes, with a panel for each quantity."""
    histories = _probed(result.case)
    if "probes" not in result or not histories:
        return None
    time = result["probes/time"]
    # without records of sensors
    names = [name for name in result.names("probes") if name.rsplit("_", 1)[0] in histories]
    curves = _probe_curves(result, names)
    figure, *stack = panels(0.5 + 1.5 * len(curves), rows=len(curves), sharex=True)
    for axes, (quantity, records) in zip(stack, curves.items(), strict=True):
        title, scale = _QUANTITIES[quantity]
        for n, (curve, values) in enumerate(records.items()):
            line = LINES[(n + n // len(LINES)) % len(LINES)]
            against_time(axes, time, values * scale, line, label=curve)
        label(axes, y=title)
    _name_curves(figure, stack, [list(records) for records in curves.values()])
    columns = {"time_s": time}
    for name in names:
        unit = result.unit(f"probes/{name}").replace(" s-1", "_s")
        columns[f"{name}_{unit}"] = result[f"probes/{name}"]
    return Drawing(figure, columns)


def _probed(case: Case) -> set[str]:
    """Return the names of the spheres and contacts with a probe, as in the names of records."""
    names = set()
    for probe in case.output.probes:
        if probe.sphere is not None:
            names.add(f"sphere_{probe.sphere}")
        if probe.contact:
            first, second = probe.contact
            names.add(f"contact_{first}_{second}")
    return names


def _probe_curves(result: Result, names: list[str]) -> dict[str, dict[str, NDArray]]:
    """Return the records of probes by quantity, in the order of the panels, and by curve."""
    curves: dict[str, dict[str, NDArray]] = {}
    for name in names:
        match = _PROBE.fullmatch(name)
        if match is None:
            continue
        quantity = match["quantity"]
        curve = match["name"].replace("_", " ", 1).replace("_", "-")
        if quantity not in _QUANTITIES:  # a component, such as vz
            curve = f"{curve}, {quantity[1:]}"
            quantity = quantity[0]
        curves.setdefault(quantity, {})[curve] = result[f"probes/{name}"]
    return {quantity: curves[quantity] for quantity in _QUANTITIES if quantity in curves}


def _name_curves(figure: Any, stack: list[Axes], names: list[list[str]]) -> None:
    """Draw legends of panels with few curves: a common legend above panels that have the same
    curves.

    Parameters
    ----------
    names
        Names of the curves of each panel.
    """
    if max(map(len, names)) > _MOST_IN_LEGEND:
        return
    if len(names) > 1 and all(own == names[0] for own in names):
        legend_outside(figure, min(len(names[0]), _COLUMNS), handlelength=2.2)
        return
    for axes in stack:
        axes.legend(handlelength=2.2)


def sensors(result: Result) -> Drawing | None:
    """Draw the accelerations of the spheres with a sensor, each along the direction of its largest
    velocity.
    """
    accelerations = sensor_accelerations(result)
    if not accelerations:
        return None
    time = result["probes/time"]
    velocities = sensor_velocities(result)
    names = list(accelerations)
    rows = -(-len(names) // _IN_PANEL)
    figure, *stack = panels(0.5 + 1.5 * rows, rows=rows, sharex=True)
    for n, name in enumerate(names):
        axes = stack[n // _IN_PANEL]
        velocity = velocities[name]
        fastest = velocity[np.argmax(np.linalg.norm(velocity, axis=1))]
        along = accelerations[name] @ fastest / (np.linalg.norm(fastest) or 1.0)
        line = "--" if len(axes.lines) % 2 else "-"  # neighbours often coincide
        against_time(axes, time, along, line, label=name, linewidth=0.9)
    for axes in stack:
        label(axes, y="Acceleration (m/s²)")
        axes.legend(handlelength=1.2, loc="upper left")
    columns = {"time_s": time}
    for name, values in accelerations.items():
        for axis, component in zip("xyz", values.T, strict=True):
            columns[f"{name}_a{axis}_m_s2"] = component
    return Drawing(figure, columns)


def _common_zero(first: Axes, second: Axes) -> None:
    """Align the zeros of two axes."""
    limits = [axes.get_ylim() for axes in (first, second)]
    below = max(max(-low, 0.0) / max(high, 1e-300) for low, high in limits)
    for axes, (_, high) in zip((first, second), limits, strict=True):
        axes.set_ylim(-below * high, high)


def target_moves(result: Result) -> bool:
    """Return True for a moving target and for a bar; otherwise `bottom_force` shows the same
    values.
    """
    return "walls/bottom" not in result or result.has("walls/bottom/displacement")


def target(result: Result) -> Drawing | None:
    """Draw the force on the bottom, which is a target or a wall, against time, the force without
    the packing, and below them the work on a bottom that moves.

    The axis of the forces is logarithmic if their peaks differ by more than a decade. The
    impulse is in the figure of the force on the bottom. None if the bottom does not move and there
    is no such force: the force on the bottom has a separate figure.
    """
    arrival = reached(result)
    if arrival is None or not np.any(arrival.force):
        return None
    without = unprotected(result.assembly, float(result["energy/time"][-1]))
    moves = arrival.displacement is not None
    if not moves and without is None:
        return None
    time = arrival.time
    columns = {"time_s": arrival.time, "force_N": arrival.force, "impulse_Ns": arrival.impulse}
    figure, force, *below = panels(
        3.6 if moves else 2.6, rows=1 + moves, sharex=True, height_ratios=(3, 2)[: 1 + moves]
    )
    largest = [float(arrival.force.max())]
    bottom = "target" if target_moves(result) else "bottom"
    against_time(force, time, arrival.force, linewidth=0.9, label=f"on the {bottom}")
    if arrival.displacement is not None and arrival.ground_force is not None:
        columns |= {"displacement_m": arrival.displacement, "ground_force_N": arrival.ground_force}
        against_time(
            force, time, arrival.ground_force, "-.", color=GREEN, linewidth=0.9,
            label="on the ground",
        )  # fmt: skip
        largest.append(float(arrival.ground_force.max()))
    if without is not None and without.peak_force > 0:
        columns |= {
            "without_packing_time_s": without.time,
            "without_packing_force_N": without.force,
        }
        force.plot(
            without.time * _MICRO,
            without.force,
            color=GREY,
            linestyle="--",
            label=f"on the {bottom} without packing",
        )
        largest.append(without.peak_force)
    if max(largest) > _FAR_APART * min(largest) > 0:
        force.set(yscale="log", ylim=(1e-2 * min(largest), 2 * max(largest)))
    label(force, y="Force (N)")
    legend_above(force, 2)
    for axes in below:
        ledger = result["energy/time"]
        energy = result.get("energy/target")
        energy = np.zeros_like(ledger) if energy is None else energy
        unit, name = energy_unit(float(np.abs(energy).max()))
        axes.plot(ledger * _MICRO, energy * unit)
        label(axes, y=f"Work on the\ntarget ({name})")
        columns |= {"energy_time_s": ledger, "energy_J": energy}
    time_axis(figure.axes[-1], time)
    return Drawing(figure, columns)


def timestep(result: Result) -> Drawing | None:
    """Draw the timestep against time, and below it the error of the balance: measured, expected,
    and allowed.
    """
    largest_input = result.largest_input
    tolerance = result.case.run.energy_tolerance
    if not largest_input or not result.has("energy/timestep"):
        return None
    time = result["energy/time"]
    step = result["energy/timestep"]
    work = work_on_packing(result.ledger, moved_mass(result.assembly))
    expected = np.abs(result["energy/expected_error"]) * work / largest_input
    error = misfit(result.ledger) / largest_input
    figure, upper, lower = panels(3.2, rows=2, sharex=True)
    upper.plot(time * _MICRO, step * _NANO, ".", markersize=2)  # a line would hide fast changes
    upper.set_yscale("log", base=2)
    upper.yaxis.set_major_formatter("{x:.4g}")
    label(upper, y="Timestep (ns)")
    for values, colour, line, width, name in (
        (error, _PALE, "-", 2.4, "measured"),
        (expected, ORANGE, "-", 0.7, "expected"),
    ):
        lower.semilogy(
            time * _MICRO,
            np.where(values > 0, values, np.nan),
            line,
            color=colour,
            linewidth=width,
            label=name,
        )
    lower.axhline(tolerance, color="black", linestyle=":", linewidth=0.8, label="tolerance")
    label(lower, y="|Residual|\n/ input", ylim=(_LEAST * tolerance, 3 * tolerance))
    legend_above(lower, 3)
    time_axis(lower, time)
    columns = {
        "time_s": time,
        "timestep_s": step,
        "residual_over_input": error,
        "expected_over_input": expected,
    }
    return Drawing(figure, columns)
