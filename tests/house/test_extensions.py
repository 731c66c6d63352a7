"""The core imports and names no extension, and works if any or all of them are hidden."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from granwave.lammps_inputs.extensions import ALL, WITHOUT, added, extensions
from tests.helpers.hidden import FOLDER, NAMES
from tests.house.test_layers import CORE, FACE_FOR_TYPES, MODULES, imports

ROOT = Path(__file__).parents[2]
SMALL = (
    "packing.size=[3,3,3]", "run.frames=3", "run.end_time=2e-5", "figures.formats=[]",
)  # fmt: skip
#: Keys of [figures], a quantity of driven rows, a part of a study, and a field of `Extension`.
ALSO_OF_THE_CORE = {"film", "view", "transmission", "pictures", "packings"}
#: Tests of the core that are run where all extensions are hidden; those in `hostile` name commands of extensions.
ROOMS = ("lammps_inputs", "analysis", "workflows", "plugins/laws", "plugins/pair")


def without(names: str, *words: object, cwd: Path | None = None) -> subprocess.CompletedProcess:
    """Run granwave with these extensions hidden."""
    environment = os.environ | {WITHOUT: names, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "tests.helpers.hidden", *map(str, words)]
    return subprocess.run(
        command, cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )


def output(done: subprocess.CompletedProcess) -> str:
    """Return the output of a command, which must have succeeded."""
    assert done.returncode == 0, done.stdout + done.stderr
    return str(done.stdout)


def test_every_folder_is_an_extension():
    """Each extension has tests and pages, and is found by its entry point."""
    assert tuple(sorted(one.name for one in extensions() if (FOLDER / one.name).is_dir())) == NAMES
    for name in NAMES:
        assert list((ROOT / "tests" / "extensions" / name).glob("test_*.py")), name
        assert list((ROOT / "docs" / "extensions" / name).glob("*.md")), name


@pytest.mark.parametrize("name", NAMES)
def test_extensions_import_only_those_that_they_use(name):
    (extension,) = [one for one in extensions() if one.name == name]
    own = [module for module in MODULES if module.startswith(f"granwave.extensions.{name}")]
    others = {
        other.split(".")[2]
        for module in own
        for other in imports(module)
        if other.startswith("granwave.extensions.")
    }
    assert others - {name} <= set(extension.uses)


def test_the_core_says_no_name_of_an_extension():
    """No text in the code of the core is the name of an extension or of one of its commands."""
    words = {*NAMES, *(command.name for commands in added("commands") for command in commands)}
    words -= ALSO_OF_THE_CORE
    found = []
    for module in set(CORE) - {FACE_FOR_TYPES}:
        tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
        found += [
            f"{module}:{node.lineno}: {node.value}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and node.value in words
        ]
    assert found == [], "\n".join(found)


@pytest.mark.parametrize("name", [*NAMES, ALL])
def test_the_core_works_without(name, tmp_path):
    """Help, keys, built-in cases and a plan; with all hidden a run, its report and figures too."""
    names = NAMES if name == ALL else (name,)
    commands = [
        command
        for extension in extensions()
        if extension.name in names and extension.commands
        for command in _commands_of(extension)
    ]
    listed = output(without(name, "--help"))
    assert [one.name for one in commands if f"\n  {one.name} " in listed] == []
    assert "\n  run " in listed
    if name != ALL:
        return
    assert "[packing]" in output(without(name, "keys", "packing"))
    assert "fcc-small" in output(without(name, "cases", "--all"))
    plan = json.loads(output(without(name, "check", "fcc-small", "--json")))
    assert plan["n_spheres"] == 24 * 24 * 12
    sets = [word for key in SMALL for word in ("--set", key)]
    output(without(name, "run", "fcc-small", *sets, "-o", "small", cwd=tmp_path))
    output(without(name, "report", "small", cwd=tmp_path))
    assert (tmp_path / "report.html").stat().st_size > 10_000
    assert (tmp_path / "small" / "figures" / "energies.png").is_file()
    output(without(name, "export", "small", "--to", "csv", cwd=tmp_path))


def _commands_of(extension):
    from granwave.lammps_inputs.extensions import load

    return load(extension.commands)


@pytest.mark.validation
@pytest.mark.parametrize("name", [ALL, *NAMES])
def test_the_tests_of_the_core_pass_without(name):
    """All tests of the core if all extensions are hidden; the tests of the interfaces if one is."""
    rooms = ROOMS if name == ALL else ("workflows/cli", "analysis/reports", "analysis/notebook")
    command = [sys.executable, "-m", "pytest", "-n", "2", "-p", "tests.helpers.hidden", "-q"]
    command += ["-p", "no:cacheprovider", *(f"tests/{room}" for room in rooms)]
    environment = os.environ | {WITHOUT: name}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-5000:]
