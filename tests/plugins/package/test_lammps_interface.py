"""Comparison of the LAMMPS interfaces that the styles use with the headers of another version."""

from __future__ import annotations

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.documents.pages import ROOT

SCRIPT = ROOT / "plugins" / "package" / "lammps_interface.py"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("lammps_interface", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def headers(script, tmp_path) -> Path:
    """Return a copy of the headers with which the plugin is built."""
    return Path(shutil.copytree(script.own_headers(), tmp_path / "headers"))


def replace(path: Path, before: str, after: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert text.count(before) == 1
    path.write_text(text.replace(before, after), encoding="utf-8")


def differences(script, headers: Path) -> dict[str, str]:
    """Return the states of the interfaces that differ, by their names."""
    rows = script.compare(script.own_headers(), headers)
    return {f"{row.use.scope}::{row.use.name}": row.state for row in rows if row.state != "same"}


def test_the_same_headers_have_the_same_interfaces(script, headers):
    assert differences(script, headers) == {}


def test_functions_that_the_styles_override_are_among_those_compared(script):
    """The pair style's header names them: all are interfaces of Pair that are compared."""
    text = (ROOT / "plugins" / "styles" / "pair_gran_hysteretic.h").read_text(encoding="utf-8")
    overridden = set(re.findall(r"(\w+)\([^;{}]*\)\s*(?:const\s*)?override", text))
    compared = {use.name for use in script.uses(script.own_headers()) if use.scope == "Pair"}
    assert len(overridden) > 10 and overridden - {"PairGranHysteretic"} <= compared


def test_changes_of_another_lammps_are_found(script, headers):
    """A missing function, other arguments, another type of a number, a missing header."""
    replace(headers / "modify.h", "  Fix *get_fix_by_id(const std::string &) const;\n", "")
    replace(headers / "pair.h", "virtual double init_one(int, int)", "virtual double init_one(int)")
    replace(headers / "neighbor.h", "double skin;", "float skin;")
    (headers / "timer.h").unlink()
    found = differences(script, headers)
    timer = {name: found.pop(name) for name in list(found) if name.startswith("Timer::")}
    assert set(timer.values()) == {"header not found"}
    assert found == {
        "Modify::get_fix_by_id": "missing",
        "Pair::init_one": "changed",
        "Neighbor::skin": "changed",
    }


def test_names_of_parameters_and_comments_are_no_changes(script, headers):
    replace(
        headers / "pair.h",
        "virtual double init_one(int, int)",
        "virtual double init_one(int itype,\n    int jtype /* types */)",
    )
    assert differences(script, headers) == {}


def test_what_the_command_prints(headers):
    """The table, the declarations that differ, and the exit status."""
    replace(headers / "pair.h", "virtual double init_one(int, int)", "virtual double init_one(int)")
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(headers)], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 1, done.stderr
    assert re.search(r"\| `pair\.h` \| \d+ \| \d+ \| 1 \| 0 \|", done.stdout)
    assert "other  virtual double init_one(int)" in done.stdout


def test_a_folder_without_headers_is_rejected(tmp_path):
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path)], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2 and "expected the folder with pair.h" in done.stderr
