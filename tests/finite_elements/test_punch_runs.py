"""Runs of the punch on a block: progress, files, refusals."""

from __future__ import annotations

import json
import logging
import math

import h5py
import numpy as np
import pytest

from granwave.lammps_inputs import InputError, RunError
from granwave.workflows.cli.main import main
from granwave.workflows.finite_elements.frame import check_memory
from granwave.workflows.finite_elements.punch import ContinuumCase
from granwave.workflows.finite_elements.punch.run import run_continuum
from granwave.workflows.finite_elements.runner import advance, digits_of
from tests.helpers.punch import values_of

SMALL = {"name": "small", "material": "brass", "run": {"elements": 1500}}


def test_defaults_are_those_of_the_interface():
    case = ContinuumCase.from_dict({"material": "brass"}, "half-space.toml")
    assert case.name == "half-space"
    assert (case.block.diameter, case.block.height) == (0.1, 0.1)
    assert (case.punch.diameter, case.punch.mass, case.punch.velocity, case.punch.taper) == (0.01, 0.1, 10.0, 1e-4)
    assert (case.run.end_time, case.run.elements) == ("auto", 62_500)
    assert case.energy_unit == pytest.approx(2.630, abs=5e-4)
    again = ContinuumCase.from_dict(case.to_dict())
    assert again == case


