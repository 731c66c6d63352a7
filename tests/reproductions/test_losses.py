"""Losses in contacts: small runs against the formulas of restitution and of decay."""

from __future__ import annotations

from pathlib import Path

import pytest

import granwave as gw
from tests.helpers.scripts import columns, study_of

LOSSES = ({"time": 3e-7}, {"restitution": 0.9, "velocity": 1.0}, {"dashpot": {"restitution": 0.9}})
PAIR = {"packing.size": 2, "run.end_time": 2e-4, "run.frames": 2}
CHAIN = {"packing.size": 30, "run.end_time": 7e-4, "output.history": 1000, "run.frames": 2}


@pytest.mark.validation
def test_restitution_and_decay(tmp_path: Path) -> None:
    """Restitution is that of the formulas; F^(-1/6), or ln F of a dashpot, is linear along a chain."""
    runs = [
        gw.run("elastic-impact", changes | {"contact.loss": loss}, directory=tmp_path / f"{k}{n}", progress=False)
        for k, loss in enumerate(LOSSES)
        for n, changes in enumerate((PAIR | {"load.velocity": 0.1}, PAIR | {"load.velocity": 1.0}, CHAIN))
    ]
    study = study_of("losses/loss.py", runs)
    checked = [one for one in study.rows if one.verification]
    assert len(checked) == 8
    for one in checked:
        assert one.ours == pytest.approx(one.theory, abs=1e-3)
    for kind, law in (("time", "F^(-1/6)"), ("restitution", "F^(-1/6)"), ("dashpot", "ln F")):
        (decay,) = [
            one for one in study.rows if one.quantity.startswith("Largest force") and f", {kind} " in one.quantity
        ]
        assert decay.ours is not None and 0.6 < decay.ours < 0.95
        assert law in decay.remark and float(decay.remark.partition("to ")[2].partition(" %")[0]) < 2
    assert columns(study)["time_restitution"].shape == (2,)
