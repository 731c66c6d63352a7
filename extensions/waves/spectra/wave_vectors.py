"""Real wave vectors along paths, and complex wave vectors inside gaps.

Paths are given in rad/m, or by the standard names of points of the Brillouin zone.

    0,0,0; 0,0,314.2; 100,0,0      wave vectors in rad/m, straight lines between them
    G-X-M-G,  GXMG,  G-X|R-M       names of points; | begins a new stretch

The names and positions of the points are from ASE (Setyawan, Curtarolo,
doi:10.1016/j.commatsci.2010.05.010) for the cell before the load; a chain has G and X.

Complex wave vectors give the attenuation of waves inside gaps. Along a direction in which planes of
the lattice have the distance h, all phases are powers of lambda = exp(i s h), and

    sum_m K_m lambda^m u = omega^2 M u

is an eigenvalue problem for lambda at a given frequency. Waves have |lambda| = 1; a field with
|lambda| < 1 decays by -ln |lambda| from plane to plane. The complete spectrum of a small cell is
computed from the dense matrix of all its unknowns.

A larger cell is first condensed to its faces. Only the unknowns A touch the next cell, and only the
unknowns B touch the cell before, by the stiffness C between them. With the inverse G of
K_0 - omega^2 M, and p = u_A, q = lambda u_B,

    lambda [[1, G_AA C], [0, G_BA C]] (p, q) = -[[G_AB C^H, 0], [G_BB C^H, 1]] (p, q)

This is also exact, and has as many unknowns as the faces. If contacts reach beyond the next plane,
several cells are joined until they reach only the next joint cell. The phase is then known only up
to multiples of 2 pi, and is omitted.
"""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.linalg import eig
from scipy.sparse.linalg import splu

from granwave.extensions.waves.spectra.stiffness import Stiffness
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number
from granwave.lammps_inputs.statics.bodies import Array

_NAMES = re.compile(r"[A-Z][0-9]*")
_FORM = '"kx,ky,kz; kx,ky,kz; ..." in rad/m, or names such as "G-X-M-G"'
_EPSILON = 1e-3  # relative tolerance of the symmetry of a cell
MOST_UNKNOWNS = 80  # unknowns of the linear problem, which is solved at some hundred frequencies
MOST_ON_FACES = 400  # largest number of unknowns of a condensed problem
_MOST_CONDENSED = 6000  # largest number of unknowns of a cell that is condensed
_FLOPS = 5e8  # largest product of frequencies and cubes of unknowns of condensed problems
_FEWEST = 16  # smallest number of frequencies
_OUTSIDE = 1e-9  # relative part of a wave vector outside the span of the periods that is rounding
_WHOLE = 1e-6  # deviation of plane positions from multiples of their spacing, relative to periods
_WAVE = 1e-6  # ln |lambda| below which a wave does not decay
_SMALLEST = 1e-12  # smallest |lambda|
_LARGEST = 1e12  # largest |lambda|; larger values are infinite ones of a singular pencil


@dataclasses.dataclass(frozen=True, eq=False)
class Path:
    """Wave vectors along a path.

    Attributes
    ----------
    k
        Wave vectors: (n, 3), rad/m.
    distance
        Length of the path up to them: (n,), rad/m.
    corners
        Rows of the corners, with their names.
    breaks
        Rows at which a new stretch begins that does not continue the previous one.
    """

    k: Array
    distance: Array
    corners: tuple[tuple[int, str], ...]
    breaks: tuple[int, ...] = ()

    def nearest(self, row: int) -> str:
        """Describe a row: the corner of the path at which it is, or its wave vector."""
        names = dict(self.corners)
        where = ", ".join(f"{component:.4g}" for component in self.k[row])
        return f"k = ({where}) rad/m" + (f", {names[row]}" if names.get(row) else "")


