"""Orthographic rendering of many spheres, and of cylinders among them, with shading.

Equal spheres that do not overlap hide one another in the order of the distances of their centres (the plane midway
between two of them separates them), so that drawing the farthest first is exact. Cylinders are then drawn where they
lie before what is drawn already, pixel by pixel. A first pass at low
resolution finds the visible grains; only these are drawn at full resolution. The light comes from above the viewer's
left shoulder, and gaps that lie deeper than their surroundings are darkened.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_OVERSAMPLING = 2  # rendered pixels along each side of a pixel of the picture
_COARSE = 7.0  # pixels across a sphere in the first pass
_LIGHT = np.array([-0.45, 0.65, 0.62])  # right, up, towards the viewer
_AMBIENT, _DIFFUSE, _GLOSS = 0.42, 0.62, 0.16
_OCCLUSION = 0.5  # darkening of points one diameter deeper than their surroundings
_SHARPNESS = 5  # binary logarithm of the exponent of the gloss
_BLUR = 4  # pixels to a radius when averaging the surroundings
_BLOCK = 16384  # pixels that are shaded at a time, whose numbers fit into the processor's cache
_LINES = 8  # of the picture that are coloured at a time, likewise


@dataclass(frozen=True, eq=False)
class Camera:
    """Orthographic camera.

    Attributes
    ----------
    right, up, towards
        Orthonormal axes of the picture: to its right, to its top, towards the viewer; (3,) each.
    """

    right: NDArray[np.float64]
    up: NDArray[np.float64]
    towards: NDArray[np.float64]

    @classmethod
    def looking(cls, azimuth: float, elevation: float, vertical: NDArray[np.float64]) -> Camera:
        """Make a camera at an azimuth about the vertical and an elevation above the horizon, degrees.

        Parameters
        ----------
        vertical
            Unit vector upwards in the picture: (3,), along +z or -z.
        """
        turn, rise = math.radians(azimuth), math.radians(elevation)
        level = np.array([math.cos(turn), math.sin(turn), 0.0])
        towards = math.cos(rise) * level + math.sin(rise) * vertical
        right = np.cross(vertical, level)
        return cls(right, np.cross(towards, right), towards)

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the coordinates (right, up, towards the viewer) of points: (n, 3), m."""
        return points @ np.stack([self.right, self.up, self.towards], axis=1)


