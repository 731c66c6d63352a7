"""Lines follow the rules; the list of exceptions only becomes shorter."""

from __future__ import annotations

import ast

import pytest

from tests.house import rules

UPDATE = "run: python -m tests.house.rules"
EXCEPTIONS = rules.exceptions()
pytestmark = pytest.mark.xdist_group("rules")  # the files are read once


@pytest.mark.parametrize("rule", [*rules.RULES, rules.LONG_LINES])
def test_no_file_breaks_a_rule_more_often(rule: str) -> None:
    allowed = EXCEPTIONS[rule]
    counts = rules.counts()[rule]
    worse = {
        path: rules.violations(rules.ROOT / path)[rule]
        for path, count in counts.items()
        if count > allowed.get(path, 0)
    }
    assert worse == {}, f"{rule}: lines that break the rule, in files that have more of them"


@pytest.mark.parametrize("rule", [*rules.RULES, rules.LONG_LINES])
def test_the_list_has_become_shorter(rule: str) -> None:
    counts = rules.counts()[rule]
    stale = {path: count for path, count in EXCEPTIONS[rule].items() if counts.get(path, 0) < count}
    assert stale == {}, f"{rule}: the list allows more than there is; {UPDATE}"


def test_complex_functions_are_listed_by_name() -> None:
    present = {f"{p}:{name}" for p, names in rules.complex_functions().items() for name in names}
    listed = set(EXCEPTIONS["accepted"])
    for path, names in EXCEPTIONS["complex_functions"].items():
        listed.update(f"{path}:{name}" for name in names)
    assert sorted(present - listed) == [], "take these apart"
    assert sorted(listed - present) == [], f"these are simple now; {UPDATE}"


def test_accepted_exceptions_have_a_reason() -> None:
    assert [name for name, reason in EXCEPTIONS["accepted"].items() if len(reason) < 20] == []


def test_names_of_classes_are_unique() -> None:
    several = {name: len(paths) for name, paths in rules.public_classes().items() if len(paths) > 1}
    assert several == EXCEPTIONS["classes"], UPDATE


@pytest.mark.parametrize(
    ("rule", "bad", "good"),
    [
        ("tuple_assignments", "a, b = 1, 2", "a, b = b, a"),
        ("tuple_assignments", "self.a, b = f(x), y", "a, b = pair"),
        ("products_with_truth", "'s' * (n > 1)", "'s' * n"),
        ("products_with_truth", "[x] * (not y)", "3 * (x > 1)"),
        ("nested_comprehensions", "[a for b in c for a in b]", "[a for a in b]"),
        ("nested_comprehensions", "[sum(d for d in a) for a in b]", "[sum(a) for a in b]"),
        ("long_conditionals", "x = (a if b\n     else c)", "x = a if b else c"),
        ("long_conditionals", "x = a if b else c if d else e", "x = a if b else c"),
    ],
)
def test_rules_find_what_they_are_for(rule: str, bad: str, good: str) -> None:
    assert rules.broken_lines(ast.parse(bad))[rule] == [1]
    assert rules.broken_lines(ast.parse(good))[rule] == []
