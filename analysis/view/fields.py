"""Fields that the page of a run shows: values of the spheres at every instant, as levels of a logarithmic scale.

Instants are the snapshots of a run, or those at which a whole chain was recorded, which are more. A page holds millions
of values. They are stored as the levels of a scale of `LEVELS` colours, with 0 for values below it: numbers that
repeat, which compress to a twentieth.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from numpy.typing import NDArray

from granwave.analysis.figures.sections import DISSIPATION_LIMITS, decades_up_to, force_scale
from granwave.analysis.figures.style import DISSIPATION_MAP, FORCE_MAP
from granwave.analysis.result.reader import Result

_MOST_OF_A_CHAIN = 120  # instants of up to a thousand
BLANK = "#a4a4a4"  # spheres below the scale; the lights of the page make it paler
LEVELS = 100  # colours of a scale; steps of a twentieth of a decade, or finer
_DECADES = 4  # of a scale of forces, far below F_y, to include the elastic wave


@dataclass(frozen=True, eq=False)
class Instants:
    """Values of the spheres at rising times.

    Attributes
    ----------
    times
        Times, s: (n_instants,).
    quantities
        Names that `values` knows, as of a snapshot.
    values
        Function of the number of an instant and a quantity: (n_spheres,) or (n_spheres, 3), SI units.
    """

    times: NDArray[np.float64]
    quantities: tuple[str, ...]
    values: Callable[[int, str], NDArray[np.float64]]

    def at(self, numbers: Sequence[int]) -> Instants:
        """Return some of the instants, by their numbers."""
        return Instants(self.times[list(numbers)], self.quantities, lambda n, name: self.values(numbers[n], name))


def instants_of(result: Result) -> Instants:
    """Return the instants of a run: its snapshots, with 0 for what was not recorded, or the record of a chain."""
    if "chain" in result and len(result["chain/time"]) > result.n_frames:
        return _of_chain(result)
    return Instants(
        result.frame_times, result.quantities, lambda number, name: np.nan_to_num(result.frame(number, name))
    )


def _of_chain(result: Result) -> Instants:
    """Return velocity and displacement, which point along the chain, and the largest force of each bead's contacts."""
    time, n = result["chain/time"], result.n_spheres
    rows = np.unique(np.linspace(0, len(time) - 1, min(_MOST_OF_A_CHAIN, len(time))).round().astype(int))
    beads, force = result.rows(result["chain/id"]), np.zeros((len(time), n))
    row = dict(zip(result["chain/id"].tolist(), beads.tolist(), strict=True))
    for end in ("chain/contact_i", "chain/contact_j"):
        for contact, sphere in enumerate(result[end].tolist()):
            if sphere in row:  # else the face of a bar
                np.maximum(force[:, row[sphere]], result["chain/contact_force"][:, contact], out=force[:, row[sphere]])
    scalars = {"contact_force": force, "peak_force": np.maximum.accumulate(force, axis=0)}
    along = {name: result[f"chain/{name}"] for name in ("velocity", "displacement")}

    def values(number: int, quantity: str) -> NDArray[np.float64]:
        if quantity in scalars:
            return np.asarray(scalars[quantity][rows[number]])
        found = np.zeros((n, 3))
        found[beads, 2] = along[quantity][rows[number]]
        return found

    return Instants(time[rows], (*along, *scalars), values)


@dataclass(frozen=True, eq=False)
class Field:
    """A field with its colour scale.

    Attributes
    ----------
    name
        Its name in the panel.
    label
        Label of the colour bar, with the unit.
    map
        Name of the colour map.
    low, high
        Ends of the logarithmic scale, in the unit of the label.
    above
        True if there are values above the scale.
    levels
        Level over `LEVELS` of each sphere at each snapshot, 0 below the scale: (n_frames, n_spheres).
    """

    name: str
    label: str
    map: str
    low: float
    high: float
    above: bool
    levels: NDArray[np.float32]

    @property
    def colours(self) -> NDArray[np.float32]:
        """Colour map of k3d: rows of level over `LEVELS`, red, green and blue, grey below the scale."""
        level = np.arange(1, LEVELS + 1) / LEVELS
        scale = colormaps[self.map]((np.arange(LEVELS) + 0.5) / LEVELS)[:, :3]
        edge = 0.5 / LEVELS
        blank = np.array([[0.0, *to_rgb(BLANK)], [edge, *to_rgb(BLANK)], [1.001 * edge, *scale[0]]])
        return np.concatenate([blank, np.column_stack([level, scale])]).astype(np.float32)


def fields(result: Result, instants: Instants, rows: NDArray[np.int64] | slice) -> list[Field]:
    """Return the fields of a run that are not zero throughout.

    Parameters
    ----------
    instants
        Instants that are shown.
    rows
        Rows of the spheres.
    """
    options = result.figure_options
    forces, losses = options.colour_map or FORCE_MAP, options.colour_map or DISSIPATION_MAP
    given = result.energy_input
    scale = force_scale(result)[0]
    in_newtons = None if options.force_limits is None else tuple(scale * end for end in options.force_limits)
    in_joules = tuple(given * end for end in options.dissipation_limits or DISSIPATION_LIMITS) if given else None
    wanted: list[tuple[str, str, str, str, tuple[float, ...] | None]] = [
        ("contact force", "Largest contact force (N)", "contact_force", forces, in_newtons),
        ("speed", "Speed (m/s)", "velocity", forces, None),
        ("peak force", "Largest contact force so far (N)", "peak_force", forces, in_newtons),
        ("dissipated energy", "Dissipated so far (J)", "dissipated_energy", losses, in_joules),
        ("elastic energy", "Elastic energy (J)", "elastic_energy", losses, None),
    ]
    found = []
    for name, label, quantity, colours, limits in wanted:
        if quantity not in instants.quantities:
            continue
        frame_values = (instants.values(number, quantity) for number in range(len(instants.times)))
        values = np.stack([(np.linalg.norm(one, axis=1) if one.ndim == 2 else one)[rows] for one in frame_values])
        largest = float(np.max(values, initial=0.0))
        if not largest > 0:
            continue
        high = decades_up_to(largest, None)[1]
        low, high = limits or (high / 10**_DECADES, high)
        with np.errstate(divide="ignore"):
            share = np.log(values / low) / np.log(high / low)
        levels = np.clip(np.floor(share * LEVELS) + 1, 0, LEVELS) / LEVELS
        found.append(Field(name, label, colours, low, high, largest > high, levels.astype(np.float32)))
    return found
