"""Commands on spectra and small waves."""

from __future__ import annotations

import csv
import json
import math
import re
import shlex

import h5py
import numpy as np
import pytest

import granwave as gw
from granwave.extensions.waves import small_waves as commands
from granwave.extensions.waves.check import small_waves, wave_rows
from granwave.extensions.waves.spectra.quantities import OF_BANDS, OF_MODES, OF_TRANSMISSION
from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.planning.impact_input import energy_unit, inputs_of_packing
from granwave.workflows.cli.main import main
from granwave.workflows.library import find_for, load_case
from granwave.workflows.run.driver import run_case

ROW = """
name = "row"
material = "brass"
[packing]
kind = "chain"
size = 12
diameter = 0.01
[contact]
law = "hertz"
[precompression]
kind = "uniaxial"
force = 20.0
"""


@pytest.fixture
def row(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "row.toml").write_text(ROW)
    return tmp_path


def test_files_of_all_three_share_a_directory(row, capsys):
    assert main(["bands", "row.toml", "-o", "out", "--points", "5", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((row / "out" / "bands.json").read_text())
    assert main(["modes", "row.toml", "-o", "out", "--no-figures"]) == 0
    frequencies = ["--frequencies", "500:20000:4"]
    assert (
        main(
            [
                "transmission",
                "row.toml",
                "--drive",
                "1",
                "--sensor",
                "4,8",
                *frequencies,
                "-o",
                "out",
            ]
        )
        == 0
    )
    with (row / "out" / "bands.csv").open() as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == ["distance", "kx", "ky", "kz", "f1_Hz"] and len(table) == 5
    assert float(table[-1]["f1_Hz"]) == pytest.approx(printed["highest_frequency_Hz"], rel=1e-8)
    with (row / "out" / "transmission.csv").open() as file:
        table = list(csv.DictReader(file))
    assert (
        list(table[0]) == ["frequency_Hz", "sensor", "amplitude_ratio", "phase_rad"]
        and len(table) == 8
    )
    with h5py.File(row / "out" / "spectra.h5") as file:
        assert {"bands", "modes", "transmission"} == set(file)
        assert file["bands/frequency"].attrs["unit"] == "Hz" and file["modes/frequency"].shape == (
            12,
        )
        assert file["bands/springs/force"][0] == pytest.approx(20)
    assert {"bands.png", "bands.pdf", "transmission.csv"} <= {
        one.name for one in (row / "out" / "figures").iterdir()
    }
    assert main(["bands", "row.toml", "-o", "out"]) == 2
    assert "already holds results (bands.csv)" in capsys.readouterr().err
    assert main(["bands", "row.toml", "-o", "out", "--force", "--no-figures"]) == 0


def test_python_gives_datasets(row):
    bands = gw.bands("row.toml", path=[[0, 0, 0], [0, 0, 314.159265]], points=3)
    assert bands.frequency.dims == ("point", "band") and bands.frequency.attrs["units"] == "Hz"
    np.testing.assert_allclose(bands.k.values[-1], [0, 0, 314.159265])
    assert gw.modes("row.toml").sizes["mode"] == 12
    through = gw.transmission("row.toml", drive=1, sensors=[5], frequencies=[100.0], end="matched")
    assert float(through.amplitude_ratio[0, 0]) == pytest.approx(1, rel=1e-6)


def test_a_finished_run_serves_as_a_case(row, capsys):
    """The state that its static stage left; bands, and modes with its wall, as computed from the
    case.
    """
    run = gw.run("row.toml", run__end_time=2e-6, run__frames=2, load__velocity=1e-3, progress=False)
    np.testing.assert_allclose(gw.bands(run).frequency, gw.bands("row.toml").frequency, rtol=1e-6)
    np.testing.assert_allclose(gw.modes(run).frequency, gw.modes("row.toml").frequency, rtol=1e-6)
    assert main(["bands", str(run.directory), "--set", "packing.size=3"]) == 2
    assert "which is done" in capsys.readouterr().err


def test_each_value_has_its_entry(row):
    packing = assemble(load_case("row.toml"))
    tables = (OF_BANDS, OF_MODES, OF_TRANSMISSION)
    found = (
        commands.bands(packing, None, points=3),
        commands.modes(packing, None),
        commands.steady(packing, None, drive=[1, 2], sensors=[5], frequencies=np.array([1e3])),
    )
    for table, (waves, _) in zip(tables, found, strict=True):
        assert {one.name for one in table} == set(waves.summary)


def test_another_case_in_the_same_directory(row, capsys):
    assert main(["bands", "row.toml", "-o", "out", "--points", "5", "--no-figures"]) == 0
    before = (row / "out" / "spectra.h5").read_bytes()
    other = ["modes", "row.toml", "--set", "precompression.force=30", "-o", "out", "--no-figures"]
    capsys.readouterr()
    assert main(other) == 2
    assert "out: holds results of another case (bands.csv); --force" in capsys.readouterr().err
    assert (row / "out" / "spectra.h5").read_bytes() == before
    assert main([*other, "--force"]) == 0
    assert not (row / "out" / "bands.csv").exists() and (row / "out" / "modes.csv").exists()
    with h5py.File(row / "out" / "spectra.h5") as file:
        assert set(file) == {"modes"}


@pytest.mark.parametrize(
    ("cell", "places", "message"),
    [
        (
            "[[0, 0, 0.004]]",
            [[0, 0, 0]],
            "found a period of 0.004 m, shorter than a grain with a diameter of 0.01 m",
        ),
        ("[[0, 0, 1e-12]]", [[0, 0, 0]], "shorter than a grain"),
        (
            "[[0, 0, 0.014]]",
            [[0, 0, 0], [0, 0, 0.01]],
            "found grain 2 in an image of grain 1: they overlap by 0.006 m",
        ),
    ],
)
def test_a_cell_smaller_than_its_grains(row, capsys, cell, places, message):
    (row / "g.csv").write_text(
        "x,y,z,diameter\n" + "".join(f"{x},{y},{z},0.01\n" for x, y, z in places)
    )
    text = ROW.replace(
        'kind = "chain"\nsize = 12\ndiameter = 0.01',
        f'kind = "file"\nfile = "g.csv"\ncell = {cell}',
    )
    (row / "cell.toml").write_text(text)
    assert main(["bands", "cell.toml", "-o", "out", "--no-figures"]) == 2
    assert message in capsys.readouterr().err


FORCE = 20.0
DIAMETER = 0.010


def chain(**changes):
    tables = {
        "packing.diameter": DIAMETER, "packing.size": 40, "precompression.force": FORCE, "material": "steel",
        "contact.law": "hertz", **changes,
    }  # fmt: skip
    return load_case("precompressed-chain", tables)


def closed_forms():
    """Cut-off, Hz, and speed of long waves, m/s: stiffness k = 3/2 F/overlap of Hertz's law."""
    case = chain()
    modulus = case.material.youngs_modulus / (1 - case.material.poisson_ratio**2) / 2
    radius = DIAMETER / 4
    overlap = (3 * FORCE / (4 * modulus * math.sqrt(radius))) ** (2 / 3)
    stiffness = 1.5 * FORCE / overlap
    mass = case.material.density * math.pi * DIAMETER**3 / 6
    return math.sqrt(stiffness / mass) / math.pi, DIAMETER * math.sqrt(stiffness / mass)


def numbers(text):
    return [float(one) for one in re.findall(r"\d+(?:\.\d+)?(?:e[-+]\d+)?", text)]


def test_cut_off_and_speed():
    cut_off, speed = closed_forms()
    rows = list(wave_rows(small_waves(assemble(chain()))))
    assert numbers(rows[0][1])[0] == pytest.approx(cut_off * 1e-3, rel=1e-3)
    assert numbers(rows[1][1])[0] == pytest.approx(speed, rel=2e-3)


@pytest.mark.parametrize(("share", "fate"), [(0.5, "passes"), (1.1, "is stopped")])
def test_frequency_of_the_load(share, fate):
    cut_off, _ = closed_forms()
    load = {
        "load": {
            "kind": "force",
            "shape": "harmonic",
            "amplitude": 0.01,
            "frequency": share * cut_off,
        }
    }
    rows = list(wave_rows(small_waves(assemble(chain(**load)))))
    assert rows[-1][0] == "load's frequency" and rows[-1][1].endswith(fate)


def test_nothing_without_a_static_force():
    assert small_waves(assemble(load_case("elastic-impact"))) is None


def test_a_case_of_inference_is_named_as_such(tmp_path):
    file = tmp_path / "crystal.toml"
    file.write_text("[infer]\nfriction = 0.3\n")
    with pytest.raises(InputError, match=r"granwave infer GRAINS\.csv --case"):
        find_for(str(file), "run", "continuum")


SMALL = ["--set", "packing.size=[6,6,4]"]
UNIT = "energy_input_over_sigma2_D3_E"


def plan_of(words, capsys):
    """Return what granwave check says of a command that would run a case."""
    without_directory = words[: words.index("-o")] if "-o" in words else words
    assert main(["check", *without_directory, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(
    "changes",
    [
        [],
        ["material=steel"],
        ["load.spheres=7", "load.velocity=2"],
        ["packing.diameter=0.004", "packing.kind=bcc", "load.velocity=12"],
        ["material.youngs_modulus=100e9", "material.density=5000"],
    ],
)
def test_the_continuum_case_has_the_input_of_the_packing(changes, capsys):
    packing = plan_of(
        ["fcc-small", *SMALL, *(word for change in changes for word in ("--set", change))], capsys
    )
    program, verb, *words = shlex.split(packing["counterpart"]["command"])
    assert (program, verb) == ("granwave", "continuum")
    continuum = plan_of(words, capsys)
    assert continuum["command"] == "continuum"
    assert continuum[UNIT] == pytest.approx(packing[UNIT], rel=1e-9)
    assert continuum["energy_input_J"] == pytest.approx(packing["energy_input_J"], rel=1e-9)


@pytest.mark.parametrize(
    ("changes", "struck"),
    [([], "load.spheres=1"), (["punch.mass=0.2", "punch.velocity=40"], "load.spheres=7"),
     (["punch.diameter=0.02", "material=steel"], "load.spheres=1")],
)  # fmt: skip
def test_the_packing_has_the_input_of_the_continuum_case(changes, struck, capsys):
    continuum = plan_of(
        ["half-space", *(word for change in changes for word in ("--set", change))], capsys
    )
    program, verb, *words = shlex.split(continuum["counterpart"]["command"])
    assert (program, verb) == ("granwave", "run")
    assert struck in words
    packing = plan_of(words, capsys)
    assert packing[UNIT] == pytest.approx(continuum[UNIT], rel=1e-9)


def test_the_command_runs_and_its_summary_agrees(tmp_path, capsys):
    packing = plan_of(["fcc-small", *SMALL], capsys)
    words = shlex.split(packing["counterpart"]["command"])[1:-1]
    coarse = ["--set", "run.elements=400", "--set", "run.end_time=2e-6", "--no-figures", "--json"]
    assert main([*words, str(tmp_path / "block"), *coarse]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["energy_input_normalised"] == pytest.approx(packing[UNIT], rel=1e-9)


def test_inputs_are_those_of_the_summary(tmp_path):
    case = load_case(
        "fcc-small", {"packing.size": [4, 4, 3], "run.end_time": 2e-5, "load.spheres": 3}
    )
    inputs = inputs_of_packing(assemble(case))
    summary = run_case(case, tmp_path, figures=False).summary
    assert inputs.energy == pytest.approx(summary["energy_input_J"], rel=1e-12)
    assert inputs.energy_normalised == pytest.approx(summary["energy_input_normalised"], rel=1e-12)
    assert inputs.velocity_normalised == pytest.approx(summary["velocity_normalised"], rel=1e-12)
    # brass, 10 mm: sigma_y^2 D^3/E = (550e6)^2 1e-6 / 115e9 J
    assert energy_unit(material("brass"), 0.01) == pytest.approx(2.6304347826)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["elastic-impact"], "the contacts do not yield"),
        (["two-spheres"], "no block: a chain"),
        (["fcc-small", "--set", "packing.size=[1,1,6]"], "or too narrow"),
        (["elastoplastic-pulse"], "impacts and strikers along z alone"),
        (["fcc-small", *SMALL, "--set", "load.angle=30"], "impacts and strikers along z alone"),
    ],
)
def test_where_there_is_none_it_says_why(words, reason, capsys):
    counterpart = plan_of(words, capsys)["counterpart"]
    assert counterpart["command"] is None and reason in counterpart["reason"]


def test_check_prints_inputs_and_the_command(capsys):
    assert main(["check", "fcc-small", *SMALL]) == 0
    lines = {line.partition("  ")[0]: line for line in capsys.readouterr().out.splitlines()}
    assert "0.0556324 J" in lines["energy in"]
    assert "8434.55 F_y alpha_y" in lines["energy normalised"]
    assert "47.4259" in lines["velocity normalised"]
    assert any(
        line.startswith("continuum of equal input: granwave continuum half-space --set")
        for line in lines
    )
