"""The check of the site's search, which `make docs` runs: the ranking of the browser on a small
index, and its words.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess

import pytest

from tests.documents.pages import ROOT, extension

SEARCH = extension("search")
#: An index as Sphinx writes it, of four pages.
INDEX = {
    "docnames": ["armour", "chain", "dents", "python"],
    "titles": ["Force on a target", "A chain", "Dents", "Python interface"],
    "alltitles": {
        "Force on a target": [[0, None]],
        "A chain": [[1, None]],
        "A chain of beads": [[2, "beads"]],
        "Dents": [[2, None]],
        "Python interface": [[3, None]],
    },
    "indexentries": {"drop test": [[0, "index-0", True]], "bead": [[2, "index-1", False]]},
    "objects": {"gw": [[3, 0, 1, "", "chain"], [3, 1, 0, "-", "measures"]]},
    "objnames": {
        "0": ["py", "function", "Python function"],
        "1": ["py", "module", "Python module"],
    },
    "terms": {"plate": 0, "bead": [1, 2], "chain": [1, 3], "drop": 1, "test": [1, 3]},
    "titleterms": {"target": 0, "chain": [1, 2], "dent": 2},
}


def found(query: str) -> list[str]:
    results = SEARCH.search(INDEX, query, lambda word: word.removesuffix("s"), {"the"})
    return [f"{one.page}{one.anchor} {one.score:g}" for one in results]


@pytest.mark.parametrize(
    ("query", "results"),
    [
        (
            "drop test",
            ["armour#index-0 100", "armour 12", "chain 5"],
        ),  # an entry of the index before its words, and these before words of texts
        ("the plates", ["armour 5"]),  # a stem, and a word that is not looked for
        ("dents", ["dents 16.9"]),  # a title, once
        (
            "chain",
            ["python#gw.chain 16", "chain 15.9", "dents 9", "python 5"],
        ),  # an object, a title, a title of a section, a text
        ("beads", ["chain 5", "dents 5"]),
        (
            "bead",
            ["chain 5", "dents 5", "dents#index-1 100"],
        ),  # an entry that is not the main one comes last
        ("targ", ["armour 7.9"]),  # a part of a word of a title
        ("measures", ["python#module-gw.measures 26"]),
        (
            "plate bead",
            ["armour 1.0496", "chain 0.333836", "dents 0.333836"],
        ),  # no page has both words: pages with one of them, the rarer word first
        ("drop piston", ["armour 12", "chain 5"]),  # a word that no page has does not count
        ("nothing", []),
    ],
)
def test_ranking(query, results):
    assert found(query) == results


def test_words_in_the_title_order_equal_results():
    """Only words of the query that begin words of the title count; a plural matches too."""
    index = INDEX | {
        "docnames": ["a", "b", "c"],
        "titles": ["Absorb", "Chains of forces", "Force chains, fronts"],
        "alltitles": {},
        "indexentries": {},
        "objects": {},
        "terms": {"force": [0, 1, 2], "chain": [0, 1, 2]},
        "titleterms": {},
    }
    results = SEARCH.search(index, "force chains", lambda word: word.removesuffix("s"), set())
    assert [(one.page, one.score) for one in results] == [("b", 15.9), ("c", 15.9), ("a", 5)]
    assert SEARCH.part_in_title("Force chains", "chains of sand") == pytest.approx(1 / 3)
    assert SEARCH.part_in_title("Mass", "as") == 0
    assert SEARCH.part_in_title("Mass", "") == 0


def test_pages_of_frequent_words_are_expected_among_two_results():
    heads = SEARCH.HEADS
    assert SEARCH.FIRST_OF_HEADS == 2
    assert {
        "changelog", "what changed", "new in 1.0", "force chains", "fit material", "absorb waves",
        "contacts csv", "Thornton", "killed run", "group velocity",
    } <= set(heads)  # fmt: skip
    for word, page in heads.items():
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        lines = re.findall(r"^```\{index\} (.*)$", text, re.MULTILINE)
        entries = [entry.strip(" !") for entry in ",".join(lines).split(",")]
        assert word in entries, f"{page} has no entry of the index for {word}"


def test_questions_have_pages():
    assert len(SEARCH.QUESTIONS) > 16
    for page in SEARCH.QUESTIONS.values():
        if not page.startswith("reference/styles/"):  # copied when the site is built
            assert (ROOT / "docs" / f"{page}.md").is_file(), page


PROGRAM = """
const Search = {_index: INDEX};
const SearchResultKind = {text: "text"};
const splitQuery = (query) => query.split(/[^\\w]+/).filter((word) => word);
class Stemmer { stemWord(word) { return word.replace(/s$/, ""); } }
SCORER
const found = Search.performTermsSearch(new Set(WORDS), new Set([]));
console.log(JSON.stringify(found.map((one) => [one[0], one[4]])));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
@pytest.mark.parametrize("words", [["chain"], ["drop", "test"], ["plate", "bead"], ["targ"]])
def test_the_browser_finds_the_pages_of_the_check(words):
    parts = {"INDEX": INDEX | {"filenames": INDEX["docnames"]}, "WORDS": words}
    program = PROGRAM.replace("SCORER", SEARCH.SCORER)
    for name, part in parts.items():
        program = program.replace(name, json.dumps(part), 1)
    printed = subprocess.run(["node", "-e", program], capture_output=True, text=True, check=True)
    expected = SEARCH._texts(INDEX, words, lambda word: word.removesuffix("s"))
    scores = {one.page: one.score for one in expected}
    assert dict(json.loads(printed.stdout)) == pytest.approx(scores)


