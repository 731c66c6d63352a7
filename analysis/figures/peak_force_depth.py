"""Figure of the peak force against the depth, with the fitted law of its decay."""

from __future__ import annotations

from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from granwave.analysis.figures.colouring import force_scale
from granwave.analysis.figures.series import label, label_log_axis, panels, with_error
from granwave.analysis.figures.style import BLUE, GREEN, ORANGE, Drawing, legend_above
from granwave.analysis.measures.beads import beads_on_axis
from granwave.analysis.measures.dynamic_force import has_static_forces
from granwave.analysis.measures.force_decay import (
    ForceDecay,
    PowerDecay,
    accepted,
    both_decays,
    reason_against,
)
from granwave.analysis.measures.impact import peak_force_by_depth, rays
from granwave.analysis.measures.layer_peaks import LayerPeaks, layer_peaks
from granwave.analysis.measures.signals import Array
from granwave.analysis.result.reader import Result

_MILLI = 1e3  # mm in a metre
_POINTS_OF_FIT = 50
_MARGIN = 1.03  # end of the axis of depths / depth of the last layer
_MOST_MARKED = 60  # largest number of layers with a marker each
# smallest force of a layer that the wave has not passed / of the layers that it has passed: lower
# ones are at the foot of the wave, and would only stretch the axis
_LEAST_RISING = 0.3
_FEWEST = 2  # fewest layers and loaded contacts of a course of forces
_LETTERS = 36  # most letters of a line of a legend


def peak_force_depth(result: Result) -> Drawing | None:
    """Draw the decay of the peak force: largest of each layer with the law that is fitted to it, a
    marker for each layer of contacts along the preferred directions, at the depth of their lower
    sphere, and bars over the range of these directions.

    The forces are those of the first wave. Layers whose largest force occurred when the reflection
    from the base may have arrived have hollow markers, and are not fitted. Under a load that keeps
    oscillating the forces are the largest of the run.

    Under a static load the fitted force is the largest dynamic force of each layer, above the
    static force; a line shows the largest total force of the run. Where no law describes the
    forces, the legend gives the reason.

    Layers that the wave has not reached are not drawn. Beads of a chain and grains that were added
    next to them are separate curves.
    """
    is_bead = beads_on_axis(result)
    if is_bead is not None:
        return _peak_force_of_beads(result, is_bead)
    depth, force = peak_force_by_depth(result)
    n_loaded = np.count_nonzero(result["contacts/peak_force"] > 0)
    # a single contact has no course of forces, and a chain has a figure of its own
    if len(depth) < _FEWEST or n_loaded < _FEWEST or "chain" in result:
        return None
    scale, unit, name = force_scale(result)
    peaks = layer_peaks(result)
    along = rays(result)
    n_contacts, n_rays = along.peak_force.shape
    pitch = result.case.packing.diameter * along.directions[0, 2] if n_rays else 0.0
    middle = (np.arange(n_contacts) + 0.5) * pitch  # depth of the contact points
    figure, axes = panels(3.2)
    if n_rays > 1 and _have_lines(along.peak_force):
        arrival = np.interp(middle, depth, peaks.reflection)
        is_first = along.time_peak < arrival[:, None]
        lower = (np.arange(n_contacts) + 1.0) * pitch  # as the layers, whose peaks they are
        _mark_directions(axes, lower * _MILLI, np.where(is_first, along.peak_force, 0.0) / scale)
    is_pressed = has_static_forces(result)
    if is_pressed:
        total = "largest of the layer in the run, with static force"
        axes.plot(depth * _MILLI, force / scale, "-.", color=GREEN, label=total, zorder=1)
    _draw_layers(axes, peaks, scale)
    decay = _draw_fit(axes, result, peaks, scale)
    _label_depths(axes, peaks, unit, is_pressed=is_pressed)
    columns: dict[str, ArrayLike] = {
        "layer_depth_m": depth,
        f"layer_peak_{name}": force / scale,
        "layer_peak_after_reflection": peaks.is_later.astype(int),
        "layer_still_rises": _still_rising(peaks).astype(int),
        "of_first_wave": [int(peaks.of_first_wave)],
        "contact_depth_m": middle,
    }
    if is_pressed:
        columns[f"layer_dynamic_{name}"] = peaks.largest / scale
    if decay is not None:
        columns |= _columns_of_decay(decay)
    columns |= {
        f"direction_{n + 1}_{name}": values / scale for n, values in enumerate(along.peak_force.T)
    }
    return Drawing(figure, columns)


