"""Impacts on packings and blocks, of the thesis, chapter 5: small runs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from tests.helpers.scripts import row, study_of

SMALL = {"packing.size": [8, 8, 6], "run.frames": 2, "run.end_time": 2e-4}
BLOCK = {"run.elements": 1500}


def run(directory: Path, name: str, fixed: dict[str, Any], varied: dict[str, Any]) -> gw.Run:
    """Run of a scan, with the values that vary."""
    path = directory / f"{name}{len(list(directory.iterdir()))}"
    return gw.Run(gw.run(name, fixed | varied, directory=path, progress=False).directory, varied)


@pytest.fixture(scope="module")
def packings(tmp_path_factory: pytest.TempPathFactory) -> list[gw.Run]:
    """Brass from 4 to 40 m/s, three spheres with the energy of one, and twice the modulus at equal normalised velocity."""
    folder = tmp_path_factory.mktemp("packings")
    varied: list[dict[str, Any]] = [
        {"load.velocity": velocity, "load.spheres": 1} for velocity in (4.0, 10.0, 16.0, 40.0)
    ]
    varied.append({"load.velocity": 16 / math.sqrt(3), "load.spheres": 3})
    varied.append({"load.velocity": 4.0, "material.youngs_modulus": 230e9})
    return [run(folder, "fcc-impact", SMALL, one) for one in varied]


@pytest.fixture(scope="module")
def blocks(tmp_path_factory: pytest.TempPathFactory) -> list[gw.Run]:
    """Punches of 10 and 100 g with equal energies, and a block of twice the modulus."""
    folder = tmp_path_factory.mktemp("blocks")
    varied = [
        {"punch.mass": mass, "punch.velocity": v / math.sqrt(10 * mass)} for mass in (0.01, 0.1) for v in (6.0, 16.0)
    ]
    varied.append({"material.youngs_modulus": 230e9, "punch.velocity": 16 / math.sqrt(2)})
    return [run(folder, "half-space", BLOCK, one) for one in varied]


def test_packings_collapse(packings: list[gw.Run]) -> None:
    study = study_of("thesis/chapter_5/packings.py", packings)
    normalised = [one for one in study.rows if one.quantity == "Velocity, normalised"]
    assert [(one.source, one.theory) for one in normalised] == [
        (source, pytest.approx(source, rel=2e-3)) for source in (37.9, 94.9, 379)
    ]
    assert row(study, "Largest difference in dissipated share at 1 equal").ours < 2e-3
    assert 0 < row(study, "Largest difference in dissipated share for 1, 3 struck").ours < 0.1
    assert row(study, "D2").ours == pytest.approx(0.5, abs=0.05)


def test_forces_and_energies_of_spheres(packings: list[gw.Run]) -> None:
    """The first layers bear most in the preferred directions; few spheres do most of the dissipation."""
    study = study_of("thesis/chapter_5/spheres.py", packings[:5])
    energy = row(study, "Energy of a sphere at 16 m/s")
    assert energy.ours == pytest.approx(math.pi / 6 * 1e-6 * 8500 * 16**2 / 2) and energy.source == 0.576
    assert row(study, "Layers whose largest force").ours >= 3
    assert 0.1 < row(study, "Force straight below").ours < 0.4
    assert 10 < row(study, "Velocity of the largest force").ours < 40
    assert row(study, "Spheres that do half").ours < 10
    assert len(study.pictures) == 1


def test_blocks_beside_a_packing(packings: list[gw.Run], blocks: list[gw.Run]) -> None:
    study = study_of("thesis/chapter_5/blocks.py", [*packings[:4], *blocks])
    assert row(study, "Energy input over").ours == pytest.approx(550e6**2 * 0.01**3 / 115e9)
    share = row(study, "Dissipated share of a block")
    assert (share.source, share.ours, share.bound) == (0.7, blocks[3]["dissipated_fraction"], True)
    assert row(study, "Largest difference in a block's share between materials").ours < 5
    light, heavy = (one["dissipated_fraction"] for one in (blocks[1], blocks[3]))
    masses = "Largest difference in a block's share between punches of unlike mass, inputs above"
    assert row(study, masses).ours == pytest.approx(abs(light - heavy))
    assert 0.2 < row(study, "Volume that dissipates").ours < 5
