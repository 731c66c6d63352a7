"""Formats of numbers and of case values that are tables, in tables and figures."""

from __future__ import annotations

import pytest

from granwave.analysis.formatting.numbers import interval, tick, with_interval
from granwave.analysis.formatting.values import as_label, shown_unit, unique_labels
from granwave.analysis.statistics import estimate, exactly


@pytest.mark.parametrize(
    ("mean", "half_width", "text"),
    [
        (0.901453, 0.00131, "0.9015 ± 0.0013"),
        (0.7, 0.2484, "0.70 ± 0.25"),
        (1232.8, 38.2, "1233 ± 38"),
        (1020.0, 182.0, "1020 ± 180"),
        (4.623e-4, 7.6e-6, "(4.623 ± 0.076)e-4"),
        (0.5, 0.0996, "0.50 ± 0.10"),  # two digits after rounding, no more
        (0.0, 0.5, "0.00 ± 0.50"),
        (-3.0, 20.0, "-3 ± 20"),
        (2.5e7, 1.2e5, "(2.500 ± 0.012)e7"),
        (0.9, 1e-12, "0.9 ± 1.0e-12"),
    ],
)
def test_a_mean_has_the_digits_that_its_interval_allows(mean, half_width, text):
    assert interval(mean, half_width) == text


def test_intervals_of_estimates():
    assert with_interval(estimate([0.6, 0.7, 0.8]), unit="N") == "0.70 ± 0.25 N"  # 4.303 x 0.1 / sqrt 3
    assert with_interval(exactly(1234.5)) == "1230"


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (20000, "20000"),
        (1e5, "1e5"),
        (2.5e5, "2.5e5"),
        (0.0042, "0.0042"),
        (1.3e-5, "1.3e-5"),
        (-3.5, "-3.5"),
    ],
)
def test_ticks(value, text):
    assert tick(value) == text


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ({"plate": {"mass": 5, "stiffness": 5e9}}, "plate mass=5 stiffness=5e9"),
        ('{"half_space": {}, "material": {"name": "concrete", "density": 2447}}', "half_space, concrete"),
        ('{"bar": {"length": 0.5, "area": 0.0125}, "material": "steel"}', "bar length=0.5 area=0.0125, steel"),
        ({"material": {"name": "steel"}}, "wall, steel"),
        ('{"preset": "steel", "yield_strength": 21000000.0}', "steel yield_strength=2.1e7"),
        ('[{"index": 2, "material": "steel"}, {"index": 3}]', "index=2, steel; index=3"),
        ('{"force": 300}', "force=300"),
        ("[24, 24, 6]", "[24, 24, 6]"),
        ("{broken", "{broken"),
        ("wall", "wall"),
        ("", "none"),
    ],
)
def test_tables_of_cases_in_words(value, words):
    assert as_label(value) == words


def test_different_tables_have_different_words():
    first, second = '{"name": "a", "density": 1}', '{"name": "a", "density": 2}'
    assert unique_labels([first, second, first, "", "a (2)"]) == ["a", "a (2)", "a", "none", "a (2) (2)"]


def test_units_within_a_bottom():
    assert shown_unit("boundary.bottom.plate.stiffness") == "N/m"
    assert shown_unit("boundary.bottom.bar.area") == "m²"
    assert shown_unit("boundary.bottom.material.density") == "kg/m³"
    assert shown_unit("boundary.bottom") == ""
