"""The page of what is asked next: each answer is short, has its fragments, and leads on; other tests run its code."""

from __future__ import annotations

import re

import pytest

from tests.documents.pages import ROOT

PAGE = ROOT / "docs" / "howto" / "more-questions.md"
# words of the question, and words that its answer must have
QUESTIONS = {
    "units": ["SI units", "granwave keys", "peak_force_N"],
    "into pandas": ["run.contact_forces", "run.contacts", "granwave export", "output.contact_forces"],
    "Which id": ["run.spheres", "granwave write", "data.granwave", "[[hold]]"],
    "damping": ["contact.loss", "restitution", "losses.md"],
    "my experiment": ["run.walls", "measured.csv", "[[sensor]]"],
    "error of the results": ["run.energy_tolerance", "replicates", "../explanation/limits.md", "packing-size.md"],
    "one figure for a paper": ["granwave figures", "--only", "--width", "films.md"],
}


def answers() -> dict[str, str]:
    """Return the answers by their question."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


@pytest.mark.parametrize("words", QUESTIONS)
def test_each_is_answered(words):
    (answer,) = [text for question, text in answers().items() if words in question]
    assert all(fragment in answer for fragment in QUESTIONS[words])
    assert len(answer.split()) < 260  # read in two minutes, code included


def test_the_ten_questions_and_the_list_lead_there():
    for name in ("questions.md", "index.md"):
        assert "more-questions.md" in (PAGE.parent / name).read_text(encoding="utf-8")
    assert len(answers()) == len(QUESTIONS)


def test_all_recipes_are_in_the_list():
    """Each page of the folder is in the table of contents and in the table that says what one gets."""
    text = (PAGE.parent / "index.md").read_text(encoding="utf-8")
    for page in PAGE.parent.glob("*.md"):
        if page.stem != "index":
            assert re.search(rf"^{page.stem}$", text, re.MULTILINE) and f"]({page.name})" in text, page.name
