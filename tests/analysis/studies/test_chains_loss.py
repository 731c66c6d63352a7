"""The study of losses: restitution against velocity, and waves that decay."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.registry import STUDIES
from granwave.analysis.studies.study import make_studies
from granwave.workflows import load_case, load_scan, run_case


def run(directory: Path, name: str, changes: dict[str, Any]) -> ChainRun:
    outcome = run_case(load_case(name, {"run.frames": 2} | changes), directory, figures=False)
    (found,) = ChainRun.among([(directory.name, directory, outcome.summary)])
    return found


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    folder = tmp_path_factory.mktemp("loss")
    losses = {"time": {"time": 3e-7}, "dashpot": {"dashpot": {"restitution": 0.9}}}
    runs = [
        run(folder / f"{kind}{speed}", "elastic-impact",
            {"contact.loss": loss, "load.velocity": speed, "packing.size": 2, "run.end_time": 2e-4})
        for kind, loss, speed in (("time", losses["time"], 0.1), ("dashpot", losses["dashpot"], 10.0))
    ]  # fmt: skip
    chain = {"packing.size": 30, "run.end_time": 7e-4, "output.history": 1000}
    return [*runs, run(folder / "chain", "elastic-impact", chain | {"contact.loss": losses["time"]})]


@pytest.mark.validation
def test_restitution_and_decay(found: list[ChainRun]) -> None:
    """Restitution is that of the formulas; F^(-1/6) grows linearly along a chain with a loss time."""
    (study,) = make_studies({"loss": found})
    checked = [row for row in study.rows if row.verification]
    assert len(checked) == 2
    for row in checked:
        assert row.ours == pytest.approx(row.theory, abs=1e-3)
    (decay,) = [row for row in study.rows if row.quantity.startswith("Largest force")]
    assert decay.ours is not None and 0.75 < decay.ours < 0.95
    share = float(decay.remark.partition("to ")[2].partition(" %")[0])
    assert "F^(-1/6)" in decay.remark and share < 2
    (picture,) = study.pictures
    assert picture.drawing.columns["time_0_3_us_restitution"].shape == (1,)


def test_scan_names_its_study() -> None:
    assert load_scan("loss").study == ("loss",) and "loss" in STUDIES
