"""Fit of measured restitution: recovery, error bars, undetermined constants, files and messages."""

from __future__ import annotations

import csv
import dataclasses
import logging
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis.contact_law.curves import write_restitution
from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.law_fit.fit_output import fit_toml
from granwave.extensions.continuum.law_fit.fitted_law import YIELD
from granwave.extensions.continuum.law_fit.rebounds import Rebounds, read_rebounds, rebounds_of
from granwave.extensions.continuum.law_fit.restitution_fit import (
    effective_mass,
    fit_restitution,
    overlap_at,
    restitution_at,
)
from granwave.extensions.continuum.terminal import fit
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.case.material import material
from granwave.lammps_inputs.contact.law import contact_of, sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case
from tests.extensions.continuum.test_fit import options

R = 0.005
BRASS = material("brass")
STRENGTH = 430e6
TRUE = dataclasses.replace(BRASS, yield_strength=STRENGTH)
LAW = contact_of([TRUE], [R])
MASS = effective_mass([BRASS], [R])
VELOCITY = np.geomspace(0.005, 10.0, 15)


def collided(law=LAW, mass: float = MASS, velocity=VELOCITY) -> np.ndarray:
    """Coefficients of restitution of collisions integrated in time, without the closed forms of the
    energies.
    """
    return np.array([law.collide(mass, float(v), steps=4000)["restitution"] for v in velocity])


RESTITUTION = collided()


def noisy(seed: int, noise: float = 0.01) -> Rebounds:
    """Rebounds with noise."""
    scatter = noise * np.random.default_rng(seed).standard_normal(VELOCITY.size)
    return rebounds_of(VELOCITY, RESTITUTION + scatter)


def test_yield_strength_of_exact_rebounds():
    found = fit_restitution(rebounds_of(VELOCITY[::-1], RESTITUTION[::-1]), [BRASS], [R])
    assert found.value(YIELD) == pytest.approx(STRENGTH, rel=1e-4)
    assert found.materials[0].yield_strength == found.value(YIELD)
    assert found.constants == LAW_CONSTANTS
    assert found.misfit.largest_percent.max() < 0.01
    assert found.misfit.published_largest_percent.max() > 5  # 550 MPa
    assert dict(zip(found.misfit.part, found.misfit.rows, strict=True)) == {
        "impacts without yield": 4,
        "impacts beyond it": 11,
    }


def test_a_material_without_a_yield_strength():
    """The search starts at Young's modulus; there are no published constants for comparison."""
    bare = dataclasses.replace(BRASS, yield_strength=None)
    found = fit_restitution(rebounds_of(VELOCITY, RESTITUTION), [bare], [R])
    assert found.value(YIELD) == pytest.approx(STRENGTH, rel=1e-4)


def test_further_constants():
    other = LAW_CONSTANTS | {"unloading_exponent": 1.6}
    law = contact_of([TRUE], [R], constants=other)
    rebounds = rebounds_of(VELOCITY, collided(law))
    found = fit_restitution(rebounds, [BRASS], [R], ["unloading_exponent"])
    assert found.value(YIELD) == pytest.approx(STRENGTH, rel=1e-3)
    assert found.value("unloading_exponent") == pytest.approx(1.6, rel=1e-3)
    assert not found.undetermined("unloading_exponent")


def test_sphere_on_a_plane_of_another_material():
    """The effective mass is the mass of the sphere; the softer material yields."""
    steel = material("steel")
    law = contact_of([steel, TRUE], [R, math.inf])
    mass = 4 / 3 * math.pi * R**3 * steel.density
    velocity = np.geomspace(0.05, 5, 8)
    rebounds = rebounds_of(velocity, collided(law, mass, velocity))
    found = fit_restitution(rebounds, [steel, BRASS], [R, math.inf])
    assert found.mass == pytest.approx(mass)
    assert found.value(YIELD) == pytest.approx(STRENGTH, rel=1e-3)


def test_error_bars():
    """Noise of 0.01: the scatter over many sets of impacts is the stated uncertainty."""
    pulls = []
    for seed in range(8):
        found = fit_restitution(noisy(seed), [BRASS], [R])
        pulls.append((found.value(YIELD) - STRENGTH) / found.uncertainty[YIELD])
    assert abs(np.mean(pulls)) < 1.0
    assert 0.5 < np.std(pulls) < 1.7


def test_what_restitution_does_not_tell_is_said():
    found = fit_restitution(noisy(1), [BRASS], [R])
    assert found.state(YIELD) == "fitted"
    assert "not determined by restitution (+-" in found.state("area_switch")
    assert found.state("residual_slope").startswith("fixed: --free residual_slope would determine")
    both = fit_restitution(noisy(1), [BRASS], [R], ["area_switch"])
    assert both.undetermined("area_switch")
    # the spread that was foretold is that of the fit
    ratio = both.uncertainty["area_switch"] / (
        found.told["area_switch"] * LAW_CONSTANTS["area_switch"]
    )
    assert 0.3 < ratio < 3


def test_elastic_impacts_tell_no_yield_strength(caplog):
    slow = np.linspace(0.05, 0.5, 10)
    noise = 0.002 * np.random.default_rng(3).standard_normal(slow.size)
    with caplog.at_level(logging.WARNING, "granwave"):
        found = fit_restitution(rebounds_of(slow, 1 + noise), [material("glass")], [R])
    assert found.undetermined(YIELD)
    assert "not determined" in found.state(YIELD)
    assert "the yield strength is not determined" in caplog.text
    assert "another source of dissipation" not in caplog.text


