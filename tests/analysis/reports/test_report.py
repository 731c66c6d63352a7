"""Contents of a report: statements on runs, scans and continuum runs, and figures."""

from __future__ import annotations

import dataclasses
import json

import pytest

from granwave.analysis.document.model import (
    DocumentTable,
    Figure,
    Gallery,
    Note,
    cleaned,
    named,
    percent,
    show,
)
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.quantities import quantity
from granwave.analysis.reports import figures
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.case.run import BALANCE_TOLERANCE
from granwave.lammps_inputs.case.run import RunSettings as CaseRun
from tests.helpers.made_up.synthetic_report import (
    blocks,
    build,
    draw,
    notes,
    table,
    write_inputs,
    write_run,
)
from tests.helpers.made_up.synthetic_scan import grid, write_json, write_scan


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    return write_inputs(tmp_path)


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """Inputs that no test changes, and their report."""
    place = tmp_path_factory.mktemp("both")
    found = write_inputs(place)
    return found, build(found, place)


@pytest.mark.needs_extension("continuum")
def test_sections_and_order_of_the_inputs(both):
    inputs, report = both
    slugs = [section.slug for section in report.sections]
    assert slugs == ["short", "comparison", "figures", "failures", "results", "balance", "inputs"]
    for directories in (inputs, inputs[::-1]):
        rows = table(build(directories, inputs[0].parent), "inputs", "Contents of this report")
        assert [row["Name"].text for row in rows] == [path.name for path in directories]
    assert report.lead == (
        "2 runs and 1 scan with 6 of 8 points done: first (fcc 24 × 24 × 12, brass, 10 mm, 5 m/s, ideal); second (fcc "
        "24 × 24 × 12, brass, 10 mm, 10 m/s, ideal); scan (fcc 24 × 24 × 12, 10 mm, ideal; load.velocity, material "
        "varied)."
    )
    tables = [
        block
        for slug in slugs
        for block in blocks(report, slug)
        if isinstance(block, DocumentTable)
    ]
    assert all(len(row) == len(one.columns) for one in tables for row in one.rows)


def test_scan_table_has_the_varied_keys_first_and_every_status(both):
    (_, _, scan), report = both
    part = next(
        b
        for b in blocks(report, "results")
        if isinstance(b, DocumentTable) and b.caption == "Scan scan"
    )
    heads = ["#", "load.velocity", "material", "Status", quantity("dissipated_fraction").label]
    assert [column.heading for column in part.columns][:5] == heads and part.columns[
        1
    ].unit == "m/s"
    rows = table(report, "results", "Scan scan")
    assert [row["#"].text for row in rows] == [str(n) for n in range(1, 9)]
    assert [row["Status"].text for row in rows] == [
        "done",
        "done",
        "failed",
        "done",
        "done",
        "done",
        "done",
        "missing",
    ]
    assert rows[0]["load.velocity"].value == 10.0
    summary = json.loads(next((scan / "points").glob("*/summary.json")).read_text())
    assert any(
        row["Peak contact force, excluding walls"].value == pytest.approx(summary["peak_force_N"])
        for row in rows
    )
    assert rows[2]["Peak contact force, excluding walls"].text == ""  # for a failed point


def test_failed_and_missing_points_say_why(both):
    _, report = both
    failed, missing = table(report, "failures", "Scan scan: points that are not done")
    assert (failed["#"].text, failed["Status"].text, failed["Attempts"].text) == (
        "3",
        "failed",
        "2",
    )
    assert failed["Why"].text == "the disk is full\nno space left"
    assert failed["Directory"].text.startswith("scan/unfinished/")
    assert (missing["#"].text, missing["Why"].text) == ("8", "not started")
    assert notes(report, "short")[0].tone == "bad"
    assert any("1 of 8 points failed" in note.text for note in notes(report, "short"))


def test_damaged_summary_of_a_point_is_told(runs, tmp_path):
    for name, content in (("[1]", "[1]"), ("cut", '{"name": ')):
        scan = write_scan(tmp_path / name, grid(load__velocity=[1, 2]))
        next((scan / "points").glob("*/summary.json")).write_text(content)
        (row,) = table(
            build([scan], tmp_path), "failures", f"Scan {name}: points that are not done"
        )
        assert "damaged" in row["Why"].text and "granwave analyse" in row["Why"].text


