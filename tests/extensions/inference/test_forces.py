"""Forces from measured grains: closed forms, exact data, another solver, and spheres."""

from __future__ import annotations

import dataclasses
import time
from functools import cache

import numpy as np
import pytest
from scipy import sparse

from granwave.extensions.inference.forces.case import Infer
from granwave.extensions.inference.forces.equations import make_equations
from granwave.extensions.inference.forces.freedom import freedom
from granwave.extensions.inference.forces.grains import (
    MeasuredGrains,
    StraightWall,
    find_contacts,
    stiffness,
)
from granwave.extensions.inference.forces.infer import infer, relative_noise
from granwave.extensions.inference.forces.output import network
from granwave.extensions.inference.forces.solve import solve, solve_conic
from granwave.extensions.inference.forces.tables import instant_summary
from tests.helpers.bodies import plane_crystal

RADIUS = 0.01
MASS = 0.3
EXACT = Infer(friction=0.3, repetitions=0)


def discs(x, stress, acceleration=0.0, spin=0.0, turning=0.0):
    """Equal discs of a metre's length with given stresses (xx, yy, xy)."""
    n = len(x)
    return MeasuredGrains(
        np.arange(1, n + 1), np.array(x, float), np.full(n, RADIUS), np.full(n, MASS), np.full(n, np.pi * RADIUS**2),
        np.zeros((n, 2)) + acceleration, np.zeros((n, 1)) + spin, np.zeros((n, 1)) + turning, np.zeros((n, 2)),
        np.array(stress, float),
    )  # fmt: skip


