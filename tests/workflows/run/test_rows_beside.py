"""Rows of spheres with cylinders between walls (thesis 7.1 and 8), beside equations of symmetric motion."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.measures.rows.symmetric_row import SymmetricRow, elliptic_stiffness, line_force
from granwave.analysis.studies.rows import dented
from granwave.analysis.studies.rows.filter import FilterRun
from granwave.analysis.studies.rows.switch import SwitchRun
from granwave.analysis.studies.runs import FinishedRun
from granwave.analysis.studies.study import Study, make_studies
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.case.case import Case
from granwave.workflows import load_case, run_case

N = 20
SHORT = {
    "packing.size": N, "hold.1.index": [1, N], "guide.1.index": {"first": 2, "last": N - 1}, "load.index": [4],
    "run.end_time": 2.2e-4,
}  # fmt: skip


def twin(case: Case) -> SymmetricRow:
    """Equations of a row of the built-in case ``filter-row``, from its values alone."""
    grains = case.packing.grains
    assert grains is not None
    steel, light = case.material, case.materials[0]
    spheres = np.array([one != "cylinders" for one in grains.group])
    place = grains.position[spheres, 2]
    beside = np.flatnonzero(~spheres)[::2]
    radius, small = case.packing.diameter / 2, float(grains.diameter[-1]) / 2
    shape = grains.shape[-1]
    assert shape is not None
    own = [one.youngs_modulus / (1 - one.poisson_ratio**2) for one in (steel, light)]
    across = np.abs(grains.position[beside, 0])
    moved = case.precompression.moves["x"] if case.precompression else 0.0
    return SymmetricRow(
        place=place,
        along=grains.position[beside, 2],
        across=across,
        gap=np.searchsorted(place, grains.position[beside, 2]) - 1,
        radius=radius,
        small=small,
        length=shape.length,
        mass=steel.density * math.pi / 6 * (2 * radius) ** 3,
        small_mass=light.density * math.pi * small**2 * shape.length,
        sphere_stiffness=4 / 3 * own[0] / 2 * math.sqrt(radius / 2),
        side_stiffness=elliptic_stiffness(1 / (1 / own[0] + 1 / own[1]), 1 / radius, 1 / radius + 1 / small),
        compliance=1 / (math.pi * own[1]),
        wall=float(across.max()) + small - moved,
        friction=case.boundary.friction or 0.0,
        held=(0, len(place) - 1),
    )


def run(name: str, directory: Path, **changes: Any) -> FinishedRun:
    case = load_case(name, changes)
    outcome = run_case(case, directory, figures=False)
    assert outcome.summary["energy_balance_error"] < 3e-6
    return FinishedRun("", directory, case, outcome.summary)


def test_check_values_of_the_source() -> None:
    brass = 115e9 / (1 - 0.3**2)
    assert line_force(1e-6, 1 / (math.pi * brass), 9.525e-3, 4.76e-3) == pytest.approx(266.272, rel=1e-6)
    assert line_force(1e-26, 1 / (math.pi * brass), 9.525e-3, 4.76e-3) == 0.0
    assert elliptic_stiffness(brass / 2, 1 / 4.7625e-3, 1 / 4.7625e-3 + 1 / 2.38e-3) == pytest.approx(
        4.528092e9, rel=1e-6
    )


def test_row_between_pressed_walls(tmp_path: Path) -> None:
    """Other cylinders, another approach and friction; the second solver takes the sign of the velocity for it."""
    changes = SHORT | {"grains.1.diameter": 4.0e-3, "grains.1.length": 7e-3, "precompression.x": 5e-6}
    found = run("filter-row", tmp_path, **changes).seen_as(FilterRun)
    row = twin(found.case)
    assert found.static["force"] == pytest.approx(row.wall_force()[N // 2], rel=1e-6)
    motion = row.struck(3, 1.0, 2.2e-4)
    passed = np.flatnonzero(motion.arrivals < 2e-4)
    assert passed.max() > 10
    assert found.peaks[3 : passed.max()] == pytest.approx(motion.peaks[3 : passed.max()], rel=1e-3)
    assert not make_studies({"filter": [found]})  # another sphere is struck than in the source


@pytest.mark.validation
def test_row_between_walls_that_just_touch(tmp_path: Path) -> None:
    """The foot of the wave is far below the rounding of places: the line law must not fail there."""
    found = run("filter-row-touching", tmp_path, **SHORT).seen_as(FilterRun)
    motion = twin(found.case).struck(3, 1.0, 2.2e-4)
    passed = np.flatnonzero(motion.arrivals < 2e-4)
    assert found.peaks[3 : passed.max()] == pytest.approx(motion.peaks[3 : passed.max()], rel=2e-3)


def test_static_state_of_the_source(tmp_path: Path) -> None:
    found = run("filter-row", tmp_path, **SHORT | {"run.end_time": 2e-6}).seen_as(FilterRun)
    force, shift, overlap = (found.static[name] for name in ("force", "shift", "overlap"))
    assert (force, shift, overlap) == pytest.approx((29.668, 3.60653e-6, 2.0347e-7), rel=2e-5)
    assert found.stiffness == pytest.approx(4.198584e9, rel=1e-6)


def studied(runs: list[FinishedRun]) -> Study:
    (study,) = make_studies({"gap-switch": runs})
    return study


def test_open_gap_that_cylinders_bridge(tmp_path: Path) -> None:
    """First peak behind one open gap, of the independent solver that the study names; friction takes a fifth of it."""
    changes = {"run.end_time": 3.45e-4}
    runs = [run("gap-switch", tmp_path / str(f), **changes, **{"boundary.friction": f}) for f in (0.0, 0.185)]
    smooth, rubbed = (one.seen_as(SwitchRun) for one in runs)
    assert (smooth.state, smooth.n_cylinders) == ("open gaps", 2)
    assert smooth.first[1] == pytest.approx(85.73, rel=5e-3)
    assert rubbed.first[1] == pytest.approx(66.72, rel=2e-2)
    assert rubbed.summary["energy_dissipated_wall_J"] >= 0
    assert rubbed.summary["n_cylinders"] == 2 and "grains                      29" in summary_table(rubbed.summary)
    rows = {row.quantity: row for row in studied(runs).rows}
    row = rows["First peak at sphere 21, open gaps, 2 cylinders, friction 0.185"]
    assert row.verification and row.deviation == pytest.approx(0.0, abs=2e-2)
    assert rows["Width of the open gaps, plates 15.975 mm apart"].deviation == pytest.approx(0.0, abs=1e-6)


@pytest.mark.validation
@pytest.mark.parametrize(("upstream", "peak"), [(True, 87.77), (False, 103.69)])
def test_loose_cylinders(tmp_path: Path, upstream: bool, peak: float) -> None:
    case = load_case("gap-switch-loose")
    grains = case.packing.grains
    assert grains is not None
    x, y, z = grains.position[-2]
    z = z if upstream else 27 * 9.5e-3 - z  # the other sphere of the same gap
    found = run("gap-switch-loose", tmp_path, **{"grains.1.at": [[x, y, z], [-x, y, z]], "run.end_time": 3.45e-4})
    assert found.seen_as(SwitchRun).state == ("loose, upstream" if upstream else "loose, downstream")
    assert found.seen_as(SwitchRun).first[1] == pytest.approx(peak, rel=1e-3)


def test_filter_after_a_strong_pulse(tmp_path: Path) -> None:
    """Dents of a strong pulse let more of a weak one through, and slacken the walls."""
    weak = [[0, 0], [1e-4, 0], [1.05e-4, 706], [1.1e-4, 0]]
    changes = SHORT | {
        "load": {"kind": "force", "index": [4], "shape": "table", "table": weak}, "contact.law": "elastoplastic",
        "output.probes": [{"contact": [5, 6]}, {"contact": [8, 9]}], "output.probe_interval": 1e-6,
    }  # fmt: skip
    del changes["load.index"]
    whole = run("filter-row", tmp_path / "whole", **changes)
    changes["load"] |= {"table": [[0, 0], [5e-6, 3530], [1e-5, 0], *weak[1:]]}
    after = run("filter-row", tmp_path / "after", **changes)
    (found,) = dented.select([after, whole])
    assert [one.words for one in found] == ["yielding, whole", "yielding, after a strong pulse"]
    assert found[0].pulses[8][0] == 0.0 < found[0].pulses[8][1] < 0.5 * found[1].pulses[8][1]
    assert found[0].pressed == pytest.approx(1.0, abs=1e-6) and found[1].pressed < 0.98
    names = [row.quantity for row in dented.rows(found)]
    assert names == ["Force of a wall before the weak pulse over that at the start, yielding, after a strong pulse"]
    assert len(list(dented.pictures(found))) == 1 and not dented.select([whole])
