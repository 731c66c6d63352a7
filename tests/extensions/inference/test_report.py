"""What a report says of inferred forces."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from granwave.analysis.document.model import BLANK
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.kinds import ReportRun
from granwave.analysis.reports.results import compact_table, value_rows
from granwave.extensions.inference.report import InferenceKind
from granwave.lammps_inputs.result_directory import ResultDirectory


def labels(run):
    return [row[0].text for row in value_rows(run).rows]


def test_answer_and_table():
    summary = dict(
        kind="inference", n_grains=48, n_contacts=104, n_loaded_contacts=89, n_significant_contacts=9, noise=[0.02, 0.1],
        true_force_error=[0.012, 0.057], largest_force_N=179.8, residual_fraction=0.05,
    )  # fmt: skip
    run = ReportRun("one", InferenceKind(), ResultDirectory(Path()), "done", summary, {}, {})
    assert in_words(run) == (
        "89 of 104 contacts bear a force, at most 179.8 N. 9 of them bear a force above two standard errors. These forces "
        "are off by 1.2 % to 5.7 % of the true ones, for noise of 2 % to 10 %. What these forces leave unexplained is 5 % "
        "of the data."
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
    table = compact_table([run, *others])
    assert [column.heading for column in table.columns] == ["Quantity", "one", "two", "Unit"]
    rows = {row[0].text: [cell.text for cell in row[1:]] for row in table.rows}
    assert rows["Error of the forces, of the true ones"] == ["1.2 to 5.7", "1.2 to 5.7", "%"]
    assert rows["Contacts with a force above two standard errors"] == ["9", BLANK, ""]
    assert "Young's modulus" not in rows