def test_a_disc_between_two_walls():
    """Stress -2 F/(pi R) across the disc."""
    force = 1234.5
    walls = {"left": StraightWall((0, 0), (1, 0)), "right": StraightWall((2 * RADIUS, 0), (-1, 0))}
    found = infer(discs([[RADIUS, 0]], [[-2 * force / (np.pi * RADIUS), 0, 0]]), walls, EXACT)
    assert found.contacts.walls == ("left", "right")
    np.testing.assert_allclose(found.force, [[force, 0], [force, 0]], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(
        found.contacts.vectors(found.force), [[force, 0], [-force, 0]], rtol=1e-12, atol=1e-9
    )


def test_a_row_of_three_that_is_pushed():
    """Forces 3 m a, 2 m a, m a, and zero at the far side."""
    acceleration = 1000.0
    forces = MASS * acceleration * np.array([3, 2, 1, 0])
    x = [[RADIUS * (1 + 2 * k), 0.0] for k in range(3)]
    across = -(forces[:3] + forces[1:]) / (np.pi * RADIUS)
    grains = discs(
        x, np.stack([across, 0 * across, 0 * across], axis=1), acceleration=[acceleration, 0.0]
    )
    walls = {"piston": StraightWall((0, 0), (1, 0)), "end": StraightWall((6 * RADIUS, 0), (-1, 0))}
    found = infer(grains, walls, EXACT)
    by_place = sorted(zip(found.grains.position[found.contacts.first] + found.contacts.arm, found.force, strict=True),
                      key=lambda pair: pair[0][0])  # fmt: skip
    np.testing.assert_allclose([force[0] for _, force in by_place], forces, rtol=1e-12, atol=1e-9)


def test_a_spinning_disc_bears_the_stress_of_the_closed_form():
    """Mean stress rho w^2 R^2/4 of a free spinning disc (Timoshenko and Goodier), with no contact
    force.
    """
    spin = 500.0
    hoop = MASS / (np.pi * RADIUS**2) * spin**2 * RADIUS**2 / 4
    found = infer(
        discs([[RADIUS, 0]], [[hoop, hoop, 0]], spin=spin),
        {"left": StraightWall((0, 0), (1, 0))},
        EXACT,
    )
    np.testing.assert_allclose(found.force, 0, atol=1e-9)


@pytest.mark.parametrize("state", ["plane-stress", "plane-strain", "space"])
def test_stiffness_is_hookes(state):
    """Compared with the strains of a bar, a strip and a block."""
    modulus = 70e6
    ratio = 0.4
    inverse = np.linalg.inv(stiffness(np.array([modulus]), np.array([ratio]), state)[0])
    lengthwise, crosswise = {
        "plane-stress": (1, -ratio), "plane-strain": (1 - ratio**2, -ratio * (1 + ratio)), "space": (1, -ratio),
    }[state]  # fmt: skip
    np.testing.assert_allclose(inverse[0, :2] * modulus, [lengthwise, crosswise], rtol=1e-12)
    np.testing.assert_allclose(inverse[-1, -1] * modulus, 1 + ratio, rtol=1e-12)


def cube(rng, sliding=0.0):
    """A cube of 27 spheres in a box, with random forces in the cones of friction, some of them on
    the cone, and the resulting state.

    Accelerations and stresses are sums over contacts, computed here; the forces are not in
    equilibrium.
    """
    n_side = 3
    radius = 0.004
    mass = 2e-3
    x = (
        2
        * radius
        * (
            0.5
            + np.array(
                [(i, j, k) for k in range(n_side) for j in range(n_side) for i in range(n_side)]
            )
        )
    )
    width = 2 * radius * n_side
    walls = {"left": StraightWall((0, 0, 0), (1, 0, 0)), "right": StraightWall((width, 0, 0), (-1, 0, 0)),
             "floor": StraightWall((0, 0, 0), (0, 0, 1)), "slope": StraightWall((0, width, 0), (0, -1, 0))}  # fmt: skip
    n = len(x)
    spin = 100 * rng.normal(size=(27, 3))
    zero = np.zeros((n, 3))
    volume = np.full(n, 4 / 3 * np.pi * radius**3)
    bare = MeasuredGrains(np.arange(1, n + 1), x, np.full(n, radius), np.full(n, mass), volume, zero, spin, zero, zero,
                  np.zeros((n, 6)))  # fmt: skip
    contacts = find_contacts(bare, walls, 1e-3)
    normal = rng.exponential(50.0, len(contacts))
    shear = rng.normal(size=(len(contacts), 2))
    part = rng.uniform(size=len(contacts))
    part[: round(sliding * len(part))] = 1.0
    shear *= (0.3 * normal * part / np.linalg.norm(shear, axis=1))[:, None]
    true = np.concatenate([normal[:, None], shear], axis=1)
    total = np.zeros((n, 3))
    torque = np.zeros((n, 3))
    moment = np.zeros((n, 3, 3))
    for m, force in enumerate(contacts.vectors(true)):
        i = contacts.first[m]
        j = contacts.second[m]
        for grain, sign, arm in (
            (i, 1, -radius * contacts.normal[m]),
            (j, -1, radius * contacts.normal[m]),
        ):
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
    voigt = np.stack(
        [stress[:, a, b] for a, b in ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))], axis=1
    )
    inertia = 2 / 5 * mass * radius**2
    grains = dataclasses.replace(
        bare, acceleration=total / mass, angular_acceleration=torque / inertia, stress=voigt
    )
    return grains, walls, true


def test_spheres_in_space_are_exact():
    grains, walls, true = cube(np.random.default_rng(5))
    found = infer(grains, walls, EXACT)
    np.testing.assert_allclose(found.force, true, rtol=0, atol=1e-12 * np.abs(true).max())


def test_spheres_in_space_stay_within_their_cones():
    """With wrong stresses: no tension, no tangential force above the friction limit; and no small
    change of the forces fits better.
    """
    rng = np.random.default_rng(6)
    grains, walls, true = cube(rng)
    wrong = dataclasses.replace(
        grains, stress=grains.stress * (1 + 0.5 * rng.normal(size=grains.stress.shape))
    )
    found = infer(wrong, walls, EXACT)
    assert (found.force[:, 0] >= 0).all()
    slack = 1e-9 * np.abs(true).max()
    assert (np.linalg.norm(found.force[:, 1:], axis=1) <= 0.3 * found.force[:, 0] + slack).all()
    matrix = found.equations.matrix
    data = found.equations.data()
    gradient = (matrix.T @ (matrix @ found.force.ravel() - data)).reshape(-1, 3)
    # the gradient at the best forces lies in the dual of each cone, and is orthogonal to the force
    size = np.abs(gradient).max()
    assert (gradient[:, 0] >= 0.3 * np.linalg.norm(gradient[:, 1:], axis=1) - 1e-6 * size).all()
    assert np.abs((gradient * found.force).sum(axis=1)).max() < 1e-6 * size * np.abs(true).max()


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        ([[1.0, 0.3], [1.0, 0.1], [0.0, 0.0], [2.0, -0.6]], 1 + 2 + 0 + 1),
        ([[1.0, 0.3, 0.0], [1.0, 0.1, 0.1], [1e-12, 0.0, 0.0], [2.0, 0.0, -0.6]], 2 + 3 + 0 + 2),
    ],
)
def test_contacts_that_slide_have_a_component_less(force, expected):
    """A sliding contact has one of two free components in the plane, two of three in space; without
    friction one, without load none.
    """
    force = np.array(force)
    free = freedom(force, np.full(4, 0.3), np.zeros_like(force))
    assert len(free.held) == expected
    changed = (force.ravel() + 1e-6 * free.directions.toarray().T).reshape(-1, *force.shape)
    size = np.linalg.norm(changed[..., 1:], axis=-1)
    assert (size[:, [0, 3]] <= 0.3 * changed[:, [0, 3], 0] * (1 + 1e-9)).all()
    smooth = freedom(force * np.eye(force.shape[1])[0], np.zeros(4), np.zeros_like(force))
    assert len(smooth.held) == 3


