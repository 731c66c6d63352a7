"""Stress from a strain history: closed forms of a Prony series, and the messages for invalid
input.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import granwave as gw
from granwave.lammps_inputs.errors import InputError

LONG = 15.7e6
TERMS = ((253.1e6, 2.64e-3), (1320.4e6, 0.55e-3))  # of polyurethane, Pa and s


def modulus(time: float) -> float:
    """Relaxation modulus, Pa."""
    return LONG + sum(size * np.exp(-time / tau) for size, tau in TERMS)


def test_a_held_strain_relaxes_with_the_modulus() -> None:
    time = np.linspace(0.0, 0.01, 7)
    stress = gw.stress_history(time, np.full(7, 0.02), LONG, TERMS)
    np.testing.assert_allclose(stress, 0.02 * np.vectorize(modulus)(time), rtol=1e-13)


@pytest.mark.parametrize(
    ("rise", "printed"), [(1.25e-3, 740e6), (2.1e-3, 530e6), (2.4e-3, 480e6), (10.3e-3, 150e6)]
)
def test_an_even_rise_has_the_printed_secant_moduli(rise: float, printed: float) -> None:
    """One step and many steps are exact; the printed values are rounded to 10 MPa."""
    once = gw.stress_history([0.0, rise], [0.0, 0.01], LONG, TERMS)[-1] / 0.01
    time = np.linspace(0.0, rise, 101)
    often = gw.stress_history(time, 0.01 * time / rise, LONG, TERMS)[-1] / 0.01
    exact = quad(modulus, 0.0, rise, epsabs=0.0, epsrel=1e-12)[0] / rise
    np.testing.assert_allclose([once, often], exact, rtol=1e-10)
    assert once == pytest.approx(printed, abs=5e6)


@pytest.mark.parametrize("frequency", [20.0, 200.0, 2000.0])
def test_a_harmonic_strain_has_the_storage_and_loss_moduli(frequency: float) -> None:
    """E' + i E'' = E_0 + sum of E_q i omega tau/(1 + i omega tau), once the start has relaxed.

    The corners of the interpolated strain act on the instantaneous modulus, so that errors are
    relative to it; they fall with the square of the step.
    """
    omega = 2 * np.pi * frequency
    errors = []
    for per_period in (200, 400):
        periods = int(np.ceil(15 * TERMS[0][1] * frequency)) + 1
        time = np.arange(periods * per_period + 1) / (per_period * frequency)
        stress = gw.stress_history(time, np.sin(omega * time), LONG, TERMS)
        last = stress[-per_period:]
        phase = omega * time[-per_period:]
        found = 2 * np.mean(last * np.sin(phase)) + 2j * np.mean(last * np.cos(phase))
        exact = LONG + sum(size * 1j * omega * tau / (1 + 1j * omega * tau) for size, tau in TERMS)
        errors.append(abs(found - exact) / modulus(0.0))
    assert errors[1] < 3e-5
    assert errors[1] < 0.3 * errors[0]


def test_components_and_uneven_instants() -> None:
    generator = np.random.default_rng(1)
    time = np.cumsum(generator.uniform(1e-5, 1e-3, 20))
    strain = generator.normal(size=(20, 3, 2))
    whole = gw.stress_history(time, strain, LONG, TERMS)
    single = gw.stress_history(time, strain[:, 1, 0], LONG, TERMS)
    assert whole.shape == strain.shape
    np.testing.assert_allclose(whole[:, 1, 0], single, rtol=1e-14)
    elastic = gw.stress_history(time, strain, LONG, [])
    np.testing.assert_allclose(elastic, LONG * strain)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"time": [0.0, 0.0]}, "time: expected increasing instants"),
        ({"time": "now"}, "time: expected an array of finite numbers"),
        ({"strain": [0.0]}, "strain: found 1 rows for 2 instants"),
        ({"strain": [0.0, np.nan]}, "strain: expected an array of finite numbers"),
        ({"long_time_modulus": -1.0}, "long_time_modulus: found -1.0"),
        ({"terms": [1.0]}, "terms: found 1.0, expected pairs"),
        ({"terms": [(1.0, 0.0)]}, "relaxation time of terms: found 0"),
    ],
)
def test_bad_input(changes: dict[str, object], message: str) -> None:
    arguments = {
        "time": [0.0, 1.0], "strain": [0.0, 1.0], "long_time_modulus": 1.0, "terms": [(1.0, 1.0)],
    }  # fmt: skip
    with pytest.raises(InputError, match=message):
        gw.stress_history(**(arguments | changes))
