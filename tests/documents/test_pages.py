"""Pages: their code, files, commands and names, and the questions of readers."""

from __future__ import annotations

import argparse
import contextlib
import re
import runpy
import tomllib
from collections.abc import Collection
from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import pytest

from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.quantities import entries
from granwave.extensions.design.search.design_file import load_problem
from granwave.extensions.inference.forces.case import read_infer_case
from granwave.lammps_inputs import load_case, load_materials
from granwave.lammps_inputs.case.packing.made_packing import PackingNotMadeError, nothing_made
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.workflows import library, load_profile, load_scan
from granwave.workflows.cli.keys.reference import tables
from granwave.workflows.cli.parser import make_parser
from granwave.workflows.python.api import public_names
from granwave.workflows.scanning.suite import load_suite
from tests.documents.pages import README, ROOT, Block, blocks, name_of, pages, write_files

PAGES = pages()
WITH_PYTHON = [
    page
    for page in PAGES
    if any(block.language == "python" and not block.caption for block in blocks(page))
]
WITH_FILES = [page for page in PAGES if any(block.language == "toml" for block in blocks(page))]
WITH_COMMANDS = [page for page in PAGES if any(block.commands for block in blocks(page))]
BASE = {
    "name": "base",
    "material": "brass",
    "packing": {"kind": "fcc", "size": [6, 6, 4], "diameter": 0.01},
}
SELECTED = {
    "run": "case",
    "check": "case",
    "write": "case",
    "continuum": "case",
    "scan": "scan",
    "show": "name",
}


def test_pages_are_found():
    assert README in PAGES and len(PAGES) > 40
    assert WITH_PYTHON and len(WITH_FILES) > 10 and len(WITH_COMMANDS) > 20


def test_the_readme_is_short():
    assert len(README.read_text(encoding="utf-8").splitlines()) <= 200


