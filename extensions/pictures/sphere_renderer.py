"""Orthographic rendering of many spheres, and of cylinders among them, with shading.

Equal spheres that do not overlap hide one another in the order of the distances of their centres
(the plane midway between two of them separates them), so that drawing from back to front is exact.
Cylinders are then drawn pixel by pixel where they are in front of the existing image. A first pass
at low resolution finds the visible grains; only these are drawn at full resolution. The light comes
from above the viewer's left shoulder, and gaps deeper than their surroundings are darkened.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

_OVERSAMPLING = 2  # rendered pixels along each side of a pixel of the image
_COARSE = 7.0  # pixels across a sphere in the first pass
_LIGHT = np.array([-0.45, 0.65, 0.62])  # right, up, towards the viewer
_AMBIENT = 0.42
_DIFFUSE = 0.62
_GLOSS = 0.16
_OCCLUSION = 0.5  # darkening of points one diameter deeper than their surroundings
_SHARPNESS = 32  # exponent of the gloss
_BLUR = 4  # pixels per radius when averaging the surroundings
_BLOCK = 16384  # pixels that are shaded at a time, whose numbers fit into the processor's cache
_LINES = 8  # lines of the image that are coloured at a time, for the same reason


@dataclass(frozen=True, eq=False)
class Camera:
    """Orthographic camera.

    Attributes
    ----------
    right, up, towards
        Orthonormal axes of the image: to its right, to its top, towards the viewer; (3,) each.
    """

    right: NDArray[np.float64]
    up: NDArray[np.float64]
    towards: NDArray[np.float64]

    @classmethod
    def looking(cls, azimuth: float, elevation: float, vertical: NDArray[np.float64]) -> Camera:
        """Make a camera at an azimuth about the vertical and an elevation above the horizon,
        degrees.

        Parameters
        ----------
        vertical
            Unit vector upwards in the image: (3,), along +z or -z.
        """
        turn = math.radians(azimuth)
        rise = math.radians(elevation)
        level = np.array([math.cos(turn), math.sin(turn), 0.0])
        towards = math.cos(rise) * level + math.sin(rise) * vertical
        right = np.cross(vertical, level)
        return cls(right, np.cross(towards, right), towards)

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coordinates (right, up, towards the viewer) of points: (n, 3), m."""
        return points @ np.stack([self.right, self.up, self.towards], axis=1)


@dataclass(frozen=True, eq=False)
class RenderedSpheres:
    """Visible surfaces of spheres with their light, without colours: most of the work, and the same
    for all quantities.

    Attributes
    ----------
    front
        Row in ``visible`` of the sphere that each rendered pixel shows, -1 for none: (n_rows,
        n_columns), from the bottom up.
    brightness, gloss
        Factor of the colour of each rendered pixel, and an additive term, 0 for none: (n_rows,
        n_columns).
    visible
        Rows of the spheres that can be seen, rising: (n_visible,).
    extent
        Left, right, bottom and top in the plane of the image, m.
    """

    front: NDArray[np.int32]
    brightness: NDArray[np.float32]
    gloss: NDArray[np.float32]
    visible: NDArray[np.int64]
    extent: tuple[float, float, float, float]


