"""Runs with partial slip: energy record and tables, words of the deck, pairs, and the impact of a
sphere on a plate.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.result.reader import Result
from granwave.lammps_inputs import auto_timestep
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.cost import expected_space, seconds_per_step
from granwave.lammps_inputs.planning.schedule import make_schedule
from granwave.workflows import load_case, run_case
from tests.helpers.twins.slip_twin import rebound

PARTIAL = {"contact.friction": 0.2, "contact.tangential": "partial_slip"}


def test_the_ledger_closes(tmp_path: Path) -> None:
    """In a packing that yields, with spin, walls and losses."""
    extra = {
        "packing.size": [6, 6, 4],
        "load.spin": [300.0, 0.0, 600.0],
        "contact.loss": {"time": 1e-7},
    }
    case = load_case("fcc-small", {**PARTIAL, **extra, "run.end_time": 1e-4, "run.frames": 3})
    found = run_case(case, tmp_path / "run", figures=False).summary
    assert found["energy_balance_error"] < 1e-5 and found["friction_fraction"] > 1e-3
    with Result(tmp_path / "run") as result:
        lost = (
            result["contacts/friction_energy"].sum() + result["wall_contacts/friction_energy"].sum()
        )
        assert lost == pytest.approx(result["energy/friction"][-1], rel=1e-9)


def test_the_timestep_is_that_of_one_spring() -> None:
    assert auto_timestep(load_case("fcc-small", PARTIAL)) == auto_timestep(
        load_case("fcc-small", {**PARTIAL, "contact.tangential": "mindlin_rescale"})
    )


def test_an_oblique_impact(tmp_path: Path) -> None:
    """At 10 degrees a case file gives the spin of the theory; a single spring gives 57 % of it."""
    case = load_case(
        "sphere-on-wall",
        {**PARTIAL, "contact.law": "hertz", "contact.friction": 0.3, "load.velocity": 1.0, "load.angle": 10.0,
         "run.end_time": 1e-4, "run.frames": 2},
    )  # fmt: skip
    run_case(case, tmp_path / "run", figures=False)
    radius = case.packing.diameter / 2
    material = case.material
    with Result(tmp_path / "run") as result:
        inertia = 0.4 * material.density * 4 / 3 * np.pi * radius**5
        spin = (2 * result["energy/rotational"][-1] / inertia) ** 0.5
    _, _, expected = rebound(
        modulus=material.youngs_modulus, poisson=material.poisson_ratio, density=material.density, radius=radius,
        friction=0.3, normal=np.cos(np.radians(10)), across=np.sin(np.radians(10)),
    )  # fmt: skip
    assert spin == pytest.approx(-expected, rel=0.01)


def test_refused() -> None:
    with pytest.raises(InputError, match=r"contact\.tangential") as error:
        load_case("fcc-small", {"contact.tangential": "partial"})
    assert "partial_slip" in str(error.value) and len(str(error.value).splitlines()) == 1


def test_its_cost_is_planned() -> None:
    single, partial = (
        assemble(load_case("fcc-impact", {**PARTIAL, "contact.tangential": name}))
        for name in ("mindlin_rescale", "partial_slip")
    )
    assert seconds_per_step(partial) > 1.5 * seconds_per_step(single)
    memory, more = (expected_space(one, make_schedule(one), 1) for one in (single, partial))
    assert more.first_rank > memory.first_rank


def test_after_a_static_stage(tmp_path: Path) -> None:
    """The run begins without friction; the cells are added with later laws."""
    case = load_case(
        "precompressed-fcc",
        {**PARTIAL, "contact.friction": 0.2, "packing.size": [6, 6, 4], "run.end_time": 5e-5},
    )
    found = run_case(case, tmp_path / "run", figures=False).summary
    assert found["energy_balance_error"] < 1e-5 and found["friction_fraction"] > 0