def test_a_loss_of_another_kind_is_named(caplog):
    velocity = np.geomspace(0.001, 5, 20)
    lossy = 0.95 * restitution_at(LAW, MASS, velocity)
    with caplog.at_level(logging.WARNING, "granwave"):
        fit_restitution(rebounds_of(velocity, lossy), [BRASS], [R])
    assert "rebound with 0.950 of their velocity" in caplog.text
    assert "contact.loss" in caplog.text


def test_impacts_beyond_the_law_are_counted(caplog):
    velocity = np.array([1.0, 5.0, 10.0, 100.0, 200.0])
    with caplog.at_level(logging.WARNING, "granwave"):
        fit_restitution(rebounds_of(velocity, restitution_at(LAW, MASS, velocity)), [BRASS], [R])
    overlap = overlap_at(LAW, MASS, velocity)
    beyond = np.count_nonzero(overlap > 0.2 * LAW.effective_radius)
    assert beyond == 2
    assert "2 impacts, from 100 m/s on" in caplog.text


def test_velocities_go_with_the_strength_to_the_power_five_halves():
    stronger = dataclasses.replace(TRUE, yield_strength=2 * STRENGTH)
    law = contact_of([stronger], [R])
    ours = restitution_at(law, MASS, VELOCITY * 2**2.5)
    assert ours == pytest.approx(restitution_at(LAW, MASS, VELOCITY), abs=1e-4)


def test_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Rows of one contact of `granwave law --restitution`, in cm/s, and the case of the fit."""
    write_restitution({"two spheres": (LAW, MASS)}, tmp_path / "law.csv")
    rows = list(csv.DictReader((tmp_path / "law.csv").open()))[::20]
    table = {
        "velocity_cm_s": np.array([100 * float(row["velocity_m_s"]) for row in rows]),
        "restitution": np.array([float(row["restitution"]) for row in rows]),
    }
    write_csv(table, tmp_path / "drops.csv")
    asked = options(tmp_path / "drops.csv", tmp_path / "out", pair=["brass", "rigid"])
    assert fit(asked) == 0
    shown = capsys.readouterr().out
    assert "contacts yield from" in shown
    assert "fixed: --free unloading_exponent would determine it to" in shown
    case = load_case(tmp_path / "out" / "fit.toml")
    assert case.material.yield_strength == pytest.approx(STRENGTH, rel=1e-3)
    assert sphere_contact(case).constants == LAW_CONSTANTS
    assert (tmp_path / "out" / "pair.toml").is_file()
    drawn = list(csv.DictReader((tmp_path / "out" / "figures" / "fit.csv").open()))
    assert len(drawn) == len(rows)
    assert max(abs(float(row["deviation"])) for row in drawn) < 1e-3
    with pytest.raises(InputError, match=r"--fit-zero: found with .*drops.csv, a table of rest"):
        fit(options(tmp_path / "drops.csv", tmp_path / "x", fit_zero=True))
    assert not (tmp_path / "x").exists()


HEAD = "velocity_m_s,restitution\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v,restitution\n1,0.5\n", "found v, restitution, expected one column velocity_m_s or"),
        ("velocity_mm_s," + HEAD + "1,1,1\n", "found velocity_m_s and velocity_mm_s"),
        (HEAD + "1,0.9\n2,87\n", r'3: restitution: found "87", expected a ratio from 0 to 1, not'),
        (HEAD + "0,0.9\n", r'line 2: velocity_m_s: found "0", expected a velocity above 0'),
        (HEAD + "1,\n", r'line 2: restitution: found "", expected a number'),
        (HEAD, "found 0 impacts, expected at least 3 to fit 1 value"),
        (HEAD + "1,0.8\n2,0.7\n", "found 2 impacts, expected at least 3 to fit 1 value"),
        ("contact," + HEAD + "a,1,0.8\nb,1,0.7\n", r"contact: found 2 contacts \(a, b\), expected"),
    ],
)  # fmt: skip
def test_wrong_tables(tmp_path: Path, text: str, message: str):
    path = tmp_path / "drops.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as refused:
        fit(options(path, tmp_path / "out"))
    assert len(refused.value.errors) == 1
    assert "drops.csv" in refused.value.errors[0]
    assert not (tmp_path / "out").exists()


def test_faults_are_named_up_to_five(tmp_path: Path):
    (tmp_path / "drops.csv").write_text(HEAD + "x,1\n" * 8)
    with pytest.raises(InputError) as refused:
        read_rebounds(tmp_path / "drops.csv")
    assert len(refused.value.errors) == 6
    assert refused.value.errors[-1].endswith("3 more errors")


def test_a_rate_sensitive_material_is_refused():
    fast = dataclasses.replace(BRASS, rate_sensitivity=0.02)
    with pytest.raises(InputError, match=r"rate_sensitivity: found 0\.02"):
        fit_restitution(rebounds_of(VELOCITY, RESTITUTION), [fast], [R])


@pytest.mark.parametrize("order", [("steel", "brass"), ("brass", "steel")])
def test_case_of_a_fit_has_the_softer_material(tmp_path: Path, order: tuple[str, str]):
    materials = [material(name) for name in order]
    fitted = fit_restitution(rebounds_of(VELOCITY, RESTITUTION), materials, [R])
    text = fit_toml(fitted)
    written = tomllib.loads(text)["material"]
    assert written["name"] == "brass"
    assert written["youngs_modulus"] == BRASS.youngs_modulus
    assert written["yield_strength"] == fitted.value(YIELD)
