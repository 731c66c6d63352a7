"""Steady transmission through a finite packing against frequency.

One grain is moved along an axis by exp(-i omega t); all others follow

    (K + S(omega) - omega^2 M) u = 0

where S describes the end: none (reflecting), a matched end, or a layer. A matched end acts like an
infinite continuation of the packing. With the stiffness A of the contacts between a grain of the
last layer and the grains before it, and the stiffness B of its contacts with side walls, along each
principal direction

    S = A (1 - exp(i q)),   cos q = 1 - (m omega^2 - B)/(2 A)

This is exact for a chain of identical beads, and for lattice layers that move as a whole. In a
layer the grains are damped, S = -2 i omega w m x^2, where x rises from 0 to 1 along the layer and w
is the highest frequency of the packing divided by 20. Walls across the axis do not hold the grains
of the end; side walls do. Absorbing grains of the case and lossy contacts are damped as in its
runs, by -i omega C.

A contact with the slope k = dF/d(overlap) resists the rate of its overlap by c = A k with the loss
time A (``contact.loss``), or by c = alpha sqrt(2/3 m* k) with the factor alpha of a dashpot and the
effective mass m*, as in the runs: grains that are held or driven along the normal do not move. The
matrix of these dampers is the stiffness matrix of a network with c instead of k, without static
force and friction.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from granwave.extensions.waves.spectra.network import Network, Springs
from granwave.extensions.waves.spectra.stiffness import Stiffness, factorised, stiffness_of
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.contact.tables import Resistance
from granwave.lammps_inputs.case.material import Material, Shape
from granwave.lammps_inputs.contact.law import ContactLoss, viscous_loss
from granwave.lammps_inputs.contact.static_load import absorbing_ids, impedance_of, rise_of
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.packing.walls import walls
from granwave.lammps_inputs.statics.bodies import Array, joined

REFLECTING = "reflecting"
MATCHED = "matched"
LAYER = "layer"
BOTTOM = "bottom"  # wall above a damper
_Z = 2  # direction of the damper
_RESISTANCES = ("rolling", "twisting")
_FACING = 0.5  # part of a wall's normal along an axis above which the wall is across the axis
_END_LAYER = (
    0.45  # distance from the last grain within which grains are in the last layer, mean diameters
)
_SHARE_OF_HIGHEST = 0.05  # damping rate at the end of a layer divided by the highest frequency
_HELD = 1e-12  # inverse mass relative to free grains below which it is rounding of the normal
_FORM = '"reflecting", "matched" or "layer:N" with the number of grains along the axis'


@dataclasses.dataclass(frozen=True, eq=False)
class Transmission:
    """Steady motion of sensors relative to the drive.

    Attributes
    ----------
    drive, sensors
        Ids.
    axis
        Direction of drive and sensors: x, y or z.
    frequency
        (n_frequencies,), Hz.
    ratio
        Complex ratios of displacements: (n_frequencies, n_sensors). Phases are relative to the
        motion cos(2 pi f t) of the drive.
    end
        Kind of the far end.
    together
        Ids of the grains that move with the drive.
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
        """Phases of the sensors, -pi to pi, negative if they lag behind the drive: (n_frequencies,
        n_sensors), rad.
        """
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
    """Find the steady response to the prescribed motion of a grain, or of several grains together.

    Parameters
    ----------
    drive, sensors
        Ids.
    frequency
        (n_frequencies,), Hz.
    end
        Far end: ``reflecting``, ``matched`` or ``layer:N``.
    dampers
        Force / velocity and moment / angular velocity of each grain: (n_grains, 6), N s/m and
        N m s; none by default.
    losses
        Network with damping constants instead of stiffnesses, N s/m; none by default.
    together
        Ids of grains that move with the drive.
    bottom
        Constant of the damper under the bottom, a plate without mass, N s/m; None for a bottom at
        rest.

    Raises
    ------
    InputError
        A grain does not exist, or cannot move along the axis.
    """
    end = end or REFLECTING
    layer = re.fullmatch(rf"{LAYER}:([1-9]\d*)", end)
    if end not in (REFLECTING, MATCHED) and not layer:
        raise InputError(f"--end: found {end!r}, expected {_FORM}")
    network = stiffness.network
    direction = "xyz".index(axis)
    resisting = np.zeros((network.n_grains, 6)) if dampers is None else dampers
    matched: Callable[[float], sparse.csc_array] | None = None
    if end != REFLECTING:
        last, share = _far(network, drive, direction, float(layer[1]) if layer else 0.0)
        network = _without_ends(network, last, direction)
        losses = None if losses is None else _without_ends(losses, last, direction)
        stiffness = stiffness_of(network)
        if layer:
            rate = np.zeros(network.n_grains)
            rate[last] = 2 * _SHARE_OF_HIGHEST * math.sqrt(stiffness.largest) * share**2
            masses = np.stack([network.mass, network.inertia], axis=1)
            resisting = resisting + np.repeat(rate[:, None] * masses, 3, axis=1)
        else:
            matched = _matched(network, last)

    driven = [
        _unknown_of(network, grain, axis, "--drive") for grain in dict.fromkeys((drive, *together))
    ]
    measured = [_unknown_of(network, sensor, axis, "--sensor") for sensor in sensors]
    damping = sparse.diags_array(resisting[network.freedoms]).tocsc()
    if losses is not None:
        damping = damping + stiffness_of(losses).total
    mass = sparse.diags_array(network.masses)
    plate = _Plate.of(network, losses, bottom)
    ratio = np.zeros((len(frequency), len(measured)), dtype=np.complex128)
    for row, frequency_Hz in enumerate(frequency.tolist()):
        omega = 2 * np.pi * frequency_Hz
        matrix = stiffness.total - omega**2 * mass - 1j * omega * damping
        if matched is not None:
            matrix = matrix + matched(omega)
        if plate is not None:
            matrix = plate.coupled(matrix, omega)
        ratio[row] = _response(matrix.astype(np.complex128).tocsc(), driven)[measured]
    return Transmission(drive, tuple(sensors), axis, frequency, ratio, end, tuple(together))


