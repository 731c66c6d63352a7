"""Square packings, their sensors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.studies.study import make_studies
from tests.helpers.programs.scripts import FOLDER, columns, row, study_of

#: A packing of 8 x 10 that the strikers hit between X1Y5 and X1Y6.
SMALL = {
    "packing.size": [8, 10],
    "striker.1.touches": [33, 41],
    "striker.2.touches": 81,
    "sensor": [],
}


def run(directory: Path, name: str = "square-in-plane", **changes: Any) -> gw.Run:
    found = gw.run(name, changes, directory=directory, progress=False)
    assert found["energy_balance_error"] < 1e-5
    return found


@pytest.fixture(scope="module")
def in_plane(tmp_path_factory: pytest.TempPathFactory) -> gw.Run:
    return run(tmp_path_factory.mktemp("square") / "in")


@pytest.fixture(scope="module")
def out_of_plane(tmp_path_factory: pytest.TempPathFactory) -> gw.Run:
    return run(tmp_path_factory.mktemp("square") / "out", "square-out-of-plane")


def test_energies_of_the_source(in_plane: gw.Run, out_of_plane: gw.Run) -> None:
    made = make_studies({str(FOLDER / "square_packing/impacts.py"): [in_plane, out_of_plane]})
    assert [study.name for study in made] == ["square-in-plane", "square-out-of-plane"]
    for study, count in zip(made, (2, 3), strict=True):
        energies = [
            one
            for one in study.rows
            if one.quantity.startswith("Energy in") and one.kind == "source"
        ]
        assert len(energies) == count and not study.failed and len(study.pictures) == 3
        for one in energies:
            assert one.ours == pytest.approx(one.source, abs=0.1)  # % of the input
        waves = row(study, "Chains with a wave")
        assert waves.ours == waves.source
        assert row(study, "Largest energy in other spheres").ours < 1e-4


def test_all_energy_is_accounted_for(in_plane: gw.Run) -> None:
    shares = gw.measures.energy_by_region(
        in_plane.result, {"strikers": [401, 402], "struck": [181, 201]}
    )
    assert list(shares) == ["strikers", "struck", "other spheres", "walls", "dissipated"]
    np.testing.assert_allclose(sum(shares.values()), 1.0, atol=2e-5)
    assert shares["strikers"][0] == pytest.approx(1.0)


def test_wave_is_nesterenkos_but_shorter(in_plane: gw.Run) -> None:
    chain = np.arange(181, 201)
    time = in_plane.result.frame_times
    diameter = in_plane.case.packing.diameter
    velocity = gw.measures.line_velocity(in_plane.result, chain)
    np.testing.assert_allclose(
        velocity, in_plane.fields.velocity.sel(id=chain, axis="x"), atol=1e-12
    )
    lengths = gw.measures.pulse_lengths(time, velocity, diameter)
    theory = gw.theory.solitary_lengths()
    assert theory["fit of velocity"] == pytest.approx(4.967, abs=1e-3)
    ratio = [lengths[name][12] / expected for name, expected in theory.items()]
    np.testing.assert_allclose(ratio, [0.871, 0.890, 0.875, 0.873], atol=0.004)


def test_sensors(in_plane: gw.Run) -> None:
    study = study_of("square_packing/sensor_signals.py", [in_plane])
    factor = row(study, "Factor of the speed against the peak force (equation 3), central")
    assert factor.ours == pytest.approx(factor.theory, rel=2e-3)
    peak = row(study, "Peak acceleration at sensor 1C")
    assert peak.ours == pytest.approx(in_plane["sensor_1C_peak_acceleration_m_s2"], rel=1e-3)
    assert (
        row(study, "Acceleration across").ours
        < 1e-6
        > row(study, "Largest acceleration at sensor 2D").ours
    )
    assert np.max(columns(study)["1C_along_m_s2"]) == pytest.approx(peak.ours, rel=1e-2)


def test_speeds_and_directions(in_plane: gw.Run, tmp_path: Path) -> None:
    less = {"sensor": [], "run.frames": 121}
    slow = run(
        tmp_path / "slow", **less, **{"striker.2.velocity": [0.05, 0, 0], "run.end_time": 1e-3}
    )
    fast = run(
        tmp_path / "fast", **less, **{"striker.2.velocity": [5.0, 0, 0], "run.end_time": 4.5e-4}
    )
    study = study_of("square_packing/wave_speed.py", [fast, in_plane, slow])
    for name in ("central", "edge"):
        power = row(
            study, f"Exponent of wave speed against particle velocity, {name} chains, in-plane"
        )
        assert power.kind == "verification" and power.ours == pytest.approx(power.theory, abs=5e-4)
    speed = study.rows[1]
    velocity = columns(study)["central_chains_in_plane_peak_velocity_m_s"][1]
    assert speed.theory == pytest.approx(464.6 * (velocity / 0.1187) ** 0.2, rel=1e-3)
    assert speed.ours == pytest.approx(speed.theory, rel=0.012)
    study = study_of("square_packing/directions.py", [fast, in_plane, slow])
    (along,) = study.rows  # of the fastest, which loses nothing
    assert along.quantity == "Energy along contacts: square, elastic, 5 m/s, in-plane"
    assert along.ours == pytest.approx(100)
    assert along.kind == "alone" and along.remark == "Isotropic distribution: 33.3 %."


def test_yielding_leaves_little_for_the_waves(tmp_path: Path) -> None:
    changes = {"contact.law": "elastoplastic", "packing.size": [12, 12], "run.frames": 121}
    places = {"striker.1.touches": [61, 73], "striker.2.touches": 145}
    study = study_of("square_packing/yielding.py", [run(tmp_path, **SMALL | changes | places)])
    assert (
        row(study, "Dissipated at 0.29 m/s").ours > 85
        and row(study, "Largest energy in central chains").ours < 20
    )
    assert all(one.source is None for one in study.rows)


@pytest.mark.validation
def test_friction_takes_from_the_edge_chains(tmp_path: Path) -> None:
    changes = {
        "precompression.kind": "gravity",
        "run.frames": 121,
        "run.end_time": 5e-4,
        "boundary.friction": 0.0,
    }
    wide = {"packing.size": [16, 16], "striker.1.touches": [113, 129], "striker.2.touches": 257}
    both = ({"contact.friction": 0.0}, {"contact.friction": 0.2}, {"boundary.friction": 0.3})
    runs = [run(tmp_path / str(n), **SMALL | wide | changes | one) for n, one in enumerate(both)]
    study = study_of("square_packing/friction.py", runs)
    own = "friction 0.2 between spheres"
    assert 1 < row(study, f"Decrease of peak velocity, central chains, sphere 6: {own}").ours < 4
    assert 30 < row(study, f"Decrease of peak velocity, edge chains, sphere 5: {own}").ours < 55
    assert (
        row(
            study,
            "Fraction of the friction between spheres at contacts of the two impacted spheres: "
            f"{own}",
        ).ours
        > 60
    )
    lost = row(study, "Dissipated at the floor / input")
    assert lost.ours == pytest.approx(lost.theory, rel=0.1)


#: A packing of 8 x 10 that the strikers hit between X1Y5 and X1Y6; sensors beside each other, and at both edges.
SENSORS = {
    "packing.size": [8, 10],
    "striker.1.touches": [33, 41],
    "striker.2.touches": 81,
    "sensor": [
        {"name": name, "id": one} for name, one in (("1A", 36), ("1B", 44), ("2A", 57), ("2B", 17))
    ],
    "run.end_time": 3.2e-4,
    "run.frames": 2,
}


def runs(name: str, directory: Path, *changes: dict[str, Any]) -> list[gw.Run]:
    return [
        gw.run(name, one, directory=directory / str(n), progress=False)
        for n, one in enumerate(changes)
    ]


def test_twin_sensors(tmp_path: Path) -> None:
    scatter = {"striker.2.misalignment": [0, 1e-3, 0]}
    seeds = [SENSORS | scatter | {"packing.seed": seed} for seed in range(1, 5)]
    found = study_of(
        "square_packing/twin_sensors.py", runs("square-in-plane", tmp_path, SENSORS, *seeds)
    )
    where = "1A and 1B (central chains, in-plane)"
    delay, peak = (
        row(found, f"Scatter of the {name}, {where}") for name in ("delay", "peak acceleration")
    )
    assert delay.kind == peak.kind == "alone", "how much strikes miss is ours, not the source's"
    assert "68" in delay.remark and "10" in peak.remark
    assert 0.5 < delay.ours < 5 and 3 < peak.ours < 10
    mean = row(found, f"Mean delay, {where}")
    assert (mean.source, mean.ours, mean.theory) == (
        -21,
        None,
        0,
    ) and "1.2 standard errors" in mean.remark
    (picture,) = found.pictures
    data = picture.drawing.columns
    ideal = [n for n, setting in enumerate(data["setting"]) if setting == "ideal"]
    assert len(ideal) == 2 and all(abs(data["delay_us"][n]) < 1e-3 for n in ideal)
    assert len(found.verdict) == 2


def test_lighter_spheres_with_sensors(tmp_path: Path) -> None:
    lighter = {
        "index": [36, 44, 57, 17],
        "material": {"preset": "stainless-steel-316", "density": 6000},
    }
    changes = [SENSORS, SENSORS | {"replace": [lighter]}]
    sensors = [{"name": "2C", "id": 9}, {"name": "1C", "id": 38}, {"name": "1D", "id": 40}]
    made = runs(
        "square-in-plane",
        tmp_path,
        *(one | {"sensor": [*SENSORS["sensor"], *sensors]} for one in changes),
    )
    found = study_of("square_packing/sensors_in_square.py", made)
    first, twin = (
        row(
            found, f"Change of peak velocity, sensor {name}, 0.75 of the mass of other spheres"
        ).ours
        for name in ("1A", "1B")
    )
    assert first == pytest.approx(twin, rel=1e-3) and 0 < first < 25, "a lighter sphere is faster"
    assert len(found.pictures) == 1


@pytest.mark.validation
def test_scattered_diameters_slow_weak_waves_more(tmp_path: Path) -> None:
    thin = SENSORS | {
        "packing.size": [12, 2],
        "striker.1.touches": [1, 13],
        "striker.2.touches": 25,
        "sensor": [],
    }
    changes = [
        thin
        | {
            "packing.diameter_scatter": scatter,
            "striker.2.velocity": [v, 0, 0],
            "run.end_time": end,
            "run.frames": 161,
        }
        for scatter in (0.0, 2e-6)
        for v, end in ((0.03, 1.9e-3), (0.3, 8e-4), (3.0, 4e-4))
    ]
    found = study_of("square_packing/defects.py", runs("square-in-plane", tmp_path, *changes))
    kinds = {row.kind: row for row in found.rows}
    assert kinds["verification"].ours == pytest.approx(1 / 6, abs=2e-3)
    assert kinds["source"].source == 0.25 and kinds["source"].ours > 0.2
    assert kinds["alone"].ours > 0.3  # where gaps are large beside the overlaps


@pytest.mark.validation
def test_lighter_spheres_hardly_change_what_a_load_cell_reads(tmp_path: Path) -> None:
    steel = {"preset": "stainless-steel-316"}
    short = {"packing.size": 10, "run.end_time": 7e-4}
    others = [
        short | {"replace": [{"index": [6], "material": steel | {"density": one}}]}
        for one in (7369.2, 4000)
    ]
    wall = {"boundary.bottom": {"material": steel}}
    made = runs("load-cell-chain", tmp_path, short, *others, short | wall, others[0] | wall)
    found = study_of("square_packing/load_cell.py", made)
    assert row(found, "First peak, identical spheres, load cell").ours == pytest.approx(
        337, rel=0.01
    )  # as of 20 spheres
    for end in ("load cell", "rigid wall"):
        assert (
            abs(row(found, f"Change of the first peak, {end}, 0.921 of the mass: sphere 6").ours)
            < 0.3
        )
        assert (
            abs(row(found, f"Change of its width, {end}, 0.921 of the mass: sphere 6").ours) < 0.3
        )
    assert row(found, "Change of the first peak, load cell, 0.5 of the mass: sphere 6").ours < -1


def test_a_lighter_sphere_in_a_chain_reflects_little(tmp_path: Path) -> None:
    found = study_of("square_packing/sensor_chain.py", runs("sensor-chain", tmp_path, {}))
    solid, sensor, ratio, reflected = found.rows
    assert (solid.source, sensor.source, ratio.source) == (28.79, 26.52, 92.0)
    assert ratio.ours == pytest.approx(92.1, abs=0.05)
    assert reflected.source == 1.2 and 0.5 < reflected.ours < 1.2
    assert reflected.bound and reflected.deviation is None, "the source: less than 1.2 %"
