"""Square packings hit by strikers: energies, waves and lengths of the source; sensors; directions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from granwave.analysis import Result
from granwave.analysis.figures.run_figures import draw_figures
from granwave.analysis.measures.impact.regions import groups, regions
from granwave.analysis.measures.waves import pulses
from granwave.analysis.measures.waves.directions import energy_of_spheres, spread, travelling_frame
from granwave.analysis.studies.square.runs import PackingRun
from granwave.analysis.studies.study import make_studies
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict, load_case
from granwave.workflows import run_case

CASES = Path(__file__).parents[3] / "workflows" / "cases"
STUDIES = ("square-impact", "square-wave-speed", "square-yielding", "directional")
STEEL = {"youngs_modulus": 193e9, "poisson_ratio": 0.3, "density": 8000.0, "yield_strength": 240e6}


def run(name: str, directory: Path, **changes: Any) -> PackingRun:
    outcome = run_case(load_case(CASES / f"{name}.toml", changes), directory, figures=False)
    assert outcome.summary["energy_balance_error"] < 1e-5
    return PackingRun(name, directory, load_case(directory / "case.toml"), outcome.summary)


@pytest.fixture(scope="module")
def in_plane(tmp_path_factory: pytest.TempPathFactory) -> PackingRun:
    return run("square-in-plane", tmp_path_factory.mktemp("square") / "in")


@pytest.fixture(scope="module")
def out_of_plane(tmp_path_factory: pytest.TempPathFactory) -> PackingRun:
    return run("square-out-of-plane", tmp_path_factory.mktemp("square") / "out")


def test_energies_of_the_source(in_plane: PackingRun, out_of_plane: PackingRun) -> None:
    found = in_plane.settled
    assert 100 * found["central chains"] == pytest.approx(71.5, abs=0.1)
    assert 100 * found["edge chains"] == pytest.approx(24.5, abs=0.1)
    found = out_of_plane.settled
    assert 100 * found["central chains"] == pytest.approx(44.3, abs=0.1)
    assert 100 * found["strikers"] == pytest.approx(8.0, abs=0.1)
    assert 100 * found["struck spheres"] == pytest.approx(47.7, abs=0.1)
    for one in (in_plane, out_of_plane):
        shares = regions(one.snapshots)
        np.testing.assert_allclose(sum(shares.values()), 1.0, atol=2e-5)  # all energy is accounted for
        assert shares["other spheres"].max() < 1e-6


def test_wave_is_nesterenkos_but_shorter(in_plane: PackingRun) -> None:
    chain = groups(in_plane.snapshots)["central chains"][0]
    assert chain.name == "Y10 +x" and len(chain.rows) == 20
    velocity, diameter = chain.speeds(in_plane.snapshots), in_plane.case.packing.diameter
    found = pulses.peaks(in_plane.snapshots.time, velocity, diameter)
    expected = pulses.speed_of(in_plane.case.material, found.velocity[9])
    assert found.speed[9] == pytest.approx(expected, rel=0.012)
    lengths, theory = pulses.lengths(in_plane.snapshots.time, velocity, diameter), pulses.theory()
    assert theory["fit of velocity"] == pytest.approx(4.967, abs=1e-3)
    ratio = [lengths[name][12] / theory[name] for name in pulses.MEASURES]
    np.testing.assert_allclose(ratio, [0.871, 0.890, 0.875, 0.873], atol=0.004)


def test_fits_of_length_are_exact_for_the_waves_of_the_theory() -> None:
    time, diameter, speed = np.linspace(0, 1e-3, 401), 0.02, 500.0
    length = pulses.LENGTH * diameter
    wave = []
    for sphere in range(9):
        phase = np.pi * speed * (time - 2.5e-4 - sphere * diameter / speed) / length
        wave.append(np.cos(np.clip(phase, -np.pi / 2, np.pi / 2)) ** 4)
    found = pulses.lengths(time, np.stack(wave, axis=1), diameter)
    for name, expected in pulses.theory().items():
        np.testing.assert_allclose(found[name][1:-1], expected, rtol=2e-3)


def test_studies_and_their_pictures(in_plane: PackingRun, tmp_path: Path) -> None:
    less = {"sensor": [], "run.frames": 121}
    slow = {"striker.2.velocity": [0.05, 0, 0], "run.end_time": 1e-3}
    fast = {"striker.2.velocity": [3.0, 0, 0], "run.end_time": 5e-4}
    slow, fast = (run("square-in-plane", tmp_path / f"{n}", **less, **one) for n, one in enumerate((slow, fast)))
    found = {study.name: study for study in make_studies({name: [fast, in_plane, slow] for name in STUDIES})}
    assert {"square-in-plane", "square-wave-speed", "directional"} <= found.keys()
    rows = {row.quantity: row for study in found.values() for row in study.rows}
    for name in ("central", "edge"):
        row = rows[f"Exponent of wave speed against particle velocity, {name} chains, in-plane"]
        assert row.kind == "verification" and row.ours == pytest.approx(row.theory, abs=5e-4)
    assert rows["Energy in central chains, in-plane"].source == 71.5
    assert rows["Energy along contacts: square, elastic, 3 m/s, in-plane"].ours == pytest.approx(100)
    names = [picture.name for study in found.values() for picture in study.pictures]
    assert len(names) == len(set(names)) == 5


def test_sensors_record_the_acceleration(in_plane: PackingRun) -> None:
    assert in_plane.summary["sensor_2D_peak_acceleration_m_s2"] == 0.0
    with Result(in_plane.directory) as result:
        time, force = result["probes/time"], result["probes/sphere_206_fx"]
        mass = result["spheres/mass"][205]
        gained = np.sum((force[1:] + force[:-1]) / 2 * np.diff(time)) / mass
        assert gained == pytest.approx(result["probes/sphere_206_vx"][-1], abs=1e-5)
        assert in_plane.summary["sensor_1B_peak_acceleration_m_s2"] == pytest.approx(
            np.abs(force).max() / mass, rel=1e-3
        )
    drawn = draw_figures(in_plane.directory, names=("accelerations", "directions", "probes"))
    assert [path.stem for path in drawn] == ["accelerations", "directions"]


def test_yielding_leaves_little_for_the_waves(tmp_path: Path) -> None:
    changes = {"contact.law": "elastoplastic", "packing.size": [12, 12], "sensor": [], "run.frames": 121}
    places = {"striker.1.touches": [61, 73], "striker.2.touches": 145}
    plastic = run("square-in-plane", tmp_path / "plastic", **changes, **places)
    found = plastic.settled
    assert found["dissipated"] > 0.85 and found["central chains"] < 0.2
    (study,) = make_studies({"square-yielding": [plastic]})
    assert study.rows[0].source is None and study.rows[0].ours == pytest.approx(100 * found["dissipated"])


@pytest.mark.parametrize("kind", ["fcc", "hcp"])
def test_directions_of_other_packings(kind: str, tmp_path: Path) -> None:
    changes = {"packing.size": [12, 12, 6], "packing.kind": kind, "striker.1.touches": [54, 55, 66], "run.frames": 11}
    places = {"striker.2.touches": 865, "contact.law": "elastoplastic", "run.end_time": 2e-4}
    one = run("fcc-striker", tmp_path / kind, **changes, **places)
    energy, lost = one.spreads
    assert energy is not None and lost is not None
    for found in (energy, lost):
        assert found.cells.sum() == pytest.approx(1.0)
        assert found.even < found.along <= 1
    assert lost.along > energy.along  # contacts along the directions of contacts yield first
    with Result(one.directory) as result:
        frame = travelling_frame(result)
        assert spread(result, np.zeros(result.n_spheres)) is None
        stored = result.frame(frame, "elastic_energy").sum()
        assert stored == pytest.approx(
            np.interp(result.frame_times[frame], result["energy/time"], result["energy/elastic"]), rel=0.02
        )
        assert energy_of_spheres(result, frame).sum() < result.energy_input
    assert [path.stem for path in draw_figures(one.directory, names=("directions",))] == ["directions"]


def square(**tables: Any) -> Case:
    packing = {"kind": "square", "size": [6, 6], "diameter": 0.01905}
    return case_from_dict({"name": "square", "material": STEEL, "packing": packing} | tables)


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ({"striker": [{"touches": []}]}, r"striker.1.touches: found \[\], expected an id from 1 up"),
        ({"striker": [{"touches": [1, 3]}]}, "striker: striker 1: its place overlaps sphere 2"),
        ({"striker": [{"touches": [1, 2]}, {"touches": [1, 2]}]}, "striker: striker 2: its place overlaps sphere 37"),
        ({"sensor": [{"name": "A", "id": 37}]}, "sensor.1.id: found 37, expected an id from 1 to 36"),
    ],
)
def test_bad_input_is_one_clear_line(tables: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as error:
        square(**tables)
    assert len(error.value.errors) == 1


def test_a_wall_cannot_cut_a_striker_of_a_chain() -> None:
    chain = {"kind": "chain", "size": 6, "diameter": 0.01905}
    with pytest.raises(InputError, match=r"striker\.1: the wall at the bottom cuts through it, 0\.019"):
        case_from_dict({"name": "chain", "material": STEEL, "packing": chain, "striker": [{"touches": 6}]})


def test_theory_of_the_speed() -> None:
    assert pulses.speed_of(material("stainless-steel-316"), 0.1187) == pytest.approx(464.6, abs=0.5)
