"""Two unlike spheres against closed forms and the twin."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.measures.chains.probed_pair import Pair
from granwave.analysis.studies.chains.runs import ChainRun
from granwave.analysis.studies.study import make_studies
from granwave.workflows import load_case, run_case


def run(directory: Path, name: str, changes: dict[str, Any]) -> ChainRun:
    outcome = run_case(load_case(name, changes), directory, figures=False)
    (found,) = ChainRun.among([(directory.name, directory, outcome.summary)])
    return found


PROBED = {"packing.diameter": 0.00952, "run.end_time": 4e-5, "output.probes": [{"contact": [1, 2]}]}


@pytest.fixture(scope="module")
def pairs(tmp_path_factory: pytest.TempPathFactory) -> list[ChainRun]:
    folder = tmp_path_factory.mktemp("pairs")
    cases = {
        "like": {"load.velocity": 50.5},
        "radii": {"load.velocity": 72.8, "replace": [{"index": 2, "diameter": 0.03808}]},
        "weak": {"load.velocity": 48.5, "material": {"preset": "brass", "yield_strength": 500e6}},
        "unlike": {"load.velocity": 52.6, "replace": [{"index": 2, "material": "steel"}]},
    }
    return [run(folder / name, "two-spheres", PROBED | changes) for name, changes in cases.items()]


def test_unlike_spheres_follow_the_law(pairs: list[ChainRun]) -> None:
    """Loading and unloading; values at 0.4 mm of the independent law (tests/twin.py) in kN."""
    found = {one.label: Pair(one) for one in pairs}
    assert max(pair.deviation for pair in found.values()) < 1e-3
    assert all(pair.deepest > 0.199 * pair.law.effective_radius for pair in found.values())
    for name, force in (("like", 8.972), ("weak", 8.266), ("unlike", 9.251)):
        assert found[name].at(0.4e-3) == pytest.approx(1e3 * force, rel=2e-4)
    radius = found["radii"].law.effective_radius
    assert radius == pytest.approx(0.8 * 0.00476)
    assert found["radii"].law.yield_force == pytest.approx(4.996287 * (radius / 2.38e-3) ** 2, rel=1e-6)


def test_unlike_study(pairs: list[ChainRun]) -> None:
    (study,) = make_studies({"unlike-spheres": pairs})
    assert len(study.pictures) == 4
    assert {row.kind for row in study.rows} == {"verification"}  # the law, looked up through itself
    assert all(row.ours == pytest.approx(row.theory, rel=1e-3) for row in study.rows if row.theory)
    assert not make_studies({"unlike-spheres": pairs[:1]})
