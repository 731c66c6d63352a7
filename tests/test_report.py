"""The report: what it says, that it is the same every time, what it refuses, and how a browser takes it."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image

from granwave.analysis.reports import balance, figures
from granwave.analysis.reports.content import build_report
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.model import Figure, Gallery, Group, Note, Report, Table, cleaned
from granwave.analysis.reports.quantities import MAIN, label_of, named, percent, show
from granwave.analysis.reports.report import write_report
from granwave.analysis.reports.sources import applies, source_values
from granwave.lammps_inputs import load_case, sphere_contact
from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.balance import TOLERANCE
from tests.chromium import Browser
from tests.synthetic_scan import case_of, grid, summary_of, write_json, write_scan

NASTY = "<script>alert(1)</script> & \"q\" 'a' | *b* `c` {{ 7*7 }}"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def write_run(directory: Path, figures: bool = True, name: str = "synthetic", **changes) -> Path:
    """A finished run of brass; `load__velocity=4` in the labels, other words change the summary."""
    labels = {key.replace("__", "."): value for key, value in changes.items() if "__" in key or key == "material"}
    values = {key: value for key, value in changes.items() if "__" not in key and key != "material"}
    case = case_of(labels)
    directory.mkdir(parents=True)
    (directory / "case.toml").write_text(case.to_toml(), encoding="utf-8")
    summary = {"energy_balance_error": 3e-7, "contacts_beyond_law": 0, "timestep_s": 3e-8} | summary_of(case)
    write_json(directory / "summary.json", summary | {"name": name} | values)
    write_json(directory / "run.json", {"state": "finished", "attempts": []})
    with h5py.File(directory / "result.h5", "w") as file:
        time = np.linspace(0, 1e-3, 50)
        file["energy/time"], file["energy/input"] = time, np.full(50, 2.0)
        file["energy/dissipated"] = 1.6 * (1 - np.exp(-time / 1e-4))
    if figures:
        draw(directory, "zebra", "energies", "peak_force_principal")
    return directory


def draw(directory: Path, *names: str) -> None:
    """Pictures of noise, with data for the first."""
    (directory / "figures").mkdir(exist_ok=True)
    pixels = np.random.default_rng(1).integers(0, 255, (40, 60, 3), dtype=np.uint8)
    for name in names:
        Image.fromarray(pixels).resize((1000, 50)).save(directory / "figures" / f"{name}.png")
    (directory / "figures" / f"{names[0]}.csv").write_text("x\n1\n")


@pytest.fixture
def runs(tmp_path):
    """Two runs and a scan in which points failed and are missing."""
    first = write_run(tmp_path / "first")
    second = write_run(tmp_path / "second", figures=False, load__velocity=10)
    points = grid(load__velocity=[10, 9, 1, 40], material=["brass", "steel"])
    scan = write_scan(tmp_path / "scan", points, failed={3: "the disk is full\nno space left"}, missing=[8])
    draw(scan, "dissipated_fraction_vs_load_velocity")
    return [first, second, scan]


def build(directories, base) -> Report:
    return build_report(read_inputs(directories, base))


def blocks(report: Report, slug: str) -> list:
    """Blocks of a section, those of its groups included."""
    section = next(section for section in report.sections if section.slug == slug)
    found = []
    for block in section.blocks:
        found += block.blocks if isinstance(block, Group) else [block]
    return found


def table(report: Report, slug: str, caption: str) -> list[dict]:
    """Rows of a table: cells by heading."""
    part = next(b for b in blocks(report, slug) if isinstance(b, Table) and b.caption == caption)
    return [dict(zip([c.heading for c in part.columns], row, strict=True)) for row in part.rows]


def notes(report: Report, slug: str) -> list[Note]:
    return [block for block in blocks(report, slug) if isinstance(block, Note)]


# ---- what it says ----


def test_sections_and_order_of_the_inputs(runs, tmp_path):
    report = build(runs, tmp_path)
    slugs = [section.slug for section in report.sections]
    assert slugs == ["short", "inputs", "results", "sources", "balance", "failures", "figures"]
    assert [row["Name"].text for row in table(report, "inputs", "What this report is about")] == [
        "first",
        "second",
        "scan",
    ]
    turned = build(runs[::-1], tmp_path)
    assert [row["Name"].text for row in table(turned, "inputs", "What this report is about")] == [
        "scan",
        "second",
        "first",
    ]
    assert report.lead == "2 runs and 1 scan with 6 of 8 points done. SI units."


def test_scan_table_has_the_varied_keys_first_and_every_status(runs, tmp_path):
    report = build(runs, tmp_path)
    part = next(b for b in blocks(report, "results") if isinstance(b, Table) and b.caption == "Scan scan")
    assert [column.heading for column in part.columns][:5] == [
        "#",
        "load.velocity",
        "material",
        "Status",
        label_of(MAIN[0]),
    ]
    assert [column.unit for column in part.columns][1] == "m/s"
    rows = table(report, "results", "Scan scan")
    assert [row["#"].text for row in rows] == [str(n) for n in range(1, 9)]
    assert [row["Status"].text for row in rows] == ["done", "done", "failed", "done", "done", "done", "done", "missing"]
    assert rows[0]["load.velocity"].value == 10.0
    summary = json.loads(next((runs[2] / "points").glob("*/summary.json")).read_text())
    assert any(row["Peak contact force"].value == pytest.approx(summary["peak_force_N"]) for row in rows)
    assert rows[2]["Peak contact force"].text == ""  # of a point that failed


def test_failed_and_missing_points_say_why(runs, tmp_path):
    report = build(runs, tmp_path)
    failed, missing = table(report, "failures", "Scan scan: points that are not done")
    assert (failed["#"].text, failed["Status"].text, failed["Attempts"].text) == ("3", "failed", "2")
    assert failed["Why"].text == "the disk is full\nno space left"
    assert failed["Directory"].text.startswith("scan/unfinished/")
    assert (missing["#"].text, missing["Why"].text) == ("8", "not begun")
    assert notes(report, "short")[0].tone == "bad"
    assert any("1 of 8 points failed" in note.text for note in notes(report, "short"))


def test_damaged_summary_of_a_point_is_told(runs, tmp_path):
    for name, content in (("[1]", "[1]"), ("cut", '{"name": ')):
        scan = write_scan(tmp_path / name, grid(load__velocity=[1, 2]))
        next((scan / "points").glob("*/summary.json")).write_text(content)
        (row,) = table(build([scan], tmp_path), "failures", f"Scan {name}: points that are not done")
        assert "damaged" in row["Why"].text and "granwave analyse" in row["Why"].text


def test_scan_without_a_finished_point(tmp_path):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2]), missing=[1, 2])
    report = build([scan], tmp_path)
    assert report.lead == "1 scan with 0 of 2 points done. SI units."
    for suffix in ("html", "pdf", "md"):
        write_report([scan], tmp_path / f"r.{suffix}")


@pytest.mark.parametrize(
    ("error", "text", "tone"),
    [
        (9e-7, "good", "good"),
        (2.1e-6, "fair: above 2e-6", "note"),
        (1.1e-5, "poor: above 1e-5", "bad"),
        (float("nan"), "poor: above 1e-5", "bad"),
        (None, "not known", "note"),
        ("?", "not known", "note"),
    ],
)
def test_energy_balance(tmp_path, error, text, tone):
    run = write_run(tmp_path / "run", figures=False, energy_balance_error=error)
    report = build([run], tmp_path)
    (row,) = table(report, "balance", "Energies at the end, and the error of the balance")
    assert (row["Balance"].text, row["Balance"].tone) == (text, tone)
    warned = [note.tone for note in notes(report, "short")]
    assert warned == ([tone] if tone != "good" else ["good"])


def test_limit_of_the_balance_is_the_driver_s():
    assert balance.LIMITS["run"][1] == TOLERANCE


def test_contacts_beyond_the_law_are_told(tmp_path):
    run = write_run(tmp_path / "run", figures=False, contacts_beyond_law=3)
    texts = [note.text for note in notes(build([run], tmp_path), "short")]
    assert any("beyond the law" in text and "run (3)" in text for text in texts)


def test_refused_run_is_told(tmp_path):
    run = write_run(tmp_path / "run", figures=False, energy_balance_error=3e-5)
    write_json(run / "run.json", {"state": "refused", "reason": "the balance missed by 3e-5"})
    report = build([run], tmp_path)
    assert any("3e-5" in note.text and note.tone == "bad" for note in notes(report, "failures"))
    assert table(report, "inputs", "What this report is about")[0]["Status"].text == "refused"


def test_two_runs_side_by_side(runs, tmp_path):
    report = build(runs[:2], tmp_path)
    rows = {row["Quantity"].text: row for row in table(report, "results", "Values side by side")}
    values = [json.loads((run / "summary.json").read_text())["energy_input_J"] for run in runs[:2]]
    row = rows["Energy input"]
    assert [row["first"].value, row["second"].value] == pytest.approx(values)
    assert row["Difference"].value == pytest.approx(300.0)
    assert row["Difference"].text == "+300 %"
    (shown,) = [block for block in blocks(report, "results") if isinstance(block, Gallery)]
    assert shown.figures[0].caption == "Dissipated share of the input against time"
    assert [c.heading for c in next(b for b in blocks(report, "results") if b.caption == "Runs").columns][
        1
    ] == "load.velocity"


def test_many_runs_have_one_table(tmp_path):
    paths = [write_run(tmp_path / f"r{v}", figures=False, load__velocity=v) for v in range(1, 9)]
    report = build(paths, tmp_path)
    captions = [block.caption for block in blocks(report, "results") if isinstance(block, Table)]
    assert captions == ["Runs"]
    assert len(table(report, "results", "Runs")) == 8


def test_damaged_result_file_leaves_a_note(runs, tmp_path):
    (runs[1] / "result.h5").write_bytes(b"no")
    texts = [note.text for note in notes(build(runs[:2], tmp_path), "results")]
    assert any("second" in text and "result.h5" in text for text in texts)


def test_replicates_have_mean_and_deviation(tmp_path):
    points = [{"load.velocity": v, "packing.seed": s} for v in (1, 2) for s in (1, 2, 3)]
    scan = tmp_path / "scan"
    write_scan(scan, [{"load.velocity": p["load.velocity"]} for p in points], missing=range(1, 7))
    index = json.loads((scan / "scan.json").read_text()) | {"varied": ["load.velocity", "packing.seed"]}
    for number, (point, entry) in enumerate(zip(points, index["points"], strict=True)):
        entry |= {"labels": point, "id": f"p{number}"}
        folder = scan / "points" / f"p{number}"
        folder.mkdir(parents=True)
        write_json(folder / "summary.json", {"dissipated_fraction": 0.5 + 0.1 * point["packing.seed"], "versions": {}})
    write_json(scan / "scan.json", index)
    rows = table(build([scan], tmp_path), "results", "Scan scan: mean and standard deviation")
    assert [row["Replicates"].text for row in rows] == ["3", "3"]
    assert rows[0]["Dissipated fraction"].text == "0.7 ± 0.1"


def test_versions_common_once_and_differences_by_run(tmp_path):
    first = write_run(tmp_path / "first", figures=False, versions={"granwave": "1", "numpy": "2"})
    second = write_run(tmp_path / "second", figures=False, versions={"granwave": "1", "numpy": "3"})
    report = build([first, second], tmp_path)
    assert [row["Program"].text for row in table(report, "inputs", "Versions, the same in all")] == ["granwave"]
    found = [
        (row["Program"].text, row["Version"].text, row["Runs"].text)
        for row in table(report, "inputs", "Versions that differ")
    ]
    assert found == [("numpy", "2", "first"), ("numpy", "3", "second")]


def test_continuum_run_with_other_keys_and_nulls(tmp_path):
    run = tmp_path / "block"
    run.mkdir()
    (run / "case.toml").write_text(
        "[punch]\ndiameter = 0.010\nvelocity = 10.0\n[material]\nyoungs_modulus = 115e9\nyield_strength = 550e6\n"
    )
    summary = {
        "name": "half-space",
        "n_elements": 62500,
        "energy_input_J": 5.0,
        "energy_input_normalised": 1.9012,
        "peak_force_N": None,
    }
    summary |= {
        "energy_balance_error": 4e-3,
        "plastic_zone_volume_ever_m3": 2e-6,
        "energy_hourglass_J": 1e-3,
        "versions": None,
    }
    write_json(run / "summary.json", summary)
    report = build([run, write_run(tmp_path / "grains", figures=False)], tmp_path)
    first = table(report, "inputs", "What this report is about")[0]
    assert first["What"].text == "continuum run"
    row = table(report, "balance", "Energies at the end, and the error of the balance")[0]
    assert (row["Balance"].text, row["Hourglass energy"].value) == ("good", 1e-3)
    assert table(report, "results", "Runs")[0]["Peak contact force"].value is None
    (row,) = table(report, "sources", "Source against ours")
    assert row["Ours"].value == pytest.approx(5.0 / 1.9012)
    for suffix in ("html", "pdf", "md"):
        write_report([run], tmp_path / f"r.{suffix}")


# ---- figures ----


def test_figures_in_a_fixed_order_made_small(runs, tmp_path):
    report = build(runs, tmp_path)
    gallery = next(block for block in blocks(report, "figures") if isinstance(block, Gallery))
    assert [figure.caption for figure in gallery.figures] == [
        "Peak contact force, principal plane",
        "Energies and the error of their balance",
        "Zebra",
    ]
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


# ---- source against ours ----


def test_source_table_is_computed_right(tmp_path):
    run = write_run(
        tmp_path / "reference",
        figures=False,
        packing__size=[72, 72, 30],
        dissipated_fraction=0.8735,
        peak_force_N=696.8,
        n_plastic_contacts=2856,
    )
    unit = sphere_contact(load_case(run / "case.toml")).yield_force
    rows = {row["Quantity"].text: row for row in table(build([run], tmp_path), "sources", "Source against ours")}
    assert set(rows) == {"Dissipated fraction", "Peak contact force (F_y)", "Yielded contacts"}
    row = rows["Dissipated fraction"]
    assert (row["Source gives"].value, row["Ours"].value, row["Within its rounding"].text) == (0.87, 0.8735, "yes")
    assert row["Difference"].value == pytest.approx(100 * 0.0035 / 0.87)
    assert row["Difference"].text == "+0.4 %"
    assert rows["Peak contact force (F_y)"]["Ours"].value == pytest.approx(696.8 / unit)
    assert rows["Yielded contacts"]["Within its rounding"].text == "yes"


@pytest.mark.parametrize(("velocity", "theirs"), [(4, 37.9), (10, 94.9), (40, 379)])
def test_normalised_velocities_of_the_thesis(tmp_path, velocity, theirs):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[velocity], packing__diameter=[0.01, 0.02]))
    (row,) = table(build([scan], tmp_path), "sources", "Source against ours")  # two points, one value
    assert row["Source gives"].value == theirs
    assert row["Within its rounding"].text == "yes"
    assert row["Run"].text == "scan #1, #2"


def test_first_yield_of_the_source_s_spheres(tmp_path):
    run = write_run(tmp_path / "run", figures=False, packing__diameter=0.00952)
    rows = table(build([run], tmp_path), "sources", "Source against ours")
    assert [row["Within its rounding"].text for row in rows] == ["yes", "yes"]


def test_other_cases_have_no_source_value_but_errata(tmp_path):
    run = write_run(tmp_path / "run", figures=False, material="steel", load__velocity=4)
    report = build([run], tmp_path)
    assert not any(b.caption == "Source against ours" for b in blocks(report, "sources") if isinstance(b, Table))
    where = [row["Where"].text for row in table(report, "sources", "Errata of the sources")]
    assert "thesis 2.17" in where
    assert "thesis 4.1.3" not in where  # bilinear


def test_every_source_entry_is_sound():
    values = source_values()
    for entry in values["values"]:
        assert {"quantity", "value", "rounding", "source"} <= set(entry)
        assert set(entry.get("cases", ())) <= set(values["cases"])
        assert entry["value"] and entry["rounding"] > 0
        wanted = {}
        for name in entry.get("cases", ()):
            wanted |= values["cases"][name]
        wanted |= entry.get("conditions", {})
        assert applies(entry, wanted, values)
        for key in wanted:
            assert not applies(entry, wanted | {key: "another"}, values)
    for entry in values["errata"]:
        assert set(entry) == {"cases", "where", "printed", "right"}
        assert set(entry["cases"]) <= set(values["cases"])


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
    assert [percent(x) for x in (0.0, 0.11234, -12.345, 1e-7)] == ["0 %", "+0.11 %", "-12.3 %", "+1e-7 %"]


def test_cleaned_replaces_what_formats_cannot_hold():
    assert cleaned(Note("a\x00b\ud800c\n")).text == "a\ufffdb\ufffdc\n"
    figure = Figure("n", "c", "a", b"\x00", (1, 1))
    assert cleaned(figure) == figure


# ---- the three formats ----


@pytest.mark.parametrize("suffix", ["html", "pdf", "md"])
def test_same_inputs_same_bytes(runs, tmp_path, suffix):
    """In another process, with other hashes, from another place, of files made in another order."""
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
    """Tags and what they point to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        self.words.append(data)


