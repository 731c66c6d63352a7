"""Reports in a browser and on paper, without duplicates, and rejected inputs and paths."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from PIL import Image

from granwave.analysis import analyse
from granwave.analysis.document.model import (
    Block,
    DocumentTable,
    Figure,
    Gallery,
    Group,
    Note,
    Report,
)
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import write_report
from granwave.analysis.reports.studies import studies_of
from granwave.analysis.scans.figures import draw_scan_figures
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.studies.study import draw_studies
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.small_cases import PULSE, case_of
from tests.helpers.made_up.synthetic_report import build, nasty_inputs, write_inputs, write_run
from tests.helpers.made_up.synthetic_scan import grid, write_json, write_scan
from tests.helpers.programs.chromium import Browser

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
NO_CHROMIUM = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)"
)
pytestmark = [NO_CHROMIUM, pytest.mark.xdist_group("browser")]  # its fixtures are made once


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path)


def test_in_a_browser(runs, tmp_path):
    """No error messages, no requests, no horizontal scrolling on a phone, and tables that can be
    sorted by keyboard.
    """
    write_report([*runs, *nasty_inputs(tmp_path / "more")], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        for width in (390, 1200):
            browser.open((tmp_path / "report.html").as_uri(), width)
            browser.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))")
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
            assert browser.evaluate("innerWidth") == width
            wide = (
                "[...document.querySelectorAll('.box')].some((b) => b.scrollWidth > b.clientWidth)"
            )
            assert browser.evaluate(wide) is True  # tables scroll within their own elements
            assert (
                browser.evaluate(
                    "[...document.images].every((i) => i.complete && i.naturalWidth > 0)"
                )
                is True
            )
            assert browser.evaluate("parseFloat(getComputedStyle(document.body).fontSize)") >= 16
        sort = "[...document.querySelectorAll('table.sortable')].find((t) => t.caption?.innerText == 'Scan scan')"
        column = f"[...({sort}).tBodies[0].rows].map((r) => r.cells[1].innerText)"
        unsorted = browser.evaluate(column)
        assert unsorted == ["10", "10", "9", "9", "1", "1", "40", "40"]
        browser.evaluate(f"({sort}).tHead.rows[0].cells[1].querySelector('button').focus()")
        browser.press("Enter", 13)
        assert browser.evaluate(column) == ["1", "1", "9", "9", "10", "10", "40", "40"]
        assert (
            browser.evaluate(f"({sort}).tHead.rows[0].cells[1].getAttribute('aria-sort')")
            == "ascending"
        )
        browser.press("Enter", 13)
        assert browser.evaluate(column) == ["40", "40", "10", "10", "9", "9", "1", "1"]
        browser.press("Enter", 13)
        assert browser.evaluate(column) == unsorted
        browser.evaluate(f"({sort}).tHead.rows[0].cells[4].querySelector('button').focus()")
        browser.press("Enter", 13)
        states = browser.evaluate(f"[...({sort}).tBodies[0].rows].map((r) => r.cells[3].innerText)")
        assert states[-2:] == ["failed", "missing"]  # blank values last
        assert browser.complaints() == []
        asked = {url for url in browser.requests() if not url.startswith("data:")}
        assert asked == {(tmp_path / "report.html").as_uri()}


def test_on_paper(runs, tmp_path):
    """When printed, all sections are unfolded and no table is wider than the page; afterwards the
    page is unchanged.
    """
    write_report(runs, tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), 1200)
        folded = "document.querySelectorAll('details:not([open])').length"
        before = browser.evaluate(folded)
        assert before > 0
        browser.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert browser.evaluate(folded) == 0
        zooms = browser.evaluate(
            "[...document.querySelectorAll('table')].map((t) => parseFloat(t.style.zoom))"
        )
        assert min(zooms) < 1 and max(zooms) == 1  # wide tables alone are made smaller
        browser.evaluate("dispatchEvent(new Event('afterprint'))")
        assert browser.evaluate(folded) == before
        assert (
            browser.evaluate("[...document.querySelectorAll('table')].every((t) => !t.style.zoom)")
            is True
        )
        assert browser.complaints() == []


@pytest.mark.parametrize("alone", [True, False])
def test_a_wide_figure_has_the_whole_row(tmp_path, alone):
    """A two-column figure has the font size of the page, whether it is alone in its gallery or not;
    other figures share a row.
    """
    run = write_run(tmp_path / "run", figures=False)
    (run / "figures").mkdir()
    sizes = {"target": (2100, 1300)} | (
        {} if alone else {"impactor_velocity": (1020, 1080), "probes": (1020, 700)}
    )
    for name, size in sizes.items():
        Image.new("RGB", size, "white").save(run / "figures" / f"{name}.png", dpi=(300, 300))
    write_report([run], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), 1200)
        gallery = browser.evaluate("document.querySelector('#figures .gallery').clientWidth")
        width = "document.querySelector('#figures img[alt^=\"{}\"]').clientWidth"
        assert (
            browser.evaluate(width.format("Force on the target with and without")) > 0.9 * gallery
        )
        if not alone:
            assert (
                browser.evaluate(width.format("Velocity of the impacted or loaded sphere"))
                < 0.5 * gallery
            )
            tops = "[...document.querySelectorAll('#figures figure')].map((f) => f.offsetTop)"
            assert len(set(browser.evaluate(tops))) == 2


def test_the_browser_test_would_notice(tmp_path):
    """A page with a request and an error message is detected by the same check."""
    page = tmp_path / "bad.html"
    page.write_text(
        "<body><img src='http://127.0.0.1:9/x.png'><p style='width:2000px'>x</p><script>nope()</script>"
    )
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open(page.as_uri(), 390)
        assert browser.evaluate("document.documentElement.scrollWidth") > 390
        assert any("nope" in complaint for complaint in browser.complaints())
        assert any("127.0.0.1:9" in url for url in browser.requests())


@pytest.fixture(scope="module")
def tolerances(tmp_path_factory) -> Path:
    """Scan with the files written by the driver: packings hit at two velocities, with friction and
    without.
    """
    points = grid(load__velocity=[2.0, 5.0], contact__friction=[0.0, 0.1, 0.2])
    scan = write_scan(tmp_path_factory.mktemp("scans") / "tolerances", points, study=["tolerance"])
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        values = (float(v) for v in point.labels.values())
        velocity, friction = values
        force = {"wall_peak_force_N": 300 * velocity * (1 - friction * velocity / 10)}
        path.write_text(json.dumps(json.loads(path.read_text()) | force))
    draw_scan_figures(ScanResult(scan), pdf=False)
    draw_studies(studies_of(read_inputs([scan], scan)), scan)
    assert len(list((scan / FIGURES_DIRECTORY).glob("tolerances*.png"))) == 2
    return scan


@pytest.fixture(scope="module")
def kinds(tmp_path_factory) -> list[Path]:
    """Packing with its figures, chain with a bar, target below a packing."""
    folder = tmp_path_factory.mktemp("runs")
    packing = synthetic.write_run(folder / "packing", synthetic.make_case())
    analyse(packing)
    bar = {"length": 0.4, "area": 127e-6, "elements": 20, "material": "steel"}
    run_case(
        case_of(6, load=PULSE, bar=bar, run={"end_time": 4e-5, "frames": 3}),
        folder / "chain",
        figures=False,
    )
    plate = {"bottom": {"plate": {"mass": 0.5, "stiffness": 1e8}, "material": "steel"}}
    target = synthetic.make_case(boundary=plate, run={"end_time": 1e-4, "frames": 3})
    run_case(target, folder / "target", figures=False)
    return [folder / name for name in ("packing", "chain", "target")]


def parts(blocks: Sequence[Block]) -> Iterator[Block | Figure]:
    """Blocks and figures, including those of groups."""
    for block in blocks:
        yield block
        if isinstance(block, Group):
            yield from parts(block.blocks)
        elif isinstance(block, Gallery):
            yield from block.figures


def repeated(report: Report) -> dict[str, list[object]]:
    """Find the parts that a report shows twice, by their kind."""
    everything = [part for section in report.sections for part in parts(section.blocks)]
    figures, tables, groups, notes = (
        [part for part in everything if isinstance(part, kind)]
        for kind in (Figure, DocumentTable, Group, Note)
    )
    verdicts = [section for section in report.sections if section.slug == "verdict"]
    said = {id(part) for section in verdicts for part in parts(section.blocks)}  # one per packing
    assert figures and tables and notes
    found: dict[str, list[object]] = {
        "pictures": [figure.png for figure in figures],
        "data of pictures": [figure.data.href for figure in figures if figure.data],
        "captions": [figure.caption for figure in figures],
        "headings": [*(section.title for section in report.sections), *(group.title for group in groups),
                     *(table.caption for table in tables if table.captioned)],
        "tables": [(table.caption, table.columns, table.rows) for table in tables],
        "notes": [note.text for note in notes if id(note) not in said],
    }  # fmt: skip
    return {
        kind: [one for one, n in Counter(shown).items() if n > 1] for kind, shown in found.items()
    }


def test_report_of_a_scan(tolerances):
    """Figures of studies are also files; the studies show them together with their packing."""
    report = build([tolerances], tolerances)
    assert not any(repeated(report).values()), repeated(report)
    figures = [
        part
        for section in report.sections
        for part in parts(section.blocks)
        if isinstance(part, Figure)
    ]
    against = [
        figure for figure in figures if figure.caption.startswith("Against friction coefficient")
    ]
    assert [figure.caption.partition(" (")[2][:6] for figure in against] == ["2 m/s)", "5 m/s)"]
    assert all(figure.data for figure in against)


def test_report_of_everything(tolerances, kinds, tmp_path):
    inputs = [*kinds, tolerances, next((tolerances / "points").iterdir())]
    report = build(inputs, tmp_path)
    assert {"Verdict", "Studies", "Figures"} <= {section.title for section in report.sections}
    assert not any(repeated(report).values()), repeated(report)


def refused(directories, output) -> list[str]:
    with pytest.raises(InputError) as error:
        write_report(directories, output)
    return error.value.errors


def test_studies_that_do_not_exist(runs, tmp_path):
    with pytest.raises(
        InputError, match=r"--study: found tolerence, expected one of: .*tolerance"
    ) as error:
        write_report(runs, tmp_path / "r.md", ["tolerence", "protected-height"])
    assert len(error.value.errors) == 1
    assert not list(tmp_path.glob("r*"))


def test_all_faults_at_once_and_nothing_written(runs, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("x")
    (runs[1] / "summary.json").unlink()
    (runs[0] / "summary.json").write_text("{")
    before = sorted(tmp_path.rglob("*"))
    given = [
        tmp_path / "nowhere",
        tmp_path / "empty",
        tmp_path / "other",
        *runs[:2],
        tmp_path,
        runs[0] / "case.toml",
    ]
    errors = refused(given, tmp_path / "there" / "r.doc")
    assert len(errors) == 9, errors
    for part in (
        "found the suffix .doc, expected .html, .pdf or .md",
        "does not exist; create it first",
        "nowhere: no such directory",
        "empty: is neither a run nor a scan: it is empty",
        "it holds notes.txt; expected summary.json or scan.json",
        f"cannot be read (Expecting property name enclosed in double quotes: line 1 column 2 (char 1)); recreate it with  granwave analyse {runs[0]}",
        f"a run without summary.json; make it with  granwave analyse {runs[1]}",
        "but contains some (first, scan, second); use these directories",
        "is a file, expected the directory",
    ):
        assert any(part in fault for fault in errors), (part, errors)
    assert sorted(tmp_path.rglob("*")) == before


def test_unfinished_run_and_damaged_scans(runs, tmp_path):
    (runs[0] / "summary.json").unlink()
    write_json(runs[0] / "run.json", {"state": "interrupted"})
    assert "--resume" in refused([runs[0]], tmp_path / "r.html")[0]
    for content in (
        "{",
        "[]",
        '{"name": "a", "case": "b", "varied": [], "points": [{}]}',
        '{"name": 1}',
    ):
        (runs[2] / "scan.json").write_text(content)
        assert "scan.json" in refused([runs[2]], tmp_path / "r.html")[0]


def test_failure_while_writing_keeps_the_old_report(runs, tmp_path, monkeypatch):
    output = write_report(runs[:1], tmp_path / "r.html")
    before = output.read_bytes()

    def full(self, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(RunError, match="No space left"):
        write_report(runs, output)
    monkeypatch.undo()
    assert output.read_bytes() == before
    assert not list(tmp_path.glob(".r.html*"))


def test_a_report_of_runs_that_share_nothing_is_written_anew(runs, tmp_path):
    report = tmp_path / "r.md"
    report.write_text("# Report: bar, chain, driven and 5 more\n\n8 runs.\n\n")
    assert "8 runs." not in write_report(runs, report).read_text()
