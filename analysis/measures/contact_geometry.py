"""Positions of contacts of a run: points, normals, depths and distances from the impact axis."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from granwave.analysis.result.reader import Result

#: Units of the columns, in their order.
UNITS = {
    "x": "m",
    "y": "m",
    "z": "m",
    "nx": "1",
    "ny": "1",
    "nz": "1",
    "depth": "m",
    "distance": "m",
}


def contact_geometry(result: Result) -> dict[str, NDArray[np.float64]]:
    """Return the positions of the contacts of a run at the start.

    The point of a contact lies on the line between both centres, and divides it in the ratio of the
    radii; across periodic sides it is next to the first sphere. The same holds for cylinders.

    Returns
    -------
    dict
        ``x``, ``y``, ``z``: point of the contact, m; ``nx``, ``ny``, ``nz``: unit normal from the
        first sphere to the second; ``depth`` of the point below the centre of the impacted sphere,
        m; ``distance`` of the point from the impact axis, m. Each (n_contacts,).
    """
    first, second = result.ends.T
    position = result["spheres/position"]
    radius = result["spheres/radius"]
    step = position[second] - position[first]
    step[:, :2] = result.across(step[:, :2])
    length = np.linalg.norm(step, axis=1, keepdims=True)
    normal = np.divide(step, length, out=np.zeros_like(step), where=length > 0)
    fraction = radius[first] / (radius[first] + radius[second])
    point = position[first] + fraction[:, None] * step
    columns = {}
    for axis, name in enumerate("xyz"):
        columns[name] = point[:, axis]
    for axis, name in enumerate("xyz"):
        columns[f"n{name}"] = normal[:, axis]
    columns["depth"] = point[:, 2] - result.origin[2]
    columns["distance"] = result.distance_from_axis(point)
    return columns