@dataclass(frozen=True, eq=False)
class Picture:
    """Coloured spheres and cylinders.

    Attributes
    ----------
    pixels
        Red, green, blue and alpha from 0 to 1: (n_rows, n_columns, 4), the first row at the top.
    extent
        Left, right, bottom and top in the plane of the picture, m.
    visible
        Rows of the spheres that can be seen, rising: (n_visible,).
    """

    pixels: NDArray[np.float32]
    extent: tuple[float, float, float, float]
    visible: NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Surface:
    """Spheres as they are seen and lit, without colours: most of the work, and the same for all quantities.

    Attributes
    ----------
    front
        Row in ``visible`` of the sphere that each rendered pixel shows, -1 for none: (n_rows, n_columns), from the
        bottom up.
    brightness, gloss
        Factor of the colour of each rendered pixel, and what is added to it, 0 for none: (n_rows, n_columns).
    visible
        Rows of the spheres that can be seen, rising: (n_visible,).
    extent
        Left, right, bottom and top in the plane of the picture, m.
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
) -> Surface:
    """Find what can be seen of spheres and cylinders, and light it.

    Parameters
    ----------
    centres
        Centres: (n_spheres, 3), m.
    radius
        Common radius, or that of each: (n_spheres,), m.
    camera
        Camera.
    width
        Width of the picture, pixels.
    axes
        From the centres to the ends of the cylinders, 0 for spheres: (n_spheres, 3), m. By default all are spheres.
    """
    seen = camera.project(centres)
    radii = np.broadcast_to(np.asarray(radius, dtype=float), len(seen))
    halves = np.zeros_like(seen) if axes is None else camera.project(axes)
    reach = radii[:, None] + np.abs(halves[:, :2])
    margin = 0.1 * float(radii.max())
    low = (seen[:, :2] - reach).min(axis=0) - margin
    high = (seen[:, :2] + reach).max(axis=0) + margin
    coarse = _painted_grains(seen, radii, halves, low, high, 2 * float(np.median(radii)) / _COARSE).front
    visible = np.unique(coarse[coarse >= 0]).astype(np.int64)
    pitch = (high[0] - low[0]) / (width * _OVERSAMPLING)
    found = _painted_grains(seen[visible], radii[visible], halves[visible], low, high, pitch)
    found = found.cropped(found.front.shape[0] // _OVERSAMPLING * _OVERSAMPLING, width * _OVERSAMPLING)
    fine = found.front
    top = low[1] + fine.shape[0] * pitch
    extent = (float(low[0]), float(low[0] + fine.shape[1] * pitch), float(low[1]), float(top))
    rows, columns = (place.astype(np.int32) for place in np.nonzero(fine >= 0))
    brightness, gloss = np.zeros((2, *fine.shape), dtype=np.float32)
    lit = _light(found, rows, columns, seen[visible], radii[visible], low, pitch)
    brightness[rows, columns], gloss[rows, columns] = lit
    return Surface(fine, brightness, gloss, visible, extent)


def painted(surface: Surface, colours: NDArray[np.float64]) -> Picture:
    """Colour a surface; ``colours``: red, green, blue of all spheres from 0 to 1, (n_spheres, 3)."""
    n_rows, n_columns = (size // _OVERSAMPLING for size in surface.front.shape)
    shown = np.concatenate([colours[surface.visible], np.zeros((1, 3))]).astype(np.float32)  # the last one: blank, -1
    pixels = np.empty((n_rows, n_columns, 4), dtype=np.float32)  # premultiplied by alpha
    for first in range(0, n_rows, _LINES):
        lines = slice(first, first + _LINES)
        rendered = slice(_OVERSAMPLING * first, _OVERSAMPLING * (first + _LINES))
        front, brightness, gloss = surface.front[rendered], surface.brightness[rendered], surface.gloss[rendered]
        for channel in range(3):
            lit = np.take(shown[:, channel], front, mode="wrap")  # -1 is the last one
            lit *= brightness
            lit += gloss
            pixels[lines, :, channel] = _mean_of_squares(np.clip(lit, 0.0, 1.0, out=lit))
        pixels[lines, :, 3] = _mean_of_squares((front >= 0).astype(np.float32))
    pixels[..., :3] /= np.maximum(pixels[..., 3:], 1e-6)
    return Picture(np.clip(pixels[::-1], 0.0, 1.0), surface.extent, surface.visible)


def _mean_of_squares(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the means over the rendered pixels of each pixel of the picture."""
    rows = sum((values[n::_OVERSAMPLING] for n in range(1, _OVERSAMPLING)), values[::_OVERSAMPLING])
    both = sum((rows[:, n::_OVERSAMPLING] for n in range(1, _OVERSAMPLING)), rows[:, ::_OVERSAMPLING])
    return np.asarray(both / np.float32(_OVERSAMPLING**2))


@dataclass(frozen=True, eq=False)
class _Grains:
    """Grains as they are painted, before they are lit.

    Attributes
    ----------
    front
        Row of the grain that each pixel shows, -1 for none: (n_rows, n_columns), from the bottom up.
    depth, normal
        Distance towards the viewer, m, and direction of the surface, where a cylinder is shown: (n_rows, n_columns) and
        (n_rows, n_columns, 3); None without cylinders.
    is_cylinder
        True for cylinders: (n_grains,).
    """

    front: NDArray[np.int32]
    depth: NDArray[np.float32] | None
    normal: NDArray[np.float32] | None
    is_cylinder: NDArray[np.bool_]

    def cropped(self, n_rows: int, n_columns: int) -> _Grains:
        """Return the first rows and columns."""
        depth, normal = (None if one is None else one[:n_rows, :n_columns] for one in (self.depth, self.normal))
        return _Grains(self.front[:n_rows, :n_columns], depth, normal, self.is_cylinder)


