"""First section of a report: main sentence, figure and table."""

from __future__ import annotations

import json
import shutil

import pytest

from granwave.analysis.document.model import Beside, DocumentTable, Figure, Group, Note, Report
from granwave.analysis.reports.answer import answer_blocks, main_figures
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import write_report
from granwave.analysis.reports.studies import leads, verdicts
from granwave.analysis.scans.figures import draw_scan_figures
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.studies.study import Row, Study
from tests.helpers.made_up.synthetic_report import NASTY, blocks, build, draw, write_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan
from tests.helpers.programs.chromium import Browser

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)


def scan_with(directory, points, share, **more):
    """Scan whose dissipated fraction is a function of the labels, and whose forces hardly vary."""
    scan = write_scan(directory, points, **more)
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        if path.exists():
            own = {
                "dissipated_fraction": share(point.labels),
                "peak_force_N": 100 + point.labels.get("load.velocity", 0.0),
            }
            path.write_text(json.dumps(json.loads(path.read_text()) | own))
    return scan


def answer(report: Report) -> tuple[str, Beside | None]:
    section = report.sections[0]
    texts = [
        block.text for block in section.blocks if isinstance(block, Note) and block.tone == "lead"
    ]
    shown = [block for block in section.blocks if isinstance(block, Beside)]
    return (texts[0] if texts else ""), (shown[0] if shown else None)


POINTS = grid(load__velocity=[1, 2, 10], contact__friction=[0.0, 0.3])


@pytest.mark.parametrize(
    ("share", "said"),
    [
        (lambda p: 0.5 + 0.01 * p["load.velocity"] + p["contact.friction"],
         "from 0.51 (impact velocity 1 m/s, friction coefficient 0) to 0.9 (impact velocity 10 m/s, friction coefficient "
         "0.3). It rises with impact velocity and friction coefficient."),
        (lambda p: 0.5 + 0.01 * p["load.velocity"] - p["contact.friction"],
         "It rises with impact velocity, falls with friction coefficient."),
        (lambda p: 0.5 + 0.01 * p["load.velocity"] * (1 - 4 * p["contact.friction"]), "friction coefficient 0)."),
    ],
)  # fmt: skip
def test_sentence_of_a_scan(tmp_path, share, said):
    scan = scan_with(tmp_path / "scan", POINTS, share)
    text, _ = answer(build([scan], tmp_path))
    assert text.startswith("Dissipated fraction: from ") and said in text
    assert ("It rises" in text) == ("It rises" in said)


def test_table_and_figure_of_a_scan(tmp_path):
    scan = scan_with(
        tmp_path / "scan", POINTS, lambda p: 0.5 + 0.01 * p["load.velocity"], missing=[6]
    )
    draw_scan_figures(scan, pdf=False)
    report = build([scan], tmp_path)
    _, shown = answer(report)
    assert [column.heading for column in shown.table.columns][:3] == [
        "Impact velocity", "Friction coefficient", "Dissipated fraction",
    ]  # fmt: skip
    assert [row[2].value for row in shown.table.rows] == pytest.approx(
        [0.51, 0.51, 0.52, 0.52, 0.6]
    )
    assert shown.table.columns[3].meaning or shown.table.columns[2].meaning is not None
    (figure,) = shown.gallery.figures
    assert figure.caption == "Dissipated fraction against impact velocity"
    figures = next(section for section in report.sections if section.slug == "figures")
    names = [one.name for block in figures.blocks for one in block.figures]
    assert names and not any(
        "dissipated-fraction-vs-load-velocity" in name for name in names
    )  # shown once
    assert any(
        "1 of 6 points is missing" in block.text
        for block in report.sections[0].blocks
        if isinstance(block, Note)
    )


def test_many_points_of_two_keys_are_crossed(tmp_path):
    points = grid(load__velocity=[1, 2, 3, 4, 5, 6, 7, 8], contact__friction=[0.0, 0.1, 0.3])
    scan = scan_with(
        tmp_path / "scan", points, lambda p: 0.5 + 0.01 * p["load.velocity"] + p["contact.friction"]
    )
    draw_scan_figures(scan, pdf=False)
    _, shown = answer(build([scan], tmp_path))
    assert [column.heading for column in shown.table.columns] == ["Impact velocity"] + [
        f"Friction coefficient {value}" for value in ("0", "0.1", "0.3")
    ]
    assert [cell.text for cell in shown.table.rows[7]] == ["8", "0.58", "0.68", "0.88"]


def test_means_over_seeds(tmp_path):
    points = grid(load__velocity=[1, 2], packing__seed=[1, 2, 3])
    scan = scan_with(
        tmp_path / "scan", points, lambda p: 0.3 * p["load.velocity"] + 0.05 * p["packing.seed"]
    )
    draw_scan_figures(scan, pdf=False)
    text, shown = answer(build([scan], tmp_path))
    assert "from 0.40 ± 0.12 (impact velocity 1 m/s) to 0.70 ± 0.12 (impact velocity 2 m/s)" in text
    assert (
        shown.table.caption == "Means of 3 replicates, with 95 % confidence intervals"
        and len(shown.table.rows) == 2
    )


