"""Dents from before the run: the time step that they ask for, and boxes of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.timestep import auto_timestep
from granwave.workflows import load_case, run_case


def test_timestep_counts_the_slope_of_dents(tmp_path: Path) -> None:
    """Unloading is steeper: with dents far beyond the peak overlap the balance closes as well as without."""
    changes = {"packing.size": 30, "run.end_time": 2e-4, "run.frames": 2}
    one = load_case("preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1e4}})
    summary = run_case(one, tmp_path / "run", figures=False).summary
    fresh = load_case("preconditioned-chain", changes | {"contact.initial_overlap": 0.0})
    small = load_case("preconditioned-chain", changes | {"contact.initial_overlap": {"force": 1.0}})
    from_file = load_case("preconditioned-chain", changes | {"contact.initial_overlap": str(tmp_path / "run")})
    assert auto_timestep(one) < 0.6 * auto_timestep(fresh)
    assert auto_timestep(small) == auto_timestep(fresh)
    assert auto_timestep(from_file) == pytest.approx(auto_timestep(one), rel=0.11)  # two digits
    assert summary["energy_balance_error"] < one.run.energy_tolerance


@pytest.mark.parametrize(
    ("dents", "message"),
    [({"overlap": 1e-6, "low": [0, 0, 0.02], "high": [1, 1, 0.01]}, "expected low of a box of dents below its high"),
     ({"overlap": 1e-6, "low": [1, 1, 1]}, r"found no contact in the box \{low = \[1.0, 1.0, 1.0\]\}, expected")],
)  # fmt: skip
def test_boxes_of_dents_that_hold_nothing(dents: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as refused:
        load_case("fcc-small", {"contact.initial_overlap": dents})
    assert len(refused.value.errors) == 1


def test_pair_without_materials() -> None:
    with pytest.raises(InputError, match=r"pair.1.materials: missing; expected the names of two"):
        load_case("fcc-small", {"pair": [{"friction": 0.1}]})
