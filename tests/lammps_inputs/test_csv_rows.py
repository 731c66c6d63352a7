"""CSV files as spreadsheets take them."""

from __future__ import annotations

import csv
import io

import pytest

from granwave.analysis.figures.style import write_csv
from granwave.lammps_inputs.files import write_csv_rows


@pytest.mark.parametrize("text", ["=1+1", "+cmd|calc", "-2+3", "@SUM(A1)", "\t=1", '=HYPERLINK("a")'])
def test_text_is_no_formula(text):
    file = io.StringIO()
    write_csv_rows(file, [[text]])
    assert next(csv.reader([file.getvalue()])) == [f"'{text}"]


@pytest.mark.parametrize("cell", ["-1.5e-3", "+7", "-inf", "-", "", "a=1", "brass"])
def test_numbers_and_other_text_stay(cell):
    file = io.StringIO()
    write_csv_rows(file, [[cell, -2.5, None]])
    assert file.getvalue() == f"{cell},-2.5,\n"


def test_columns_named_by_the_user(tmp_path):
    write_csv({"=group": ["=a", "b"], "force": [-1.0, 2.0]}, tmp_path / "table.csv")
    assert (tmp_path / "table.csv").read_text() == "'=group,force\n'=a,-1\nb,2\n"
