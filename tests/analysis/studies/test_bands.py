"""The tunnel of thesis 7.2: its static state, stiffness of the walls, bands and gaps, against another program."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from granwave.analysis.studies.bands.tunnel import brass_tunnel
from granwave.lammps_inputs.case.material import material


@pytest.mark.parametrize(
    ("approach", "overlaps", "wall", "edges"),
    [
        (-1.8e-5, (3.673e-7, 5.816e-8, 5.54e-10), 1.789e8, (31795, 42051, 68093, 354119)),
        (0.0, (3.307e-7, 1.092e-7, 1.366e-9), 1.872e8, (37222, 49229, 68647, 362876)),
        (3e-5, (2.489e-7, 1.873e-7, 2.949e-9), 1.950e8, (42592, 56331, 67350, 370989)),
    ],
)
def test_tunnel(approach, overlaps, wall, edges):
    tunnel = brass_tunnel(approach)
    np.testing.assert_allclose(tunnel.overlaps, overlaps, rtol=1e-3)
    assert tunnel.network.supports.stiffness[0] / 2 == pytest.approx(wall, rel=5e-4)
    found = tunnel.edges
    np.testing.assert_allclose([found[0, 1], *found[1], found[2, 0]], edges, rtol=1e-4)
    assert tunnel.row_frequency == pytest.approx(31637, rel=1e-5)


@pytest.mark.parametrize(
    ("sphere", "cylinder", "ratio", "edges"),
    [
        ("brass", "brass", 0.3, [(6.28, 6.98), (7.03, 7.07), (6.93, 7.85)]),
        ("steel", "aluminium", 0.5, [(3.85, 4.33), (5.81, 6.52), (7.01, 7.87)]),
        ("aluminium", "steel", 0.65, [(2.41, 5.21), (2.78, 6.00), (3.12, 6.74)]),
    ],
)
def test_gaps_of_other_tunnels(sphere, cylinder, ratio, edges):
    """Figure 7.8: top of the acoustic and bottom of the optical band, 1e4 rad/s, at a = -2e-5, 0 and 3e-5."""
    of_source = {
        "brass": material("brass"),
        "steel": dataclasses.replace(material("steel"), youngs_modulus=210e9, poisson_ratio=0.3, density=7800.0),
        "aluminium": dataclasses.replace(material("aluminium"), youngs_modulus=70e9, poisson_ratio=0.3, density=2700.0),
    }
    for approach, (top, bottom) in zip((-2e-5, 0.0, 3e-5), edges, strict=True):
        tunnel = dataclasses.replace(
            brass_tunnel(approach, ratio), sphere=of_source[sphere], cylinder=of_source[cylinder]
        )
        assert tunnel.edges[0, 1] / 1e4 == pytest.approx(top, abs=0.006)
        assert tunnel.edges[1, 0] / 1e4 == pytest.approx(bottom, abs=0.06 if bottom == 11.1 else 0.006)
