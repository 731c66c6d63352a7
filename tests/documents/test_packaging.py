"""Recipes for conda, Spack and containers in docs/packaging: they have the requirements and the
version of the package.
"""

from __future__ import annotations

import ast
import itertools
import re
import tomllib

import pytest
from packaging.requirements import Requirement

from granwave.lammps_inputs.extensions import extensions
from tests.documents.pages import ROOT

yaml = pytest.importorskip("yaml")
PACKAGING = ROOT / "docs" / "packaging"
TABLES = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = TABLES["project"]
NEEDED = [one for text in PROJECT["dependencies"] if (one := Requirement(text)).name != "lammps"]
EXTRAS = PROJECT["optional-dependencies"]
(OF_ALL,) = map(Requirement, EXTRAS["all"])
OF_FEATURES = {str(Requirement(text)) for text in itertools.chain(*map(EXTRAS.get, OF_ALL.extras))}
TO_BUILD = [one for text in TABLES["build-system"]["requires"] if (one := Requirement(text)).name not in ("lammps", "mpich")]  # fmt: skip
OF_CONDA = {"matplotlib": "matplotlib-base"}


def least(requirement: Requirement) -> str:
    (version,) = [one.version for one in requirement.specifier if one.operator == ">="]
    return version


def test_requirements_of_a_site():
    lines = (PACKAGING / "requirements-site.txt").read_text(encoding="utf-8").splitlines()
    found = {str(one) for line in lines if not line.startswith("#") for one in [Requirement(line)]}
    needed = {str(one) for one in (*NEEDED, *TO_BUILD)} | OF_FEATURES
    assert needed <= found
    assert len(found) == len(needed) + 2  # CMake and ninja
    assert not [name for name in found if name.startswith(("lammps", "mpich"))]


def test_conda():
    recipe = yaml.safe_load((PACKAGING / "recipe.yaml").read_text(encoding="utf-8"))
    assert (
        recipe["context"]["version"] == PROJECT["version"]
        and recipe["about"]["license"] == PROJECT["license"]
    )
    found = dict(line.split(" ", 1) for line in recipe["requirements"]["run"] if " " in line)
    for one in NEEDED:
        name = OF_CONDA.get(one.name, one.name.lower())
        assert found.pop(name).split(",")[0] == f">={least(one)}", name
    assert set(found) == {"lammps"}
    least_python = PROJECT["requires-python"].removeprefix(">=")
    assert f'match(python, "<{least_python}")' in recipe["build"]["skip"]
    host = dict(line.split(" ", 1) for line in recipe["requirements"]["host"] if " " in line)
    assert all(host[one.name] == f">={least(one)}" for one in TO_BUILD)
    pinned = next(
        text.partition("==")[2] for text in PROJECT["dependencies"] if text.startswith("lammps")
    )
    year, month, day = map(int, pinned.split(".")[:3])
    assert recipe["context"]["lammps"] == f"{year}.{month:02}.{day:02}"


def test_spack():
    text = (PACKAGING / "spack" / "package.py").read_text(encoding="utf-8")
    (package,) = [one for one in ast.parse(text).body if isinstance(one, ast.ClassDef)]
    assert package.name == "PyGranwave"
    assert f'version("{PROJECT["version"]}")' in text and f'license("{PROJECT["license"]}")' in text
    found = dict(re.findall(r'depends_on\("py-([\w-]+)@([\d.]+):', text))
    assert found == {one.name.lower(): least(one) for one in (*NEEDED, *TO_BUILD)}


def test_containers_prove_themselves():
    for name in ("Dockerfile", "apptainer.def"):
        text = (PACKAGING / name).read_text(encoding="utf-8")
        assert "granwave selftest" in text
        assert "[all]'" in text


def test_extras_are_those_of_the_extensions():
    """Every package that an extension names is in its extra, and `all` has all extras."""
    for extension in extensions():
        in_extra = {Requirement(text).name for text in EXTRAS.get(extension.extra, ())}
        assert set(extension.packages.values()) == in_extra, extension.name
    features = {extension.extra for extension in extensions()} - {""}
    assert {*features, "pdf", "export"} == OF_ALL.extras
    assert "granwave[all]" in EXTRAS["test"]
