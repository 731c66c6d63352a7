"""Three formats of a report: identical bytes for identical inputs, and arbitrary characters in texts."""

from __future__ import annotations

import contextlib
import itertools
import os
import re
import shutil
import subprocess
import sys
import zlib
from html.parser import HTMLParser
from pathlib import Path

import pytest

from granwave.analysis.document.model import Cell, Column, Gallery, Note, Report, Section, Table
from granwave.analysis.reports import report as pdf_writer
from granwave.analysis.reports.report import html_page, markdown, parts, write_report
from granwave.lammps_inputs.errors import InputError
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
    assert pdf.startswith(b"%PDF") and b"%%EOF" in pdf[-60:]


def objects(pdf: bytes) -> bytes:
    """Return a PDF with the contents of its compressed parts after it."""
    found = pdf
    for start in re.finditer(rb"stream\r?\n", pdf):
        with contextlib.suppress(zlib.error):
            found += zlib.decompressobj().decompress(pdf[start.end() :], 2_000_000)
    return found


def test_pdf_is_the_page_on_paper(runs, tmp_path):
    """A4 landscape with a title, letters of its own, and folded tables unfolded; no link to a file."""
    pdf = write_report(runs, tmp_path / "report.pdf").read_bytes()
    inside = objects(pdf)
    assert len(re.findall(rb"/Type /Page\b", inside)) > 3
    assert re.search(rb"/MediaBox \[ 0 0 841\.\d+ 595\.\d+ \]", inside)
    assert b"/Title (Report: " in inside and b"/Author (granwave)" in inside
    assert b"DejaVuSans" in inside and b"DejaVuSans-Bold" in inside
    assert b"/URI" not in inside and b"file:" not in inside
    page = Page(html_page(build(runs, tmp_path), paper=True))
    tags = {tag for tag, _ in page.tags}
    assert not tags & {"details", "summary", "script", "button", "nav", "dialog"}
    assert all(attributes["href"].startswith("#") for tag, attributes in page.tags if tag == "a")
    assert len([tag for tag, _ in page.tags if tag == "img"]) == len(
        [tag for tag, _ in Page(html_page(build(runs, tmp_path))).tags if tag == "img"]
    )


def test_tables_of_a_pdf_fill_its_page():
    """The grounds of the heads of their columns reach from margin to margin, as the line below a title does."""
    table = Table("Two", (Column("A", key=True), Column("B", numeric=True)), ((Cell("x"), Cell("1")),))
    drawn = objects(pdf_writer.pdf_file(Report("R", "", (Section("S", "s", (table,)),))))
    boxes = [tuple(map(float, box)) for box in re.findall(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", drawn)]
    page = max(width for _, _, width, height in boxes if height < 1)
    heads = [(left, left + width) for left, _, width, height in boxes if 5 < height < 20]
    assert max(right for _, right in heads) - min(left for left, _ in heads) == pytest.approx(page, abs=1)


def test_pdf_reads_nothing_but_its_page(runs, tmp_path, monkeypatch):
    """A picture from the disk or the network would stay out, even if a text got past the escapes."""
    secret = tmp_path / "secret.png"
    secret.write_bytes(Path(__file__).with_name("test_formats.py").read_bytes())
    form = '<body><img src="{}"><p>text</p></body>'
    plutoprint = pytest.importorskip("plutoprint")
    refused = []

    class Watched(plutoprint.ResourceFetcher):
        def __init_subclass__(cls):
            fetch = cls.fetch_url

            def watched(self, url):
                try:
                    return fetch(self, url)
                except ValueError:
                    refused.append(url)
                    raise

            cls.fetch_url = watched

    monkeypatch.setattr(plutoprint, "ResourceFetcher", Watched)
    for address in (secret.as_uri(), "http://127.0.0.1:9/picture.png", "secret.png"):
        monkeypatch.setattr(pdf_writer, "html_page", lambda report, paper, url=address: form.format(url))
        assert pdf_writer.pdf_file(Report("R", "", ())).startswith(b"%PDF")
    assert len(refused) == 3


def test_pdf_without_its_library(runs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plutoprint", None)
    (tmp_path / "report.pdf").write_bytes(b"% report of granwave\n")
    with pytest.raises(InputError, match=r"needs PlutoPrint.*pip install plutoprint.*\.html and print that"):
        write_report(runs, tmp_path / "new.pdf")
    assert not (tmp_path / "new.pdf").exists()


@pytest.mark.parametrize("columns", [3, 12, 13, 40])
def test_wide_tables_in_parts(columns):
    """Every part has the key columns, no column is lost, and the order stays."""
    heads = tuple(Column(f"c{n}", key=n in (0, 2)) for n in range(columns))
    rows = tuple(tuple(Cell(f"{row}.{n}") for n in range(columns)) for row in range(2))
    found = parts(Table("Points", heads, rows))
    assert all(len(part.columns) <= 12 for part in found) and (len(found) > 1) == (columns > 12)
    others = [column for part in found for column in part.columns if not column.key]
    assert others == [column for column in heads if not column.key]
    for number, part in enumerate(found, 1):
        if len(found) > 1:
            assert [column.heading for column in part.columns[:2]] == ["c0", "c2"]
            assert part.caption == f"Points, part {number} of {len(found)}"
        assert [cell.text for cell in part.rows[1]] == [f"1.{column.heading[1:]}" for column in part.columns]


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
