"""Switch: distance of the plates, and properties not stated in the source (thesis 8.1 and 8.4).

The rows give the positions of the cylinders between the plates and the widths of the open gaps.
They also give first peaks at sphere 21 with 10 cylinders, open gaps and friction, for other lengths
of the cylinders, rigid plates, and plates 15.95 and 16 mm apart.
"""

import math

import numpy as np
from switch_row import CYLINDER, FRICTION, SPHERE, STATES, SwitchRow

import granwave as gw

APART = 15.975e-3  # m: distance of the plates of the other rows
TOUCHING = (SPHERE + CYLINDER) / 2  # m: distance of the centres


def difference(row):
    """Text of the difference from the other rows; empty for the reference."""
    length = row.case.packing.grains.shape[-1].length
    parts = []
    if not math.isclose(length, SPHERE):
        parts.append(f"cylinders {1e3 * length:g} mm long")
    if row.case.boundary.sides_material is None:
        parts.append("rigid plates")
    if not math.isclose(row.height, APART, abs_tol=1e-6):
        parts.append(f"plates {1e3 * row.height:.4g} mm apart")
    return ", ".join(parts)


def select(runs):
    """Rows with cylinders; empty for a single scan, whose cylinders all open the gaps or are all
    loose.
    """
    found = [row for row in map(SwitchRow, runs) if row.n]
    return [found] if {row.state for row in found} >= set(STATES[1:3]) else []


def rows(found):
    opened = {round(row.height, 6): row for row in found if row.state == STATES[1]}
    loose = next(row for row in found if row.state == STATES[2])
    by_geometry = {"where": "thesis 8.4", "verification": True}
    not_stated = {"where": "thesis 8"}
    # fmt: off
    for height, row in sorted(opened.items()):
        formula = math.sqrt(4 * TOUCHING**2 - (row.height - CYLINDER) ** 2) - SPHERE
        yield gw.Row(f"Width of the open gaps, plates {1e3 * height:.5g} mm apart", "mm", where="thesis 8.1",
                     ours=1e3 * (np.diff(row.spheres).max() - SPHERE), theory=1e3 * formula, verification=True,
                     remark="The source value follows from formula 8.1, which is correct.")
    across = np.abs(loose.cylinders[0, 0])
    near, far = np.sort(np.abs(loose.spheres - loose.cylinders[0, 2]))[:2]
    along = math.sqrt(TOUCHING**2 - ((loose.height - CYLINDER) / 2) ** 2)
    for name, ours, theory in (
        ("Distance of a loose cylinder from its sphere, along the row", near, along),
        ("Gap between this cylinder and the other sphere", math.hypot(far, across) - TOUCHING,
         math.hypot(SPHERE - along, (loose.height - CYLINDER) / 2) - TOUCHING),
    ):
        yield gw.Row(f"{name}, plates 16.5 mm apart", "mm", ours=1e3 * ours, theory=1e3 * theory,
                     remark="The value follows from the geometry of the source.", **by_geometry)
    yield gw.Row("Distance H0 of the plates at which all bodies just touch", "mm", where="thesis 8.1", theory=16.279,
                 ours=1e3 * (math.sqrt(4 * TOUCHING**2 - SPHERE**2) + CYLINDER), verification=True,
                 remark="The value follows from the diameters of the packing; the source does not "
                        "give it.")
    alike = [row for row in found if (row.state, row.n, row.friction) == (STATES[1], 10, FRICTION)]
    usual = next(row for row in alike if not difference(row))
    for row in alike:
        if what := difference(row):
            yield gw.Row(f"First peak at sphere 21, {row.name}, {what}", "N", ours=row.first[1],
                         remark="The source does not state this property.", **not_stated)
            yield gw.Row(f"First peak relative to the other chains, {row.name}, {what}",
                         ours=row.first[1] / usual.first[1],
                         remark="The other chains have cylinders of 9.5 mm length and plates of "
                                "aluminium, 15.975 mm apart.", **not_stated)
    # fmt: on
