"""Chains of others: small runs against what their rows say."""

from __future__ import annotations

from pathlib import Path

import pytest

import granwave as gw
from tests.helpers.scripts import study_of

SHORT = {"run.end_time": 3e-4, "run.frames": 2, "output.history": 1000}


def test_tapered_chain_hands_on_less_than_hard_spheres(tmp_path: Path) -> None:
    """The last of like beads gets nearly all; that of shrinking ones less than hard spheres would hand on."""
    shrinking = [{"index": [n], "diameter": 0.00952 * 0.9 ** (n - 1)} for n in range(2, 21)]
    runs = [
        gw.run("elastic-impact", SHORT | {"packing.size": 20} | more, directory=tmp_path / f"{k}", progress=False)
        for k, more in enumerate(({"run.end_time": 6e-4}, {"replace": shrinking}))
    ]
    study = study_of("benchmarks/chains_tapered.py", runs)
    last = [row for row in study.rows if row.quantity.startswith("Energy of the last bead")]
    assert [row.theory for row in last] == [1.0, pytest.approx(0.6234, abs=1e-3)]
    like, tapered = (row.ours or 0.0 for row in last)
    assert like > 0.95 and 0.2 < tapered < 0.35
    assert len(study.pictures) == 1
