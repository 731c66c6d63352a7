"""Surface of a cylinder as a camera sees it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
