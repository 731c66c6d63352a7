"""Questions that a reader has, on two pages: each has a short answer that runs, and leads on."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.documents.pages import ROOT, blocks

HOWTO = ROOT / "docs" / "howto"
PAGE, MORE_PAGE = HOWTO / "questions.md", HOWTO / "more-questions.md"
# words of the question, words that its answer must have, and the page that tells more
QUESTIONS = {
    "my own material": (["youngs_modulus", "granwave run mine.toml"], "tutorials/material-and-tolerances.md"),
    "my own packing file": (['kind = "file"', "granwave run row.toml"], "howto/own-places.md"),
    "only a chain": (['kind = "chain"', "granwave run"], "tutorials/chain.md"),
    "reaches a plate": (["peak_reduction", "granwave run protected-target"], "howto/target.md"),
    "energy balance poor": (["run.timestep=auto", "run.energy_tolerance"], "howto/balance.md"),
    "How big must my packing be": (["granwave check", "zone_cut"], "howto/packing-size.md"),
    "cite": (["LAMMPS", "source of the contact law"], "howto/cite.md"),
    "restart": (["--resume"], "howto/stop-and-resume.md"),
    "its own MPI": (["launcher", "slurm"], "howto/own-lammps.md"),
    "contact law differs": (["granwave fit", "thornton"], "howto/fit-a-law.md"),
}
# of the second page: words of the question, and words that its answer must have
MORE = {
    "units": ["SI units", "granwave keys", "peak_force_N"],
    "into pandas": ["run.contact_forces", "run.contacts", "granwave export", "output.contact_forces"],
    "Which id": ["run.spheres", "granwave write", "data.granwave", "[[hold]]"],
    "damping": ["contact.loss", "restitution", "losses.md"],
    "my experiment": ["run.walls", "measured.csv", "[[sensor]]"],
    "error of the results": ["run.energy_tolerance", "replicates", "../explanation/limits.md", "packing-size.md"],
    "one figure for a paper": ["granwave figures", "--only", "--width", "films.md"],
}


def answers(page: Path) -> dict[str, str]:
    """Return the answers by their question."""
    parts = re.split(r"^## (.*)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def test_their_number():
    assert len(answers(PAGE)) == len(QUESTIONS) == 10
    assert len(answers(MORE_PAGE)) == len(MORE)


@pytest.mark.parametrize("words", QUESTIONS)
def test_each_is_answered(words):
    (answer,) = [text for question, text in answers(PAGE).items() if words in question]
    fragments, page = QUESTIONS[words]
    assert [fragment for fragment in fragments if fragment not in answer] == []
    links = [(HOWTO / link.partition("#")[0]).resolve() for link in re.findall(r"\]\(([^)]+)\)", answer)]
    assert (ROOT / "docs" / page).resolve() in links
    assert all(link.is_file() for link in links)


@pytest.mark.parametrize("words", MORE)
def test_each_of_the_second_page_is_answered(words):
    (answer,) = [text for question, text in answers(MORE_PAGE).items() if words in question]
    assert [fragment for fragment in MORE[words] if fragment not in answer] == []


@pytest.mark.parametrize(("page", "most"), [(PAGE, 200), (MORE_PAGE, 260)])
def test_answers_are_short(page, most):
    """Each can be read in two minutes, code included."""
    assert all(len(answer.split()) < most for answer in answers(page).values())


def test_all_but_one_run_something():
    commands = [block for block in blocks(PAGE) if block.commands]
    assert len(commands) >= 9  # how to cite needs none; the cluster's is a file


def test_questions_stand_on_the_first_page():
    assert "howto/questions" in (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "questions.md" in (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
    for name in ("questions.md", "index.md"):
        assert "more-questions.md" in (HOWTO / name).read_text(encoding="utf-8")


def test_all_recipes_are_in_the_list():
    """Each page of the folder is in the table of contents and in the table that says what one gets."""
    text = (HOWTO / "index.md").read_text(encoding="utf-8")
    for page in HOWTO.glob("*.md"):
        if page.stem != "index":
            assert re.search(rf"^{page.stem}$", text, re.MULTILINE) and f"]({page.name})" in text, page.name
