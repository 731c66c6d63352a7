"""Peak forces of a packing at several velocities: linear in the impulse at every contact, and a front that gets planar.

The impulse is the momentum of the struck spheres.

Peak forces of contacts against the impulse that struck the packing, and whether they are proportional.

Front of a wave in a packing: peak forces by layer within the cone of the preferred directions.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.document.cells import show
from granwave.analysis.document.model import Table
from granwave.analysis.figures.series import label, panels
from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing
from granwave.analysis.measures.geometry import preferred_directions
from granwave.analysis.measures.impact import rays
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.axes import log_ticks
from granwave.analysis.studies.packing_and_block.curves import colour_and_marker
from granwave.analysis.studies.packing_and_block.impacts import Granular, Impacts
from granwave.analysis.studies.study import Sketch
from granwave.analysis.studies.tables import numeric, table_of
from granwave.lammps_inputs.errors import GranwaveError

_FEWEST_RUNS = 3
_ON_RAY = (1, 2, 4, 8, 12)  # contacts of a preferred direction, from the struck sphere, that are drawn
_LAYERS_TOLD = (1, 4, 8, 16)  # below the struck one, whose uniformity is told
_MOST_FRONTS = 4
_BANDS = 5  # of depth
_ROOM = 2.4  # inches: length of the horizontal axis of a panel
_MILLI = 1e3
_IMPULSE = (
    "Granular: peak force against impulse. Points on their line, and exponents of 1 at every depth, tell that force is "
    "proportional to impulse"
)
_FRONT = (
    "Granular: the front by layer. Below F_y the front is elastic; a mean that comes near the largest force of its "
    "layer tells that it gets planar"
)
_UNREADABLE = (GranwaveError, OSError, KeyError)


def linear(runs: Sequence[Granular]) -> Linearity | None:
    """Linearity of runs that differ in velocity, by rising velocity; None for fewer than three. Forces are in F_y."""
    if len(runs) < _FEWEST_RUNS:
        return None
    forces = []
    try:
        for run in runs:
            with Result(run.directory) as result:
                forces.append(peak_forces(result, run.law.yield_force))
    except _UNREADABLE:
        return None
    return linearity([run.velocity_normalised for run in runs], forces)


def fronts(runs: Sequence[Granular]) -> list[tuple[float, Front]]:
    """Normalised velocity and front of up to four runs, spread over their range; forces are in F_y."""
    if not runs or len(preferred_directions(runs[0].case.packing.kind)) != 3:
        return []
    found = []
    for n in sorted({round(n) for n in np.linspace(0, len(runs) - 1, _MOST_FRONTS)}):
        try:
            with Result(runs[n].directory) as result:
                found.append((runs[n].velocity_normalised, front_of(result, runs[n].law.yield_force)))
        except _UNREADABLE:
            continue
    return found


def pictures(impacts: Impacts) -> Iterator[Sketch]:
    """Peak force against impulse, and the front, of the reference."""
    found = linear(impacts.fast)
    if found is not None:
        draw = partial(_peak_force_against_impulse, found)
        yield Sketch("peak_force_impulse", _IMPULSE, draw)
    there = fronts(impacts.reference)
    if there:
        yield Sketch("front", _FRONT, partial(_front_by_depth, there))


def tables(impacts: Impacts) -> Iterator[Table]:
    """Exponents of force against impulse over fifths of the depth, and the front."""
    found = linear(impacts.fast)
    if found is not None:
        numbers = numeric(("to", "mm"), "Contacts", "5 %", "Median", "95 %")
        columns = (*numeric(("Depth from", "mm"), key=True), *numbers)
        caption = (
            f"Peak force against impulse: exponent over normalised velocities from {show(float(found.velocity[0]))} to "
            f"{show(float(found.velocity[-1]))} (1: proportional)"
        )
        yield table_of(caption, columns, _by_depth(found))
    there = fronts(impacts.reference)
    if there:
        numbers = numeric(("Elastic from a depth of", "mm"), *(f"Uniformity, layer {n}" for n in _LAYERS_TOLD))
        rows = []
        for velocity, front in there:
            elastic = None if front.weak_from is None else _MILLI * front.weak_from
            uniformity = [float(front.uniformity[n]) if n < len(front.uniformity) else None for n in _LAYERS_TOLD]
            rows.append((velocity, elastic, *uniformity))
        caption = "The front: mean over largest peak force of a layer, within the cone of the preferred directions"
        yield table_of(caption, (*numeric("Normalised velocity", key=True), *numbers), rows)


def _by_depth(found: Linearity) -> Iterator[tuple[float, ...]]:
    """Top and bottom of a band, mm, how many contacts, and 5 %, 50 % and 95 % of their exponents, over fifths."""
    for top, bottom in pairwise(np.linspace(0, float(found.depth.max()), _BANDS + 1).tolist()):
        inside = (found.depth >= top) & (found.depth <= bottom)
        if inside.any():
            quantiles = np.quantile(found.exponent[inside], (0.05, 0.5, 0.95))
            yield _MILLI * top, _MILLI * bottom, int(inside.sum()), *quantiles.tolist()


def _peak_force_against_impulse(found: Linearity) -> Drawing:
    """Force against velocity along a preferred direction, and the exponent of every contact against depth."""
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {"velocity_normalised": found.velocity}
    for k, n in enumerate(n for n in _ON_RAY if n <= len(found.ray)):
        values, look = found.ray[n - 1], colour_and_marker(k)
        left.plot(
            found.velocity, values, label=f"contact {n}", markerfacecolor="none", markersize=5, linestyle="none", **look
        )
        proportional = values[-1] * found.velocity / found.velocity[-1]
        left.plot(found.velocity, proportional, color=look["color"], linewidth=0.7)
        columns[f"contact_{n}_over_Fy"] = values
    label(left, r"Impact velocity $\bar v_0$, as impulse", r"Peak force $F_\mathrm{max}/F_\mathrm{y}$", log="xy")
    log_ticks(left.xaxis, _ROOM)
    left.set_ylim(top=30 * float(np.nanmax(found.ray)))
    left.legend(title="lines: proportional", alignment="left", ncols=3, loc="upper left", fontsize=7, columnspacing=1)
    right.plot(found.depth * _MILLI, found.exponent, ".", color=BLUE, markersize=1.5, rasterized=True)
    right.axhline(1, color=ORANGE, linewidth=0.8)
    low, high = np.quantile(found.exponent, (0.005, 0.995))
    limits = min(low, 0.8), max(high, 1.2)
    label(right, "Depth of the contact (mm)", "Exponent of force against impulse", ylim=limits)
    return Drawing(figure, columns | {"depth_m": found.depth, "exponent": found.exponent})


def _front_by_depth(found: Sequence[tuple[float, Front]]) -> Drawing:
    """Largest peak force and its uniformity by layer: the front gets elastic, then planar."""
    figure, left, right = panels(2.6, 2)
    columns: dict[str, NDArray] = {}
    for n, (velocity, front) in enumerate(found):
        look = {**colour_and_marker(n), "markersize": 3.5, "linewidth": 0.8}
        left.plot(front.depth * _MILLI, front.largest, label=rf"$\bar v_0$ = {velocity:.4g}", **look)
        right.plot(front.depth * _MILLI, front.uniformity, **look)
        columns[f"depth_m_v_{velocity:.4g}"] = front.depth
        columns[f"largest_over_Fy_v_{velocity:.4g}"] = front.largest
        columns[f"mean_over_largest_v_{velocity:.4g}"] = front.uniformity
    left.axhline(1, color=GREY, linestyle=":", linewidth=0.9)
    label(left, "Depth (mm)", r"Largest peak force of a layer $/F_\mathrm{y}$", log="y")
    left.legend()
    label(right, "Depth (mm)", "Mean / largest peak force of a layer", ylim=(0, 1.05))
    return Drawing(figure, columns)


_WEAK = 1.0  # of the unit: contacts that stay below at the largest velocity are left out

Pair = tuple[int, int]


@dataclasses.dataclass(frozen=True, eq=False)
class PeakForces:
    """Peak forces of one impact.

    Attributes
    ----------
    of_pair
        Of every contact, by the ids of its spheres.
    along
        Largest of the n-th contacts along the preferred directions: (n_contacts,).
    depth
        Of the contacts within the cone of these directions, m, by the ids of their spheres.
    """

    of_pair: dict[Pair, float]
    along: NDArray[np.float64]
    depth: dict[Pair, float]


def peak_forces(result: Result, unit: float) -> PeakForces:
    """Return the peak forces of an impact in a unit, N."""
    pairs = list(zip(result["contacts/i"].tolist(), result["contacts/j"].tolist(), strict=True))
    force = (result["contacts/peak_force"] / unit).tolist()
    depth = result["spheres/position"][result.ends, 2].mean(axis=1) - result.origin[2]
    inside = np.flatnonzero(in_cone(result)[result.ends].all(axis=1))
    along = np.fmax.reduce(rays(result).peak_force, axis=1) / unit  # NaN where no ray has a contact
    return PeakForces(dict(zip(pairs, force, strict=True)), along, {pairs[k]: float(depth[k]) for k in inside})


@dataclasses.dataclass(frozen=True, eq=False)
class Linearity:
    """Peak force against velocity, contact by contact.

    Attributes
    ----------
    velocity
        (n_runs,).
    ray
        Largest peak force of the contacts on the preferred directions: (n_contacts, n_runs).
    depth
        Of the contacts, m: (m,).
    exponent
        Of force against velocity, a least-squares slope on logarithmic axes: (m,).
    """

    velocity: NDArray[np.float64]
    ray: NDArray[np.float64]
    depth: NDArray[np.float64]
    exponent: NDArray[np.float64]


def linearity(velocity: Sequence[float], found: Sequence[PeakForces]) -> Linearity | None:
    """Return the linearity of impacts on one packing, by rising velocity; None if no contact counts.

    Contacts count that lie within the cone of the preferred directions, are pressed beyond the unit at the largest
    velocity and were pressed at all at every other. Beyond the cone a contact may be loaded by the rebound alone.
    """
    forces, depth = [one.of_pair for one in found], found[-1].depth
    kept = [pair for pair in depth if forces[-1][pair] > _WEAK and all(one.get(pair, 0) > 0 for one in forces)]
    if not kept:
        return None
    x, y = np.log(velocity), np.log([[one[pair] for one in forces] for pair in kept])
    x = x - x.mean()
    shortest = min(len(one.along) for one in found)
    ray = np.stack([one.along[:shortest] for one in found], axis=1)
    return Linearity(np.array(velocity), ray, np.array([depth[pair] for pair in kept]), (y @ x) / (x @ x))


_INSIDE = -1e-6  # diameters, of a coordinate along a preferred direction: within the cone that these span
_LAYERS = 1e3  # in a diameter, by which depths are told apart


@dataclasses.dataclass(frozen=True, eq=False)
class Front:
    """Peak forces of the layers that the wave reached; every array (n_layers,).

    Attributes
    ----------
    depth
        Below the struck sphere, m.
    largest
        Peak force of a sphere, in the unit of the front.
    uniformity
        Mean over largest: 1 where the front is planar.
    """

    depth: NDArray[np.float64]
    largest: NDArray[np.float64]
    uniformity: NDArray[np.float64]

    @property
    def weak_from(self) -> float | None:
        """Depth of the layer from which on no force is above the unit, m; None if all are."""
        above = np.flatnonzero(self.largest > 1)
        first = int(above[-1]) + 1 if len(above) else 0
        return float(self.depth[first]) if first < len(self.depth) else None


def front_of(result: Result, unit: float) -> Front:
    """Return the front of an impact.

    Parameters
    ----------
    unit
        Of the forces, N.
    """
    depth, inside = result["spheres/position"][:, 2] - result.origin[2], in_cone(result)
    force, diameter = result["spheres/peak_force"][inside] / unit, result.case.packing.diameter
    layers, layer = np.unique(np.rint(_LAYERS * depth[inside] / diameter), return_inverse=True)
    largest = np.zeros(len(layers))
    np.maximum.at(largest, layer, force)
    mean = np.bincount(layer, force) / np.bincount(layer)
    reached = largest > 0
    return Front(layers[reached] * diameter / _LAYERS, largest[reached], mean[reached] / largest[reached])


def in_cone(result: Result) -> NDArray[np.bool_]:
    """Spheres within the cone that the preferred directions span: (n_spheres,); all where these are not three."""
    case = result.case
    directions = preferred_directions(case.packing.kind)
    offset = result["spheres/position"] - result.origin
    if len(directions) != 3:
        return np.ones(len(offset), dtype=bool)
    return np.all(offset @ np.linalg.inv(directions) > _INSIDE * case.packing.diameter, axis=1)
