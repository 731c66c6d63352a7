"""Powers and exponentials of the laws, and the laws of several contacts at a time."""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw, exponential, power
from tests.conftest import script_of

RNG = np.random.default_rng(7)
R = 0.005
BODIES = {"youngs_modulus": (115e9, 115e9), "poisson_ratio": (0.3, 0.3), "radius": (R, R)}
EXTENDED = np.finfo(np.longdouble).nmant > 60  # long doubles of x86


def units(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest error in units in the last place."""
    return float(np.max(np.abs(found - exact) / np.spacing(np.abs(exact.astype(float)))))


@pytest.mark.skipif(not EXTENDED, reason="needs a more precise type to compare with")
@pytest.mark.parametrize(
    ("x", "y"),
    [
        (RNG.uniform(0, 1, 10**5), 1.35),
        (10 ** RNG.uniform(-16, 0, 10**5), RNG.uniform(1, 3, 10**5)),
        (RNG.uniform(1, 400, 10**5), 1.1414),
        (np.exp(RNG.uniform(-100, 100, 10**5)), RNG.uniform(-3, 3, 10**5)),
    ],
)
def test_powers_are_exact_to_a_unit(x, y):
    assert units(power(x, y), np.power(x.astype(np.longdouble), np.longdouble(y))) < 1.0


@pytest.mark.skipif(not EXTENDED, reason="needs a more precise type to compare with")
@pytest.mark.parametrize("reach", [1.0, 20.0, 700.0])
def test_exponentials_are_exact_to_a_unit(reach):
    x = RNG.uniform(-reach, reach, 10**5)
    assert units(exponential(x), np.exp(x.astype(np.longdouble))) < 1.0


def test_ends_of_the_range():
    assert np.all(power(1.0, RNG.uniform(-5, 5, 100)) == 1.0), "a contact at its peak has the peak's force"
    assert exponential(0.0) == 1.0 and 0.0 < exponential(-1e6) < 1e-300
    assert power(1e-300, 3.0) < 1e-300


@pytest.mark.parametrize(
    "law", ["elastoplastic", "elastoplastic variant published", "bilinear", "thornton", "hertz", "mixed"]
)
def test_contacts_of_a_batch_have_the_forces_of_the_law(lammps, law):
    """Pairs of spheres at many overlaps, first on the way in and then on the way out, more than fill a batch."""
    n = 150
    deep, out = 10 ** RNG.uniform(-8, -3.8, n), RNG.uniform(0.1, 1.0, n)
    places = [(0.02 * k, 0.0, z) for k in range(n) for z in (0.0, 2 * R - deep[k])]
    names = {k: law for k in (1, 2)} if law != "mixed" else {1: "thornton", 2: "elastoplastic"}

    def coefficients(kind: int) -> str:
        name, *options = names[kind].split()
        return f"pair_coeff {kind} {kind} " + " ".join(
            [name, "115e9 0.3", "" if name == "hertz" else "550e6", *options]
        )

    types = [1 + k % 2 for k in range(n) for _ in range(2)]
    lmp = lammps()
    both = f"pair_coeff 1 2 {coefficients(1).split(maxsplit=3)[3]}"
    lmp.commands_string(
        script_of(places, types=types, coefficients=[coefficients(1), coefficients(2), both], box=[-1, 4, -1, 1, -1, 1])
    )

    def laws(kind: int) -> ContactLaw:
        name, *options = names[kind].split()
        words = dict(zip(options[::2], options[1::2], strict=True))
        return ContactLaw(
            law=name, yield_strength=(np.inf, np.inf) if name == "hertz" else (550e6, 550e6), **BODIES, **words
        )

    def forces() -> np.ndarray:
        order = np.argsort(lmp.numpy.extract_atom("id")[: 2 * n])
        return lmp.numpy.extract_atom("f")[: 2 * n][order][1::2, 2]

    def overlaps() -> np.ndarray:
        order = np.argsort(lmp.numpy.extract_atom("id")[: 2 * n])
        x = lmp.numpy.extract_atom("x")[: 2 * n][order]
        return 2 * R - np.abs(x[1::2, 2] - x[::2, 2])

    def expected(present, peak) -> np.ndarray:
        return np.array([laws(1 + k % 2).force(present[k], peak[k]) for k in range(n)])

    lmp.command("run 0 post no")
    peaks = overlaps()
    assert np.allclose(forces(), expected(peaks, peaks), rtol=1e-13, atol=0)
    for k in range(n):
        lmp.command(f"set atom {2 * k + 2} z {2 * R - out[k] * deep[k]:.17g}")
    lmp.command("run 0 post no")
    assert np.allclose(forces(), expected(overlaps(), peaks), rtol=1e-9, atol=0)