def words_on_depths(_: Result, table: Path) -> tuple[str, str]:
    """Return caption and look of `peak_force_depth` of a run.

    Parameters
    ----------
    table
        Path of the data of the figure, CSV.
    """
    data = np.genfromtxt(table, delimiter=",", names=True, ndmin=1)
    names = data.dtype.names or ()
    look = ["A straight line is exponential."]
    if any(name.startswith("decay_") for name in names):
        look.append("The fit excludes the impacted and the last layer.")
    if "bead_depth_m" in names:
        caption = (
            "Peak force of the contacts between beads, and of the grains next to them, against "
            "depth, excluding walls"
        )
        look.append("Beads that the wave has not reached are not drawn.")
        later = data["bead_peak_after_reflection"]
    else:
        is_first = "of_first_wave" not in names or data["of_first_wave"][0] > 0
        part = "first wave" if is_first else "run"
        caption = f"Peak contact force of the {part} against depth, excluding walls"
        later = data["layer_peak_after_reflection"]
    if np.any(later > 0):
        look.append("Squares: after a reflection.")
    rising = [name for name in names if name.endswith("_still_rises")]
    if any(np.any(data[name] > 0) for name in rising):
        look.append("Crosses: still rising at the end.")
    directions = [name for name in names if name.startswith("direction_")]
    if len(directions) > 1 and np.any([data[name][1:2] > 0 for name in directions]):
        look.append("Circles: contacts, at their lower sphere.")
    return caption, " ".join(look)


def _peak_force_of_beads(result: Result, is_bead: NDArray[np.bool_]) -> Drawing | None:
    """Draw the peak forces of the beads of a chain with the fitted decay, and those of the grains
    that were added next to them.
    """
    beads = layer_peaks(result, is_bead)
    added = layer_peaks(result, ~is_bead & result.in_packing)
    if np.count_nonzero(beads.is_known) < _FEWEST:
        return None
    scale, unit, name = force_scale(result)
    figure, axes = panels(3.2)
    _draw_layers(axes, beads, scale, "between beads")
    shown = added.is_known | added.is_later
    axes.plot(
        added.depth[shown] * _MILLI,
        added.largest[shown] / scale,
        "--",
        color=ORANGE,
        linewidth=1.0,
        label="largest of the grains next to the beads",
    )
    decay = _draw_fit(axes, result, beads, scale)
    _label_depths(axes, beads, unit, is_pressed=has_static_forces(result))
    columns = {
        "bead_depth_m": beads.depth,
        f"bead_peak_{name}": beads.largest / scale,
        "bead_peak_is_known": beads.is_known.astype(int),
        "bead_still_rises": _still_rising(beads).astype(int),
        "bead_peak_after_reflection": beads.is_later.astype(int),
        "added_depth_m": added.depth,
        f"added_peak_{name}": added.largest / scale,
        "added_peak_is_known": added.is_known.astype(int),
    }
    if decay is not None:
        columns |= _columns_of_decay(decay)
    return Drawing(figure, columns)


def _draw_fit(
    axes: Axes, result: Result, peaks: LayerPeaks, scale: float
) -> ForceDecay | PowerDecay | None:
    """Draw the decay that is fitted to layers, or give the reason why there is none in the legend;
    return the decay.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    """
    fits = both_decays(result, peaks)
    decay = accepted(fits)
    if decay is None:
        axes.plot([], [], " ", label=_wrapped(reason_against(fits)))
    else:
        _draw_decay(axes, decay, scale)
    return decay


def _label_depths(axes: Axes, peaks: LayerPeaks, unit: str, *, is_pressed: bool) -> None:
    """Label the axes of peak forces against depth, which end at the last layer that the wave
    reached, and draw the legend.

    Parameters
    ----------
    unit
        Label of the unit of the forces.
    is_pressed
        True for the rise of forces above static ones.
    """
    kind = "Dynamic peak force" if is_pressed else "Peak force"
    part = "first wave" if peaks.of_first_wave else "run"
    last = peaks.depth[-1]
    if np.any(peaks.is_reached):
        last = peaks.depth[peaks.is_reached][-1]
    limits = (0, _MARGIN * last * _MILLI)
    label(axes, "Depth (mm)", f"{kind} of the {part} {unit}", log="y", xlim=limits)
    lowest, highest = axes.get_ylim()
    label_log_axis(axes, highest / lowest)
    legend_above(axes, 1, fontsize=8)


