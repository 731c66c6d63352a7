"""Benchmarks and chains of other authors, damping, and the contact law compared with finite
elements: rows of small and synthetic runs.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.registry import load_study
from tests.helpers.made_up.synthetic_contact import RADIUS, write_contact
from tests.helpers.programs.scripts import columns, row, study_of

FOLDER = Path(__file__).parents[2] / "reproductions" / "benchmarks"
OXIDE = {"youngs_modulus": 3.8e11, "poisson_ratio": 0.23, "density": 4000}
CASE = {
    "material": OXIDE,
    "contact.law": "hertz",
    "contact.friction": 0.092,
    "packing.diameter": 0.005,
    "load.velocity": 3.9,
    "run.end_time": 3e-5,
    "run.frames": 2,
}


def rebound_of(run):
    """Impact of the run, in the form of the script."""
    return load_study(str(FOLDER / "impacts_oblique.py")).Rebound(run)


@pytest.mark.parametrize("angle", [10, 60])
def test_rebound_beside_partial_slip(tmp_path: Path, angle: float) -> None:
    """Sliding follows the theory of rigid bodies; if part of the circle sticks, partial slip gives
    more spin than one spring.
    """
    run = gw.run(
        "sphere-on-wall", CASE | {"load.angle": angle}, directory=tmp_path / "run", progress=False
    )
    one = rebound_of(run)
    normal, across, spin = one.with_partial_slip()
    energy = 0.5 * 0.4 * run.case.sphere_mass * one.radius**2 * one.spin_after**2
    assert run["energy_rotational_J"] == pytest.approx(energy, rel=5e-3)
    assert normal == pytest.approx(one.normal_after, rel=1e-3)
    if angle == 60:
        change = 2 * 0.092 * 3.9 * math.cos(math.radians(60))
        assert across == pytest.approx(one.across - change, rel=1e-3)
        assert one.across_after == pytest.approx(across, rel=1e-3)
    else:
        assert 1.15 < spin / one.spin_after < 1.35


@pytest.mark.parametrize(
    ("angle", "loss"), [(3.94, None), (10, {"dashpot": {"restitution": 0.98}})]
)
def test_runs_with_partial_slip_follow_it(tmp_path: Path, angle: float, loss: object) -> None:
    case = (
        CASE
        | {"load.angle": angle, "contact.tangential": "partial_slip"}
        | ({"contact.loss": loss} if loss else {})
    )
    one = rebound_of(gw.run("sphere-on-wall", case, directory=tmp_path / "run", progress=False))
    _, across, spin = one.with_partial_slip()
    assert one.spin_after == pytest.approx(spin, rel=0.01)
    assert one.across_after == pytest.approx(across, rel=3e-3)


SHORT = {"run.end_time": 3e-4, "run.frames": 2, "output.history": 1000}


def test_tapered_chain_hands_on_less_than_hard_spheres(tmp_path: Path) -> None:
    """The last of identical beads receives nearly all energy; the last of tapered beads less than
    hard spheres would transmit.
    """
    shrinking = [{"index": [n], "diameter": 0.00952 * 0.9 ** (n - 1)} for n in range(2, 21)]
    runs = [
        gw.run(
            "elastic-impact",
            SHORT | {"packing.size": 20} | more,
            directory=tmp_path / f"{k}",
            progress=False,
        )
        for k, more in enumerate(({"run.end_time": 6e-4}, {"replace": shrinking}))
    ]
    study = study_of("benchmarks/chains_tapered.py", runs)
    last = [row for row in study.rows if row.quantity.startswith("Energy of the last bead")]
    assert [row.theory for row in last] == [1.0, pytest.approx(0.6234, abs=1e-3)]
    like, tapered = (row.ours or 0.0 for row in last)
    assert like > 0.95 and 0.2 < tapered < 0.35
    assert len(study.pictures) == 1


LOSSES = ({"time": 3e-7}, {"restitution": 0.9, "velocity": 1.0}, {"dashpot": {"restitution": 0.9}})
PAIR = {"packing.size": 2, "run.end_time": 2e-4, "run.frames": 2}
CHAIN = {"packing.size": 30, "run.end_time": 7e-4, "output.history": 1000, "run.frames": 2}


@pytest.mark.validation
def test_restitution_and_decay(tmp_path: Path) -> None:
    """Restitution agrees with the formulas; F^(-1/6), or for a dashpot ln F, is linear along a
    chain.
    """
    runs = [
        gw.run(
            "elastic-impact",
            changes | {"contact.loss": loss},
            directory=tmp_path / f"{k}{n}",
            progress=False,
        )
        for k, loss in enumerate(LOSSES)
        for n, changes in enumerate(
            (PAIR | {"load.velocity": 0.1}, PAIR | {"load.velocity": 1.0}, CHAIN)
        )
    ]
    study = study_of("losses/loss.py", runs)
    checked = [one for one in study.rows if one.verification]
    assert len(checked) == 8
    for one in checked:
        assert one.ours == pytest.approx(one.theory, abs=1e-3)
    for kind, law in (("time", "F^(-1/6)"), ("restitution", "F^(-1/6)"), ("dashpot", "ln F")):
        (decay,) = [
            one
            for one in study.rows
            if one.quantity.startswith("Largest force") and f", {kind} " in one.quantity
        ]
        assert decay.ours is not None and 0.6 < decay.ours < 0.95
        assert (
            law in decay.remark and float(decay.remark.partition(" by ")[2].partition(" %")[0]) < 2
        )
    assert columns(study)["time_restitution"].shape == (2,)


SCRIPT = "thesis/chapter_3/sphere_contact.py"


def contact(folder: Path, **changes: Any) -> gw.Run:
    return gw.Run(write_contact(folder, **changes))


def test_the_largest_difference_is_beside_the_claim(tmp_path: Path) -> None:
    unlike = {"name": "steel", "yield_strength": 1100e6}
    study = study_of(SCRIPT, [
        contact(tmp_path / "alike"), contact(tmp_path / "radii", difference=-0.09, partner=9.52e-3),
        contact(tmp_path / "unlike", material=unlike),
    ])  # fmt: skip
    assert row(
        study, "Deviation of finite elements from the law at 3 alpha_y, brass, equal"
    ).ours == pytest.approx(15)
    start = "Deviation of finite elements from the law from"
    worst = row(study, f"{start} 1 to 10 alpha_y: largest, brass, equal radii")
    assert (worst.source, worst.ours) == (6, pytest.approx(15))
    for name, claim, ours in (("equal radii", -6, -5), ("radii 2 to 1", None, -14)):
        least = row(study, f"{start} 10 alpha_y to 0.2 R*: smallest, brass, {name}")
        assert (least.source, least.ours) == (claim, pytest.approx(ours)), (
            "the source states its error for identical spheres"
        )
    assert row(study, f"{start} 1 to 10 alpha_y: largest, brass and steel").source is None
    deep = row(study, "Finite elements at 0.19 R*, brass, radii 2 to 1")
    assert deep.ours == pytest.approx(100 * (0.86 / 0.95 - 1)) and deep.source is None
    assert row(study, "Smallest unloading exponent, brass, equal radii").source == 1.3
    assert row(study, "Smallest unloading exponent, brass, radii 2 to 1").source is None
    assert row(study, "Fraction of the plastic dissipation").ours == pytest.approx(
        0.3 / (0.3 + 2 * 0.1)
    )


def test_a_force_on_disk_moves_every_row_that_measures_it(tmp_path: Path) -> None:
    before, after = (
        study_of(SCRIPT, [contact(tmp_path / f"{force:g}", force=force)]).rows
        for force in (1.0, 1.1)
    )
    measured = [
        pair
        for pair in zip(before, after, strict=True)
        if pair[0].quantity.startswith("Deviation of finite elements")
    ]
    assert len(measured) == 6
    for first, second in measured:
        assert 1 + second.ours / 100 == pytest.approx(1.1 * (1 + first.ours / 100))


def test_pressure_and_area_are_compared_with_thorntons_law(tmp_path: Path) -> None:
    study = study_of(SCRIPT, [contact(tmp_path / "alike")])
    assert row(study, "Largest pressure / yield strength").ours == pytest.approx(1.6 * 16 / 15)
    assert row(study, "Largest pressure / Thornton's").ours == pytest.approx(1.6)
    assert row(study, "Contact area / Thornton's contact area").ours == pytest.approx(2)
    force = row(study, "Force / force of Thornton's")
    overlap = 0.19 * RADIUS
    law = 5e9 * overlap**1.2 / (16 / 15 * 550e6 * np.pi * RADIUS * overlap)
    assert (force.source, force.ours, force.theory) == (
        4.7,
        pytest.approx(0.95 * law, rel=1e-3),
        pytest.approx(law, rel=1e-3),
    )
