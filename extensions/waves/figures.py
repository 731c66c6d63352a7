"""Figures of small waves: bands, attenuation, curves over a plane, modes, transmission."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from granwave.analysis.figures.series import COLOURS, one_panel, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, WIDTH, Drawing, legend_above
from granwave.extensions.waves.spectra.band_structure import BandStructure
from granwave.extensions.waves.spectra.bands import Gap, Modes
from granwave.extensions.waves.spectra.network import FREEDOMS
from granwave.extensions.waves.spectra.transmission import Transmission

_FEWEST_GRAINS = 2  # fewest grains of a cell whose modes are drawn
_KILO = 1e-3
_LEAST_GAP = 0.002  # fraction of the height of the panel; narrower gaps are invisible


def band_diagram(found: BandStructure) -> Drawing:
    """Draw the bands along the path, with gaps shaded, and next to them the attenuation where it is
    known.
    """
    bands = found.bands
    decaying = found.complex_bands
    widths, width = ((3, 1), 1.45) if decaying is not None else ((1,), 1.05)
    figure, *row = panels(2.8, len(widths), width=WIDTH * width, sharey=True, width_ratios=widths)
    axes = row[0]
    top = 1.08 * _KILO * float(np.nanmax(bands.frequency))
    if decaying is not None:
        top = min(1.2 * top, _KILO * float(decaying.frequency[-1]))
    for gap in found.gaps:
        low = _KILO * gap.low
        high = min(_KILO * gap.high, top)
        for one in row if high - low > _LEAST_GAP * top else ():
            one.axhspan(low, high, color="0.9", lw=0, zorder=0)
    starts = [0, *bands.path.breaks, len(bands.path.k)]
    for n in range(bands.frequency.shape[1]):
        for start, stop in pairwise(starts):
            thin = {"color": BLUE, "lw": 1.0} if bands.share is None else {"color": GREY, "lw": 0.4}
            axes.plot(
                bands.path.distance[start:stop], _KILO * bands.frequency[start:stop, n], **thin
            )
    if bands.share is not None:
        place = np.broadcast_to(bands.path.distance[:, None], bands.share.shape)
        order = np.argsort(bands.share, axis=None)
        x, y, part = (one.ravel()[order] for one in (place, _KILO * bands.frequency, bands.share))
        dots = axes.scatter(
            x, y, c=part, s=3, cmap="viridis_r", vmin=0, vmax=1, linewidths=0, zorder=3
        )
        figure.colorbar(dots, ax=row[-1], label="Energy in the upper quarter", pad=0.02)
    _mark_corners(axes, found)
    axes.set(
        ylabel="Frequency (kHz)",
        ylim=(0, top),
        xlim=(bands.path.distance[0], bands.path.distance[-1]),
    )
    columns: dict[str, Any] = {"distance_rad_per_m": bands.path.distance}
    columns |= {f"f{n}_Hz": one for n, one in enumerate(bands.frequency.T, start=1)}
    if bands.share is not None:
        columns |= {f"share{n}": one for n, one in enumerate(bands.share.T, start=1)}
    if decaying is not None:
        row[1].plot(decaying.least, _KILO * decaying.frequency, color=ORANGE, lw=1.0)
        row[1].set(xlabel="Attenuation\nper plane", xlim=(0, None))
        columns |= {
            "attenuation_frequency_Hz": decaying.frequency,
            "attenuation_per_plane": decaying.least,
        }
    unit = _KILO * found.unit_frequency
    right = row[-1].secondary_yaxis("right", functions=(lambda f: f / unit, lambda f: f * unit))
    right.set_ylabel(r"$\omega/\sqrt{k/m}$")
    row[-1].tick_params(right=False)
    return Drawing(figure, columns)


def _mark_corners(axes: Axes, found: BandStructure) -> None:
    path = found.bands.path
    at: dict[float, list[str]] = {}
    for row, name in path.corners:
        at.setdefault(float(path.distance[row]), []).append("Γ" if name == "G" else name)
    if all(any(names) for names in at.values()):
        axes.set_xticks(
            list(at), ["|".join(dict.fromkeys(filter(None, names))) for names in at.values()]
        )
        axes.set_xlabel("Wave vector")
    else:
        axes.set_xlabel("Wave vector along the path (rad/m)")
    for place in list(at)[1:-1]:
        axes.axvline(place, color="0.6", lw=0.5)
    axes.tick_params(axis="x", top=False)


def group_velocities(found: BandStructure) -> Drawing:
    """Draw the group velocities of the bands along the path."""
    bands = found.bands
    figure, axes = panels(2.4, width=WIDTH * 1.05)
    step = np.gradient(bands.path.k, axis=0)
    along = step / np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1e-300)
    velocity = np.einsum("kna,ka->kn", bands.velocity, along)
    for n, one in enumerate(velocity.T):
        axes.plot(
            _KILO * bands.frequency[:, n], np.abs(one), ".", ms=2, color=COLOURS[n % len(COLOURS)]
        )
    axes.set(
        xlabel="Frequency (kHz)",
        ylabel="Group velocity along the path (m/s)",
        ylim=(0, None),
        xlim=(0, None),
    )
    columns: dict[str, Any] = {"distance_rad_per_m": bands.path.distance}
    for n in range(bands.frequency.shape[1]):
        columns |= {
            f"f{n + 1}_Hz": bands.frequency[:, n],
            f"velocity{n + 1}_m_per_s": velocity[:, n],
        }
    return Drawing(figure, columns)


def slowness_curves(found: BandStructure) -> Drawing | None:
    """Draw the slowness of long waves over the directions of a plane; None without a plane."""
    curves = found.surface
    if curves is None or np.isnan(curves.speed).all():
        return None
    figure, axes = panels(2.8)
    angle = np.append(curves.angle, curves.angle[0])
    columns: dict[str, Any] = {"angle_rad": curves.angle}
    for n, one in enumerate(curves.slowness.T):
        closed = 1e3 * np.append(one, one[0])
        axes.plot(
            closed * np.cos(angle), closed * np.sin(angle), color=COLOURS[n], label=f"wave {n + 1}"
        )
        columns[f"slowness{n + 1}_s_per_m"] = one
    first, second = (f"Slowness along {axis} (ms/m)" for axis in list(curves.plane))
    axes.set(xlabel=first, ylabel=second, aspect="equal")
    legend_above(axes, 3)
    return Drawing(figure, columns)


def equal_frequency_curves(found: BandStructure) -> Drawing | None:
    """Draw lines of equal frequency over a plane of wave vectors, a panel for each of the lowest
    bands.
    """
    curves = found.surface
    if curves is None:
        return None
    n = min(3, curves.frequency.shape[2])
    figure, *row = panels(2.3, n, width=WIDTH * (0.35 + 0.75 * n), sharey=True)
    for number, axes in enumerate(row):
        values = np.ma.masked_invalid(_KILO * curves.frequency[:, :, number])
        if values.count():
            lines = axes.contour(curves.k, curves.k, values, 8, linewidths=0.8, cmap="viridis")
            axes.clabel(lines, fontsize=6, fmt="%.3g")
        axes.set(
            title=f"Band {number + 1} (kHz)",
            aspect="equal",
            xlabel=f"$k_{curves.plane[0]}$ (rad/m)",
        )
        if not number:
            axes.set_ylabel(f"$k_{curves.plane[1]}$ (rad/m)")
    across, along = (one.ravel() for one in np.meshgrid(curves.k, curves.k))
    columns: dict[str, Any] = {
        f"k{curves.plane[0]}_rad_per_m": across,
        f"k{curves.plane[1]}_rad_per_m": along,
    }
    columns |= {
        f"f{one + 1}_Hz": curves.frequency[:, :, one].ravel()
        for one in range(curves.frequency.shape[2])
    }
    return Drawing(figure, columns)


def mode_shapes(found: BandStructure) -> Drawing | None:
    """Draw the displacements of the modes at the end of the first segment of the path; None for
    cells of many grains, and of one grain, whose modes have no shape.
    """
    network = found.state.network
    bands = found.bands
    if network.n_freedoms > 24 or len(network.ids) < _FEWEST_GRAINS:
        return None
    grain, direction = network.freedoms
    row = bands.path.corners[1][0]
    shape = bands.shape[1] / np.sqrt(network.masses)[:, None]
    turning = direction >= 3
    shape[turning] *= np.sqrt(network.inertia / network.mass)[grain[turning], None]
    shape = shape / np.abs(shape).max(axis=0)
    phase = np.exp(
        -1j * np.angle(shape[np.argmax(np.abs(shape), axis=0), np.arange(shape.shape[1])])
    )
    shape = shape * phase
    n = min(bands.frequency.shape[1], 6)
    figure, *stack = panels(0.5 + 0.75 * n, rows=n, sharex=True)
    names = [f"{network.ids[g]} {FREEDOMS[d]}" for g, d in zip(grain, direction, strict=True)]
    place = np.arange(len(names))
    for number, axes in enumerate(stack):
        axes.bar(place - 0.2, shape[:, number].real, 0.4, color=BLUE, label="in phase")
        axes.bar(
            place + 0.2,
            shape[:, number].imag,
            0.4,
            color=GREY,
            label="a quarter period out of phase",
        )
        frequency = bands.frequency[row, number]
        axes.set(ylim=(-1.15, 1.15), yticks=(-1, 0, 1), title=f"{_KILO * frequency:.4g} kHz")
        axes.axhline(0, color="black", lw=0.4)
        axes.tick_params(axis="x", length=0)
    legend_above(figure.axes[0], 2, bbox_to_anchor=(0.5, 1.25))
    axes.set_xticks(place, names, rotation=90 if len(names) > 8 else 0)
    axes.set_xlabel(f"Grain and direction, at {bands.path.nearest(row)}")
    columns: dict[str, Any] = {
        "grain": network.ids[grain],
        "freedom": [FREEDOMS[one] for one in direction],
    }
    for number in range(bands.frequency.shape[1]):
        columns |= {
            f"real{number + 1}": shape[:, number].real,
            f"imaginary{number + 1}": shape[:, number].imag,
        }
    return Drawing(figure, columns)


def density_of_states(modes: Modes) -> Drawing:
    """Draw the density of states."""
    figure, axes = one_panel(2.2, "Frequency (kHz)", "Density of states (1/kHz)", xlim=(0, None))
    axes.fill_between(
        _KILO * modes.density_frequency, modes.density / _KILO, color=BLUE, alpha=0.3, lw=0
    )
    axes.plot(_KILO * modes.density_frequency, modes.density / _KILO, color=BLUE)
    axes.set_xlim(0, _KILO * float(modes.density_frequency[-1]))
    axes.set_ylim(0, None)
    return Drawing(
        figure, {"frequency_Hz": modes.density_frequency, "density_per_Hz": modes.density}
    )


def participation(modes: Modes) -> Drawing:
    """Draw the participation ratios of the modes."""
    figure, axes = one_panel(2.2, "Frequency (kHz)", "Participation ratio", ylim=(0, 1.05))
    axes.plot(_KILO * modes.frequency, modes.participation, "o", ms=2, color=BLUE)
    axes.set_xlim(0, None)
    return Drawing(
        figure, {"frequency_Hz": modes.frequency, "participation_ratio": modes.participation}
    )


def transmission_curve(found: Transmission, gaps: tuple[Gap, ...] = ()) -> Drawing:
    """Draw the ratios of amplitudes against frequency, with the gaps of the bands shaded if they
    are known.
    """
    figure, axes = one_panel(2.4, "Frequency (kHz)", "Amplitude / drive amplitude", yscale="log")
    for gap in gaps:
        high = min(gap.high, float(found.frequency[-1]))
        if high > gap.low:
            axes.axvspan(_KILO * gap.low, _KILO * high, color="0.9", lw=0, zorder=0)
    for sensor, one, colour in zip(
        found.sensors, found.amplitude.T, COLOURS * len(found.sensors), strict=False
    ):
        axes.plot(
            _KILO * found.frequency, np.maximum(one, 1e-300), color=colour, label=f"grain {sensor}"
        )
    axes.set_xlim(_KILO * float(found.frequency[0]), max(_KILO * float(found.frequency[-1]), 1e-9))
    largest = float(found.amplitude.max())
    axes.set_ylim(max(float(found.amplitude.min()) / 2, 1e-12 * largest), 2 * largest)
    legend_above(axes, min(len(found.sensors), 4))
    columns: dict[str, Any] = {"frequency_Hz": found.frequency}
    for n, sensor in enumerate(found.sensors):
        columns |= {
            f"amplitude_{sensor}": found.amplitude[:, n],
            f"phase_{sensor}_rad": found.phase[:, n],
        }
    return Drawing(figure, columns)
