"""Gravity on strikers: bounces in closed form, the work of gravity is energy input."""

from __future__ import annotations

import numpy as np
import pytest

import granwave as gw
from granwave.lammps_inputs.errors import InputError

GRAVITY = 9.81
SPEED = 0.05  # upwards at first, m/s
D = 0.010
DENSITY = 2500.0
SOFT = {
    "name": "soft",
    "youngs_modulus": 1e8,
    "poisson_ratio": 0.3,
    "density": DENSITY,
    "yield_strength": 1e6,
}
CASE = {
    "material": SOFT,
    "packing": {"kind": "chain", "size": 2, "diameter": D},
    "contact": {"law": "hertz"},
    "boundary": {"bottom": "wall"},
    "precompression": {"kind": "gravity", "strikers": True},
    "hold": [{"index": [1]}],
    "striker": [{"touches": 1, "velocity": [0.0, 0.0, SPEED]}],
    "run": {"end_time": 1.5 * 2 * SPEED / GRAVITY, "frames": 2},
}
MASS = DENSITY * np.pi / 6 * D**3


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Return the run of a striker that bounces twice on a held sphere."""
    return gw.run(CASE, directory=tmp_path_factory.mktemp("fall") / "run", figures=False)


def test_a_striker_flies_a_parabola(run):
    velocity = run.energies["struck_velocity"]
    flight = 2 * SPEED / GRAVITY
    first = velocity[(velocity.index > 0.2 * flight) & (velocity.index < 0.9 * flight)]
    assert len(first) > 10
    slope, _ = np.polyfit(first.index, first, 1)
    assert slope == pytest.approx(GRAVITY, rel=1e-6)


def test_the_work_of_gravity_is_energy_input(run):
    energies = run.energies
    time = energies.index.to_numpy()
    velocity = energies["struck_velocity"].to_numpy()
    middle = (velocity[1:] + velocity[:-1]) / 2
    fallen = np.concatenate([[0.0], np.cumsum(np.diff(time) * middle)])
    expected = MASS * (SPEED**2 / 2 + GRAVITY * fallen)
    np.testing.assert_allclose(energies["input"], expected, rtol=0, atol=0.02 * expected[0])
    assert energies["input"].min() < 0.05 * expected[0]  # near the apex of a flight
    assert run.summary["energy_balance_error"] < 1e-5
    assert run.summary["dissipated_fraction"] == 0.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"striker": []}, "precompression.strikers: found true without [[striker]]"),
        (
            {"precompression": {"kind": "uniaxial", "force": 1.0, "strikers": True}},
            'precompression.strikers: belongs to precompression.kind = "gravity"; found "uniaxial"',
        ),
    ],
)
def test_gravity_on_strikers_is_refused_where_there_is_none(changes, message):
    case = {**CASE, **changes}
    with pytest.raises(InputError) as raised:
        gw.case(case)
    assert message in str(raised.value)
