"""Values of keys: counts, SI values, and hints at the intended key or unit."""

from __future__ import annotations

import contextlib
import dataclasses
import logging
import re
import resource
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.sphere_contact import SphereContactCase
from granwave.lammps_inputs import files, make_schedule, plan
from granwave.lammps_inputs.case import added_grains, case
from granwave.lammps_inputs.case.case import case_keys
from granwave.lammps_inputs.case.hints import (
    _KEY_OF_WORD,
    _NOTES,
    _WITHIN,
    POSSIBLE,
    impossible,
    unusual,
)
from granwave.lammps_inputs.case.material import Material, presets
from granwave.lammps_inputs.case.packing import packing
from granwave.lammps_inputs.case.schema import info_of
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows import library, load_case, load_scan
from granwave.workflows.cli.main import main
from granwave.workflows.solvers import solver_of

_SPARE = 4_000_000_000  # bytes of address space in addition to those in use


@pytest.fixture(autouse=True)
def little_memory(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Limit the memory of the process, on a machine of 8 GB, so that no large object can be created
    before the error.
    """
    for module in (added_grains, packing, files):
        monkeypatch.setattr(module, "available_memory", lambda: 8e9)
    before = resource.getrlimit(resource.RLIMIT_AS)
    taken = (
        int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        * resource.getpagesize()
    )
    resource.setrlimit(resource.RLIMIT_AS, (taken + _SPARE, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


MANY = "packing.size: found [1200, 1200, 1200]: 1728000000 spheres require more than"


@pytest.mark.parametrize(
    ("case", "overrides", "expected"),
    [
        ("fcc-small", ["packing.size=[1000000,1000000,1000000]"], "packing.size: found [1000000, 1000000, 1000000], expected"),
        ("fcc-small", ["packing.size=[1000,1000,1000]"], "packing.size: 1000000000 spheres require about"),
        ("fcc-small", ["packing.size=[1,1,2000000000]"], "packing.size: 2000000000 spheres require about"),
        ("fcc-small", ["packing.size=[40000,40000,1]"], "packing.size: found [40000, 40000, 1]: 1600000000 spheres require"),
        ("elastic-impact", ["packing.size=2000000000"], "packing.size: 2000000000 spheres require about"),
        ("half-space", ["run.elements=1000000000"], "run.elements: 1000000000 elements require about"),
        *(("fcc-small", ["packing.size=[1200,1200,1200]", disorder], MANY) for disorder in (
            "packing.diameter_scatter=1e-6", "packing.vacancies=0.1", 'replace=[{share=0.1,material="steel"}]')),
    ],
)  # fmt: skip
def test_large_counts(
    case: str, overrides: list[str], expected: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run is rejected; in a plan for another machine, missing resources of this machine are only
    a warning.
    """
    begin = time.process_time()
    words = [word for override in overrides for word in ("--set", override)]
    lacks_memory = expected.endswith("require about")
    assert main(["check", case, *words]) == (0 if lacks_memory else 2)
    assert expected in capsys.readouterr().err
    verb = "continuum" if case == "half-space" else "run"
    assert main([verb, case, *words]) == 2
    assert expected in capsys.readouterr().err
    assert time.process_time() - begin < 10


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[grid]\nload.velocity = {linear = [0, 1, 1e12]}\n", "expected {linear = [first, last, how many]} with 2 to 100000"),
        ("[grid]\nload.velocity = {log = [1, 2, 1000000000000]}\n", "with 2 to 100000 values"),
        ("[grid]\nload.velocity = {log = [1, 2, 100000]}\npacking.seed = {linear = [1, 9, 10000]}\n", "found 1000000000 points"),
        ("replicates = 1000000000000\n[grid]\nload.velocity = [1]\n", "replicates: found 1000000000000, expected at most"),
        ("replicates = 60000\n[[points]]\nload.velocity = 1\n[[points]]\nload.velocity = 2\n", "found 120000 points"),
        ("ranks = 1000000000000\n[grid]\nload.velocity = [1]\n", "ranks: found 1000000000000, expected at most"),
        ("[grid]\nrun.frames = [2, 1000000000000]\n", "point 2 (run.frames = 1000000000000): fcc-small: run.frames: found"),
    ],
)  # fmt: skip
def test_large_scans(text: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "scan.toml").write_text(f'case = "fcc-small"\n{text}', encoding="utf-8")
    with pytest.raises(InputError) as caught:
        load_scan(tmp_path / "scan.toml")
    (fault,) = caught.value.errors
    assert expected in fault and fault.startswith(str(tmp_path / "scan.toml"))


