"""Runs of chains: beads, strikers, bars, cylinders; independent solver, ranks, stops."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

from granwave.analysis.figures.run_figures import draw_figures, run_figures
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.bodies import echoes
from granwave.lammps_inputs.planning.arrival import earliest_passage
from granwave.workflows import load_case
from granwave.workflows.run.driver import run_case
from tests.helpers.made_up.small_cases import BRASS, DIAMETER, PULSE, case_of
from tests.helpers.twins import chain_twin as twin

SOFT = {"youngs_modulus": 67e9, "poisson_ratio": 0.33, "density": 2700.0, "yield_strength": 150e6}
HARD = {"youngs_modulus": 210e9, "poisson_ratio": 0.28, "density": 7850.0}


def bead(material: dict[str, float], diameter: float = DIAMETER) -> twin.Bead:
    modulus, ratio, density = (
        material[name] for name in ("youngs_modulus", "poisson_ratio", "density")
    )
    return twin.Bead(modulus, ratio, material.get("yield_strength"), diameter / 2, density)


def compare(
    case: Case, directory: Path, record: twin.Record, chosen: slice = slice(None)
) -> dict[str, Any]:
    """Run, and compare peaks, dissipation, final velocities and energies."""
    outcome = run_case(case, directory, figures=False)
    summary = outcome.summary
    assert summary["energy_balance_error"] < 1e-5
    with Result(directory) as result:
        peak = result.along_chain("peak_force")
        lost = result.along_chain("dissipated_energy")
        np.testing.assert_allclose(
            peak, record.peak_force[chosen], rtol=5e-4, atol=1e-4 * peak.max()
        )
        largest = record.dissipated.max()
        np.testing.assert_allclose(
            lost, record.dissipated[chosen], rtol=1e-3, atol=1e-4 * (largest or 1e-30)
        )
        last = float(result["chain/time"][-1])
        expected = [np.interp(last, record.times, column) for column in record.velocities.T]
        np.testing.assert_allclose(
            result["chain/velocity"][-1], expected, atol=2e-3 * np.abs(record.velocities).max()
        )
    assert summary["energy_input_J"] == pytest.approx(record.work[-1], rel=1e-4)
    return summary


@pytest.mark.parametrize("law", ["hertz", "bilinear", "elastoplastic"])
def test_unlike_beads_under_a_pulse_against_a_wall_of_a_material(tmp_path: Path, law: str) -> None:
    wall = HARD | {"yield_strength": 400e6}
    case = case_of(
        contact={"law": law},
        load=PULSE,
        replace=[
            {"index": [4, 5], "material": SOFT},
            {"index": {"first": 7, "last": 8}, "diameter": 6e-3},
        ],
        boundary={"bottom": {"material": wall}},
    )
    beads = [bead(BRASS) for _ in range(12)]
    beads[3:5] = [bead(SOFT)] * 2
    beads[6:8] = [bead(BRASS, 6e-3)] * 2
    record = twin.Chain(
        beads, law, right=twin.Solid(HARD["youngs_modulus"], HARD["poisson_ratio"], 400e6)
    ).run(1.5e-4, 1e-8, twin.half_sine(4e3, 2e-5))
    summary = compare(case, tmp_path / "run", record, slice(0, 11))
    assert summary["wall_peak_force_N"] == pytest.approx(record.peak_force[-1], rel=1e-3)
    assert summary["energy_dissipated_wall_J"] == pytest.approx(
        record.dissipated[-1], rel=1e-3, abs=1e-12
    )
    with (
        Result(tmp_path / "run") as result
    ):  # the wall is softer than brass: the dissipation of this contact is that of the wall
        between = summary["energy_dissipated_J"] - summary["energy_dissipated_wall_J"]
        assert result["spheres/dissipated_energy"].sum() == pytest.approx(
            between, rel=1e-6, abs=1e-12
        )


@pytest.mark.parametrize("end", ["fixed", "wall", "free"])
def test_an_impact_and_the_ends(tmp_path: Path, end: str) -> None:
    case = case_of(load={"velocity": 3.0}, boundary={"bottom": end})
    right = {"fixed": twin.FIXED, "wall": twin.RIGID, "free": None}[end]
    record = twin.Chain([bead(BRASS)] * 12, "elastoplastic", right=right).run(
        1.5e-4, 1e-8, velocity={0: 3.0}
    )
    compare(case, tmp_path / "run", record, slice(0, 11))


@pytest.mark.parametrize("shape", ["rectangle", "table"])
def test_shapes_of_the_force(tmp_path: Path, shape: str) -> None:
    if shape == "rectangle":
        load = {"amplitude": 2e3, "duration": 1.7e-5}
        given = twin.rectangle(2e3, 1.7e-5)
    else:
        rows = [[0.0, 0.0], [5e-6, 3e3], [1.2e-5, 1e3], [3e-5, 0.0]]
        (tmp_path / "pulse.txt").write_text("# s N\n" + "".join(f"{t} {f}\n" for t, f in rows))
        load = {"file": str(tmp_path / "pulse.txt")}
        given = twin.table(*np.array(rows).T)
    case = case_of(load={"kind": "force", "shape": shape} | load)
    record = twin.Chain([bead(BRASS)] * 12, "elastoplastic").run(1.5e-4, 1e-8, given)
    compare(case, tmp_path / "run", record)


def test_a_striker_and_a_sensor(tmp_path: Path) -> None:
    striker = {
        "touches": 1,
        "velocity": [0, 0, 2.0],
        "material": HARD | {"yield_strength": 700e6},
        "diameter": 0.012,
    }
    case = case_of(striker=[striker], sensor=[{"name": "A", "id": 5}])
    beads = [bead(HARD | {"yield_strength": 700e6}, 0.012), *[bead(BRASS)] * 12]
    record = twin.Chain(beads, "elastoplastic").run(1.5e-4, 1e-8, velocity={0: 2.0})
    summary = compare(case, tmp_path / "run", record)
    at_bead = record.forces[:, 4:6].mean(axis=1).max()
    assert summary["sensor_A_peak_force_N"] == pytest.approx(at_bead, rel=5e-3)
    assert summary["impactor_velocity_m_s"] == pytest.approx(record.velocities[-1, 0], rel=1e-3)
    names = ("force_map", "force_histories", "along_chain", "bead_velocities", "sensors")
    drawn = {path.stem for path in draw_figures(tmp_path / "run", names=names)}
    assert drawn == set(names)


@pytest.mark.validation
def test_two_bars(tmp_path: Path) -> None:
    """Transmission of energy and force from the incident bar through the chain into the second bar,
    as in the independent solver.
    """
    steel = {"youngs_modulus": 200e9, "poisson_ratio": 0.30, "density": 8100.0}
    bar = {"area": 127e-6, "material": steel}
    case = case_of(
        size=6,
        load=PULSE | {"amplitude": 8e3},
        incident_bar={"length": 0.3, "elements": 150} | bar,
        bar={"length": 0.4, "elements": 200} | bar,
        run={"end_time": 1.6e-4},
        replace=[{"index": 3, "material": SOFT}],
    )
    beads = [bead(BRASS) for _ in range(6)]
    beads[2] = bead(SOFT)
    left = twin.Bar(length=0.3, elements=150)
    right = twin.Bar(length=0.4, elements=200)
    solver = twin.Chain(beads, "elastoplastic", left=left, right=right)
    record = solver.run(1.6e-4, 1e-8, twin.half_sine(8e3, 2e-5))
    summary = compare(case, tmp_path / "run", record)
    assert summary["energy_incident_bar_J"] == pytest.approx(record.bar_energy[-1, 0], rel=2e-3)
    assert summary["energy_bar_J"] == pytest.approx(record.bar_energy[-1, 1], rel=5e-3)
    assert summary["wall_peak_force_N"] == pytest.approx(record.peak_force[-1], rel=1e-3)
    with Result(tmp_path / "run") as result:
        section = result["bars/incident_bar/force"]
        assert section.max() == pytest.approx(record.bar_forces[0].max(), rel=5e-3)
        assert set(result["wall_contacts/wall"]) == {"bar", "incident_bar"}
    assert {path.stem for path in draw_figures(tmp_path / "run", names=("bars", "force_map"))} == {
        "bars",
        "force_map",
    }


def test_a_driven_end_does_work_on_the_chain(tmp_path: Path) -> None:
    load = {"kind": "displacement", "shape": "harmonic", "amplitude": 1e-6, "frequency": 2e4}
    outcome = run_case(
        case_of(contact={"law": "hertz"}, load=load), tmp_path / "run", figures=False
    )
    assert outcome.summary["energy_balance_error"] < 1e-5
    with Result(tmp_path / "run") as result:
        time = result["chain/time"]
        moved = result["chain/displacement"][:, 0]
        np.testing.assert_allclose(moved, 1e-6 * np.sin(2 * np.pi * 2e4 * time), atol=1e-9)
        assert result["energy/input"].max() > 0


@pytest.mark.validation
def test_the_same_bits_on_two_ranks_and_after_a_stop(granwave, tmp_path: Path) -> None:
    """Chain between bars on two ranks, and one that was stopped half-way and resumed."""
    text = case_of(
        size=6,
        load=PULSE,
        bar={"length": 0.1, "elements": 20, "area": 1e-4, "material": HARD},
        replace=[{"index": 5, "diameter": 7e-3}],
        output={"history": 50},
        run={"end_time": 8e-5},
    ).to_toml()
    (tmp_path / "case.toml").write_text(text)
    for ranks in (1, 2):
        done = granwave(
            "run", "case.toml", "-o", f"r{ranks}", "--np", ranks, "--no-figures", cwd=tmp_path
        )
        assert done.returncode == 0, done.stderr
    with Result(tmp_path / "r1") as one, Result(tmp_path / "r2") as two:
        for name in (
            "chain/contact_force",
            "chain/velocity",
            "bars/bar/force",
            "contacts/peak_force",
        ):
            np.testing.assert_array_equal(one[name], two[name])
    first, second = (json.loads((tmp_path / f"r{n}" / "summary.json").read_text()) for n in (1, 2))
    assert first["energy_bar_J"] == pytest.approx(second["energy_bar_J"], rel=1e-12)


def test_a_bar_that_is_too_short_is_told(caplog):
    load_case("intruder", {"bar.length": 1.0})
    assert (
        "a reflection from the end of the bar can reach the chain after 643 µs, before the end of "
        "the run at 1 ms"
    ) in caplog.text
    caplog.clear()
    for name in ("intruder", "split-hopkinson", "bar-pulse"):
        load_case(name)
    assert not caplog.text


def test_the_wave_passes_the_chain_before_it_enters_the_bar(caplog, tmp_path: Path):
    """Twice the length over the speed is 241 us, of a run of 400 us; the bar is reached later."""
    bar = {"length": 0.6, "elements": 200, "area": 28e-6, "material": "aluminium"}
    case = {
        "name": "short", "material": "aluminium", "bar": bar, "load": {"velocity": 0.7},
        "packing": {"kind": "chain", "size": 18, "diameter": 6e-3}, "run": {"end_time": 4e-4},
    }  # fmt: skip
    short = case_from_dict(case)
    assert not caplog.text
    run_case(short, tmp_path / "run", figures=False)
    with Result(tmp_path / "run") as result:
        force = result["walls/bar/force"]
        front = result["walls/bar/time"][np.argmax(force > 0.1 * force.max())]
        echo = echoes(result.assembly.bars)["bar"]
        assert 0.7 * front < earliest_passage(result.assembly) < front
    assert front + echo > case["run"]["end_time"]
    case_from_dict(case | {"run": {"end_time": 5e-4}})
    assert "can reach the chain after 414 µs, before the end of the run at 500 µs" in caplog.text


def test_echo_of_a_bar_behind_another():
    times = echoes(assemble(load_case("split-hopkinson")).bars)
    crossing = 2.0 / (200e9 / 8100) ** 0.5
    assert times == pytest.approx({"incident_bar": 3 * crossing, "bar": 3 * crossing})


def test_a_crystal_of_brass_cylinders(tmp_path: Path) -> None:
    case = {
        "name": "cylinders", "material": "brass", "contact": {"friction": 0.2}, "run": {"end_time": 1e-4, "frames": 2},
        "packing": {"kind": "hexagonal", "size": [4, 4], "shape": "cylinder", "diameter": 0.01, "length": 0.02},
    }  # fmt: skip
    run_case(case_from_dict(case), tmp_path / "run", figures=False)
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["plastic_zone_volume_m3"] is None and summary["wave_return_share"] is None
    assert summary["energy_input_normalised"] is None and summary["friction_fraction"] > 0
    with Result(tmp_path / "run") as result:
        assert not result.yields and not np.isfinite(result.law.yield_force)
        drawn = {
            name: figure.draw(result)
            for name, figure in run_figures().items()
            if not name.startswith("packing_3d")
        }
        assert (
            drawn["dissipation_ranked"]
            is drawn["plastic_zone_size"]
            is drawn["dissipation_parts_principal"]
            is None
        )
        force = drawn["peak_force_depth"]
        values = [line.get_ydata() for axes in force.figure.axes for line in axes.lines]
        assert any(np.nanmax(one) > 0 for one in values if len(one))
        texts = [
            text.get_text() for one in drawn.values() if one for text in one.figure.findobj(Text)
        ]
    assert any("cylinder" in text for text in texts) and not any(
        "sphere" in text.lower() for text in texts
    )
    assert any(r"F_\mathrm{max}" in text for text in texts) and not any(
        r"F_\mathrm{y}" in text for text in texts
    )
