"""Cases of equal normalised input: a packing's in the continuum, and the reverse."""

from __future__ import annotations

import json
import shlex

import pytest

from granwave.lammps_inputs.case.material import material
from granwave.workflows.cli.main import main
from granwave.workflows.counterpart import energy_unit, inputs_of_packing
from granwave.workflows.library import load_case
from granwave.workflows.run.driver import run_case

SMALL = ["--set", "packing.size=[6,6,4]"]
UNIT = "energy_input_over_sigma2_D3_E"


def plan_of(words, capsys):
    """Return what granwave check says of a command that would run a case."""
    without_directory = words[: words.index("-o")] if "-o" in words else words
    assert main(["check", *without_directory, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "changes",
    [
        [],
        ["material=steel"],
        ["load.spheres=7", "load.velocity=2"],
        ["packing.diameter=0.004", "packing.kind=bcc", "load.velocity=12"],
        ["material.youngs_modulus=100e9", "material.density=5000"],
    ],
)
def test_the_continuum_case_has_the_input_of_the_packing(changes, capsys):
    packing = plan_of(["fcc-small", *SMALL, *(word for change in changes for word in ("--set", change))], capsys)
    program, verb, *words = shlex.split(packing["counterpart"]["command"])
    assert (program, verb) == ("granwave", "continuum")
    continuum = plan_of(words, capsys)
    assert continuum["command"] == "continuum"
    assert continuum[UNIT] == pytest.approx(packing[UNIT], rel=1e-9)
    assert continuum["energy_input_J"] == pytest.approx(packing["energy_input_J"], rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "struck"),
    [([], "load.spheres=1"), (["punch.mass=0.2", "punch.velocity=40"], "load.spheres=7"),
     (["punch.diameter=0.02", "material=steel"], "load.spheres=1")],
)  # fmt: skip
def test_the_packing_has_the_input_of_the_continuum_case(changes, struck, capsys):
    continuum = plan_of(["half-space", *(word for change in changes for word in ("--set", change))], capsys)
    program, verb, *words = shlex.split(continuum["counterpart"]["command"])
    assert (program, verb) == ("granwave", "run")
    assert struck in words
    packing = plan_of(words, capsys)
    assert packing[UNIT] == pytest.approx(continuum[UNIT], rel=1e-9)


def test_the_command_runs_and_its_summary_agrees(tmp_path, capsys):
    packing = plan_of(["fcc-small", *SMALL], capsys)
    words = shlex.split(packing["counterpart"]["command"])[1:-1]
    coarse = ["--set", "run.elements=400", "--set", "run.end_time=2e-6", "--no-figures", "--json"]
    assert main([*words, str(tmp_path / "block"), *coarse]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["energy_input_normalised"] == pytest.approx(packing[UNIT], rel=1e-9)


def test_inputs_are_those_of_the_summary(tmp_path):
    case = load_case("fcc-small", {"packing.size": [4, 4, 3], "run.end_time": 2e-5, "load.spheres": 3})
    inputs, summary = inputs_of_packing(case), run_case(case, tmp_path, figures=False).summary
    assert inputs.energy == pytest.approx(summary["energy_input_J"], rel=1e-12)
    assert inputs.energy_normalised == pytest.approx(summary["energy_input_normalised"], rel=1e-12)
    assert inputs.velocity_normalised == pytest.approx(summary["velocity_normalised"], rel=1e-12)
    # brass, 10 mm: sigma_y^2 D^3/E = (550e6)^2 1e-6 / 115e9 J
    assert energy_unit(material("brass"), 0.01) == pytest.approx(2.6304347826)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["elastic-impact"], "the contacts do not yield"),
        (["two-spheres"], "no block: a chain"),
        (["fcc-small", "--set", "packing.size=[1,1,6]"], "or too narrow"),
        (["elastoplastic-pulse"], "impacts and strikers along z alone"),
        (["fcc-small", *SMALL, "--set", "load.angle=30"], "impacts and strikers along z alone"),
    ],
)
def test_where_there_is_none_it_says_why(words, reason, capsys):
    counterpart = plan_of(words, capsys)["counterpart"]
    assert counterpart["command"] is None and reason in counterpart["reason"]


def test_check_prints_inputs_and_the_command(capsys):
    assert main(["check", "fcc-small", *SMALL]) == 0
    lines = {line.partition("  ")[0]: line for line in capsys.readouterr().out.splitlines()}
    assert "0.0556324 J" in lines["energy in"]
    assert "8434.55 F_y alpha_y" in lines["energy normalised"]
    assert "47.4259" in lines["velocity normalised"]
    assert any(line.startswith("continuum of equal input: granwave continuum half-space --set") for line in lines)