def test_every_fault_is_named(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(
        "[block]\ndiameter = 0.01\n[punch]\ndiameter = 0.02\ntaper = 0.03\nwidth = 1\n"
        '[material]\npreset = "brass"\nyield_strength = -1\n[run]\nelements = 5\n'
    )
    with pytest.raises(InputError) as caught:
        ContinuumCase.load(path, ["run.end_time=soon"])
    text = "\n".join(caught.value.errors)
    for words in ("punch.width: unknown", "material.yield_strength", "run.elements", "--set: run.end_time"):
        assert words in text
    with pytest.raises(InputError, match=r"punch\.diameter: found 0\.2 m, expected less than block\.diameter"):
        ContinuumCase.from_dict({"material": "brass", "punch": {"diameter": 0.2}})
    with pytest.raises(InputError, match=r"punch\.taper"):
        ContinuumCase.from_dict({"material": "brass", "punch": {"taper": 0.006}})


def test_mesh_beyond_memory_is_refused(tmp_path):
    case = ContinuumCase.from_dict({"material": "brass", "run": {"elements": 10**9}})
    with pytest.raises(InputError, match=r"run\.elements: 1000000000 elements need"):
        run_continuum(case, tmp_path / "r")
    assert not (tmp_path / "r").exists()
    with pytest.raises(InputError):
        check_memory(ContinuumCase.from_dict(SMALL), 1e6)


def test_run_leaves_its_results(tmp_path):
    case = ContinuumCase.from_dict(SMALL)
    summary = run_continuum(case, tmp_path / "r")
    assert json.loads((tmp_path / "r" / "summary.json").read_text()) == summary
    assert summary["kind"] == "continuum" and summary["energy_input_J"] == 5.0
    parts = ("kinetic", "elastic", "dissipated", "punch", "hourglass", "viscous", "contact")
    assert sum(summary[f"energy_{name}_J"] for name in parts) == pytest.approx(5.0, rel=5e-3)
    assert summary["dissipated_fraction"] == pytest.approx(summary["energy_dissipated_J"] / 5.0)
    with h5py.File(tmp_path / "r" / "result.h5") as file:
        sets = []
        file.visititems(lambda name, item: sets.append((name, item)) if isinstance(item, h5py.Dataset) else None)
        assert all("unit" in item.attrs for _, item in sets)
        assert {"nodes", "elements", "fields/von_mises", "energy/plastic"} <= {name for name, _ in sets}
        assert np.diff(file["energy/time"][:]).max() <= 2e-7
        assert file["energy/time"][-1] == pytest.approx(file["fields/time"][-1])
        assert file["fields/von_mises"].shape[1] == len(file["elements"]) == summary["n_elements"]
        energy = np.sum(file["fields/plastic_energy"][:] * file["element_volume"][:])
        assert energy == pytest.approx(summary["energy_dissipated_J"], rel=1e-9)
        assert "brass" in file.attrs["case"] and "numba" in json.loads(file.attrs["versions"])
    assert summary["zone_volume_99_m3"] < summary["plastic_zone_volume_ever_m3"]
    assert (summary["zone_cut"], summary["wave_returned"]) == ([], ["sides"])
    for name in ("energies", "plastic_zone", "plastic_zone_volume", "plastic_zone_size", "von_mises"):
        for suffix in ("png", "pdf", "csv"):
            assert (tmp_path / "r" / "figures" / f"{name}.{suffix}").stat().st_size > 0
    # and further commands in that directory
    with pytest.raises(InputError, match="already holds results"):
        run_continuum(case, tmp_path / "r")
    assert run_continuum(case, tmp_path / "r", resume=True) == summary
    other = ContinuumCase.from_dict(SMALL | {"punch": {"velocity": 4.0}})
    with pytest.raises(InputError, match=r"another case \(different: punch\)"):
        run_continuum(other, tmp_path / "r", resume=True)
    replaced = run_continuum(other, tmp_path / "r", force=True, figures=False)
    assert replaced["energy_input_J"] == pytest.approx(0.8)
    assert not (tmp_path / "r" / "figures").exists()


def test_given_end_time_is_met():
    found = values_of(elements=500, end_time=1.03e-5)
    assert found["end_reason"] == "end_time"
    assert found["end_time_s"] == pytest.approx(1.03e-5, abs=found["timestep_s"])


def test_unstable_run_stops_and_keeps_what_it_has(tmp_path):
    case = ContinuumCase.from_dict({"name": "u", "material": "brass", "run": {"elements": 500, "timestep": 5e-7}})
    with pytest.raises(RunError, match="energy balance is off"):
        run_continuum(case, tmp_path, figures=False)
    assert json.loads((tmp_path / "summary.json").read_text())["end_reason"] == "refused"
    assert (tmp_path / "result.h5").exists()


def test_large_strains_are_named(tmp_path, caplog):
    case = ContinuumCase.from_dict(SMALL | {"punch": {"velocity": 100.0}})
    with caplog.at_level(logging.WARNING):
        summary = run_continuum(case, tmp_path, figures=False)
    assert "strains are not small" in caplog.text
    assert f"{summary['largest_strain']:.2f}" in caplog.text


@pytest.mark.validation
@pytest.mark.parametrize("punch", [{"velocity": 6.0}, {"velocity": 16.0}, {"mass": 0.01, "velocity": 40.0}])
def test_results_converge_with_the_mesh(punch):
    found = [values_of({"punch": punch}, elements=elements) for elements in (4000, 16_000, 62_500)]
    fractions, volumes = (
        [values[name] for values in found] for name in ("dissipated_fraction", "plastic_zone_volume_m3")
    )
    print(f"\n{punch}: fraction {fractions}, volume {volumes}")
    assert fractions[1] == pytest.approx(fractions[2], rel=0.02)
    assert volumes[1] == pytest.approx(volumes[2], rel=0.07)  # 6 m/s: 5.5 %, the others less
    assert fractions[0] == pytest.approx(fractions[2], rel=0.03)
    assert volumes[0] == pytest.approx(volumes[2], rel=0.20)  # 6 m/s: 17 %
    assert abs(volumes[1] - volumes[2]) < abs(volumes[0] - volumes[2])
    half = values_of({"punch": punch}, elements=16_000, timestep=found[1]["timestep_s"] / 2)
    assert half["dissipated_fraction"] == pytest.approx(fractions[1], rel=2e-3)
    assert half["plastic_zone_volume_m3"] == pytest.approx(volumes[1], rel=0.02)


@pytest.mark.validation
def test_taper_does_not_matter():
    """Two elements across each taper, well above the onset of yield."""
    tapers = (5e-5, 1e-4, 2e-4)
    found = [
        values_of({"punch": {"velocity": 16.0, "taper": taper}}, elements=16_000, edge_size=taper / 2)
        for taper in tapers
    ]
    fractions = [values["dissipated_fraction"] for values in found]
    volumes = [values["plastic_zone_volume_m3"] for values in found]
    print(f"\ntapers: fraction {fractions}, volume {volumes}")
    assert np.ptp(fractions) < 0.03 * np.mean(fractions)
    assert np.ptp(volumes) < 0.05 * np.mean(volumes)


def test_command_line(granwave, tmp_path, monkeypatch, capsys):
    words = ["continuum", "half-space", "-o", "out", "--set", "run.elements=500"]
    done = granwave(*words, cwd=tmp_path)
    assert done.returncode == 0 and "plastically" in done.stdout, done.stderr
    monkeypatch.chdir(tmp_path)
    wrong = ["check", "half-space", "--set", "punch.velocity=-1"]
    for refused in (words, ["continuum", "fcc-small"], ["run", "half-space"], wrong):
        assert main(refused) == 2
    assert main([*words, "--resume"]) == main(["report", "out", "-o", "page.md"]) == 0
    capsys.readouterr()
    assert main(["check", "half-space", "--set", "run.elements=500"]) == 0 and "elements" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out", "page.md"] or (tmp_path / "page_files").is_dir()


@pytest.mark.parametrize("total", [6.5, 0.8, 0.0123, 2e-5])
def test_a_bar_ends_at_its_total(total):
    """Whatever the size of the total, and where the last place lies beyond it."""
    digits, shown = digits_of(total), 0.0
    end = round(total, digits)
    assert end == pytest.approx(total, rel=0.01)
    places = [0.1 * total * n for n in range(10)] + [total, 1.4 * total]
    for place in places:
        step = advance(shown, place, end, digits)
        assert step >= 0
        shown += step
        assert shown <= end * (1 + 1e-9)
    assert math.isclose(shown, end)


def test_a_bar_without_a_total_goes_on():
    assert digits_of(None) == 2
    assert advance(1.0, 3.456, None, 2) == 2.46
    assert advance(5.0, 3.0, None, 2) == 0