@pytest.mark.parametrize(
    ("changes", "frames", "every"),
    [
        ({"run.frames": 1, "run.timestep": 1e-3 / 34500}, 2, 34500),
        ({"run.frames": 2, "run.timestep": 1e-3 / 34500}, 2, 34500),
        ({"run.frames": 20}, 20, 0),
        ({"run.frames": 301, "run.timestep": 1e-3 / 34500}, 301, 115),
        ({"run.frames": 34501, "run.timestep": 1e-3 / 34500}, 34501, 1),
        (
            {"run.frames": 20, "run.end_time": 1e-9, "run.timestep": 1e-10},
            11,
            1,
        ),  # the default, in a run of few steps
    ],
)
def test_as_many_snapshots_as_are_asked_for(
    changes: dict[str, Any], frames: int, every: int
) -> None:
    schedule = make_schedule(load_case("fcc-small", changes))
    assert (schedule.n_frames, schedule.frame_every) == (frames, every)


def test_times_that_cannot_be_meant_are_noted(caplog: pytest.LogCaptureFixture) -> None:
    plan(load_case("fcc-small", {"output.probe_interval": 1e-10, "output.probes": [{"sphere": 1}]}))
    plan(load_case("fcc-small", {"run.timestep": 1e-5}))
    assert [record.getMessage() for record in caplog.records] == [
        "fcc-small: output.probe_interval: found 1e-10 s, but at most one record per timestep "
        "(2.89e-08 s) is written",
        'fcc-small: run.timestep: found 1e-05 s, but "auto" uses 2.9e-08 s; the error of the energy '
        "balance will probably be too large",
    ]


def _notes(
    caplog: pytest.LogCaptureFixture, overrides: dict[str, Any], case: str = "fcc-small"
) -> list[str]:
    with contextlib.suppress(InputError):  # other errors may follow
        load_case(case, overrides)
    return [record.getMessage() for record in caplog.records if record.levelno == logging.WARNING]