@pytest.mark.parametrize("page", WITH_PYTHON, ids=name_of)
def test_python(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_files(page, tmp_path)
    (tmp_path / "page.py").write_text(
        "\n".join(
            block.text for block in blocks(page) if block.language == "python" and not block.caption
        )
    )
    with matplotlib.rc_context({"backend": "agg"}):
        runpy.run_path("page.py", run_name="__main__")
        plt.close("all")
    assert capsys.readouterr().out


def test_names_of_python():
    """Functions of the package that the page on Python names exist."""
    (page,) = [
        page for page in WITH_PYTHON if page.name == "python.md" and page.parent.name == "howto"
    ]
    assert set(re.findall(r"\bgw\.(\w+)", page.read_text(encoding="utf-8"))) <= set(public_names())


def load(block: Block, folder: Path) -> None:
    """Load a file of a page by the function that reads its kind; parts of a case are put into a
    small one.
    """
    data = tomllib.loads(block.text)
    path = folder / (block.caption or "unnamed.toml")
    path.write_text(block.text, encoding="utf-8")
    if "variables" in data:
        load_problem(path)
    elif "uncertainty" in data:
        load_problem({"base": "protected-target", "variables": {"material": ["steel"]},
                      "objective": {"minimise": ["mass_kg"]}} | data)  # fmt: skip
    elif "slurm" in data or "cluster" in data:
        load_profile(path)
    elif "scans" in data:
        load_suite(path)
    elif "grid" in data or "zip" in data or "points" in data:
        assert load_scan(path).points
    elif "infer" in data:
        read_infer_case(path)
    elif "packing" in data and "material" in data:
        load_case(path)
    elif "material" not in data and are_materials(data):
        load_materials(path)
    else:
        case_from_dict({**BASE, **data}, path)


def are_materials(data: dict) -> bool:
    """True for a file of materials, each table of which has the constants of a material."""
    tables = [table for table in data.values() if isinstance(table, dict)]
    return bool(tables) and all("youngs_modulus" in table for table in tables)


FITTED = 'material = "brass"\n[contact]\nlaw = "elastoplastic"\npressure_limit = 2.5\n'


@pytest.mark.parametrize("page", WITH_FILES, ids=name_of)
def test_files(page, tmp_path, monkeypatch):
    """Grains that LAMMPS would have to generate first are not generated."""
    monkeypatch.chdir(tmp_path)
    write_files(page, tmp_path)
    (tmp_path / "fit").mkdir()  # what a command of the page on fits leaves
    (tmp_path / "fit" / "fit.toml").write_text(FITTED)
    for block in blocks(page):
        if block.language == "toml":
            with nothing_made(), contextlib.suppress(PackingNotMadeError):
                load(block, tmp_path)


@pytest.mark.parametrize("page", WITH_COMMANDS, ids=name_of)
def test_commands(page, tmp_path, monkeypatch):
    """Every command is read by the parser, names existing objects, and sets keys of its case."""
    monkeypatch.chdir(tmp_path)
    write_files(page, tmp_path)
    made = known_directories(page) | {
        "fit",
        "grains.csv",
    }  # directories and files that commands of the page leave
    for words in (words for block in blocks(page) for words in block.commands):
        if words[-1] in ("--version", "--help"):
            continue
        words, files = (words[:-2], words[-1:]) if ">" in words else (words, [])
        options = make_parser().parse_args(words)
        made |= {
            *files,
            str(getattr(options, "directory", None) or Path(words[-1]).stem),
            Path([*words, "x"][1]).stem,
        }
        check_command(words[0], options, made)


def check_command(verb: str, options: argparse.Namespace, made: Collection[str]) -> None:
    """Check the names in a command; ``made`` are directories and files from commands of its page."""

    def is_there(name: object) -> bool:
        in_checkout = str(name).startswith("reproductions/") and (ROOT / str(name)).is_file()
        return in_checkout or Path(str(name)).exists() or str(name).partition("/")[0] in made

    if verb == "keys":
        assert not options.table or ".".join(options.table) in {table.name for table in tables()}
    if verb in SELECTED:
        name = getattr(options, SELECTED[verb])
        kind = library.SCANS if verb == "scan" else library.CASES
        built_in = name in library.names(kind)
        assert built_in or is_there(name), f"{name}: no such study"
        there = built_in or Path(name).is_file()
        granular = there and library.verb_of(library.find(name, kind)) == "run"
        if verb in ("run", "check", "write") and granular:
            library.load_case(
                name, [change for change in options.overrides if "initial_overlap" not in change]
            )
    for name in [
        *getattr(options, "directories", []),
        *filter(None, [getattr(options, "profile", None)]),
    ]:
        assert is_there(name), f"{name}: no command of the page makes it"


def known_directories(page: Path) -> set[str]:
    """Return the directories that the cases of a page run into if no other is named."""
    return {
        str(tomllib.loads(block.text).get("name"))
        for block in blocks(page)
        if block.language == "toml"
    }


def test_no_line_of_text_is_a_comment():
    """A percent sign at the beginning of a line makes it a comment, which the site leaves out."""
    comments = []
    for page in [*PAGES, *(ROOT / "plugins" / "doc").glob("*.md")]:
        text = page.read_text(encoding="utf-8")
        text = re.sub(r"(?ms)^ *(```+|~~~+|:::+).*?^ *\1$", "", text)
        comments += [(page.name, line) for line in re.findall(r"(?m)^ *%.*$", text)]
    assert comments == []


def test_targets_of_make_exist():
    targets = set(
        re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    )
    named = {
        target
        for page in PAGES
        for target in re.findall(
            r"(?:^ {4}|`)make ([\w-]+)", page.read_text(encoding="utf-8"), re.MULTILINE
        )
    }
    assert {"demo", "test"} <= named <= targets


def test_values_of_a_summary_that_tables_name_exist():
    known = {entry.name for entry in entries()}
    named = set()
    for page in PAGES:
        for table in re.findall(
            r"^\| value \| meaning \|\n\|.*\n((?:\|.*\n)+)",
            page.read_text(encoding="utf-8"),
            re.MULTILINE,
        ):
            named |= set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE))
    assert len(named) > 10 and named <= known


def test_figures_that_tables_name_exist():
    text = (ROOT / "docs/tutorials/first-impact.md").read_text(encoding="utf-8")
    (table,) = re.findall(r"^\| figure \|.*\n\|.*\n((?:\|.*\n)+)", text, re.MULTILINE)
    assert set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE)) <= set(run_figures())


def test_every_value_of_a_summary_is_explained():
    unexplained = [entry.name for entry in entries() if not entry.meaning and not entry.note]
    assert set(unexplained) <= {
        "packing_mass_kg",
        "packing_height_m",
        "yield_overlap_m",
        "yield_force_N",
        "max_overlap_m",
    }