def _painted_grains(
    seen: NDArray[np.float64],
    radius: NDArray[np.float64],
    halves: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    pitch: float,
) -> _Grains:
    """Paint spheres, and then cylinders where they are nearer to the viewer."""
    is_cylinder: NDArray[np.bool_] = np.asarray(halves.any(axis=1))
    spheres = np.flatnonzero(~is_cylinder)
    front = _front(seen[spheres], radius[spheres], low, high, pitch)
    if len(spheres) == len(seen):
        return _Grains(front, None, None, is_cylinder)
    front = np.where(front >= 0, spheres.astype(np.int32)[front] if len(spheres) else -1, -1).astype(np.int32)
    depth = np.full(front.shape, -np.inf, dtype=np.float32)
    normal = np.zeros((*front.shape, 3), dtype=np.float32)
    rows, columns = np.nonzero(front >= 0)
    sphere = front[rows, columns]
    across = (low + (np.stack([columns, rows], axis=1) + 0.5) * pitch - seen[sphere, :2]) ** 2
    depth[rows, columns] = seen[sphere, 2] + np.sqrt(np.maximum(radius[sphere] ** 2 - across.sum(axis=1), 0.0))
    for grain in np.flatnonzero(is_cylinder):
        reach = radius[grain] + np.abs(halves[grain, :2])
        first = np.maximum(np.floor((seen[grain, :2] - reach - low) / pitch).astype(int), 0)
        last = np.ceil((seen[grain, :2] + reach - low) / pitch).astype(int) + 1
        box = slice(first[1], last[1]), slice(first[0], last[0])
        y, x = (low[way] + (np.arange(front.shape[1 - way])[box[1 - way]] + 0.5) * pitch for way in (1, 0))
        found, direction = surface_of_cylinder(seen[grain], halves[grain], radius[grain], x, y)
        nearer = found > depth[box]
        front[box][nearer], depth[box][nearer], normal[box][nearer] = grain, found[nearer], direction[nearer]
    return _Grains(front, depth, normal, is_cylinder)


def _front(
    seen: NDArray[np.float64],
    radius: NDArray[np.float64],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
    pitch: float,
) -> NDArray[np.int32]:
    """Return the row of the sphere that each pixel shows, -1 for none: (n_rows, n_columns), from the bottom up."""
    shape = tuple(math.ceil(extent) + 1 for extent in (high[::-1] - low[::-1]) / pitch)
    order = np.argsort(seen[:, 2], kind="stable").astype(np.int32)  # the farthest first
    place = (seen[order, :2] - low) / pitch - 0.5  # in pixels; integers are centres of pixels
    reach = radius[order] / pitch
    front = np.full(shape, -1, dtype=np.int32)
    if not len(order):
        return front
    if len(order) < 4 * np.median(reach) ** 2:
        _paint_by_sphere(front, place, reach)
    else:
        _paint_by_pixel(front, place, reach)
    front[front >= 0] = order[front[front >= 0]]
    return front


def _paint_by_sphere(front: NDArray[np.int32], place: NDArray[np.float64], reach: NDArray[np.float64]) -> None:
    """Write the number of each sphere into its pixels, sphere by sphere: fast for few large ones."""
    corner = np.maximum(np.floor(place - reach[:, None]).astype(int), 0)
    beyond = np.ceil(place + reach[:, None]).astype(int) + 1
    for n, (left, bottom) in enumerate(corner):
        block = front[bottom : beyond[n, 1], left : beyond[n, 0]]
        rows = (np.arange(block.shape[0]) + bottom - place[n, 1]) ** 2
        columns = (np.arange(block.shape[1]) + left - place[n, 0]) ** 2
        block[rows[:, None] + columns < reach[n] ** 2] = n


