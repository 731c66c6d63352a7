"""Command granwave fit: recovery of known constants, uncertainties, measured curves, errors, a run
with a fitted law.
"""

from __future__ import annotations

import argparse
import csv
import dataclasses
import json
import logging
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from granwave.analysis.contact_law.curves import Curve, curve_of, read_curve, write_law
from granwave.analysis.figures.style import write_csv
from granwave.extensions.continuum.law_fit.fit import fit_law
from granwave.extensions.continuum.law_fit.fit_output import fit_toml
from granwave.extensions.continuum.law_fit.fitted_law import YIELD
from granwave.extensions.continuum.terminal import fit
from granwave.lammps_inputs.case.contact.contact import LAW_CONSTANTS
from granwave.lammps_inputs.case.material import material, sphere_mass
from granwave.lammps_inputs.contact.law import contact_of, sphere_contact
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_case
from tests.helpers.twins.twin import OTHER

R = 0.005
BRASS = material("brass")
LAW = contact_of([BRASS], [R], constants=OTHER)
LENGTH = LAW.yield_overlap


def sampled(
    noise: float = 0.0, seed: int = 0, largest: float = 400.0, turns=(0.25, 0.5, 0.75, 1.0), law=LAW
) -> Curve:
    """A curve of a law with a few hundred rows and relative noise."""
    parts = [("loading", np.linspace(0, largest, 120) * law.yield_overlap, None)]
    for n, share in enumerate(turns, 1):
        peak = share * largest * law.yield_overlap
        rest = float(law.residual_overlap(np.array([peak]))[0])
        parts.append((f"unloading_{n}", np.linspace(peak, rest, 40), peak))
    branch = np.concatenate([np.full(overlap.size, name) for name, overlap, _ in parts])
    overlap = np.concatenate([overlap for _, overlap, _ in parts])
    peak = np.concatenate(
        [overlap if turn is None else np.full(overlap.size, turn) for _, overlap, turn in parts]
    )
    factor = 1 + noise * np.random.default_rng(seed).standard_normal(overlap.size)
    return curve_of(overlap, law.force(overlap, peak) * factor, branch)


def measured(
    noise: float = 0.0, jitter: float = 0.0, cycles=((60, 0.5), (150, 0.8), (300, 0.0))
) -> dict[str, np.ndarray]:
    """Overlap and force in the order of measurement: loading, then partial unloading and reloading
    in cycles.
    """
    path = []
    here = 0.0
    for top, back in cycles:
        path += [np.linspace(here, top, 150), np.linspace(top, top * back, 100)[1:]]
        here = top * back
    a = np.concatenate(path) * LENGTH
    generator = np.random.default_rng(4)
    force = LAW.force(a, np.maximum.accumulate(a)) * (1 + noise * generator.standard_normal(a.size))
    return {
        "overlap_m": np.abs(a + jitter * LENGTH * generator.standard_normal(a.size)),
        "force_N": force,
    }


def options(curve: Path, directory: Path, **more) -> argparse.Namespace:
    usual = {"material": ["brass"], "radius": [R], "free": None, "force": False}
    usual |= {"fit_yield": False, "fit_zero": False, "pair": None}
    return argparse.Namespace(curve=curve, directory=directory, **(usual | more))


def test_exact_curve():
    found = fit_law(sampled(), [BRASS], [R])
    assert found.constants == pytest.approx(OTHER, rel=1e-6)
    assert found.misfit.largest_percent.max() < 1e-4
    assert found.misfit.published_largest_percent.max() > 10
    assert not any(found.undetermined(name) for name in OTHER)


@pytest.mark.validation
def test_published_curve_gives_published_constants(tmp_path):
    """Table written by `granwave law -o`."""
    found = fit_law(
        read_curve(write_law(contact_of([BRASS], [R]), tmp_path / "law.csv")), [BRASS], [R]
    )
    assert found.constants == pytest.approx(LAW_CONSTANTS, rel=1e-6)


def test_two_materials_and_a_plane():
    for materials, radii in (
        ([BRASS, material("steel")], [0.004, 0.008]),
        ([BRASS], [R, math.inf]),
    ):
        curve = sampled(law=contact_of(materials, radii, constants=OTHER))
        assert fit_law(curve, materials, radii).constants == pytest.approx(OTHER, rel=1e-6)


SMOOTH = [name for name in OTHER if name != "area_switch"]


