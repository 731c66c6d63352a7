"""Curves of a run that a comparison draws on shared axes, in SI units.

A function of a run returns a curve, or raises `LackingError` with the reason why there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import h5py
import numpy as np
from numpy.typing import NDArray

from granwave.analysis.measures.force_decay import ForceDecay, PowerDecay, both_decays
from granwave.analysis.measures.geometry import layers
from granwave.analysis.measures.impact import zone_growth
from granwave.analysis.measures.layer_peaks import layer_peaks
from granwave.analysis.measures.signals import Array
from granwave.analysis.measures.target_record import Reached, reached
from granwave.analysis.measures.waves import front_arrivals, stays_in_layer
from granwave.analysis.reports.comparison.subjects import ComparedRun, LackingError
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.files import regular
from granwave.lammps_inputs.run_directory import RESULT_FILE

FORMS = ("kinetic", "elastic", "dissipated")  # forms of energy, in the order of their panels
_LEAST_LAYERS = 2  # fewest layers of a curve
_LEAST_YIELDED = 3  # fewest yielded spheres of a zone that grows
_NO_FORCE = "the force on its bottom is not recorded"
_NO_BOTTOM = "it has no bottom"
_BOTTOM = "boundary.bottom"
_FREE = "free"
_STATIC_LOAD = "precompression"  # beginning of the keys of a static load


@dataclass(frozen=True, eq=False)
class SampledCurve:
    """Values at positions or times, rising: (n,) each, SI units."""

    x: Array
    y: Array


@dataclass(frozen=True, eq=False)
class PeaksByDepth:
    """Peak forces of the spheres of each layer that the load reached, above their static forces.

    Attributes
    ----------
    depth
        Of the layers below the impacted sphere, m: (n_layers,).
    largest, median
        Of the peak forces of their spheres, N: (n_layers,).
    decays
        Fits of the largest by an exponential and by a power of the depth; None without fits.
    no_decay
        Reason why there are no fits; empty if there are.
    n_unknown
        Number of layers that are left out since a larger pulse may still reach them.
    n_hidden
        Number of layers that are left out since their force rose until the reflection from the end
        of a chain came.
    of_first_wave
        True for the forces of the first wave, False for the largest of the run.
    is_chain
        True for beads of a chain, False for layers.
    later
        Depths of the layers of a packing whose largest force occurred when the reflection from the
        base may have arrived, m.
    after_gap
        True for layers that follow a layer that is left out, (n_layers,); None without such layers.
    """

    depth: Array
    largest: Array
    median: Array
    decays: tuple[ForceDecay, PowerDecay] | None
    no_decay: str = ""
    n_unknown: int = 0
    n_hidden: int = 0
    of_first_wave: bool = False
    is_chain: bool = False
    later: Array = field(default_factory=lambda: np.empty(0))
    after_gap: NDArray[np.bool_] | None = None

    @property
    def is_later(self) -> NDArray[np.bool_]:
        """True for layers in `later`: (n_layers,)."""
        return np.isin(self.depth, self.later)

    def with_gaps(self, values: Array) -> Array:
        """Return values of the layers with NaN where layers are left out, so that no line joins the
        layers on both sides.
        """
        if self.after_gap is None:
            return values
        return np.insert(values, np.flatnonzero(self.after_gap), np.nan)


@dataclass(frozen=True, eq=False)
class GrowthCurves:
    """Plastic zone in time.

    Attributes
    ----------
    time
        s: (n,).
    spheres, depth
        Number of yielded spheres, and depth of the deepest, m: (n,).
    """

    time: Array
    spheres: Array
    depth: Array


def force_at_bottom(run: ComparedRun) -> SampledCurve:
    """Return the force on the bottom against time: s, N."""
    if not run.has_spheres:
        raise LackingError(_NO_FORCE)
    with run.opened() as result:
        record = reached(result)
        if record is None:
            is_free = run.run.case.get(_BOTTOM) == _FREE
            raise LackingError(_NO_BOTTOM if is_free else _NO_FORCE)
        return SampledCurve(record.time, record.force)


def drawn_force_at_bottom(run: ComparedRun) -> SampledCurve:
    """Return the force on the bottom against time, s, N, of a run whose wave reaches the bottom."""
    curve = force_at_bottom(run)
    record = bottom_record(run)
    if record is not None and not record.is_reached:
        raise LackingError("the wave does not reach its bottom before its end")
    return curve


def bottom_record(run: ComparedRun) -> Reached | None:
    """Return the record of the force on the bottom of a run; None without one."""
    try:
        with run.opened() as result:
            return reached(result)
    except LackingError:
        return None


def can_reach_bottom(run: ComparedRun) -> bool:
    """Return False for a run of one layer whose load acts in its plane; True if it is unknown."""
    try:
        with run.opened() as result:
            return not stays_in_layer(result)
    except LackingError:
        return True


def has_peak_at_bottom(run: ComparedRun) -> bool:
    """Return False if the wave does not reach the bottom, the force there is largest at the end of
    a run, or a later pulse may be larger; True without a record.
    """
    record = bottom_record(run)
    return record is None or record.has_known_peak


def has_own_peak(run: ComparedRun) -> bool:
    """Return True if the record of a run shows by itself that it includes the largest force on the
    bottom: the force has passed its peak, and most of the momentum of the impact has arrived.

    False where other bodies take up momentum, so that it does not show whether pulses are missing.
    """
    record = bottom_record(run)
    return record is not None and record.arrived_momentum is not None and record.has_known_peak


def has_static_load(run: ComparedRun) -> bool:
    """Return True if the case of a run has a static load."""
    return any(key.startswith(_STATIC_LOAD) for key in run.run.case)


def static_force_at_bottom(run: ComparedRun) -> float:
    """Return the force on the bottom before the impact, N; 0 without a static load."""
    if not has_static_load(run):
        return 0.0
    try:
        force = force_at_bottom(run).y
    except LackingError:
        return 0.0
    return float(force[0]) if len(force) else 0.0


def energy_shares(run: ComparedRun) -> dict[str, SampledCurve]:
    """Return the forms of energy divided by the final input, against time: s, 1."""
    try:
        with h5py.File(regular(run.run.directory / RESULT_FILE), "r") as file:
            time = _dataset(file, "energy/time")
            given = _dataset(file, "energy/input")
            columns = {form: _form(file, run.run.kind.ledger[form]) for form in FORMS}
    except (OSError, KeyError, ValueError, TypeError):
        raise LackingError(f"{RESULT_FILE} has no energies") from None
    is_whole = all(np.shape(values) == time.shape == given.shape for values in columns.values())
    if not is_whole or not len(time) or not given[-1] > 0:
        raise LackingError("the energy input is zero, or its record is damaged")
    return {form: SampledCurve(time, values / given[-1]) for form, values in columns.items()}


def numerical_shares(run: ComparedRun) -> dict[str, float]:
    """Return the energies of the numerical method at the end, divided by the input, by name; empty
    for a run without such energies.
    """
    shares: dict[str, float] = {}
    try:
        with h5py.File(regular(run.run.directory / RESULT_FILE), "r") as file:
            given = float(_dataset(file, "energy/input")[-1])
            for name, words in run.run.kind.numerical.items():
                if f"energy/{name}" in file:
                    shares[words] = float(_dataset(file, f"energy/{name}")[-1]) / given
    except (OSError, KeyError, ValueError, TypeError, IndexError):
        raise LackingError(f"{RESULT_FILE} has no energies") from None
    return shares


def _form(file: h5py.File, names: Sequence[str]) -> Array:
    """Return the sum of the data sets of a form of energy; every run has at least the first of
    them.
    """
    first, *others = names
    present = [name for name in others if f"energy/{name}" in file]
    total = _dataset(file, f"energy/{first}")
    for name in present:
        total = total + _dataset(file, f"energy/{name}")
    return total


def _dataset(file: h5py.File, name: str) -> Array:
    return np.asarray(file[name][()], dtype=np.float64)


def peaks_by_depth(run: ComparedRun) -> PeaksByDepth:
    """Return the peak forces of the layers of a run."""
    with run.opened() as result:
        peaks = layer_peaks(result)
        fits = both_decays(result, peaks)
        n_loaded = int(np.count_nonzero(result["contacts/peak_force"] > 0))
        is_chain = "chain" in result
    largest = peaks.largest
    if n_loaded == 1:
        raise LackingError("a single contact carries a force, the same for both spheres")
    if len(largest) < _LEAST_LAYERS or not largest.any():
        raise LackingError("no force reaches two layers")
    shown = peaks.is_known | peaks.is_later
    if np.count_nonzero(shown) < _LEAST_LAYERS:
        raise LackingError("the peak force of fewer than two layers is known at the end of the run")
    decays = None if isinstance(fits, str) else fits
    no_decay = fits if isinstance(fits, str) else ""
    return PeaksByDepth(
        depth=peaks.depth[shown],
        largest=largest[shown],
        median=peaks.median[shown],
        decays=decays,
        no_decay=no_decay,
        n_unknown=peaks.n_left_out - peaks.n_hidden,
        n_hidden=peaks.n_hidden,
        of_first_wave=peaks.of_first_wave,
        is_chain=is_chain,
        later=peaks.depth[peaks.is_later],
        after_gap=_after_gap(shown),
    )


def _after_gap(shown: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return True for shown layers that follow a layer that is not shown: (n_shown,)."""
    places = np.flatnonzero(shown)
    return np.diff(places, prepend=places[:1] - 1) > 1


