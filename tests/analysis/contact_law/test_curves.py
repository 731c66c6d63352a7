"""Curves of contact laws, and coefficients of restitution compared with runs."""

from __future__ import annotations

import csv
import json
import logging
import math

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from granwave.analysis import law_table, write_law
from granwave.analysis.contact_law.curves import curve_of, restitution, write_restitution
from granwave.lammps_inputs.case.material import material, sphere_mass
from granwave.lammps_inputs.contact.law import contact_of
from granwave.lammps_inputs.load_case import load_case
from granwave.workflows import library
from granwave.workflows.run.driver import run_case
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import value


def contact(law="elastoplastic", strength=550e6):
    bodies = {
        "youngs_modulus": 115e9,
        "poisson_ratio": 0.3,
        "yield_strength": strength,
        "radius": 5e-3,
    }
    return ContactLaw(law, **{name: (one, one) for name, one in bodies.items()})


@pytest.mark.parametrize(
    ("peak", "force"), [(2, 2.4711), (10, 24.3497), (50, 197.692), (200, 962.643), (400, 2064.69)]
)
def test_loading_ends_at_the_check_values(peak, force):
    """Check values of the elastoplastic law, default variant."""
    table = law_table(contact(), peak)
    loading = table["branch"] == "loading"
    assert table["overlap_normalised"][loading][-1] == pytest.approx(peak, rel=1e-12)
    assert table["force_normalised"][loading][-1] == pytest.approx(force, rel=2e-5)


@pytest.mark.parametrize(("peak", "lost"), [(10, 51.993), (50, 3051.69), (200, 75500.0)])
def test_area_between_loading_and_unloading_is_what_is_lost(peak, lost):
    table = law_table(contact(), peak)
    keys = ("force_normalised", "overlap_normalised")
    area = {name: abs(np.trapezoid(*(table[key][table["branch"] == name] for key in keys)))
            for name in ("loading", "unloading_4", "reloading_4")}  # fmt: skip
    assert area["loading"] - area["unloading_4"] == pytest.approx(lost, rel=1e-3)
    assert area["unloading_4"] == pytest.approx(area["reloading_4"], rel=1e-12)


@pytest.mark.parametrize(
    "law", ["elastoplastic", "elastoplastic-fe", "hertz", "bilinear", "thornton"]
)
def test_branches_meet_where_unloading_starts(law):
    table = law_table(contact(law), 40)
    top = table["force_N"][table["branch"] == "loading"].max()
    for name in ("unloading_4", "reloading_4"):
        assert table["force_N"][table["branch"] == name].max() == pytest.approx(top, rel=1e-12)


def test_material_without_a_yield_strength():
    table = law_table(contact("hertz", math.inf), 100)
    assert table["overlap_m"].max() == pytest.approx(0.01 * 2.5e-3)
    assert np.isnan(table["force_normalised"]).all()


def test_files(tmp_path):
    write_law(contact(), tmp_path / "law.csv")
    with open(tmp_path / "law.csv") as file:
        assert next(csv.reader(file)) == [
            "branch",
            "overlap_m",
            "force_N",
            "overlap_normalised",
            "force_normalised",
        ]
    write_law(contact(), tmp_path / "plot.png", title="brass")
    assert all(
        (tmp_path / f"plot.{suffix}").stat().st_size > 1000 for suffix in ("png", "pdf", "csv")
    )
    with pytest.raises(ValueError, match=r"expected \.png, \.pdf or \.csv"):
        write_law(contact(), tmp_path / "law.txt")
    with pytest.raises(ValueError, match="expected a positive number"):
        law_table(contact(), -1.0)


def test_error_bars_of_the_fitted_law_are_in_table_and_figure(tmp_path):
    law = contact("elastoplastic-fe")
    table = law_table(law, 40)
    loading = table["branch"] == "loading"
    overlap = table["overlap_m"][loading]
    np.testing.assert_allclose(
        table["force_error_N"][loading], law.force_error(overlap, overlap), rtol=1e-12
    )
    down = table["branch"] == "unloading_4"
    bar = table["force_error_N"][down] / table["force_N"].max()
    assert np.all(bar > 0.01) and np.all(bar < 0.15)
    write_law(law, tmp_path / "fe.png")
    assert (tmp_path / "fe.csv").read_text().splitlines()[0].endswith("force_error_N")
    write_restitution({"pair": (law, MASS / 2)}, tmp_path / "e.png")
    header, *rows = csv.reader((tmp_path / "e.csv").open())
    assert header[-1] == "restitution_error"
    assert 0 < float(rows[-1][-1]) < 0.05 * float(rows[-1][-2])


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
    lmp.commands_string(
        script_of([(0, 0, 0), (0, 0, 2 * R)], velocities=[(0, 0, velocity), (0, 0, 0)], style=style)
    )
    lmp.commands_string("timestep 5e-9\nrun 30000")
    found = (value(lmp, "vz[2]") - value(lmp, "vz[1]")) / velocity
    assert found == pytest.approx(at(velocity, contact_of([BRASS], [R], law), MASS / 2), rel=1e-3)


