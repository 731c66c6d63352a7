"""Units of columns, labels of compared runs, and keys that differ."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import pytest

from granwave.analysis.document.model import cell_in_unit, shared_units, units_of_values
from granwave.analysis.formatting.numbers import column_unit
from granwave.analysis.formatting.values import ratio_in_words, with_unit
from granwave.analysis.reports.comparison.subjects import compared_runs, value_text
from granwave.analysis.reports.setting import differing, setting_of
from tests.helpers.made_up.synthetic_report import build, write_run

BED = {
    "packing.kind": "file",
    "packing.source": "poured",
    "packing.grains": "x,y,z,diameter\n0,0,0,0.01\n0,0,0.01,0.01\n",
    "packing.diameter": 0.01,
}


@pytest.mark.parametrize(
    ("unit", "values", "expected"),
    [
        ("m", [0.024, 0.0005, None], ("mm", 1e-3)),
        ("m", [1.2e-5], ("µm", 1e-6)),
        ("m", [2.0, 0.001], ("m", 1.0)),
        ("s", [1e-3, 199e-6], ("µs", 1e-6)),
        ("s", [0.012], ("ms", 1e-3)),
        ("m³", [2.9e-5, 8.6e-4], ("cm³", 1e-6)),
        ("J", [0.05563], ("mJ", 1e-3)),
        ("N", [1488.0], ("N", 1.0)),
        ("N", [math.nan, 2e4], ("kN", 1e3)),
        ("m/s", [1e-5], ("m/s", 1.0)),
        ("m", [0.0, None, "none", True], ("m", 1.0)),
    ],
)
def test_unit_of_a_column(unit, values, expected):
    assert column_unit(unit, values) == expected


def test_cells_in_another_unit_sort_by_the_value():
    cell = cell_in_unit(0.0241, 1e-3, tone="note")
    assert (cell.text, cell.value, cell.tone) == ("24.1", 0.0241, "note")
    assert cell_in_unit("none", 1e-3).text == "none"


class Kind:
    of_spheres = True


def runs(*cases):
    """Return runs with these cases, called a, b, ..."""
    return [
        SimpleNamespace(label=label, case=case, kind=Kind)
        for label, case in zip("abcdef", cases, strict=False)
    ]


def labels(*cases):
    return [run.label for run in compared_runs(runs(*cases))]


def test_labels_omit_the_value_of_most_runs():
    """A run with the values of most runs has one of them, since a bare name says nothing."""
    case = {"packing.kind": "fcc", "load.velocity": 5.0, "contact.friction": 0.0}
    fast = case | {"load.velocity": 20.0}
    rough = case | {"contact.friction": 0.3}
    assert labels(case, fast, rough) == ["a: 5 m/s", "b: 20 m/s", "c: friction 0.3"]
    assert labels(case, fast) == ["a: 5 m/s", "b: 20 m/s"]


def test_grains_have_the_name_of_their_origin():
    fcc = {"packing.kind": "fcc", "packing.size": [8, 8, 5], "packing.diameter": 0.01}
    of_file = BED | {"packing.source": "scan.csv"}
    assert labels(BED, fcc)[0] == "a: poured"
    assert value_text("packing.kind", of_file) == "scan.csv"
    assert "packing.source" not in differing(runs(BED, fcc))
    assert "packing.source" in differing(runs(BED, of_file))
    assert setting_of(BED).startswith("poured packing of 2 spheres")
    assert setting_of(of_file).startswith("packing of 2 spheres of scan.csv")
    unknown = {name: value for name, value in BED.items() if name != "packing.source"}
    assert setting_of(unknown).startswith("packing of 2 spheres of a file")


def test_keys_without_effect_do_not_differ():
    plain = {"load.velocity": 1.0}
    pressed = plain | {
        "precompression.kind": "uniaxial",
        "precompression.acceleration": 9.81,
        "precompression.strikers": False,
        "load.angle": 0.0,
        "load.spin": [0.0, 0.0, 0.0],
    }
    assert differing(runs(plain, pressed)) == ["precompression.kind"]
    heavy = pressed | {"precompression.kind": "gravity"}
    assert "precompression.acceleration" in differing(runs(plain, heavy))


def test_an_unfinished_run_is_not_ranked(tmp_path):
    """The zone is small because the run has hardly started; a badge marks the run as unfinished."""
    paths = []
    for name, depth in (("a", 0.02), ("b", 0.03), ("c", 0.001)):
        values = {"zone_depth_90_interpolated_m": depth, "end_time_s": 1e-4}
        paths.append(write_run(tmp_path / name, figures=False, **values))
    record = paths[2] / "run.json"
    record.write_text('{"state": "interrupted", "name": "c"}')
    report = build(paths, tmp_path)
    texts = [str(dataclasses.asdict(section)) for section in report.sections]
    assert "a has the shallower plastic zone" in texts[0]
    assert "not finished: 1 of 3" in [badge.text for badge in report.badges]


def test_energies_of_a_table_have_one_unit():
    rows = {
        "input": ("J", [0.0556, 5.6e-6]),
        "kinetic": ("J", [1e-7, None]),
        "depth": ("m", [0.02]),
        "force": ("N", [10.0, 2e4]),
    }
    assert shared_units(rows) == {
        "input": ("mJ", 1e-3),
        "kinetic": ("mJ", 1e-3),
        "depth": ("mm", 1e-3),
        "force": ("kN", 1e3),
    }
    assert shared_units({"input": ("J", [0.0])}) == {"input": ("J", 1.0)}
    keys = ("energy_elastic_J", "energy_input_J", "peak_force_N")
    summaries = [{"energy_elastic_J": 1e-9, "energy_input_J": 2.0}]
    units = units_of_values(keys, summaries)
    assert [units[key] for key in keys] == [("J", 1.0), ("J", 1.0), ("N", 1.0)]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Speed over c0, force added 10 N", "Speed divided by c0, force added 10 N"),
        (
            "Restitution with a rate, over that without",
            "Restitution with a rate, divided by that without",
        ),
        ("Largest difference over all N2", None),
        ("First peak: spread over the numbers of cylinders", None),
        ("N2 over which V approaches its limit", None),
        ("Impulse: integral of the force over time", None),
    ],
)
def test_ratios_are_in_words(name, expected):
    assert ratio_in_words(name) == (expected or name)


@pytest.mark.parametrize(
    ("unit", "expected"),
    [("um", "7 µm"), ("us", "7 µs"), ("1e-3", "7 × 10⁻³"), ("1e4", "7 × 10⁴"), ("J/N^2", "7 J/N²"),
     ("rad/s", "7 rad/s"), ("", "7")],
)  # fmt: skip
def test_units_of_rows_are_printed_as_symbols(unit, expected):
    assert with_unit("7", unit) == expected
