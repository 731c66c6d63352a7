"""Paths of wave vectors: given in rad/m, or by the standard names of points of the Brillouin zone.

    0,0,0; 0,0,314.2; 100,0,0      wave vectors in rad/m, straight between them
    G-X-M-G,  GXMG,  G-X|R-M       names of points; | begins a new stretch

Names and places of the points are those of ASE (Setyawan, Curtarolo, doi:10.1016/j.commatsci.2010.05.010) for the
cell before the load; a row has G and X.
"""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise

import numpy as np

from granwave.analysis.spectra.network import Array
from granwave.lammps_inputs.case.schema import show
from granwave.lammps_inputs.errors import InputError

_NAMES = re.compile(r"[A-Z][0-9]*")
_FORM = '"kx,ky,kz; kx,ky,kz; ..." in rad/m, or names such as "G-X-M-G"'
_ROW = {"G": np.zeros(3), "X": np.array([0.5, 0.0, 0.0])}
_EPSILON = 1e-3  # of a cell, for recognising its symmetry


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


def special_points(periods: Array) -> dict[str, Array]:
    """Return the special points of the Brillouin zone of a cell by name: (3,), rad/m."""
    scaled, vectors = _scaled_points(periods)
    return {name: point @ vectors for name, point in scaled.items()}


def _scaled_points(periods: Array) -> tuple[dict[str, Array], Array]:
    """Special points in units of the reciprocal vectors, and these: (3, 3), rad/m."""
    from ase.cell import Cell  # takes longer to load than most commands need

    n = len(periods)
    reciprocal = np.zeros((3, 3))
    reciprocal[:n] = 2 * np.pi * np.linalg.pinv(periods).T
    if n == 1:
        return dict(_ROW), reciprocal
    full = np.concatenate([periods, _perpendicular(periods)])
    unit = np.linalg.norm(periods[0])
    pbc = [True] * n + [False] * (3 - n)
    try:
        path = Cell(full / unit).bandpath(pbc=pbc, npoints=0, eps=_EPSILON)
    except (RuntimeError, ValueError, AssertionError):  # a cell that ASE cannot name
        half = {"X": 0, "Y": 1, "Z": 2}
        points = {"G": np.zeros(3)} | {name: np.eye(3)[axis] / 2 for name, axis in half.items() if axis < n}
        return points, reciprocal
    return {name: np.asarray(point, dtype=float) for name, point in path.special_points.items()}, reciprocal


def standard_path(periods: Array) -> str:
    """Return the standard path of a cell, by names."""
    from ase.cell import Cell

    n = len(periods)
    if n == 1:
        return "G-X"
    full = np.concatenate([periods, _perpendicular(periods)])
    pbc = [True] * n + [False] * (3 - n)
    try:
        found = Cell(full / np.linalg.norm(periods[0])).bandpath(pbc=pbc, npoints=0, eps=_EPSILON).path
    except (RuntimeError, ValueError, AssertionError):
        return "-".join(["G", *"XYZ"[:n], "G"])
    return "|".join("-".join(_NAMES.findall(stretch)) for stretch in found.split(","))


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
        The text names no path, an unknown point, or leaves the directions in which the packing repeats.
    """
    stretches = _corners(text or standard_path(periods), periods)
    inside = periods.T @ np.linalg.pinv(periods.T)  # the span of the periods
    k: list[Array] = []
    corners: list[tuple[int, str]] = []
    breaks: list[int] = []
    distance: list[float] = []
    for stretch in stretches:
        for _, place in stretch:
            if np.linalg.norm(place - inside @ place) > 1e-9 * max(float(np.linalg.norm(place)), 1e-300):
                axes = "".join(a for a, one in zip("xyz", np.abs(inside).sum(axis=0), strict=True) if one > 1e-9)
                where = ", ".join(f"{one:g}" for one in place)
                raise InputError(
                    f"--path: found ({where}) rad/m, but the packing repeats along {axes} alone; expected wave vectors "
                    "in the span of its periods"
                )
        if k:
            breaks.append(len(k))
        corners.append((len(k), stretch[0][0]))
        k.append(stretch[0][1])
        distance.append(distance[-1] if distance else 0.0)
        for (_, start), (name, end) in pairwise(stretch):
            length = float(np.linalg.norm(end - start))
            if length == 0:
                where = show(name) if name else "(" + ", ".join(f"{one:g}" for one in end) + ") rad/m"
                raise InputError(f"--path: found {where} twice in a row, expected points that differ")
            for share in np.linspace(0, 1, points)[1:]:
                k.append(start + share * (end - start))
                distance.append(distance[-1] + length / (points - 1))
            corners.append((len(k) - 1, name))
    return Path(np.array(k), np.array(distance), tuple(corners), tuple(breaks))


def _corners(text: str, periods: Array) -> list[list[tuple[str, Array]]]:
    if re.search(r"[;,]\s*[-+.\d]", text) or re.fullmatch(r"[-+.\d eE,;]*", text):
        return [_numbers(text)]
    known = special_points(periods)
    found = []
    for stretch in re.split(r"[|]", text.replace("Γ", "G").replace("Gamma", "G")):
        names = _NAMES.findall(stretch)
        if "".join(names) != re.sub(r"[-\s]", "", stretch) or len(names) < 2:
            raise InputError(f"--path: found {show(text)}, expected {_FORM}; points: {', '.join(known)}")
        for name in names:
            if name not in known:
                raise InputError(
                    f"--path: found the point {name}, expected one of {', '.join(known)}, those of this cell; "
                    f"or {_FORM}"
                )
        found.append([(name, known[name]) for name in names])
    return found


def _numbers(text: str) -> list[tuple[str, Array]]:
    corners = []
    for part in [part for part in text.split(";") if part.strip()]:
        try:
            numbers = [float(one) for one in part.split(",")]
        except ValueError:
            numbers = []
        if len(numbers) != 3 or not np.isfinite(numbers).all():
            raise InputError(f"--path: found {show(part.strip())}, expected three numbers, kx,ky,kz in rad/m")
        corners.append(("G" if not any(numbers) else "", np.array(numbers)))
    if len(corners) < 2:
        raise InputError(f"--path: found {len(corners)} wave vectors, expected two or more: {_FORM}")
    return corners


def _perpendicular(periods: Array) -> Array:
    """Vectors that complete one or two periods to three of the same length."""
    length = np.linalg.norm(periods[0])
    return np.asarray(length * np.linalg.svd(periods)[2][len(periods) :])
