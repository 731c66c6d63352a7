"""Rows of studies and their tables, runs that belong together, descriptions of cases in titles, and
studies of one's own.
"""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from granwave.analysis.document.model import DocumentTable
from granwave.analysis.reports.inputs import ReportPoint, ReportScan, read_inputs
from granwave.analysis.reports.report import parts, write_report
from granwave.analysis.reports.studies import row_tables, studies_of, studies_section
from granwave.analysis.studies.runs import (
    all_but,
    bottom_label,
    impact_title,
    load_label,
    packing_title,
)
from granwave.analysis.studies.study import Row, Study, write_rows
from granwave.lammps_inputs.case.boundary import time_label
from granwave.lammps_inputs.case.case import Case
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.run_directory import STUDY_ROWS
from granwave.workflows import load_case, load_scan, run_scan
from granwave.workflows.scanning.suite import load_suite
from tests.helpers.made_up.synthetic_report import write_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan

STUDY = '''"""Force against velocity.

Two velocities
of one packing."""
import granwave as gw


def rows(runs):
    for run in runs:
        yield gw.Row(f"Peak force at {run.case.load.velocity:g} m/s", "N", ours=run["peak_force_N"], theory=100.0)


def pictures(runs):
    from matplotlib.figure import Figure

    figure = Figure()
    figure.subplots().plot([run["peak_force_N"] for run in runs])
    yield gw.Picture("my_forces", "Forces", figure, {"force_N": [run["peak_force_N"] for run in runs]})
'''
SCAN = """case = "fcc-small"
study = "study.py"
set = {"packing.size" = [3, 3, 2], "run.end_time" = 1e-5}
grid = {"load.velocity" = [1, 2]}
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """File of the study."""
    path = tmp_path / "study.py"
    path.write_text(STUDY)
    return path


def test_a_report_makes_it_of_all_runs(tmp_path: Path, study: Path) -> None:
    """Title and text from the docstring, rows and pictures from the functions."""
    runs = [write_run(tmp_path / f"run{v}", load__velocity=v, figures=False) for v in (1, 2)]
    text = write_report(runs, tmp_path / "r.md", [str(study)]).read_text(encoding="utf-8")
    assert "Force against velocity" in text and "Two velocities of one packing." in text
    assert "Peak force at 1 m/s" in text and "Peak force at 2 m/s" in text and "Forces" in text


def test_a_scan_names_it_relative_to_its_own_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, study: Path
) -> None:
    """Rows, figure and data are in the directory of the scan, wherever it was started."""
    (tmp_path / "scan.toml").write_text(SCAN)
    monkeypatch.chdir("/")
    assert run_scan(load_scan(tmp_path / "scan.toml"), tmp_path / "out").complete
    with (tmp_path / "out" / "study_rows.csv").open() as file:
        assert [row["quantity"] for row in csv.DictReader(file)] == [
            "Peak force at 1 m/s",
            "Peak force at 2 m/s",
        ]
    assert {"my_forces.png", "my_forces.csv"} <= {
        path.name for path in (tmp_path / "out" / "figures").iterdir()
    }
    assert "Force against velocity" in (tmp_path / "out" / "report.html").read_text(
        encoding="utf-8"
    )


def test_a_later_report_loads_no_code_unasked(
    tmp_path: Path, study: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The path stored in the directory of a scan is not sufficient: the directory may be from
    another person.
    """
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[1, 2]), study=[str(study)])
    assert studies_of(read_inputs([scan], tmp_path)) == []
    assert f"--study {study}" in caplog.text
    assert [one.name for one in studies_of(read_inputs([scan], tmp_path, [str(study)]))] == [
        "study"
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 +", "cannot be loaded: SyntaxError"),
        ("import no_such_module", "No module named 'no_such_module'"),
        ("def row(runs): ...", "found neither rows(runs), pictures(runs) nor tables(runs)"),
        (None, "no such file, expected the Python file of a study"),
    ],
)
def test_a_file_that_is_no_study_is_refused_before_anything_runs(
    tmp_path: Path, text: str | None, says: str
) -> None:
    """This holds for scans, suites and reports."""
    if text is not None:
        (tmp_path / "study.py").write_text(text)
    (tmp_path / "scan.toml").write_text(SCAN)
    (tmp_path / "suite.toml").write_text('scans = ["velocity-fcc"]\nstudy = "study.py"\n')
    run = write_run(tmp_path / "run", figures=False)
    for call in (
        lambda: load_scan(tmp_path / "scan.toml"),
        lambda: load_suite(tmp_path / "suite.toml"),
        lambda: write_report([run], tmp_path / "r.md", [str(tmp_path / "study.py")]),
    ):
        with pytest.raises(InputError) as caught:
            call()
        assert says in str(caught.value) and "study.py" in str(caught.value)


