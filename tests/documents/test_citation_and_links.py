"""BibTeX entries of the page on citing, and how links to other sites are judged."""

from __future__ import annotations

import importlib.util
import re
from types import ModuleType

import pytest

from tests.documents.pages import ROOT

yaml = pytest.importorskip("yaml")


def extension(name: str) -> ModuleType:
    """Load a module of the site's extensions."""
    specification = importlib.util.spec_from_file_location(name, ROOT / "docs" / "_ext" / f"{name}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_bibtex_has_all_works_and_authors():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    program = yaml.safe_load(citation)
    entries = extension("bibtex").bibtex(citation).split("\n\n")
    assert [re.match(r"@(\w+)\{(\w+),\n", entry).groups() for entry in entries] == [
        ("software", "granwave"), ("article", "thompson2022"), ("phdthesis", "pal2015"),
    ]  # fmt: skip
    for work, entry in zip([program, *program["references"]], entries, strict=True):
        fields = dict(re.findall(r"^  (\w+) *= \{(.*)\},$", entry, re.MULTILINE))
        assert len(fields["author"].split(" and ")) == len(work["authors"])
        assert fields["title"] == f"{{{work['title']}}}"
        assert fields.get("doi") == work.get("doi") and fields.get("year") == (
            str(work["year"]) if "year" in work else None
        )
        assert entry.count("{") == entry.count("}")
    assert "school = {University of Illinois at Urbana-Champaign}" in entries[2]


def test_bibtex_escapes_and_refuses():
    module = extension("bibtex")
    work = 'type: article\ntitle: "A & B, 5 %"\nauthors: [{family-names: "O_x", given-names: A.}]\nyear: 2000\n'
    assert r"title  = {{A \& B, 5 \%}}" in module.bibtex(work) and r"O\_x, A." in module.bibtex(work)
    with pytest.raises(ValueError, match="found type map, expected one of"):
        module.bibtex(work.replace("article", "map"))


def test_dead_links_are_told_from_those_that_cannot_be_checked():
    def link(uri: str, status: str, info: str = "") -> dict[str, str]:
        return {"filename": "page.md", "lineno": 3, "uri": uri, "status": status, "info": info}

    links = [
        link("https://a", "working"),
        link("https://a", "working"),
        link("https://b", "redirected", "https://c"),
        link("https://d", "broken", "404 Client Error: Not Found for url: https://d"),
        link("https://d", "broken", "404 Client Error: Not Found for url: https://d"),
        link("https://e", "broken", "HTTPSConnectionPool: Max retries exceeded (Failed to resolve 'e')"),
        link("https://f", "timeout"),
        link("page", "local"),
    ]
    broken, unknown, good = extension("other_sites").sorted_out(links)
    assert broken == ["page.md:3: https://d: 404 Client Error: Not Found for url: https://d"]
    assert [line.split(": ")[1] for line in unknown] == ["https://e", "https://f"] and good == 2