@pytest.mark.parametrize("weights", ["white", "correlated"])
def test_chi_squared_of_true_noise_is_near_one(weights):
    """With a third of the contacts at their limit of friction, and noise of 2 %."""
    exact, walls, _ = cube(np.random.default_rng(5), 1 / 3)
    rng = np.random.default_rng(3)
    size = relative_noise(exact, 0.02)
    each = []
    for _ in range(20):
        grains = dataclasses.replace(
            exact,
            **{
                name: getattr(exact, name) + scale * rng.normal(size=getattr(exact, name).shape)
                for name, scale in (
                    ("stress", size.stress),
                    ("acceleration", size.acceleration),
                    ("angular_acceleration", size.angular_acceleration),
                )
            },
        )
        settings = dataclasses.replace(EXACT, noise=size, weights=weights)
        each.append(instant_summary(infer(grains, walls, settings), 0.0)["chi2_per_equation"])
    assert np.mean(each) == pytest.approx(1, abs=0.06)
    assert np.std(each) == pytest.approx(np.sqrt(2 / 75), rel=0.4)


def test_chi_squared_of_discs_counts_what_the_noise_leaves():
    """Strains whose errors are correlated by Hooke's law, with both kinds of weights."""
    exact, walls, _ = state_of("centred-square", 0.5e-3)
    rng = np.random.default_rng(8)
    for weights, lowest in (("white", 215), ("correlated", 220)):
        grains, size = measured(exact, 0.01, rng)
        found = infer(grains, walls, dataclasses.replace(EQUAL, noise=size, weights=weights))
        assert lowest < found.n_free < 240  # some 186 with both components of all
        assert found.chi2 / found.n_free == pytest.approx(1, abs=3 * np.sqrt(2 / 220))


def random_plane(n_contacts, rng):
    """A random sparse problem of the size of a crystal."""
    rows = 6 * n_contacts // 5
    matrix = sparse.random_array(
        (2 * rows, 2 * n_contacts), density=0.1, rng=rng, data_sampler=rng.normal
    )
    return sparse.csr_array(matrix), rng.normal(size=2 * rows)


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_two_solvers_agree_in_the_plane(friction):
    """Non-negative least squares and cones (Clarabel)."""
    matrix, data = random_plane(60, np.random.default_rng(7))
    each = np.full(60, friction)
    first = solve(matrix, data, each, 2)
    second = solve_conic(matrix, data, each, 2)
    assert np.linalg.norm(first - second) < 1e-7 * np.linalg.norm(first)
    misfit = [float(np.sum((matrix @ force.ravel() - data) ** 2)) for force in (first, second)]
    assert misfit[1] == pytest.approx(misfit[0], rel=1e-10)


def test_equations_leave_forces_without_matter_alone():
    """Grains that were not measured have no equations."""
    grains = discs([[RADIUS, 0], [3 * RADIUS, 0]], [[-1e3, 0, 0], [np.nan] * 3])
    contacts = find_contacts(grains, {"left": StraightWall((0, 0), (1, 0))}, 1e-3)
    equations = make_equations(grains, contacts)
    assert set(equations.stress_grain.tolist()) == {0}
    assert set(equations.motion_grain.tolist()) == {0, 1}


