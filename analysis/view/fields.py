"""Fields that the page of a run shows: values of the spheres at every instant, as levels of a logarithmic scale.

Instants are the snapshots of a run, or those at which a whole chain was recorded, which are more. A page holds millions
of values. They are stored as the levels of a scale of `LEVELS` colours, with 0 for values below it: numbers that
repeat, which compress to a twentieth.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
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


class Instants(ABC):
    """Values of the spheres at rising times.

    Attributes
    ----------
    times
        Times, s: (n_instants,).
    quantities
        Names that `values` knows, as of a snapshot.
    """

    times: NDArray[np.float64]
    quantities: tuple[str, ...]

    @abstractmethod
    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Return a quantity of all spheres at an instant: (n_spheres,) or (n_spheres, 3), SI units."""


def instants_of(result: Result) -> Instants:
    """Return the instants of a run."""
    if "chain" in result and len(result["chain/time"]) > result.n_frames:
        return _History(result)
    return _Snapshots(result)


class _Snapshots(Instants):
    def __init__(self, result: Result) -> None:
        self.times, self.quantities, self._result = result.frame_times, result.quantities, result

    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Read a snapshot, with 0 for what was not recorded."""
        return np.nan_to_num(self._result.frame(number, quantity))


class _History(Instants):
    """Record of a chain: velocity and displacement along it, and the largest force of each bead's contacts."""

    quantities = ("velocity", "displacement", "contact_force", "peak_force")

    def __init__(self, result: Result) -> None:
        time = result["chain/time"]
        self._rows = np.unique(np.linspace(0, len(time) - 1, min(_MOST_OF_A_CHAIN, len(time))).round().astype(int))
        self.times, self._n = time[self._rows], result.n_spheres
        self._beads = result.rows(result["chain/id"])
        force = result["chain/contact_force"]
        self._force = np.zeros((len(time), self._n))
        row = dict(zip(result["chain/id"].tolist(), self._beads.tolist(), strict=True))
        for end in ("chain/contact_i", "chain/contact_j"):
            for contact, sphere in enumerate(result[end].tolist()):
                if sphere in row:  # else the face of a bar
                    bead = self._force[:, row[sphere]]
                    np.maximum(bead, force[:, contact], out=bead)
        self._peak = np.maximum.accumulate(self._force, axis=0)
        self._along = {name: result[f"chain/{name}"] for name in ("velocity", "displacement")}

    def values(self, number: int, quantity: str) -> NDArray[np.float64]:
        """Return what was recorded; vectors point along the chain."""
        row = self._rows[number]
        if quantity == "contact_force":
            return self._force[row]
        if quantity == "peak_force":
            return self._peak[row]
        found = np.zeros((self._n, 3))
        found[self._beads, 2] = self._along[quantity][row]
        return found


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


def fields(result: Result, instants: Instants, frames: Sequence[int], rows: NDArray[np.int64] | slice) -> list[Field]:
    """Return the fields of a run that are not zero throughout.

    Parameters
    ----------
    instants
        Instants of the run.
    frames
        Numbers of those that are shown.
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
    found = (_field(instants, frames, rows, *one) for one in wanted if one[2] in instants.quantities)
    return [field for field in found if field is not None]


def _field(
    instants: Instants,
    frames: Sequence[int],
    rows: NDArray[np.int64] | slice,
    name: str,
    label: str,
    quantity: str,
    colours: str,
    limits: tuple[float, ...] | None,
) -> Field | None:
    found = (instants.values(number, quantity) for number in frames)
    values = np.stack([(np.linalg.norm(one, axis=1) if one.ndim == 2 else one)[rows] for one in found])
    largest = float(np.max(values, initial=0.0))
    if not largest > 0:
        return None
    high = decades_up_to(largest, None)[1]
    low, high = limits or (high / 10**_DECADES, high)
    with np.errstate(divide="ignore"):
        share = np.log(values / low) / np.log(high / low)
    levels = np.clip(np.floor(share * LEVELS) + 1, 0, LEVELS) / LEVELS
    return Field(name, label, colours, low, high, largest > high, levels.astype(np.float32))
