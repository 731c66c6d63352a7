"""A row that switches, of the thesis, chapter 8: small runs against an independent solver and geometry."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from tests.helpers.scripts import row, study_of


def run(directory: Path, name: str, changes: dict[str, Any]) -> gw.Run:
    return gw.run(name, changes, directory=directory, figures=False, progress=False)


def test_row_without_cylinders(tmp_path: Path) -> None:
    """Peaks of the second solver, and how far a wave moves a sphere."""
    bare = {"grains": [], "guide": [{"free": "z"}], "boundary.sides": "free", "run.end_time": 3.3e-4}
    runs = [
        run(tmp_path / str(n), "gap-switch-loose", bare | changes)
        for n, changes in enumerate((
            {}, {"load.velocity": 0.907766}, {"load.velocity": 0.804649}, {"packing.size": 60, "run.end_time": 6e-4},
        ))
    ]  # fmt: skip
    study = study_of("thesis/chapter_8/no_cylinders.py", runs)
    checked = [one for one in study.rows if one.theory is not None]
    assert len(checked) == 7
    for one in checked:
        assert one.ours == pytest.approx(one.theory, rel=1e-3), one.quantity


def test_where_plates_put_cylinders(tmp_path: Path) -> None:
    """Width of open gaps, and the place of loose cylinders; rigid plates make the first peak another."""
    gaps = {n: [[k, width] for k in range(14, 19)] for n, width in (("usual", 3.45424064e-4), ("wide", 3.72866858e-4))}
    opened = {
        "boundary.friction": 0.185, "run.end_time": 1e-6,
        "grains.1.ring": {"n": 2, "radius": "touching", "gap": [14, 15, 16, 17, 18]},
    }  # fmt: skip
    runs = [
        run(tmp_path / "usual", "gap-switch", opened | {"packing.gaps": gaps["usual"]}),
        run(tmp_path / "wide", "gap-switch", opened | {"packing.gaps": gaps["wide"]}),
        run(tmp_path / "rigid", "gap-switch", opened | {"packing.gaps": gaps["usual"], "boundary.sides": "wall"}),
        run(tmp_path / "loose", "gap-switch-loose", {"run.end_time": 1e-6}),
    ]
    study = study_of("thesis/chapter_8/plates.py", runs)
    for start in ("Width of the open gaps, plates 15.975", "Width of the open gaps, plates 15.95", "Distance", "Gap"):
        for one in (one for one in study.rows if one.quantity.startswith(start)):
            assert one.ours == pytest.approx(one.theory, rel=1e-5)
    assert row(study, "First peak at sphere 21, open gaps, 10 cylinders, friction 0.185, rigid plates")
    assert row(study, "First peak at sphere 21, open gaps, 10 cylinders, friction 0.185, plates 15.95 mm apart")