@pytest.mark.parametrize(
    ("case", "key", "value", "meant"),
    [
        ("fcc-small", "material.youngs_modulus", 210, "found 210 Pa, expected about 1e6 to 1e12 Pa; 210 GPa is 210e9"),
        ("fcc-small", "material.density", 7.85, "expected about 10 to 30000 kg/m^3; 7.85 g/cm^3 is 7.85e3"),
        ("fcc-small", "material.yield_strength", 700, "expected about 10000 to 5e10 Pa; 700 MPa is 700e6"),
        ("fcc-small", "packing.diameter", 10, "found 10 m, expected about 1e-6 to 1 m; 10 mm is 10e-3"),
        ("fcc-small", "load.velocity", 5000, "5000 mm/s is 5000e-3"),
        ("fcc-small", "run.end_time", 50, "50 µs is 50e-6"),
        ("fcc-small", "packing.diameter_scatter", 0.45, "0.45 mm is 0.45e-3"),
        ("fcc-small", "output.probe_interval", 1e-14, "expected about 1e-13 to 0.5 s"),
        ("fcc-small", "contact.friction", 30, "found 30, expected about 0 to 2"),
        ("fcc-small", "boundary.friction", 30, "found 30, expected about 0 to 2"),
        ("fcc-small", "load.spin", [0, 0, 1e7], "found 1e7 rad/s"),
        ("precompressed-fcc", "precompression.pressure", 2, "2 MPa is 2e6"),
        ("precompressed-chain", "precompression.force", 1e-10, "found 1e-10 N"),
        ("settled-gravity", "precompression.acceleration", 5810, "5810 mm/s^2 is 5810e-3"),
        ("split-hopkinson", "bar.area", 78.5, "78.5 mm^2 is 78.5e-6"),
        ("split-hopkinson", "incident_bar.length", 180, "180 mm is 180e-3"),
        ("elastic-long-load", "load.duration", 50, "50 µs is 50e-6"),
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
    ContinuumCase.from_dict(
        {"name": "b", "material": "brass", "block": {"diameter": 100, "height": 100}}
    )
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
            if usual := info_of(field).usual:
                assert not unusual(getattr(material, field.name), usual), material.name
    assert not [record for record in caplog.records if "expected about" in record.getMessage()]


ABSURD = {
    "packing.diameter": [1e30, 1e-30, 1e-320, 1e7], "load.velocity": [1e300, 3e8, 1e-320],
    "material.youngs_modulus": [1e300, 1e-320, 1e19], "material.density": [1e300, 1e-10],
    "material.yield_strength": [1e300, 1e-300], "run.end_time": [1e300, 1e-300], "run.timestep": [1e-300, 1e-19],
    "packing.diameter_scatter": [1e-300], "boundary.forget_gap": [1e-300], "load.spin": [[0, 0, 1e300], [1e-320, 0, 0]],
    "output.probe_interval": [1e-300],
}  # fmt: skip


@pytest.mark.parametrize("key", ABSURD)
def test_absurd_values_are_refused(key: str) -> None:
    for value in [*ABSURD[key], "nan", "inf", "-inf"]:
        with pytest.raises(InputError) as caught:
            load_case("fcc-small", [f"{key}={value}"])
        assert (
            caught.value.errors[0].startswith(f"{key}: found ")
            and "expected" in caught.value.errors[0]
            and caught.value.items[0].changed
        )


def test_zero_is_no_magnitude() -> None:
    assert not impossible((0.0, 0.0, 1.0), "m/s") and not impossible(0.0, "m")
    assert load_case("fcc-small", {"packing.diameter_scatter": 0.0, "load.spin": [0, 0, 0]})


def test_every_unit_of_a_case_has_a_range() -> None:
    units = {case.unit_of(key) for key in case.case_keys()}
    assert units - {"", "degrees"} <= set(POSSIBLE)


def test_synonyms_lead_to_keys_that_there_are() -> None:
    known = {key.rpartition(".")[2] for key in case_keys()}
    assert set(_KEY_OF_WORD.values()) | set(_WITHIN.values()) <= known
    assert not set(_KEY_OF_WORD) & known, "a key that there is needs no synonym"
    assert not set(_NOTES) & set(_KEY_OF_WORD)


def test_a_table_of_a_file_is_not_blamed_on_the_command_line(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text(
        'material = "brass"\n[packing]\nkind = "fcc"\nsize = [3, 3, 2]\ndiameter = 0.01\nradius = 1\n'
    )
    with pytest.raises(InputError) as caught:
        load_case(path, ["packing.seed=3"])
    assert caught.value.errors == [
        f"{path}: packing.radius: unknown key; did you mean packing.diameter?"
    ]


def test_hints_of_continuum_cases_and_scans(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"velocity: unknown key; did you mean punch.velocity\?"):
        ContinuumCase.from_dict({"material": "brass", "velocity": 3})
    with pytest.raises(InputError, match=r"punch.diametre: unknown key; did you mean diameter\?"):
        ContinuumCase.from_dict({"material": "brass", "punch": {"diametre": 3}})
    path = tmp_path / "scan.toml"
    path.write_text(
        'case = "fcc-small"\nvelocity = 3\n[grid]\nload.velocity = [1]\n', encoding="utf-8"
    )
    with pytest.raises(
        InputError, match=r"velocity: unknown key; did you mean set.load.velocity\?"
    ):
        load_scan(path)


def test_files_with_similar_names_are_named_before_studies(tmp_path: Path) -> None:
    """Files are compared by their names without the suffix, which all files share."""
    (tmp_path / "Impact.toml").write_text("")
    (tmp_path / "f.toml").write_text("")
    for name in ("Impact", "impac", "Imapct.toml"):
        with pytest.raises(
            InputError, match=rf"did you mean {re.escape(str(tmp_path / 'Impact.toml'))}\?"
        ):
            library.find(str(tmp_path / name), library.CASES)
    with pytest.raises(InputError, match="granwave cases lists the built-in ones"):
        library.find(str(tmp_path / "s24.toml"), library.CASES)
