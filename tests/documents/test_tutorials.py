"""Numbers in the tutorials agree with the runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from granwave.lammps_inputs.case.packing.grains import read_grains
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.workflows.cli.main import main
from tests.documents.pages import ROOT, blocks, write_files

_HEAD = 9  # lines of a dump before the grains
_LABEL = 37  # characters of a line of a summary before its value
_NUMBER = re.compile(r"\d[\d.]*(?:e[+-]?\d+)?")
DUMP = ROOT / "docs" / "tutorials" / "somebodys-dump.md"


def test_from_somebodys_dump_to_an_impact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_files(DUMP, tmp_path)
    shown = [block.text for block in blocks(DUMP) if block.language == "text" and not block.caption]
    rows, summary, warning = (text.splitlines() for text in shown)
    assert main(["check", "struck.toml"]) == 0
    printed = capsys.readouterr().out.replace(f"{tmp_path.resolve()}", "/home/me").splitlines()
    for row in rows:
        assert row in printed
    assert main(["run", "struck.toml", "--no-figures"]) == 0
    output = capsys.readouterr()
    lines = {line[:_LABEL].strip(): line for line in output.out.splitlines()}
    for row in summary:
        line = lines[row[:_LABEL].strip()]
        assert _NUMBER.sub("#", line) == _NUMBER.sub("#", row)
        relative = {"energy in": 1e-5, "yielded contacts": 0.01}.get(row[:_LABEL].strip(), 1e-3)
        if not row.startswith("balance error"):  # depends on the machine's rounding
            shown_numbers = list(map(float, _NUMBER.findall(row)))
            numbers = list(map(float, _NUMBER.findall(line)))
            assert numbers == pytest.approx(shown_numbers, rel=relative)
    assert warning == [line for line in output.err.splitlines() if line.startswith("granwave: ")]


def test_six_digits_leave_overlaps(tmp_path: Path) -> None:
    write_files(DUMP, tmp_path)
    path = tmp_path / "crystal.dump"
    lines = path.read_text().splitlines()
    rows = [" ".join(f"{float(word):g}" for word in line.split()) for line in lines[_HEAD:]]
    path.write_text("\n".join([*lines[:_HEAD], *rows]) + "\n")
    grains = read_grains(GrainSource(path))
    deepest = Places(grains, float(grains.diameter[0])).overlapping()[1][0]
    assert deepest == pytest.approx(0.07e-6, rel=0.05)
    assert deepest < 4 * grains.half_unit.max()
