"""Tables and notes of a report: no empty columns, no insignificant digits, the bottoms of runs,
names of sections.
"""

from __future__ import annotations

import math
import re
from pathlib import Path

import pytest

from granwave.analysis.document.model import (
    BLANK,
    Cell,
    DocumentTable,
    TableColumn,
    spread_cell,
    tidied_table,
    value_cell,
)
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import text_of, write_report
from granwave.analysis.reports.results import results_section
from granwave.analysis.reports.setting import settings_blocks
from granwave.analysis.reports.studies import studies_section
from granwave.analysis.studies.study import Row, Study
from tests.helpers.made_up.synthetic_report import build, notes, table, write_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan


def made(heads: list[str], rows: list[list], *, by_row: bool = False) -> DocumentTable:
    """Table from headings: ``Energy:J`` is a numeric column with its unit, ``Run`` a column of
    names.
    """
    columns = [TableColumn(name, unit, numeric=name[0].isupper() and colon == ":") for name, colon, unit in
               (head.partition(":") for head in heads)]  # fmt: skip
    cells = [
        [value if isinstance(value, Cell) else value_cell(value) for value in row] for row in rows
    ]
    return DocumentTable("t", tuple(columns), tuple(map(tuple, cells)), by_row=by_row)


def texts(of: DocumentTable) -> list[list[str]]:
    tidy = tidied_table(of)
    assert all(len(row) == len(tidy.columns) for row in tidy.rows)
    return [[cell.text for cell in row] for row in tidy.rows]


def test_columns_without_a_value_are_left_out():
    of = made(["Run", "A:", "Remark", "B:"], [["x", None, "", 1.0], ["y", None, "", None]])
    assert texts(of) == [["x", "1"], ["y", BLANK]]
    assert [column.heading for column in tidied_table(of).columns] == ["Run", "B"]
    nothing = made(["Run", "A:"], [])
    assert tidied_table(nothing) == nothing


def test_quantities_without_a_value_are_left_out():
    of = made(
        ["Quantity", "One:", "Two:"],
        [["a", 1.0, None], ["b", None, None], ["c", None, 2.0]],
        by_row=True,
    )
    assert texts(of) == [["a", "1", BLANK], ["c", BLANK, "2"]]


def test_tables_on_paper_are_as_wide_as_the_page():
    assert re.search(r"table, \.beside table \{ width: 100%;", text_of("print.css"))


def test_rounding_is_no_number():
    rows = [
        ["x", 0.0022, 7.7711e-121, 1.0],
        ["y", 0.0022, 4.8756e-12, 3e-17],
        ["z", 0.0022, -1e-19, 0.0],
    ]
    of = made(["Run", "Input:J", "Elastic:J", "Share:"], rows)
    assert texts(of) == [
        ["x", "0.0022", "< 1e-14", "1"],
        ["y", "0.0022", "4.8756e-12", "< 1e-12"],
        ["z", "0.0022", "< 1e-14", "0"],
    ]
    assert tidied_table(of).rows[0][2].value == 7.7711e-121  # sorts as before
    assert texts(made(["Run", "A:"], [["x", 3e-120]])) == [["x", "< 1e-100"]]


def test_small_runs_of_a_wide_scan_keep_their_energies():
    """The scale of each run is its own input energy, even if that of another run is much larger."""
    of = made(["Run", "Input:J", "Kinetic:J"], [["x", 1e-13, 4e-14], ["y", 10.0, 5.0]])
    assert texts(of) == [["x", "1e-13", "4e-14"], ["y", "10", "5"]]


def test_rounding_where_each_row_is_a_quantity():
    rows = [
        ["Spheres", "", 100000, 100000],
        ["Input", "J", 2.0, 2.0],
        ["Elastic", "J", 4e-25, 1e-3],
        ["e", "", 1e-6, 2e-6],
    ]
    of = made(["Quantity", "Unit", "First:", "Second:"], rows, by_row=True)
    assert [row[2:] for row in texts(of)] == [
        ["100000", "100000"],
        ["2", "2"],
        ["< 1e-11", "0.001"],
        ["1e-6", "2e-6"],
    ]


def test_means_of_rounding():
    of = made(
        ["Run", "A:"],
        [
            ["x", spread_cell(0.7, 0.25)],
            ["y", spread_cell(3e-20, 1e-20)],
            ["z", spread_cell(0.5, None)],
        ],
    )
    assert [row[1] for row in texts(of)][0::2] == ["0.70 ± 0.25", "0.5"]


