"""Values of summary.json compared with closed forms and known counts."""

from __future__ import annotations

import json
import math
import re

import numpy as np
import pytest

from granwave.analysis import summarise, velocity_normalised, write_result
from granwave.analysis.document import model
from granwave.analysis.lammps_output import time_series
from granwave.analysis.quantities import quantity
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs import sphere_contact, struck_spheres
from granwave.lammps_inputs.packing.assembly import assemble
from tests.helpers.made_up import synthetic


def summary_of(directory, dent=synthetic.DENT, **options):
    case = synthetic.make_case(**options)
    synthetic.write_run(directory, case, dent)
    write_result(directory)
    return summarise(directory), case


def test_known_values(tmp_path):
    summary, case = summary_of(tmp_path)
    assert summary == json.loads((tmp_path / "summary.json").read_text())
    assert summary["n_spheres"] == 144
    assert summary["n_contacts"] == assemble(case).lattice.n_contacts
    assert summary["dissipated_fraction"] == pytest.approx(0.75, rel=1e-13)
    assert summary["energy_balance_error"] == pytest.approx(synthetic.BALANCE, rel=1e-6)
    assert summary["impactor_velocity_m_s"] == pytest.approx(-0.5)
    assert summary["timestep_s"] == pytest.approx(synthetic.TIMESTEP, rel=1e-14)
    assert summary["sphere_steps_per_s"] == pytest.approx(144 * synthetic.STEPS / 2.0)
    assert (summary["n_ranks"], summary["end_reason"]) == (3, "end_time")


def test_peak_force_is_that_of_the_deepest_dent(tmp_path):
    summary, case = summary_of(tmp_path)
    law = sphere_contact(case)
    assert summary["peak_force_N"] == pytest.approx(
        float(law.loading_force(np.array([synthetic.DENT * law.yield_overlap]))[0]), rel=1e-12
    )


def test_impulse_of_a_half_sine(tmp_path):
    """The integral of A sin(pi t/T) over T is 2 A T / pi; the trapezoid rule is off by (pi/n)^2/12."""
    summary, _ = summary_of(tmp_path)
    exact = 2 / math.pi * synthetic.BOTTOM_FORCE * synthetic.STEPS * synthetic.TIMESTEP
    assert summary["wall_impulse_Ns"] == pytest.approx(exact, rel=3e-5)
    assert summary["wall_peak_force_N"] == pytest.approx(synthetic.BOTTOM_FORCE, rel=1e-3)


@pytest.mark.parametrize(("velocity", "expected"), [(4, 37.9), (10, 94.9), (40, 379)])
def test_normalised_velocity_of_the_thesis(velocity, expected):
    """Thesis 5.3.2: brass of D = 10 mm; 4, 10 and 40 m/s."""
    modulus = 115e9 / (1 - 0.3**2) / 2
    assert velocity_normalised(velocity, modulus, 8500, 550e6) == pytest.approx(expected, rel=2e-3)


def test_input_is_normalised_by_first_yield(tmp_path):
    summary, case = summary_of(tmp_path)
    law = sphere_contact(case)
    unit = law.yield_force * law.yield_overlap
    assert summary["energy_input_normalised"] == pytest.approx(
        summary["energy_input_J"] / unit, rel=1e-12
    )


def test_plastic_zone_counted_by_hand(tmp_path):
    """Indentations decay as exp(-(d/D - 1/2)/1.2) from 40 alpha_y, and reach alpha_y at (1/2 + 1.2
    ln 40) D.
    """
    summary, case = summary_of(tmp_path, size=(12, 12, 8))
    lattice = assemble(case).lattice
    positions = lattice.positions(1, lattice.n_spheres)
    pairs = np.concatenate(list(lattice.pairs()))
    centre = positions[_struck(case) - 1]
    middle = 0.5 * (positions[pairs[:, 0] - 1] + positions[pairs[:, 1] - 1])
    near = np.linalg.norm(middle - centre, axis=1) < (0.5 + 1.2 * math.log(synthetic.DENT)) * 0.01
    spheres = np.unique(pairs[near]) - 1
    offset = positions[spheres] - centre
    assert summary["n_plastic_contacts"] == np.count_nonzero(near)
    assert summary["n_plastic_spheres"] == len(spheres)
    assert summary["plastic_zone_volume_m3"] == pytest.approx(
        len(spheres) * math.pi * 1e-6 / 6, rel=1e-12
    )
    assert summary["plastic_zone_depth_m"] == pytest.approx(offset[:, 2].max(), rel=1e-12)
    assert summary["plastic_zone_radius_m"] == pytest.approx(
        np.hypot(*offset[:, :2].T).max(), rel=1e-12
    )


def _struck(case):
    return struck_spheres(assemble(case).lattice, 1)[0]


def test_hertz_has_no_plastic_zone(tmp_path):
    summary, _ = summary_of(tmp_path, law="hertz", dent=5.0)
    assert summary["n_plastic_contacts"] == summary["n_plastic_spheres"] == 0
    absent = ["plastic_zone_volume_m3", "plastic_zone_depth_m", "plastic_zone_radius_m"]
    for name in (*absent, "contacts_beyond_law", "energy_input_normalised", "velocity_normalised"):
        assert summary[name] is None


def test_every_loaded_contact_of_the_bilinear_law_is_plastic(tmp_path):
    summary, case = summary_of(tmp_path, law="bilinear", dent=0.5)
    assert summary["n_plastic_contacts"] == assemble(case).lattice.n_contacts
    assert summary["contacts_beyond_law"] is None


