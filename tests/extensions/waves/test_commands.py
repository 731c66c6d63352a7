"""Commands on spectra and small waves."""

from __future__ import annotations

import csv
import json
import math
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

import granwave as gw
from granwave.extensions.waves import small_waves as commands
from granwave.extensions.waves.check import small_waves, wave_rows
from granwave.extensions.waves.spectra.quantities import OF_BANDS, OF_MODES, OF_TRANSMISSION
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows.cli.main import main
from granwave.workflows.library import load_case
from tests.helpers.keywords import check_keywords

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
    """The state after the static stage; bands, and modes with the wall, agree with those computed
    from the case.
    """
    run = gw.run("row.toml", run__end_time=2e-6, run__frames=2, load__velocity=1e-3, progress=False)
    np.testing.assert_allclose(gw.bands(run).frequency, gw.bands("row.toml").frequency, rtol=1e-6)
    np.testing.assert_allclose(gw.modes(run).frequency, gw.modes("row.toml").frequency, rtol=1e-6)
    assert main(["bands", str(run.directory), "--set", "packing.size=3"]) == 2
    assert "which is finished" in capsys.readouterr().err


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
    assert rows[-1][0] == "load frequency" and rows[-1][1].endswith(fate)


def test_nothing_without_a_static_force():
    assert small_waves(assemble(load_case("elastic-impact"))) is None


@pytest.mark.parametrize("name", ["bands", "modes", "transmission"])
def test_options_of_commands_are_keywords(name):
    check_keywords(name, "figures")


def test_bands_move_alone_where_the_case_is_the_same(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["-o", "b", "--no-figures"]
    assert main(["bands", "precompressed-chain", *words]) == 0
    assert main(["modes", "precompressed-chain", *words]) == 0
    assert main(["bands", "precompressed-chain", *words, "--points", "5", "--force"]) == 0
    assert {path.name for path in Path("b").iterdir()} >= {"bands.csv", "modes.csv", "spectra.h5"}
    assert {path.name for path in Path("b.old").iterdir()} == {MARKER, "bands.csv", "bands.json"}
