"""Invalid input of real packings on the command line: exit status 2, one clear line, and no files.

Friction, tolerances, vacancies, dents, precompression, movable bottoms, contacts by pair, oblique and spinning impacts.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from granwave.workflows.cli.main import main

CASE = """name = "wrong"
material = "brass"
[packing]
kind = "{kind}"
size = {size}
diameter = 0.01
{packing}
"""

OF_PACKING = [
    ("diameter_scatter = 0.006", "packing.diameter_scatter: found 0.006, expected less than the radius, 0.005 m"),
    ("diameter_scatter = -1e-6", "packing.diameter_scatter: found -1e-06, expected a number at least 0"),
    ('scatter_distribution = "gauss"', 'packing.scatter_distribution: found "gauss", expected one of "uniform"'),
    ("seed = -1", "packing.seed: found -1, expected a whole number from 0"),
    ("vacancies = 1.0", "packing.vacancies: found 1.0, expected a share of the spheres"),
    ("vacancies = [999]", "packing.vacancies: found 999, expected ids from 1 to 144"),
    ("vacancies = [16]", "packing.vacancies: found 16, which"),
]
OF_TABLES = [
    ("[contact]\nfriction = -0.1", "contact.friction: found -0.1, expected a number at least 0"),
    ("[contact]\nfriction = nan", "contact.friction: found nan, expected a number at least 0"),
    ("[boundary]\nfriction = -1", "boundary.friction: found -1, expected a number at least 0"),
    ("[contact]\ninitial_overlap = 2e-3", "found a dent of 0.002 m, expected at most 0.2 R* = 0.0005 m"),
    ("[contact]\ninitial_overlap = {force = 1e7}", "expected at most 0.2 R* = 0.0005 m, as far as the contact law"),
    ("[contact]\ninitial_overlap = {force = 1, overlap = 1e-6}", "contact.initial_overlap: found {force = 1,"),
    ('[contact]\nlaw = "hertz"\ninitial_overlap = 1e-5', 'found dents with contact.law = "hertz", which cannot yield'),
    ('[contact]\ninitial_overlap = "none.h5"', "none.h5: there is no such file; expected the result.h5 of a run"),
    ('[contact]\ninitial_overlap = "text.h5"', "text.h5: is not the result.h5 of a run"),
    ('[contact]\ninitial_overlap = "empty.h5"', "empty.h5: is not the result.h5 of a run"),
    ('[precompression]\nkind = "uniaxial"\npressure = 1e9', "precompression.pressure: would yield every contact"),
    ('[precompression]\nkind = "uniform"\npressure = 1e9', "precompression.pressure: would yield every contact"),
    ('[precompression]\nkind = "uniaxial"', "precompression: found neither pressure nor force, expected one of them"),
    ('[precompression]\nkind = "biaxial"\npressure = 1', 'precompression.kind: found "biaxial"'),
    ('[precompression]\nkind = "uniaxial"\npresure = 1', "precompression.presure: unknown key; did you mean pressure?"),
    ('[boundary]\nbottom = "free"\n[precompression]\nkind = "gravity"', "which something must bear"),
    ("[boundary]\nbottom = {plate = {mass = 1, stiffness = 0}}", "plate.stiffness: found 0, expected a number above 0"),
    ("[boundary]\nbottom = {plate = {mass = 0, stiffness = 1}}", "plate.mass: found 0, expected a number above 0"),
    ("[boundary]\nbottom = {plate = {mass = 1, stiffness = 1, damping = -1}}", "plate.damping: found -1"),
    ("[boundary]\nbottom = {plates = {mass = 1}}", "boundary.bottom.plates: unknown key; did you mean plate?"),
    ("[boundary]\nbottom = {half_space = {}}", "boundary.bottom.material: missing; a half_space needs it"),
    ("[boundary]\nbottom = {bar = {length = 1, area = 1}}", "boundary.bottom.material: missing; a bar needs it"),
    (
        '[boundary]\nbottom = {bar = {length = 1, area = 1, end = "loose"}, material = "steel"}',
        'bar.end: found "loose"',
    ),
    ('[boundary]\nbottom = {half_space = {}, material = "lead"}', 'boundary.bottom.material: found "lead"'),
    ("[boundary]\nsides = {plate = {mass = 1, stiffness = 1}}", "boundary.sides.plate: unknown key"),
    ('[[pair]]\nmaterials = ["brass", "lead"]\nfriction = 0.1', 'pair.1.materials: found "lead", expected materials'),
    ('[[pair]]\nmaterials = ["brass", "brass"]\nfriction = -1', "pair.1.friction: found -1"),
    ('[[pair]]\nmaterials = ["brass", "brass"]', "pair.1: changes nothing; give keys of [contact]"),
    ("[load]\nangle = 90", "load.angle: found 90, expected a number at least 0 and below 90"),
    ("[load]\nspin = [1, 2]", "load.spin: found [1, 2], expected [x, y, z] in rad/s"),
    ('[[replace]]\nmaterial = "steel"', "replace.1: found no spheres, expected one of index, a box"),
    ("[[replace]]\nindex = 60\ndiameter = 0.012", "replace.1.diameter: sphere 60 of 0.012 m overlaps"),
]


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """Run an invalid case; returns the messages."""

    def run(text: str, packing: str = "", kind: str = "fcc", size: str = "[6, 6, 4]") -> str:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "text.h5").write_text("not HDF5", encoding="utf-8")
        with h5py.File(tmp_path / "empty.h5", "w"):
            pass
        (tmp_path / "wrong.toml").write_text(
            CASE.format(kind=kind, size=size, packing=packing) + text, encoding="utf-8"
        )
        before = sorted(tmp_path.rglob("*"))
        capsys.readouterr()
        assert main(["run", "wrong.toml"]) == 2
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1 and said.err.startswith("granwave: ")
        assert sorted(tmp_path.rglob("*")) == before
        return said.err

    return run


@pytest.mark.parametrize(("packing", "message"), OF_PACKING)
def test_packings(refused, packing: str, message: str) -> None:
    assert message in refused("", packing)


@pytest.mark.parametrize(("text", "message"), OF_TABLES)
def test_tables(refused, text: str, message: str) -> None:
    assert message in refused(text)


def test_a_chain_has_no_vacancies(refused) -> None:
    assert "found in a chain, which has none" in refused("", "vacancies = [3]", "chain", "10")


def test_a_precompressed_chain_takes_a_force(refused) -> None:
    text = '[precompression]\nkind = "uniaxial"\npressure = 1e4'
    assert "found for a chain, which has no face; expected a force" in refused(text, "", "chain", "10")


def test_dents_of_another_packing(refused, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    small = CASE.format(kind="fcc", size="[3, 3, 2]", packing="").replace("wrong", "small")
    (tmp_path / "small.toml").write_text(small + "[run]\nend_time = 2e-5\nframes = 2\n", encoding="utf-8")
    assert main(["run", "small.toml", "--no-figures"]) == 0
    said = refused('[contact]\ninitial_overlap = "small"')
    assert "small/result.h5: is of another packing: found 18 spheres, expected 144" in said


def test_the_program_itself(granwave, tmp_path: Path) -> None:
    (tmp_path / "c.toml").write_text(CASE.format(kind="fcc", size="[6, 6, 4]", packing=""), encoding="utf-8")
    done = granwave("run", "c.toml", "--set", "contact.friction=-0.1", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert (
        done.stderr == "granwave: --set: contact.friction: found -0.1, expected a number at least 0 and at most 10000\n"
    )
    assert [path.name for path in tmp_path.iterdir()] == ["c.toml"]
