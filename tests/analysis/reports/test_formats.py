"""Three formats of a report: identical bytes for identical inputs, and arbitrary characters in
texts.
"""

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

from granwave.analysis.document.model import (
    Cell,
    DocumentSection,
    DocumentTable,
    Gallery,
    Note,
    Report,
    TableColumn,
)
from granwave.analysis.reports import report as pdf_writer
from granwave.analysis.reports.report import html_page, markdown, parts, write_report
from granwave.lammps_inputs.errors import InputError
from tests.helpers.made_up.synthetic_report import blocks, build, nasty_inputs, write_inputs

#: A section, a file next to the report, or a table in the page.
LINK = r"#[a-z]+|[\w%./~-]+|data:text/csv;base64,[\w+/=]+"


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path_factory.mktemp("runs"))


@pytest.fixture(scope="module")
def nasty(tmp_path_factory):
    """Inputs whose texts would break a page that does not escape them."""
    return nasty_inputs(tmp_path_factory.mktemp("nasty"))


@pytest.mark.validation
def test_same_inputs_same_bytes(runs, tmp_path):
    """Reports are identical in another process and directory, with other hashes and files made in
    another order.
    """
    here = tmp_path / "here"
    there = tmp_path / "there"
    shutil.copytree(runs[0].parent, here)
    for path in sorted(here.rglob("*"), reverse=True):
        if path.is_file():
            (there / path.relative_to(here)).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, there / path.relative_to(here))
    reports = [f"report.{suffix}" for suffix in ("html", "pdf", "md")]
    for name in reports:
        write_report([here / path.name for path in runs], here / name)
    code = f"""from granwave.analysis.reports.report import write_report
for name in {reports}:
    write_report({[path.name for path in runs]}, name)"""
    subprocess.run(
        [sys.executable, "-c", code],
        cwd=there,
        env={**os.environ, "PYTHONHASHSEED": "7"},
        check=True,
    )
    pictures = sorted(f"report_files/{path.name}" for path in (here / "report_files").iterdir())
    assert pictures and pictures == sorted(
        f"report_files/{path.name}" for path in (there / "report_files").iterdir()
    )
    for name in (*reports, *pictures):
        assert (there / name).read_bytes() == (here / name).read_bytes(), name
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


def test_html_escapes_everything(nasty, tmp_path):
    page = write_report(nasty, tmp_path / "r.html").read_text(encoding="utf-8")
    tags = Page(page).tags
    assert [tag for tag, _ in tags].count("script") == 1
    assert not [tag for tag, _ in tags if tag == "i"]
    assert "alert(1)" in page and "<script>alert" not in page
    assert "{{ 7*7 }}" in page
    for tag, attributes in tags:
        assert not [name for name in attributes if name.startswith("on") or name == "style"], tag
        if tag == "a":
            assert re.fullmatch(LINK, attributes["href"]), attributes["href"]


def test_markdown_escapes_everything(nasty, tmp_path):
    text = write_report(nasty, tmp_path / "r.md").read_text(encoding="utf-8")
    assert "<" not in text
    for line in text.splitlines():
        if line.startswith("| "):
            cells = re.split(r"(?<!\\)\|", line)
            assert cells[0] == cells[-1] == ""
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert rows
    for path in re.findall(r"\]\((r_files/[^)]+)\)", text):
        assert (tmp_path / path).is_file()


@pytest.mark.parametrize("text", ["75.5 % of it", "5\\. of May", "\\- no list", "-e of it"])
def test_markdown_has_no_lists_by_accident(text):
    blocks = (Note(text.replace("\\", "")), Note("Answer", "lead", "short"))
    found, _ = markdown(
        Report("R", "1 run. SI units.", (DocumentSection("In short", "short", blocks),)), "r_files"
    )
    assert f"\n{text}\n\n**Answer** [In short](#in-short)\n" in found


def test_pdf_takes_anything(nasty, tmp_path):
    pdf = write_report(nasty, tmp_path / "r.pdf").read_bytes()
    assert pdf.startswith(b"%PDF") and b"%%EOF" in pdf[-60:]


def objects(pdf: bytes) -> bytes:
    """Return a PDF with the contents of its compressed parts after it."""
    found = pdf
    for start in re.finditer(rb"stream\r?\n", pdf):
        with contextlib.suppress(zlib.error):
            found += zlib.decompressobj().decompress(pdf[start.end() :], 2_000_000)
    return found


def test_pdf_is_the_page_on_paper(runs, tmp_path):
    """A4 landscape with a title, embedded fonts, and unfolded tables; no link to a file."""
    pdf = write_report(runs, tmp_path / "report.pdf").read_bytes()
    inside = objects(pdf)
    assert len(re.findall(rb"/Type /Page\b", inside)) > 3
    assert re.search(rb"/MediaBox \[ 0 0 841\.\d+ 595\.\d+ \]", inside)
    assert b"/Title (Report: " in inside and b"/Author (granwave)" in inside
    assert b"DejaVuSans" in inside and b"DejaVuSans-Bold" in inside
    assert b"/URI" not in inside and b"file:" not in inside
    report = build(runs, tmp_path)
    page = Page(html_page(report, paper=True))
    screen = Page(html_page(report))
    assert not {tag for tag, _ in page.tags} & {
        "details",
        "summary",
        "script",
        "button",
        "nav",
        "dialog",
    }
    assert all(attributes["href"].startswith("#") for tag, attributes in page.tags if tag == "a")
    assert (
        [tag for tag, _ in page.tags].count("img")
        == [tag for tag, _ in screen.tags].count("img")
        > 0
    )


