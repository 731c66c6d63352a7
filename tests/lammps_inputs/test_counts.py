"""Counts that are too large are an error before they are used; the message contains the count and its limit."""

from __future__ import annotations

import resource
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs import files
from granwave.lammps_inputs.case import added_grains, packing
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.planning.plan import plan
from granwave.lammps_inputs.planning.schedule import make_schedule
from granwave.workflows import load_case, load_scan
from granwave.workflows.cli.main import main

_SPARE = 4_000_000_000  # bytes of address space in addition to those in use


@pytest.fixture(autouse=True)
def little_memory(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Limit the memory of the process, on a machine of 8 GB, so that no large object can be created before the error."""
    for module in (added_grains, packing, files):
        monkeypatch.setattr(module, "available_memory", lambda: 8e9)
    before = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + _SPARE, before[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, before)


def _refused(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    begin = time.process_time()
    assert main(words) == 2
    assert time.process_time() - begin < 5
    return capsys.readouterr().err


@pytest.mark.parametrize(
    ("case", "override", "expected"),
    [
        ("fcc-small", "run.frames=1000000000000", "run.frames: found 1000000000000, expected at most 34545: one at the start"),
        ("fcc-small", "run.frames=34546", "run.frames: found 34546, expected at most 34545"),
        ("fcc-small", "run.frames=20000", "found 20000, expected at most 10000 where they do not divide the 34544 steps"),
        ("two-spheres", "run.frames=1000000000", "run.frames: found 1000000000, expected at most 28601"),
        ("elastic-impact", "output.history=1000000000000", "output.history: found 1000000000000, expected at most 49197"),
        ("fcc-small", "packing.size=[1000000,1000000,1000000]", "packing.size: found [1000000, 1000000, 1000000], expected"),
        ("fcc-small", "packing.size=[1000,1000,1000]", "packing.size: 1000000000 spheres need about"),
        ("fcc-small", "packing.size=[1,1,2000000000]", "packing.size: 2000000000 spheres need about"),
        ("fcc-small", "packing.size=[40000,40000,1]", "packing.size: found [40000, 40000, 1]: 1600000000 spheres need"),
        ("elastic-impact", "packing.size=2000000000", "packing.size: 2000000000 spheres need about"),
        ("fcc-small", 'replace=[{index={first=1,last=1000000000000},material="steel"}]', "replace.1.index: found"),
        ("fcc-small", 'replace=[{index={first=1,last=2000000000},material="steel"}]', "expected at most 10000000 ids"),
        ("fcc-small", "striker=[{touches={first=1,last=2000000000}}]", "expected at most 10000000 ids"),
        ("fcc-small", "packing.vacancies=[99999999999]", "packing.vacancies: found [99999999999], expected at most"),
        ("split-hopkinson", "bar.elements=1000000000000", "bar.elements: found 1000000000000, expected at most 10000000"),
        ("fcc-small", 'boundary.bottom={bar={length=1,area=1,elements=1000000000},material="steel"}',
         "boundary.bottom.bar.elements: found 1000000000, expected at most 10000000"),
        ("half-space", "run.elements=1000000000000", "run.elements: found 1000000000000, expected at most 1000000000"),
        ("half-space", "run.elements=1000000000", "run.elements: 1000000000 elements need about"),
        ("half-space", "run.timestep=1e-17", "run.end_time: 0.005 s in steps of 1e-17 s are more than 2e+09 steps"),
        ("half-space", "run.end_time=1e8", "run.end_time: 1e+08 s in steps of"),
        ("sphere-contact", "run.elements=1000000000000", "run.elements: found 1000000000000, expected at most 1000000000"),
        ("sphere-contact", "run.unloadings=1000000000000", "run.unloadings: found 1000000000000, expected at most 1000"),
        ("sphere-contact", "run.speed=1e-300", "run.speed: found 1e-300, which takes"),
    ],
)  # fmt: skip
def test_large_counts(case: str, override: str, expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert expected in _refused(["check", case, "--set", override], capsys)


def test_a_disordered_packing_beyond_memory(capsys: pytest.CaptureFixture[str]) -> None:
    for disorder in (
        "packing.diameter_scatter=1e-6",
        "packing.vacancies=0.1",
        'replace=[{share=0.1,material="steel"}]',
    ):
        said = _refused(["check", "fcc-small", "--set", "packing.size=[1200,1200,1200]", "--set", disorder], capsys)
        assert "packing.size: found [1200, 1200, 1200]: 1728000000 spheres need more than" in said


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
        ({"run.frames": 20, "run.end_time": 1e-9, "run.timestep": 1e-10}, 11, 1),  # the default, in a run of few steps
    ],
)
def test_as_many_snapshots_as_are_asked_for(changes: dict[str, Any], frames: int, every: int) -> None:
    schedule = make_schedule(load_case("fcc-small", changes))
    assert (schedule.n_frames, schedule.frame_every) == (frames, every)


def test_times_that_cannot_be_meant_are_noted(caplog: pytest.LogCaptureFixture) -> None:
    plan(load_case("fcc-small", {"output.probe_interval": 1e-10, "output.probes": [{"sphere": 1}]}))
    plan(load_case("fcc-small", {"run.timestep": 1e-5}))
    assert [record.getMessage() for record in caplog.records] == [
        "fcc-small: output.probe_interval: found 1e-10 s, there is at most a record each timestep, 2.89e-08 s",
        'fcc-small: run.timestep: found 1e-05 s, "auto" takes 2.9e-08 s; the energy balance will hardly close',
    ]