@pytest.mark.validation
def test_uncertainties_are_of_the_right_size():
    """The scatter over many curves with 1 % noise agrees with the stated uncertainties, and the
    mean is correct.
    """
    errors = []
    for seed in range(40):
        found = fit_law(sampled(0.01, seed), [BRASS], [R], SMOOTH)
        # area_switch is fixed at its published value, which is not that of this law: compare with
        # the fit of the exact curve
        errors.append([(found.constants[name], found.uncertainty[name]) for name in SMOOTH])
    exact = fit_law(sampled(), [BRASS], [R], SMOOTH).constants
    values, said = np.array(errors).transpose(2, 0, 1)
    pull = (values - [exact[name] for name in SMOOTH]) / said
    assert np.all(np.abs(pull.mean(axis=0)) < 0.6)
    assert np.all((pull.std(axis=0) > 0.6) & (pull.std(axis=0) < 1.5))


def test_noise():
    found = fit_law(sampled(0.01, 3), [BRASS], [R])
    for name, true in OTHER.items():
        assert abs(found.constants[name] - true) < 4 * found.uncertainty[name], name
    beyond = {one.part: one for one in found.misfit.itertuples()}
    assert (
        0.7 < beyond["loading beyond it"].rms_percent < 1.3
        and 0.7 < beyond["unloading and reloading"].rms_percent < 1.3
    )


@pytest.mark.validation
def test_outliers_count_little():
    curve = sampled(0.005, 1)
    force = curve.force.copy()
    force[::25] *= 1.4
    found = fit_law(curve_of(curve.overlap, force, curve.branch), [BRASS], [R])
    for name in ("residual_slope", "residual_offset", "unloading_exponent"):
        assert found.constants[name] == pytest.approx(OTHER[name], rel=0.02)


@pytest.mark.validation
def test_rows_that_err_alike_widen_the_uncertainties():
    curve = sampled(0.003, 2)
    wavy = curve.force * (1 + 0.02 * np.sin(np.arange(curve.force.size) / 8))
    found = fit_law(curve_of(curve.overlap, wavy, curve.branch), [BRASS], [R])
    plain = fit_law(curve, [BRASS], [R])
    assert found.correlation > 0.8 and plain.correlation < 0.2
    assert found.uncertainty["unloading_exponent"] > 6 * plain.uncertainty["unloading_exponent"]


@pytest.mark.parametrize(
    ("curve", "held", "words"),
    [
        (sampled(turns=()), ("residual_slope", "residual_offset", "residual_rate", "unloading_exponent"), "no unloading"),
        (sampled(turns=(1.0,)), ("residual_slope", "residual_rate"), "unloaded from 1 overlap only"),
        (sampled(turns=(0.5, 1.0)), ("residual_rate",), "unloaded from 2 overlaps only"),
        (sampled(largest=120), ("area_switch", "area_offset"), "fewer than 5 rows of loading lie beyond 177.6"),
    ],
)  # fmt: skip
def test_what_the_curve_cannot_tell_stays_and_is_said(caplog, curve, held, words):
    with caplog.at_level(logging.WARNING, "granwave"):
        found = fit_law(curve, [BRASS], [R])
    assert set(OTHER) - set(found.uncertainty) == set(held)
    assert all(found.constants[name] == LAW_CONSTANTS[name] for name in held)
    assert words in caplog.text and all(name in caplog.text for name in held)
    if "area_switch" not in held:
        assert found.constants["pressure_limit"] == pytest.approx(OTHER["pressure_limit"], rel=1e-5)


def test_a_constant_that_is_not_determined_is_said(tmp_path, capsys):
    """Loading up to a fifth of the pressure limit, with the offset of the area to be fitted."""
    curve = sampled(0.02, 5, largest=12.0, turns=())
    found = fit_law(
        curve, [BRASS], [R], ["pressure_limit", "pressure_rate", "area_slope", "area_offset"]
    )
    lost = [name for name in found.uncertainty if found.undetermined(name)]
    assert "area_offset" in lost or "area_slope" in lost
    assert "not determined" in fit_toml(found)


@pytest.mark.parametrize("jitter", [0.0, 0.05])
def test_measured_curve_without_branches(jitter):
    table = measured(0.005, jitter)
    curve = curve_of(**{name.split("_")[0]: values for name, values in table.items()})
    assert curve.turns / LENGTH == pytest.approx([60, 150, 300], abs=0.5)
    names, first = np.unique(curve.branch, return_index=True)
    assert list(names[np.argsort(first)]) == [
        "loading", "unloading_1", "reloading_1", "unloading_2", "reloading_2", "unloading_3",
    ]  # fmt: skip
    assert np.all(curve.peak[curve.loading] == curve.overlap[curve.loading])
    found = fit_law(curve, [BRASS], [R])
    for name in ("residual_slope", "residual_offset", "residual_rate", "unloading_exponent"):
        assert found.constants[name] == pytest.approx(OTHER[name], rel=0.03)


