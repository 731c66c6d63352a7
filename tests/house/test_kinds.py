"""A kind is a class: no code outside compares its name; the number of exceptions only decreases."""

from __future__ import annotations

import ast

import pytest

from tests.house import kinds

UPDATE = "run: python -m tests.house.kinds"
pytestmark = pytest.mark.xdist_group("kinds")  # the files are read once


def test_no_file_asks_for_kinds_more_often() -> None:
    allowed = kinds.exceptions()
    worse = {
        path: numbers
        for path, numbers in kinds.lines().items()
        if len(numbers) > allowed.get(path, 0)
    }
    assert worse == {}, "lines that compare a kind: give its class a flag or a method"


def test_the_list_of_kinds_has_become_shorter() -> None:
    present = kinds.lines()
    stale = {
        path: count
        for path, count in kinds.exceptions().items()
        if len(present.get(path, ())) < count
    }
    assert stale == {}, f"the list allows more than there is; {UPDATE}"


@pytest.mark.parametrize(
    "text",
    [
        "case.packing.kind == 'chain'",
        "self._lattice.kind != 'chain'",
        "load.kind in ('force', 'plate')",
        "stage.kind == GRAVITY",
        "case.boundary.bottom == 'fixed'",
        "run.case.get('packing.kind') == 'chain'",
        "tables['packing']['kind'] == 'chain'",
        "tables.get('boundary', {}).get('sides') != 'periodic'",
        "{'gravity': 1}.get(stage.kind)",
        "{'gravity': 1}[stage.kind]",
    ],
)
def test_comparisons_of_kinds_are_seen(text: str) -> None:
    assert list(kinds.comparisons(ast.parse(text))) == [1]


def test_a_variable_that_holds_a_kind_is_seen() -> None:
    tree = ast.parse("kind = case.load.kind\nif kind == 'plate':\n    pass\n")
    assert list(kinds.comparisons(tree)) == [2]


@pytest.mark.parametrize(
    "text",
    [
        "row.kind == 'source'",
        "values.dtype.kind == 'O'",
        "case.packing.rule.is_chain",
        "case.load.kind == other.load.kind",
        "run.kind == 'run'",
    ],
)
def test_other_comparisons_are_none(text: str) -> None:
    assert list(kinds.comparisons(ast.parse(text))) == []
