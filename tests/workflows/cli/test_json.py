"""granwave check, and the JSON output of commands."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any

import pytest

from granwave.lammps_inputs.case.case import Case
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.installation import doctor
from granwave.workflows.cli.installation.doctor import Finding
from granwave.workflows.cli.keys.reference import tables
from granwave.workflows.cli.main import main
from granwave.workflows.cli.tables.scan_outcome import outcome_values
from granwave.workflows.cli.terminal import print_json
from granwave.workflows.scanning.driver import ScanOutcome
from tests.documents.pages import ROOT
from tests.helpers.made_up.synthetic_scan import grid, write_scan

SMALL = {"packing.size": "[8,8,5]"}
CENTRE = {"load": "{kind='striker'}", "striker": "[{touches='centre',velocity=[0,0,5]}]"}
CORNER = {"load": "{kind='striker'}", "striker": "[{touches=1,velocity=[0,0,5]}]"}


def check(
    name: str, changes: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> tuple[dict[str, Any], str]:
    """Return the values of ``check --json``, and the table."""
    words = [
        "check",
        name,
        *(word for key, value in changes.items() for word in ("--set", f"{key}={value}")),
    ]
    assert main([*words, "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert main(words) == 0
    return values, capsys.readouterr().out


def loaded(changes: dict[str, str]) -> Case:
    return load_case("fcc-small", [f"{key}={value}" for key, value in changes.items()])


@pytest.mark.parametrize(
    "case",
    [
        "fcc-small",
        "precompressed-chain",
        "fcc-striker",
        pytest.param("half-space", marks=pytest.mark.needs_extension("continuum")),
        pytest.param("poured-small", marks=pytest.mark.needs_extension("packings")),
    ],
)
def test_the_page_lists_all_values(
    case: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`check --json` prints no value that the page of the command does not explain."""
    monkeypatch.chdir(tmp_path)
    assert main(["check", case, "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    page = (ROOT / "docs" / "howto" / "check.md").read_text(encoding="utf-8")
    explained = set(re.findall(r"`(\w+)`", page))
    assert len(values) >= 1
    assert set(values) - explained == set()


@pytest.mark.parametrize(
    "changes", [{}, {"replace": "[{index=[5],diameter=0.008,material='steel'}]"}]
)
def test_mass_and_height_are_those_of_the_run(changes, tmp_path, capsys) -> None:
    values, table = check("fcc-small", SMALL | changes, capsys)
    case = loaded(SMALL | changes | {"run.end_time": "1e-6", "run.frames": "2"})
    summary = run_case(case, tmp_path / "run", figures=False).summary
    for name in ("packing_mass_kg", "packing_height_m"):
        assert values[name] == pytest.approx(summary[name], rel=1e-9)
    rows = 0.01 * math.sqrt(3) / 2  # triangular layers, of which every second or third is shifted
    assert values["packing_width_m"][1] == pytest.approx(0.01 + 7 * rows + 2 / 3 * rows, rel=0.02)
    assert f"{values['packing_mass_kg']:.4g} kg, {values['packing_height_m']:.4g} m high" in table


def test_where_a_striker_lands_and_how_deep_it_yields(capsys) -> None:
    values, table = check("fcc-small", SMALL, capsys)
    zone = values["zone"]
    impact = values["struck"]
    assert zone["depth_m"] < values["packing_height_m"] < zone["depth_in_larger_packing_m"]
    assert zone["radius_m"] < zone["radius_in_larger_packing_m"]
    assert "to the bottom and the sides of the packing; in a larger one about" in table
    assert values["nulls"] == {} and "no peak reduction" not in table
    corner, table = check("fcc-small", SMALL | CORNER, capsys)
    assert corner["struck"]["sphere"] == 1 and corner["struck"]["where"] == "at a corner of the top"
    assert "sphere 1, at a corner of the top, 0.0" in table
    centre = check("fcc-small", SMALL | CENTRE, capsys)[0]
    assert centre["struck"] == impact and not impact["where"] and not impact["aside_m"]
    assert loaded(SMALL | CENTRE).striker[0].touches == (impact["sphere"],)


def test_what_will_be_null(tmp_path, capsys) -> None:
    plate = {
        "load": "{kind='plate',mass=0.1,velocity=1.0}",
        "boundary.bottom": "{plate={mass=1.0,stiffness=1e6}}",
    }
    values, table = check("fcc-small", SMALL | plate, capsys)
    assert (
        'load.kind = "plate"' in values["nulls"]["peak_reduction"] and "no peak reduction" in table
    )
    case = loaded(SMALL | plate | {"run.end_time": "2e-5", "run.frames": "2"})
    assert run_case(case, tmp_path / "run", figures=False).summary["peak_reduction"] is None


TINY = ["--set", "packing.size=[4,4,3]", "--set", "run.end_time=4e-5", "--no-figures"]
SCAN = """
case = "two-spheres"
[set]
run.end_time = 1e-5
[grid]
load.velocity = [1.0, 2.0]
"""


def document(arguments, capsys, status=0):
    """Return the document that a command prints."""
    capsys.readouterr()
    assert main(arguments) == status
    return json.loads(capsys.readouterr().out)


def test_check(capsys):
    plan = document(["check", "fcc-small", "--json"], capsys)
    assert (plan["name"], plan["command"], plan["n_spheres"], plan["n_frames"]) == (
        "fcc-small",
        "run",
        6912,
        20,
    )
    assert plan["end_time_s"] == pytest.approx(1e-3)
    assert plan["expected_arrival_s"] == pytest.approx(2.2e-4, rel=0.05)  # 1.8e-4 in the run
    assert plan["n_frames_before_arrival"] == 12
    assert plan["zone"]["reaches"] == ["bottom", "sides"] and "packing.size" in plan["warnings"][0]
    assert (
        sum(plan["wall_time_parts_s"][name] for name in ("static", "steps", "rest", "figures"))
        == plan["wall_time_s"]
    )
    assert main(["check", "fcc-small", "--json", "--set", "packing.kind=fcx"]) == 2
    assert capsys.readouterr().out == ""  # refused before it prints


def leaves(value):
    """Numbers of a document, including numbers that are keys, and the lengths of lists and tables."""
    if isinstance(value, dict):
        return [
            one
            for key, part in value.items()
            for one in [*leaves(part), *([float(key)] if key.isdigit() else [])]
        ]
    if isinstance(value, list):
        return [one for part in value for one in leaves(part)]
    return [float(value)] if isinstance(value, int | float) and not isinstance(value, bool) else []


def is_rounded(text, value):
    """True if the text is the value with fewer digits."""
    mantissa, _, power = text.partition("e")
    last = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    return abs(float(text) - value) <= 0.5001 * last


CHECKED = [
    ["precompressed-chain", "--np", "2"],
    ["driven-row", "--set", "contact.loss={restitution=0.9,velocity=0.1}"],
    ["confined-steel"],
    [
        "fcc-small",
        "--set",
        "precompression={kind='uniform',pressure=1e5}",
        "--set",
        "packing.size=[8,8,5]",
    ],
]


@pytest.mark.parametrize("words", CHECKED, ids=lambda words: words[0])
def test_the_plan_holds_every_number_of_the_table(words, capsys):
    values = leaves(document(["check", *words, "--json"], capsys))
    assert main(["check", *words]) == 0
    table, _, _ = capsys.readouterr().out.partition("\n\n")
    of_law = 0.2  # "beyond 0.2 R*"
    known = [
        *values,
        of_law,
        *(factor * value for value in values for factor in (1e-3, 1e-9, 2.0**-30)),
    ]
    rows = [row for row in table.splitlines() if not row.startswith(("case", "expected time"))]
    numbers = [
        (number, row)
        for row in rows
        for number in re.findall(r"(?<![\w^])\d+(?:\.\d+)?(?:e[-+]\d+)?", row)
    ]
    assert len(numbers) > 12
    for number, row in numbers:
        assert any(is_rounded(number, value) for value in known), f"{number} of {row!r}"


def test_keys(capsys):
    assert len(document(["keys", "--json"], capsys)) == len(tables())
    (table,) = document(["keys", "load", "velocity", "--json"], capsys)
    (key,) = table["keys"]
    assert (table["name"], key["name"], key["unit"], key["default"]) == (
        "load",
        "velocity",
        "m/s",
        "5.0",
    )


@pytest.mark.parametrize(("works", "status"), [(True, 0), (False, 1)])
def test_doctor(works, status, monkeypatch, capsys):
    monkeypatch.setattr(
        doctor, "examine", lambda profile: [Finding("plugin", works, "found", "mend it")]
    )
    part = {"part": "plugin", "works": works, "found": "found", "remedy": "mend it"}
    shown = document(["doctor", "--json"], capsys, status)
    assert (shown["works"], shown["parts"]) == (works, [part])


def test_run_and_analyse(tmp_path, capfd):
    place = tmp_path / "tiny"
    summary = document(["run", "fcc-small", "-o", str(place), *TINY, "--json"], capfd)
    assert summary == json.loads((place / "summary.json").read_text())
    again = document(["analyse", str(place), "--no-figures", "--json"], capfd)
    assert again == summary


def test_plan_of_a_scan(tmp_path, capfd):
    path = tmp_path / "pair.toml"
    path.write_text(SCAN)
    plan = document(["scan", str(path), "-o", str(tmp_path / "pair"), "--plan", "--json"], capfd)
    assert (plan["name"], plan["n_points"], plan["n_left"], plan["n_spheres_most"]) == (
        "pair",
        2,
        2,
        2,
    )
    suite = document(
        ["scan", "protection", "-o", str(tmp_path / "suite"), "--plan", "--json"], capfd
    )
    assert suite["name"] == "protection" and suite["wall_time_s"] > 0 and len(suite["scans"]) > 1


def test_end_of_a_scan(tmp_path, capsys):
    place = write_scan(
        tmp_path / "scan", grid(load__velocity=[1.0, 2.0, 3.0]), failed={2: "no end"}, missing=[3]
    )
    print_json(outcome_values(ScanOutcome(place, done=1, failed=1, missing=1, stopped=None)))
    found = json.loads(capsys.readouterr().out)
    assert (found["done"], found["failed"], found["missing"], found["stopped"]) == (1, 1, 1, None)
    assert [point["labels"]["load.velocity"] for point in found["points"]] == [1.0, 2.0, 3.0]
    assert [point["status"] for point in found["points"]] == ["done", "failed", "missing"]
    assert found["points"][1]["reason"] == "no end"
    assert found["points"][0]["summary"]["n_spheres"] > 0 and not found["points"][2]["summary"]


@pytest.mark.validation
def test_a_scan_prints_one_document(tmp_path, capfd):
    path = tmp_path / "pair.toml"
    path.write_text(SCAN)
    found = document(
        ["scan", str(path), "-o", str(tmp_path / "pair"), "--jobs", "1", "--json"], capfd
    )
    assert (found["done"], found["failed"], found["missing"], found["stopped"]) == (2, 0, 0, None)
    assert all(point["summary"]["n_spheres"] == 2 for point in found["points"])


def test_doctor_with_the_profile_of_a_cluster(tmp_path, monkeypatch):
    """Existing commands are found, the launcher only after the commands of `before`; for others a
    remedy is given.
    """
    tools = tmp_path / "tools"
    bare = tmp_path / "bare"
    for folder in (tools, bare):
        folder.mkdir()
        (folder / "bash").symlink_to("/bin/bash")
    monkeypatch.setenv("PATH", str(bare))
    for name in ("sbatch", "scancel", "squeue", "srun", "start-ranks"):
        (tools / name).write_text("#!/bin/sh\n")
        (tools / name).chmod(0o755)
    profile = tmp_path / "cluster.toml"
    profile.write_text(
        f'[slurm]\nlauncher = "start-ranks --mpi=pmix"\nbefore = ["PATH={tools}:$PATH"]\n'
    )
    found = {finding.part: finding for finding in doctor._cluster(profile)}
    assert (
        found["profile"].works
        and found["start-ranks command"].works
        and found["commands of before"].works
    )
    assert not found["sbatch command"].works and "login node" in found["sbatch command"].remedy
    monkeypatch.setenv("PATH", str(tools))
    assert all(
        finding.works for finding in doctor._cluster(profile) if finding.part.endswith("command")
    )
    profile.write_text('[slurm]\nlauncher = "no-such-launcher"\npartitoin = "x"\n')
    (fault,) = doctor._cluster(profile)
    assert not fault.works and "partitoin" in fault.found
    profile.write_text(
        '[slurm]\nlauncher = "no-such-launcher"\nbefore = ["no-such-module load mpi"]\n'
    )
    found = {finding.part: finding for finding in doctor._cluster(profile)}
    assert "launcher or before" in found["no-such-launcher command"].remedy
    assert (
        "no-such-module" in found["commands of before"].found
        and not found["commands of before"].works
    )
