"""A parameter of a law is easy to add: a patch does so in few files, in a copy of the sources
whose binding is compiled there, and its tests pass.

A patch that fits no longer is made anew: make the change by hand, ``git add -N .``, and put
``git diff`` below the text at its top.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterable
from pathlib import Path

import pybind11
import pytest

import granwave
from granwave import _contact_laws

ROOT = Path(__file__).parents[2]
PATCH = Path(__file__).parent / "patches" / "new_law_parameter.patch"
INSTALLED = Path(granwave.__file__).parent
SOURCES = ("analysis", "docs", "lammps_inputs", "plugins", "tests", "workflows")
FILES = ("pyproject.toml", "CONTRIBUTING.md", "CHANGELOG.md", "README.md")
MOST_FILES = 5
BINDING = ("bindings/python_bindings.cpp", "laws/law_arguments.cpp")
FLAGS = ("-std=c++17", "-O1", "-fPIC", "-fvisibility=hidden", "-ffp-contract=off")


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """Copy of the sources, with the package as links to it in the folder ``site``."""
    folder = tmp_path / "copy"
    leave_out = shutil.ignore_patterns("__pycache__", "*.so")
    for name in SOURCES:
        shutil.copytree(ROOT / name, folder / name, ignore=leave_out)
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    package = folder / "site" / "granwave"
    package.mkdir(parents=True)
    link_all(package, (folder / name for name in ("analysis", "lammps_inputs", "workflows")))
    link_all(package, (folder / "workflows" / "package").glob("*.py"))
    (package / "plugins").mkdir()
    link_all(package / "plugins", (folder / "plugins").iterdir())
    link_built(package)
    return folder


def link_all(folder: Path, files: Iterable[Path]) -> None:
    """Link files and folders into a folder."""
    for file in files:
        (folder / file.name).symlink_to(file)


def link_built(package: Path) -> None:
    """Link what the build made, such as the compiled plugin, from the installed package."""
    for folder in (Path(), Path("plugins")):
        for file in (INSTALLED / folder).iterdir():
            link = package / folder / file.name
            if file.is_file() and not link.exists():
                link.symlink_to(file.resolve())


def compile_binding(copy: Path) -> None:
    """Compile the contact laws for Python from the sources of a copy, into its package."""
    target = copy / "site" / "granwave" / Path(_contact_laws.__file__).name
    target.unlink()
    headers = (pybind11.get_include(), sysconfig.get_path("include"))
    objects = []
    for name in BINDING:
        made = copy / Path(name).with_suffix(".o").name
        source = copy / "plugins" / name
        release = f'-DGRANWAVE_LAMMPS_RELEASE="{_contact_laws.LAMMPS_RELEASE}"'
        includes = [f"-I{header}" for header in headers]
        run(copy, "c++", *FLAGS, *includes, release, "-c", str(source), "-o", str(made))
        objects.append(str(made))
    run(copy, "c++", "-shared", *objects, "-o", str(target))


def run(copy: Path, *words: str) -> None:
    """Run a command in the copy, with its package in front; it must succeed."""
    environment = os.environ | {
        "PYTHONPATH": str(copy / "site"),
        "GIT_CEILING_DIRECTORIES": str(copy.parent),
    }
    done = subprocess.run(words, cwd=copy, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def patched_files(text: str) -> list[str]:
    """Files that a patch changes or adds."""
    return re.findall(r"^diff --git a/\S+ b/(\S+)$", text, re.MULTILINE)


def test_a_parameter_of_a_law_is_few_files(copy: Path) -> None:
    text = PATCH.read_text(encoding="utf-8")
    files = patched_files(text)
    assert len(files) <= MOST_FILES
    python = [name for name in files if name.endswith(".py")]
    assert all(name.startswith("tests/") for name in python)
    run(copy, "git", "apply", str(PATCH))
    compile_binding(copy)
    (tests,) = re.findall(r"^Tests: (.*)$", text, re.MULTILINE)
    run(copy, sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *tests.split())
