"""Surfaces of triangles, and STL files of them in the form that CAD programs write."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def plate(n: int, half: float = 0.02, height: float = 0.0) -> Floats:
    """Return a square plate across z of 2 n^2 triangles, its corners not in rows: (k, 3, 3)."""
    random = np.random.default_rng(3)
    line = np.linspace(-half, half, n + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    shift = np.zeros((2, n + 1, n + 1))
    shift[:, 1:-1, 1:-1] = random.uniform(-0.3, 0.3, (2, n - 1, n - 1)) * 2 * half / n
    points = np.stack([x + shift[0], y + shift[1], np.full_like(x, height)], axis=-1)
    return of_grid(points)


def of_grid(points: Floats) -> Floats:
    """Return two triangles for each cell of a grid of points (m, n, 3): (k, 3, 3)."""
    a = points[:-1, :-1]
    b = points[1:, :-1]
    c = points[1:, 1:]
    d = points[:-1, 1:]
    first = np.stack([a, b, c], axis=-2).reshape(-1, 3, 3)
    second = np.stack([a, c, d], axis=-2).reshape(-1, 3, 3)
    return np.concatenate([first, second])


def tube(n: int, radius: float, low: float, high: float) -> Floats:
    """Return the side of a cylinder around z of n facets, whose corners are on the circle."""
    angle = 2 * np.pi * np.arange(n + 1) / n
    angle[-1] = 0.0
    circle = [radius * np.cos(angle), radius * np.sin(angle)]
    rings = [np.stack([*circle, np.full_like(angle, z)], axis=-1) for z in (low, high)]
    return of_grid(np.stack(rings))


def box(half: float) -> Floats:
    """Return the six faces of a cube around the origin, of two triangles each."""
    faces = []
    for axis in range(3):
        for side in (-half, half):
            face = np.roll(plate(1, half, side), axis + 1, axis=2)
            faces.append(face)
    return np.concatenate(faces)


def stl_text(triangles: Floats) -> str:
    """Return the text of an STL file, with numbers of 17 digits."""
    lines = ["solid part"]
    for corners in triangles:
        lines += ["  facet normal 0 0 0", "    outer loop"]
        lines += [f"      vertex {x:.17g} {y:.17g} {z:.17g}" for x, y, z in corners]
        lines += ["    endloop", "  endfacet"]
    return "\n".join([*lines, "endsolid part", ""])


def stl_binary(triangles: Floats) -> bytes:
    """Return a binary STL file."""
    head = b"solid by a program that says so in binary files".ljust(80, b" ")
    facets = [
        np.concatenate([np.zeros(3), corners.ravel()]).astype("<f4").tobytes() + b"\0\0"
        for corners in triangles
    ]
    return head + struct.pack("<I", len(triangles)) + b"".join(facets)