def dissipation_by_depth(run: ComparedRun) -> SampledCurve:
    """Return the energy that the spheres of each layer dissipated, divided by the input: m, 1."""
    with run.opened() as result:
        mean, layer = _layers_below(result)
        lost = np.bincount(layer, result["spheres/dissipated_energy"], minlength=len(mean))
        given = result.energy_input
    if not given > 0 or not np.any(lost > 0):
        raise LackingError("it dissipated no energy")
    return SampledCurve(mean, lost / given)


def dissipation_at_walls(run: ComparedRun) -> SampledCurve:
    """Return the fraction of the dissipation of each layer that occurred at walls: m, 1."""
    with run.opened() as result:
        mean, layer = _layers_below(result)
        lost = np.bincount(layer, result["spheres/dissipated_energy"], minlength=len(mean))
        at_walls = np.zeros(len(mean))
        if "wall_contacts" in result:
            of_contact = layer[result.rows(result["wall_contacts/id"])]
            np.add.at(at_walls, of_contact, result["wall_contacts/dissipated_energy"])
    return SampledCurve(mean, np.divide(at_walls, lost, out=np.zeros(len(mean)), where=lost > 0))


def growth(run: ComparedRun) -> GrowthCurves:
    """Return the growth of the plastic zone, from zero to the end of the run."""
    with run.opened() as result:
        if not result["contacts/yielded"].any():
            raise LackingError("no contact of two spheres yielded")
        zone = zone_growth(result)
        if int(zone.spheres[-1]) < _LEAST_YIELDED:
            raise LackingError("fewer than three spheres yielded")
        end = float(result["energy/time"][-1])
    time = np.concatenate([[0.0], zone.time, [end]])
    spheres = np.concatenate([[0], zone.spheres, zone.spheres[-1:]]).astype(np.float64)
    depth = np.concatenate([[0.0], zone.depth, zone.depth[-1:]])
    return GrowthCurves(time, spheres, depth)


def front(run: ComparedRun) -> SampledCurve:
    """Return the times at which the front of the wave reached each layer, or bead of a
    chain: m, s.

    Layers with loaded or moving spheres are left out: the wave starts there, and their first
    contact is also the first one of the next layer.
    """
    with run.opened() as result:
        if result.case.precompression is not None:
            raise LackingError("its contacts are loaded from the start")
        depth, arrival = front_arrivals(result)
        rows = result.rows(np.array(result.struck))
        start = result["spheres/position"][rows, 2] - result.origin[2]
    is_start = np.zeros(len(depth), dtype=bool)
    is_start[np.abs(depth[:, None] - start).argmin(axis=0)] = True
    is_reached = np.isfinite(arrival) & ~is_start
    if np.count_nonzero(is_reached) < 2:
        raise LackingError("the wave reached fewer than two layers")
    return SampledCurve(depth[is_reached], arrival[is_reached])


def _layers_below(result: Result) -> tuple[Array, NDArray[np.int64]]:
    """Return the depth of each layer of the packing, m, and the layer of each of its spheres."""
    depth = result["spheres/position"][:, 2] - result.origin[2]
    return layers(depth, result["spheres/radius"], result.case.packing.diameter)