@pytest.mark.validation
def test_five_hundred_unknowns_take_half_a_second():
    from tests.extensions.inference.test_forces import measured, state_of

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


EQUAL = Infer(friction=plane_crystal.FRICTION, contact_tolerance=1e-6, repetitions=0)
#: |f - f_true|/|f_true| by noise, of equal and white weights: physics-plane.md, section 6, from another program.
PRINTED = {
    "centred-square": {
        0.01: (0.0070, 0.0051),
        0.05: (0.0345, 0.0254),
        0.10: (0.070, 0.049),
        0.50: (0.311, 0.217),
    },
    "hexagonal": {
        0.01: (0.025, 0.022),
        0.05: (0.088, 0.073),
        0.10: (0.152, 0.126),
        0.50: (0.519, 0.394),
    },
}
INSTANTS = (0.5e-3, 1.0e-3, 1.5e-3)


@cache
def snapshots(name, times):
    return plane_crystal.snapshots(name, times)


def state_of(name, time, times=(0.5e-3,)):
    """Grains with exact strains, walls, and the true forces of the candidates."""
    times = times if time in times else (time,)
    snapshot = snapshots(name, times)[times.index(time)]
    n = len(snapshot.position)
    modulus, ratio = (np.full(n, value) for value in (plane_crystal.MODULUS, plane_crystal.POISSON))
    stress = snapshot.stress()
    radius = np.full(n, plane_crystal.RADIUS)
    grains = MeasuredGrains(
        np.arange(1, n + 1), snapshot.position, radius, np.full(n, plane_crystal.MASS), np.pi * radius**2,
        snapshot.acceleration, snapshot.spin[:, None], snapshot.angular_acceleration[:, None], np.zeros((n, 2)),
        np.stack([stress[:, 0, 0], stress[:, 1, 1], stress[:, 0, 1]], axis=1),
        np.linalg.inv(stiffness(modulus, ratio, "plane-stress")), modulus,
    )  # fmt: skip
    left, right, floor, plate = snapshot.levels
    walls = {"left": StraightWall((left, 0), (1, 0)), "right": StraightWall((right, 0), (-1, 0)),
             "floor": StraightWall((0, floor), (0, -1)), "plate": StraightWall((0, plate), (0, 1))}  # fmt: skip
    contacts = find_contacts(grains, walls, EQUAL.contact_tolerance)
    partner = np.where(contacts.second >= 0, contacts.second, -1 - contacts.wall)
    row = {
        pair: m
        for m, pair in enumerate(zip(contacts.first.tolist(), partner.tolist(), strict=True))
    }
    vectors = np.zeros((len(contacts), 2))
    for i, j, force in zip(
        snapshot.first.tolist(), snapshot.second.tolist(), snapshot.force, strict=True
    ):
        vectors[row[i, j]] = force
    return grains, walls, contacts.components(vectors)


def measured(grains, noise, rng):
    """Grains with errors that are a fraction of the root mean squares, and their standard
    deviations.
    """
    size = relative_noise(grains, noise)
    strain = np.einsum("nij,nj->ni", grains.compliance, grains.stress)
    strain = strain + size.strain * rng.normal(size=strain.shape)
    return dataclasses.replace(
        grains,
        stress=np.linalg.solve(grains.compliance, strain[:, :, None])[:, :, 0],
        acceleration=grains.acceleration
        + size.acceleration * rng.normal(size=grains.acceleration.shape),
        angular_acceleration=grains.angular_acceleration
        + size.angular_acceleration * rng.normal(size=grains.angular_acceleration.shape),
    ), size


def error(found, true):
    return float(np.linalg.norm(found.force - true) / np.linalg.norm(true))


def errors(name, noise, times, repetitions):
    """Errors with equal and white weights, averaged over instants and repetitions."""
    rng = np.random.default_rng(11)
    found = []
    for instant in times:
        exact, walls, true = state_of(name, instant, times)
        for _ in range(repetitions):
            grains, size = measured(exact, noise, rng)
            each = [
                dataclasses.replace(EQUAL, noise=size, weights=kind)
                for kind in ("equal", "white", "correlated")
            ]
            found.append([error(infer(grains, walls, settings), true) for settings in each])
    return np.mean(found, axis=0)


