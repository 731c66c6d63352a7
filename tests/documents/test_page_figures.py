"""Figures of the pages: each is drawn by the present script, and shown on a page."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from tests.documents.pages import ROOT, pages

SHOWN = re.compile(r"(?:\]\(|\{image\} |\{figure\} )([\w./-]+\.(?:webp|png|svg))")
#: Tutorials and how-tos that speak of no figure: installation, commands and files.
WITHOUT_PICTURE = {
    "cite",
    "index",
    "install",
    "lammps-package",
    "other-programs",
    "own-lammps",
    "stop-and-resume",
}


@pytest.fixture(scope="module")
def figures() -> ModuleType:
    """Return the module that draws the figures, which belongs to no package."""
    path = ROOT / "docs" / "_ext" / "page_figures.py"
    spec = importlib.util.spec_from_file_location("page_figures", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def shown_pictures() -> set[Path]:
    """Return the pictures that are shown on some page."""
    shown = set()
    for page in pages():
        for name in SHOWN.findall(page.read_text(encoding="utf-8")):
            shown.add((page.parent / name).resolve())
    return shown


def test_figures_are_those_of_their_scripts(figures):
    digests = figures.stored_digests()
    stale = [page for page in figures.names() if digests.get(page) != figures.digest(page)]
    assert not stale, (
        f"earlier figures: run .venv/bin/python docs/_ext/page_figures.py {' '.join(stale)}"
    )
    assert set(digests) == set(figures.names())


def test_every_figure_has_a_script_and_a_page(figures):
    shown = shown_pictures()
    missing = [path for path in shown if not path.exists()]
    assert not missing
    for picture in figures.FOLDER.glob("*/*/*"):
        assert picture.parent.with_suffix(".py") == figures.scripts()[picture.parent.name]
        assert picture in shown, f"no page shows {picture.relative_to(ROOT)}"


@pytest.mark.parametrize("folder", ["tutorials", "howto"])
def test_tutorials_and_recipes_show_pictures(folder):
    for page in (ROOT / "docs" / folder).glob("*.md"):
        shown = SHOWN.findall(page.read_text(encoding="utf-8"))
        assert bool(shown) != (page.stem in WITHOUT_PICTURE), page.stem
