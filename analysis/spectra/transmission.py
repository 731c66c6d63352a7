"""Steady transmission through a finite packing against frequency.

One grain is moved along an axis by exp(-i omega t); all others follow

    (K + S(omega) - omega^2 M) u = 0

with S of the end: none (reflecting), a matched one, or a layer. Behind a matched end the packing goes on without end:
with the stiffness A of the contacts of a grain of the last layer with those before it, along each principal direction

    S = A (1 - exp(i q)),   cos q = 1 - m omega^2/(2 A),   for long waves the damper  -i omega sqrt(m A)

which is exact for a chain of like beads, and for layers of a lattice that move as wholes. In a layer the grains are
damped, S = -2 i omega w m x^2, x rising from 0 to 1 along it, w the highest frequency of the packing over 20. Where the
ends are, walls do not hold. Grains that the case lets absorb waves are damped as in its runs, and contacts lose what
they do there, -i omega C.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.analysis.spectra.network import Array, Network
from granwave.analysis.spectra.stiffness import Stiffness, factorised, stiffness_of
from granwave.lammps_inputs.errors import InputError

REFLECTING, MATCHED, LAYER = "reflecting", "matched", "layer"
BOTTOM, _Z = "bottom", 2  # wall, and direction of its damper
_END_LAYER = 0.45  # mean diameters: grains so near to the last one are of the last layer
_SHARE_OF_HIGHEST = 0.05  # of the highest frequency of a packing: damping at the end of a layer
_FORM = '"reflecting", "matched" or "layer:N" with the number of grains along the axis'


@dataclasses.dataclass(frozen=True, eq=False)
class Transmission:
    """Steady motion of sensors over that of the drive.

    Attributes
    ----------
    drive, sensors
        Ids.
    axis
        Direction of drive and sensors, of "xyz".
    frequency
        (n_frequencies,), Hz.
    ratio
        Complex ratios of displacements: (n_frequencies, n_sensors); the phase is that of a motion cos(2 pi f t).
    end
        Kind of the far end.
    together
        Ids of the grains that are moved as the drive is.
    """

    drive: int
    sensors: tuple[int, ...]
    axis: str
    frequency: Array
    ratio: NDArray[np.complex128]
    end: str
    together: tuple[int, ...] = ()

    @property
    def amplitude(self) -> Array:
        """Ratios of amplitudes: (n_frequencies, n_sensors)."""
        return np.abs(self.ratio)

    @property
    def phase(self) -> Array:
        """Phases of the sensors behind the drive, -pi to pi: (n_frequencies, n_sensors), rad; negative: later."""
        return np.asarray(-np.angle(self.ratio))


def transmission(
    stiffness: Stiffness,
    drive: int,
    sensors: Sequence[int],
    frequency: Array,
    *,
    axis: str = "z",
    end: str = "",
    dampers: Array | None = None,
    losses: Network | None = None,
    together: Sequence[int] = (),
    bottom: float | None = None,
) -> Transmission:
    """Find the steady response to a prescribed motion of one grain, or of several alike.

    Parameters
    ----------
    drive, sensors
        Ids.
    frequency
        (n_frequencies,), Hz.
    end
        Far end: ``reflecting``, ``matched`` or ``layer:N``.
    dampers
        Force over velocity, moment over angular velocity of each grain: (n_grains, 6), N s/m, N m s; none by default.
    losses
        The network with the damping constants of its contacts for stiffnesses, N s/m; none by default.
    together
        Ids of grains that are moved as the drive is.
    bottom
        Constant of the damper under the bottom, whose plate has no mass, N s/m; None for a bottom that stays.

    Raises
    ------
    InputError
        A grain is not there, or cannot move along the axis.
    """
    end = end or REFLECTING
    kind, n_layer = _parse_end(end)
    network = stiffness.network
    damping: Callable[[float], sparse.csc_array] | None = None
    direction = "xyz".index(axis)
    if kind != REFLECTING:
        last, share = _far(network, drive, direction, n_layer if kind == LAYER else 0.0)
        network = _without_walls(network, last)
        losses = None if losses is None else _without_walls(losses, last)
        stiffness = stiffness_of(network)
        damping = _matched(network, last) if kind == MATCHED else _layer(network, stiffness, last, share)
    freedom = {(int(g), int(d)): n for n, (g, d) in enumerate(zip(*network.freedoms, strict=True))}
    driven = []
    for one in dict.fromkeys((drive, *together)):
        if not _moves(network, one, direction):
            raise InputError(f"--drive: grain {one} is held along {axis}, expected one that moves")
        driven.append(freedom[_row(network, one, "--drive"), direction])
    places = []
    for sensor in sensors:
        row = _row(network, sensor, "--sensor")
        if (row, direction) not in freedom:
            raise InputError(f"--sensor: grain {sensor} is held along {axis}, expected one that moves")
        places.append(freedom[row, direction])
    root = sparse.diags_array(np.sqrt(network.masses))
    matrix = (root @ stiffness.matrix(np.zeros(3)).real @ root).tocsc()
    lossy = None if losses is None else (root @ stiffness_of(losses).matrix(np.zeros(3)).real @ root).tocsc()
    mass = sparse.diags_array(network.masses)
    damped = None if dampers is None else sparse.diags_array(dampers[network.freedoms])
    plate = None if bottom is None else _on_plate(network, losses)
    n_unknowns = network.n_freedoms + (plate is not None)
    others = np.delete(np.arange(n_unknowns), driven)
    ratio = np.zeros((len(frequency), len(places)), dtype=np.complex128)
    for row, one in enumerate(frequency.tolist()):
        omega = 2 * np.pi * one
        whole = matrix - omega**2 * mass
        if damping is not None:
            whole = whole + damping(omega)
        if damped is not None:
            whole = whole - 1j * omega * damped
        if lossy is not None:
            whole = whole - 1j * omega * lossy
        if plate is not None:
            whole = _with_plate(whole, plate, omega, bottom or 0.0)
        whole = whole.astype(np.complex128).tocsc()
        column = np.asarray(whole[:, driven].sum(axis=1)).ravel()
        motion = np.zeros(n_unknowns, dtype=np.complex128)
        motion[driven] = 1.0
        if len(others):
            motion[others] = factorised(whole[others][:, others]).solve(-column[others])
        ratio[row] = motion[places]
    return Transmission(drive, tuple(sensors), axis, frequency, ratio, end, tuple(together))


def _on_plate(network: Network, losses: Network | None) -> tuple[Array, Array] | None:
    """Stiffnesses and damping constants between each freedom and the bottom, N/m and N s/m; None without contacts."""
    supports = network.supports
    rows = np.flatnonzero(supports.wall == BOTTOM)
    freedom = {(int(g), int(d)): n for n, (g, d) in enumerate(zip(*network.freedoms, strict=True))}
    found = np.zeros((2, network.n_freedoms))
    for row in rows.tolist():
        place = freedom.get((int(supports.grain[row]), _Z))
        if place is not None:
            found[0, place] = supports.stiffness[row]
            found[1, place] = 0.0 if losses is None else losses.supports.stiffness[row]
    return (found[0], found[1]) if found[0].any() else None


def _with_plate(whole: sparse.sparray, plate: tuple[Array, Array], omega: float, damping: float) -> sparse.csc_array:
    """Return the matrix with a last unknown, the motion of a plate without mass on a damper along z."""
    coupling = sparse.csc_array((plate[0] - 1j * omega * plate[1])[:, None])
    own = sparse.csc_array([[coupling.sum() - 1j * omega * damping]])
    return sparse.block_array([[whole, -coupling], [-coupling.T, own]], format="csc")


def _without_walls(network: Network, rows: NDArray[np.int64]) -> Network:
    """Take the walls from grains."""
    supports = network.supports
    return dataclasses.replace(network, supports=supports.where(~np.isin(supports.grain, rows)))


def _row(network: Network, grain: int, option: str) -> int:
    rows = np.flatnonzero(network.ids == grain)
    if len(rows):
        return int(rows[0])
    if grain in network.left_out:
        raise InputError(f"{option}: grain {grain} bears no static load, so that no small wave reaches it")
    raise InputError(f"{option}: found {grain}, expected an id from {network.ids.min()} to {network.ids.max()}")


def _moves(network: Network, grain: int, direction: int) -> bool:
    return bool(network.moves[_row(network, grain, "--drive"), direction])


def _parse_end(end: str) -> tuple[str, float]:
    if end in (REFLECTING, MATCHED):
        return end, 0.0
    found = re.fullmatch(rf"{LAYER}:([1-9]\d*)", end)
    if not found:
        raise InputError(f"--end: found {end!r}, expected {_FORM}")
    return LAYER, float(found[1])


def _far(network: Network, drive: int, direction: int, n_layer: float) -> tuple[NDArray[np.int64], Array]:
    """Rows of the grains at the end that is farther from the drive, and their places in the layer from 0 to 1."""
    place = network.position[:, direction]
    here = place[_row(network, drive, "--drive")]
    low, high = float(place.min()), float(place.max())
    away = high - place if high - here >= here - low else place - low
    spacing = float(2 * np.median(network.springs.lever))
    depth = max(n_layer - 0.5, 0.0) * spacing if n_layer else _END_LAYER * spacing
    last = np.flatnonzero(away <= depth)
    if np.isin(_row(network, drive, "--drive"), last):
        raise InputError(f"--end: the end reaches the drive, grain {drive}; give a longer packing or a thinner layer")
    return last, 1 - away[last] / max(depth, 1e-300)


def _matched(network: Network, last: NDArray[np.int64]) -> Callable[[float], sparse.csc_array]:
    """Return S of a matched end, (n_freedoms, n_freedoms), N/m, as a function of omega, rad/s."""
    springs, inside = network.springs, np.zeros(network.n_grains, dtype=bool)
    inside[last] = True
    number = np.full((network.n_grains, 6), -1)
    grain, freedom = network.freedoms
    number[grain, freedom] = np.arange(network.n_freedoms)
    stiffness = np.zeros((network.n_grains, 3, 3))
    for one, other in ((springs.first, springs.second), (springs.second, springs.first)):
        across = np.flatnonzero(inside[one] & ~inside[other])
        normal = springs.normal[across]
        parallel = normal[:, :, None] * normal[:, None, :]
        block = springs.stiffness[across, None, None] * parallel
        block += springs.tangential[across, None, None] * (np.eye(3) - parallel)
        block -= (springs.force[across] / springs.distance[across])[:, None, None] * springs.turning[across]
        np.add.at(stiffness, one[across], block)
    free = [np.flatnonzero(network.moves[row, :3]) for row in last.tolist()]
    principal = [np.linalg.eigh(stiffness[row][np.ix_(own, own)]) for row, own in zip(last, free, strict=True)]
    places = [number[row, own] for row, own in zip(last.tolist(), free, strict=True)]
    rows = np.concatenate([np.repeat(at, len(at)) for at in places])
    columns = np.concatenate([np.tile(at, len(at)) for at in places])

    def at(omega: float) -> sparse.csc_array:
        values = []
        for row, (strength, axes) in zip(last.tolist(), principal, strict=True):
            stiff = np.maximum(strength, 1e-300)
            cosine = (1 - network.mass[row] * omega**2 / (2 * stiff)).astype(np.complex128)
            inner = np.where(np.abs(cosine) <= 1, 1j * np.sqrt(1 - cosine**2), np.sqrt(cosine**2 - 1))
            impedance = np.where(strength > 0, stiff * (1 - cosine - inner), 0.0)
            values.append(((axes * impedance) @ axes.T).ravel())
        n = network.n_freedoms
        return sparse.coo_array((np.concatenate(values), (rows, columns)), shape=(n, n)).tocsc()

    return at


def _layer(
    network: Network, stiffness: Stiffness, last: NDArray[np.int64], share: Array
) -> Callable[[float], sparse.csc_array]:
    """Return S of a layer, (n_freedoms, n_freedoms), N/m or N m, as a function of omega, rad/s."""
    highest = np.sqrt(float(np.abs(stiffness.matrix(np.zeros(3))).sum(axis=1).max()))
    rate = np.zeros(network.n_grains)
    rate[last] = 2 * _SHARE_OF_HIGHEST * highest * share**2
    grain, _ = network.freedoms
    dampers = sparse.diags_array(rate[grain] * network.masses).tocsc()
    return lambda omega: -1j * omega * dampers
