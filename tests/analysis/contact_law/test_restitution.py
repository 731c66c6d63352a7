"""Coefficient of restitution: closed form of the law, against runs of two spheres and of a sphere and a wall."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

from granwave.analysis.contact_law.curves import restitution
from granwave.lammps_inputs.case.material import material, sphere_mass
from granwave.lammps_inputs.contact.law import contact_of, rigid_wall_contact_of
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import library
from granwave.workflows.run.driver import run_case
from tests.conftest import script_of
from tests.helpers.two_spheres import value

R = 0.005
BRASS = material("brass")
MASS = sphere_mass(BRASS, R)


def at(velocity, law, mass):
    velocities, values = restitution(law, mass)
    return np.interp(velocity, velocities, values)


@pytest.mark.parametrize("law", ["elastoplastic", "bilinear", "thornton"])
@pytest.mark.parametrize("velocity", [0.02, 0.08, 0.5, 3.0, 20.0])
def test_two_spheres(lammps, law, velocity):
    lmp = lammps()
    style = f"{law} 115e9 0.3 550e6" + (" beta 0.8" if law == "bilinear" else "")
    lmp.commands_string(script_of([(0, 0, 0), (0, 0, 2 * R)], velocities=[(0, 0, velocity), (0, 0, 0)], style=style))
    lmp.commands_string("timestep 5e-9\nrun 30000")
    found = (value(lmp, "vz[2]") - value(lmp, "vz[1]")) / velocity
    assert found == pytest.approx(at(velocity, contact_of([BRASS], [R], law), MASS / 2), rel=1e-3)


@pytest.mark.parametrize("velocity", [0.02, 0.5, 3.0, 20.0])
def test_sphere_and_wall(lammps, velocity):
    lmp = lammps()
    wall = f"fix floor all wall/gran/hysteretic zplane NULL {R:.17g} elastoplastic 115e9 0.3 550e6"
    lmp.commands_string(
        script_of([(0, 0, 0)], velocities=[(0, 0, velocity)], box=[-0.1, 0.1, -0.1, 0.1, -0.1, 0.1], extra=wall)
    )
    lmp.commands_string("timestep 5e-9\nrun 30000")
    assert -value(lmp, "vz[1]") / velocity == pytest.approx(
        at(velocity, rigid_wall_contact_of(BRASS, R), MASS), rel=1e-3
    )


def test_slow_collisions_lose_nothing():
    velocities, values = restitution(contact_of([BRASS], [R]), MASS / 2)
    law = contact_of([BRASS], [R])
    yield_velocity = np.sqrt(2 * law.loading_work(law.yield_overlap) / (MASS / 2))
    assert np.all(values[velocities < yield_velocity] == 1)
    assert np.all(np.diff(values) <= 1e-12) and values[-1] < 0.35


def test_table_and_figure(granwave, tmp_path):
    done = granwave("law", "--restitution", "--material", "brass", "steel", "-o", "e.csv", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "e.csv").open()))
    assert set(rows[0]) == {"contact", "velocity_m_s", "restitution"}
    assert granwave("law", "--restitution", cwd=tmp_path).returncode == 0
    assert (tmp_path / "restitution.png").exists() and (tmp_path / "restitution.pdf").exists()


@pytest.mark.parametrize("study", ["two-spheres", "sphere-on-wall"])
def test_built_in_studies(granwave, tmp_path, study):
    done = granwave("run", study, "-o", tmp_path / "r")
    assert done.returncode == 0, done.stderr
    ratio = json.loads((tmp_path / "r" / "summary.json").read_text())["impactor_velocity_m_s"]
    if study == "two-spheres":
        assert 1 - 2 * ratio == pytest.approx(at(1.0, contact_of([BRASS], [R]), MASS / 2), rel=1e-3)
    else:
        assert -ratio == pytest.approx(at(1.0, rigid_wall_contact_of(BRASS, R), MASS), rel=1e-3)


def test_bodies_that_still_touch_at_the_end_have_none(tmp_path):
    """A blow at 0.05 m/s lasts 75 us; the automatic end comes after 50 us, in which nothing yields."""
    changes = {"load.velocity": 0.05, "run.frames": 2}
    found = [
        run_case(load_case(library.find("two-spheres"), changes | end), tmp_path / name, figures=False).summary
        for name, end in (("auto", {}), ("whole", {"run.end_time": 2e-4}))
    ]
    assert found[0]["restitution"] is None
    assert found[1]["restitution"] == pytest.approx(1.0, abs=1e-4)