def _unknown_of(network: Network, grain: int, axis: str, option: str) -> int:
    """Return the number of the displacement of a grain along an axis."""
    unknown = int(network.numbers[_row(network, grain, option), "xyz".index(axis)])
    if unknown < 0:
        raise InputError(f"{option}: grain {grain} is fixed along {axis}, expected a movable grain")
    return unknown


@dataclasses.dataclass(frozen=True)
class _Plate:
    """Plate without mass on a damper, below the grains that touch the bottom.

    Attributes
    ----------
    stiffness, damping
        Stiffness and damping constant between each unknown and the plate: (n_freedoms,), N/m and
        N s/m.
    damper
        Constant of the damper, N s/m.
    """

    stiffness: Array
    damping: Array
    damper: float

    @classmethod
    def of(cls, network: Network, losses: Network | None, damper: float | None) -> _Plate | None:
        """Return the plate below a network; None for a bottom at rest, or without contacts."""
        stiffness = np.zeros(network.n_freedoms)
        damping = np.zeros(network.n_freedoms)
        unknown = network.numbers[network.supports.first, _Z]
        rows = np.flatnonzero((network.supports.wall == BOTTOM) & (unknown >= 0))
        stiffness[unknown[rows]] = network.supports.stiffness[rows]
        if losses is not None:
            damping[unknown[rows]] = losses.supports.stiffness[rows]
        if damper is None or not stiffness.any():
            return None
        return cls(stiffness, damping, damper)

    def coupled(self, matrix: sparse.csc_array, omega: float) -> sparse.csc_array:
        """Return the matrix of the grains and of the motion of the plate along z, which is the last
        unknown.
        """
        coupling = sparse.csc_array((self.stiffness - 1j * omega * self.damping)[:, None])
        own = sparse.csc_array([[coupling.sum() - 1j * omega * self.damper]])
        return sparse.block_array([[matrix, -coupling], [-coupling.T, own]])


def _response(matrix: sparse.csc_array, driven: Sequence[int]) -> NDArray[np.complex128]:
    """Return all unknowns if the driven unknowns are 1 and no force acts on the others."""
    motion = np.zeros(matrix.shape[0], dtype=np.complex128)
    motion[driven] = 1.0
    others = np.delete(np.arange(len(motion)), driven)
    if len(others):
        force = -np.asarray(matrix[:, driven].sum(axis=1)).ravel()
        motion[others] = factorised(matrix[others][:, others], pivots=True).solve(force[others])
    return motion


