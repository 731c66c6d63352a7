"""Rows that filter waves, of the thesis, chapter 7: small runs against check values; packings with grains in holes."""

from __future__ import annotations

from pathlib import Path

import pytest

import granwave as gw
from tests.helpers.scripts import row, study_of


def test_static_state(tmp_path: Path) -> None:
    """Check values of two rows whose walls have moved in."""
    n = 20
    short = {
        "packing.size": n, "hold.1.index": [1, n], "guide.1.index": {"first": 2, "last": n - 1}, "load.index": [4],
        "run.end_time": 2e-6,
    }  # fmt: skip
    runs = [
        gw.run("filter-row", short | {"grains.1.diameter": gamma * 9.525e-3}, directory=tmp_path / str(gamma),
               figures=False, progress=False)
        for gamma in (0.9, 0.56)
    ]  # fmt: skip
    study = study_of("thesis/chapter_7/static_state.py", runs)
    checked = [one for one in study.rows if one.verification]
    assert len(checked) == 8
    for one in checked:
        assert one.ours == pytest.approx(one.theory, rel=2e-5), one.quantity


def test_grains_in_holes(tmp_path: Path) -> None:
    """Steel in the holes: hardly another speed, a larger force at the bottom."""
    size = {
        "packing.size": [3, 4, 46], "load.index": {"first": 1, "last": 12}, "run.end_time": 6e-4, "run.frames": 121,
    }  # fmt: skip
    runs = [
        gw.run("interstitial-fcc", size | change, directory=tmp_path / name, figures=False, progress=False)
        for name, change in (("empty", {"grains": []}), ("steel", {"grains.1.material": "steel"}))
    ]
    study = study_of("thesis/chapter_7/interstitial_fcc.py", runs)
    empty, steel = (row(study, f"Speed of the pulse, {what}").ours for what in ("empty holes", "steel"))
    assert empty < steel < 1.01 * empty
    assert 1.05 < row(study, "Peak at the bottom over that with empty holes, steel").ours < 1.1