def test_means_that_the_end_of_a_run_limits_are_marked(tmp_path):
    """The dissipated fraction of the first point still grows at its end."""
    points = grid(load__velocity=[1, 2, 3])
    scan = scan_with(tmp_path / "scan", points, lambda p: 0.1 * p["load.velocity"])
    path = ScanResult(scan).points[0].directory / "summary.json"
    summary = json.loads(path.read_text()) | {"incomplete_values": ["dissipated_fraction"]}
    path.write_text(json.dumps(summary))
    draw_scan_figures(scan, pdf=False)
    _, shown = answer(build([scan], tmp_path))
    assert shown.table.caption == "All points. † still changes at the end of the run"
    assert [row[1].text for row in shown.table.rows] == ["0.1 †", "0.2", "0.3"]


def test_the_force_on_the_bottom_leads_where_zones_are_limited(tmp_path):
    """Sentence, figure and first column are of the force, the yielded spheres come last."""
    points = grid(packing__diameter_scatter=[0, 2e-6, 5e-6])
    scan = scan_with(
        tmp_path / "scan", points, lambda p: 0.87 + 1e3 * p["packing.diameter_scatter"]
    )
    for point in ScanResult(scan).points:
        path = point.directory / "summary.json"
        scatter = point.labels["packing.diameter_scatter"]
        more = {
            "wall_peak_force_N": 1869.0 - 1.8e8 * scatter,
            "n_plastic_spheres": 536 - round(1e7 * scatter),
            "zone_cut": ["bottom", "sides"],
        }
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    draw_scan_figures(scan, pdf=False)
    text, shown = answer(build([scan], tmp_path))
    assert text.startswith(
        "Peak force on the bottom: from 969 N (diameter scatter 5 µm) to 1.869 kN"
    )
    headings = [column.heading for column in shown.table.columns]
    assert headings[1:3] == ["Peak force on the bottom", "Dissipated fraction"]
    assert headings[3] == "Yielded spheres"
    (figure,) = shown.gallery.figures
    assert figure.caption == "Peak force on the bottom against diameter scatter"


def test_one_run(tmp_path):
    run = write_run(
        tmp_path / "run", energy_input_J=2.0, dissipated_fraction=0.8731, peak_force_N=696.84
    )
    report = build([run], tmp_path)
    text, shown = answer(report)
    assert text.startswith(
        "87.3 % of the input energy of 2 J was dissipated. The largest force between two spheres was 696.8 N."
    )
    rows = {row[0].text: row for row in shown.table.rows}
    assert (
        rows["Peak contact force, excluding walls"][1].value == 696.84
        and rows["Peak contact force, excluding walls"][2].text == "N"
    )
    assert any(row[0].meaning for row in shown.table.rows)
    elastic = write_run(tmp_path / "elastic", energy_input_J=2.0, dissipated_fraction=0.0)
    text = answer(build([elastic], tmp_path))[0]
    assert not text.startswith("0 %")
    assert "None of the input energy of 2 J was dissipated." in text


def test_several_runs(tmp_path):
    """The first section is the comparison of the runs."""
    runs = [write_run(tmp_path / f"r{v}", figures=False, load__velocity=v) for v in (1, 2, 4)]
    sentence, *others = blocks(build(runs, tmp_path), "short")
    assert sentence.tone == "lead" and sentence.text.startswith("The main results differ most in ")
    values, cases, *_ = [block for block in others if not isinstance(block, Note)]
    headings = [column.heading for column in values.columns]
    assert headings == ["Quantity", "Unit", "r1", "r2", "r4", "Largest / smallest"]
    (row,) = cases.rows
    assert [cell.text for cell in row] == ["load.velocity", "1 m/s", "2 m/s", "4 m/s"]


def test_a_study_speaks_for_its_scan(tmp_path):
    """The sentence and the figure at the top come from a study with a verdict."""
    scan = scan_with(tmp_path / "scan", POINTS, lambda p: 0.5 + 0.01 * p["load.velocity"])
    inputs = read_inputs([scan], tmp_path)
    assert [type(block) for block in answer_blocks(inputs)] == [Note, DocumentTable]
    assert [type(block) for block in answer_blocks(inputs, judged=True)] == [DocumentTable]
    picture = Figure("answer-study", "Study", "Study", b"", (2, 1))
    (shown,) = answer_blocks(inputs, picture, judged=True)
    assert shown.gallery.figures == (picture,) and main_figures(inputs, picture) == set()


@pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)"
)
def test_on_the_first_screen(tmp_path):
    """The main result is on the first screen; tables can be copied and figures enlarged; the dark
    mode has light letters.
    """
    scan = scan_with(tmp_path / "scan", POINTS, lambda p: 0.5 + 0.01 * p["load.velocity"])
    draw_scan_figures(scan, pdf=False)
    draw(scan, NASTY.replace("/", "-")[:20])
    write_report([scan], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open((tmp_path / "report.html").as_uri(), 1200)
        bottom = "document.querySelector('.beside').getBoundingClientRect().bottom"
        assert browser.evaluate(bottom) < 800
        browser.evaluate("window.scrollTo(0, 2000)")
        assert (
            0 <= browser.evaluate("document.querySelector('nav').getBoundingClientRect().top") < 100
        )
        copied = "navigator.clipboard.writeText = (text) => { window.copied = text; return Promise.resolve(); }"
        browser.evaluate(f"{copied}; document.querySelector('.beside .copy').click()")
        lines = browser.evaluate("window.copied").splitlines()
        assert len(lines) == 1 + len(POINTS) and lines[1].startswith("1,0,0.51")
        browser.evaluate("document.querySelector('.beside img').click()")
        assert browser.evaluate("document.getElementById('enlarged').open") is True
        browser.press("Escape", 27)
        assert browser.evaluate("document.getElementById('enlarged').open") is False
        assert browser.complaints() == []


def test_nothing_varies_in_a_scan_so_nothing_is_drawn(tmp_path):
    """The first section omits the constant figure and its table; the figure remains among the
    others.
    """
    scan = scan_with(tmp_path / "scan", grid(load__velocity=[1, 2]), lambda _: 0.5)
    draw_scan_figures(scan, pdf=False)
    report = build([scan], tmp_path)
    text, shown = answer(report)
    assert (shown is None) == text.endswith("at all points.")


def test_scans_of_a_suite(tmp_path):
    """The report has the name of the suite; of many scans the first is shown and the others are
    folded.
    """
    names = [f"scan-{n}" for n in range(5)]
    for name in names:
        scan_with(
            tmp_path / "suite" / name,
            grid(load__velocity=[1, 2]),
            lambda p: 0.1 * p["load.velocity"],
        )
    (tmp_path / "suite" / "suite.json").write_text(
        json.dumps({"name": "all-of-it", "scans": names})
    )
    report = build([tmp_path / "suite"], tmp_path / "suite")
    assert report.title == "Report: all-of-it"
    blocks = report.sections[0].blocks
    (group,) = (block for block in blocks if isinstance(block, Group))
    assert group.folded and group.title == "Main quantity of the other 4 scans"
    said = [block.text for block in group.blocks if isinstance(block, Note)]
    assert [text.partition(":")[0] for text in said] == [f"Scan {name}" for name in names[1:]]
    text = write_report([tmp_path / "suite"], tmp_path / "suite" / "report.md").read_text(
        encoding="utf-8"
    )
    assert (
        text.startswith("# Report: all-of-it\n")
        and "### Main quantity of the other 4 scans" in text
    )


def test_agreement_with_the_sources():
    values = [(1.0, 1.01), (1.0, 1.05), (1.0, 1.5), (None, 7.0)]
    rows = tuple(
        Row(f"Quantity {n}", "", source, ours, "1.1") for n, (source, ours) in enumerate(values, 1)
    )
    (lead,) = leads([Study("study", "Study", "", rows)])
    assert (lead.text, lead.tone) == (
        "Of 3 values of the sources, granwave agrees within 2 % for 1 and within 10 % for 2; "
        "the largest difference is 50 % "
        "(quantity 3).", "lead",
    )  # fmt: skip
    assert leads([Study("study", "Study", "", rows[3:])]) == ()


def test_verdicts_begin_a_report_and_are_said_once():
    one, two = (
        Study(name, f"Title {name}", "", verdict=(f"First of {name}.", "Second."))
        for name in ("a", "b")
    )
    assert [note.text for note in leads([one])] == ["First of a."]
    assert [note.text for note in leads([one, two])] == [
        "Title a: First of a.",
        "Title b: First of b.",
    ]
    assert [[part.text for part in group.blocks] for group in verdicts([one, two])] == [
        ["Second."],
        ["Second."],
    ]
    many = [one] * 4
    assert leads(many) == () and len(verdicts(many)[0].blocks) == 2


def test_a_run_that_ends_before_its_load_begins(tmp_path):
    """Without yielding and energy input, no zone is reported, and a reason is given for the missing
    energy balance.
    """
    write_run(
        tmp_path / "late",
        energy_input_J=0.0,
        energy_balance_error=None,
        zone_depth_90_m=0.0,
        zone_radius_90_m=0.0,
    )
    page = write_report([tmp_path / "late"], tmp_path / "late.md").read_text()
    assert "No energy input before the end: late." in page
    assert "90 % of the energy of yielding" not in page
