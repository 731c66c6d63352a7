"""Kinds of rows, and the tables and files that keep them apart."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.document.model import Table
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.studies import studies_section
from granwave.analysis.studies.study import Row, Study, write_rows
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import STUDY_ROWS
from tests.helpers.synthetic_report import write_run

SOURCE = Row("force", "N", 2.0, 3.0, "thesis 1", "why", 2.5)
THEORY = Row("speed", "m/s", None, 3.0, "Hertz", theory=4.0)
TESTS = Row("power", "", None, 0.1667, "Hertz", theory=1 / 6, verification=True)
ALONE = Row("share", "%", None, 12.0, "ours alone")
SILENT = Row("printed formula", "m/s", 14.8, None, "thesis 2", theory=10.0)


def test_kind_follows_from_what_a_row_compares() -> None:
    rows = (SOURCE, THEORY, TESTS, ALONE, SILENT)
    assert [row.kind for row in rows] == ["source", "theory", "verification", "alone", "source"]
    assert [row.deviation for row in rows] == pytest.approx([0.5, -0.25, 0.0002, None, None], nan_ok=True)


def test_no_difference_is_given_from_a_bound() -> None:
    assert dataclasses.replace(SOURCE, bound=True).deviation is None


@pytest.mark.parametrize("missing", [{"source": 1.0}, {"theory": None}, {"ours": None}])
def test_a_verification_has_its_two_values_and_no_source(missing: dict[str, float | None]) -> None:
    with pytest.raises(ValueError, match="expected ours and theory, and no source"):
        dataclasses.replace(TESTS, **missing)


def test_numbers_of_numpy_can_be_stored() -> None:
    row = Row("waves", source=4.0, ours=np.int64(4), theory=np.float64(4.5))  # type: ignore[arg-type]
    assert json.dumps([row.ours, row.theory]) == "[4, 4.5]"


def test_a_row_without_a_value_is_refused() -> None:
    with pytest.raises(ValueError, match="found no value"):
        dataclasses.replace(ALONE, ours=None)


def test_a_report_has_a_table_for_each_kind(tmp_path: Path) -> None:
    study = Study("s", "Chain", "text", rows=(SOURCE, TESTS, THEORY, ALONE, SILENT))
    section = studies_section(read_inputs([write_run(tmp_path / "run", figures=False)], tmp_path), [study])
    tables = {block.caption: block for block in section.blocks[0].blocks if isinstance(block, Table)}
    assert list(tables) == [
        "Chain: source against ours", "Chain: theory against ours", "Chain: verification of the code",
        "Chain: ours alone",
    ]  # fmt: skip
    sourced = tables["Chain: source against ours"]
    assert [row[0].text for row in sourced.rows] == ["force (N)", "printed formula (m/s)"]
    assert sourced.rows[1][2].text == "–"  # noqa: RUF001
    assert "Must be" in [column.heading for column in tables["Chain: verification of the code"].columns]


def test_rows_are_written_beside_the_report_of_a_scan(tmp_path: Path) -> None:
    study = Study("chain", "Chain", "text", rows=(SOURCE, TESTS))
    path = write_rows([study], tmp_path)
    assert path is not None
    with path.open(newline="", encoding="utf-8") as file:
        first, second = csv.DictReader(file)
    assert (first["study"], first["kind"], first["source"], first["granwave"]) == ("chain", "source", "2.0", "3.0")
    assert (second["kind"], second["source"], float(second["theory"])) == ("verification", "", 1 / 6)
    assert write_rows([], tmp_path) is None and not path.exists()


def test_a_file_of_someone_else_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / STUDY_ROWS).write_text("mine\n")
    with pytest.raises(InputError, match="granwave did not write it"):
        write_rows([Study("s", "S", "text", rows=(SOURCE,))], tmp_path)
    assert (tmp_path / STUDY_ROWS).read_text() == "mine\n"
