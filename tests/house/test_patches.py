"""Things that are easy to add: each patch in `patches` adds one thing, in few files, to a copy of the
sources, and its tests pass there; contact laws that it changes are compiled there first.

The text above the changes says what the patch shows, and names its tests in lines ``Tests: FILE
FILE``. If a patch no longer applies, write it again: make the change by hand, ``git add -N .``, and
put ``git diff`` below that text.
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
PATCHES = Path(__file__).parent / "patches"
INSTALLED = Path(granwave.__file__).parent
SOURCES = ("analysis", "docs", "extensions", "lammps_inputs", "plugins", "tests", "workflows")
FILES = ("pyproject.toml", "CONTRIBUTING.md", "CHANGELOG.md", "README.md")
#: Most files that a patch may touch.
MOST_FILES = {
    "new_lattice": 3,
    "new_load": 6,
    "new_law_parameter": 8,
}
#: Sources of the contact laws for Python.
BINDING = (
    "bindings/arguments.cpp",
    "bindings/bound_contact.cpp",
    "bindings/bound_laws.cpp",
    "bindings/bound_mesh.cpp",
    "bindings/bound_shapes.cpp",
    "bindings/collision.cpp",
    "bindings/python_bindings.cpp",
    "laws/law_arguments.cpp",
    "kernels/stl_file.cpp",
    "kernels/triangle_mesh.cpp",
)
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
    for name in ("analysis", "extensions", "lammps_inputs", "workflows"):
        (package / name).symlink_to(folder / name)
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
    """Link the build products, such as the compiled plugin, from the installed package."""
    for folder in (Path(), Path("plugins")):
        for file in (INSTALLED / folder).iterdir():
            link = package / folder / file.name
            if file.is_file() and not link.exists():
                link.symlink_to(file.resolve())


def compile_laws(copy: Path) -> None:
    """Compile the contact laws for Python from the sources of a copy, into its package."""
    target = copy / "site" / "granwave" / Path(_contact_laws.__file__).name
    target.unlink()
    headers = (pybind11.get_include(), sysconfig.get_path("include"))
    includes = [f"-I{header}" for header in headers]
    release = f'-DGRANWAVE_LAMMPS_RELEASE="{_contact_laws.LAMMPS_RELEASE}"'
    sources = [str(copy / "plugins" / name) for name in BINDING]
    made = run(copy, "c++", *FLAGS, "-shared", *includes, release, *sources, "-o", str(target))
    assert made.returncode == 0, made.stderr[-5000:]


def patched_files(text: str) -> list[str]:
    """Files that a patch changes or adds."""
    return re.findall(r"^diff --git a/\S+ b/(\S+)$", text, re.MULTILINE)


def run(copy: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run a command in the copy, with its package in front."""
    environment = os.environ | {
        "PYTHONPATH": str(copy / "site"),
        "GIT_CEILING_DIRECTORIES": str(copy.parent),
    }
    return subprocess.run(
        words, cwd=copy, env=environment, capture_output=True, text=True, check=False
    )


def try_patch(path: Path, copy: Path) -> None:
    """Apply a patch to a copy of the sources, and run its tests there."""
    text = path.read_text(encoding="utf-8")
    files = patched_files(text)
    assert 0 < len(files) <= MOST_FILES[path.stem]
    applied = run(copy, "git", "apply", str(path))
    assert applied.returncode == 0, f"{path.name} fits no longer, see above: {applied.stderr}"
    where = run(copy, sys.executable, "-c", "import granwave.analysis as a; print(a.__path__)")
    assert str(copy) in where.stdout
    if any(name.startswith("plugins/") for name in files):
        compile_laws(copy)
    tests = " ".join(re.findall(r"^Tests: (.+)$", text, re.MULTILINE)).split()
    assert set(tests) & set(files), "a patch brings a test of its own"
    options = ("-q", "-p", "no:cacheprovider", "-p", "no:xdist")
    tested = run(copy, sys.executable, "-m", "pytest", *options, *tests)
    assert tested.returncode == 0, tested.stdout[-5000:] + tested.stderr[-2000:]


def test_every_patch_is_tried() -> None:
    """Each has a bound on its files, and a test of its own below."""
    assert {path.stem for path in PATCHES.glob("*.patch")} == set(MOST_FILES)
    assert all(f"test_a_{name}" in globals() for name in MOST_FILES)


@pytest.mark.parametrize("name", sorted(MOST_FILES))
def test_each_patch_fits(name: str) -> None:
    """A change of a line in the context of a patch is detected immediately."""
    checked = subprocess.run(
        ["git", "apply", "--check", str(PATCHES / f"{name}.patch")],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 0, checked.stderr


@pytest.mark.validation
def test_a_new_lattice(copy: Path) -> None:
    try_patch(PATCHES / "new_lattice.patch", copy)


@pytest.mark.validation
def test_a_new_load(copy: Path) -> None:
    try_patch(PATCHES / "new_load.patch", copy)


@pytest.mark.validation
def test_a_new_law_parameter(copy: Path) -> None:
    try_patch(PATCHES / "new_law_parameter.patch", copy)
