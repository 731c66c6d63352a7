"""Suggestions of the intended key or name, and command-line words that do not run a study."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from granwave.lammps_inputs.case.case import case_keys
from granwave.lammps_inputs.case.hints import _KEY_OF_WORD, _NOTES, _WITHIN
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import library, load_case, load_scan
from granwave.workflows.cli.main import main
from granwave.workflows.finite_elements.punch import ContinuumCase


def _fault(override: str, case: str = "fcc-small") -> str:
    with pytest.raises(InputError) as caught:
        load_case(case, [override])
    (fault,) = caught.value.errors
    return fault


@pytest.mark.parametrize(
    ("override", "hint"),
    [
        ("velocity=3", "velocity: unknown key; did you mean load.velocity?"),
        ("load.speed=3", "load.speed: unknown key; did you mean load.velocity?"),
        ("speed=3", "speed: unknown key; did you mean load.velocity?"),
        ("Load.velocity=3", "Load.velocity: unknown key; did you mean load?"),
        ("load.Velocity=3", "load.Velocity: unknown key; did you mean velocity?"),
        ("contact.mu=0.1", "did you mean contact.friction?"),
        ("mu=0.1", "did you mean contact.friction or boundary.friction?"),
        ("boundary.mu=0.1", "did you mean boundary.friction?"),
        ("friction=0.1", "did you mean contact.friction or boundary.friction?"),
        ("material.youngs=1e9", "did you mean material.youngs_modulus?"),
        ("material.E=1e9", "did you mean material.youngs_modulus?"),
        ("youngs_modulus=1e9", "did you mean material.youngs_modulus?"),
        ("packing.radius=1", "did you mean packing.diameter?"),
        ("radius=1", "did you mean packing.diameter?"),
        ("load.diameter=1", "did you mean packing.diameter?"),
        ("load.end_time=1", "did you mean run.end_time?"),
        ("dt=1e-9", "did you mean run.timestep?"),
        ("packing.material=brass", "did you mean material, outside [packing]?"),
        ("load.force=3", "did you mean load.amplitude?"),
        ("output.frames=3", "did you mean run.frames?"),
        ("packing.velocty=3", "did you mean load.velocity?"),
        ("contact.restitution=0.9", "take contact.loss = {restitution = 0.9, velocity = 1.0}"),
        ("gravity=9.81", 'take [precompression] with kind = "gravity"'),
        ("np=4", "--np"),
        ("index=4", "did you mean load.index?"),
        ("packing.kind=FCC", "did you mean fcc?"),
        ("material=Steel", "did you mean steel?"),
        ("material=ALUMINIUM", "did you mean aluminium?"),
    ],
)
def test_hints_at_the_key_that_was_meant(override: str, hint: str) -> None:
    fault = _fault(override)
    assert fault.startswith("--set: ") and hint in fault


def test_synonyms_lead_to_keys_that_there_are() -> None:
    known = {key.rpartition(".")[2] for key in case_keys()}
    assert set(_KEY_OF_WORD.values()) | set(_WITHIN.values()) <= known
    assert not set(_KEY_OF_WORD) & known, "a key that there is needs no synonym"
    assert not set(_NOTES) & set(_KEY_OF_WORD)


def test_a_table_of_a_file_is_not_blamed_on_the_command_line(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('material = "brass"\n[packing]\nkind = "fcc"\nsize = [3, 3, 2]\ndiameter = 0.01\nradius = 1\n')
    with pytest.raises(InputError) as caught:
        load_case(path, ["packing.seed=3"])
    assert caught.value.errors == [f"{path}: packing.radius: unknown key; did you mean packing.diameter?"]


def test_hints_of_continuum_cases_and_scans(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"velocity: unknown key; did you mean punch.velocity\?"):
        ContinuumCase.from_dict({"material": "brass", "velocity": 3})
    with pytest.raises(InputError, match=r"punch.diametre: unknown key; did you mean diameter\?"):
        ContinuumCase.from_dict({"material": "brass", "punch": {"diametre": 3}})
    path = tmp_path / "scan.toml"
    path.write_text('case = "fcc-small"\nvelocity = 3\n[grid]\nload.velocity = [1]\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"velocity: unknown key; did you mean set.load.velocity\?"):
        load_scan(path)


# ---------------------------------------------------------------------- studies and words of the command line


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["run", "half-space"], "half-space: is a continuum case, expected a granular case: granwave continuum half-space"),
        (["write", "half-space", "-o", "x"], "expected a granular case: granwave continuum half-space"),
        (["run", "sphere-contact"], "is a continuum case, expected a granular case: granwave continuum sphere-contact"),
        (["continuum", "fcc-small"], "fcc-small: is a granular case, expected a continuum case: granwave run fcc-small"),
        (["scan", "fcc-small"], "fcc-small: is a case, expected a scan: granwave run fcc-small"),
        (["scan", "half-space"], "half-space: is a case, expected a scan: granwave continuum half-space"),
        (["run", "velocity-fcc"], "velocity-fcc: is a scan, expected a case: granwave scan velocity-fcc"),
        (["check", "velocity-fcc"], "velocity-fcc: is a scan, expected a case: granwave scan velocity-fcc"),
        (["continuum", "protection"], "protection: is a scan, expected a case: granwave scan protection"),
        (["run", "my-scan.toml"], "my-scan.toml: is a scan, expected a case: granwave scan my-scan.toml"),
        (["run", "suite.toml"], "suite.toml: is a scan, expected a case: granwave scan suite.toml"),
        (["scan", "my-case.toml"], "my-case.toml: is a case, expected a scan: granwave run my-case.toml"),
        (["scan", "of-scan.toml"], "of-scan.toml: case: my-scan.toml: is a scan, expected a case"),
        (["run", "FCC-small"], "FCC-small: neither a file nor a built-in case; did you mean fcc-small?"),
        (["run", "fcc_small"], "did you mean fcc-small?"),
        (["run", "results"], "results: found a directory, expected a case file; its case is results/case.toml"),
        (["run", "empty"], "empty: found a directory, expected a case file; granwave cases lists the built-in ones"),
        (["run", ""], "(empty)"),
        (["run", "a\0b"], "neither a file nor a built-in case"),
    ],
)  # fmt: skip
def test_the_word_that_runs_a_study_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], words: list[str], expected: str
) -> None:
    monkeypatch.chdir(tmp_path)
    case = 'material = "brass"\n[packing]\nkind = "fcc"\nsize = [3, 3, 2]\ndiameter = 0.01\n'
    (tmp_path / "my-case.toml").write_text(case, encoding="utf-8")
    (tmp_path / "my-scan.toml").write_text('case = "fcc-small"\n[grid]\nload.velocity = [1]\n', encoding="utf-8")
    (tmp_path / "of-scan.toml").write_text('case = "my-scan.toml"\n[grid]\nload.velocity = [1]\n', encoding="utf-8")
    (tmp_path / "suite.toml").write_text('scans = ["my-scan.toml"]\n', encoding="utf-8")
    for name in ("results", "empty", "fcc-small", "half-space"):
        (tmp_path / name).mkdir()  # results of that name exist
    (tmp_path / "results" / "case.toml").write_text(case, encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    assert main(words) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and expected in error
    assert sorted(tmp_path.rglob("*")) == before


def test_files_with_similar_names_are_named_before_studies(tmp_path: Path) -> None:
    """By the name without its suffix, which any two files have in common."""
    (tmp_path / "Impact.toml").write_text("")
    (tmp_path / "f.toml").write_text("")
    for name in ("Impact", "impac", "Imapct.toml"):
        with pytest.raises(InputError, match=rf"did you mean {re.escape(str(tmp_path / 'Impact.toml'))}\?"):
            library.find(str(tmp_path / name), library.CASES)
    with pytest.raises(InputError, match="granwave cases lists the built-in ones"):
        library.find(str(tmp_path / "s24.toml"), library.CASES)
