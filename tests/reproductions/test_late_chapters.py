"""Chapters 6 to 8 of the thesis."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.registry import load_study
from tests.helpers.programs.scripts import FOLDER, row, study_of

CHAPTER = FOLDER / "thesis" / "chapter_6"
waves, theory, yielding = (
    load_study(str(CHAPTER / f"confined_{name}.py"))
    for name in ("waves", "asymptotics", "yielding")
)


def run_of(case: str, directory: Path, beads: int, **changes: Any) -> gw.Run:
    keys = {
        "packing.size": beads,
        "grains.1.repeat.times": beads - 1,
        "hold.1.index": [1, beads],
    } | changes
    return gw.run(case, keys, directory=directory, progress=False)


def test_sizes_constants_and_balance() -> None:
    """Check values of the same formulas; the legends follow from an equilibrium without rings,
    except 12.5 and 18.4.
    """
    study = study_of("thesis/chapter_6/confined_sizes.py", [None])  # type: ignore[list-item]
    checked = [row for row in study.rows if row.verification]
    assert len(checked) == 4 * 7 + 4 and all(abs(row.deviation or 0.0) < 3e-4 for row in checked)
    legends = [row for row in study.rows if row.quantity.startswith("a of the legends")]
    assert sum(f"{row.theory:.2g}" != f"{row.source:.2g}" for row in legends) == 2
    assert "printed balance requires 0.00191, the correct balance 0.00134" in legends[7].remark


def test_small_spheres_in_balance() -> None:
    row = waves.Rows.fitting([8, 6], 1.9e-3)
    assert (row.inward > 0).all() and (row.inward < row.shrinks).all()
    assert np.abs(row.outward(row.inward)) == pytest.approx(0, abs=1e-9)


def test_waves_of_the_equations() -> None:
    """Forces at contacts 21 and 51 from an earlier program, and a decay that is uniform because the
    wave is self-similar.
    """
    row = waves.Rows.fitting([8, 8, 9], [0.0, 1.9e-3, 1.2e-3])
    force, time = waves.leading_wave(row, 1.0, struck=10, last=51)
    scaled = 1e4 * force / waves.FORCE
    assert scaled[:, [20, 50]] == pytest.approx(
        np.array([[3.208, 2.499], [1.316, 1.266], [1.587, 1.547]]), abs=1.5e-3
    )
    assert -np.diff(np.log(scaled[0, [30, 40, 50]])) / 10 == pytest.approx(8.33e-3, rel=0.01)
    assert 10 * 0.015 / np.diff(time[1:, [40, 50]]).ravel() == pytest.approx(
        [637.6, 676.5], rel=2e-3
    )


def test_similar_rows() -> None:
    """Velocity, precompression and force scale together in the equations."""
    row = waves.Rows.fitting([8, 8], [4.8e-4, 4.8e-4 * 2**0.8])
    force, _ = waves.leading_wave(row, [1.0, 2.0], struck=10, last=40)
    assert np.log2(force[1, 39] / force[0, 39]) == pytest.approx(1.2, abs=3e-3)


def test_a_run_beside_the_equations(tmp_path: Path) -> None:
    changes = {
        "load.index": [4],
        "precompression": {"kind": "walls", "tube": 9e-6},
        "run.end_time": 6e-4,
    }
    run = waves.ConfinedRun(run_of("confined-row", tmp_path, 32, **changes))
    assert (run.n, run.struck) == (8, 4) and run.a == pytest.approx(1.2e-3) and run.passed > 20
    assert run.inward == pytest.approx(run.rows.inward[0], rel=1e-4)
    force, time = waves.waves_of([run])
    assert run.peaks[7:20] == pytest.approx(force[0, 7:20], rel=1e-3)
    assert run.times[19] - run.times[9] == pytest.approx(time[0, 19] - time[0, 9], rel=1e-3)


def test_asymptotic_theory() -> None:
    """Values of an earlier program, and tails that vanish with precompression."""
    limit = theory.LightSpheres(waves.Rows.fitting(8))
    assert limit.eta_hat == pytest.approx(0.5286, abs=1e-4)
    low, high = (theory.Travelling(limit, one) for one in (0.2, 0.4))
    coefficients, speed = low.series()
    assert coefficients == pytest.approx([2.0988, 0.1587, -0.0037], abs=2e-4)
    assert speed == pytest.approx(1.0217, abs=1e-4) and speed == pytest.approx(low.speed, rel=3e-4)
    z = np.linspace(-3, 3, 31)
    assert theory.series_at(z, coefficients) == pytest.approx(low.displacement(z), abs=4e-3)
    assert low.tails == pytest.approx([1.91, 0.154], rel=0.01) and high.tails == pytest.approx(
        [1.15, 0.042], rel=0.02
    )
    assert low.energy_decay > 2 * high.energy_decay > 0


def test_legends_are_values_of_delta_hat() -> None:
    """The printed equations stay within both axes of Fig. 6.10, the corrected ones within one."""
    legends = load_study(str(CHAPTER / "legends.py"))
    row = waves.Rows.fitting([8])
    printed = legends.Travelling(legends.PrintedSpheres(row), legends.LEGENDS[0])
    corrected = legends.Travelling(legends.LightSpheres(row), legends.LEGENDS[0])
    ends = list(legends.ENDS.values())
    assert printed.largest == pytest.approx([2.98, 0.488], rel=0.01)
    assert corrected.largest == pytest.approx([3.46, 0.562], rel=0.01)
    assert np.less(printed.largest, ends).all() and not np.less(corrected.largest, ends).all()


def test_delta_hat_by_the_force() -> None:
    """delta_hat of a wave is recovered from its largest force."""
    legends = load_study(str(CHAPTER / "legends.py"))
    limit = legends.LightSpheres(waves.Rows.fitting([8]))
    amplitude = 2e-5
    force = legends.K_BEADS * amplitude**1.5 * legends.Travelling(limit, 0.5).largest_force
    found = legends.delta_hat_by_force(limit, [0.5 * amplitude], [force])
    assert found == pytest.approx([0.5], rel=1e-3)


@pytest.mark.validation
def test_decay_by_the_equations_of_the_source() -> None:
    """Decay between contacts 50 and 100 of the run with the model of the source (stored rows)."""
    run = SimpleNamespace(rows=waves.Rows.fitting(8, 0.0019), struck=10)
    (decay,) = theory.decay_by_source(SimpleNamespace(runs=[run]))
    stored = json.loads((FOLDER.parent / "docs/explanation/results.json").read_text("utf-8"))
    peaks = {
        row["quantity"]: row["granwave"]
        for row in stored["suites"]["confined"]["studies"]["source_model"]["rows"]
    }
    name = "Peak force / (E* R*^2), contact {}, n = 8, a = 0.0019"
    near = peaks[name.format(50)]
    far = peaks[name.format(100)]
    assert decay == pytest.approx(np.log(near / far) / 50, rel=0.1)


def test_rows_that_yield(tmp_path: Path) -> None:
    pushes = [[0, 0], [1e-5, 3467], [2e-5, 0], [2e-4, 0], [2.1e-4, 3467], [2.2e-4, 0]]
    changes = {
        "load.table": pushes, "load.index": [4], "run.end_time": 4.2e-4, "run.timestep": 5e-8, "contact.law": "hertz",
        "output.probes": [{"contact": [8, 9]}, {"contact": [12, 13]}],
    }  # fmt: skip
    plastic = run_of(
        "confined-steel", tmp_path / "plastic", 24, **changes | {"contact.law": "elastoplastic"}
    )
    elastic = run_of("confined-steel", tmp_path / "elastic", 24, **changes)
    (found,) = yielding.select([plastic, elastic])
    assert [run.words for run in found] == ["elastic, a = 0", "yielding, a = 0"]
    assert all((run.contacts == [8, 12]).all() for run in found)
    first, second = (np.array([run.pulses[k] for run in found]) for k in (0, 1))
    assert (first[1] < 0.6 * first[0]).all() and (second > 0).all()


def test_static_state(tmp_path: Path) -> None:
    """Check values of two rows whose walls have moved inwards."""
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


@pytest.mark.validation
def test_grains_in_holes(tmp_path: Path) -> None:
    """Steel in the holes hardly changes the speed, and increases the force at the bottom."""
    size = {
        "packing.size": [3, 4, 46], "load.index": {"first": 1, "last": 12}, "run.end_time": 6e-4, "run.frames": 121,
    }  # fmt: skip
    runs = [
        gw.run(
            "interstitial-fcc",
            size | change,
            directory=tmp_path / name,
            figures=False,
            progress=False,
        )
        for name, change in (("empty", {"grains": []}), ("steel", {"grains.1.material": "steel"}))
    ]
    study = study_of("thesis/chapter_7/interstitial_fcc.py", runs)
    empty, steel = (
        row(study, f"Speed of the pulse, {what}").ours for what in ("empty holes", "steel")
    )
    assert empty < steel < 1.01 * empty
    assert 1.05 < row(study, "Peak at the bottom, filled / empty holes, steel").ours < 1.1


def run(directory: Path, name: str, changes: dict[str, Any]) -> gw.Run:
    return gw.run(name, changes, directory=directory, figures=False, progress=False)


def test_row_without_cylinders(tmp_path: Path) -> None:
    """Peaks of the second solver, and the displacement of a sphere by a wave."""
    bare = {
        "grains": [],
        "guide": [{"free": "z"}],
        "boundary.sides": "free",
        "run.end_time": 3.3e-4,
    }
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
    """Width of open gaps, and position of loose cylinders; rigid plates change the first peak."""
    gaps = {
        n: [[k, width] for k in range(14, 19)]
        for n, width in (("usual", 3.45424064e-4), ("wide", 3.72866858e-4))
    }
    opened = {
        "boundary.friction": 0.185, "run.end_time": 1e-6,
        "grains.1.ring": {"n": 2, "radius": "touching", "gap": [14, 15, 16, 17, 18]},
    }  # fmt: skip
    runs = [
        run(tmp_path / "usual", "gap-switch", opened | {"packing.gaps": gaps["usual"]}),
        run(tmp_path / "wide", "gap-switch", opened | {"packing.gaps": gaps["wide"]}),
        run(
            tmp_path / "rigid",
            "gap-switch",
            opened | {"packing.gaps": gaps["usual"], "boundary.sides": "wall"},
        ),
        run(tmp_path / "loose", "gap-switch-loose", {"run.end_time": 1e-6}),
    ]
    study = study_of("thesis/chapter_8/plates.py", runs)
    for start in (
        "Width of the open gaps, plates 15.975",
        "Width of the open gaps, plates 15.95",
        "Distance",
        "Gap",
    ):
        for one in (one for one in study.rows if one.quantity.startswith(start)):
            assert one.ours == pytest.approx(one.theory, rel=1e-5)
    assert row(
        study, "First peak at sphere 21, open gaps, 10 cylinders, friction 0.185, rigid plates"
    )
    assert row(
        study,
        "First peak at sphere 21, open gaps, 10 cylinders, friction 0.185, plates 15.95 mm apart",
    )
