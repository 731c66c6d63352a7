"""Report of inferred forces, and their tables in a notebook."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.document.model import BLANK
from granwave.analysis.errors import OutputFormatError
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.reports.results import value_rows
from granwave.analysis.reports.sentences import value_table
from granwave.extensions.inference.report import InferenceKind
from granwave.lammps_inputs.files import plain
from granwave.lammps_inputs.result_directory import ResultDirectory

DISC = "id,x_m,y_m,radius_m,sxx,syy,sxy\n1,0,0.005,0.005,0,-1e5,0\n"
CASE = """
[material]
density = 1130
[infer]
friction = 0.3
thickness = 0.02
walls = {floor = 0.0, top = 0.01}
"""


def labels(run):
    return [row[0].text for row in value_rows(run).rows]


def test_answer_and_table():
    summary = dict(
        kind="inference",
        n_grains=48,
        n_contacts=104,
        n_loaded_contacts=89,
        n_significant_contacts=9,
        noise=[0.02, 0.1],
        true_force_error=[0.012, 0.057],
        largest_force_N=179.8,
        residual_fraction=0.05,
    )
    run = ReportRun("one", InferenceKind(), ResultDirectory(Path()), "done", summary, {}, {})
    assert in_words(run) == (
        "89 of 104 contacts carry a force, at most 179.8 N. 9 of them carry a force above two "
        "standard errors. The error is 1.2 % to 5.7 % of the true forces, for noise of "
        "2 % to 10 %. The unexplained fraction of the data is 5 %."
    )
    assert labels(run)[:3] == [
        "Grains",
        "Candidate contacts",
        "Contacts with a force above two standard errors",
    ]
    others = [
        dataclasses.replace(
            run, label="two", summary={**run.summary, "n_significant_contacts": None}
        )
    ]
    table = value_table([run, *others], "inferred forces")
    assert [column.heading for column in table.columns] == ["Quantity", "one", "two", "Unit"]
    rows = {row[0].text: row[1:] for row in table.rows}
    error = rows["Error of the forces relative to the true forces"]
    assert [cell.text for cell in error] == ["1.2 to 5.7", "1.2 to 5.7", "%"]
    significant = rows["Contacts with a force above two standard errors"]
    assert [cell.text for cell in significant] == ["9", BLANK, ""]
    assert "Young's modulus" not in rows


def test_inferred_forces(tmp_path):
    (tmp_path / "disc.csv").write_text(DISC)
    (tmp_path / "disc.toml").write_text(CASE)
    made = gw.infer(tmp_path / "disc.csv", tmp_path / "disc.toml", directory=tmp_path / "found")
    found = gw.load(tmp_path / "found")
    assert isinstance(found, gw.InferredForces) and dict(found) == plain(dict(made))
    assert (
        np.array_equal(found.forces["normal_force_N"], made.forces["normal_force_N"])
        and found.measurement is None
    )
    assert "2 of them carry a force" in repr(found)
    (tmp_path / "found" / "forces.csv").unlink()
    with pytest.raises(OutputFormatError, match=r"forces\.csv or grains\.csv cannot be read"):
        gw.load(tmp_path / "found")
