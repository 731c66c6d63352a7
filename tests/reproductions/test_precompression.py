"""Packings and chains with a history: precompressed, settled, preloaded and hit before; and the
texts of their scripts.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest

import granwave as gw
from granwave.analysis.studies.study import Study, make_studies

FOLDER = Path(__file__).parents[2] / "reproductions" / "precompression"
DENTED = {"packing__kind": "fcc", "packing__size": [4, 4, 3], "run__end_time": 5e-4}
ROWS: dict[str, dict[str, Any]] = {
    "falling row": {"packing__size": 5, "load__index": [1, 2, 3, 4, 5], "run__end_time": 1e-3},
    "loose row": {
        "packing__size": 10,
        "packing__gaps": [[n, 1e-4] for n in range(1, 10)],
        "run__end_time": 3e-3,
    },
    "pressed": DENTED | {"contact__initial_overlap": {"force": 3e3}},
    "fresh": DENTED,
}
run = partial(gw.run, progress=False, run__frames=2)


def made(script: str, *runs: gw.Run) -> Study:
    (study,) = make_studies({str(FOLDER / script): runs})
    assert not study.failed
    return study


def test_impact_on_top_of_pressure(tmp_path: Path) -> None:
    """The wave arrives earlier; dissipation counts from the static state."""
    small = {"packing__size": [6, 6, 4], "run__end_time": 1.5e-4}
    pressed = {"precompression": {"kind": "uniform", "pressure": 1e5}}
    without, under = runs = [
        run("fcc-small", directory=tmp_path / f"{n}", **small, **more)
        for n, more in enumerate(({}, pressed))
    ]
    assert 0.5 < under["dissipated_fraction"] < 0.95
    assert under["base_arrival_s"] < without["base_arrival_s"]
    assert under["energy_balance_error"] < 1e-5
    study = made("impacts.py", *runs)
    assert len(study.tables[0].rows) == 2 and "More than 100 %" not in study.verdict[0]


def test_more_than_the_input_is_dissipated(tmp_path: Path) -> None:
    """A weak impact on contacts near yield causes the packing to settle under its load, and the
    script states this.
    """
    weak = {
        "packing__size": [5, 5, 3],
        "run__end_time": 2e-4,
        "load__velocity": 0.2,
        "precompression__kind": "uniform",
    }
    runs = [
        run("fcc-small", directory=tmp_path / f"{p:g}", precompression__pressure=p, **weak)
        for p in (1e4, 1.4e5)
    ]
    assert runs[1]["dissipated_fraction"] > 1 > runs[0]["dissipated_fraction"]
    assert runs[1]["energy_elastic_J"] < 0 and runs[1]["energy_balance_error"] < 1e-5
    assert "More than 100 %" in made("impacts.py", *runs).verdict[0]


def test_settled_packing_beside_the_same_as_placed(tmp_path: Path) -> None:
    """Packings settled without friction have about three contacts per sphere, including those with
    the bottom.
    """
    small = {"packing__size": [5, 6, 5], "run__end_time": 2e-4}
    settled = run("settled-fcc", directory=tmp_path / "settled", **small)
    scatter = {"packing__diameter_scatter": 5e-6, "packing__seed": 1}
    placed = run(
        "fcc-small", directory=tmp_path / "placed", **small, boundary__sides="periodic", **scatter
    )
    ideal = run("fcc-small", directory=tmp_path / "ideal", **small, boundary__sides="periodic")
    assert settled["precompression_residual"] < 1e-6
    assert 2.5 < settled.result["prestage/contacts"][-1] / settled["n_spheres"] < 5
    assert max(settled["base_arrival_s"], ideal["base_arrival_s"]) < placed["base_arrival_s"]


def test_preconditioned_chain_is_elastic_up_to_its_level(tmp_path: Path) -> None:
    fresh, slow, elastic, losing = runs = [
        run("preconditioned-chain", directory=tmp_path / f"{level:g}-{velocity:g}", packing__size=40, run__end_time=5e-4,
            load__velocity=velocity, contact__initial_overlap={"force": level} if level else 0.0)
        for level, velocity in ((0, 10.0), (2e3, 1.0), (2e3, 2.0), (2e3, 10.0))
    ]  # fmt: skip
    assert fresh["dissipated_fraction"] > 0.5
    assert max(slow["dissipated_fraction"], elastic["dissipated_fraction"]) < 1e-9
    assert elastic["peak_force_N"] < 2e3 < losing["peak_force_N"]
    assert losing["dissipated_fraction"] > 0.1
    peaks = gw.measures.Chain(elastic).of_contacts("peak_force")
    assert peaks[25] == pytest.approx(peaks[12], rel=0.02)
    study = made("preconditioned.py", *runs)
    largest, smallest = study.rows
    assert largest.ours < 1 < smallest.ours and len(study.pictures) == 2
    assert largest.bound and "at most 1" in largest.remark
    assert smallest.bound and "at least 1" in smallest.remark


def test_packing_hit_three_times(tmp_path: Path) -> None:
    """An impact starts with the indentations of the previous one, and dissipates less, farther away
    from the impacted sphere.
    """
    small = {"packing__size": [6, 6, 4], "run__end_time": 3e-4}
    runs = [run("fcc-small", directory=tmp_path / "hit1", **small)]
    for n in (2, 3):
        dents = str(runs[-1].directory / "result.h5")
        runs.append(
            run(
                "fcc-small", directory=tmp_path / f"hit{n}", contact__initial_overlap=dents, **small
            )
        )
    first, second, third = (one["dissipated_fraction"] for one in runs)
    assert third < second < 0.9 * first
    study = made("hits.py", *runs[::-1])
    shown = [row[2].value for row in study.tables[0].rows]
    assert shown == pytest.approx([100 * one for one in (first, second, third)])
    assert study.title == "3 impacts on a packing" and study.pictures


@pytest.fixture(scope="module")
def kept_and_forgotten(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[gw.Run]]:
    folder = tmp_path_factory.mktemp("dents")
    return {
        name: [
            run(
                "sphere-on-wall",
                directory=folder / f"{name} {gap:g}",
                boundary__forget_gap=gap,
                load__velocity=5.0,
                **keys,
            )
            for gap in (0.1, 1e-9)
        ]
        for name, keys in ROWS.items()
    }


def test_where_a_dent_is_met_again_it_counts(kept_and_forgotten: dict[str, list[gw.Run]]) -> None:
    """The memory hardly affects a single impact and a falling chain; it affects loose and preloaded
    packings.
    """

    def change(name: str, key: str) -> float:
        kept, forgotten = (one[key] for one in kept_and_forgotten[name])
        return forgotten / kept - 1

    for name in ("fresh", "falling row"):
        assert abs(change(name, "energy_dissipated_J")) < 0.01
        assert abs(change(name, "wall_peak_force_N")) < 0.01
    assert change("loose row", "wall_peak_force_N") < -0.1
    assert change("loose row", "energy_dissipated_J") > 0.02
    kept, forgotten = (one["dissipated_fraction"] for one in kept_and_forgotten["pressed"])
    assert kept == 0 and forgotten > 0.01  # a blow below what pressed it before


def test_the_table_of_dents_has_a_line_for_each_pair(
    kept_and_forgotten: dict[str, list[gw.Run]],
) -> None:
    study = made("dents.py", *(one for pair in kept_and_forgotten.values() for one in pair))
    table, note = study.tables
    assert len(table.rows) == len(ROWS)
    loose = next(row for row in table.rows if "gaps of 0.1 mm" in row[0].text)
    assert loose[-1].text.startswith("-")
    assert "separate with 0.561 of this speed, and would separate with 0.735" in note.text
    assert "Chain of 5" in study.verdict[0] and "preconditioned contacts" in study.verdict[1]