def lit_surface(
    centres: NDArray[np.float64],
    radius: float | NDArray[np.float64],
    camera: Camera,
    width: int,
    axes: NDArray[np.float64] | None = None,
) -> RenderedSpheres:
    """Find the visible parts of spheres and cylinders, and shade them.

    Parameters
    ----------
    centres
        Centres: (n_spheres, 3), m.
    radius
        Common radius, or radius of each sphere: (n_spheres,), m.
    camera
        Camera.
    width
        Width of the image, pixels.
    axes
        From the centres to the ends of the cylinders, 0 for spheres: (n_spheres, 3), m. By default
        all are spheres.
    """
    seen = camera.project(centres)
    seen[:, 2] -= seen[:, 2].mean()  # only differences count, and their rounding
    radii = np.broadcast_to(np.asarray(radius, dtype=float), len(seen))
    halves = np.zeros_like(seen) if axes is None else camera.project(axes)
    reach = radii[:, None] + np.abs(halves[:, :2])
    margin = 0.1 * float(radii.max())
    low = (seen[:, :2] - reach).min(axis=0) - margin
    high = (seen[:, :2] + reach).max(axis=0) + margin
    grains = _Grains(seen, radii, halves, low, high)
    coarse = grains.front(2 * float(np.median(radii)) / _COARSE)
    visible = np.unique(coarse[coarse >= 0]).astype(np.int64)
    pitch = (high[0] - low[0]) / (width * _OVERSAMPLING)
    grains = _Grains(seen[visible], radii[visible], halves[visible], low, high)
    fine = grains.front(pitch)
    fine = fine[: fine.shape[0] // _OVERSAMPLING * _OVERSAMPLING, : width * _OVERSAMPLING]
    top = low[1] + fine.shape[0] * pitch
    extent = (float(low[0]), float(low[0] + fine.shape[1] * pitch), float(low[1]), float(top))
    return RenderedSpheres(fine, *_light(grains, fine, pitch), visible, extent)


def painted(surface: RenderedSpheres, colours: NDArray[np.float64]) -> NDArray[np.float32]:
    """Colour a surface.

    Returns red, green, blue and alpha from 0 to 1: (n_rows, n_columns, 4), the first row at the
    top. ``colours``: red, green, blue of all spheres from 0 to 1, (n_spheres, 3).
    """
    n_rows, n_columns = (size // _OVERSAMPLING for size in surface.front.shape)
    shown = np.concatenate([colours[surface.visible], np.zeros((1, 3))]).astype(
        np.float32
    )  # the last one: blank, -1
    pixels = np.empty((n_rows, n_columns, 4), dtype=np.float32)  # premultiplied by alpha
    for first in range(0, n_rows, _LINES):
        lines = slice(first, first + _LINES)
        rendered = slice(_OVERSAMPLING * first, _OVERSAMPLING * (first + _LINES))
        front = surface.front[rendered]
        brightness = surface.brightness[rendered]
        gloss = surface.gloss[rendered]
        for channel in range(3):
            lit = np.take(shown[:, channel], front, mode="wrap")  # -1 is the last one
            lit *= brightness
            lit += gloss
            pixels[lines, :, channel] = _mean_of_squares(np.clip(lit, 0.0, 1.0, out=lit))
        pixels[lines, :, 3] = _mean_of_squares((front >= 0).astype(np.float32))
    pixels[..., :3] /= np.maximum(pixels[..., 3:], 1e-6)
    return np.clip(pixels[::-1], 0.0, 1.0)


def _mean_of_squares(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the means over the rendered pixels of each pixel of the picture."""
    rows = sum((values[n::_OVERSAMPLING] for n in range(1, _OVERSAMPLING)), values[::_OVERSAMPLING])
    both = sum(
        (rows[:, n::_OVERSAMPLING] for n in range(1, _OVERSAMPLING)), rows[:, ::_OVERSAMPLING]
    )
    return np.asarray(both / np.float32(_OVERSAMPLING**2))


@dataclass(frozen=True, eq=False)
class _Grains:
    """Spheres and cylinders in the coordinates of the camera.

    Attributes
    ----------
    seen, radius, halves
        Centres, radii, and vectors from the centres to the ends of cylinders, 0 for spheres: to the
        right, up and towards the viewer; (n, 3), (n,) and (n, 3), m.
    low, high
        Corners of the picture, m.
    """

    seen: NDArray[np.float64]
    radius: NDArray[np.float64]
    halves: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    def front(self, pitch: float) -> NDArray[np.int32]:
        """Return the row of the grain that each pixel shows, -1 for none: (n_rows, n_columns), from
        the bottom up.
        """
        shape = tuple(
            math.ceil(extent) + 1 for extent in (self.high[::-1] - self.low[::-1]) / pitch
        )
        front = np.full(shape, -1, dtype=np.int32)
        lying = self.halves.any(axis=1)
        spheres = np.flatnonzero(~lying)
        order = spheres[np.argsort(self.seen[spheres, 2], kind="stable")].astype(
            np.int32
        )  # the farthest first
        place = (
            self.seen[order, :2] - self.low
        ) / pitch - 0.5  # in pixels; integers are centres of pixels
        reach = self.radius[order] / pitch
        if len(order):
            paint = _paint_by_sphere if len(order) < 4 * np.median(reach) ** 2 else _paint_by_pixel
            paint(front, place, reach)
            front[front >= 0] = order[front[front >= 0]]
        if lying.any():  # cylinders, where they are nearer to the viewer
            depth = np.full(shape, -np.inf, dtype=np.float32)
            rows, columns = np.nonzero(front >= 0)
            depth[rows, columns] = self.surface(front, rows, columns, pitch)[0]
        for grain in np.flatnonzero(lying):
            reach = self.radius[grain] + np.abs(self.halves[grain, :2])
            first = np.maximum(
                np.floor((self.seen[grain, :2] - reach - self.low) / pitch).astype(int), 0
            )
            last = np.ceil((self.seen[grain, :2] + reach - self.low) / pitch).astype(int) + 1
            box = slice(first[1], last[1]), slice(first[0], last[0])
            rows, columns = np.mgrid[
                box[0].start : min(box[0].stop, shape[0]), box[1].start : min(box[1].stop, shape[1])
            ]
            found = self._of_cylinder(int(grain), rows, columns, pitch)[0]
            nearer = found > depth[box]
            front[box][nearer] = grain
            depth[box][nearer] = found[nearer]
        return front

    def surface(
        self, front: NDArray[np.int32], rows: NDArray[Any], columns: NDArray[Any], pitch: float
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Return the position towards the viewer, (n,), m, and the normal, (n, 3), of the visible
        surface in pixels.
        """
        grain = front[rows, columns]
        radius = self.radius[grain]
        normal = np.empty((len(grain), 3), dtype=np.float32)
        for axis, pixels in enumerate((columns, rows)):
            normal[:, axis] = (
                self.low[axis] + (pixels + 0.5) * pitch - self.seen[grain, axis]
            ) / radius
        normal[:, 2] = np.sqrt(np.clip(1 - normal[:, 0] ** 2 - normal[:, 1] ** 2, 0.0, 1.0))
        depth = (self.seen[grain, 2] + radius * normal[:, 2]).astype(np.float32)
        for one in set(grain.tolist()) & set(np.flatnonzero(self.halves.any(axis=1)).tolist()):
            own = grain == one
            depth[own], normal[own] = self._of_cylinder(one, rows[own], columns[own], pitch)
        return depth, normal

    def _of_cylinder(
        self, grain: int, rows: NDArray[Any], columns: NDArray[Any], pitch: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        x, y = (
            self.low[axis] + (pixels + 0.5) * pitch for axis, pixels in enumerate((columns, rows))
        )
        return surface_of_cylinder(self.seen[grain], self.halves[grain], self.radius[grain], x, y)


def _paint_by_sphere(
    front: NDArray[np.int32], place: NDArray[np.float64], reach: NDArray[np.float64]
) -> None:
    """Write the number of each sphere into its pixels, sphere by sphere: fast for few large
    spheres.
    """
    corner = np.maximum(np.floor(place - reach[:, None]).astype(int), 0)
    beyond = np.ceil(place + reach[:, None]).astype(int) + 1
    for n, (left, bottom) in enumerate(corner):
        block = front[bottom : beyond[n, 1], left : beyond[n, 0]]
        rows = (np.arange(block.shape[0]) + bottom - place[n, 1]) ** 2
        columns = (np.arange(block.shape[1]) + left - place[n, 0]) ** 2
        block[rows[:, None] + columns < reach[n] ** 2] = n


def _paint_by_pixel(
    front: NDArray[np.int32], place: NDArray[np.float64], reach: NDArray[np.float64]
) -> None:
    """Draw one pixel of all spheres at a time: fast for many small spheres."""
    flat = front.ravel()
    base = np.floor(place).astype(np.int64)
    part = (place - base).astype(np.float32)
    number = np.arange(len(place), dtype=np.int32)
    square = (reach**2).astype(np.float32)
    span = range(-int(reach.max()) - 1, int(reach.max()) + 3)
    for up, across in itertools.product(span, span):
        inside = np.flatnonzero((across - part[:, 0]) ** 2 + (up - part[:, 1]) ** 2 < square)
        pixel = (base[inside, 1] + up) * front.shape[1] + base[inside, 0] + across
        flat[pixel] = np.maximum(flat[pixel], number[inside])


def _light(
    grains: _Grains, front: NDArray[np.int32], pitch: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return brightness and gloss of all pixels: (n_rows, n_columns) each."""
    rows, columns = (place.astype(np.int32) for place in np.nonzero(front >= 0))
    blocks = [slice(start, start + _BLOCK) for start in range(0, len(rows), _BLOCK)]
    normal = np.empty((len(rows), 3), dtype=np.float32)
    depth = np.full(front.shape, float(grains.seen[:, 2].min()), dtype=np.float32)
    for block in blocks:
        depth[rows[block], columns[block]], normal[block] = grains.surface(
            front, rows[block], columns[block], pitch
        )
    light = (_LIGHT / np.linalg.norm(_LIGHT)).astype(np.float32)
    half = light + np.array([0.0, 0.0, 1.0], dtype=np.float32)
    half /= np.linalg.norm(half)
    usual = float(np.median(grains.radius))
    step = max(1, int(usual / pitch / _BLUR))  # large spheres take fewer pixels
    around = gaussian_filter(depth[::step, ::step], usual / pitch / step, mode="nearest")
    brightness, gloss = np.zeros((2, *front.shape), dtype=np.float32)
    for block in blocks:
        row = rows[block]
        column = columns[block]
        one = normal[block]
        bright = _AMBIENT + _DIFFUSE * np.clip(one @ light, 0.0, None)
        mean = map_coordinates(around, [row / step, column / step], order=1, mode="nearest")
        bright *= 1 - _OCCLUSION * np.clip((mean - depth[row, column]) / (2 * usual), 0.0, 1.0)
        shine = np.clip(one @ half, 0.0, None) ** _SHARPNESS
        brightness[row, column] = bright
        gloss[row, column] = shine * _GLOSS
    return brightness, gloss


_ALONG = 1e-6  # component of the axis towards the viewer, or across, that counts as zero


def surface_of_cylinder(
    centre: NDArray[np.float64],
    half: NDArray[np.float64],
    radius: float,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find the visible part of a cylinder with flat ends.

    A point of the mantle lies at the distance of the radius from the axis, a quadratic equation for
    its depth; of the two ends only the end towards the viewer is visible.

    Parameters
    ----------
    centre, half
        Centre, and the vector from it to one end, not 0: (3,), m; to the right, up and towards the
        viewer.
    radius
        Radius, m.
    x, y
        Positions to the right and upwards: arrays of one shape, m.

    Returns
    -------
    depth, normal
        Position towards the viewer, minus infinity outside the cylinder, m; and unit vectors off
        the surface, with a last axis of 3.
    """
    length = float(np.linalg.norm(half))
    axis = (
        half / length if half[2] >= 0 else -half / length
    )  # from the centre to the end that can be seen
    across = x - centre[0]
    up = y - centre[1]
    depth = np.full(across.shape, -np.inf)
    normal = np.zeros((*across.shape, 3))
    along = across * axis[0] + up * axis[1]  # at the depth of the centre
    flat = 1 - axis[2] ** 2
    if flat > _ALONG**2:
        # flat d^2 - 2 along axis_z d + across^2 + up^2 - along^2 - radius^2 = 0
        root = (along * axis[2]) ** 2 - flat * (across**2 + up**2 - along**2 - radius**2)
        d = (along * axis[2] + np.sqrt(np.maximum(root, 0.0))) / flat
        on_axis = along + d * axis[2]
        seen = (root >= 0) & (np.abs(on_axis) <= length)
        point = np.stack([across, up, d], axis=-1)
        depth[seen] = d[seen]
        normal[seen] = ((point - on_axis[..., None] * axis) / radius)[seen]
    if axis[2] > _ALONG:
        d = (length - along) / axis[2]
        beside = across**2 + up**2 + d**2 - length**2
        end = (beside <= radius**2) & (d > depth)
        depth[end] = d[end]
        normal[end] = axis
    return depth + centre[2], normal
