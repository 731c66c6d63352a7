"""Continuum cases on the command line and in Python; packings and blocks of equal input."""

from __future__ import annotations

import json
import shlex

import pytest

import granwave as gw
from granwave.workflows.cli.main import main
from tests.helpers.programs.completion import completed

SMALL = ["--set", "packing.size=[6,6,4]"]
UNIT = "energy_input_over_sigma2_D3_E"


def settings(changes: list[str]) -> list[str]:
    """Options for these changes of a case."""
    words = []
    for change in changes:
        words += ["--set", change]
    return words


def plan_of(words, capsys):
    """Return the output of granwave check for a command that would run a case."""
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
    packing = plan_of(["fcc-small", *SMALL, *settings(changes)], capsys)
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
    continuum = plan_of(["half-space", *settings(changes)], capsys)
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


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["elastic-impact"], "the contacts do not yield"),
        (["two-spheres"], "not a block: a chain"),
        (["fcc-small", "--set", "packing.size=[1,1,6]"], "or too narrow"),
        (["elastoplastic-pulse"], "only for impacts and strikers along z"),
        (["fcc-small", *SMALL, "--set", "load.angle=30"], "only for impacts and strikers along z"),
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
    assert any(
        line.startswith("continuum of equal input: granwave continuum half-space --set")
        for line in lines
    )


STRIKER = ["--set", "load={kind='striker'}", "--set"]


@pytest.mark.parametrize(("velocity", "is_there"), [("0,0,5", True), ("1,0,5", False)])
def test_a_striker_along_z_has_a_continuum_case(velocity, is_there, capsys):
    striker = f"striker=[{{touches='centre',velocity=[{velocity}]}}]"
    found = plan_of(["fcc-small", *SMALL, *STRIKER, striker], capsys)["counterpart"]["command"]
    same = plan_of(["fcc-small", *SMALL], capsys)["counterpart"]["command"]
    assert found == (same if is_there else None)


def test_check_of_finite_elements(capsys):
    assert plan_of(["half-space"], capsys)["n_elements"] == 62500
    contact = plan_of(["sphere-contact"], capsys)
    assert contact["command"] == "continuum" and "counterpart" not in contact


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("granwave continuum half", ["half-space"]),
        ("granwave continuum half-space --set punch.v", ["punch.velocity="]),
        ("granwave continuum sphere-contact --set run.max", ["run.max_overlap="]),
        ("granwave continuum --set partner.r", ["partner.radius="]),
        ("granwave fit --material steel", ["steel"]),
    ],
)
def test_words(line, words, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert completed(line) == words


def test_cases_have_their_group(granwave):
    listed = granwave("cases", "--all").stdout.splitlines()
    place = listed.index("Finite elements (granwave continuum):")
    assert listed[place + 1].startswith("case  half-space ")
    assert listed.index("Scans:") > place


def test_continuum(tmp_path):
    run = gw.run("half-space", directory=tmp_path, run__elements=200, run__end_time=2e-6)
    assert run["n_elements"] > 100 and "elements" in repr(run) and run.figures == ()
    with pytest.raises(gw.OutputFormatError, match=r"expected the result.h5 of a run of spheres"):
        _ = run.spheres


def test_a_case_in_python():
    assert type(gw.case("half-space", punch__velocity=3)).__name__ == "ContinuumCase"


def test_ranks_are_of_packings():
    message = "ranks: found 2, expected 1: half-space is a continuum case"
    with pytest.raises(gw.InputError, match=message):
        gw.run("half-space", ranks=2)
