"""Sources in a report: their values next to computed ones, and their errata."""

from __future__ import annotations

import pytest

from granwave.analysis.document.model import Table
from granwave.analysis.reports.sections.sources import applies, source_values
from granwave.lammps_inputs import load_case, sphere_contact
from tests.helpers.synthetic_report import blocks, build, table, write_run
from tests.helpers.synthetic_scan import grid, write_scan


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
    rows = {
        row["Quantity"].text: row
        for row in table(build([run], tmp_path, "restitution"), "sources", "Verification of the code")
    }
    assert set(rows) == {"Dissipated fraction", "Peak contact force (F_y)", "Yielded contacts"}
    row = rows["Dissipated fraction"]
    assert (row["Must be"].value, row["Ours"].value, row["Within its rounding"].text) == (0.87, 0.8735, "yes")
    assert row["Difference"].value == pytest.approx(100 * 0.0035 / 0.87)
    assert row["Difference"].text == "+0.4 %"
    assert rows["Peak contact force (F_y)"]["Ours"].value == pytest.approx(696.8 / unit)
    assert rows["Yielded contacts"]["Within its rounding"].text == "yes"


@pytest.mark.parametrize(("velocity", "theirs"), [(4, 37.9), (10, 94.9), (40, 379)])
def test_normalised_velocities_of_the_thesis(tmp_path, velocity, theirs):
    scan = write_scan(tmp_path / "scan", grid(load__velocity=[velocity], packing__diameter=[0.01, 0.02]))
    (row,) = table(build([scan], tmp_path, "restitution"), "sources", "Source against ours")  # two points, one value
    assert row["Source gives"].value == theirs
    assert row["Within its rounding"].text == "yes"
    assert row["Run"].text == "scan #1, #2"


def test_first_yield_of_the_source_s_spheres(tmp_path):
    run = write_run(tmp_path / "run", figures=False, packing__diameter=0.00952)
    rows = table(build([run], tmp_path, "restitution"), "sources", "Verification of the code")
    assert [row["Within its rounding"].text for row in rows] == ["yes", "yes"]


def test_other_cases_have_no_source_value_but_errata(tmp_path):
    run = write_run(tmp_path / "run", figures=False, material="steel", load__velocity=4)
    report = build([run], tmp_path, "restitution")
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