def test_scan_without_a_finished_point(tmp_path):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2]), missing=[1, 2])
    report = build([scan], tmp_path)
    assert report.lead == "1 scan with 0 of 2 points done: load.velocity varied."
    for suffix in ("html", "pdf", "md"):
        write_report([scan], tmp_path / f"r.{suffix}")


@pytest.mark.parametrize(
    ("error", "text", "tone"),
    [
        (9e-7, "good", "good"),
        (2.1e-6, "good", "good"),
        (9.9e-6, "good", "good"),
        (1.1e-5, "too large: above 1e-5", "bad"),
        (float("nan"), "too large: above 1e-5", "bad"),
        (None, "not known", "note"),
    ],
)
def test_energy_balance(tmp_path, error, text, tone):
    run = write_run(tmp_path / "run", figures=False, energy_balance_error=error)
    report = build([run], tmp_path)
    (row,) = table(report, "balance", "Energies at the end, and the error of the balance")
    assert (row["Balance"].text, row["Balance"].tone) == (text, tone)
    warned = [note.tone for note in notes(report, "short")]
    assert warned == ([tone] if tone != "good" else ["good"])


@pytest.mark.parametrize(
    ("error", "badge"),
    [
        (9e-7, ("energy balance closed", "good", "")),
        (1.1e-5, ("energy balance open", "bad", "balance")),
        (None, ("energy balance unknown", "note", "balance")),
    ],
)
def test_badges_show_states_and_lead_to_their_sections(tmp_path, error, badge):
    changes = {"energy_balance_error": error, "contacts_beyond_law": 3, "zone_cut": ["bottom"]}
    run = write_run(tmp_path / "run", figures=False, **changes)
    badges = [dataclasses.astuple(one) for one in build([run], tmp_path).badges]
    assert badges == [
        ("finished", "good", ""),
        badge,
        ("contacts beyond the law", "note", "balance"),
        ("boundaries influence the plastic zone", "note", "results"),
    ]


def test_a_collision_of_two_spheres_has_no_badge_of_its_zone(tmp_path):
    """A zone without boundaries is neither clear of them nor limited by them."""
    run = write_run(tmp_path / "run", figures=False, n_spheres=2, zone_cut=["bottom"])
    texts = [badge.text for badge in build([run], tmp_path).badges]
    assert not any("plastic zone" in text for text in texts)


def test_badges_of_several_runs_count(both):
    texts = [badge.text for badge in both[1].badges]
    assert "not finished: 2 of 10" in texts and "energy balance unknown: 6 of 8" in texts


@pytest.mark.parametrize(
    ("error", "text", "tone"),
    [
        (9e-6, "good", "good"),
        (3e-4, "accepted: at most 0.001, run.energy_tolerance", "good"),
        (2e-3, "too large: above 0.001", "bad"),
    ],
)
def test_the_accepted_error_is_that_of_the_run(tmp_path, error, text, tone):
    """The balance of an accepted run is not called poor, also if only the case states the limit."""
    recorded = write_run(
        tmp_path / "new",
        figures=False,
        energy_balance_error=error,
        energy_balance_accepted=1e-3,
    )
    earlier = write_run(
        tmp_path / "earlier",
        figures=False,
        energy_balance_error=error,
        run__energy_tolerance=1e-3,
    )
    for run in (recorded, earlier):
        report = build([run], tmp_path)
        (row,) = table(report, "balance", "Energies at the end, and the error of the balance")
        assert (row["Balance"].text, row["Balance"].tone) == (text, tone)
        assert row["Accepted error"].value == 1e-3
        assert any("do not use" in note.text for note in notes(report, "short")) == (tone == "bad")


def test_runs_of_other_accepted_errors_have_notes_of_their_own(tmp_path):
    strict = write_run(tmp_path / "strict", figures=False, energy_balance_error=5e-3)
    loose = write_run(
        tmp_path / "loose",
        figures=False,
        energy_balance_error=5e-3,
        energy_balance_accepted=1e-3,
    )
    texts = [note.text for note in notes(build([strict, loose], tmp_path), "short")]
    assert any("more than 1e-5): strict." in text for text in texts)
    assert any("more than 0.001): loose." in text for text in texts)


def test_a_run_without_a_record_is_judged_by_the_limit_of_its_case():
    assert CaseRun().accepted_balance_error == BALANCE_TOLERANCE
    assert CaseRun(energy_tolerance=1e-3).accepted_balance_error == 1e-3