def zone(periods: Array) -> tuple[dict[str, Array], str]:
    """Return the special points of the Brillouin zone by name, (3,), rad/m, and the standard path
    by names.
    """
    from ase.cell import Cell  # imported on demand: slow to load

    n = len(periods)
    reciprocal = np.zeros((3, 3))
    reciprocal[:n] = 2 * np.pi * np.linalg.pinv(periods).T
    unit = np.linalg.norm(periods[0])
    beside = np.linalg.svd(periods)[2][n:]  # complete one or two periods to three
    try:
        if n == 1:
            points = {"G": np.zeros(3), "X": np.array([0.5, 0.0, 0.0])}
            path = "GX"
        else:
            pbc = [True] * n + [False] * (3 - n)
            cell = Cell(np.concatenate([periods / unit, beside]))
            band_path = cell.bandpath(pbc=pbc, npoints=0, eps=_EPSILON)
            points = band_path.special_points
            path = band_path.path
    except (RuntimeError, ValueError, AssertionError):  # a cell that ASE cannot classify
        points = {"G": np.zeros(3)} | dict(zip("XYZ"[:n], np.eye(3) / 2, strict=False))
        path = "".join([*points, "G"])
    stretches = ("-".join(_NAMES.findall(stretch)) for stretch in path.split(","))
    return {
        name: np.asarray(point, dtype=float) @ reciprocal for name, point in points.items()
    }, "|".join(stretches)


def make_path(text: str, periods: Array, points: int) -> Path:
    """Make a path.

    Parameters
    ----------
    text
        Corners, see the module; empty for the standard path.
    periods
        Periods of the packing: (n_periods, 3), m.
    points
        Wave vectors of each stretch between two corners, both included.

    Raises
    ------
    InputError
        The text names no path, an unknown point, or leaves the directions in which the packing
        repeats.
    """
    inside = periods.T @ np.linalg.pinv(periods.T)  # the span of the periods
    k: list[Array] = []
    corners: list[tuple[int, str]] = []
    breaks: list[int] = []
    for stretch in _corners(text, periods):
        for _, place in stretch:
            _refuse_outside(place, inside)
        breaks += [len(k)] if k else []
        corners.append((len(k), stretch[0][0]))
        k.append(stretch[0][1])
        for (_, start), (name, end) in pairwise(stretch):
            if np.array_equal(start, end):
                where = show(name) if name else f"({_components(end)}) rad/m"
                raise InputError(
                    f"--path: found {where} twice in succession, expected different points"
                )
            k += [start + share * (end - start) for share in np.linspace(0, 1, points)[1:]]
            corners.append((len(k) - 1, name))
    steps = np.linalg.norm(np.diff(k, axis=0), axis=1)
    steps[[row - 1 for row in breaks]] = 0.0
    return Path(
        np.array(k), np.concatenate([[0.0], np.cumsum(steps)]), tuple(corners), tuple(breaks)
    )


def _components(vector: Array) -> str:
    """Return a vector in words."""
    return ", ".join(f"{component:g}" for component in vector)


def _refuse_outside(vector: Array, inside: Array) -> None:
    """Raise InputError if a wave vector is not in the span of the periods, given its projection."""
    outside = float(np.linalg.norm(vector - inside @ vector))
    if outside <= _OUTSIDE * max(float(np.linalg.norm(vector)), 1e-300):
        return
    weights = np.abs(inside).sum(axis=0)
    axes = "".join(axis for axis, weight in zip("xyz", weights, strict=True) if weight > _OUTSIDE)
    raise InputError(
        f"--path: found ({_components(vector)}) rad/m, but the packing is periodic only along "
        f"{axes}; expected wave vectors in the span of its periods"
    )


def _corners(text: str, periods: Array) -> list[list[tuple[str, Array]]]:
    """Return the corners of each stretch of a path, with their names and wave vectors, rad/m."""
    if text and (re.search(r"[;,]\s*[-+.\d]", text) or re.fullmatch(r"[-+.\d eE,;]*", text)):
        return [_vectors(text)]
    special_points, standard = zone(periods)
    text = text or standard
    stretches = []
    for stretch in text.replace("Γ", "G").replace("Gamma", "G").split("|"):
        names = _NAMES.findall(stretch)
        if "".join(names) != re.sub(r"[-\s]", "", stretch) or len(names) < 2:
            raise InputError(
                f"--path: found {show(text)}, expected {_FORM}; points: {', '.join(special_points)}"
            )
        if unknown := [name for name in names if name not in special_points]:
            raise InputError(
                f"--path: found the point {unknown[0]}, expected one of "
                f"{', '.join(special_points)} (the points of this cell), or {_FORM}"
            )
        stretches.append([(name, special_points[name]) for name in names])
    return stretches


