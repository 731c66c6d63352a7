"""Captions of the figures of studies."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = (
    "composite_chains",
    "losses",
    "precompression",
    "square_packing",
    *(f"thesis/chapter_{n}" for n in (2, 3, 4, 5)),
)
SCRIPTS = [file for folder in FOLDERS for file in sorted((ROOT / "reproductions" / folder).glob("*.py"))]
SHORTEST, LONGEST = 100, 230  # characters; a title alone is shorter, two lines are no longer


def _captions(file):
    """Text of the captions that a script gives its figures, without what it puts into them."""
    functions = (node for node in ast.parse(file.read_text(encoding="utf-8")).body if isinstance(node, ast.FunctionDef))
    for function in (one for one in functions if one.name == "pictures"):
        texts = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                texts.setdefault(node.targets[0].id, []).append(node.value)
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "gw.Picture":
                given = node.args[1]
                for one in texts[given.id] if isinstance(given, ast.Name) else [given]:
                    yield "".join(str(part.value) for part in ast.walk(one) if isinstance(part, ast.Constant))


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.stem)
def test_captions_say_what_is_drawn_and_what_to_look_for_in_two_lines(file):
    """A caption is more than a title, and short enough to be read."""
    assert [text for text in _captions(file) if not SHORTEST <= len(text) <= LONGEST] == []
