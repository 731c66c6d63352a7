"""An extension from outside adds a lattice, a load, a value, a figure and a command.

The page "Write an extension" shows its sources. They are installed into a separate folder in the
form of a package installed by pip: the modules, and a dist-info with the entry point.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.xdist_group("toy")  # its fixtures are made once

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
PAGE = ROOT / "docs" / "howto" / "own-extension.md"
#: Another extension, with one field.
OTHER = """
from granwave.lammps_inputs.extensions import Extension

extension = Extension(name="other", title="another extension", {})
"""
WITHOUT = "GRANWAVE_WITHOUT"
Granwave = Callable[..., subprocess.CompletedProcess]


def install(site: Path, name: str, folder: Path = HERE / "toy") -> None:
    """Install the package of a folder under a name, for Python processes with ``site`` in
    PYTHONPATH.
    """
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    shutil.copytree(folder, site / name, ignore=shutil.ignore_patterns("__pycache__"))
    information = site / f"{name}-{project['version']}.dist-info"
    information.mkdir()
    metadata = f"Metadata-Version: 2.1\nName: {name}\nVersion: {project['version']}\n"
    (information / "METADATA").write_text(metadata, encoding="utf-8")
    lines = ["[granwave.extensions]", f"{name} = {name}:extension"]
    (information / "entry_points.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.fixture(scope="module")
def granwave(tmp_path_factory: pytest.TempPathFactory) -> Granwave:
    """Function that runs a command of granwave with the toy extension installed."""
    site = tmp_path_factory.mktemp("site")
    install(site, "toy")
    return runner(site)


def runner(site: Path) -> Granwave:
    """Return the function that runs a command of granwave with packages of a folder."""

    def run(*words: object, cwd: Path, without: str = "") -> subprocess.CompletedProcess:
        command = [sys.executable, "-m", "granwave.workflows", *map(str, words)]
        environment = os.environ | {"PYTHONPATH": str(site), WITHOUT: without}
        return subprocess.run(
            command, cwd=cwd, env=environment, capture_output=True, text=True, check=False
        )

    return run


def output(done: subprocess.CompletedProcess) -> str:
    """Return the output of a command, which must have succeeded."""
    assert done.returncode == 0, done.stdout + done.stderr
    return str(done.stdout)


@pytest.fixture(scope="module")
def folder(granwave: Granwave, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a case of the toy's lattice and load, and its run ``out``."""
    folder = tmp_path_factory.mktemp("toy")
    shutil.copy(HERE / "case.toml", folder)
    output(granwave("run", "case.toml", "-o", "out", cwd=folder))
    return folder


def test_the_page_has_all_files():
    """Each file is included, and no line of a file that is shown in parts is missing."""
    text = PAGE.read_text(encoding="utf-8")
    for path in (HERE / "pyproject.toml", HERE / "case.toml", *(HERE / "toy").glob("*.py")):
        assert f"../../{path.relative_to(ROOT)}\n" in text, path.name
    parts = re.findall(r"^:(?:start-at|end-before): (.*)$", text, re.MULTILINE)
    functions = ["def ranked_forces", "def participation"]
    assert parts == [functions[0], *functions, functions[1]]


def test_the_project_has_the_entry_point():
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"] == {"granwave.extensions": {"toy": "toy:extension"}}


def test_lattice_and_load(granwave, folder):
    """Eight contacts inside, and the velocity sqrt(2 g h), in plan and run."""
    plan = json.loads(output(granwave("check", "case.toml", "--json", cwd=folder)))
    assert plan["n_spheres"] == 75
    mass = 7850 * math.pi / 6 * 0.01**3
    assert plan["energy_input_J"] == pytest.approx(mass * 9.80665 * 0.2, rel=1e-3)
    summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))
    assert summary["energy_input_J"] == pytest.approx(plan["energy_input_J"], rel=1e-9)
    in_layers = 3 * (5 * 4 + 4 * (2 * 5 - 1))
    assert summary["n_contacts"] == in_layers + 2 * 25


def test_value_and_figure(folder):
    summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))
    force = [float(row.split(",")[1]) for row in rows(folder / "out/figures/ranked_forces.csv")]
    share = sum(force) ** 2 / (len(force) * sum(one**2 for one in force))
    assert summary["force_participation"] == pytest.approx(share, rel=1e-6)
    assert force == sorted(force, reverse=True)
    assert (folder / "out/figures/ranked_forces.png").is_file()


def rows(path: Path) -> list[str]:
    """Return the rows of a table below its head."""
    return path.read_text(encoding="utf-8").splitlines()[1:]


def test_figures_are_drawn_again_and_reported(granwave, folder):
    (folder / "out/figures/ranked_forces.png").unlink()
    output(granwave("figures", "out", "--only", "ranked_forces", cwd=folder))
    assert (folder / "out/figures/ranked_forces.png").is_file()
    output(granwave("report", "out", "-o", "report.md", cwd=folder))
    text = (folder / "report.md").read_text(encoding="utf-8")
    assert "The flatter the curve" in text


def test_keys(granwave, folder):
    assert '"simple-hexagonal"' in output(granwave("keys", "packing.kind", cwd=folder))
    assert "height from which" in output(granwave("keys", "load.height", cwd=folder))


def test_command(granwave, folder):
    assert "participation of the contacts" in output(granwave("--help", cwd=folder))
    assert "DIR" in output(granwave("participation", "--help", cwd=folder))
    summary = json.loads((folder / "out" / "summary.json").read_text(encoding="utf-8"))
    value = float(output(granwave("participation", "out", cwd=folder)))
    assert value == summary["force_participation"] == pytest.approx(0.00903086, rel=1e-4)


def test_without_it_the_case_is_wrong_and_the_rest_works(granwave, folder):
    done = granwave("check", "case.toml", cwd=folder, without="toy")
    assert done.returncode == 2
    assert 'packing.kind: found "simple-hexagonal", expected one of "fcc"' in done.stderr
    assert output(granwave("check", "fcc-small", cwd=folder, without="toy"))


@pytest.mark.parametrize(
    ("field", "message"),
    [
        ('loads="toy.loads:LOADS"',
         "load.kind fall: both the extension other and the extension toy"),
        ('figures={"energies": "toy.results:RANKED_FORCES"}',
         "figure energies: both granwave itself and the extension other"),
        ('summary="toy.results:summary_values", quantities="toy.results:QUANTITIES"',
         "value of summary.json force_participation: both the extension other and"),
        ('lattices="missing_module:LATTICES"',
         "extension other: lattices missing_module:LATTICES cannot be loaded: No module named"),
    ],
)  # fmt: skip
def test_clashes_and_faults_name_the_extension(tmp_path, field, message):
    """A single message before anything is run; it explains how to disable the extension."""
    site = tmp_path / "site"
    install(site, "toy")
    other = tmp_path / "other"
    other.mkdir()
    (other / "__init__.py").write_text(OTHER.format(field), encoding="utf-8")
    install(site, "other", other)
    shutil.copy(HERE / "case.toml", tmp_path)
    done = runner(site)("run", "case.toml", cwd=tmp_path)
    assert done.returncode == 2 and not (tmp_path / "case").exists(), done.stderr
    assert message in done.stderr
    assert re.search(rf"hide the extension with {WITHOUT}=(other|toy)", done.stderr)
    assert "Traceback" not in done.stderr