def nasty_inputs(tmp_path) -> list[Path]:
    run = write_run(tmp_path / "a<b>&'c", name=NASTY, end_reason=NASTY, versions={NASTY: NASTY})
    draw(run, 'x<y>"&')
    (run / "case.toml").write_text(
        (run / "case.toml").read_text() + f"[{json.dumps('<i>')}]\nx = {json.dumps(NASTY)}\n"
    )
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2]), failed={1: NASTY + "\x07\ud800\n" + "w" * 3000})
    return [run, scan]


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


def test_tables_of_the_model_are_regular(runs, tmp_path):
    report = build(runs, tmp_path)
    for section in report.sections:
        for block in blocks(report, section.slug):
            if isinstance(block, Table):
                assert all(len(row) == len(block.columns) for row in block.rows), block.caption


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


# ---- what is refused ----


def refused(directories, output) -> list[str]:
    with pytest.raises(InputError) as error:
        write_report(directories, output)
    return error.value.faults


def test_all_faults_at_once_and_nothing_written(runs, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "notes.txt").write_text("x")
    (runs[1] / "summary.json").unlink()
    (runs[0] / "summary.json").write_text("{")
    before = sorted(tmp_path.rglob("*"))
    given = [tmp_path / "nowhere", tmp_path / "empty", tmp_path / "other", *runs[:2], tmp_path, runs[0] / "case.toml"]
    faults = refused(given, tmp_path / "there" / "r.doc")
    assert len(faults) == 9
    for part in (
        "found the suffix .doc, expected .html, .pdf or .md",
        "there is no directory",
        "nowhere: no such directory",
        "empty: is neither a run nor a scan: it is empty",
        "it holds notes.txt; expected summary.json or scan.json",
        f"cannot be read (Expecting property name enclosed in double quotes: line 1 column 2 (char 1)); make it anew with  granwave analyse {runs[0]}",
        f"a run without summary.json; make it with  granwave analyse {runs[1]}",
        "but holds some (first, scan); give those",
        "is a file, expected the directory",
    ):
        assert any(part in fault for fault in faults), part
    assert sorted(tmp_path.rglob("*")) == before