def _without_ends(network: Network, rows: NDArray[np.int64], direction: int) -> Network:
    """Remove the walls across a direction from grains; keep the walls along it."""
    contacts = network.contacts
    ends = (contacts.second < 0) & (np.abs(contacts.normal[:, direction]) > _FACING)
    kept = ~(ends & np.isin(contacts.first, rows))
    return dataclasses.replace(network, contacts=joined([contacts], kept))


def _row(network: Network, grain: int, option: str) -> int:
    rows = np.flatnonzero(network.ids == grain)
    if len(rows):
        return int(rows[0])
    if grain in network.left_out:
        raise InputError(
            f"{option}: grain {grain} carries no static load, so small waves do not reach it"
        )
    raise InputError(
        f"{option}: found {grain}, expected an id from {network.ids.min()} to {network.ids.max()}"
    )


def _far(
    network: Network, drive: int, direction: int, n_layer: float
) -> tuple[NDArray[np.int64], Array]:
    """Return the rows of the grains at the end far from the drive, and their positions in the layer
    from 0 to 1.
    """
    place = network.position[:, direction]
    here = place[_row(network, drive, "--drive")]
    low = float(place.min())
    high = float(place.max())
    away = high - place if high - here >= here - low else place - low
    spacing = float(2 * np.median(network.springs.lever))
    depth = max(n_layer - 0.5, 0.0) * spacing if n_layer else _END_LAYER * spacing
    last = np.flatnonzero(away <= depth)
    if np.isin(_row(network, drive, "--drive"), last):
        raise InputError(
            f"--end: the end reaches the drive, grain {drive}; use a longer packing or a thinner "
            "layer"
        )
    return last, 1 - away[last] / max(depth, 1e-300)


def _matched(network: Network, last: NDArray[np.int64]) -> Callable[[float], sparse.csc_array]:
    """Return S of a matched end, (n_freedoms, n_freedoms), N/m, as a function of omega, rad/s."""
    springs = network.springs
    inside = np.zeros(network.n_grains, dtype=bool)
    inside[last] = True
    stiffness = np.zeros((network.n_grains, 3, 3))
    for inner, outer in ((springs.first, springs.second), (springs.second, springs.first)):
        between = np.flatnonzero(inside[inner] & ~inside[outer])
        np.add.at(stiffness, inner[between], _blocks(springs)[between])
    supports = np.zeros_like(stiffness)
    np.add.at(supports, network.supports.first, _blocks(network.supports))
    number = network.numbers[last, :3]
    n = network.n_freedoms
    rows, columns = np.broadcast_arrays(number[:, :, None], number[:, None, :])
    kept = (rows >= 0) & (columns >= 0)
    strength, axes = np.linalg.eigh(np.where(kept, stiffness[last], 0.0))
    sideways = np.einsum("nab,nai,nbi->ni", np.where(kept, supports[last], 0.0), axes, axes)

    def at(omega: float) -> sparse.csc_array:
        stiff = np.where(strength > 0, strength, 1.0)
        inertia = network.mass[last, None] * omega**2 - sideways
        cosine = (1 - inertia / (2 * stiff)).astype(np.complex128)
        decay = -np.sign(cosine.real) * np.sqrt(cosine**2 - 1)  # below and above the pass band
        inner = np.where(np.abs(cosine) <= 1, 1j * np.sqrt(1 - cosine**2), decay)
        impedance = np.where(strength > 0, stiff * (1 - cosine - inner), 0.0)
        blocks = (axes * impedance[:, None, :]) @ axes.transpose(0, 2, 1)
        return sparse.coo_array((blocks[kept], (rows[kept], columns[kept])), shape=(n, n)).tocsc()

    return at


def _blocks(springs: Springs) -> Array:
    """Return the stiffness of each contact against displacements of its first grain: (n, 3, 3),
    N/m.
    """
    normal = springs.normal
    parallel = normal[:, :, None] * normal[:, None, :]
    block = springs.stiffness[:, None, None] * parallel
    block = block + springs.tangential[:, None, None] * (np.eye(3) - parallel)
    return np.asarray(block - (springs.force / springs.distance)[:, None, None] * springs.turns)


