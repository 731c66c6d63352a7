"""Values of summaries of finite elements, and where they are shown."""

from __future__ import annotations

import fnmatch
from fnmatch import fnmatchcase

import pytest

from granwave.analysis.formatting.values import unit_of
from granwave.analysis.quantities import (
    entries,
    quantities,
    report_columns,
    scan_columns,
    scan_figures,
)
from granwave.extensions.continuum.case_keys import CASE_KEYS
from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.punch.run import run_continuum
from granwave.extensions.continuum.quantities import CONTINUUM_ROWS, QUANTITIES
from granwave.extensions.continuum.sphere_contact import SphereContactCase
from granwave.extensions.continuum.sphere_contact.run import run_sphere_contact
from granwave.workflows.cli.keys.reference import tables

COMMON = {"name": "small", "material": "brass"}
CONTACT = {
    "sphere": {"radius": 0.005},
    "run": {"elements": 500, "unloadings": 1, "max_overlap": 0.005},
}


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    """Summaries of a punch and of two spheres."""
    place = tmp_path_factory.mktemp("runs")
    punch = ContinuumCase.from_dict(COMMON | {"run": {"elements": 500}})
    contact = SphereContactCase.from_dict(COMMON | CONTACT)
    return [
        run_continuum(punch, place / "punch", figures=False),
        run_sphere_contact(contact, place / "contact", figures=False),
    ]


def test_every_value_has_an_entry_and_every_entry_a_value(summaries):
    punch, contact = summaries
    keys = [*punch, *contact]
    known = list(quantities())
    for key in keys:
        assert any(fnmatchcase(key, name) for name in known), key
    for entry in QUANTITIES:
        assert fnmatch.filter(keys, entry.name), entry.name


def test_values_are_shown_with_their_digits(summaries):
    for entry in (*CONTINUUM_ROWS, *scan_columns()):
        values = [summary.get(entry.name) for summary in summaries]
        assert entry.digits or not any(isinstance(value, float) for value in values), entry.name


def test_values_have_their_places_among_those_of_packings():
    assert set(QUANTITIES) <= set(entries())
    columns = list(report_columns())
    assert columns.index("n_elements") == columns.index("n_spheres") + 1
    assert [entry.name for entry in scan_columns()][-2:] == [
        "max_force_N",
        "force_deviation_rms_percent",
    ]
    assert scan_figures(())["max_force"] == "max_force_N"


def test_units_of_keys_are_those_of_the_cases():
    units = {}
    for table in tables():
        if table.file == "continuum":
            units |= {f"{table.name}.{key.name}": key.unit for key in table.keys if key.unit}
    keys = {name for name in CASE_KEYS if unit_of(name)}
    assert keys >= {"punch.mass", "run.edge_size"}
    assert {name: unit_of(name) for name in keys} == {name: units[name] for name in keys}