def test_contacts_beyond_the_law_and_a_refused_run_are_told(tmp_path):
    run = write_run(
        tmp_path / "run", figures=False, contacts_beyond_law=3, energy_balance_error=3e-5
    )
    write_json(run / "run.json", {"state": "refused", "reason": "the balance missed by 3e-5"})
    report = build([run], tmp_path)
    texts = [note.text for note in notes(report, "short")]
    assert any(
        "beyond the range of the law" in text and "run (refused) (3)" in text for text in texts
    )
    assert any("3e-5" in note.text and note.tone == "bad" for note in notes(report, "failures"))
    assert table(report, "inputs", "Contents of this report")[0]["Status"].text == "refused"


@pytest.mark.parametrize(
    "reason", ["energy balance refused", "refused"]
)  # of spheres, of finite elements
def test_refused_runs_are_marked_and_not_compared(tmp_path, reason):
    """This includes runs without a run.json, such as blocks."""
    runs = [write_run(tmp_path / name, figures=False, **values) for name, values in
            (("good", {}), ("bad", {"end_reason": reason}))]  # fmt: skip
    report = build(runs, tmp_path)
    assert blocks(report, "short")[0].tone == "bad"  # before the comparison
    assert any(
        "energy balance error too large: bad (refused)" in note.text and note.tone == "bad"
        for note in notes(report, "short")
    )


def test_two_runs_side_by_side(runs, tmp_path):
    report = build(runs[:2], tmp_path)
    row = {row["Quantity"].text: row for row in table(report, "results", "Values side by side")}[
        "Energy input"
    ]
    values = [json.loads((run / "summary.json").read_text())["energy_input_J"] for run in runs[:2]]
    assert [row["first"].value, row["second"].value] == pytest.approx(values)
    assert row["Difference"].value == pytest.approx(300.0) and row["Difference"].text == "+300 %"
    (shown,) = [block for block in blocks(report, "short") if isinstance(block, Gallery)][:1]
    assert shown.figures[0].caption.startswith(
        "Kinetic, elastic and dissipated energy against time, relative to the input."
    )
    assert list(table(report, "results", "Runs")[0])[1] == "load.velocity"


def test_many_runs_have_one_table(tmp_path):
    paths = [write_run(tmp_path / f"r{v}", figures=False, load__velocity=v) for v in range(1, 9)]
    report = build(paths, tmp_path)
    captions = [
        block.caption
        for block in blocks(report, "results")
        if isinstance(block, DocumentTable) and block.captioned
    ]
    assert captions == ["Runs"] and len(table(report, "results", "Runs")) == 8


def test_damaged_result_file_leaves_a_note(runs, tmp_path):
    (runs[1] / "result.h5").write_bytes(b"no")
    texts = [note.text for note in notes(build(runs[:2], tmp_path), "short")]
    assert any("second" in text and "result.h5" in text for text in texts)


def test_replicates_have_mean_and_confidence(tmp_path):
    points = [{"load.velocity": v, "packing.seed": s} for v in (1, 2) for s in (1, 2, 3)]
    scan = tmp_path / "scan"
    write_scan(scan, [{"load.velocity": p["load.velocity"]} for p in points], missing=range(1, 7))
    index = json.loads((scan / "scan.json").read_text()) | {
        "varied": ["load.velocity", "packing.seed"]
    }
    for number, (point, entry) in enumerate(zip(points, index["points"], strict=True)):
        entry |= {"labels": point, "id": f"p{number}"}
        folder = scan / "points" / f"p{number}"
        folder.mkdir(parents=True)
        write_json(
            folder / "summary.json",
            {"dissipated_fraction": 0.5 + 0.1 * point["packing.seed"], "versions": {}},
        )
    write_json(scan / "scan.json", index)
    rows = table(build([scan], tmp_path), "results", "Scan scan: mean and 95 % confidence interval")
    assert [row["Replicates"].text for row in rows] == ["3", "3"]
    assert rows[0]["Dissipated fraction"].text == "0.70 ± 0.25"  # 4.303 x 0.1 / sqrt 3