def test_output_that_cannot_be_written(runs, tmp_path):
    (tmp_path / "d.html").mkdir()
    assert "is a directory" in refused(runs, tmp_path / "d.html")[0]
    assert "no suffix" in refused(runs, tmp_path / "report")[0]
    (tmp_path / "r_files").write_text("mine")
    assert "is a file, but pictures" in refused(runs, tmp_path / "r.md")[0]
    assert "no directory was given" in refused([], tmp_path / "r.html")[0]


def test_unfinished_run_and_damaged_scans(runs, tmp_path):
    (runs[0] / "summary.json").unlink()
    write_json(runs[0] / "run.json", {"state": "interrupted"})
    assert "--resume" in refused([runs[0]], tmp_path / "r.html")[0]
    for content in ("{", "[]", '{"name": "a", "case": "b", "varied": [], "points": [{}]}', '{"name": 1}'):
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


def test_same_names_and_one_directory_twice(tmp_path):
    first, second = write_run(tmp_path / "a" / "run", figures=False), write_run(tmp_path / "b" / "run", figures=False)
    inputs = read_inputs([first, second, tmp_path / "a" / ".." / "a" / "run"], tmp_path)
    assert [run.label for run in inputs.runs] == ["a/run", "b/run"]


def test_run_without_a_case_or_record(tmp_path):
    run = write_run(tmp_path / "run", figures=False)
    (run / "case.toml").write_text("broken =")
    (run / "run.json").unlink()
    (run / "result.h5").unlink()
    report = build([run], tmp_path)
    assert any("case.toml" in note.text for note in notes(report, "short"))