@pytest.mark.parametrize("velocity", [0.02, 0.5, 3.0, 20.0])
def test_sphere_and_wall(lammps, velocity):
    lmp = lammps()
    wall = f"fix floor all wall/gran/hysteretic zplane NULL {R:.17g} elastoplastic 115e9 0.3 550e6"
    lmp.commands_string(
        script_of(
            [(0, 0, 0)],
            velocities=[(0, 0, velocity)],
            box=[-0.1, 0.1, -0.1, 0.1, -0.1, 0.1],
            extra=wall,
        )
    )
    lmp.commands_string("timestep 5e-9\nrun 30000")
    assert -value(lmp, "vz[1]") / velocity == pytest.approx(
        at(velocity, contact_of((BRASS, None), (R, math.inf)), MASS), rel=1e-3
    )


def test_slow_collisions_lose_nothing():
    velocities, values = restitution(contact_of([BRASS], [R]), MASS / 2)
    law = contact_of([BRASS], [R])
    yield_velocity = np.sqrt(2 * law.loading_work(law.yield_overlap) / (MASS / 2))
    assert np.all(values[velocities < yield_velocity] == 1)
    assert np.all(np.diff(values) <= 1e-12) and values[-1] < 0.35


def test_table_and_figure(granwave, tmp_path):
    done = granwave(
        "law", "--restitution", "--material", "brass", "steel", "-o", "e.csv", cwd=tmp_path
    )
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
        assert -ratio == pytest.approx(
            at(1.0, contact_of((BRASS, None), (R, math.inf)), MASS), rel=1e-3
        )


@pytest.mark.parametrize("study", ["two-spheres", "sphere-on-wall"])
def test_the_summary_has_the_error_bars_of_the_law(tmp_path, study):
    """Error bars exist for law elastoplastic-fe only; a sphere and its mirror plane are half of two spheres."""
    changes = {"contact.law": "elastoplastic-fe", "run.frames": 2}
    summary = run_case(
        load_case(library.find(study), changes), tmp_path / "fe", figures=False
    ).summary
    other = BRASS if study == "two-spheres" else None
    law = contact_of((BRASS, other), (R, R if other else math.inf), "elastoplastic-fe")
    if study == "two-spheres":
        peak = summary["peak_overlap_m"]
        assert summary["peak_force_error_N"] == pytest.approx(law.force_error(peak, peak))
        assert summary["restitution_error"] == pytest.approx(law.restitution_error(peak))
    else:
        assert summary["peak_force_error_N"] is None  # no pair of grains
    relative = summary["restitution_error"] / summary["restitution"]
    assert 0.01 < relative < 0.1
    rate = {"material.rate_sensitivity": 0.01}
    fast = run_case(
        load_case(library.find(study), changes | rate), tmp_path / "rate", figures=False
    ).summary
    assert fast["peak_force_error_N"] is None and fast["restitution_error"] is None


def test_bodies_that_still_touch_at_the_end_have_none(tmp_path):
    """An impact at 0.05 m/s lasts 72 us, and nothing yields."""
    changes = {"load.velocity": 0.05, "run.frames": 2}
    found = [
        run_case(
            load_case(library.find("two-spheres"), changes | end), tmp_path / name, figures=False
        ).summary
        for name, end in (("short", {"run.end_time": 5e-5}), ("whole", {"run.end_time": 2e-4}))
    ]
    assert found[0]["restitution"] is None
    assert found[1]["restitution"] == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("in_order", [True, False])
def test_rows_out_of_the_order_of_measurement_are_named(caplog, in_order):
    """Unloading from the peak and from half of it, after complete loading."""
    rise = np.linspace(0.0, 1e-5, 101)
    turn = rise[-1] if in_order else rise[50]
    overlap = np.concatenate([rise, np.linspace(turn, 3e-6, 60)])
    with caplog.at_level(logging.WARNING, "granwave"):
        curve_of(overlap, overlap)
    jumps = "the overlap jumps from 10 to 5 µm at row 102" in caplog.text
    assert jumps != in_order
    assert bool(caplog.text) != in_order