def test_loaded_contacts_are_those_that_bore_a_force(tmp_path):
    """Spheres with scattered diameters do not touch at the start, but contacts form during the run."""
    scattered, case = summary_of(tmp_path / "scattered", packing={"diameter_scatter": 5e-6}.items())
    assert assemble(case).n_contacts == scattered["n_contacts"] == 0
    dents = assemble(synthetic.make_case()).lattice.n_contacts
    synthetic.write_run(tmp_path / "loaded", synthetic.make_case())
    path = tmp_path / "loaded" / "dumps" / "contacts.dump"
    head = path.read_text().splitlines()[:9]
    rows = np.loadtxt(path, skiprows=9)
    law = sphere_contact(case)
    rows[:10, 4:6] = 0.0  # touched, without a force
    rows[10:14, 4] = 1e-7 * law.yield_overlap  # rounding
    path.write_text(
        "\n".join([*head, *(" ".join(f"{v:.17g}" for v in row) for row in rows)]) + "\n"
    )
    write_result(tmp_path / "loaded")
    summary = summarise(tmp_path / "loaded")
    assert summary["n_contacts"] == dents and summary["n_loaded_contacts"] == dents - 14
    text = summary_table(summary)
    assert re.search(rf"contacts at the start +{dents}\nloaded contacts +{dents - 14}\n", text)
    labels = [quantity(name).label for name in ("n_contacts", "n_loaded_contacts")]
    assert labels == ["Contacts at the start", "Loaded contacts"]


def test_contacts_beyond_the_law_are_counted(tmp_path):
    """0.2 R* is 418 alpha_y for these spheres: only contacts of the impacted sphere are deeper."""
    summary, case = summary_of(tmp_path, dent=430.0)
    law = sphere_contact(case)
    assert 0.2 * law.effective_radius / law.yield_overlap == pytest.approx(417.9, rel=1e-3)
    coordination = len(assemble(case).lattice.neighbours(_struck(case)))
    assert summary["contacts_beyond_law"] == coordination
    assert summary["contacts_beyond_half_law"] >= coordination


def test_run_without_a_bottom(tmp_path):
    summary, _ = summary_of(tmp_path, boundary={"bottom": "free"})
    assert summary["wall_impulse_Ns"] is None and summary["wall_peak_force_N"] is None


def test_shares_of_yielding_and_friction(tmp_path):
    plain, _ = summary_of(tmp_path / "plain")
    assert (
        plain["plastic_fraction"] == plain["dissipated_fraction"]
        and plain["friction_fraction"] == 0
    )
    rubbing, _ = summary_of(tmp_path / "rubbing", contact={"friction": 0.1})
    assert rubbing["dissipated_fraction"] == pytest.approx(0.75, rel=1e-13)
    ratio = rubbing["friction_fraction"] / rubbing["plastic_fraction"]
    assert ratio == pytest.approx(synthetic.RUBBED, rel=1e-12)
    parts = rubbing["energy_dissipated_plastic_J"] + rubbing["energy_dissipated_friction_J"]
    assert parts == pytest.approx(rubbing["energy_dissipated_J"], rel=1e-13)
    assert 0 < rubbing["energy_rotational_J"] < rubbing["energy_kinetic_J"]


def test_what_a_damper_took_is_no_yielding(tmp_path):
    """Columns of a bottom that moves, and of the static stage."""
    case = synthetic.make_case(
        boundary={"bottom": {"plate": {"mass": 1.0, "stiffness": 1e6, "damping": 5.0}}}
    )
    synthetic.write_run(tmp_path, case)
    dumps = tmp_path / "dumps"
    table = time_series.read_energy(tmp_path)
    share = table["time"] / table["time"][-1]
    lost = 0.1 * table["dissipated"]
    table |= {"support": 1e-3 * share, "support_lost": lost, "target": 1e-3 * share + lost}
    synthetic.write_table(
        dumps / "energy.txt", " ".join(table), np.stack(list(table.values()), axis=1)
    )
    table = time_series.read_table(tmp_path, "walls.txt")
    table |= {
        "bottom_displacement": 1e-6 * (1 + share_of(table)),
        "bottom_velocity": share_of(table),
    }
    table["bottom_ground_force"] = 0.5 * table["bottom"]
    synthetic.write_table(
        dumps / "walls.txt", " ".join(table), np.stack(list(table.values()), axis=1)
    )
    (dumps / "prestage.txt").write_text("# residual largest_force stored\n1e-9 2.0 3e-4\n")
    write_result(tmp_path)
    summary = summarise(tmp_path)
    assert summary["support_lost_J"] == pytest.approx(0.1 * summary["energy_dissipated_J"])
    assert summary["energy_dissipated_plastic_J"] == pytest.approx(
        0.9 * summary["energy_dissipated_J"]
    )
    assert summary["energy_target_J"] == pytest.approx(
        summary["support_energy_J"] + summary["support_lost_J"]
    )
    assert summary["target_peak_displacement_m"] == pytest.approx(1e-6)
    assert summary["ground_peak_force_N"] == pytest.approx(0.5 * summary["wall_peak_force_N"])
    assert (summary["precompression_residual"], summary["energy_stored_J"]) == (1e-9, 3e-4)


def share_of(table):
    return table["time"] / table["time"][-1]


def test_values_are_explained(tmp_path):
    """A report explains all values of a run."""
    summary, _ = summary_of(tmp_path)
    (group,) = model.meanings([summary])
    told = {row[1].text for row in group.blocks[0].rows}
    assert "peak_reduction" in told and "support_lost_J" not in told
    assert model.unit_of_value("peak_reduction_per_kg") == "1/kg"
    assert model.unit_of_value("packing_mass_kg") == "kg"
    assert model.meanings([{"name": "x"}]) == ()
