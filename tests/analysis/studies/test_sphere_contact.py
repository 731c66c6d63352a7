"""The contact law beside finite elements: made-up runs of two spheres with known differences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis.studies.runs import SphereContactRun
from granwave.analysis.studies.study import Row, make_studies

BRASS = {"name": "brass", "yield_strength": 550e6}
YIELD, RADIUS = 1e-6, 2.4e-3  # m: overlap at first yield, R*


def contact(
    folder: Path,
    difference: float = 0.0,
    partner: float | None = None,
    force: float = 1.0,
    material: dict[str, Any] | None = None,
) -> SphereContactRun:
    """A run whose finite elements are 15 % above the law to 10 alpha_y, and 5 % below it beyond, and a difference."""
    folder.mkdir()
    overlap = np.geomspace(0.3 * YIELD, 0.2 * RADIUS, 2000)
    law = 5e9 * overlap**1.2
    over = np.where(overlap <= 10.001 * YIELD, 0.15, -0.05) + difference
    with h5py.File(folder / "result.h5", "w") as file:
        file["loading/overlap"], file["loading/law_force"] = overlap, law
        file["loading/force"] = force * law * (1 + over)
        for n, pressure in enumerate((1.0, 1.6, 1.5)):
            file[f"pressure/{n}/pressure"] = [pressure * 16 / 15 * 550e6] * 3 + [0.0] * 5
        file["loading/contact_radius"] = np.sqrt(2 * RADIUS * overlap)
        file["fields/position"] = [[0, 0], [1, 0], [1, 1], [0, 1], [1, 2], [0, 2]]
        file["fields/elements"] = [[0, 1, 2, 3], [3, 2, 4, 5]]
        file["fields/body"], file["fields/plastic_strain"] = [0, 1], [0.3, 0.1]
    case = {"material": BRASS, "sphere": {"radius": 4.76e-3}}
    if partner or material:
        case["partner"] = {"radius": partner or 4.76e-3, "material": material or BRASS}
    summary = {"yield_overlap_m": YIELD, "effective_radius_m": RADIUS, "unloading_exponent_min": 1.33}
    return SphereContactRun(folder.name, folder, case, summary)


def rows(*runs: SphereContactRun) -> dict[str, Row]:
    (study,) = make_studies({"sphere-contact": runs})
    return {row.quantity: row for row in study.rows}


def test_differences_are_finite_elements_over_the_law(tmp_path: Path) -> None:
    found = rows(contact(tmp_path / "alike"), contact(tmp_path / "unlike", -0.09, partner=9.52e-3))
    assert found["Finite elements over the law at 3 alpha_y, brass, like radii"].ours == pytest.approx(15)
    worst = found["Finite elements over the law from 1 to 10 alpha_y: most, brass, like radii"]
    assert (worst.source, worst.ours) == (6, pytest.approx(15))
    least = found["Finite elements over the law from 10 alpha_y to 0.2 R*: least, brass, like radii"]
    assert (least.source, least.ours) == (-6, pytest.approx(-5))
    deep = found["Finite elements at 0.19 R*, brass, radii 2 to 1, over those of like radii"]
    assert deep.ours == pytest.approx(100 * (0.86 / 0.95 - 1)) and deep.source is None
    unlike = next(
        row for name, row in found.items() if "10 alpha_y to" in name and "least" in name and "2 to 1" in name
    )
    assert unlike.kind == "source" and unlike.source == -6, "the source has one law for all radii"
    assert found["Smallest unloading exponent, brass, radii 2 to 1"].source == 1.3


def test_a_force_on_disk_moves_every_row_that_measures_it(tmp_path: Path) -> None:
    before, after = rows(contact(tmp_path / "true")), rows(contact(tmp_path / "false", force=1.1))
    measured = [name for name in before if name.startswith("Finite elements over")]
    assert len(measured) == 6
    for name in measured:
        assert 1 + after[name].ours / 100 == pytest.approx(1.1 * (1 + before[name].ours / 100))


def test_pressure_and_area_are_compared_with_thorntons_law(tmp_path: Path) -> None:
    found = rows(contact(tmp_path / "alike"))
    assert found["Largest pressure over the yield strength"].ours == pytest.approx(1.6 * 16 / 15)
    assert found["Largest pressure over Thornton's"].ours == pytest.approx(1.6)
    deep = "at 0.19 R*, brass, like radii"
    assert found[f"Contact area over Thornton's {deep}"].ours == pytest.approx(2)
    force = found[f"Force over that of Thornton's pressure and area {deep}"]
    overlap = 0.19 * RADIUS
    thornton = 16 / 15 * 550e6 * np.pi * RADIUS * overlap
    law = 5e9 * overlap**1.2 / thornton
    assert (force.source, force.ours, force.theory) == (
        4.7,
        pytest.approx(0.95 * law, rel=1e-3),
        pytest.approx(law, rel=1e-3),
    )


def test_the_softer_sphere_takes_what_its_strain_and_strength_say(tmp_path: Path) -> None:
    found = rows(contact(tmp_path / "unlike", material={"name": "steel", "yield_strength": 1100e6}))
    share = found["Share of the energy of yielding in the softer sphere, brass and steel"]
    assert share.ours == pytest.approx(0.3 / (0.3 + 2 * 0.1))


def test_other_runs_are_left_out(tmp_path: Path) -> None:
    run = contact(tmp_path / "elastic")
    assert make_studies({"sphere-contact": [SphereContactRun("e", run.directory, run.case, {})]}) == []
