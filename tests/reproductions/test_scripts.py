"""Scripts of the reproductions: they use only the public Python interface, are short, and are named
by a scan or suite next to them; captions of their figures.
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

import pytest

from granwave.analysis.studies.registry import load_study
from granwave.workflows import load_scan
from granwave.workflows.scanning.suite import is_suite, load_suite

FOLDER = Path(__file__).parents[2] / "reproductions"
SCRIPTS = sorted(FOLDER.rglob("*.py"))
FILES = sorted(FOLDER.rglob("*.toml"))
STUDIES = [path for path in SCRIPTS if "\ndef rows(" in path.read_text(encoding="utf-8")]
SUITES = [path for path in FILES if is_suite(path)]
#: Scans that a suite loads with the others of it.
OF_SUITES: set[Path] = set()
for suite in SUITES:
    scans = tomllib.loads(suite.read_text(encoding="utf-8"))["scans"]
    OF_SUITES |= {(suite.parent / name).resolve() for name in scans}
#: Hundreds of points: validations.
MANY_POINTS = {"thesis/chapter_7/suite.toml", "square_packing/sensors.toml"}
DOORS = {"granwave", "granwave.measures", "granwave.theory"}


def name_of(path: Path) -> str:
    """Name of a file in the list of tests."""
    return str(path.relative_to(FOLDER))


@pytest.mark.parametrize("path", SCRIPTS, ids=name_of)
def test_imports(path: Path) -> None:
    """Scripts import only public modules of the package."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0
            names = [node.module or ""]
        for name in names:
            assert name in DOORS if name.startswith("granwave") else True, (
                f"{path.name} imports {name}"
            )


@pytest.mark.parametrize("path", STUDIES, ids=name_of)
def test_title_and_text(path: Path) -> None:
    study = load_study(str(path))
    assert (study.TITLE and study.TEXT) or hasattr(study, "text")


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=[pytest.mark.validation] if name_of(path) in MANY_POINTS else [])
        for path in FILES
    ],
    ids=name_of,
)
def test_files_are_right(path: Path) -> None:
    """Every scan and suite can be run, a scan with its suite; its first line describes it."""
    assert path.read_text(encoding="utf-8").startswith("# ")
    if path in SUITES:
        assert load_suite(path).scans
    elif path.resolve() not in OF_SUITES:
        assert load_scan(path).points


def test_every_study_is_made() -> None:
    """Every script is named by a scan or a suite of its folder."""
    named = set()
    for path in FILES:
        study = tomllib.loads(path.read_text(encoding="utf-8")).get("study", [])
        names = [study] if isinstance(study, str) else study
        named |= {(path.parent / name).resolve() for name in names if name.endswith(".py")}
    assert {path.resolve() for path in STUDIES} <= named


SHORTEST = 80  # characters; a title alone is shorter


def _text(node):
    return "".join(str(part.value) for part in ast.walk(node) if isinstance(part, ast.Constant))


def _captions(file):
    """Longest text of the caption of each figure of a script, without inserted numbers."""
    for function in ast.parse(file.read_text(encoding="utf-8")).body:
        texts = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                texts.setdefault(node.targets[0].id, []).append(_text(node.value))
        for node in ast.walk(function):
            if (
                isinstance(node, ast.AugAssign)
                and isinstance(node.target, ast.Name)
                and node.target.id in texts
            ):
                texts[node.target.id] = [text + _text(node.value) for text in texts[node.target.id]]
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "gw.Picture":
                names = {
                    part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)
                } & set(texts)
                yield _text(node.args[1]) + "".join(max(texts[name], key=len) for name in names)


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.stem)
def test_captions_say_what_is_drawn_and_what_to_look_for(file):
    """A caption is more than a title."""
    assert [text for text in _captions(file) if len(text) < SHORTEST] == []
