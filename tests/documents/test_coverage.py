"""The page on coverage of the sources is generated from the table and the stored rows."""

from __future__ import annotations

import dataclasses

import pytest

from tests.documents.pages import extension

for name in ("chosen", "stored", "notes", "sources", "rows", "picture"):
    extension(f"results_{name}")
COVERAGE = extension("results_coverage")
STORED = extension("results_stored").read_stored()
ITEMS = COVERAGE.read_items()
#: Beginnings of what rows say of their source, by the source's name in the table.
SAID = {
    "thesis": "thesis",
    "composite chains": "composite chain,",
    "lateral constraints": "lateral constraints",
    "square packing": "square packing",
}


def test_the_page_is_made_of_the_table_and_the_stored_rows():
    page = COVERAGE.PAGE.read_text(encoding="utf-8")
    assert page == COVERAGE.page_of(ITEMS, STORED), (
        "run .venv/bin/python docs/_ext/results_coverage.py"
    )


def test_items_of_every_source_say_what_is_missing():
    assert {item.source for item in ITEMS} == set(COVERAGE.SOURCES) == set(SAID)
    places = [(item.source, item.place) for item in ITEMS]
    assert len(set(places)) == len(places)
    for item in ITEMS:
        assert item.state in COVERAGE.STATES, item.place
        assert bool(item.why) == (item.state != "works"), item.place
        assert item.state == "works" or not item.differs, item.place


def test_items_name_studies_whose_rows_are_stored():
    for item in ITEMS:
        for suite, study in item.studies:
            assert study in STORED["suites"][suite]["studies"], f"{item.place}: {suite}/{study}"


@pytest.mark.parametrize("source", SAID)
def test_every_study_that_compares_with_a_source_belongs_to_an_item(source):
    named = set()
    for item in ITEMS:
        if item.source == source:
            named |= set(item.studies)
    for suite, content in STORED["suites"].items():
        for name, study in content["studies"].items():
            places = [row["where"] for row in study["rows"] if row["kind"] == "source"]
            if any(place.startswith(SAID[source]) for place in places):
                assert (suite, name) in named


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"state": "partly", "why": "No value is printed."}, "| partly | No value is printed. |"),
        ({"what": "a*b"}, r"| a\*b |"),
        (
            {"state": "works", "why": "", "differs": "12 % too large."},
            "| works | 12 % too large. |",
        ),
    ],
)
def test_a_changed_item_changes_the_page(change, says):
    first = dataclasses.replace(ITEMS[0], **change)
    page = COVERAGE.page_of([first, *ITEMS[1:]], STORED)
    assert says in page
    assert page != COVERAGE.page_of(ITEMS, STORED)
