"""Python code and case and scan files of the README, run unmodified."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from granwave._contact_laws import LAWS
from granwave.lammps_inputs import load_case
from granwave.lammps_inputs.lattices import KINDS
from granwave.workflows import library, load_profile, load_scan
from tests.conftest import PLAIN
from tests.golden import outputs

README = (Path(__file__).parent.parent / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.MULTILINE | re.DOTALL)


def test_python(tmp_path):
    pytest.importorskip("snakemake")
    (tmp_path / "readme.py").write_text("\n".join(blocks("python")))
    done = subprocess.run(
        [sys.executable, "readme.py"], cwd=tmp_path, env=PLAIN, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split()) >= 27


def test_files(tmp_path):
    names = ("case", "chain", "real", "scan", "profile")
    for name, text in zip(names, blocks("toml"), strict=True):
        (tmp_path / f"{name}.toml").write_text(text)
    assert load_case(tmp_path / "case.toml").name == "mine"
    assert load_case(tmp_path / "chain.toml").bar is not None
    assert load_case(tmp_path / "real.toml").precompression is not None
    assert len(load_scan(tmp_path / "scan.toml").points) == 7 * 3 * 2 + 1
    assert load_profile(tmp_path / "profile.toml").nodes == 1


def test_built_in_studies_that_commands_name_exist():
    named = re.findall(r"^    granwave (run|check|show|scan|continuum) ([a-z][a-z0-9-]+)(?=\s|$)", README, re.MULTILINE)
    for command, name in named:
        assert name in library.names(library.SCANS if command == "scan" else library.CASES), (command, name)
    assert {command for command, _ in named} == {"run", "check", "show", "scan", "continuum"}


def test_kinds_of_packings_and_laws():
    case = blocks("toml")[0]
    for key, names in (("kind", KINDS), ("law", LAWS)):
        (comment,) = re.findall(rf"^{key} = .*# (.*)$", case, re.MULTILINE)
        assert set(comment.split(" | ")) == set(names)


def test_values_of_a_summary():
    assert f"{outputs.TABLE_BEGINS}{outputs.quantity_table()}{outputs.TABLE_ENDS}" in README, outputs.RENEW