def test_studies_without_rows_stand_in_a_report(tmp_path: Path) -> None:
    """Two studies with the same text, the second of which has no content."""
    paths = [tmp_path / "one.py", tmp_path / "two.py"]
    for path in paths:
        path.write_text(
            f'"""Study {path.stem}.\n\nNothing was found."""\n\ndef rows(runs):\n    return []\n'
        )
    run = write_run(tmp_path / "run")
    text = write_report([run], tmp_path / "r.html", [str(path) for path in paths]).read_text(
        encoding="utf-8"
    )
    assert "Study one" in text and "Study two" in text and text.count("Nothing was found.") == 2


@pytest.mark.failing_figures
def test_a_study_that_fails_costs_no_report(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The study is named with the line of its fault."""
    (tmp_path / "bad.py").write_text('"""Bad."""\ndef rows(runs):\n    return [1 / 0]\n')
    (tmp_path / "misspelt.py").write_text(
        '"""Misspelt."""\ndef rows(runs):\n    yield runs[0]["peak_forc_N"]\n'
    )
    run = write_run(tmp_path / "run", figures=False)
    text = write_report(
        [run], tmp_path / "r.md", [str(tmp_path / "bad.py"), str(tmp_path / "misspelt.py")]
    )
    fault = "rows of the study bad, from number 1 on, could not be made: ZeroDivisionError: division by zero (bad.py, line 3)"
    assert fault in text.read_text(encoding="utf-8") and fault in caplog.text
    assert "did you mean peak_force_N?" in caplog.text


SOURCE = Row("force", "N", 2.0, 3.0, "thesis 1", "why", 2.5)
THEORY = Row("speed", "m/s", None, 3.0, "Hertz", theory=4.0)
TESTS = Row("power", "", None, 0.1667, "Hertz", theory=1 / 6, verification=True)
ALONE = Row("share", "%", None, 12.0, "ours alone")
SILENT = Row("printed formula", "m/s", 14.8, None, "thesis 2", theory=10.0)


def test_kind_follows_from_what_a_row_compares() -> None:
    rows = (SOURCE, THEORY, TESTS, ALONE, SILENT)
    assert [row.kind for row in rows] == ["source", "theory", "verification", "alone", "source"]
    assert [row.deviation for row in rows] == pytest.approx(
        [0.5, -0.25, 0.0002, None, None], nan_ok=True
    )
    assert dataclasses.replace(SOURCE, bound=True).deviation is None


@pytest.mark.parametrize(
    ("row", "missing", "says"),
    [
        *((TESTS, one, "expected ours and theory, and no source") for one in ({"source": 1.0}, {"theory": None}, {"ours": None})),
        (ALONE, {"ours": None}, "found no value"),
    ],
)  # fmt: skip
def test_a_row_has_the_values_of_its_kind(
    row: Row, missing: dict[str, float | None], says: str
) -> None:
    with pytest.raises(ValueError, match=says):
        dataclasses.replace(row, **missing)


def test_numbers_of_numpy_can_be_stored() -> None:
    row = Row("waves", source=4.0, ours=np.int64(4), theory=np.float64(4.5))  # type: ignore[arg-type]
    assert json.dumps([row.ours, row.theory]) == "[4, 4.5]"


def test_a_report_has_a_table_for_each_kind(tmp_path: Path) -> None:
    study = Study("s", "Chain", "text", rows=(SOURCE, TESTS, THEORY, ALONE, SILENT))
    section = studies_section(
        read_inputs([write_run(tmp_path / "run", figures=False)], tmp_path), [study]
    )
    tables = {
        block.caption: block
        for block in section.blocks[0].blocks
        if isinstance(block, DocumentTable)
    }
    assert list(tables) == [
        "Chain: source against ours", "Chain: theory against ours", "Chain: verification of the code",
        "Chain: granwave only (no reference)",
    ]  # fmt: skip
    sourced = tables["Chain: source against ours"]
    assert [row[0].text for row in sourced.rows] == ["force (N) ¹", "printed formula (m/s)"]
    assert sourced.footnotes == (f"¹ {SOURCE.remark}",)
    assert sourced.rows[1][2].text == "–"  # noqa: RUF001
    assert "Must be" in [
        column.heading for column in tables["Chain: verification of the code"].columns
    ]


def test_equal_remarks_share_a_footnote_and_the_last_part_of_a_table_has_it() -> None:
    rows = [
        dataclasses.replace(ALONE, quantity=name, remark=remark)
        for name, remark in (("a", "first"), ("b", ""), ("c", "second"), ("d", "first"))
    ]
    (table,) = row_tables(Study("s", "Chain", "text", rows=tuple(rows)))
    assert [row[0].text.split()[-1] for row in table.rows if row[0].text[0] in "acd"] == [
        "¹",
        "²",
        "¹",
    ]
    assert table.footnotes == ("¹ first", "² second")
    wide = dataclasses.replace(
        table,
        columns=table.columns * 4,
        rows=tuple(row * 4 for row in table.rows),
    )
    split = parts(wide)
    assert len(split) > 1
    assert [part.footnotes for part in split] == [()] * (len(split) - 1) + [table.footnotes]


def test_rows_are_written_beside_the_report_of_a_scan(tmp_path: Path) -> None:
    study = Study("chain", "Chain", "text", rows=(SOURCE, TESTS))
    path = write_rows([study], tmp_path)
    assert path is not None
    with path.open(newline="", encoding="utf-8") as file:
        first, second = csv.DictReader(file)
    assert (first["study"], first["kind"], first["source"], first["granwave"]) == (
        "chain",
        "source",
        "2.0",
        "3.0",
    )
    assert (second["kind"], second["source"], float(second["theory"])) == (
        "verification",
        "",
        1 / 6,
    )
    assert write_rows([], tmp_path) is None and not path.exists()


def test_a_file_of_someone_else_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / STUDY_ROWS).write_text("mine\n")
    with pytest.raises(InputError, match="granwave did not write it"):
        write_rows([Study("s", "S", "text", rows=(SOURCE,))], tmp_path)
    assert (tmp_path / STUDY_ROWS).read_text() == "mine\n"


def test_twins_differ_in_what_is_named_alone() -> None:
    case = load_case("settled-fcc")
    other = load_case("settled-fcc", {"precompression.pressure": 1e4, "run.end_time": 1e-3})
    faster = load_case("settled-fcc", {"load.velocity": 10.0})
    of_case, of_other, of_faster = (all_but(one, "precompression") for one in (case, other, faster))
    assert of_case == of_other != of_faster
    assert (
        all_but(case, "load.velocity")
        == all_but(faster, "load.velocity")
        != all_but(other, "load.velocity")
    )
    assert all_but(case, "precompression", "load.velocity") == all_but(
        other, "precompression", "load.velocity"
    )


def test_a_report_shows_the_studies_of_its_runs(tmp_path: Path) -> None:
    """All runs that the scans share are listed, except runs that no study uses."""
    for name, text in (("all", ""), ("none", "def select(runs): return []\n")):
        (tmp_path / f"{name}.py").write_text(
            f"def tables(runs): yield 'Count', {{'Runs': [len(runs)]}}\n{text}"
        )
    every, none = (str(tmp_path / name) for name in ("all.py", "none.py"))
    directories = [write_run(tmp_path / name, figures=False) for name in ("one", "two")]
    inputs = read_inputs(directories, tmp_path / "report.html", [every, none])
    assert studies_of(inputs) == []
    assert [study.name for study in studies_of(inputs, [every, none])] == ["all"]
    points = tuple(ReportPoint(SimpleNamespace(labels={}), "", one) for one in inputs.runs)
    scans = (
        ReportScan("first", None, points, (none,)),
        ReportScan("second", None, points[:1], (every,)),
        ReportScan("third", None, points, (every,)),
    )
    (study,) = studies_of(dataclasses.replace(inputs, items=scans))
    assert study.tables[0].rows[0][0].text == "2"


def made(
    kind: str = "fcc", size: Any = (6, 5, 4), material: Any = "brass", **sections: Any
) -> Case:
    packing = {
        "kind": kind,
        "size": list(size) if isinstance(size, tuple) else size,
        "diameter": 0.00952,
    }
    return case_from_dict({"name": "words", "packing": packing, "material": material, **sections})


@pytest.mark.parametrize(
    ("kind", "size", "words", "of_any_height"),
    [
        ("fcc", (6, 5, 4), "FCC packing of 6 × 5 × 4 brass spheres", "FCC packing of 6 × 5 brass spheres of 9.52 mm a layer"),
        ("square", (6, 5), "Square packing of 6 × 5 brass spheres", "Square packing of 6 × 5 brass spheres of 9.52 mm"),
        ("chain", 20, "Chain of 20 brass spheres", "Chain of brass spheres of 9.52 mm"),
        ("chain", 1, "Brass sphere", "Chain of brass spheres of 9.52 mm"),
    ],
)  # fmt: skip
def test_packings(kind: str, size: Any, words: str, of_any_height: str) -> None:
    striker = {"load": {"kind": "striker"}, "striker": [{"touches": 1, "velocity": [0.3, 0.4, 0]}]}
    case = made(kind, size, **(striker if kind == "square" else {}))
    assert packing_title(assemble(case)) == f"{words} of 9.52 mm"
    assert packing_title(assemble(case), height=False) == of_any_height


def test_names_of_loads_and_of_a_material_without_one() -> None:
    own = {"youngs_modulus": 1e11, "poisson_ratio": 0.3, "density": 8000, "yield_strength": 5e8}
    assert packing_title(assemble(made("chain", 3, own))) == "Chain of 3 spheres of 9.52 mm"
    some = [{"index": 2, "material": "steel"}]
    every = [{"index": {"first": 1, "last": 3}, "material": "steel"}]
    assert packing_title(assemble(made("chain", 3, replace=some))).startswith(
        "Chain of 3 brass and steel sph"
    )
    assert packing_title(assemble(made("chain", 3, replace=every))).startswith(
        "Chain of 3 steel spheres"
    )
    assert impact_title(assemble(made(load={"velocity": 2.5}, contact={"law": "hertz"}))).endswith(
        ", elastic contacts, 2.5 m/s"
    )
    assert load_label(assemble(made(load={"velocity": 5, "angle": 30}))) == "5 m/s"
    force = {"kind": "force", "shape": "half-sine", "amplitude": 100.0, "duration": 1e-5}
    assert load_label(assemble(made("chain", 3, load=force))) == "force on top"
    strikers = [{"touches": 1, "velocity": [0, 0, 0.6]}, {"touches": 2, "velocity": [0, 0.6, 0.8]}]
    assert load_label(assemble(made(load={"kind": "striker"}, striker=strikers))) == "1 m/s"
    assert [time_label(time) for time in (2.5e-5, 9.99e-4, 1e-3)] == ["25 µs", "999 µs", "1 ms"]


@pytest.mark.parametrize(
    ("bottom", "words"),
    [
        ("wall", "rigid wall"),
        ("fixed", "fixed last layer"),
        ("free", "no bottom"),
        ({"material": "steel"}, "steel wall"),
        ({"plate": {"mass": 0.5, "stiffness": 2e8}}, "plate of 0.5 kg, 314 µs"),
        ({"plate": {"mass": 1.0, "stiffness": 1e6, "damping": 10.0}, "material": "steel"}, "plate of 1 kg, 6.28 ms, damped"),
        ({"half_space": {}, "material": "steel"}, "steel half-space"),
        ({"half_space": {"radius": 0.05}, "material": "steel"}, "steel half-space, disc of 50 mm"),
        ({"bar": {"length": 1, "area": 0.0125}, "material": "steel"}, "steel bar of 125 cm²"),
        ({"bar": {"length": 1, "area": 0.0125, "end": "fixed"}, "material": "steel"}, "steel bar of 125 cm², far end fixed"),
    ],
)  # fmt: skip
def test_bottoms(bottom: Any, words: str) -> None:
    assert bottom_label(made(boundary={"bottom": bottom})) == words