def test_the_force_free_stretch_of_a_dent_does_not_dilute_the_misfit():
    curve = sampled(0.01, 3)
    idle = np.linspace(0, 80 * LENGTH, 2000)
    overlap = np.append(curve.overlap, idle)
    force = np.append(curve.force, 0 * idle)
    longer = curve_of(overlap, force, [*curve.branch, *["unloading_1"] * 2000])
    found = fit_law(longer, [BRASS], [R], SMOOTH)
    for name, number in fit_law(curve, [BRASS], [R], SMOOTH).constants.items():
        assert found.constants[name] == pytest.approx(number, rel=1e-6)


def test_reloading_below_an_earlier_peak_belongs_to_it():
    curve = curve_of([0, 5, 10, 6, 8, 6, 4, 9, 12, 3], np.ones(10))
    assert list(curve.peak) == [0, 5, 10, 10, 10, 10, 10, 10, 12, 12]
    assert list(curve.branch[[2, 3, 4, 5, 7, 8, 9]]) == [
        "loading", "unloading_1", "reloading_1", "unloading_1", "reloading_1", "loading", "unloading_2",
    ]  # fmt: skip


@pytest.mark.validation
def test_yield_strength_too():
    softer = dataclasses.replace(BRASS, yield_strength=420e6)
    found = fit_law(
        sampled(law=contact_of([softer], [R], constants=OTHER)), [BRASS], [R], fit_yield=True
    )
    assert found.value(YIELD) == pytest.approx(420e6, rel=1e-4)
    assert found.constants == pytest.approx(OTHER, rel=1e-3)
    assert found.materials[0].yield_strength == found.law.yield_strength
    assert tomllib.loads(fit_toml(found))["material"]["yield_strength"] == pytest.approx(
        420e6, rel=1e-4
    )


def test_files(tmp_path, capsys):
    write_csv({"note": ["x"] * 747, **measured(0.005)}, tmp_path / "m.csv")
    assert fit(options(tmp_path / "m.csv", tmp_path / "out")) == 0
    shown = capsys.readouterr().out
    assert (
        all(name in shown for name in OTHER)
        and "published" in shown
        and "unloading and reloading" in shown
    )
    found = {
        path.relative_to(tmp_path / "out").as_posix()
        for path in (tmp_path / "out").rglob("[!.]*.*")
    }
    assert found == {
        "fit.toml",
        "fit.csv",
        "misfit.csv",
        "figures/fit.png",
        "figures/fit.pdf",
        "figures/fit.csv",
    }
    rows = {row["constant"]: row for row in csv.DictReader((tmp_path / "out" / "fit.csv").open())}
    assert list(rows) == list(LAW_CONSTANTS) and all(
        row["state"] == "fitted" for row in rows.values()
    )
    drawn = list(csv.DictReader((tmp_path / "out" / "figures" / "fit.csv").open()))
    assert len(drawn) == 747 and float(drawn[300]["deviation_percent"]) == pytest.approx(
        100 * (float(drawn[300]["fit_N"]) / float(drawn[300]["force_N"]) - 1), rel=1e-6
    )
    written = tomllib.loads((tmp_path / "out" / "fit.toml").read_text())
    for name, row in rows.items():
        assert written["contact"][name] == float(row["value"])
    with pytest.raises(InputError, match="already holds a fit; force=True"):
        fit(options(tmp_path / "m.csv", tmp_path / "out"))
    assert (
        fit(options(tmp_path / "m.csv", tmp_path / "out", force=True, free=["unloading_exponent"]))
        == 0
    )
    assert (
        tomllib.loads((tmp_path / "out" / "fit.toml").read_text())["contact"]["pressure_limit"]
        == 2.48
    )


