"""Compressed packings reach pressure and solid fraction in equilibrium, and jam as published."""

import json
import subprocess
import sys
import tomllib

import numpy as np
import pytest
import tomli_w

from granwave.extensions.packings.bed_statistics import statistics_of
from granwave.extensions.packings.compressed import CompressedMaker
from granwave.extensions.packings.compression import PRESSURE_TOLERANCE
from granwave.extensions.packings.insertion import nearest_image
from granwave.extensions.packings.recipe import bed_of
from granwave.lammps_inputs.case.packing.made_packing import (
    PackingNotMadeError,
    maker_input,
    nothing_made,
)
from granwave.lammps_inputs.case.schema import ErrorList
from granwave.lammps_inputs.errors import InputError
from granwave.workflows import load_case
from granwave.workflows.run.driver import run_case

N = 60
D = 0.010
MODULUS = 1e7
POISSON = 0.3
EFFECTIVE_MODULUS = MODULUS / (2 * (1 - POISSON**2))
PRESSURE = 1e-3 * EFFECTIVE_MODULUS
ENDLESS = {"sides": "periodic", "bottom": "periodic"}
TABLES = {
    "material": {
        "name": "soft",
        "youngs_modulus": MODULUS,
        "poisson_ratio": POISSON,
        "density": 2500.0,
        "yield_strength": 1e6,
    },
    "packing": {"kind": "compressed", "grains": N, "diameter": D, "seed": 1},
    "contact": {"law": "hertz"},
}
JAMMED = 0.639  # O'Hern et al. 2003, monodisperse spheres, of infinite packings


def case_file(folder, *, boundary, contact=None, more=None, **keys):
    """Write the case with keys of [packing] into a folder; return its path."""
    path = folder / "packing.toml"
    tables = {**TABLES, "packing": {**TABLES["packing"], **keys}, "boundary": boundary}
    tables["contact"] = {**TABLES["contact"], **(contact or {})}
    path.write_text(tomli_w.dumps({**tables, **(more or {})}))
    return path


def made(path):
    """Return recipe and packing of a case."""
    errors = ErrorList(str(path))
    given = maker_input(tomllib.loads(path.read_text()), path, errors)
    recipe = CompressedMaker().read(given, errors)
    assert not errors.items
    return recipe, bed_of(recipe, given)


def hertz_contacts(bed):
    """Return pairs, differences of positions, overlaps and forces of equal spheres, from their
    positions only.
    """
    first, second = np.triu_indices(len(bed.grains), 1)
    apart = bed.grains.position[second] - bed.grains.position[first]
    apart -= nearest_image(apart, bed.container.period)
    overlap = D - np.linalg.norm(apart, axis=1)
    near = overlap > 0
    force = 4 / 3 * EFFECTIVE_MODULUS * np.sqrt(D / 4) * overlap[near] ** 1.5
    return np.stack([first[near], second[near]], axis=1), apart[near], overlap[near], force


@pytest.fixture(scope="module")
def endless_case(tmp_path_factory):
    """Return the case of a periodic packing without friction."""
    folder = tmp_path_factory.mktemp("endless")
    return case_file(folder, boundary=ENDLESS, pressure=PRESSURE)


@pytest.fixture(scope="module")
def endless(endless_case):
    """Return recipe and packing of a periodic packing without friction."""
    return made(endless_case)


def test_the_pressure_is_met(endless):
    _, bed = endless
    _, apart, _, force = hertz_contacts(bed)
    lengths = (*bed.container.box, bed.container.height)
    pressure = (force * np.linalg.norm(apart, axis=1)).sum() / (3 * np.prod(lengths))
    assert pressure == pytest.approx(PRESSURE, rel=PRESSURE_TOLERANCE)
    assert bed.record["pressure"] == pytest.approx(pressure, rel=1e-6)


def test_each_grain_is_in_balance(endless):
    _, bed = endless
    pairs, apart, _, force = hertz_contacts(bed)
    np.testing.assert_array_equal(pairs, bed.contacts)
    np.testing.assert_allclose(bed.normal_force, force, rtol=1e-6)
    vectors = force[:, None] * apart / np.linalg.norm(apart, axis=1)[:, None]
    net = np.zeros((N, 3))
    np.add.at(net, pairs[:, 0], -vectors)
    np.add.at(net, pairs[:, 1], vectors)
    assert np.linalg.norm(net, axis=1).max() < 1e-3 * force.max()


def test_an_endless_packing_is_dense_and_isotropic(endless):
    found = statistics_of(*endless)
    # at this pressure it is 0.02 above jamming
    assert 0.62 < found.solid_fraction < 0.69
    assert 6.0 < found.coordination_without_rattlers < 8.0
    assert found.anisotropy < 0.2
    assert found.pressure == pytest.approx(PRESSURE, rel=PRESSURE_TOLERANCE)


def test_an_endless_packing_is_a_cell_of_a_case(endless, endless_case):
    recipe, bed = endless
    case = load_case(endless_case)
    lengths = (*bed.container.box, bed.container.height)
    np.testing.assert_allclose(np.diag(case.packing.cell), lengths)
    assert case.precompression.kind == "overlaps"
    assert recipe.words == f"a periodic box, compressed to {PRESSURE:g} Pa"