def test_bottoms_of_runs_are_told_in_one_column(tmp_path):
    """Runs on a wall, a plate, a half-space and a bar; units and common values are in the
    settings.
    """
    bottoms = {
        "wall": "wall",
        "plate": "{plate = {mass = 5.0, stiffness = 5e9}}",
        "space": '{half_space = {}, material = "steel"}',
        "bar": '{bar = {length = 0.5, area = 0.0125}, material = "steel"}',
    }
    runs = [
        write_run(tmp_path / name, figures=False, boundary__bottom=text)
        for name, text in bottoms.items()
    ]
    results = results_section(read_inputs(runs, tmp_path))
    shown = tidied_table(
        next(block for block in results.blocks if isinstance(block, DocumentTable))
    )
    heads = [column.heading for column in shown.columns]
    assert [row[heads.index("boundary.bottom")].text for row in shown.rows] == [
        "wall",
        "plate mass=5 stiffness=5e9 damping=0",
        "half_space, steel",
        "bar length=0.5 area=0.0125 elements=200 end=infinite, steel",
    ]
    assert not any(heading.startswith("boundary.bottom.") for heading in heads)
    assert BLANK not in [cell.text for row in shown.rows for cell in row]
    (group,) = settings_blocks(read_inputs([runs[1]], tmp_path))
    found = {row[0].text: (row[1].text, row[2].text) for row in group.blocks[0].rows}
    assert found["boundary.bottom.plate.stiffness"] == ("5e9", "N/m")


def test_labels_of_scans_are_words_in_tables(tmp_path):
    points = grid(load__velocity=[1, 2])
    for point, overlap in zip(points, (0.0, '{"force": 300}'), strict=True):
        point["contact.initial_overlap"] = overlap
    scan = write_scan(tmp_path / "scan", points, missing=[1, 2])
    rows = table(build([scan], tmp_path), "failures", "Scan scan: points that are not done")
    assert [row["contact.initial_overlap"].text for row in rows] == ["0", "force=300"]


def test_shares_of_friction_are_shown_where_there_is_friction(tmp_path):
    shares = {"plastic_fraction": 0.5, "friction_fraction": 0.0}
    first = write_run(tmp_path / "first", figures=False, **shares)
    second = write_run(tmp_path / "second", figures=False, **shares | {"friction_fraction": 0.2})
    assert (
        "Fraction dissipated by friction"
        in table(build([first, second], tmp_path), "results", "Runs")[0]
    )
    third = write_run(tmp_path / "third", figures=False, **shares)
    assert not any(
        "Share" in head for head in table(build([first, third], tmp_path), "results", "Runs")[0]
    )


def test_rounding_is_no_difference(tmp_path):
    first = write_run(tmp_path / "first", figures=False, energy_input_J=0.045)
    second = write_run(tmp_path / "second", figures=False, energy_input_J=0.045 * (1 + 1e-14))
    rows = table(build([first, second], tmp_path), "results", "Values side by side")
    (row,) = [row for row in rows if row["Quantity"].text == "Energy input"]
    assert row["Difference"].text == "0 %"


@pytest.mark.parametrize(
    ("errors", "number"),
    [([7.66e-5], "7.7e-5"), ([2.1e-5, 8e-5], "up to 8e-5"), ([math.nan], "infinite")],
)
def test_a_balance_that_is_poor_is_told_with_numbers(tmp_path, errors, number):
    runs = [
        write_run(tmp_path / f"r{n}", figures=False, energy_balance_error=e)
        for n, e in enumerate(errors)
    ]
    (note,) = notes(build(runs, tmp_path), "short")
    assert number in note.text and "1e-5" in note.text and "r0" in note.text and note.tone == "bad"


def test_sections_have_names_of_their_own(tmp_path):
    run = write_run(tmp_path / "run", figures=False)
    inputs = read_inputs([run], tmp_path)
    study = Study(
        "s",
        "A chain",
        "text",
        rows=(Row("a", "N", 2.0, 3.0, "1"), Row("b", "", None, 3.0, "", theory=4.0)),
    )
    section = studies_section(inputs, [study])
    assert section.title == "Studies"
    parts = [block for block in section.blocks[0].blocks if isinstance(block, DocumentTable)]
    assert [part.caption for part in parts] == [
        "A chain: source against ours",
        "A chain: theory against ours",
    ]
    assert [row[3].text for part in parts for row in part.rows] == [
        "+50 %",
        "-25 %",
    ]  # of what it is compared with
    titles = [one.title for one in build([run], tmp_path).sections] + [section.title]
    assert len({re.sub(r"\W", "", title).lower() for title in titles}) == len(titles)


def test_templates_give_a_wide_figure_the_whole_row():
    """The style of a figure alone in its gallery does not reduce the width of a wide one."""
    css = (Path(__file__).parents[3] / "analysis/reports/templates/report.css").read_text()
    for rule in re.findall(r"([^{}]*only-child[^{}]*)\{[^}]*max-width", css):
        assert ":not(.wide)" in rule


def test_long_texts_in_columns_of_numbers_wrap(tmp_path):
    """A list of names does not cover the next column; numbers are on one line."""
    names = ["dissipated_fraction", "plastic_fraction", "energy_dissipated_J"]
    folders = [
        write_run(tmp_path / name, figures=False, incomplete_values=values)
        for name, values in (("long", names), ("short", []))
    ]
    write_report(folders, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    assert f'<td class="number words">{", ".join(names)}</td>' in page
    assert '<td class="number">none</td>' in page
