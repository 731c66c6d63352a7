"""Tables of the reference that are kept in its pages, and the list of figures."""

from __future__ import annotations

import re
import sys

import pytest

from granwave.analysis.figures.run_figures import run_figures
from tests.documents.pages import ROOT, extension, name_of

sys.path.append(str(ROOT / "docs" / "_ext"))  # its modules import each other
REFERENCE_PAGES = extension("reference_pages")


def test_pages_with_tables_are_found():
    names = set(map(name_of, REFERENCE_PAGES.pages()))
    assert {"docs/reference/keys.md", "docs/reference/commands.md"} <= names and len(names) > 6


@pytest.mark.parametrize("page", REFERENCE_PAGES.pages(), ids=name_of)
def test_tables_are_those_of_the_code(page):
    """If this test fails, ``python docs/_ext/reference_pages.py`` writes the tables again."""
    text = page.read_text(encoding="utf-8")
    assert REFERENCE_PAGES.filled(text) == text


def test_kept_tables_are_plain_markdown():
    head = "(keys-case-run)=\n## `[run]`\n\n"
    term = f"{head}[**`frames`**]{{#case-run-frames}} in s, optional\n: Frames.\n"
    assert (
        REFERENCE_PAGES.plain(term) == "## `[run]`\n\n* **`frames`** in s, optional  \n  Frames.\n"
    )
    usage = "```{code-block} text\n:class: usage\n\ngranwave run CASE\n```\n\n`CASE`\n: A case.\n"
    assert (
        REFERENCE_PAGES.plain(usage) == "```text\ngranwave run CASE\n```\n\n* `CASE`  \n  A case.\n"
    )


def test_a_kept_table_is_replaced_and_a_mark_filled():
    mark = "<!-- lattices -->\n"
    text = REFERENCE_PAGES.filled(f"# A\n\n{mark}\n## B\n\n<!-- unknown -->\n\n{mark}")
    assert text.count("<!-- /lattices -->") == 2 and "<!-- unknown -->\n\n<!--" in text
    assert REFERENCE_PAGES.filled(text) == text


def test_every_figure_is_on_its_page_and_most_have_a_picture():
    text = (ROOT / "docs" / "reference" / "figures.md").read_text(encoding="utf-8")
    for name in run_figures():
        plane = re.sub("_(principal|orthogonal|section)$", "_*", name)
        assert f"| `{plane}` |" in text, name
    pictures = re.findall(r"\]\((\S+\.webp)\)", text)
    assert len(pictures) > 25
    assert all((ROOT / "docs" / "reference" / picture).is_file() for picture in pictures)
