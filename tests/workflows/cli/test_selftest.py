"""``granwave selftest``: it passes, leaves no files, and reports each problem."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os

import pytest

from granwave.lammps_inputs.errors import RunError
from granwave.workflows.cli.installation import selftest
from granwave.workflows.cli.main import main

# computed apart from the package: Hertz and Thornton for two brass spheres of 10 mm, 1 m/s
KNOWN = {
    "two spheres, Hertz: peak force": "207.201 N",
    "two spheres, Hertz: contact": "39.5126 µs",
    "plastic pair: peak force": "98.0419 N",
    "plastic pair: restitution": "0.41425",
}


def test_it_passes_and_leaves_nothing(granwave, tmp_path, monkeypatch):
    monkeypatch.setitem(os.environ, "TMPDIR", str(tmp_path))
    done = granwave("selftest", "--json", cwd=tmp_path)
    found = json.loads(done.stdout)
    assert done.returncode == 0 and found["passed"], done.stdout + done.stderr
    rows = {row["what"]: row for row in found["checks"]}
    assert all(
        rows[name]["expected"] == value == rows[name]["found"] for name, value in KNOWN.items()
    )
    assert rows["2 ranks: at work"]["found"] == "2" and rows["2 ranks: fields as on one rank"]["ok"]
    assert any(name.startswith("resumed at step ") for name in rows)
    assert list(tmp_path.iterdir()) == []


def test_wrong_numbers_are_told_with_what_to_do(monkeypatch, capsys):
    """A deviation from a stored number, a failed run, and a run that was not stopped each have a
    line.
    """

    def refuse(scratch):
        raise RunError("LAMMPS: no such style")

    monkeypatch.setattr(selftest, "_DISSIPATED", selftest._DISSIPATED * (1 + 1e-4))
    monkeypatch.setattr(selftest, "_hertz", refuse)
    monkeypatch.setattr(selftest, "_stopped_early", lambda *_: contextlib.nullcontext())
    assert main(["selftest", "--np", "1"]) == 1
    table, _, mend = capsys.readouterr().out.partition("\n\n")
    rows = {line[:34].strip(): line[34:].split("  ") for line in table.splitlines()}
    assert [name for name, words in rows.items() if words[-1].strip() == "NO"] == [
        "two spheres, Hertz", "FCC 8 × 8 × 5: dissipated", "stopped run",
    ]  # fmt: skip
    assert "LAMMPS: no such style" in table and "finished" in " ".join(rows["stopped run"])
    assert mend.count("fix  ") == 3 and "do not use it" in mend and "do not use --resume" in mend
    assert not [name for name in rows if "ranks" in name]


def test_without_lammps_nothing_is_computed(monkeypatch, capsys):
    parts = [
        dataclasses.replace(one, works=one.part != "lammps module", remedy="mend it")
        for one in selftest.examine()
    ]
    monkeypatch.setattr(selftest, "examine", lambda: parts)
    monkeypatch.setattr(selftest, "run_case", None)
    assert main(["selftest"]) == 1
    said = capsys.readouterr().out
    assert "not run" in said and "fix  lammps module: mend it" in said


@pytest.mark.parametrize(
    ("found", "ok"), [(1.0, True), (1.00004, True), (1.00006, False), (float("nan"), False)]
)
def test_digits(found, ok):
    assert selftest._number("x", "N", 1.0, found).ok is ok


def test_under_a_launcher_it_is_refused(monkeypatch, capsys):
    monkeypatch.setenv("PMI_RANK", "0")
    assert main(["selftest"]) == 2
    assert "start it without one" in capsys.readouterr().err
