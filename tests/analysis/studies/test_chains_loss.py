"""Composite chains with a dashpot."""

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


def test_a_composite_chain_with_losses(tmp_path: Path) -> None:
    """The output pulse falls; the study of smooth chains leaves these out, and the source's speeds are beside ours."""
    short = {"replace.1.index": {"first": 8, "last": 10}, "sensor.2.id": 12, "run.end_time": 4e-4,
             "contact.loss": {"dashpot": {"restitution": 0.97}}}  # fmt: skip
    chain = run(tmp_path / "run", "composite-chain", short)
    (study,) = make_studies({"composite-loss": [chain]})
    (speed,) = study.rows
    assert (speed.quantity, speed.source) == ("V, N2 = 3, brass-composite, restitution 0.97", 469.0)
    assert speed.ours == pytest.approx(508.2, rel=1e-3)
    assert not make_studies({"composite-chain": [chain], "composite-holder": [chain]})


@pytest.mark.parametrize("name", ["composite-loss"])
def test_scans_name_their_study(name: str) -> None:
    assert load_scan(name).study == (name,) and name in STUDIES