def dampers_of(assembly: Assembly, network: Network) -> Array:
    """Return the dampers of each grain, force / velocity and moment / angular velocity:
    (n_grains, 6), N s/m and N m s.
    """
    rates = np.zeros((network.n_grains, 6))
    for entry in assembly.case.absorb:
        rows = np.flatnonzero(np.isin(network.ids, absorbing_ids(assembly, entry)))
        if entry.rate is None:
            rates[rows, _Z] = impedance_of(assembly, entry)
            continue
        rate = np.full(len(rows), entry.rate)
        if (rise := rise_of(assembly, entry)) is not None:
            place = network.position[rows, "xyz".index(entry.towards[1])]
            rate *= np.clip((place - rise[0]) / (rise[1] - rise[0]), 0.0, 1.0) ** 2
        rates[rows, :3] = (rate * network.mass[rows])[:, None]
        rates[rows, 3:] = (rate * network.inertia[rows])[:, None]
    return rates


def _effective_masses(network: Network, moves: NDArray[np.bool_]) -> Array:
    """Return the effective masses of contacts along their normals: (n_contacts,), kg.

    Grains move in the directions ``moves``, (n_grains, 3). If no grain of a contact moves along
    the normal, both count as free, as in the pair style.
    """
    contacts = network.contacts
    square = contacts.normal**2
    inverse = np.append(1 / network.mass, 0.0)  # walls are the row beyond the last
    left = np.vstack([moves, np.zeros(3)])
    free = np.zeros(len(contacts))
    moved = np.zeros(len(contacts))
    for rows in (contacts.first, contacts.second):
        free += inverse[rows]
        moved += inverse[rows] * (square * left[rows]).sum(axis=1)
    return np.asarray(1 / np.where(moved > _HELD * free, moved, free))


def losses_of(
    assembly: Assembly, network: Network, driven: Sequence[int] = (), axis: str = ""
) -> Network | None:
    """Return the network with damping constants of contacts (N s/m) instead of stiffnesses; None
    without damping.

    Parameters
    ----------
    driven
        Ids of grains whose motion is prescribed.
    axis
        Direction of this motion.
    """
    case = assembly.case
    _refuse_damped_resistance(case)
    if not case.has_loss:
        return None
    contacts = network.contacts
    partners = {wall.name: wall.material for wall in walls(assembly)}

    @cache
    def loss_of(
        materials: tuple[Material, Material], shapes: tuple[Shape, Shape] | None
    ) -> ContactLoss | None:
        """Loss of a pair of grains, or, without shapes, of a contact with a wall."""
        more: dict[str, Any] = {"flat": True} if shapes is None else {"shapes": shapes}
        return viscous_loss(assembly, case.contact_between(*materials), *materials, **more)

    damping = np.zeros(len(contacts))
    moves = network.moves[:, :3].copy()
    for direction in axis:
        moves[np.isin(network.ids, driven), "xyz".index(direction)] = False
    effective = _effective_masses(network, moves)
    ids = np.stack([network.ids[contacts.first], network.ids[contacts.second]], axis=1).tolist()
    names = [""] * len(contacts) if contacts.wall is None else contacts.wall.tolist()
    for row, ((i, j), wall) in enumerate(zip(ids, names, strict=True)):
        if wall:
            loss = loss_of((assembly.material_of(i), partners[wall]), None)
        else:
            materials = assembly.material_of(i), assembly.material_of(j)
            loss = loss_of(materials, (assembly.shape_of(i), assembly.shape_of(j)))
        if loss is not None and loss[0] != "prony":  # Prony series have no state
            kind, size = loss
            k = float(contacts.stiffness[row])
            damping[row] = size * (
                k if kind == "time" else math.sqrt(2 / 3 * float(effective[row]) * k)
            )
    none = np.zeros(len(contacts))
    damped = dataclasses.replace(
        contacts, stiffness=damping, tangential=none, force=none, rolling=none, twisting=none
    )
    return dataclasses.replace(network, contacts=damped)


def _refuse_damped_resistance(case: Case) -> None:
    """Raise InputError for dampers against sliding, rolling or twisting."""
    for contact in case.contact_laws:
        for name in _RESISTANCES:
            resistance = getattr(contact, name)
            if not isinstance(resistance, Resistance):
                continue
            if resistance.coefficient and resistance.damping:
                raise InputError(
                    f"{case.name}: contact.{name}.damping: found {resistance.damping:g}, expected "
                    "0: only contact.loss is included in a steady motion"
                )
