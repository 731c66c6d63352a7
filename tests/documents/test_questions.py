"""Ten questions that a reader has: the page of questions answers each, and the answer runs."""

from __future__ import annotations

import re

import pytest

from tests.documents.pages import ROOT, blocks

PAGE = ROOT / "docs" / "howto" / "questions.md"
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


def answers() -> dict[str, str]:
    """Return the answers by their question."""
    parts = re.split(r"^## (.*)$", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    return dict(zip(parts[::2], parts[1::2], strict=True))


def test_there_are_ten():
    assert len(answers()) == len(QUESTIONS) == 10


@pytest.mark.parametrize("words", QUESTIONS)
def test_each_is_answered(words):
    (answer,) = [text for question, text in answers().items() if words in question]
    fragments, page = QUESTIONS[words]
    for fragment in fragments:
        assert fragment in answer, fragment
    links = [(PAGE.parent / link.partition("#")[0]).resolve() for link in re.findall(r"\]\(([^)]+)\)", answer)]
    assert (ROOT / "docs" / page).resolve() in links
    assert all(link.is_file() for link in links)


def test_answers_are_short():
    """Each can be read in well under two minutes: at most some 200 words, code included."""
    assert all(len(answer.split()) < 200 for answer in answers().values())


def test_all_but_one_run_something():
    commands = [block for block in blocks(PAGE) if block.commands]
    assert len(commands) >= 9  # how to cite needs none; the cluster's is a file


def test_questions_stand_on_the_first_page():
    assert "howto/questions" in (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert "questions.md" in (ROOT / "docs" / "start.md").read_text(encoding="utf-8")
