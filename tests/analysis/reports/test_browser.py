"""Report in a browser: no error messages, no network requests, and sortable tables."""

from __future__ import annotations

import shutil

import pytest
from PIL import Image

from granwave.analysis.reports.report import write_report
from tests.helpers.chromium import Browser
from tests.helpers.synthetic_report import nasty_inputs, write_inputs, write_run

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)")


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path)


def test_in_a_browser(runs, tmp_path):
    """No error messages, no requests, no horizontal scrolling on a phone, and tables that can be sorted by keyboard."""
    write_report([*runs, *nasty_inputs(tmp_path / "more")], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        for width in (390, 1200):
            browser.open((tmp_path / "report.html").as_uri(), width)
            browser.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))")
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
            assert browser.evaluate("innerWidth") == width
            wide = "[...document.querySelectorAll('.box')].some((b) => b.scrollWidth > b.clientWidth)"
            assert browser.evaluate(wide) is True  # tables scroll within their own elements
            assert browser.evaluate("[...document.images].every((i) => i.complete && i.naturalWidth > 0)") is True
            assert browser.evaluate("parseFloat(getComputedStyle(document.body).fontSize)") >= 16
        sort = "[...document.querySelectorAll('table.sortable')].find((t) => t.caption?.innerText == 'Scan scan')"
        column = f"[...({sort}).tBodies[0].rows].map((r) => r.cells[1].innerText)"
        unsorted = browser.evaluate(column)
        assert unsorted == ["10", "10", "9", "9", "1", "1", "40", "40"]
        browser.evaluate(f"({sort}).tHead.rows[0].cells[1].querySelector('button').focus()")
        browser.press("Enter", 13)
        assert browser.evaluate(column) == ["1", "1", "9", "9", "10", "10", "40", "40"]
        assert browser.evaluate(f"({sort}).tHead.rows[0].cells[1].getAttribute('aria-sort')") == "ascending"
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
    """Printed, all is unfolded and no table is wider than the page; afterwards it is as before."""
    write_report(runs, tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), 1200)
        folded = "document.querySelectorAll('details:not([open])').length"
        before = browser.evaluate(folded)
        assert before > 0
        browser.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert browser.evaluate(folded) == 0
        zooms = browser.evaluate("[...document.querySelectorAll('table')].map((t) => parseFloat(t.style.zoom))")
        assert min(zooms) < 1 and max(zooms) == 1  # wide tables alone are made smaller
        browser.evaluate("dispatchEvent(new Event('afterprint'))")
        assert browser.evaluate(folded) == before
        assert browser.evaluate("[...document.querySelectorAll('table')].every((t) => !t.style.zoom)") is True
        assert browser.complaints() == []


@pytest.mark.parametrize("alone", [True, False])
def test_a_wide_figure_has_the_whole_row(tmp_path, alone):
    """A two-column figure has the font size of the page, alone in its gallery or not; others share a row."""
    run = write_run(tmp_path / "run", figures=False)
    (run / "figures").mkdir()
    sizes = {"target": (2100, 1300)} | ({} if alone else {"impactor_velocity": (1020, 1080), "probes": (1020, 700)})
    for name, size in sizes.items():
        Image.new("RGB", size, "white").save(run / "figures" / f"{name}.png", dpi=(300, 300))
    write_report([run], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), 1200)
        gallery = browser.evaluate("document.querySelector('#figures .gallery').clientWidth")
        width = "document.querySelector('#figures img[alt^=\"{}\"]').clientWidth"
        assert browser.evaluate(width.format("What reaches")) > 0.9 * gallery
        if not alone:
            assert browser.evaluate(width.format("Velocity of the sphere")) < 0.5 * gallery
            tops = "[...document.querySelectorAll('#figures figure')].map((f) => f.offsetTop)"
            assert len(set(browser.evaluate(tops))) == 2


def test_the_browser_test_would_notice(tmp_path):
    """A page with a request and an error message is detected by the same check."""
    page = tmp_path / "bad.html"
    page.write_text("<body><img src='http://127.0.0.1:9/x.png'><p style='width:2000px'>x</p><script>nope()</script>")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open(page.as_uri(), 390)
        assert browser.evaluate("document.documentElement.scrollWidth") > 390
        assert any("nope" in complaint for complaint in browser.complaints())
        assert any("127.0.0.1:9" in url for url in browser.requests())
