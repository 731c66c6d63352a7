"""Wave vectors: paths of real ones, and complex ones inside gaps.

Paths are given in rad/m, or by the standard names of points of the Brillouin zone.

    0,0,0; 0,0,314.2; 100,0,0      wave vectors in rad/m, straight between them
    G-X-M-G,  GXMG,  G-X|R-M       names of points; | begins a new stretch

Names and places of the points are those of ASE (Setyawan, Curtarolo,
doi:10.1016/j.commatsci.2010.05.010) for the cell before the load; a row has G and X.

Complex wave vectors give the attenuation of waves inside gaps. Along a direction in which planes of
the lattice lie h apart, all phases are powers of lambda = exp(i s h), and

    sum_m K_m lambda^m u = omega^2 M u

is an eigenvalue problem in lambda at a given frequency. |lambda| = 1 are waves; |lambda| < 1 falls
by -ln |lambda| from plane to plane. The whole spectrum of a small cell is found from the dense
matrix of all its unknowns.

A larger cell is first condensed to its faces. Of the unknowns only those in A touch the next cell,
and only those in B the one before, by the stiffness C between them; with G the inverse of K_0 -
omega^2 M, and p = u_A, q = lambda u_B,

    lambda [[1, G_AA C], [0, G_BA C]] (p, q) = -[[G_AB C^H, 0], [G_BB C^H, 1]] (p, q)

which is as exact, and has as many unknowns as the faces. Where planes lie closer than cells reach,
as many cells are taken as one that it reaches the next alone; the phase is then known up to whole
parts of 2 pi, and left out.
"""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise

import numpy as np
from scipy import sparse
from scipy.linalg import eig
from scipy.sparse.linalg import splu

from granwave.extensions.waves.spectra.network import Array
from granwave.extensions.waves.spectra.stiffness import Stiffness
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_number

_NAMES = re.compile(r"[A-Z][0-9]*")
_FORM = '"kx,ky,kz; kx,ky,kz; ..." in rad/m, or names such as "G-X-M-G"'
_EPSILON = 1e-3  # of a cell, for recognising its symmetry
MOST_UNKNOWNS = 80  # of the linear problem, which is solved at some hundred frequencies
# unknowns of a condensed problem, and of the cells that are condensed
MOST_ON_FACES = 400
_MOST_CONDENSED = 6000
# cubes of unknowns times frequencies, to which their number is reduced; fewest of them
_FLOPS = 5e8
_FEWEST = 16
_WHOLE = 1e-6  # by which the places of planes may miss multiples of their spacing
_WAVE = 1e-6  # of ln |lambda|: a wave that does not fall
# of |lambda|; beyond are the infinite ones of a singular pencil
_SMALLEST = 1e-12
_LARGEST = 1e12


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
        Rows at which a new stretch begins that does not continue the one before.
    """

    k: Array
    distance: Array
    corners: tuple[tuple[int, str], ...]
    breaks: tuple[int, ...] = ()

    def nearest(self, row: int) -> str:
        """Describe the place of a row: the corner that it is, or the wave vector."""
        names = dict(self.corners)
        where = ", ".join(f"{one:.4g}" for one in self.k[row])
        return f"k = ({where}) rad/m" + (f", {names[row]}" if names.get(row) else "")


def zone(periods: Array) -> tuple[dict[str, Array], str]:
    """Return the special points of the Brillouin zone by name, (3,), rad/m, and the standard path
    by names.
    """
    from ase.cell import Cell  # takes longer to load than most commands need

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
            found = cell.bandpath(pbc=pbc, npoints=0, eps=_EPSILON)
            points = found.special_points
            path = found.path
    except (RuntimeError, ValueError, AssertionError):  # a cell that ASE cannot name
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
            if np.linalg.norm(place - inside @ place) > 1e-9 * max(
                float(np.linalg.norm(place)), 1e-300
            ):
                axes = "".join(
                    a
                    for a, one in zip("xyz", np.abs(inside).sum(axis=0), strict=True)
                    if one > 1e-9
                )
                where = ", ".join(f"{one:g}" for one in place)
                raise InputError(
                    f"--path: found ({where}) rad/m, but the packing repeats along {axes} alone; expected wave vectors "
                    "in the span of its periods"
                )
        breaks += [len(k)] if k else []
        corners.append((len(k), stretch[0][0]))
        k.append(stretch[0][1])
        for (_, start), (name, end) in pairwise(stretch):
            if np.array_equal(start, end):
                where = (
                    show(name) if name else "(" + ", ".join(f"{one:g}" for one in end) + ") rad/m"
                )
                raise InputError(
                    f"--path: found {where} twice in a row, expected points that differ"
                )
            k += [start + share * (end - start) for share in np.linspace(0, 1, points)[1:]]
            corners.append((len(k) - 1, name))
    steps = np.linalg.norm(np.diff(k, axis=0), axis=1)
    steps[[row - 1 for row in breaks]] = 0.0
    return Path(
        np.array(k), np.concatenate([[0.0], np.cumsum(steps)]), tuple(corners), tuple(breaks)
    )


def _corners(text: str, periods: Array) -> list[list[tuple[str, Array]]]:
    if text and (re.search(r"[;,]\s*[-+.\d]", text) or re.fullmatch(r"[-+.\d eE,;]*", text)):
        corners = []
        for part in filter(str.strip, text.split(";")):
            try:
                place = np.array([read_number(one) for one in part.split(",")])
            except ValueError:
                place = np.empty(0)
            if len(place) != 3 or not np.isfinite(place).all():
                raise InputError(
                    f"--path: found {show(part.strip())}, expected three numbers, kx,ky,kz in rad/m"
                )
            corners.append(("" if place.any() else "G", place))
        if len(corners) < 2:
            raise InputError(
                f"--path: found {len(corners)} wave vectors, expected two or more: {_FORM}"
            )
        return [corners]
    known, standard = zone(periods)
    text = text or standard
    found = []
    for stretch in text.replace("Γ", "G").replace("Gamma", "G").split("|"):
        names = _NAMES.findall(stretch)
        if "".join(names) != re.sub(r"[-\s]", "", stretch) or len(names) < 2:
            raise InputError(
                f"--path: found {show(text)}, expected {_FORM}; points: {', '.join(known)}"
            )
        if unknown := [name for name in names if name not in known]:
            raise InputError(
                f"--path: found the point {unknown[0]}, expected one of {', '.join(known)}, those of this cell; "
                f"or {_FORM}"
            )
        found.append([(name, known[name]) for name in names])
    return found


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
        -ln |lambda| of all that do not grow, rising along each row; NaN where there are fewer: (n_frequencies, n).
    phase
        arg lambda of the same, rad.
    """

    direction: Array
    spacing: float
    frequency: Array
    attenuation: Array
    phase: Array

    @property
    def least(self) -> Array:
        """Smallest attenuation from plane to plane; 0 where there are waves: (n_frequencies,)."""
        return np.asarray(np.nan_to_num(self.attenuation[:, 0], nan=np.inf))