@pytest.mark.parametrize("name", plane_crystal.CRYSTALS)
def test_exact_data_give_exact_forces(name):
    grains, walls, true = state_of(name, 0.5e-3)
    assert error(infer(grains, walls, EQUAL), true) < 1e-12
    assert (
        error(
            infer(grains, walls, dataclasses.replace(EQUAL, contact_tolerance=0.02)),
            true_of_more(name),
        )
        < 1e-12
    )


def true_of_more(name):
    """Forces of the candidates agree with the true forces within 0.02; most candidates carry no
    force.
    """
    grains, walls, true = state_of(name, 0.5e-3)
    few, many = (
        find_contacts(grains, walls, tolerance) for tolerance in (EQUAL.contact_tolerance, 0.02)
    )
    row = {key: m for m, key in enumerate(zip(many.first, many.second, many.wall, strict=True))}
    found = np.zeros((len(many), 2))
    found[[row[key] for key in zip(few.first, few.second, few.wall, strict=True)]] = true
    return found


@pytest.mark.parametrize("name", plane_crystal.CRYSTALS)
def test_errors_under_noise(name):
    """Errors are within 20 % of the other program; correlated weights give smaller errors than
    white weights.
    """
    equal, white, correlated = errors(name, 0.05, (0.5e-3,), 2)
    assert [equal, white] == pytest.approx(PRINTED[name][0.05], rel=0.2)
    assert correlated < 1.02 * white


@pytest.mark.validation
@pytest.mark.parametrize("name", plane_crystal.CRYSTALS)
@pytest.mark.parametrize("noise", [0.01, 0.05, 0.10, 0.50])
def test_errors_under_noise_at_three_instants(name, noise):
    equal, white, _ = errors(name, noise, INSTANTS, 6)
    assert [equal, white] == pytest.approx(PRINTED[name][noise], rel=0.2)


def test_error_bars_tell_the_errors():
    """The squares of errors / standard errors are one on average."""
    rng = np.random.default_rng(2)
    exact, walls, true = state_of("centred-square", 0.5e-3)
    ratio = []
    for _ in range(2):
        grains, size = measured(exact, 0.02, rng)
        found = infer(grains, walls, dataclasses.replace(EQUAL, noise=size, repetitions=12))
        ratio.append(np.sum((found.force - true) ** 2) / np.sum(found.spread**2))
    assert np.mean(ratio) == pytest.approx(1, abs=0.25)


def test_the_modulus_is_found():
    """Within 3 % at 10 % noise, and within its own standard error, from strains at a modulus three
    times too large.
    """
    rng = np.random.default_rng(3)
    exact, walls, _ = state_of("centred-square", 0.5e-3)
    wrong = 3.0
    factors = []
    spreads = []
    for _ in range(2):
        grains, size = measured(exact, 0.10, rng)
        assumed = dataclasses.replace(
            grains,
            stress=wrong * grains.stress,
            compliance=grains.compliance / wrong,
            modulus=wrong * grains.modulus,
        )
        found = infer(assumed, walls, dataclasses.replace(EQUAL, noise=size, modulus="find"))
        factors.append(wrong * found.factor)
        spreads.append(found.search.error)
    assert np.mean(factors) == pytest.approx(1, abs=0.03)
    assert np.abs(np.array(factors) - 1).max() < 3.5 * np.mean(spreads)
    assert 0.005 < np.mean(spreads) < 0.03


@pytest.mark.validation
@pytest.mark.parametrize("name", plane_crystal.CRYSTALS)
def test_the_modulus_has_no_bias(name):
    """The mean of 20 at 10 % noise lies within three of its standard errors."""
    rng = np.random.default_rng(4)
    exact, walls, _ = state_of(name, 1e-3)
    found = []
    for _ in range(20):
        grains, size = measured(exact, 0.10, rng)
        one = infer(grains, walls, dataclasses.replace(EQUAL, noise=size, modulus="find"))
        found.append((one.factor, one.search.error))
    factors, spreads = np.array(found).T
    assert abs(np.log(factors).mean()) < 3 * spreads.mean() / np.sqrt(20)
    assert np.log(factors).std(ddof=1) == pytest.approx(spreads.mean(), rel=0.4)
