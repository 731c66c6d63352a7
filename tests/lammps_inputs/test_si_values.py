"""Values that are implausible in SI units give a note with the probable unit; absurd ones are an error."""

from __future__ import annotations

import contextlib
import dataclasses
import logging
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.case import case
from granwave.lammps_inputs.case.hints import POSSIBLE, impossible, unusual
from granwave.lammps_inputs.case.material import Material, presets
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows import library, load_case, load_scan
from granwave.workflows.finite_elements.punch import ContinuumCase
from granwave.workflows.finite_elements.sphere_contact import SphereContactCase
from granwave.workflows.solvers import solver_of

STEEL_IN_OTHER_UNITS = {
    "material.youngs_modulus": 210,
    "material.density": 7.85,
    "material.yield_strength": 700,
    "packing.diameter": 10,
}


def _notes(caplog: pytest.LogCaptureFixture, overrides: dict[str, Any], case: str = "fcc-small") -> list[str]:
    with contextlib.suppress(InputError):  # other errors may follow
        load_case(case, overrides)
    return [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]


def test_steel_in_gigapascals_and_millimetres(caplog: pytest.LogCaptureFixture) -> None:
    assert _notes(caplog, STEEL_IN_OTHER_UNITS) == [
        "fcc-small: material.youngs_modulus: found 210 Pa, expected some 1e6 to 1e12 Pa; 210 GPa is 210e9",
        "fcc-small: material.density: found 7.85 kg/m^3, expected some 10 to 30000 kg/m^3; 7.85 g/cm^3 is 7.85e3",
        "fcc-small: material.yield_strength: found 700 Pa, expected some 10000 to 5e10 Pa; 700 MPa is 700e6",
        "fcc-small: packing.diameter: found 10 m, expected some 1e-6 to 1 m; 10 mm is 10e-3",
    ]


@pytest.mark.parametrize(
    ("case", "key", "value", "meant"),
    [
        ("fcc-small", "load.velocity", 5000, "5000 mm/s is 5000e-3"),
        ("fcc-small", "run.end_time", 50, "50 us is 50e-6"),
        ("fcc-small", "packing.diameter_scatter", 0.45, "0.45 mm is 0.45e-3"),
        ("fcc-small", "output.probe_interval", 1e-14, "expected some 1e-13 to 0.5 s"),
        ("fcc-small", "contact.friction", 30, "found 30, expected some 0 to 2"),
        ("fcc-small", "boundary.friction", 30, "found 30, expected some 0 to 2"),
        ("fcc-small", "load.spin", [0, 0, 1e7], "found 1e7 rad/s"),
        ("precompressed-fcc", "precompression.pressure", 2, "2 MPa is 2e6"),
        ("precompressed-chain", "precompression.force", 1e-10, "found 1e-10 N"),
        ("settled-gravity", "precompression.acceleration", 5810, "5810 mm/s^2 is 5810e-3"),
        ("split-hopkinson", "bar.area", 78.5, "78.5 mm^2 is 78.5e-6"),
        ("split-hopkinson", "incident_bar.length", 180, "180 mm is 180e-3"),
        ("elastic-long-load", "load.duration", 50, "50 us is 50e-6"),
        ("intruder", "replace.1.material", {"youngs_modulus": 2.1, "poisson_ratio": 0.3, "density": 2000,
         "yield_strength": 1e8}, "replace.1.material.youngs_modulus: found 2.1 Pa"),
    ],
)  # fmt: skip
def test_unusual_values_name_the_unit_that_was_meant(
    case: str, key: str, value: Any, meant: str, caplog: pytest.LogCaptureFixture
) -> None:
    base = {"packing.diameter": 1.0} if key == "packing.diameter_scatter" else {}
    found = [note for note in _notes(caplog, {key: value} | base, case) if meant in note]
    assert len(found) == 1 and found[0].startswith(f"{case}: {key}")


def test_continuum_cases_are_looked_at_too(caplog: pytest.LogCaptureFixture) -> None:
    ContinuumCase.from_dict({"name": "b", "material": "brass", "block": {"diameter": 100, "height": 100}})
    SphereContactCase.from_dict({"name": "s", "material": "brass", "sphere": {"radius": 5}})
    assert [record.getMessage().partition(", ")[0] for record in caplog.records] == [
        "b: block.diameter: found 100 m",
        "b: block.height: found 100 m",
        "s: sphere.radius: found 5 m",
    ]


def test_no_built_in_case_or_material_is_unusual(caplog: pytest.LogCaptureFixture) -> None:
    for name in library.names():
        path = library.find(name)
        solver_of(read_toml(path)).read(read_toml(path), path)
    reproductions = Path(__file__).parents[2] / "reproductions"
    for name in (
        "thesis/chapter_3/intruder-properties.toml",
        "composite_chains/brass.toml",
    ):  # a hundred times as stiff
        load_scan(reproductions / name, here=False)
    for material in presets().values():
        for field in dataclasses.fields(Material):
            if usual := field.metadata["usual"]:
                assert not unusual(getattr(material, field.name), usual), material.name
    assert not [record for record in caplog.records if "expected some" in record.getMessage()]


@pytest.mark.parametrize(
    ("key", "values"),
    [
        ("packing.diameter", [1e30, 1e-30, 1e-320, 1e7]),
        ("load.velocity", [1e300, 3e8, 1e-320]),
        ("material.youngs_modulus", [1e300, 1e-320, 1e19]),
        ("material.density", [1e300, 1e-10]),
        ("material.yield_strength", [1e300, 1e-300]),
        ("run.end_time", [1e300, 1e-300]),
        ("run.timestep", [1e-300, 1e-19]),
        ("packing.diameter_scatter", [1e-300]),
        ("boundary.forget_gap", [1e-300]),
        ("load.spin", [[0, 0, 1e300], [1e-320, 0, 0]]),
        ("output.probe_interval", [1e-300]),
    ],
)
def test_absurd_values_are_refused(key: str, values: list[Any]) -> None:
    for value in [*values, "nan", "inf", "-inf"]:
        with pytest.raises(InputError) as caught:
            load_case("fcc-small", [f"{key}={value}"])
        assert caught.value.errors[0].startswith(f"--set: {key}: found ") and "expected" in caught.value.errors[0]


def test_zero_is_no_magnitude() -> None:
    assert not impossible((0.0, 0.0, 1.0), "m/s") and not impossible(0.0, "m")
    assert load_case("fcc-small", {"packing.diameter_scatter": 0.0, "load.spin": [0, 0, 0]})


def test_every_unit_of_a_case_has_a_range() -> None:
    units = {case.unit_of(key) for key in case.case_keys()}
    assert units - {"", "degrees"} <= set(POSSIBLE)
