"""Captions of the figures of studies."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "reproductions").rglob("*.py"))
SHORTEST = 80  # characters; a title alone is shorter


def _text(node):
    return "".join(str(part.value) for part in ast.walk(node) if isinstance(part, ast.Constant))


def _captions(file):
    """Longest text of the caption of each figure of a script, without the numbers that it puts into it."""
    for function in ast.parse(file.read_text(encoding="utf-8")).body:
        texts = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                texts.setdefault(node.targets[0].id, []).append(_text(node.value))
        for node in ast.walk(function):
            if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name) and node.target.id in texts:
                texts[node.target.id] = [text + _text(node.value) for text in texts[node.target.id]]
        for node in ast.walk(function):
            if isinstance(node, ast.Call) and ast.unparse(node.func) == "gw.Picture":
                names = {part.id for part in ast.walk(node.args[1]) if isinstance(part, ast.Name)} & set(texts)
                yield _text(node.args[1]) + "".join(max(texts[name], key=len) for name in names)


@pytest.mark.parametrize("file", SCRIPTS, ids=lambda file: file.stem)
def test_captions_say_what_is_drawn_and_what_to_look_for(file):
    """A caption is more than a title."""
    assert [text for text in _captions(file) if len(text) < SHORTEST] == []