def test_the_same_seed_is_the_same_packing_bit_for_bit(endless, tmp_path):
    again = made(case_file(tmp_path, boundary=ENDLESS, pressure=PRESSURE))[1]
    assert again.grains.text == endless[1].grains.text


def test_the_solid_fraction_is_met_between_walls_with_friction(tmp_path):
    path = case_file(
        tmp_path,
        boundary={"sides": "wall"},
        contact={"friction": 0.3},
        solid_fraction=0.45,
        diameter={"uniform": [0.008, 0.012]},
        proportions=[1, 1, 2],
    )
    _, bed = made(path)
    volume = np.pi / 6 * (bed.grains.diameter**3).sum()
    width, depth = bed.container.box
    assert width == pytest.approx(depth)
    height = volume / (0.45 * width * depth)
    assert height == pytest.approx(2 * width)
    assert bed.record["solid_fraction"] == pytest.approx(0.45)
    radius = bed.grains.diameter[:, None] / 2
    deepest = 0.05 * radius.max()
    assert (bed.grains.position[:, :2] - radius > -deepest).all()
    assert (bed.grains.position[:, :2] + radius < width + deepest).all()
    assert (bed.grains.position[:, 2] + radius[:, 0]).max() < bed.bottom + deepest


def test_a_packing_with_a_bottom_is_struck(tmp_path):
    striker = {"touches": "centre", "diameter": 0.012, "velocity": [0.0, 0.0, 1.0]}
    more = {"striker": [striker], "run": {"end_time": 2e-3, "frames": 2}}
    path = case_file(tmp_path, boundary={"sides": "periodic"}, more=more, pressure=PRESSURE)
    run = run_case(load_case(path), tmp_path / "run", figures=False)
    assert run.summary["energy_balance_error"] < 1e-5
    assert run.summary["peak_force_N"] > 1.0


def test_check_makes_no_packing(tmp_path):
    path = case_file(tmp_path, boundary={"sides": "periodic"}, solid_fraction=0.6)
    with nothing_made(), pytest.raises(PackingNotMadeError) as raised:
        load_case(path)
    expected = f"{N} grains of 0.01 m in a box with periodic sides, compressed to a solid fraction"
    assert dict(raised.value.packings[0].rows)["bed"].startswith(expected)


def test_the_command_prints_the_pressure(endless_case, tmp_path):
    command = [sys.executable, "-m", "granwave.workflows", "bed", str(endless_case)]
    figure = tmp_path / "packing.png"
    done = subprocess.run(
        [*command, "--json", "-o", str(figure)], capture_output=True, text=True, check=True
    )
    assert json.loads(done.stdout)["pressure_Pa"] == pytest.approx(PRESSURE, rel=0.01)
    assert figure.is_file()


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "packing.solid_fraction: missing; set a solid_fraction or "),
        (
            {"solid_fraction": 0.6, "pressure": 1e3},
            "packing.pressure: found both solid_fraction and pressure, expected one of them",
        ),
        ({"solid_fraction": 0.9}, "packing.solid_fraction: found 0.9"),
        ({"pressure": 1e6}, "packing.pressure: found 1e+06 Pa, expected at most 100000 Pa"),
        ({"pressure": 1e3, "grains": 4}, "packing.grains: found 4 grains, which gives a box of"),
        ({"pressure": 1e3, "proportions": [1, 1]}, "packing.proportions: found"),
        ({"pressure": 1e3, "box": [0.1, 0.1]}, "packing.box: unknown key"),
    ],
)
def test_wrong_keys(tmp_path, keys, message):
    with pytest.raises(InputError) as raised:
        load_case(case_file(tmp_path, boundary={"sides": "periodic"}, **keys))
    assert message in str(raised.value)
    assert len(raised.value.items) == 1


def test_a_periodic_bottom_needs_periodic_sides(tmp_path):
    with pytest.raises(InputError, match=r'"periodic" without periodic sides; add sides'):
        load_case(case_file(tmp_path, boundary={"bottom": "periodic"}, pressure=1e3))


@pytest.mark.validation
@pytest.mark.parametrize("seed", [1, 2])
def test_frictionless_spheres_jam_as_published(tmp_path, seed):
    n = 400
    pressure = 1e-6 * EFFECTIVE_MODULUS
    path = case_file(tmp_path, boundary=ENDLESS, pressure=pressure, grains=n, seed=seed)
    found = statistics_of(*made(path))
    assert found.solid_fraction == pytest.approx(0.64, abs=0.01)
    # finite packings jam below infinite ones: O'Hern et al. 2003, with its width
    of_size = JAMMED - 0.12 * n ** (-1 / (3 * 0.71))
    assert found.solid_fraction == pytest.approx(of_size, abs=0.16 * n**-0.55)
    assert found.coordination_without_rattlers == pytest.approx(6.0, abs=0.2)
    assert found.pressure == pytest.approx(pressure, rel=PRESSURE_TOLERANCE)


def test_the_pressure_is_met_with_friction_once_the_grains_are_at_rest(tmp_path):
    """Moving grains contribute to a small pressure; the contribution vanishes when they are at
    rest.
    """
    small = PRESSURE / 300
    path = case_file(tmp_path, boundary=ENDLESS, contact={"friction": 0.3}, pressure=small)
    _, bed = made(path)
    assert bed.record["pressure"] == pytest.approx(small, rel=PRESSURE_TOLERANCE)
    assert bed.record["residual"] < 3.1e-4
