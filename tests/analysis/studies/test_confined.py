"""Confined rows: geometry and balance, equations of symmetric motion beside LAMMPS, asymptotic theory, studies."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis.measures.confined.asymptotics import Limit, Travelling, energy_decay, first_order
from granwave.analysis.measures.confined.geometry import Row
from granwave.analysis.measures.confined.symmetric import leading_wave
from granwave.analysis.studies.confined import waves, yielding
from granwave.analysis.studies.confined.printed import printed_rows
from granwave.analysis.studies.confined.runs import ConfinedRun, decay_of, row_of
from granwave.analysis.studies.confined.waves import Waves
from granwave.analysis.studies.runs import FinishedRun
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import run_case

CASES = Path(__file__).parents[3] / "workflows" / "cases"
BEAD, MODULUS = 0.015, 115e9 / 0.91
N = np.array([6, 7, 8, 9])


def thesis_row(n: Any, a: Any = 0.0) -> Row:
    return Row.fitting(n, BEAD, np.asarray(a) * BEAD / 2, MODULUS, 8500.0)


def run_of(case: str, directory: Path, beads: int, **changes: Any) -> FinishedRun:
    keys = {"packing.size": beads, "grains.1.repeat.times": beads - 1, "hold.1.index": [1, beads]} | changes
    read = load_case(CASES / f"{case}.toml", keys)
    return FinishedRun(directory.name, directory, read, run_case(read, directory, figures=False).summary)


def test_sizes_and_constants() -> None:
    """Values that an independent program found for n = 6 to 9."""
    row = thesis_row(N)
    assert row.small / BEAD == pytest.approx([0.66667, 0.46383, 0.34315, 0.26495], abs=1e-5)
    assert row.tube / BEAD == pytest.approx([1.0, 0.76642, 0.61991, 0.51980], abs=1e-5)
    assert row.cosine == pytest.approx([0.6, 0.68314, 0.74452, 0.79055], abs=1e-5)
    assert row.eps == pytest.approx([0.2963, 0.0998, 0.0404, 0.0186], abs=1e-4)
    assert row.eta == pytest.approx([0.2494, 0.3071, 0.3419, 0.3596], abs=1e-4)
    assert row.k_wall / row.k_beads == pytest.approx([2.5645, 2.1136, 1.8006, 1.5698], abs=1e-4)
    assert row.k_thesis_wall / row.k_beads == pytest.approx([2.0785, 1.7337, 1.4912, 1.3103], abs=1e-4)
    neighbours = 2 * row.ring * np.sin(np.pi / N)
    assert neighbours == pytest.approx(row.small) and np.hypot(row.ring, BEAD / 2) == pytest.approx(
        (BEAD + row.small) / 2
    )


def test_legends_follow_from_a_balance_without_rings() -> None:
    printed = {6: (5.2, 13, 21), 7: (5.0, 13, 20), 8: (4.8, 12, 19), 9: (4.6, 12, 19)}
    misses = 0
    for n, legends in printed.items():
        found = [
            1e4 * 2 * float(thesis_row(n).thesis_shrinks(part * BEAD)[0]) / BEAD for part in (1.6e-4, 4e-4, 6.4e-4)
        ]
        misses += sum(f"{ours:.2g}" != f"{source:.2g}" for ours, source in zip(found, legends, strict=True))
    assert misses == 2  # 12.5 and 18.4, printed 13 and 19
    right = thesis_row(N).thesis_shrinks(1.6e-4 * BEAD, right_ring=True)
    assert 2e4 * right / BEAD == pytest.approx([6.2, 5.7, 5.3, 5.1], abs=0.06)


def test_printed_numbers() -> None:
    """Sizes and units are those of the check values, to their last digit."""
    decays = np.array([7.0, 8.0]), np.array([2e-3, 8e-3])
    found = [row for row in printed_rows([thesis_row(8)], *decays) if row.verification]
    assert len(found) == 4 * 7 + 4
    assert all(abs(row.deviation or 0.0) < 3e-3 for row in found)
    ring = 1e4 * 2 * float(thesis_row(8).thesis_shrinks(4e-4 * BEAD, printed_ring=True)[0]) / BEAD
    assert ring == pytest.approx(19, abs=0.3)


def test_small_spheres_in_balance() -> None:
    row = thesis_row([8, 6], 1.9e-3)
    assert (row.inward > 0).all() and (row.inward < row.shrinks).all()
    assert np.abs(row.outward_force(row.inward)) == pytest.approx(0, abs=1e-9)


def test_waves_of_an_independent_program() -> None:
    """Forces at contacts 20 and 50 (counted from 0), and a decay that similarity of the wave makes uniform."""
    row = thesis_row([8, 8, 9], [0.0, 1.9e-3, 1.2e-3])
    wave = leading_wave(row, 1.0, struck=10, last=51)
    scaled = 1e4 * wave.force / row.force_unit[:, None]
    assert scaled[:, [20, 50]] == pytest.approx(np.array([[3.208, 2.499], [1.316, 1.266], [1.587, 1.547]]), abs=1.5e-3)
    assert -np.diff(np.log(scaled[0, [30, 40, 50]])) / 10 == pytest.approx(8.33e-3, rel=0.01)
    assert 10 * BEAD / np.diff(wave.time[1:, [40, 50]]).ravel() == pytest.approx([637.6, 676.5], rel=2e-3)


def test_contacts_and_rows_of_a_run(tmp_path: Path) -> None:
    """A run beside the equations, also where beads, material, n and precompression are others."""
    n, small = 7, 2 * 0.01 * np.tan(np.pi / 7) ** 2
    radius = float(np.sqrt(small**2 + 0.02 * small) / 2)
    step = {"times": 35, "step": [0.0, 0.0, 0.01]}
    ring = {
        "ring": {"n": n, "radius": radius, "z": 0.005},
        "repeat": step,
        "diameter": float(small),
        "material": "small",
    }
    run = run_of(
        "confined-row", tmp_path, 36,
        **{"packing.diameter": 0.01, "material": "steel", "grains": [ring], "run.end_time": 3.1e-4, "run.timestep": 4e-8,
           "boundary.sides.tube.radius": radius + float(small) / 2, "load.index": [4], "load.velocity": 3.0,
           "precompression": {"kind": "walls", "tube": 3e-6}},
    ).seen_as(ConfinedRun)  # fmt: skip
    assert (run.n, run.struck) == (7, 4) and run.a == pytest.approx(6e-4) and run.passed > 22
    found = Waves([run])
    rows = {row.quantity: row for row in waves.rows(found)}
    assert set(rows) == {
        "Small spheres moved in, n = 7, a = 0.0006",
        "Peak force times 1e4 at contact 20, n = 7, a = 0.0006",
    }
    assert all(row.verification and abs(row.deviation or 1) < 5e-4 for row in rows.values())
    theory = found.theory.force[0]
    ours = [run.peak(k) for k in range(8, 22)]
    assert ours == pytest.approx(theory[7:21], rel=1e-3)
    (picture,) = waves.pictures(found)
    assert len(picture.drawing.columns["n_7_a_0_0006_contact"]) == run.passed - run.struck + 1
    assert not waves.select([run]) and row_of(load_case(CASES / "fcc-small.toml")) is None


def test_similar_rows() -> None:
    """Velocity, precompression, force and speed that go together, in the equations."""
    row = thesis_row([8, 8], [4.8e-4, 4.8e-4 * 2**0.8])
    wave = leading_wave(row, np.array([1.0, 2.0]), struck=10, last=40)
    assert np.log2(wave.force[1, 39] / wave.force[0, 39]) == pytest.approx(1.2, abs=3e-3)


def test_asymptotic_theory() -> None:
    """Values of an independent program, and tails that vanish with precompression."""
    row = thesis_row(8)
    limit = Limit(8, *(float(one[0]) for one in (row.eps, row.eta, row.k_thesis_wall / row.k_beads, row.tangent)))
    assert limit.eta_hat == pytest.approx(0.5286, abs=1e-4)
    wave = Travelling(limit.eta_hat, 0.2)
    series = wave.series()
    assert series.coefficients == pytest.approx([2.0988, 0.1587, -0.0037], abs=2e-4)
    assert series.speed == pytest.approx(1.0217, abs=1e-4) and series.speed == pytest.approx(wave.speed, rel=3e-4)
    z = np.linspace(-3, 3, 31)
    assert series(z) == pytest.approx(wave.displacement(z), abs=4e-3)
    tails = [first_order(limit, Travelling(limit.eta_hat, one)) for one in (0.2, 0.4)]
    assert [one.axial_tail for one in tails] == pytest.approx([1.91, 1.15], abs=0.01)
    assert [one.radial_tail for one in tails] == pytest.approx([0.154, 0.042], abs=1e-3)
    lost = [
        energy_decay(limit, Travelling(limit.eta_hat, one), tail) for one, tail in zip((0.2, 0.4), tails, strict=True)
    ]
    assert lost[0] > 2 * lost[1] > 0


def test_rows_that_yield(tmp_path: Path) -> None:
    pushes = [[0, 0], [1e-5, 3467], [2e-5, 0], [2e-4, 0], [2.1e-4, 3467], [2.2e-4, 0]]
    changes = {
        "load.table": pushes, "load.index": [4], "run.end_time": 4.2e-4, "run.timestep": 5e-8, "contact.law": "hertz",
        "output.probes": [{"contact": [8, 9]}, {"contact": [12, 13]}],
    }  # fmt: skip
    elastic = run_of("confined-steel", tmp_path / "elastic", 24, **changes)
    plastic = run_of("confined-steel", tmp_path / "plastic", 24, **changes | {"contact.law": "elastoplastic"})
    (found,) = yielding.select([plastic, elastic])
    assert [run.words for run in found] == ["elastic, a = 0", "yielding, a = 0"]
    assert found[0].apart == pytest.approx(2e-4)
    contacts, first, second = (np.array(one) for one in zip(*(run.pulses for run in found), strict=True))
    assert (contacts == [8, 12]).all()
    assert (first[1] < 0.6 * first[0]).all() and (second > 0).all()
    rows = {row.quantity: row.ours for row in yielding.rows(found)}
    assert rows["Energy dissipated, yielding, a = 0"] == pytest.approx(100 * plastic.summary["dissipated_fraction"])
    assert not yielding.select([elastic])
    assert len(list(yielding.pictures(found))) == 1


def test_decay() -> None:
    force = np.exp(-2e-3 * np.arange(1, 201))
    assert decay_of(force) == pytest.approx(2e-3) and np.isnan(decay_of(force[:70]))
