"""A run whose energy balance is refused says what to change."""

from __future__ import annotations

import sys

from granwave.workflows.__main__ import run


def test_a_timestep_that_is_too_long(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    changes = ["packing.size=[4,4,3]", "run.end_time=4e-5", "run.timestep=4e-7"]
    words = [word for change in changes for word in ("--set", change)]
    monkeypatch.setattr(sys, "argv", ["granwave", "run", "fcc-small", *words, "-o", "long", "--no-figures"])
    assert run() == 1
    error = capsys.readouterr().err
    assert "the energy balance was refused: it misses by" in error and "leave out run.timestep" in error
    assert (tmp_path / "long" / "summary.json").is_file()