@pytest.mark.needs_extension("continuum")
def test_versions_common_once_and_differences_by_run(tmp_path):
    """Programs of another kind of run do not count as a difference: continuum runs need no
    LAMMPS.
    """
    several = {
        "first": {"granwave": "1", "lammps": "2"},
        "second": {"granwave": "1", "lammps": "3"},
        "old": {"granwave": "1"},
    }
    runs = [
        write_run(tmp_path / name, figures=False, versions=versions)
        for name, versions in several.items()
    ]
    block = write_run(
        tmp_path / "block", figures=False, versions={"granwave": "1", "numba": "3"}, n_elements=100
    )
    report = build([runs[0], block], tmp_path)
    shared = [row["Program"].text for row in table(report, "inputs", "Versions, the same in all")]
    assert shared == ["granwave", "lammps", "numba"]
    report = build([*runs, block], tmp_path)
    rows = table(report, "inputs", "Versions that differ")
    found = [(row["Program"].text, row["Version"].text, row["Runs"].text) for row in rows]
    assert found == [("lammps", "2", "first"), ("lammps", "3", "second")]


# ---- figures ----


def test_figures_in_a_fixed_order_made_small(both):
    runs, report = both
    gallery = next(block for block in blocks(report, "figures") if isinstance(block, Gallery))
    assert [figure.alt for figure in gallery.figures] == [
        f"{name}: run first"
        for name in (
            "Peak contact force, excluding walls, principal plane",
            "Energies and the error of their balance",
            "Zebra",
        )
    ]
    assert (
        gallery.figures[0].caption
        == f"{gallery.figures[0].alt}. {run_figures()['peak_force_principal'].look}"
    )
    figure = gallery.figures[-1]
    assert figure.size == (900, 45)
    assert (figure.data.text, figure.data.href) == ("figures/zebra.csv", "first/figures/zebra.csv")
    assert figure.alt and len(figure.png) < (runs[0] / "figures" / "zebra.png").stat().st_size


def test_damaged_picture_leaves_a_note(runs, tmp_path):
    (runs[0] / "figures" / "energies.png").write_bytes(b"\x89PNG nothing")
    report = build(runs, tmp_path)
    assert any("energies.png cannot be shown" in note.text for note in notes(report, "figures"))


def test_figures_of_points_stay_within_a_budget(tmp_path, monkeypatch):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2, 3]))
    for point in json.loads((scan / "scan.json").read_text())["points"]:
        draw(scan / "points" / point["id"], "energies")
    monkeypatch.setattr(figures, "POINTS_BUDGET", 1)
    report = build([scan], tmp_path)
    assert len([block for block in blocks(report, "figures") if isinstance(block, Gallery)]) == 1
    assert [link.text for link in notes(report, "figures")[-1].links] == ["#2", "#3"]


# ---- texts and numbers ----


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\u2013"), (True, "yes"), (3, "3"), (0.0, "0"), (1.0919e-6, "1.0919e-6"), (123456.7, "123460"),
        (1.15e11, "1.15e11"), (float("nan"), "not a number"), ([1, 2.5], "[1, 2.5]"), ("x", "x"), (10**400, "1" + "0" * 400),
    ],
)  # fmt: skip
def test_numbers(value, text):
    assert show(value) == text


def test_small_words():
    assert named(["a", "s #1", "s #2", "b"]) == "a, s #1, #2, b"
    assert named(["a", "b", "c"], 2) == "a, b and 1 more"
    assert [percent(x) for x in (0.0, 0.11234, -12.345, 1e-7)] == [
        "0 %",
        "+0.11 %",
        "-12.3 %",
        "+1e-7 %",
    ]


def test_cleaned_replaces_what_formats_cannot_hold():
    assert cleaned(Note("a\x00b\ud800c\n")).text == "a\ufffdb\ufffdc\n"
    figure = Figure("n", "c", "a", b"\x00", (1, 1))
    assert cleaned(figure) == figure


def test_same_names_and_one_directory_twice(tmp_path):
    first = write_run(tmp_path / "a" / "run", figures=False)
    second = write_run(tmp_path / "b" / "run", figures=False)
    inputs = read_inputs([first, second, tmp_path / "a" / ".." / "a" / "run"], tmp_path)
    assert [run.label for run in inputs.runs] == ["a/run", "b/run"]


def test_run_without_a_case_or_record(tmp_path):
    run = write_run(tmp_path / "run", figures=False)
    (run / "case.toml").write_text("broken =")
    (run / "run.json").unlink()
    (run / "result.h5").unlink()
    report = build([run], tmp_path)
    assert any("case.toml" in note.text for note in notes(report, "short"))
