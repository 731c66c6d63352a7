"""Three formats of a report: identical bytes for identical inputs, and arbitrary characters in texts."""

from __future__ import annotations

import itertools
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser

import pytest

from granwave.analysis.document.model import Gallery, Note, Report, Section
from granwave.analysis.reports.report import write_report
from granwave.analysis.reports.writers.markdown import markdown
from tests.helpers.synthetic_report import blocks, build, nasty_inputs, write_inputs


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path)


@pytest.mark.parametrize("suffix", ["html", "pdf", "md"])
def test_same_inputs_same_bytes(runs, tmp_path, suffix):
    """Reports are identical in another process and directory, with other hashes and files made in another order."""
    write_report(runs, tmp_path / f"report.{suffix}")
    there = tmp_path / "elsewhere"
    there.mkdir()
    for path in reversed(runs):
        (there / path.name).mkdir()
        for file in sorted(path.rglob("*"), reverse=True):
            if file.is_file():
                (there / file.relative_to(tmp_path)).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, there / file.relative_to(tmp_path))
    names = [path.name for path in runs]
    code = f"from granwave.analysis.reports.report import write_report; write_report({names}, 'report.{suffix}')"
    environment = {**os.environ, "PYTHONHASHSEED": "7"}
    subprocess.run([sys.executable, "-c", code], cwd=there, env=environment, check=True)
    assert (there / f"report.{suffix}").read_bytes() == (tmp_path / f"report.{suffix}").read_bytes()
    if suffix == "md":
        pictures = sorted(path.name for path in (tmp_path / "report_files").iterdir())
        assert pictures == sorted(path.name for path in (there / "report_files").iterdir())
        assert pictures
    assert not [path for path in there.iterdir() if path.name.startswith(".")]


class Page(HTMLParser):
    """Tags and their link targets."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)


def test_html_escapes_everything(tmp_path):
    page = write_report(nasty_inputs(tmp_path), tmp_path / "r.html").read_text(encoding="utf-8")
    tags = Page(page).tags
    assert [tag for tag, _ in tags].count("script") == 1
    assert not [tag for tag, _ in tags if tag == "i"]
    assert "alert(1)" in page and "<script>alert" not in page
    assert "{{ 7*7 }}" in page
    for tag, attributes in tags:
        assert not [name for name in attributes if name.startswith("on") or name == "style"], tag
        if tag == "a":
            assert re.fullmatch(r"#[a-z]+|[\w%./~-]+", attributes["href"]), attributes["href"]


def test_markdown_escapes_everything(tmp_path):
    text = write_report(nasty_inputs(tmp_path), tmp_path / "r.md").read_text(encoding="utf-8")
    assert "<" not in text
    for line in text.splitlines():
        if line.startswith("| "):
            cells = re.split(r"(?<!\\)\|", line)
            assert cells[0] == cells[-1] == ""
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert rows
    for path in re.findall(r"\]\((r_files/[^)]+)\)", text):
        assert (tmp_path / path).is_file()


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("75.5 % of it", "75.5 % of it"),
        ("5. of May", "5\\. of May"),
        ("- no list", "\\- no list"),
        ("-e of it", "-e of it"),
    ],
)
def test_markdown_has_no_lists_by_accident(text, shown):
    report = Report(
        "R", "1 run. SI units.", (Section("In short", "short", (Note(text), Note("Answer", "lead", "short"))),)
    )
    found, _ = markdown(report, "r_files")
    assert f"\n{shown}\n\n**Answer** [In short](#in-short)\n" in found


def test_pdf_takes_anything(tmp_path):
    pdf = write_report(nasty_inputs(tmp_path), tmp_path / "r.pdf").read_bytes()
    assert pdf.startswith(b"%PDF") and pdf.rstrip().endswith(b"%%EOF")


def test_markdown_has_the_same_content(runs, tmp_path):
    report = build(runs, tmp_path)
    text = write_report(runs, tmp_path / "report.md").read_text(encoding="utf-8")
    for section in report.sections:
        assert f"## {section.title}" in text
    n_figures = sum(len(b.figures) for s in report.sections for b in blocks(report, s.slug) if isinstance(b, Gallery))
    assert text.count("![") == n_figures == len(list((tmp_path / "report_files").iterdir()))
    assert "the disk is full no space left" in text
    assert "**failed**" in text
    for width in {line.count("|") for line in text.splitlines() if line.startswith("| 3 | ")}:
        assert width > 5


def test_html_headings_and_figures(runs, tmp_path):
    page = Page(write_report(runs, tmp_path / "report.html").read_text(encoding="utf-8"))
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels.count(1) == 1
    assert all(later - before <= 1 for before, later in itertools.pairwise(levels))
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert pictures and all(p["alt"] and p["src"].startswith("data:image/png;base64,") for p in pictures)
    ids = [attributes["id"] for _, attributes in page.tags if attributes.get("id")]
    assert len(ids) == len(set(ids))
    assert {a["href"][1:] for tag, a in page.tags if tag == "a" and a["href"].startswith("#")} <= set(ids)