def test_the_fitted_case_runs(granwave, tmp_path):
    """Unmodified fit.toml for a material of the user: peak force and dissipation of a collision
    follow the fitted law.
    """
    write_csv(measured(), tmp_path / "m.csv")
    (tmp_path / "mine.toml").write_text(
        "[alloy]\nyoungs_modulus = 115e9\npoisson_ratio = 0.3\ndensity = 8000\nyield_strength = 550e6\n"
    )
    assert (
        fit(options(tmp_path / "m.csv", tmp_path / "out", material=[f"{tmp_path}/mine.toml:alloy"]))
        == 0
    )
    with pytest.raises(InputError, match=r"found no brass in .*mine.toml, expected one of alloy"):
        fit(options(tmp_path / "m.csv", tmp_path / "x", material=[f"{tmp_path}/mine.toml:brass"]))
    path = tmp_path / "out" / "fit.toml"
    law = sphere_contact(load_case(path))
    mass = sphere_mass(load_case(path).material, R) / 2
    assert (
        law.constants == pytest.approx(OTHER, rel=1e-5) and load_case(path).material.density == 8000
    )
    energy = 0.5 * mass * 1.0**2
    peak = brentq(
        lambda a: float(law.loading_work(np.array([a]))[0]) - energy, 0, 0.2 * law.effective_radius
    )
    done = granwave("run", path, "--no-figures", "-o", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["energy_dissipated_J"] == pytest.approx(law.dissipated_energy(peak), rel=1e-4)
    assert summary["peak_force_N"] == pytest.approx(law.loading_force(peak), rel=1e-4)
    published = contact_of([BRASS], [R])
    assert abs(published.dissipated_energy(peak) / law.dissipated_energy(peak) - 1) > 5e-3


GOOD = "overlap_m,force_N\n" + "".join(
    f"{a * LENGTH},{float(LAW.loading_force(a * LENGTH))}\n" for a in range(40)
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("overlap_m,F\n1,2\n", r"found overlap_m, F, expected one column force_N or force_kN"),
        ("", r"found nothing, expected one column overlap_m, overlap_mm"),
        ("overlap_m,overlap_mm,force_N\n1,2,3\n", r"found overlap_m and overlap_mm, expected one column"),
        (GOOD + "x,3\n", r'line 42: overlap_m: found "x", expected a number'),
        (GOOD + "1e-6,nan\n", r'line 42: force_N: found "nan"'),
        (GOOD + "1e-6\n", r'line 42: force_N: found "", expected a number'),
        (GOOD + "-1e-6,3\n", r"line 42: overlap_m: found -1e-06, expected no negative value"),
        ("branch,overlap_m,force_N\nup,1e-6,2\n", r'line 2: branch: found "up", expected loading, unloading_N'),
        ("\n".join(GOOD.splitlines()[:7]), r"4 rows of loading lie beyond first yield at .*, expected 5 or more"),
        ("overlap_m,force_N\n1e-6,3\n", r"is below first yield"),
        ("overlap_m,force_N\n", r"is below first yield"),
        (GOOD.replace("overlap_m,force_N", "overlap_m,force_N,", 1).replace("e-0", "e+0"), r"more than the radius 0.005 m; check"),
        ("overlap_m,force_N\n" + "".join(f"{a * LENGTH},{1e-3 * a}\n" for a in range(40)), r"force_N: the forces are"),
    ],
)  # fmt: skip
def test_wrong_curves(tmp_path, text, message):
    (tmp_path / "c.csv").write_text(text)
    with pytest.raises(InputError, match=message) as refused:
        fit(options(tmp_path / "c.csv", tmp_path / "out"))
    assert len(refused.value.errors) == 1 and "c.csv" in refused.value.errors[0]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("length", "force", "factors"),
    [("overlap_mm", "force_kN", (1e3, 1e-3)), ("displacement_um", "force_N", (1e6, 1.0))],
)
def test_eight_points_in_other_units(tmp_path, caplog, length, force, factors):
    """One of the constants is fitted; the constants that keep their values are named before the
    reason.
    """
    overlap = LENGTH * np.arange(1, 9) * 5.0
    rows = zip(factors[0] * overlap, factors[1] * LAW.loading_force(overlap), strict=True)
    (tmp_path / "c.csv").write_text(
        f"{length},{force}\n" + "".join(f"{a:.15g},{f:.15g}\n" for a, f in rows)
    )
    curve = read_curve(tmp_path / "c.csv")
    assert curve.overlap == pytest.approx(overlap) and curve.force == pytest.approx(
        LAW.loading_force(overlap)
    )
    with caplog.at_level(logging.WARNING, "granwave"):
        found = fit_law(curve, [BRASS], [R])
    assert (found.misfit.rms_percent < 0.1).all()
    assert (
        "unloading_exponent stays as published, since the curve has no unloading branch"
    ) in caplog.text


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"free": ["pressure_limt"]}, "did you mean pressure_limit"),
        ({"free": []}, "found nothing"),
        ({"radius": [R, R, R]}, "expected one or two"),
        ({"radius": [-R]}, "expected positive lengths"),
        ({"material": ["bras"]}, "did you mean brass"),
        ({"material": ["nothing.toml:brass"]}, "no such file"),
    ],
)
def test_wrong_options(tmp_path, more, message):
    (tmp_path / "c.csv").write_text(GOOD)
    with pytest.raises(InputError, match=message):
        fit(options(tmp_path / "c.csv", tmp_path / "out", **more))
    assert not (tmp_path / "out").exists()


def test_every_fault_of_a_file_is_named_up_to_five(tmp_path):
    (tmp_path / "c.csv").write_text("overlap_m,force_N\n" + "x,1\n" * 8)
    with pytest.raises(InputError) as refused:
        read_curve(tmp_path / "c.csv")
    *told, last = refused.value.errors
    assert [f"line {n}:" in line for n, line in enumerate(told, 2)] == [True] * 5 and last.endswith(
        "3 more errors"
    )