def test_words_have_pages():
    for page, words in SEARCH.WORDS.items():
        assert (ROOT / "docs" / f"{page}.md").is_file(), page
        assert words and len(set(words)) == len(words), page
    every = [word for words in SEARCH.WORDS.values() for word in words]
    assert len(every) == len(set(map(str.lower, every))) > 100


def test_what_is_missed_is_named(monkeypatch):
    monkeypatch.setattr(SEARCH, "WORDS", {"armour": ("drop test",), "dents": ("plate",)})
    monkeypatch.setattr(SEARCH, "HEADS", {"plates": "dents"})
    monkeypatch.setattr(SEARCH, "PASSAGES", {"drop test": "armour#index-0", "plate": "dents#row"})
    monkeypatch.setattr(SEARCH, "QUESTIONS", {"moving plate": "dents"})
    passage, line, question, head = SEARCH.missed(INDEX, str, frozenset())
    assert passage == "plate: expected dents#row first, found armour"
    assert line == "plate: expected dents among the first 3 results, found armour"
    assert question == "moving plate: expected dents among the first 3 results, found armour"
    assert head == "plates: expected dents among the first 2 results, found nothing"


def test_the_room_of_a_page_orders_equal_results():
    """The changelog and rows of results come last, though their titles come first."""
    pages = ("reference/changelog", "explanation/results/bands", "reference/keys", "howto/scans")
    index = INDEX | {
        "docnames": pages,
        "titles": list("abcd"),
        "alltitles": {},
        "indexentries": {},
        "objects": {},
        "terms": {"lattice": [0, 1, 2, 3]},
        "titleterms": {},
    }
    results = SEARCH.search(index, "lattice", str, frozenset())
    assert [one.page for one in results] == list(reversed(pages))


def test_the_scorer_of_the_browser_has_the_weights_of_the_check():
    """`docs/_ext/scorer.js` replaces Sphinx's weights, and must have all of them."""
    for name in ("objNameMatch: 11", "objPartialMatch: 6", "title: 15", "partialTitle: 7",
                 "term: 5", "partialTerm: 2", "titleWords: 0.9", "objPrio: { 0: 15, 1: 5, 2: -5 }"):  # fmt: skip
        assert f"  {name}" in SEARCH.SCORER, name
