"""Peak forces of a packing at several velocities: linear in the impulse at every contact, and a front that gets planar.

Thesis 5.2 and 5.3.1. The impulse is the momentum of the struck spheres.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from granwave.analysis.figures.style import BLUE, GREY, ORANGE, Drawing, new_figure
from granwave.analysis.measures.dissipation import rays
from granwave.analysis.measures.planes import preferred_directions
from granwave.analysis.result.reader import Result
from granwave.analysis.studies.granular_continuum.impacts import Granular, Impacts
from granwave.analysis.studies.granular_continuum.scaling import COLOURS, MARKERS
from granwave.lammps_inputs.errors import GranwaveError

_FEWEST_RUNS = 3
_WEAK = 1.0  # of F_y: contacts that stay below at the largest velocity are left out
_ON_RAY = (1, 2, 4, 8, 12)  # contacts of a preferred direction, from the struck sphere, that are drawn
_INSIDE = -1e-6  # of a coordinate along a preferred direction: within the cone that these span
_MOST_FRONTS = 4
_BANDS = 5  # of depth
_MILLI = 1e3


@dataclasses.dataclass(frozen=True, eq=False)
class Linearity:
    """Peak force against velocity, contact by contact.

    Attributes
    ----------
    velocity
        Normalised: (n_runs,).
    ray
        Largest peak force over F_y of the contacts on the preferred directions: (n_contacts, n_runs).
    depth
        Of the contacts, m: (m,).
    exponent
        Of force against velocity, a least-squares slope on logarithmic axes: (m,).
    departure
        Largest relative departure of a contact's forces from a straight line through zero: (m,).
    """

    velocity: NDArray[np.float64]
    ray: NDArray[np.float64]
    depth: NDArray[np.float64]
    exponent: NDArray[np.float64]
    departure: NDArray[np.float64]


def linearity(impacts: Impacts, *, lowest: float) -> Linearity | None:
    """Linearity of runs of the reference at normalised velocities from ``lowest`` on; None for fewer than three.

    Contacts count that lie within the cone of the preferred directions, are pressed beyond F_y at the largest velocity
    and were pressed at all at every other. Beyond the cone a contact may be loaded by the rebound alone.
    """
    runs = [run for run in impacts.reference if run.velocity_normalised >= lowest * (1 - 1e-9)]
    if len(runs) < _FEWEST_RUNS:
        return None
    velocity = np.array([run.velocity_normalised for run in runs])
    tables, along = [], []
    depth: dict[tuple[int, int], float] = {}
    try:
        for run in runs:
            with Result(run.directory) as result:
                pairs = list(zip(result["contacts/i"].tolist(), result["contacts/j"].tolist(), strict=True))
                tables.append(
                    dict(zip(pairs, (result["contacts/peak_force"] / run.law.yield_force).tolist(), strict=True))
                )
                along.append(np.nanmax(rays(result).peak_force, axis=1) / run.law.yield_force)
                if run is runs[-1]:
                    inside, z = _in_cone(result)[result.ends], result["spheres/position"][result.ends, 2]
                    middle = z.mean(axis=1) - result.origin[2]
                    depth = {pairs[k]: float(middle[k]) for k in np.flatnonzero(inside.all(axis=1))}
    except (GranwaveError, OSError, KeyError):
        return None
    kept = [pair for pair in depth if tables[-1][pair] > _WEAK and all(t.get(pair, 0) > 0 for t in tables)]
    if not kept:
        return None
    forces = np.array([[table[pair] for table in tables] for pair in kept])
    x, y = np.log(velocity), np.log(forces)
    x = x - x.mean()
    slope = forces @ velocity / (velocity @ velocity)
    return Linearity(
        velocity=velocity,
        ray=np.stack([column[: min(map(len, along))] for column in along], axis=1),
        depth=np.array([depth[pair] for pair in kept]),
        exponent=(y @ x) / (x @ x),
        departure=np.abs(forces / (slope[:, None] * velocity) - 1).max(axis=1),
    )


@dataclasses.dataclass(frozen=True)
class Exponents:
    """Exponents of peak force against impulse of the contacts between two depths (m): how many, and quantiles."""

    top: float
    bottom: float
    n: int
    low: float
    median: float
    high: float


def exponents_by_depth(found: Linearity) -> list[Exponents]:
    """Over fifths of the depth; the quantiles are 5 %, 50 % and 95 %."""
    edges = np.linspace(0, float(found.depth.max()), _BANDS + 1)
    rows = []
    for top, bottom in pairwise(edges):
        inside = (found.depth >= top) & (found.depth <= bottom)
        if inside.any():
            low, middle, high = np.quantile(found.exponent[inside], (0.05, 0.5, 0.95))
            rows.append(Exponents(float(top), float(bottom), int(inside.sum()), float(low), float(middle), float(high)))
    return rows


def peak_force_against_impulse(found: Linearity) -> Drawing:
    """Force against velocity along a preferred direction, and the exponent of every contact against depth."""
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, NDArray] = {"velocity_normalised": found.velocity}
    shown = [n for n in _ON_RAY if n <= len(found.ray)]
    for k, n in enumerate(shown):
        values = found.ray[n - 1]
        colour, marker = COLOURS[k % len(COLOURS)], MARKERS[k % len(MARKERS)]
        left.plot(
            found.velocity, values, marker, color=colour, markerfacecolor="none", markersize=5, label=f"contact {n}"
        )
        left.plot(found.velocity, values[-1] * found.velocity / found.velocity[-1], color=colour, linewidth=0.7)
        columns[f"contact_{n}_over_Fy"] = values
    left.set_xscale("log")
    left.set_yscale("log")
    left.set_xlabel(r"Impact velocity $\bar v_0$, as impulse")
    left.set_ylabel(r"Peak force $F_\mathrm{max}/F_\mathrm{y}$")
    left.xaxis.set_minor_formatter(NullFormatter())
    left.set_ylim(top=30 * float(np.nanmax(found.ray)))
    left.legend(title="lines: proportional", alignment="left", ncols=3, loc="upper left", fontsize=7, columnspacing=1)
    right.plot(found.depth * _MILLI, found.exponent, ".", color=BLUE, markersize=1.5, rasterized=True)
    right.axhline(1, color=ORANGE, linewidth=0.8)
    right.set_xlabel("Depth of the contact (mm)")
    right.set_ylabel("Exponent of force against impulse")
    low, high = np.quantile(found.exponent, (0.005, 0.995))
    right.set_ylim(min(low, 0.8), max(high, 1.2))
    return Drawing(figure, columns | {"depth_m": found.depth, "exponent": found.exponent})


@dataclasses.dataclass(frozen=True, eq=False)
class Front:
    """Peak forces by layer, within the cone that the preferred directions span; every array (n_layers,).

    Attributes
    ----------
    depth
        Below the struck sphere, m.
    largest
        Peak force of a sphere over F_y.
    uniformity
        Mean over largest: 1 where the front is planar.
    """

    velocity: float
    depth: NDArray[np.float64]
    largest: NDArray[np.float64]
    uniformity: NDArray[np.float64]

    @property
    def elastic_from(self) -> float | None:
        """Depth of the layer from which on no contact in the cone yields, m; None if all do."""
        above = np.flatnonzero(self.largest > 1)
        first = int(above[-1]) + 1 if len(above) else 0
        return float(self.depth[first]) if first < len(self.depth) else None


def fronts(impacts: Impacts) -> list[Front]:
    """The front at up to four velocities of the reference, spread over its range."""
    runs = impacts.reference
    if not runs or len(preferred_directions(runs[0].case.packing.kind)) != 3:
        return []
    chosen = sorted({round(n) for n in np.linspace(0, len(runs) - 1, _MOST_FRONTS)})
    found = [_front(runs[n]) for n in chosen]
    return [front for front in found if front is not None]


def _front(run: Granular) -> Front | None:
    try:
        with Result(run.directory) as result:
            depth = result["spheres/position"][:, 2] - result.origin[2]
            force = result["spheres/peak_force"] / run.law.yield_force
            inside = _in_cone(result)
    except (GranwaveError, OSError, KeyError):
        return None
    diameter = run.case.packing.diameter
    layers, layer = np.unique(np.rint(1e3 * depth[inside] / diameter), return_inverse=True)
    largest = np.zeros(len(layers))
    np.maximum.at(largest, layer, force[inside])
    mean = np.bincount(layer, force[inside]) / np.bincount(layer)
    reached = largest > 0
    return Front(
        run.velocity_normalised, layers[reached] * diameter / 1e3, largest[reached], mean[reached] / largest[reached]
    )


def _in_cone(result: Result) -> NDArray[np.bool_]:
    """Which spheres lie within the cone that the preferred directions span; all where these are not three."""
    case = result.case
    directions = preferred_directions(case.packing.kind)
    offset = result["spheres/position"] - result.origin
    if len(directions) != 3:
        return np.ones(len(offset), dtype=bool)
    return np.all(offset @ np.linalg.inv(directions) > _INSIDE * case.packing.diameter, axis=1)


def front_by_depth(found: Sequence[Front]) -> Drawing:
    """Largest peak force and its uniformity by layer: the front gets elastic, then planar (thesis 5.2)."""
    figure = new_figure(2.6, 7.0)
    left, right = figure.subplots(1, 2)
    columns: dict[str, NDArray] = {}
    for n, front in enumerate(found):
        style = {"color": COLOURS[n % len(COLOURS)], "marker": MARKERS[n % len(MARKERS)], "markersize": 3.5}
        name = rf"$\bar v_0$ = {front.velocity:.4g}"
        left.plot(front.depth * _MILLI, front.largest, linewidth=0.8, label=name, **style)
        right.plot(front.depth * _MILLI, front.uniformity, linewidth=0.8, **style)
        key = f"v_{front.velocity:.4g}"
        columns |= {
            f"depth_m_{key}": front.depth,
            f"largest_over_Fy_{key}": front.largest,
            f"mean_over_largest_{key}": front.uniformity,
        }
    left.axhline(1, color=GREY, linestyle=":", linewidth=0.9)
    left.set_yscale("log")
    left.set_ylabel(r"Largest peak force of a layer $/F_\mathrm{y}$")
    left.legend()
    right.set_ylim(0, 1)
    right.set_ylabel("Mean / largest peak force of a layer")
    for axes in (left, right):
        axes.set_xlabel("Depth (mm)")
    return Drawing(figure, columns)
