"""Invalid command-line options: one line with the value found and expected, exit status 2, no files."""

from __future__ import annotations

from pathlib import Path

import pytest

from granwave.lammps_inputs.case.contact import LAWS
from granwave.workflows.cli.main import main


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["check", "fcc-small", "--np", "two"], "--np: found two, expected a number"),
        (["check", "fcc-small", "--np", "0"], "--np: found 0, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--np", "1.5"], "--np: found 1.5, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--np", "nan"], "--np: found nan, expected a whole number, 1 or more"),
        (["run", "fcc-small", "--checkpoint", "-5"], "--checkpoint: found -5, expected a number above 0 (s)"),
        (["run", "fcc-small", "--checkpoint", "inf"], "--checkpoint: found inf, expected a number above 0 (s)"),
        (["run", "fcc-small", "--checkpoint", "soon"], "--checkpoint: found soon, expected a number"),
        (["run", "fcc-small", "-o", ""], '-o: found the empty name'),
        (["scan", "restitution", "--jobs", "x"], "--jobs: found x, expected a number"),
        (["scan", "restitution", "--jobs", ""], "--jobs: found nothing, expected a number"),
        (["scan", "restitution", "--profile", " "], "--profile: is for --executor slurm; leave it out"),
        (["bench", "--repeats", "0"], "--repeats: found 0, expected a whole number, 1 or more"),
        (["bench", "--parts", "styles,speed"], "--parts: found speed, expected some of styles,sizes,ranks,study"),
        (["law", "--radius", "x"], "--radius: found x, expected a number"),
        (["law", "--radius", "1e300"], "--radius: found 1e300, expected a length from 1e-18 to 1e+06 m"),
        (["law", "--radius", "nan"], "--radius: found nan, expected a length from 1e-18 to 1e+06 m"),
        (["law", "--max-overlap", "1e300"], "--max-overlap: found 1e300, expected a number above 0 and at most 1e+06"),
        (["law", "--law", "hertzz"], f'--law: found "hertzz", expected one of {", ".join(LAWS)}; did you mean hertz?'),
        (["rn", "fcc-small"], "did you mean run?"),
        (["run"], "the following arguments are required: CASE; granwave run --help tells more"),
        (["run", "fcc-small", "--velocity", "3"], "unrecognized arguments: --velocity 3; keys of a case are set by --set"),
        (["run", "fcc-small", "--resume", "--force"], "--force: not allowed with argument --resume"),
        (["check", "fcc-small", "--set", "packing.size=4,4,3"], "expected a TOML value or a bare word; a list is [4,4,3]"),
        (["check", "fcc-small", "--set", "velocity"], 'found "velocity", expected KEY=VALUE such as load.velocity=10'),
        (["check", "fcc-small", "--set", "replace.1.index=2"], "found no [[replace]] tables, expected 1 or more"),
        (["check", "fcc-small", "--set", "name=-rf"], 'name: found "-rf", expected a plain name'),
        (["check", "fcc-small", "--set", 'name=" x"'], 'name: found " x", expected a plain name'),
        (["check", "./-x.toml"], "from the name of the file: give the case a name of its own"),
        (["scan", "./-scan.toml", "--plan"], 'name: found "-scan", expected a plain name'),
    ],
)  # fmt: skip
def test_one_line_says_what_is_wrong(
    words: list[str], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "-x.toml").write_text('material = "brass"\n[packing]\nkind = "chain"\nsize = 2\ndiameter = 0.01\n')
    (tmp_path / "-scan.toml").write_text('case = "fcc-small"\n[grid]\nload.velocity = [1]\n')
    before = sorted(tmp_path.rglob("*"))
    try:
        status = main(words)
    except SystemExit as end:
        status = int(end.code or 0)
    said = capsys.readouterr().err
    assert status == 2 and said.count("\n") == 1 and said.startswith("granwave: ") and expected in said
    assert sorted(tmp_path.rglob("*")) == before
