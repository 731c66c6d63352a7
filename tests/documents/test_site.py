"""The pages as a reader goes through them: all their commands in order, and the scripts of the gallery."""

from __future__ import annotations

import ast
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import BIN, PLAIN
from tests.documents.pages import ROOT, blocks, name_of, pages, write_files

RUN = [page for page in pages() if any(block.language == "shell" for block in blocks(page))]


def test_pages_to_run_are_found():
    assert {"README.md", "docs/start.md", "docs/howto/questions.md"} <= set(map(name_of, RUN))


@pytest.mark.validation
@pytest.mark.parametrize("page", RUN, ids=name_of)
def test_commands_run(page, tmp_path):
    """Commands in blocks of ``shell`` run one after the other, and print the lines that the page shows."""
    write_files(page, tmp_path)
    environment = PLAIN | {"PATH": f"{BIN}:{PLAIN['PATH']}"}
    printed = ""
    for block in blocks(page):
        if block.language == "shell":
            done = subprocess.run(
                ["bash", "-euc", block.text], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=900
            )
            assert done.returncode == 0, f"{block.text}{done.stderr}"
            printed = done.stdout
        elif block.output:
            for line in filter(None, block.text.splitlines()):
                assert line in printed, f"{name_of(page)} shows a line that is not printed: {line}"


def gallery():
    """Module that runs the gallery."""
    specification = importlib.util.spec_from_file_location("studies", ROOT / "docs" / "_ext" / "studies.py")
    module = importlib.util.module_from_spec(specification)
    sys.modules["studies"] = module
    specification.loader.exec_module(module)
    return module


def test_every_script_of_the_gallery_has_a_title_and_a_text():
    studies = gallery()
    assert len(studies.scripts()) >= 10
    for script in studies.scripts():
        title, text, code = studies.parts_of(script)
        assert title and not title.endswith(".") and text and "picture.png" in code, script.name


def test_scripts_of_the_gallery_import_the_public_door_alone():
    for script in gallery().scripts():
        for node in ast.walk(ast.parse(script.read_text(encoding="utf-8"))):
            names = [one.name for one in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [name for name in names if name.startswith("granwave.")], script.name


@pytest.mark.validation
def test_every_script_of_the_gallery_takes_less_than_a_minute(tmp_path, monkeypatch):
    studies = gallery()
    monkeypatch.setattr(studies, "RUNS", Path(tmp_path))
    for script in studies.scripts():
        assert studies.run(script, "") < studies.LONGEST, script.name
