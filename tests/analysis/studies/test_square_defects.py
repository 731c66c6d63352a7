"""Square packings with friction; the wave of a chain."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from granwave.analysis.measures.chains.hertz_chain import discrete_width
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Study, make_studies
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import run_case

CASES = Path(__file__).parents[3] / "workflows" / "cases"
#: A packing of 8 x 10 that the strikers hit between X1Y5 and X1Y6.
SMALL = {
    "packing.size": [8, 10],
    "striker.1.touches": [33, 41],
    "striker.2.touches": 81,
    "sensor": [],
    "run.end_time": 3.2e-4,
    "run.frames": 2,
}


def study(name: str, case: str, directory: Path, *changes: dict[str, Any]) -> Study:
    runs = []
    for n, change in enumerate(changes):
        read = load_case(CASES / f"{case}.toml", change)
        runs.append(
            FinishedRun(str(n), directory / str(n), read, run_case(read, directory / str(n), figures=False).summary)
        )
    (found,) = make_studies({name: runs})
    return found


@pytest.mark.validation
def test_friction_takes_from_the_edge_chains(tmp_path: Path) -> None:
    weight = SMALL | {"precompression.kind": "gravity", "run.frames": 121, "run.end_time": 5e-4}
    own, floor = ({"contact.friction": a, "boundary.friction": b} for a, b in ((0.2, 0.0), (0.0, 0.3)))
    found = study("square-friction", "square-in-plane", tmp_path, weight, weight | own, weight | floor)
    rows = {row.quantity: row.ours for row in found.rows}
    central, edge = (rows[f"Loss of peak velocity, {name}: friction 0.2 between spheres"]
                     for name in ("central chains, sphere 6", "edge chains, sphere 5"))  # fmt: skip
    assert 1 < central < 4 and 30 < edge < 55
    assert (
        rows["Share of the friction between spheres at contacts of the two struck ones: friction 0.2 between spheres"]
        > 60
    )
    (lost,) = [row for row in found.rows if row.quantity.startswith("Lost to the floor")]
    assert lost.ours == pytest.approx(lost.theory, rel=0.1)


def test_width_of_the_wave_of_the_chain_itself() -> None:
    assert discrete_width() == pytest.approx(1.5791, abs=1e-4)  # runs of chains give 1.579
