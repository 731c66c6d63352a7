"""Selection of rows of the tables of a run, for exports and for ``run.select``.

Tables of grains and contacts are selected by grains, layers, depth and region, histories by time,
snapshots and the history of a chain by all of them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.contact_geometry import contact_geometry
from granwave.analysis.measures.geometry import layers as layers_of
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.region_walls import RegionShape, read_shape
from granwave.lammps_inputs.case.schema import ValidationError
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.region_faces import contains

CHAIN = "chain"
SNAPSHOTS = "snapshots"
WALLS = "walls"
#: Tables whose rows, or columns of the history of a chain, are selected by place.
OF_PLACE = ("spheres", "contacts", "wall_contacts", CHAIN, SNAPSHOTS)
#: Tables whose rows are selected by time.
OF_TIME = ("energy", "probes", WALLS, CHAIN, SNAPSHOTS)
_ROUNDING = 1e-9  # of bounds, relative to the larger one

Rows = NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class Selection:
    """Rows of tables of a run; make it with `selection`.

    Attributes
    ----------
    spheres
        Ids of grains; empty: all.
    layers
        Numbers of layers, from 1 at the top; empty: all.
    depth
        Smallest and largest depth below the centre of the impacted sphere, m.
    region
        Arguments of the LAMMPS region command, as ``region`` of ``[[wall]]``; empty: everywhere.
    time
        First and last time, s.
    """

    spheres: tuple[int, ...] = ()
    layers: tuple[int, ...] = ()
    depth: tuple[float, float] | None = None
    region: str = ""
    time: tuple[float, float] | None = None

    @property
    def is_of_place(self) -> bool:
        """True if grains are selected."""
        return bool(self.spheres or self.layers or self.depth or self.region)

    @property
    def is_empty(self) -> bool:
        """True if everything is selected."""
        return not self.is_of_place and self.time is None

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables from which it selects rows."""
        of_place = OF_PLACE if self.is_of_place else ()
        of_time = OF_TIME if self.time else ()
        return tuple(dict.fromkeys((*of_place, *of_time)))

    def refuse_tables_without(self, tables: Sequence[str]) -> None:
        """Raise InputError if none of these tables is among them."""
        if self.is_empty or set(tables) & set(self.tables):
            return
        raise InputError(
            f"{self.words}: does not apply to {', '.join(tables)}, only to {', '.join(self.tables)}"
        )

    @property
    def shape(self) -> RegionShape | None:
        """Shape of the region."""
        return read_shape(self.region) if self.region else None

    @property
    def words(self) -> str:
        """Names of the criteria of selection, for messages."""
        fields = dataclasses.fields(self)
        return ", ".join(field.name for field in fields if getattr(self, field.name))


ALL = Selection()


def selection(
    spheres: int | Iterable[int] | None = None,
    layers: int | Iterable[int] | None = None,
    depth: Sequence[float] | None = None,
    region: str | None = None,
    time: Sequence[float] | None = None,
) -> Selection:
    """Return a selection.

    Parameters
    ----------
    spheres, layers, depth, region, time
        As in `Selection`; None: all.

    Raises
    ------
    InputError
        A value is invalid.
    """
    if region is not None:
        try:
            read_shape(region if isinstance(region, str) else "")
        except ValidationError as error:
            raise InputError(f"region: found {region}, expected {error}") from None
    return Selection(
        _numbers("spheres", spheres),
        _numbers("layers", layers),
        _range("depth", depth, "m"),
        region or "",
        _range("time", time, "s"),
    )


def _numbers(name: str, values: Any) -> tuple[int, ...]:
    """Return whole numbers from 1 up."""
    if values is None:
        return ()
    try:
        numbers = np.atleast_1d(values if isinstance(values, int) else list(values))
        whole = numbers.astype(np.int64)
        is_right = bool(len(whole)) and bool(np.all(whole == numbers)) and bool(whole.min() >= 1)
    except (TypeError, ValueError):
        is_right = False
    if not is_right:
        raise InputError(f"{name}: found {values}, expected whole numbers from 1 up")
    return tuple(whole.tolist())


def _range(name: str, values: Any, unit: str) -> tuple[float, float] | None:
    """Return the lower and the upper bound."""
    if values is None:
        return None
    expected = f"{name}: found {values}, expected the lower and the upper bound ({unit})"
    try:
        bounds = [float(value) for value in values]
    except (TypeError, ValueError):
        raise InputError(expected) from None
    if len(bounds) != 2 or any(math.isnan(bound) for bound in bounds) or bounds[0] > bounds[1]:
        raise InputError(expected)
    return bounds[0], bounds[1]


def between(values: NDArray[np.float64], bounds: tuple[float, float]) -> Rows:
    """Return True for values between two bounds, which are included."""
    low, high = bounds
    finite = [abs(bound) for bound in bounds if math.isfinite(bound)]
    margin = _ROUNDING * max(finite, default=0.0)
    inside: Rows = (values >= low - margin) & (values <= high + margin)
    return inside


def _short(value: float) -> str:
    """Return a number with up to four digits."""
    return f"{value:.4g}"