def test_overrides_in_text_are_keys():
    """Dotted keys in the running text, such as ``run.end_time``, exist."""
    known = {f"{table.name}.{key.name}" for table in tables() for key in table.keys}
    heads = {key.partition(".")[0] for key in known} - {"scan"}
    for page in PAGES:
        if "changelog" not in page.name and page.name not in (
            "python.md",
            "reports.md",
            "more-questions.md",
        ):  # there `run.` is a run
            for key in re.findall(r"`([a-z_]+\.[a-z_]+)`", page.read_text(encoding="utf-8")):
                head, _, end = key.partition(".")
                if head in heads and end not in (
                    "toml",
                    "csv",
                    "h",
                    "json",
                    "html",
                    "md",
                    "png",
                    "txt",
                ):
                    assert key in known, (name_of(page), key)


HOWTO = ROOT / "docs" / "howto"
#: By page: words of each question, words that its answer must have, and the page that tells more, if that is asked for.
QUESTIONS = {
    "questions.md": {
        "my own material": (["youngs_modulus", "granwave run mine.toml"], "tutorials/material-and-tolerances.md"),
        "my own packing file": (['kind = "file"', "granwave run row.toml"], "howto/own-places.md"),
        "only a chain": (['kind = "chain"', "granwave run"], "tutorials/chain.md"),
        "reaches a plate": (["peak_reduction", "granwave run protected-target"], "howto/target.md"),
        "balance error large": (["run.timestep=auto", "run.energy_tolerance"], "howto/balance.md"),
        "How big must my packing be": (["granwave check", "zone_cut"], "howto/packing-size.md"),
        "cite": (["LAMMPS", "source of the contact law"], "howto/cite.md"),
        "restart": (["--resume"], "howto/stop-and-resume.md"),
        "its own MPI": (["launcher", "slurm"], "howto/own-lammps.md"),
        "contact law differs": (["granwave fit", "thornton"], "extensions/continuum/fit-a-law.md"),
    },
    "more-questions.md": {
        "units": (["SI units", "granwave keys", "peak_force_N"], ""),
        "into pandas": (["run.contact_forces", "run.contacts", "granwave export", "output.contact_forces"], ""),
        "Which id": (["run.spheres", "granwave write", "data.granwave", "[[hold]]"], ""),
        "damping": (["contact.loss", "restitution", "losses.md"], ""),
        "my experiment": (["run.walls", "measured.csv", "[[sensor]]"], ""),
        "error of the results": (
            ["run.energy_tolerance", "replicates", "../explanation/limits.md", "packing-size.md"], ""
        ),
        "one figure for a paper": (["granwave figures hit", "--width", "films.md"], ""),
    },
}  # fmt: skip


@pytest.mark.parametrize(("name", "most"), [("questions.md", 200), ("more-questions.md", 260)])
def test_questions_are_answered(name, most):
    """Each answer can be read in two minutes, code included."""
    parts = re.split(r"^## (.*)$", (HOWTO / name).read_text(encoding="utf-8"), flags=re.MULTILINE)[
        1:
    ]
    answers = dict(zip(parts[::2], parts[1::2], strict=True))
    answers.pop("Next")
    assert len(answers) == len(QUESTIONS[name])
    for words, (fragments, more) in QUESTIONS[name].items():
        (answer,) = [text for question, text in answers.items() if words in question]
        assert [fragment for fragment in fragments if fragment not in answer] == [], words
        assert len(answer.split()) < most, words
        if more:
            links = [
                (HOWTO / link.partition("#")[0]).resolve()
                for link in re.findall(r"\]\(([^)]+)\)", answer)
            ]
            assert (ROOT / "docs" / more).resolve() in links and all(
                link.is_file() for link in links
            ), words


def test_questions_stand_on_the_first_page():
    assert (
        len([block for block in blocks(HOWTO / "questions.md") if block.commands]) >= 9
    )  # how to cite needs none
    for name, words in (("index.md", "howto/questions"), ("start.md", "questions.md")):
        assert words in (ROOT / "docs" / name).read_text(encoding="utf-8")
    for name in ("questions.md", "index.md"):
        assert "more-questions.md" in (HOWTO / name).read_text(encoding="utf-8")


def test_all_recipes_are_in_the_list():
    """Each page of the folder is in the table of contents and in the table of results."""
    text = (HOWTO / "index.md").read_text(encoding="utf-8")
    for page in HOWTO.glob("*.md"):
        if page.stem != "index":
            assert re.search(rf"^{page.stem}$", text, re.MULTILINE) and f"]({page.name})" in text, (
                page.name
            )
