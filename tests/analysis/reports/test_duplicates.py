"""Report of several kinds of runs without duplicates of figures, tables, captions or headings."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from granwave.analysis import analyse
from granwave.analysis.document.model import Block, Figure, Gallery, Group, Note, Report, Table
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.studies import studies_of
from granwave.analysis.scans.figures import draw_scan_figures
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.studies.study import draw_studies
from granwave.lammps_inputs.run_directory import FIGURES_DIRECTORY
from granwave.workflows import run_case
from tests.helpers import synthetic
from tests.helpers.small_cases import PULSE, case_of
from tests.helpers.synthetic_report import build
from tests.helpers.synthetic_scan import grid, write_scan


@pytest.fixture(scope="module")
def tolerances(tmp_path_factory) -> Path:
    """Scan with the files written by the driver: packings hit at two velocities, with friction and without."""
    points = grid(load__velocity=[2.0, 5.0], contact__friction=[0.0, 0.1, 0.2])
    scan = write_scan(tmp_path_factory.mktemp("scans") / "tolerances", points, study=["tolerance"])
    for point in ScanResult(scan).points:
        path, values = scan / "points" / point.id / "summary.json", (float(v) for v in point.labels.values())
        velocity, friction = values
        force = {"wall_peak_force_N": 300 * velocity * (1 - friction * velocity / 10)}
        path.write_text(json.dumps(json.loads(path.read_text()) | force))
    draw_scan_figures(ScanResult(scan), pdf=False)
    draw_studies(studies_of(read_inputs([scan], scan)), scan)
    assert len(list((scan / FIGURES_DIRECTORY).glob("tolerances*.png"))) == 2
    return scan


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> list[Path]:
    """Packing with its figures, chain with a bar, target below a packing."""
    folder = tmp_path_factory.mktemp("runs")
    packing = synthetic.write_run(folder / "packing", synthetic.make_case())
    analyse(packing)
    bar = {"length": 0.4, "area": 127e-6, "elements": 20, "material": "steel"}
    run_case(case_of(6, load=PULSE, bar=bar, run={"end_time": 4e-5, "frames": 3}), folder / "chain", figures=False)
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


def twice(found: Sequence[object]) -> list[object]:
    return [one for one, n in Counter(found).items() if n > 1]


def repeated(report: Report) -> dict[str, list[object]]:
    everything = [part for section in report.sections for part in parts(section.blocks)]
    figures = [part for part in everything if isinstance(part, Figure)]
    tables = [part for part in everything if isinstance(part, Table)]
    headings = [section.title for section in report.sections]
    headings += [part.title for part in everything if isinstance(part, Group)]
    headings += [part.caption for part in tables if part.captioned]
    verdicts = [section for section in report.sections if section.slug == "verdict"]
    said = {id(part) for section in verdicts for part in parts(section.blocks)}  # one per packing
    notes = [part.text for part in everything if isinstance(part, Note) and id(part) not in said]
    assert figures and tables and notes
    return {
        "pictures": twice([figure.png for figure in figures]),
        "data of pictures": twice([figure.data.href for figure in figures if figure.data]),
        "captions": twice([figure.caption for figure in figures]),
        "headings": twice(headings),
        "tables": twice([(table.columns, table.rows) for table in tables]),
        "notes": twice(notes),
    }


def test_report_of_a_scan(tolerances):
    """Figures of studies are files, too; the studies show them with the packing that they belong to."""
    report = build([tolerances], tolerances)
    assert not any(repeated(report).values()), repeated(report)
    figures = [part for section in report.sections for part in parts(section.blocks) if isinstance(part, Figure)]
    against = [figure for figure in figures if figure.caption.startswith("Against friction coefficient")]
    assert [figure.caption.partition(" (")[2][:6] for figure in against] == ["2 m/s)", "5 m/s)"]
    assert all(figure.data for figure in against)


def test_report_of_everything(tolerances, runs, tmp_path):
    inputs = [*runs, tolerances, next((tolerances / "points").iterdir())]
    report = build(inputs, tmp_path)
    assert {"Verdict", "Studies", "Figures"} <= {section.title for section in report.sections}
    assert not any(repeated(report).values()), repeated(report)
