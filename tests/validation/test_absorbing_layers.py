"""Reflections from the bottom of a packing, compared with a packing from whose bottom no wave
returns; the page on boundaries prints the numbers.
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
import pytest

import granwave as gw

PAGE = Path(__file__).parents[2] / "docs/howto/boundaries.md"
LAYERS = 8
DEEP = 26  # layers; the wave returns from this depth after 0.75 ms
END = 7e-4
VELOCITY = 5.0
SPACING = 0.01 * np.sqrt(2 / 3)
BOTTOMS = {
    "free surface": (0, {"boundary.bottom": "free"}),
    "rigid wall": (0, {}),
    "damper of 1e4 N s/m": (0, {"boundary.bottom": {"damper": {"damping": 1e4}}}),
    "3 damped layers, 4e4 1/s": (3, {"absorb": [{"layers": 3, "rate": 4e4}]}),
    "6 damped layers, 2e4 1/s": (6, {"absorb": [{"layers": 6, "rate": 2e4}]}),
    "9 damped layers, 2e4 1/s": (9, {"absorb": [{"layers": 9, "rate": 2e4}]}),
    "6 damped layers, 2e5 1/s": (6, {"absorb": [{"layers": 6, "rate": 2e5}]}),
}


def velocities(directory: Path, layers: int, changes: dict) -> tuple[np.ndarray, np.ndarray]:
    """Times of the snapshots, and velocities of the spheres in the first layers at these times."""
    case = gw.case(
        "fcc-small",
        {"packing.size": [20, 20, layers], "run.end_time": END, "run.frames": 250, **changes},
    )
    run = gw.run(case, directory=directory, figures=False)
    places = run.spheres[["position_x", "position_y", "position_z"]]
    depth = places["position_z"] - places["position_z"].min()
    order = places[depth < (LAYERS - 0.5) * SPACING].round(5)
    order = order.sort_values(["position_z", "position_y", "position_x"])
    fields = run.fields.velocity.sel(id=order.index.to_list()).transpose("time", "id", "axis")
    return fields.time.values, fields.values


@functools.cache
def deep(directory: Path) -> tuple[np.ndarray, np.ndarray]:
    return velocities(directory, DEEP, {})


@pytest.mark.validation
@pytest.mark.parametrize("bottom", BOTTOMS)
def test_reflections_are_as_printed(bottom, tmp_path, tmp_path_factory):
    """Within the digits of the page."""
    more, changes = BOTTOMS[bottom]
    expected_at, expected = deep(tmp_path_factory.getbasetemp() / "deep")
    at, found = velocities(tmp_path / "run", LAYERS + more, changes)
    rows = found.reshape(len(at), -1).T
    found = np.array([np.interp(expected_at, at, row) for row in rows]).T
    expected = expected.reshape(len(expected_at), -1)
    reflected = ((found - expected) ** 2).sum(axis=1).max()
    share = reflected / VELOCITY**2  # the spheres have one mass
    (line,) = [line for line in PAGE.read_text().splitlines() if line.startswith(f"| {bottom}")]
    assert 100 * share == pytest.approx(float(line.split("|")[2].split()[0]), rel=0.05)
