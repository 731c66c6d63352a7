"""The contact law beside finite elements, of the thesis, sections 2.1 and 3.1: made-up runs with known differences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from tests.helpers.scripts import row, study_of
from tests.helpers.synthetic_contact import RADIUS, write_contact

SCRIPT = "thesis/chapter_3/sphere_contact.py"


def contact(folder: Path, **changes: Any) -> gw.Run:
    return gw.Run(write_contact(folder, **changes))


def test_the_largest_difference_is_beside_the_claim(tmp_path: Path) -> None:
    unlike = {"name": "steel", "yield_strength": 1100e6}
    study = study_of(SCRIPT, [
        contact(tmp_path / "alike"), contact(tmp_path / "radii", difference=-0.09, partner=9.52e-3),
        contact(tmp_path / "unlike", material=unlike),
    ])  # fmt: skip
    assert row(study, "Finite elements over the law at 3 alpha_y, brass, like").ours == pytest.approx(15)
    worst = row(study, "Finite elements over the law from 1 to 10 alpha_y: most, brass, like radii")
    assert (worst.source, worst.ours) == (6, pytest.approx(15))
    for name, ours in (("like radii", -5), ("radii 2 to 1", -14)):
        least = row(study, f"Finite elements over the law from 10 alpha_y to 0.2 R*: least, brass, {name}")
        assert (least.source, least.ours) == (-6, pytest.approx(ours)), "the source has one law for all radii"
    assert row(study, "Finite elements over the law from 1 to 10 alpha_y: most, brass and steel").source is None
    deep = row(study, "Finite elements at 0.19 R*, brass, radii 2 to 1")
    assert deep.ours == pytest.approx(100 * (0.86 / 0.95 - 1)) and deep.source is None
    assert row(study, "Smallest unloading exponent, brass, radii 2 to 1").source == 1.3
    assert row(study, "Share of the energy of yielding").ours == pytest.approx(0.3 / (0.3 + 2 * 0.1))


def test_a_force_on_disk_moves_every_row_that_measures_it(tmp_path: Path) -> None:
    before, after = (study_of(SCRIPT, [contact(tmp_path / f"{force:g}", force=force)]).rows for force in (1.0, 1.1))
    measured = [pair for pair in zip(before, after, strict=True) if pair[0].quantity.startswith("Finite elements over")]
    assert len(measured) == 6
    for first, second in measured:
        assert 1 + second.ours / 100 == pytest.approx(1.1 * (1 + first.ours / 100))


def test_pressure_and_area_are_compared_with_thorntons_law(tmp_path: Path) -> None:
    study = study_of(SCRIPT, [contact(tmp_path / "alike")])
    assert row(study, "Largest pressure over the yield strength").ours == pytest.approx(1.6 * 16 / 15)
    assert row(study, "Largest pressure over Thornton's").ours == pytest.approx(1.6)
    assert row(study, "Contact area over Thornton's").ours == pytest.approx(2)
    force, overlap = row(study, "Force over that of Thornton's"), 0.19 * RADIUS
    law = 5e9 * overlap**1.2 / (16 / 15 * 550e6 * np.pi * RADIUS * overlap)
    assert (force.source, force.ours, force.theory) == (
        4.7,
        pytest.approx(0.95 * law, rel=1e-3),
        pytest.approx(law, rel=1e-3),
    )
