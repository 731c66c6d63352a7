"""Values of contacts beyond the range of the law are marked in comparisons."""

from __future__ import annotations

from granwave.analysis.reports.comparison.blocks import value_table
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.inputs import read_inputs
from granwave.workflows.cli.compare import text_of
from tests.helpers.made_up.synthetic_report import write_run


def test_values_of_contacts_beyond_the_law_are_marked(tmp_path):
    values = {"slow": (90.0, 0), "fast": (900.0, 5)}
    folders = [
        write_run(tmp_path / name, figures=False, peak_force_N=force, contacts_beyond_law=beyond)
        for name, (force, beyond) in values.items()
    ]
    comparison = compare_runs(list(read_inputs(folders, tmp_path).results()))
    value = next(value for value in comparison.values if value.name == "peak_force_N")
    assert value.beyond_law == {1}
    assert "90 N (slow) and 900 N ‡ (fast)" in comparison.sentence
    assert "0.2 R*, the limit of the law: fast (5)." in " ".join(comparison.notes)
    rows = value_table(comparison).rows
    cells = next(row for row in rows if row[0].text.startswith("Peak contact force"))
    assert [cell.text for cell in cells[2:4]] == ["90", "900 ‡"]
    assert "900 ‡" in text_of(comparison)
