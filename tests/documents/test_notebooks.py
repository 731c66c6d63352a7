"""Notebooks of the site: their code runs from the top, as `make docs` runs them with Jupyter, in seconds."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import PLAIN
from tests.documents.pages import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
IN_EVERY_TEST = "own-material-and-fields"
LONGEST = 60.0  # s, on a machine that does other things too; alone they take less than 10


def cells(notebook: Path) -> list[dict]:
    return json.loads(notebook.read_text(encoding="utf-8"))["cells"]


def run(notebook: Path, folder: Path) -> float:
    """Run the code of a notebook as a script, and return the time that it took, s."""
    code = ["".join(cell["source"]) for cell in cells(notebook) if cell["cell_type"] == "code"]
    (folder / "notebook.py").write_text("\n".join(code), encoding="utf-8")
    start = time.monotonic()
    done = subprocess.run(
        [sys.executable, "notebook.py"], cwd=folder, env=PLAIN | {"MPLBACKEND": "agg"}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return time.monotonic() - start


def test_notebooks_have_no_outputs():
    """Each begins with a title; outputs are made anew with the site."""
    assert len(NOTEBOOKS) >= 3 and IN_EVERY_TEST in [notebook.stem for notebook in NOTEBOOKS]
    for notebook in NOTEBOOKS:
        first, *rest = cells(notebook)
        assert first["cell_type"] == "markdown" and "".join(first["source"]).startswith("# ")
        assert not any(cell.get("outputs") or cell.get("execution_count") for cell in rest), notebook.name


def test_notebooks_are_on_the_page_on_python():
    page = (ROOT / "docs" / "howto" / "python.md").read_text(encoding="utf-8")
    assert all(f"(../notebooks/{notebook.name})" in page for notebook in NOTEBOOKS)


def test_fields_of_a_material(tmp_path):
    assert run(ROOT / "docs" / "notebooks" / f"{IN_EVERY_TEST}.ipynb", tmp_path) < LONGEST


@pytest.mark.validation
@pytest.mark.parametrize("notebook", [n for n in NOTEBOOKS if n.stem != IN_EVERY_TEST], ids=lambda n: n.stem)
def test_the_others(notebook, tmp_path):
    pytest.importorskip("IPython", reason="a notebook shows a picture with it; make docs installs it")
    assert run(notebook, tmp_path) < LONGEST