# ---- in a browser ----


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)")
def test_in_a_browser(runs, tmp_path):
    """No complaint, no request, no sideways scrolling on a phone, and tables that sort by keyboard."""
    write_report([*runs, *nasty_inputs(tmp_path / "more")], tmp_path / "report.html")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        for width in (390, 1200):
            browser.open((tmp_path / "report.html").as_uri(), width)
            browser.evaluate("document.querySelectorAll('details').forEach((d) => (d.open = true))")
            assert browser.evaluate("document.documentElement.scrollWidth") <= width
            assert browser.evaluate("innerWidth") == width
            wide = "[...document.querySelectorAll('.box')].some((b) => b.scrollWidth > b.clientWidth)"
            assert browser.evaluate(wide) is True  # tables scroll in their own boxes
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


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium on this machine (Debian: apt install chromium)")
def test_the_browser_test_would_notice(tmp_path):
    """A page that does ask the network and does complain is caught by the same means."""
    page = tmp_path / "bad.html"
    page.write_text("<body><img src='http://127.0.0.1:9/x.png'><p style='width:2000px'>x</p><script>nope()</script>")
    with Browser(CHROMIUM, tmp_path / "profile") as browser:
        browser.open(page.as_uri(), 390)
        assert browser.evaluate("document.documentElement.scrollWidth") > 390
        assert any("nope" in complaint for complaint in browser.complaints())
        assert any("127.0.0.1:9" in url for url in browser.requests())