def test_tables_of_a_pdf_fill_its_page():
    """The backgrounds of the column headings extend from margin to margin, like the line below a
    title.
    """
    table = DocumentTable(
        "Two",
        (TableColumn("A", key=True), TableColumn("B", numeric=True)),
        ((Cell("x"), Cell("1")),),
    )
    drawn = objects(pdf_writer.pdf_file(Report("R", "", (DocumentSection("S", "s", (table,)),))))
    boxes = [
        tuple(map(float, box))
        for box in re.findall(rb"([\d.]+) ([\d.]+) ([\d.]+) ([\d.]+) re f", drawn)
    ]
    page = max(width for _, _, width, height in boxes if height < 1)
    heads = [(left, left + width) for left, _, width, height in boxes if 5 < height < 20]
    assert max(right for _, right in heads) - min(left for left, _ in heads) == pytest.approx(
        page, abs=1
    )


def test_pdf_reads_nothing_but_its_page(runs, tmp_path, monkeypatch):
    """Images from the disk or the network are not loaded, even if a text is not escaped."""
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
        monkeypatch.setattr(
            pdf_writer, "html_page", lambda report, paper, url=address: form.format(url)
        )
        assert pdf_writer.pdf_file(Report("R", "", ())).startswith(b"%PDF")
    assert len(refused) == 3


def test_pdf_without_its_library(runs, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "plutoprint", None)
    (tmp_path / "report.pdf").write_bytes(b"% report of granwave\n")
    with pytest.raises(
        InputError, match=r"requires PlutoPrint.*pip install .granwave\[pdf\].*\.html and print it"
    ):
        write_report(runs, tmp_path / "new.pdf")
    assert not (tmp_path / "new.pdf").exists()


@pytest.mark.parametrize("columns", [3, 12, 13, 40])
def test_wide_tables_in_parts(columns):
    """Every part has the key columns, no column is missing, and the order is kept."""
    heads = tuple(TableColumn(f"c{n}", key=n in (0, 2)) for n in range(columns))
    rows = tuple(tuple(Cell(f"{row}.{n}") for n in range(columns)) for row in range(2))
    found = parts(DocumentTable("Points", heads, rows))
    assert all(len(part.columns) <= 12 for part in found) and (len(found) > 1) == (columns > 12)
    others = [column for part in found for column in part.columns if not column.key]
    assert others == [column for column in heads if not column.key]
    for number, part in enumerate(found, 1):
        if len(found) > 1:
            assert [column.heading for column in part.columns[:2]] == ["c0", "c2"]
            assert part.caption == f"Points, part {number} of {len(found)}"
        assert [cell.text for cell in part.rows[1]] == [
            f"1.{column.heading[1:]}" for column in part.columns
        ]


def test_markdown_has_the_same_content(runs, tmp_path):
    report = build(runs, tmp_path)
    text = write_report(runs, tmp_path / "report.md").read_text(encoding="utf-8")
    assert all(f"## {section.title}" in text for section in report.sections)
    n_figures = sum(
        len(b.figures)
        for s in report.sections
        for b in blocks(report, s.slug)
        if isinstance(b, Gallery)
    )
    assert text.count("![") == n_figures == len(list((tmp_path / "report_files").iterdir()))
    assert "the disk is full no space left" in text and "**failed**" in text


def test_long_tables_have_a_filter_and_figures_their_data(runs, tmp_path):
    text = write_report(runs, tmp_path / "report.html").read_text(encoding="utf-8")
    tables = [part.partition("</table>")[0] for part in text.split('<div class="frame')[1:]]
    n_rows = [part.partition("<tbody>")[2].count("<tr>") for part in tables]
    assert ['class="filter"' in part for part in tables] == [rows > 20 for rows in n_rows]
    assert any(rows > 20 for rows in n_rows)
    assert 'href="data:text/csv;base64,' in text and 'download="' in text


def test_html_headings_and_figures(runs, tmp_path):
    page = Page(write_report(runs, tmp_path / "report.html").read_text(encoding="utf-8"))
    levels = [int(tag[1]) for tag, _ in page.tags if re.fullmatch(r"h[1-6]", tag)]
    assert levels.count(1) == 1
    assert all(later - before <= 1 for before, later in itertools.pairwise(levels))
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert pictures and all(
        p["alt"] and p["src"].startswith("data:image/png;base64,") for p in pictures
    )
    ids = [attributes["id"] for _, attributes in page.tags if attributes.get("id")]
    assert len(ids) == len(set(ids))
    assert {
        a["href"][1:] for tag, a in page.tags if tag == "a" and a["href"].startswith("#")
    } <= set(ids)
