"""Bands of an infinite, periodic packing with derived quantities: gaps, speeds, attenuation, curves
over a plane.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from numpy.typing import NDArray

from granwave.extensions.waves.spectra.bands import (
    ROLLING,
    Bands,
    Gap,
    band_edges,
    describe_floppy,
    gaps,
    solve_bands,
)
from granwave.extensions.waves.spectra.defaults import LARGE, POINTS, POINTS_OF_LARGE
from granwave.extensions.waves.spectra.states import State, cell_state
from granwave.extensions.waves.spectra.stiffness import Stiffness, stiffness_of
from granwave.extensions.waves.spectra.wave_vectors import ComplexBands, complex_bands, make_path
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import Assembly
from granwave.lammps_inputs.statics.bodies import Array

PLANES = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_LONG = 1e-3  # |k| times the largest period of long waves, whose dispersion is 1e-7
_ANGLES = 180  # directions of slowness in a plane
_GRID = 61  # points of a plane of wave vectors along each axis
_MOST_FREEDOMS = 48  # degrees of freedom of a cell whose spectrum is found at all of these points
_RIGID = 1e-9  # (c k)^2 / (largest omega^2 times (k a)^2) below which a mode has no stiffness
_MOST_POINTS = 100_000  # largest number of wave vectors in a stretch of a path
_FREQUENCIES = 401  # number of frequencies for attenuation
_BEYOND = 1.25  # largest of them / highest frequency of the bands
NEAR_TOP = 0.25  # part of a slab's depth in which the energy of surface waves is concentrated


@dataclasses.dataclass(frozen=True, eq=False)
class PlaneWaves:
    """Waves in a plane.

    Attributes
    ----------
    plane
        Name of the plane, such as ``xz``.
    angle
        Directions, from the first axis to the second: (n_angles,), rad.
    speed
        Phase velocities of long waves, rising: (n_angles, n_waves), m/s; NaN where nothing resists.
    k
        Components of wave vectors along each axis: (n,), rad/m.
    frequency
        Of the lowest bands: (n, n, n_bands), Hz; rows along the second axis; NaN where nothing
        resists.
    """

    plane: str
    angle: Array
    speed: Array
    k: Array
    frequency: Array

    @property
    def slowness(self) -> Array:
        """Slowness, 1/c: (n_angles, n_waves), s/m."""
        return np.asarray(1 / self.speed)


def long_wave_speeds(stiffness: Stiffness, directions: Array) -> Array:
    """Return the speeds of long waves along unit vectors (n, 3), rising: (n, n_waves), m/s; NaN
    where nothing resists.

    There is a wave for each direction in which all grains can be displaced together.
    """
    network = stiffness.network
    is_held: NDArray[np.bool_] = np.ones(3, dtype=bool)
    if network.n_grains:
        is_held = np.asarray(~network.moves[:, :3].all(axis=0), dtype=bool)
    if len(network.supports):
        is_held |= np.any(network.supports.normal != 0, axis=0)
        is_held |= bool(network.supports.tangential.max() > 0)
    size = float(np.linalg.norm(network.periods, axis=1).max())
    wave_number = _LONG / size
    square, _ = stiffness.spectrum(directions * wave_number, int((~is_held).sum()))
    propagates = square > _RIGID * stiffness.largest * _LONG**2
    return np.where(propagates, np.sqrt(np.where(propagates, square, 0.0)) / wave_number, np.nan)


def surface(stiffness: Stiffness, plane: str, n_bands: int = 3) -> PlaneWaves | None:
    """Return slowness and frequencies over a plane; None for large cells, and for packings that are
    not periodic in the plane.
    """
    network = stiffness.network
    a, b = PLANES[plane]
    if network.n_freedoms > _MOST_FREEDOMS or len(network.periods) < 2:
        return None
    inside = network.periods.T @ np.linalg.pinv(network.periods.T)
    if not np.allclose(inside[[a, b]][:, [a, b]], np.eye(2), atol=1e-9):
        return None
    angle = np.linspace(0, 2 * np.pi, _ANGLES, endpoint=False)
    directions = np.zeros((_ANGLES, 3))
    directions[:, a] = np.cos(angle)
    directions[:, b] = np.sin(angle)
    reciprocal = 2 * np.pi * np.linalg.pinv(network.periods)
    reach = float(np.abs(reciprocal).max()) * 0.75
    k = np.linspace(-reach, reach, _GRID)
    grid = np.zeros((_GRID * _GRID, 3))
    k_a, k_b = np.meshgrid(k, k)
    grid[:, a] = k_a.ravel()
    grid[:, b] = k_b.ravel()
    square = np.concatenate(
        [np.linalg.eigvalsh(stiffness.dense(part)) for part in np.array_split(grid, 16)]
    )
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(square[:, :n_bands]) / (2 * np.pi)
    centre = np.argmin(np.abs(grid).sum(axis=1))
    frequency[centre] = np.nan_to_num(frequency[centre])
    return PlaneWaves(
        plane,
        angle,
        long_wave_speeds(stiffness, directions),
        k,
        frequency.reshape(_GRID, _GRID, -1),
    )


@dataclasses.dataclass(frozen=True, eq=False)
class BandStructure:
    """Bands of a packing.

    Attributes
    ----------
    state
        Static state.
    bands
        Bands along the path.
    gaps
        Gaps between them.
    complex_bands
        Attenuation along the first stretch of the path; None for large cells, and where it is not
        defined.
    surface
        Waves over a plane; None for rows and large cells.
    speeds
        Speeds of long waves along the first stretch, rising: (n,), m/s.
    note
        Description of modes without resistance; empty if there are none.
    """

    state: State
    bands: Bands
    gaps: tuple[Gap, ...]
    complex_bands: ComplexBands | None
    surface: PlaneWaves | None
    speeds: Array
    note: str = ""

    @property
    def unit_frequency(self) -> float:
        """Frequency sqrt(k/m)/(2 pi) of the mean stiffness and the mean mass, Hz: the unit of
        normalised axes.
        """
        network = self.state.network
        return float(np.sqrt(network.contacts.stiffness.mean() / network.mass.mean()) / (2 * np.pi))

    @property
    def edges(self) -> Array:
        """Lowest and highest frequency of each band along the path: (n_bands, 2), Hz."""
        return band_edges(self.bands)

    def summary(self) -> dict[str, Any]:
        """Return the values of bands.json."""
        network = self.state.network
        between = [gap for gap in self.gaps if gap.below and np.isfinite(gap.high)]
        widest = max(between, key=lambda gap: gap.high - gap.low, default=None)
        spacing = None if self.complex_bands is None else self.complex_bands.spacing
        static_force = 0.0
        stiffness = 0.0
        if len(network.springs):
            static_force = float(network.springs.force.mean())
            stiffness = float(network.springs.stiffness.mean())
        return {
            "name": self.state.name,
            "kind": "bands",
            "source": self.state.source,
            "n_grains_in_cell": network.n_grains,
            "n_contacts_in_cell": len(network.springs),
            "n_wall_contacts_in_cell": len(network.supports),
            "n_left_out": len(network.left_out),
            "n_freedoms": network.n_freedoms,
            "n_bands": self.bands.square.shape[1],
            "static_force_N": static_force,
            "contact_stiffness_N_per_m": stiffness,
            "unit_frequency_Hz": self.unit_frequency,
            "highest_frequency_Hz": float(np.nanmax(self.bands.frequency)),
            "speeds_m_s": self.speeds.tolist(),
            "band_edges_Hz": self.edges.tolist(),
            "gaps_Hz": [[gap.low, gap.high] for gap in self.gaps],
            "widest_gap_Hz": None if widest is None else [widest.low, widest.high],
            "widest_gap_relative": None if widest is None else widest.relative_width,
            "attenuation_in_widest_gap": self._attenuation_in(widest),
            "attenuation_spacing_m": spacing,
            "n_floppy": int(self.bands.floppy.sum(axis=1).max()),
            "static_residual": self.state.residual,
            "state_spread": self.state.spread,
        }

    def _attenuation_in(self, gap: Gap | None) -> float | None:
        """Return the largest attenuation from plane to plane in a gap; None if it is not known."""
        if self.complex_bands is None or gap is None:
            return None
        frequency = self.complex_bands.frequency
        least = self.complex_bands.least
        decay = least[(frequency > gap.low) & (frequency < gap.high) & np.isfinite(least)]
        return float(decay.max()) if len(decay) else None


def band_structure(
    source: Assembly | FilePath | State,
    path: str = "",
    *,
    points: int | None = None,
    n_bands: int | None = None,
    directions: str = "",
    plane: str = "",
    allow_floppy: bool = False,
    slab: bool = False,
) -> BandStructure:
    """Find the bands of a packing, of a finished run, or of a state.

    Parameters
    ----------
    path
        See `granwave.extensions.waves.spectra.wave_vectors`; empty for the standard path of the
        cell.
    points
        Wave vectors of each stretch; None: 61, or 16 of a cell with more than 150 degrees of
        freedom.
    n_bands
        Number of bands; None: all bands of a small cell, 30 of a large cell.
    directions
        Directions in which the grains move, from "xyz"; empty for the directions of the packing.
    plane
        Plane of slowness and equal-frequency curves: xy, xz or yz; empty for the plane of the
        packing.
    allow_floppy
        True to continue where motions meet no resistance; their frequencies are NaN.
    slab
        True for a packing with an upper and a lower end, periodic only sideways.

    Raises
    ------
    InputError
        The packing is not periodic or carries no load, the path is invalid, or modes have no
        stiffness.
    """
    if set(directions) - set("xyz"):
        raise InputError(
            f'--directions: found "{directions}", expected some of the letters x, y and z'
        )
    if points is not None and not 2 <= points <= _MOST_POINTS:
        raise InputError(f"--points: found {points}, expected 2 to {_MOST_POINTS} in each stretch")
    if plane and plane not in PLANES:
        raise InputError(f'--plane: found "{plane}", expected {", ".join(PLANES)}')
    state = source if isinstance(source, State) else cell_state(source, slab=slab)
    if directions:
        state = dataclasses.replace(state, network=state.network.turned_off(directions))
    stiffness = stiffness_of(state.network)
    usual = POINTS if state.network.n_freedoms <= LARGE else POINTS_OF_LARGE
    route = make_path(path, state.network.periods, points or usual)
    near_top = None
    if slab:
        depth = state.network.position[:, 2]
        grain, _ = state.network.freedoms
        near_top = depth[grain] <= depth.min() + NEAR_TOP * np.ptp(depth)
    bands = solve_bands(stiffness, route, n_bands, near_top)
    note = describe_floppy(bands)
    if note and not allow_floppy:
        raise InputError(_floppy(state.name, note))
    start = route.k[0]
    towards = route.k[1] - route.k[0]
    direction = towards / np.linalg.norm(towards)
    top = float(np.nanmax(bands.frequency, initial=0.0))
    frequency = np.linspace(0.0, _BEYOND * top, _FREQUENCIES)[1:]
    decaying = complex_bands(stiffness, start, direction, frequency) if top else None
    planes = [plane] if plane else ["xz", "xy", "yz"]
    surfaces = (surface(stiffness, name) for name in planes)
    curves = next((waves for waves in surfaces if waves is not None), None)
    speeds = long_wave_speeds(stiffness, direction[None])[0]
    return BandStructure(state, bands, tuple(gaps(bands)), decaying, curves, speeds, note)


def _floppy(name: str, note: str) -> str:
    """Return the message for modes without resistance, with remedies."""
    cure = (
        'friction, a load from all sides (precompression.kind = "uniform"), --directions, [[hold]]'
    )
    if ROLLING in note:
        cure = "contact.rolling, [[hold]] with rotation = true, contact.friction=0"
    return (
        f"{name}: {note}; use {cure}, or another --path to make it rigid, or --allow-floppy to "
        "leave these modes blank"
    )
