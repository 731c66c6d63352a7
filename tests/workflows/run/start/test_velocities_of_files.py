"""Velocities and spins of the grains of a file: with a load on one of them, and after a static
stage.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.checks.warnings import warn_about
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows.run.driver import run_case

GRAINS = "x,y,z,diameter,vz\n0,0,0,0.01,0.5\n0,0,0.009999,0.01,0\n0,0,0.019998,0.01,0.1\n"
MASS = 2500 * math.pi / 6 * 0.01**3  # of glass


def summary_of(directory: Path, **keys: Any) -> dict[str, Any]:
    """Return the summary of a run of three spheres of glass that overlap by 1e-6 m."""
    packing = {"kind": "file", "grains": GRAINS, "contacts": keys.pop("contacts", "keep")}
    case: dict[str, Any] = {
        "material": "glass",
        "contact": {"law": "hertz", "friction": 0.3},
        "packing": packing | keys.pop("packing", {}),
        "precompression": {"kind": "gravity"},
        "run": {"end_time": 2e-6},
    }
    run = run_case(case_from_dict(case | keys, "velocities"), directory, figures=False)
    return dict(run.summary)


@pytest.mark.parametrize(("contacts", "packing"), [
    ("keep", {}), ("overlaps", {}), ("relax", {"relaxation": "damped"}),
])  # fmt: skip
def test_a_load_replaces_the_velocity_of_the_struck_grain(
    contacts: str, packing: dict[str, str], tmp_path: Path
) -> None:
    """The input energy includes the load and the other grains, and the balance closes."""
    values = summary_of(
        tmp_path / "r", contacts=contacts, packing=packing, load={"index": [1], "velocity": 1.0}
    )
    assert values["energy_input_J"] == pytest.approx(MASS / 2 * (1.0 + 0.01), rel=1e-6)
    assert values["energy_balance_error"] < 1e-5


def test_velocities_are_the_load_after_a_static_stage(tmp_path: Path) -> None:
    values = summary_of(tmp_path / "r", contacts="overlaps")
    assert values["energy_input_J"] == pytest.approx(MASS / 2 * (0.25 + 0.01), rel=1e-6)
    assert values["energy_balance_error"] < 1e-5


SPINNING = (
    GRAINS.replace(",vz", ",vz,omegay").replace("0.5\n", "0.5,30\n").replace(",0.1\n", ",0.1,-20\n")
)
SPINNING = SPINNING.replace(",0.01,0\n", ",0.01,0,0\n")
OF_SPIN = 0.2 * MASS * 0.005**2  # energy of a sphere, over the square of its spin


def test_spins_of_a_file_are_kept(tmp_path: Path) -> None:
    """The lowest sphere slips on the floor: the input energy includes all motion."""
    values = summary_of(tmp_path / "r", packing={"grains": SPINNING})
    moving = MASS / 2 * (0.25 + 0.01)
    assert values["energy_input_J"] == pytest.approx(moving + OF_SPIN * 1300.0, rel=1e-6)
    assert values["energy_balance_error"] < 1e-5
    data = (tmp_path / "r" / "data.granwave").read_text()
    assert "1 0.0 0.0 0.5 0.0 30.0 0.0" in data or "1 0 0 0.5 0 30 0" in data


def test_lengths_in_centimetres_are_suspected_by_the_density(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A dump in units cgs does not state its units: 0.01 m and 2500 kg/m^3 look like 1 m and 2.5
    kg/m^3.
    """
    head = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n"
    rows = "0 2\n0 2\n0 4\nITEM: ATOMS id x y z radius mass\n1 1 1 1 0.5 4.45\n2 1 1 2.1 0.5 4.45\n"
    file = tmp_path / "cgs.dump"
    file.write_text(head + rows)
    for units, warned in ((None, True), ("cm", False)):
        packing = {"kind": "file", "file": str(file)}
        packing |= {} if units is None else {"units": units}
        caplog.clear()
        case = case_from_dict({"name": "cgs", "material": "brass", "packing": packing}, "cgs")
        warn_about(assemble(case))
        assert ("are its lengths in another unit" in caplog.text) == warned


@pytest.mark.parametrize(("keys", "reason"), [
    ({"contact": {"law": "hertz"}}, "they have no effect without contact.friction"),
    ({"contacts": "overlaps"}, 'the grains come to equilibrium; packing.contacts = "keep" keeps '
     'them'),
])  # fmt: skip
def test_spins_that_are_left_out_are_told(
    keys: dict[str, Any], reason: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    values = summary_of(tmp_path / "r", packing={"grains": SPINNING}, **keys)
    assert f"angular velocities are ignored: {reason}" in caplog.text
    assert values["energy_input_J"] == pytest.approx(MASS / 2 * (0.25 + 0.01), rel=1e-6)
    assert values["energy_balance_error"] < 1e-5


def test_grains_beyond_the_walls_are_a_fault_of_the_case() -> None:
    """`up = "z"` turns x, y and z: walls along y of the file are along another axis."""
    rows = "x,y,z,diameter\n0.01,0.01,0.01,0.01\n0.02,0.02,0.01,0.01\n"
    packing = {"kind": "file", "grains": rows, "enclosure": {"y": [-0.03, 0.0]}}
    case = {"material": "brass", "packing": packing, "boundary": {"sides": "wall"}}
    fault = r"packing\.enclosure\.y: found 2 grains beyond the walls along y, such as grain 1"
    with pytest.raises(InputError, match=fault):
        case_from_dict(case, "walls")
    packing["enclosure"] = {"y": [0.0, 0.03]}
    case_from_dict(case, "walls")
