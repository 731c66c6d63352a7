"""The registry of quantities: every value of a summary has an entry, every entry is a value of some run."""

from __future__ import annotations

import json
from fnmatch import fnmatchcase

import pytest

from granwave.analysis.quantities import (
    CONTINUUM_ROWS,
    ENTRIES,
    QUANTITIES,
    REPORT_COLUMNS,
    RUN_ROWS,
    SCAN_COLUMNS,
    SCAN_FIGURES,
    quantity,
)
from granwave.workflows import load_case, run_case
from granwave.workflows.finite_elements.punch import ContinuumCase
from granwave.workflows.finite_elements.punch.run import run_continuum
from granwave.workflows.finite_elements.sphere_contact import SphereContactCase
from granwave.workflows.finite_elements.sphere_contact.run import run_sphere_contact
from tests.golden.outputs import FOLDER, SUMMARIES

SHORT = {"run.end_time": 1e-6}
BARS_AND_SENSORS = ("split-hopkinson", "composite-chain", "square-in-plane")
RESISTANCE = {"contact.friction": 0.2, "contact.rolling": 0.01, "contact.twisting": "marshall"}
COHESION = {"contact.law": "hertz", "contact.cohesion": {"kind": "jkr", "energy": 0.1}}
CONTACT = {"sphere": {"radius": 0.005}, "run": {"elements": 500, "unloadings": 1, "max_overlap": 0.005}}


@pytest.fixture(scope="module")
def summaries(tmp_path_factory):
    """Summaries of runs of all kinds; most granular ones are golden, and held against runs there."""
    place = tmp_path_factory.mktemp("runs")
    common = {"name": "small", "material": "brass"}
    found = list(json.loads((FOLDER / SUMMARIES).read_text()).values())
    found += [run_case(load_case(n, SHORT), place / n, figures=False).summary for n in BARS_AND_SENSORS]
    crystal = {"packing.size": [3, 4], "run.end_time": 1e-4}
    found.append(run_case(load_case("lateral-square", crystal), place / "crystal", figures=False).summary)
    resisting = load_case("fcc-small", SHORT | RESISTANCE | COHESION)
    found.append(run_case(resisting, place / "resisting", figures=False).summary)
    punch = ContinuumCase.from_dict(common | {"run": {"elements": 500}})
    found.append(run_continuum(punch, place / "punch", figures=False))
    contact = SphereContactCase.from_dict(common | CONTACT)
    found.append(run_sphere_contact(contact, place / "contact", figures=False))
    return found


def test_every_value_has_an_entry_and_every_entry_a_value(summaries):
    keys = {key for summary in summaries for key in summary}
    assert sorted(key for key in keys if not any(fnmatchcase(key, name) for name in QUANTITIES)) == []
    assert sorted(name for name in QUANTITIES if not any(fnmatchcase(key, name) for key in keys)) == []


def test_values_are_shown_with_their_digits(summaries):
    """A number with decimals has a format where it is shown at the terminal."""
    for entry in (*RUN_ROWS, *CONTINUUM_ROWS, *SCAN_COLUMNS):
        assert entry.digits or not any(isinstance(summary.get(entry.name), float) for summary in summaries), entry.name


def test_what_is_shown_has_one_entry():
    assert len(ENTRIES) == len(QUANTITIES)
    assert set(REPORT_COLUMNS) <= set(QUANTITIES)
    assert all(QUANTITIES[name].axis for name in SCAN_FIGURES.values())


def test_names_end_in_units():
    capitals = [entry for entry in ENTRIES if not entry.name.rpartition("_")[2].islower()]
    assert len(capitals) > 20 and [entry.name for entry in capitals if not entry.unit] == []
    names = ("wave_speed_m_s", "sensor_A_peak_acceleration_m_s2", "peak_reduction_per_kg", "packing_mass_kg", "n_steps")
    assert [quantity(name).unit for name in names] == ["m/s", "m/s^2", "1/kg", "kg", ""]


def test_value_without_an_entry_is_called_by_its_name():
    found = quantity("largest_spin_per_s")
    assert (found.label, found.unit, found.heading) == ("Largest spin", "1/s", "largest spin (1/s)")
    assert quantity("sensor_A_peak_force_N").label == "Sensor A peak force"