def plane_spacing(stiffness: Stiffness, direction: Array) -> float:
    """Return the distance of the planes of the lattice across a direction, m; 0 if they have none."""
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
    own, others = (
        stiffness._scaled
    )  # K_m of the powers of lambda, by the numbers of planes that cells are apart
    parts = {m: sparse.csc_array(own.shape, dtype=np.complex128) for m in range(-most, most + 1)}
    parts[0] = parts[0] + own
    for number, shift, one in zip(numbers.tolist(), stiffness.shifts, others, strict=True):
        phased = one * np.exp(1j * float(start @ shift))
        parts[number] = parts[number] + phased
        parts[-number] = parts[-number] + phased.conj().T
    if condensed:
        solved = _of_faces(parts, most, frequency)
        if solved is None:
            return None
        frequency, found = solved
    else:
        dense = {m: part.toarray() for m, part in parts.items()}
        found = [_of_cell(dense, most, n, (2 * np.pi * one) ** 2) for one in frequency]
    values = np.full((len(found), max(map(len, found))), np.nan, dtype=np.complex128)
    for row, powers in enumerate(found):
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
    """Return some of the frequencies, and the lambda of a large cell from its faces; None if these
    are too large.
    """
    ahead = [
        [[parts.get(away + column - row) for column in range(most)] for row in range(most)]
        for away in (0, most)
    ]
    middle, coupling = (sparse.block_array(blocks, format="csc") for blocks in ahead)
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
    found = []
    for one in frequency:
        square = (2 * np.pi * one) ** 2
        inverse = splu(
            (middle - square * sparse.eye_array(middle.shape[0])).tocsc()
        )  # indefinite: with pivots
        response = inverse.solve(loads)[faces]
        left = -np.eye(size, dtype=np.complex128)
        right = np.eye(size, dtype=np.complex128)
        left[:, :n] = -response[:, n:] @ between.conj().T
        right[:, n:] = response[:, :n] @ between
        found.append(_decaying(left, right))
    return frequency, found


def _of_cell(parts: dict[int, np.ndarray], most: int, n: int, square: float) -> np.ndarray:
    """Return the lambda that do not grow, from the matrices of a cell of n unknowns."""
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
    """Return the lambda of a pencil that do not grow, by rising attenuation."""
    above, below = eig(left, right, right=False, homogeneous_eigvals=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        values = above / below
    size = np.abs(values)
    kept = values[np.isfinite(size) & (size > _SMALLEST) & (size < _LARGEST) & (size <= 1 + _WAVE)]
    return kept[np.argsort(-np.abs(kept), kind="stable")]
