"""The paper has the format that the Journal of Open Source Software requires."""

from __future__ import annotations

import re

import pytest

from tests.documents.pages import ROOT

yaml = pytest.importorskip("yaml")

FOLDER = ROOT / "docs" / "paper"
TEXT = (FOLDER / "paper.md").read_text(encoding="utf-8")
_, HEAD, BODY = re.split(r"^---$", TEXT, maxsplit=2, flags=re.MULTILINE)
SECTIONS = [
    "Summary", "Statement of need", "State of the field", "Software design", "Research impact statement",
    "AI usage disclosure", "Acknowledgements", "References",
]  # fmt: skip


def test_the_front_matter():
    head = yaml.safe_load(HEAD)
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"title", "tags", "authors", "affiliations", "date", "bibliography"} <= set(head)
    assert head["title"] == citation["title"] and (FOLDER / head["bibliography"]).is_file()
    assert [author["name"] for author in head["authors"]] == [
        author["name"] for author in citation["authors"]
    ]
    indices = {one["index"] for one in head["affiliations"]}
    assert {author["affiliation"] for author in head["authors"]} <= indices
    assert re.fullmatch(r"\d{1,2} [A-Z][a-z]+ \d{4}", str(head["date"]))


def test_its_sections_and_length():
    assert re.findall(r"^# (.*)$", BODY, re.MULTILINE) == SECTIONS
    prose = re.sub(r"^\|.*$|<!--.*?-->|\(agreement\.png\)", "", BODY, flags=re.MULTILINE)
    assert 750 <= len(prose.split()) <= 1750


def test_its_citations_are_in_the_bibliography():
    text = (FOLDER / "paper.bib").read_text(encoding="utf-8")
    entries = re.findall(r"^@(\w+)\{(\w+),\n(.*?)^\}$", text, re.MULTILINE | re.DOTALL)
    cited = re.findall(r"@(\w+)", BODY)
    assert sorted(name for _, name, _ in entries) == sorted(set(cited))
    for kind, name, body in entries:
        fields = dict(re.findall(r"^  (\w+) *= \{(.*)\},$", body, re.MULTILINE))
        assert {"author", "title", "year"} <= set(fields), name
        assert fields.get("doi", "").startswith("10.") or kind == "phdthesis", name
        assert body.count("{") == body.count("}"), name


def test_its_pictures_are_there():
    """The picture's digest, and the block of rows, are tested with the results."""
    pictures = re.findall(r"!\[.*?\]\((\S+)\)", BODY, re.DOTALL)
    assert pictures and all((FOLDER / name).is_file() for name in pictures)
    labels = re.findall(r"\\label\{(\w+)\}", BODY)
    named = re.findall(r"\\autoref\{(\w+)\}", BODY)
    assert set(named) == set(labels)


def test_numbers_that_pages_have_too():
    """Numbers in its sentences agree with the pages of the site, which state where they were
    measured.
    """
    dents = (ROOT / "docs" / "explanation" / "contact-law.md").read_text(encoding="utf-8")
    once, shaken = (
        re.search(rf"^\| {start}.*$", dents, re.MULTILINE)[0]
        for start in (r"FCC, 12 . 12 . 8", r"chain of 10, gaps of 0\.02")
    )
    kept, forgotten = (float(cell.split()[0]) for cell in once.split("|")[2:4])
    assert f"{100 * (forgotten / kept - 1):.1f} %" in BODY
    kept, forgotten = (float(cell.split()[0]) for cell in shaken.split("|")[2:4])
    assert re.search(rf"{kept:.0f} mJ to {forgotten:g} mJ", BODY)
