"""Record of a row of grains with others beside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import granwave as gw
from granwave.measures import GrainRow, decay_rate


def test_row_in_a_tube(tmp_path: Path) -> None:
    """Contacts of the beads alone, from 1; rings between wall and beads in balance."""
    changes = {
        "packing.size": 16, "grains.1.repeat.times": 15, "hold.1.index": [1, 16], "load.index": [3],
        "precompression": {"kind": "walls", "tube": 1.425e-5}, "run.end_time": 1.2e-4,
        "output.probes": [{"contact": [5, 6]}, {"sphere": 5}],
    }  # fmt: skip
    run = gw.run("confined-row", changes, directory=tmp_path, progress=False)
    row = GrainRow(run)
    assert list(row.ids) == list(range(1, 17)) and len(row.beside) == 15 * 8 and row.struck == 3
    peak, when = row.of_contacts("peak_force"), row.of_contacts("time_peak")
    ((contact, force),) = row.contact_forces.items()
    assert contact == 5 and force.max() == pytest.approx(peak[4], rel=0.02)
    assert 3 < row.passed < 15 and (np.diff(when[2 : row.passed]) > 0).all()
    small, big, inner = 0.005147186258 / 2, 0.0075, 0.009298716066 - 1.425e-5
    modulus, ring = 115e9 / (1 - 0.3**2), 0.006725122938 - row.inward
    overlap = big + small - np.hypot(ring, big)
    push = 4 / 3 * modulus / 2 * np.sqrt(big * small / (big + small)) * 2 * overlap**1.5 * ring / np.hypot(ring, big)
    push += (
        4 / 3 * modulus / 2 * np.sqrt(small / 2) * 2 * np.sin(np.pi / 8) * (2 * row.inward * np.sin(np.pi / 8)) ** 1.5
    )
    wall = 4 / 3 * modulus * np.sqrt(gw.theory.elliptic_radius(1 / small, 1 / small - 1 / inner))
    assert push == pytest.approx(wall * (ring + small - inner) ** 1.5, rel=1e-3)


def test_rate_of_a_decay() -> None:
    x = np.arange(60, 201)
    assert decay_rate(x, 7 * np.exp(-2e-3 * x)) == pytest.approx(2e-3)
    assert np.isnan(decay_rate(x, x - 60.0)) and np.isnan(decay_rate([1], [1]))
