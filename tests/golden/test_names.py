"""Names that users type and read stay; see `names` for how to add some."""

from __future__ import annotations

import re

import pytest

import granwave as gw
from tests.documents.pages import ROOT
from tests.golden import names

ADD = "add them: python -m tests.golden.names"
NOW = names.names()
KEPT = names.kept()


@pytest.mark.parametrize("kind", KEPT)
def test_no_name_is_missing(kind: str) -> None:
    missing = names.flat(KEPT[kind]) - names.flat(NOW.get(kind, {}))
    assert sorted(missing) == [], "users and scripts rely on these names"


@pytest.mark.parametrize("kind", NOW)
def test_new_names_are_kept(kind: str) -> None:
    new = names.flat(NOW[kind]) - names.flat(KEPT.get(kind, {}))
    assert sorted(new) == [], ADD


def test_every_kind_has_names() -> None:
    assert NOW.keys() == KEPT.keys()
    assert all(len(names.flat(KEPT[kind])) > 30 for kind in KEPT)


def test_the_page_names_the_promised_members_of_a_comparison() -> None:
    page = (ROOT / "docs" / "reference" / "what-stays.md").read_text(encoding="utf-8")
    promise = page.partition("Of `gw.Comparison`, ")[2].partition("Its other members")[0]
    assert tuple(re.findall(r"`(\w+)`", promise)) == names.COMPARISON_MEMBERS
    assert all(hasattr(gw.Comparison, name) for name in names.COMPARISON_MEMBERS)


def test_a_missing_name_is_found() -> None:
    before = {"run": ["CASE", "--np"], "scan": ["SCAN"]}
    after = {"run": ["CASE"], "scan": ["SCAN", "--np"]}
    assert names.flat(before) - names.flat(after) == {"run: --np"}