class SelectedRows:
    """Rows of the tables of a result that a selection selects.

    Parameters
    ----------
    result
        Result of a run.
    selected
        Selection.

    Raises
    ------
    InputError
        The run has no such spheres or layers.
    """

    def __init__(self, result: Result, selected: Selection = ALL) -> None:
        self._result = result
        self._selected = selected
        self._check_spheres()
        self._check_layers()
        self._check_place()
        self._check_time()

    def _check_spheres(self) -> None:
        unknown = set(self._selected.spheres) - set(self._result["spheres/id"].tolist())
        if unknown:
            raise InputError(
                f"spheres: found {min(unknown)}, expected ids of {self._result.path.parent}, "
                f"which has {self._result.n_spheres} spheres"
            )

    def _check_layers(self) -> None:
        if not self._selected.layers:
            return
        last = int(self._layers.max(initial=0))
        if max(self._selected.layers) > last:
            raise InputError(
                f"layers: found {max(self._selected.layers)}, expected numbers from 1 to {last}"
            )

    def _check_place(self) -> None:
        if not self._selected.is_of_place or self.spheres.any() or self.contacts.any():
            return
        depth = self._result["spheres/position"][:, 2] - self._result.origin[2]
        raise InputError(
            f"{self._selected.words}: no sphere and no contact is there; depths of the spheres "
            f"are {_short(depth.min())} to {_short(depth.max())} m"
        )

    def _check_time(self) -> None:
        if self._selected.time is None or np.any(self.of_time("energy/time")):
            return
        last = self._result["energy/time"][-1]
        raise InputError(
            f"time: found {_short(self._selected.time[0])} to "
            f"{_short(self._selected.time[1])} s, expected times between 0 and "
            f"{_short(last)} s"
        )

    @cached_property
    def _layers(self) -> NDArray[np.int64]:
        """Number of the layer of each sphere, from 1; 0 of strikers."""
        result = self._result
        inside = result.in_packing
        depth = result["spheres/position"][:, 2] - result.origin[2]
        radius = result["spheres/radius"]
        diameter = result.case.packing.diameter
        numbers = np.zeros(len(depth), dtype=np.int64)
        numbers[inside] = 1 + layers_of(depth[inside], radius[inside], diameter)[1]
        return numbers

    @cached_property
    def _grains(self) -> Rows:
        """True for spheres with the ids and layers of the selection."""
        ids = self._result["spheres/id"]
        rows = np.ones(len(ids), dtype=bool)
        if self._selected.spheres:
            rows &= np.isin(ids, self._selected.spheres)
        if self._selected.layers:
            rows &= np.isin(self._layers, self._selected.layers)
        return rows

    def _at(self, points: NDArray[np.float64]) -> Rows:
        """Return True for points (n, 3), m, within depth and region."""
        rows = np.ones(len(points), dtype=bool)
        if self._selected.depth:
            rows &= between(points[:, 2] - self._result.origin[2], self._selected.depth)
        if self._selected.shape:
            rows &= contains(self._selected.shape, points)
        return rows

    @cached_property
    def spheres(self) -> Rows:
        """True for selected spheres: (n_spheres,)."""
        rows: Rows = self._grains & self._at(self._result["spheres/position"])
        return rows

    @cached_property
    def contacts(self) -> Rows:
        """True for contacts at a selected position with a selected sphere: (n_contacts,)."""
        geometry = contact_geometry(self._result)
        points = np.stack([geometry[axis] for axis in "xyz"], axis=1)
        rows: Rows = self._grains[self._result.ends].any(axis=1) & self._at(points)
        return rows

    @cached_property
    def frames(self) -> list[int]:
        """Numbers of the selected snapshots."""
        times = self._result.frame_times
        if self._selected.time is None:
            return list(range(len(times)))
        return np.flatnonzero(between(times, self._selected.time)).tolist()

    @cached_property
    def beads(self) -> Rows:
        """True for selected beads of the history of a chain: (n_beads,)."""
        return self.spheres[self._result.rows(self._result["chain/id"])]

    @cached_property
    def chain_contacts(self) -> Rows:
        """True for contacts of the history of a chain that belong to a selected bead."""
        ids = self._result["spheres/id"][self.spheres]
        ends = [self._result[f"chain/contact_{end}"] for end in "ij"]
        rows: Rows = np.isin(ends[0], ids) | np.isin(ends[1], ids)
        return rows

    def of_time(self, name: str) -> Rows | None:
        """Return True for selected instants of a data set of times; None: all."""
        if self._selected.time is None:
            return None
        return between(self._result[name], self._selected.time)

    def of_table(self, group: str) -> Rows | None:
        """Return True for the selected rows of a table of result.h5, such as ``contacts`` or
        ``walls/bottom``; None: all.
        """
        if group not in self._result:
            return None
        if group.partition("/")[0] in OF_TIME:
            return self.of_time(f"{group}/time")
        if group not in OF_PLACE or not self._selected.is_of_place:
            return None
        if group == "contacts":
            return self.contacts
        if group == "wall_contacts":
            return self.spheres[self._result.rows(self._result["wall_contacts/id"])]
        return self.spheres
