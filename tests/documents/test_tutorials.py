"""Numbers in the tutorials agree with the runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from granwave.lammps_inputs.case.packing.grains import read_grains
from granwave.lammps_inputs.load_case import load_case
from granwave.lammps_inputs.packing.places import Places
from granwave.lammps_inputs.readers.source import GrainSource
from granwave.workflows.cli.main import main
from granwave.workflows.run.driver import run_case
from tests.documents.pages import ROOT, blocks, write_files

_HEAD = 9  # lines of a dump before the grains
DUMP = ROOT / "docs" / "tutorials" / "somebodys-dump.md"


def test_from_somebodys_dump_to_an_impact(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_files(DUMP, tmp_path)
    shown = [block.text for block in blocks(DUMP) if block.language == "text" and not block.caption]
    rows, summary = (text.splitlines() for text in shown)
    assert main(["check", "struck.toml"]) == 0
    printed = capsys.readouterr().out.replace(f"{tmp_path.resolve()}", "/home/me").splitlines()
    for row in rows:
        assert row in printed
    values = run_case(load_case("struck.toml"), tmp_path / "run", figures=False).summary
    of_page = {line[:28].strip(): line[28:].split()[0] for line in summary}
    assert values["energy_input_J"] == pytest.approx(float(of_page["energy in"]), rel=1e-5)
    share = values["plastic_fraction"]
    assert share == pytest.approx(float(of_page["dissipated"]), rel=1e-3)
    assert values["n_plastic_contacts"] == pytest.approx(int(of_page["yielded contacts"]), rel=0.01)
    depth = values["plastic_zone_depth_m"]
    assert depth == pytest.approx(float(of_page["plastic zone, depth"]), rel=1e-3)


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
