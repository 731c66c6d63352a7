"""Forces from measured grains: closed forms, exact data, another solver, and spheres."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest
from scipy import sparse

from granwave.analysis.inference.case import Infer
from granwave.analysis.inference.equations import make_equations
from granwave.analysis.inference.grains import Grains, Wall, find_contacts, stiffness
from granwave.analysis.inference.infer import infer
from granwave.analysis.inference.output import network
from granwave.analysis.inference.solve import solve, solve_conic
from granwave.analysis.inference.tables import instant_summary

RADIUS, MASS = 0.01, 0.3
EXACT = Infer(friction=0.3, repetitions=0)


def discs(x, stress, acceleration=0.0, spin=0.0, turning=0.0):
    """Equal discs of a metre's length with given stresses (xx, yy, xy)."""
    n = len(x)
    return Grains(
        np.arange(1, n + 1), np.array(x, float), np.full(n, RADIUS), np.full(n, MASS), np.full(n, np.pi * RADIUS**2),
        np.zeros((n, 2)) + acceleration, np.zeros((n, 1)) + spin, np.zeros((n, 1)) + turning, np.zeros((n, 2)),
        np.array(stress, float),
    )  # fmt: skip


def test_a_disc_between_two_walls():
    """Stress -2 F/(pi R) across it."""
    force = 1234.5
    walls = {"left": Wall((0, 0), (1, 0)), "right": Wall((2 * RADIUS, 0), (-1, 0))}
    found = infer(discs([[RADIUS, 0]], [[-2 * force / (np.pi * RADIUS), 0, 0]]), walls, EXACT)
    assert found.contacts.walls == ("left", "right")
    np.testing.assert_allclose(found.force, [[force, 0], [force, 0]], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(found.contacts.vectors(found.force), [[force, 0], [-force, 0]], rtol=1e-12, atol=1e-9)


def test_a_row_of_three_that_is_pushed():
    """Forces 3 m a, 2 m a, m a, and none at the far side."""
    acceleration = 1000.0
    forces = MASS * acceleration * np.array([3, 2, 1, 0])
    x = [[RADIUS * (1 + 2 * k), 0.0] for k in range(3)]
    across = -(forces[:3] + forces[1:]) / (np.pi * RADIUS)
    grains = discs(x, np.stack([across, 0 * across, 0 * across], axis=1), acceleration=[acceleration, 0.0])
    walls = {"piston": Wall((0, 0), (1, 0)), "end": Wall((6 * RADIUS, 0), (-1, 0))}
    found = infer(grains, walls, EXACT)
    by_place = sorted(zip(found.grains.position[found.contacts.first] + found.contacts.arm, found.force, strict=True),
                      key=lambda pair: pair[0][0])  # fmt: skip
    np.testing.assert_allclose([force[0] for _, force in by_place], forces, rtol=1e-12, atol=1e-9)


def test_a_spinning_disc_bears_the_stress_of_the_closed_form():
    """Mean stress rho w^2 R^2/4 of a free spinning disc (Timoshenko and Goodier), with no contact force."""
    spin = 500.0
    hoop = MASS / (np.pi * RADIUS**2) * spin**2 * RADIUS**2 / 4
    found = infer(discs([[RADIUS, 0]], [[hoop, hoop, 0]], spin=spin), {"left": Wall((0, 0), (1, 0))}, EXACT)
    np.testing.assert_allclose(found.force, 0, atol=1e-9)


@pytest.mark.parametrize("state", ["plane-stress", "plane-strain", "space"])
def test_stiffness_is_hookes(state):
    """Against the strains of a bar, a strip and a block."""
    modulus, ratio = 70e6, 0.4
    inverse = np.linalg.inv(stiffness(np.array([modulus]), np.array([ratio]), state)[0])
    lengthwise, crosswise = {
        "plane-stress": (1, -ratio), "plane-strain": (1 - ratio**2, -ratio * (1 + ratio)), "space": (1, -ratio),
    }[state]  # fmt: skip
    np.testing.assert_allclose(inverse[0, :2] * modulus, [lengthwise, crosswise], rtol=1e-12)
    np.testing.assert_allclose(inverse[-1, -1] * modulus, 1 + ratio, rtol=1e-12)


def cube(rng):
    """A cube of 27 spheres in a box, with random forces in the cones of friction, and the state that these give.

    Accelerations and stresses are sums over contacts, written out here; the forces balance nothing.
    """
    n_side, radius, mass = 3, 0.004, 2e-3
    x = 2 * radius * (0.5 + np.array([(i, j, k) for k in range(n_side) for j in range(n_side) for i in range(n_side)]))
    width = 2 * radius * n_side
    walls = {"left": Wall((0, 0, 0), (1, 0, 0)), "right": Wall((width, 0, 0), (-1, 0, 0)),
             "floor": Wall((0, 0, 0), (0, 0, 1)), "slope": Wall((0, width, 0), (0, -1, 0))}  # fmt: skip
    n, spin = len(x), 100 * rng.normal(size=(27, 3))
    zero = np.zeros((n, 3))
    volume = np.full(n, 4 / 3 * np.pi * radius**3)
    bare = Grains(np.arange(1, n + 1), x, np.full(n, radius), np.full(n, mass), volume, zero, spin, zero, zero,
                  np.zeros((n, 6)))  # fmt: skip
    contacts = find_contacts(bare, walls, 1e-3)
    normal = rng.exponential(50.0, len(contacts))
    shear = rng.normal(size=(len(contacts), 2))
    shear *= (0.3 * normal * rng.uniform(size=len(contacts)) / np.linalg.norm(shear, axis=1))[:, None]
    true = np.concatenate([normal[:, None], shear], axis=1)
    total, torque, moment = np.zeros((n, 3)), np.zeros((n, 3)), np.zeros((n, 3, 3))
    for m, force in enumerate(contacts.vectors(true)):
        i, j = contacts.first[m], contacts.second[m]
        for grain, sign, arm in ((i, 1, -radius * contacts.normal[m]), (j, -1, radius * contacts.normal[m])):
            if grain >= 0:
                total[grain] += sign * force
                torque[grain] += np.cross(arm, sign * force)
                moment[grain] += np.outer(arm, sign * force)
    square = (spin**2).sum(axis=1)[:, None, None] * np.eye(3)
    # integral of rho r r over a sphere is m R^2/5 in each direction
    moment = 0.5 * (moment + moment.transpose(0, 2, 1)) - mass * radius**2 / 5 * (
        spin[:, :, None] * spin[:, None, :] - square
    )
    stress = moment / volume[:, None, None]
    voigt = np.stack([stress[:, a, b] for a, b in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], axis=1)
    inertia = 2 / 5 * mass * radius**2
    grains = dataclasses.replace(bare, acceleration=total / mass, angular_acceleration=torque / inertia, stress=voigt)
    return grains, walls, true


def test_spheres_in_space_are_exact():
    grains, walls, true = cube(np.random.default_rng(5))
    found = infer(grains, walls, EXACT)
    np.testing.assert_allclose(found.force, true, rtol=0, atol=1e-12 * np.abs(true).max())


def test_spheres_in_space_stay_within_their_cones():
    """With wrong stresses: no pull, no more than friction; and no small change of the forces fits better."""
    rng = np.random.default_rng(6)
    grains, walls, true = cube(rng)
    wrong = dataclasses.replace(grains, stress=grains.stress * (1 + 0.5 * rng.normal(size=grains.stress.shape)))
    found = infer(wrong, walls, EXACT)
    assert (found.force[:, 0] >= 0).all()
    slack = 1e-9 * np.abs(true).max()
    assert (np.linalg.norm(found.force[:, 1:], axis=1) <= 0.3 * found.force[:, 0] + slack).all()
    matrix, data = found.equations.matrix, found.equations.data()
    gradient = (matrix.T @ (matrix @ found.force.ravel() - data)).reshape(-1, 3)
    # the gradient at the best forces lies in the dual of each cone, and is orthogonal to the force
    size = np.abs(gradient).max()
    assert (gradient[:, 0] >= 0.3 * np.linalg.norm(gradient[:, 1:], axis=1) - 1e-6 * size).all()
    assert np.abs((gradient * found.force).sum(axis=1)).max() < 1e-6 * size * np.abs(true).max()


def random_plane(n_contacts, rng):
    """A random sparse problem as large as that of a crystal."""
    rows = 6 * n_contacts // 5
    matrix = sparse.random_array((2 * rows, 2 * n_contacts), density=0.1, rng=rng, data_sampler=rng.normal)
    return sparse.csr_array(matrix), rng.normal(size=2 * rows)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_two_solvers_agree_in_the_plane(friction):
    """Non-negative least squares and cones (Clarabel)."""
    matrix, data = random_plane(60, np.random.default_rng(7))
    each = np.full(60, friction)
    first, second = solve(matrix, data, each, 2), solve_conic(matrix, data, each, 2)
    assert np.linalg.norm(first - second) < 1e-7 * np.linalg.norm(first)
    misfit = [float(np.sum((matrix @ force.ravel() - data) ** 2)) for force in (first, second)]
    assert misfit[1] == pytest.approx(misfit[0], rel=1e-10)


def test_equations_leave_forces_without_matter_alone():
    """Grains that were not measured have no equations."""
    grains = discs([[RADIUS, 0], [3 * RADIUS, 0]], [[-1e3, 0, 0], [np.nan] * 3])
    contacts = find_contacts(grains, {"left": Wall((0, 0), (1, 0))}, 1e-3)
    equations = make_equations(grains, contacts)
    assert set(equations.stress_grain.tolist()) == {0}
    assert set(equations.motion_grain.tolist()) == {0, 1}


@pytest.mark.validation
def test_five_hundred_unknowns_take_half_a_second():
    from tests.analysis.inference.test_crystals import measured, state_of

    exact, walls, _ = state_of("hexagonal", 1e-3)
    grains, noise = measured(exact, 0.05, np.random.default_rng(1))
    started = time.process_time()
    found = infer(grains, walls, dataclasses.replace(EXACT, noise=noise))
    assert found.n_unknowns >= 490
    assert time.process_time() - started < 0.5


def test_forces_above_two_standard_errors_are_counted():
    """Noise gives most candidates some force. In the figure depth goes down, as everywhere."""
    grains, walls, _ = cube(np.random.default_rng(5))
    exact = infer(grains, walls, EXACT)
    assert instant_summary(exact, 0.0)["n_significant_contacts"] is None
    share = np.where(np.arange(len(exact.force)) < 7, 0.4, 0.6)
    noisy = dataclasses.replace(exact, spread=exact.force * share[:, None])
    values = instant_summary(noisy, 0.0)
    assert (values["n_significant_contacts"], values["n_loaded_contacts"]) == (7, len(exact.force))
    axes = network(exact).figure.axes[0]
    vertical = "Depth" in axes.get_ylabel()
    assert axes.yaxis_inverted() == vertical == (axes.get_ylabel() != "$y$ (mm)")
