"""First sentences and values of the reports of runs that are no simple impacts, and of what is no run."""

from __future__ import annotations

from pathlib import Path

import pytest

from granwave.analysis.reports.inputs import Run, read_inputs
from granwave.analysis.reports.sections.outcome import in_words
from granwave.analysis.reports.sections.results import value_rows
from granwave.lammps_inputs.errors import InputError


def run_with(case=None, **summary):
    return Run("one", "run", Path(), "done", summary, case or {}, {})


def labels(run):
    return [row[0].text for row in value_rows(run).rows]


def test_a_driven_row():
    run = run_with(
        energy_input_J=2e-7, dissipated_fraction=0.95, absorbed_fraction=0.9, transmission=0.5,
        driven_velocity_m_s=4e-4, peak_reduction=20.0, impactor_velocity_m_s=1e-4,
    )  # fmt: skip
    words = in_words(run)
    assert words.startswith("90 % of the 2e-7 J put in was taken by absorbing spheres, and 5 % was dissipated.")
    assert "0.5 of the driven end's velocity, 0.0004 m/s, came through." in words
    assert labels(run)[0] == "Transmission"
    assert not {"Peak reduction", "Struck sphere at the end"} & set(labels(run))


def test_a_plate():
    run = run_with(energy_input_J=9.0, dissipated_fraction=0.3, plate_velocity_m_s=-3.5, impactor_velocity_m_s=-3.0)
    assert "The plate rebounds with 3.5 m/s." in in_words(run)
    assert labels(run)[0] == "Plate at the end" and "Struck sphere at the end" not in labels(run)


@pytest.mark.parametrize(("law", "shown"), [("elastoplastic", True), ("hertz", False), ("line", False)])
def test_values_of_yielding_where_the_law_yields(law, shown):
    run = run_with({"contact.law": law}, dissipated_fraction=0.0, n_plastic_contacts=0)
    assert ("Yielded contacts" in labels(run)) == shown


def test_inferred_forces():
    run = run_with(
        kind="inference",
        n_grains=48,
        n_contacts=104,
        n_loaded_contacts=9,
        largest_force_N=179.8,
        residual_fraction=0.05,
    )
    assert in_words(run) == (
        "9 of 104 contacts bear a force, at most 179.8 N. What these forces leave unexplained is 5 % of the data."
    )
    assert labels(run)[:3] == ["Grains", "Contacts", "Contacts that bear a force"]


def test_bands_are_no_run(tmp_path):
    for name in ("bands.json", "bands.csv"):
        (tmp_path / name).write_text("{}")
    with pytest.raises(InputError, match=r"is the result of granwave bands, expected a run or a scan; .*bands\.csv"):
        read_inputs([tmp_path], tmp_path)
