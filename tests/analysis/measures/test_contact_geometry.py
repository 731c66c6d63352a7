"""Geometry of contacts: points, normals, depths and distances."""

from __future__ import annotations

import numpy as np
import pytest

from granwave.analysis import Result, write_result
from granwave.analysis.measures.contact_geometry import UNITS, contact_geometry
from tests.helpers.made_up import synthetic


@pytest.mark.parametrize("sides", ["free", "periodic"])
def test_a_contact_is_a_radius_from_both_spheres(tmp_path, sides):
    """Across periodic sides the point of contact is next to the first sphere."""
    case = synthetic.make_case(size=(6, 6, 4), boundary={"sides": sides})
    write_result(synthetic.write_run(tmp_path, case))
    with Result(tmp_path) as result:
        columns = contact_geometry(result)
        first, second = result.ends.T
        touching = result["contacts/touching"]
        position = result["spheres/position"]
        radius = result["spheres/radius"]
        axis = result.impact_axis
        origin = result.origin
    assert columns.keys() == UNITS.keys()
    point = np.stack([columns[name] for name in "xyz"], axis=1)
    normal = np.stack([columns[f"n{name}"] for name in "xyz"], axis=1)
    assert np.linalg.norm(normal, axis=1) == pytest.approx(1.0)
    assert point == pytest.approx(position[first] + radius[first, None] * normal, abs=1e-8)
    assert columns["depth"] == pytest.approx(point[:, 2] - origin[2])
    if sides == "free":
        assert point == pytest.approx(position[second] - radius[second, None] * normal, abs=1e-8)
        assert columns["distance"] == pytest.approx(np.hypot(*(point[:, :2] - axis).T))
    assert touching.any()