def _vectors(text: str) -> list[tuple[str, Array]]:
    """Read the wave vectors of a path, with the name of the origin: "0,0,0; 0,0,300"."""
    corners = []
    for part in filter(str.strip, text.split(";")):
        try:
            vector = np.array([read_number(number) for number in part.split(",")])
        except ValueError:
            vector = np.empty(0)
        if len(vector) != 3 or not np.isfinite(vector).all():
            raise InputError(
                f"--path: found {show(part.strip())}, expected three numbers, kx,ky,kz in rad/m"
            )
        corners.append(("" if vector.any() else "G", vector))
    if len(corners) < 2:
        raise InputError(
            f"--path: found {len(corners)} wave vectors, expected two or more: {_FORM}"
        )
    return corners


@dataclasses.dataclass(frozen=True, eq=False)
class ComplexBands:
    """Waves and decaying fields along a direction.

    Attributes
    ----------
    direction
        Unit vector: (3,).
    spacing
        Distance h of the planes, m.
    frequency
        (n_frequencies,), Hz.
    attenuation
        -ln |lambda| of all that do not grow, rising along each row; NaN where there are fewer:
        (n_frequencies, n).
    phase
        arg lambda, rad.
    """

    direction: Array
    spacing: float
    frequency: Array
    attenuation: Array
    phase: Array

    @property
    def least(self) -> Array:
        """Smallest attenuation from plane to plane; 0 at frequencies of waves: (n_frequencies,)."""
        return np.asarray(np.nan_to_num(self.attenuation[:, 0], nan=np.inf))


def plane_spacing(stiffness: Stiffness, direction: Array) -> float:
    """Return the distance of the planes of the lattice across a direction, m; 0 if there are no
    such planes.
    """
    places = np.abs(stiffness.shifts @ direction)
    size = np.linalg.norm(stiffness.network.periods, axis=1).max()
    places = places[places > _WHOLE * size]
    if not len(places):
        return 0.0
    spacing = float(places.min())
    for place in np.unique(places):  # Euclid's algorithm
        a = float(place)
        b = spacing
        while b > 10 * _WHOLE * size:
            a, b = b, abs(a - b * round(a / b))
        spacing = a
    numbers = places / spacing
    return spacing if np.abs(numbers - np.round(numbers)).max() < 100 * _WHOLE else 0.0


def complex_bands(
    stiffness: Stiffness, start: Array, direction: Array, frequency: Array
) -> ComplexBands | None:
    """Find the complex wave vectors along a direction from a wave vector, rad/m, at frequencies
    (n,), Hz.

    Returns
    -------
    ComplexBands or None
        None if the cell is too large, or the direction has no planes. Of a large cell there are
        fewer frequencies.
    """
    spacing = plane_spacing(stiffness, direction)
    if not spacing:
        return None
    numbers = np.rint(stiffness.shifts @ direction / spacing).astype(int)
    most = int(np.abs(numbers).max())
    n = stiffness.network.n_freedoms
    condensed = 2 * most * n > MOST_UNKNOWNS
    if condensed and most * n > _MOST_CONDENSED:
        return None
    own, others = stiffness._scaled
    # K_m of the powers of lambda, by the number of planes between two cells
    parts = {m: sparse.csc_array(own.shape, dtype=np.complex128) for m in range(-most, most + 1)}
    parts[0] = parts[0] + own
    for number, shift, block in zip(numbers.tolist(), stiffness.shifts, others, strict=True):
        phased = block * np.exp(1j * float(start @ shift))
        parts[number] = parts[number] + phased
        parts[-number] = parts[-number] + phased.conj().T
    if condensed:
        solved = _of_faces(parts, most, frequency)
        if solved is None:
            return None
        frequency, eigenvalues = solved
    else:
        dense = {m: part.toarray() for m, part in parts.items()}
        eigenvalues = [
            _of_cell(dense, most, n, (2 * np.pi * frequency_Hz) ** 2) for frequency_Hz in frequency
        ]
    values = np.full((len(eigenvalues), max(map(len, eigenvalues))), np.nan, dtype=np.complex128)
    for row, powers in enumerate(eigenvalues):
        values[row, : len(powers)] = powers
    with np.errstate(invalid="ignore"):
        attenuation = np.maximum(-np.log(np.abs(values)), 0.0)
        attenuation[attenuation < _WAVE] = 0.0
    if not condensed:
        return ComplexBands(direction, spacing, frequency, attenuation, np.angle(values))
    phase = np.angle(values) if most == 1 else np.full(values.shape, np.nan)
    return ComplexBands(direction, spacing, frequency, attenuation / most, phase)