def _have_lines(force: Array) -> bool:
    """Return True if a second contact of the preferred directions is loaded: in hcp the grains are
    not on a line beyond the first contact.

    Parameters
    ----------
    force
        Forces, 0 or NaN without contact: (n_contacts, n_directions), N.
    """
    return len(force) >= _FEWEST and bool(np.any(force[1] > 0))


def _draw_layers(
    axes: Axes, peaks: LayerPeaks, scale: float, name: str = "largest of the layer"
) -> None:
    """Draw the largest force of each layer: of the first wave as a line, of later times and of
    layers that it has reached and not passed as markers.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    name
        Of the forces in the legend.
    """
    depth = peaks.depth * _MILLI
    force = peaks.largest / scale
    others = _still_rising(peaks)
    marker = "." if len(depth) <= _MOST_MARKED else ""
    look: dict[str, Any] = {
        "color": BLUE, "markerfacecolor": "none", "markersize": 4, "zorder": 1.5
    }  # fmt: skip
    for chosen, signs, text in (
        (peaks.is_known, f"{marker}-", name),
        (peaks.is_later, "s", "after the reflection, not fitted"),
        (others, "x", "still rising at the end"),
    ):
        if np.any(chosen):
            axes.plot(depth[chosen], force[chosen], signs, label=text, **look)


def _still_rising(peaks: LayerPeaks) -> NDArray[np.bool_]:
    """Return True for layers whose force still rises at the end, and is not far below those of the
    layers that the wave has passed: (n_layers,).
    """
    others = ~peaks.is_known & ~peaks.is_later & peaks.is_reached
    passed = peaks.largest[peaks.is_known | peaks.is_later]
    lowest = passed.min(initial=float(peaks.largest.max(initial=0.0)))
    return others & (peaks.largest > _LEAST_RISING * lowest)


def _wrapped(reason: str) -> str:
    """Return the reason why no decay is drawn, in lines of a legend."""
    text = reason if reason.startswith(("no decay", "neither")) else f"no fit: {reason}"
    return "\n".join(wrap(text, _LETTERS))


def _draw_decay(axes: Axes, decay: ForceDecay | PowerDecay, scale: float) -> None:
    """Draw a fitted decay over the layers of the fit.

    Parameters
    ----------
    scale
        Unit of the forces of the figure, N.
    """
    if isinstance(decay, ForceDecay):
        first, last = decay.depth[[0, -1]]
        value = with_error(decay.rate, decay.error)
        law = rf"$\exp(-bz)$, $b$ = {value} per m"
    else:
        first = decay.first
        last = decay.last
        value = with_error(decay.exponent, decay.error)
        law = rf"$z^{{-n}}$, $n$ = {value}"
    depth = np.linspace(first, last, _POINTS_OF_FIT)
    axes.plot(
        depth * _MILLI,
        decay(depth) / scale,
        "--",
        color="black",
        linewidth=0.9,
        label=f"fitted {law},\nrms {100 * decay.misfit:.2g} %, {decay.n_layers} layers",
    )


def _columns_of_decay(decay: ForceDecay | PowerDecay) -> dict[str, NDArray[np.float64]]:
    """Return the constants of a fitted decay as columns."""
    if isinstance(decay, ForceDecay):
        values = {"decay_per_m": decay.rate, "decay_error_per_m": decay.error}
    else:
        values = {"decay_exponent": decay.exponent, "decay_exponent_error": decay.error}
    values["decay_misfit"] = decay.misfit
    return {name: np.array([value]) for name, value in values.items()}


def _mark_directions(axes: Axes, depth: Array, force: Array) -> None:
    """Mark the median force of contacts along the preferred directions, with bars over their range.

    Parameters
    ----------
    depth
        Depths of the contacts: (n_contacts,), mm.
    force
        Forces in the unit of the figure, 0 without contact: (n_contacts, n_directions).
    """
    loaded = np.flatnonzero(np.all(force > 0, axis=1))
    if not len(loaded):
        return
    middle = np.median(force[loaded], axis=1)
    below = middle - force[loaded].min(axis=1)
    above = force[loaded].max(axis=1) - middle
    axes.errorbar(
        depth[loaded],
        middle,
        yerr=np.stack([below, above]),
        fmt="o",
        color=ORANGE,
        markerfacecolor="none",
        markersize=4,
        markeredgewidth=0.8,
        elinewidth=0.8,
        capsize=2,
        label=f"contacts along {force.shape[1]} preferred directions",
    )