def _paint_by_pixel(front: NDArray[np.int32], place: NDArray[np.float64], reach: NDArray[np.float64]) -> None:
    """Do the same for one pixel of all spheres at a time: fast for many small ones."""
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
    found: _Grains,
    rows: NDArray[np.int32],
    columns: NDArray[np.int32],
    seen: NDArray[np.float64],
    radius: NDArray[np.float64],
    low: NDArray[np.float64],
    pitch: float,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return brightness and gloss of the pixels at rows and columns: (n_pixels,) each."""
    blocks = [slice(start, start + _BLOCK) for start in range(0, len(rows), _BLOCK)]
    front = found.front
    normal = np.empty((len(rows), 3), dtype=np.float32)
    depth = np.full(front.shape, float(seen[:, 2].min()), dtype=np.float32)
    for block in blocks:
        row, column, one = rows[block], columns[block], normal[block]
        sphere = front[row, column]
        own = radius[sphere]
        one[:, 0] = (low[0] + (column + 0.5) * pitch - seen[sphere, 0]) / own
        one[:, 1] = (low[1] + (row + 0.5) * pitch - seen[sphere, 1]) / own
        one[:, 2] = np.sqrt(np.clip(1 - one[:, 0] ** 2 - one[:, 1] ** 2, 0.0, 1.0))
        depth[row, column] = seen[sphere, 2] + own * one[:, 2]
        if found.normal is not None and found.depth is not None:
            cylinder = found.is_cylinder[sphere]
            row, column = row[cylinder], column[cylinder]
            one[cylinder], depth[row, column] = found.normal[row, column], found.depth[row, column]
    light = (_LIGHT / np.linalg.norm(_LIGHT)).astype(np.float32)
    half = light + np.array([0.0, 0.0, 1.0], dtype=np.float32)
    half /= np.linalg.norm(half)
    usual = float(np.median(radius))
    around = _Surroundings(depth, usual / pitch)
    brightness, gloss = np.empty(len(rows), dtype=np.float32), np.empty(len(rows), dtype=np.float32)
    for block in blocks:
        row, column, one = rows[block], columns[block], normal[block]
        bright = _AMBIENT + _DIFFUSE * np.clip(one @ light, 0.0, None)
        covered = around.at(row, column) - depth[row, column]
        bright *= 1 - _OCCLUSION * np.clip(covered / (2 * usual), 0.0, 1.0)
        shine = np.clip(one @ half, 0.0, None)
        for _ in range(_SHARPNESS):
            shine *= shine
        brightness[block], gloss[block] = bright, shine * _GLOSS
    return brightness, gloss


class _Surroundings:
    """Mean depth around pixels, weighed by a Gaussian function, at a coarser resolution for larger spheres.

    Parameters
    ----------
    depth
        Depth of all pixels: (n_rows, n_columns), m.
    reach
        Standard deviation of the Gaussian function, pixels.
    """

    def __init__(self, depth: NDArray[np.float32], reach: float) -> None:
        self.step = max(1, int(reach / _BLUR))
        coarse = depth[:: self.step, :: self.step]
        n_rows, n_columns = coarse.shape
        blurred = _weights(n_rows, reach / self.step) @ coarse @ _weights(n_columns, reach / self.step).T
        place = np.minimum(np.arange(depth.shape[0], dtype=np.float32) / self.step, n_rows - 1)
        base = np.minimum(place.astype(np.int64), max(n_rows - 2, 0))
        part = (place - base)[:, None]
        above = np.minimum(base + 1, n_rows - 1)
        self.along_rows: NDArray[np.float32] = blurred[base] * (1 - part) + blurred[above] * part

    def at(self, rows: NDArray[np.int32], columns: NDArray[np.int32]) -> NDArray[np.float32]:
        """Return the mean depth at pixels."""
        if self.step == 1:
            return self.along_rows[rows, columns]
        last = self.along_rows.shape[1] - 1
        base = np.minimum(columns // self.step, max(last - 1, 0))
        part = np.minimum((columns - base * self.step) / np.float32(self.step), 1.0).astype(np.float32)
        left, right = self.along_rows[rows, base], self.along_rows[rows, np.minimum(base + 1, last)]
        return left + (right - left) * part


def _weights(n: int, reach: float) -> NDArray[np.float32]:
    """Return the weights of all places for the mean at each place: (n, n)."""
    place = np.arange(n, dtype=np.float32)
    weights = np.exp(-0.5 * ((place[:, None] - place) / np.float32(reach)) ** 2)
    return weights / weights.sum(axis=1, keepdims=True)


_ALONG = 1e-6  # component of the axis towards the viewer, or across, below which there is none


def surface_of_cylinder(
    centre: NDArray[np.float64],
    half: NDArray[np.float64],
    radius: float,
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find what can be seen of a cylinder with flat ends.

    A point of the mantle lies at the distance of the radius from the axis, a quadratic equation for its depth; of the
    two ends only that towards the viewer can be seen.

    Parameters
    ----------
    centre, half
        Centre, and the vector from it to one end, not 0: (3,), m; to the right, up and towards the viewer.
    radius
        Radius, m.
    x, y
        Places to the right and upwards: (n_x,) and (n_y,), m.

    Returns
    -------
    depth, normal
        Place towards the viewer, minus infinity beside the cylinder: (n_y, n_x), m; and unit vectors off the surface:
        (n_y, n_x, 3).
    """
    length = float(np.linalg.norm(half))
    axis = half / length if half[2] >= 0 else -half / length  # from the centre to the end that can be seen
    across, up = np.meshgrid(x - centre[0], y - centre[1])
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
        depth[end], normal[end] = d[end], axis
    return depth + centre[2], normal