def _of_faces(
    parts: dict[int, sparse.csc_array], most: int, frequency: Array
) -> tuple[Array, list[np.ndarray]] | None:
    """Return some of the frequencies, and the values of lambda of a large cell from its faces; None
    if the faces are too large.
    """
    middle = _block_matrix(parts, most, 0)
    coupling = _block_matrix(parts, most, most)
    coupling.eliminate_zeros()
    on_next = np.unique(coupling.nonzero()[0])
    on_last = np.unique(coupling.nonzero()[1])
    n = len(on_next)
    size = len(on_next) + len(on_last)
    if not size or size > MOST_ON_FACES:
        return None
    kept = max(_FEWEST, int(_FLOPS / (size + 40) ** 3))
    frequency = frequency[:: max(1, -(-len(frequency) // kept))]
    between = coupling.tocsr()[on_next][:, on_last].toarray()
    faces = np.concatenate([on_next, on_last])
    loads = np.zeros((middle.shape[0], size), dtype=np.complex128)
    loads[faces, np.arange(size)] = 1.0
    eigenvalues = []
    for frequency_Hz in frequency:
        square = (2 * np.pi * frequency_Hz) ** 2
        inverse = splu(
            (middle - square * sparse.eye_array(middle.shape[0])).tocsc()
        )  # indefinite: with pivots
        response = inverse.solve(loads)[faces]
        left = -np.eye(size, dtype=np.complex128)
        right = np.eye(size, dtype=np.complex128)
        left[:, :n] = -response[:, n:] @ between.conj().T
        right[:, n:] = response[:, :n] @ between
        eigenvalues.append(_decaying(left, right))
    return frequency, eigenvalues


def _block_matrix(parts: dict[int, sparse.csc_array], most: int, ahead: int) -> sparse.csc_array:
    """Return the matrix between ``most`` planes and the same number of planes that lie ``ahead`` of
    them.
    """
    blocks = []
    for row in range(most):
        blocks.append([parts.get(ahead + column - row) for column in range(most)])
    return sparse.block_array(blocks, format="csc")


def _of_cell(parts: dict[int, np.ndarray], most: int, n: int, square: float) -> np.ndarray:
    """Return the values of lambda that do not grow, from the matrices of a cell of n unknowns."""
    size = 2 * most * n
    scale = max(float(np.abs(parts[0]).max()), square)
    left = np.zeros((size, size), dtype=np.complex128)
    right = np.eye(size, dtype=np.complex128)
    left[: size - n, n:] = np.eye(size - n)
    for m in range(-most, most):
        block = parts[m] - (square * np.eye(n) if m == 0 else 0.0)
        left[size - n :, (m + most) * n : (m + most + 1) * n] = -block / scale
    right[size - n :, size - n :] = parts[most] / scale
    return _decaying(left, right)


def _decaying(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the values of lambda of a pencil that do not grow, by rising attenuation."""
    above, below = eig(left, right, right=False, homogeneous_eigvals=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = above / below
    size = np.abs(values)
    kept = values[np.isfinite(size) & (size > _SMALLEST) & (size < _LARGEST) & (size <= 1 + _WAVE)]
    return kept[np.argsort(-np.abs(kept), kind="stable")]
