"""Elastic impact of the punch, and the loss to artificial viscosity, compared with closed forms.

The viscosity damps the waves that the impact radiates into the block. These tests show that the
loss is that of the equation of the viscosity, and that the force on the punch and its rebound do
not depend on it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from granwave.extensions.continuum.material import LINEAR_VISCOSITY, Elastoplastic
from granwave.extensions.continuum.punch import ContinuumCase
from granwave.extensions.continuum.punch.mesh import Mesh
from granwave.extensions.continuum.punch.run import SAMPLED, BlockRun
from granwave.extensions.continuum.punch.solver import PunchSolver

MODULUS = 115e9
POISSON = 1 / 3
DENSITY = 8500.0
RADIUS = 0.005
#: Veletsos and Verbic, Int. J. Earthquake Eng. Struct. Dyn. 2 (1973) 87: constants of the vertical
#: impedance of a rigid disc on a half-space, Poisson's ratio 1/3, fitted to the exact solution.
MAXWELL = 0.35
MAXWELL_TIME = 0.8
DASHPOT = 0.75


def rebound_of_half_space(mass):
    """Restitution, largest displacement and largest mean force between records of a rigid flat
    punch on an elastic half-space, for 1 m/s.

    Spring K = 4 G a/(1 - nu) with a dashpot and a Maxwell element in parallel, whose times are
    multiples of a/c_S.
    """
    shear = MODULUS / (2 * (1 + POISSON))
    time = RADIUS / math.sqrt(shear / DENSITY)
    stiffness = 4 * shear * RADIUS / (1 - POISSON)
    relaxation = MAXWELL_TIME * time

    def force(state):
        place, speed, relaxed = state
        maxwell = MAXWELL * (relaxation * speed - (place - relaxed))
        return stiffness * (place + DASHPOT * time * speed + maxwell)

    def rates(_, state):
        place, speed, relaxed = state
        return [speed, -force(state) / mass, (place - relaxed) / relaxation]

    def separation(_, state):
        return force(state)

    separation.terminal = True
    separation.direction = -1
    found = solve_ivp(
        rates, (0, 1e-3), [0, 1, 0], events=separation, rtol=1e-9, atol=1e-14, dense_output=True
    )
    speed = found.sol(np.arange(0, found.t[-1], SAMPLED))[1]
    return -found.y[1, -1], found.y[0].max(), -mass * np.diff(speed).min() / SAMPLED


def elastic_impact(mass, *, viscosity=1.0, elements=4000):
    """Summary of an elastic impact at 1 m/s, without returns from the boundaries.

    Parameters
    ----------
    viscosity
        Factor of both coefficients of the bulk viscosity.
    """
    material = {
        "youngs_modulus": MODULUS,
        "poisson_ratio": POISSON,
        "density": DENSITY,
        "yield_strength": 1e12,
    }
    tables = {
        "name": "elastic",
        "material": material,
        "block": {"diameter": 0.2, "height": 0.1},
        "punch": {"mass": mass, "velocity": 1.0, "taper": 0.0, "diameter": 2 * RADIUS},
        "run": {"elements": elements},
    }
    run = BlockRun(ContinuumCase.from_dict(tables))
    *others, linear, quadratic = run.solver._constants
    run.solver._constants = (*others, viscosity * linear, viscosity**2 * quadratic)
    run.integrate()
    return run.summarise(1.0)


@pytest.mark.parametrize(("mass", "error"), [(0.00445, 0.05), (0.02, 0.025)])
def test_rebound_from_an_elastic_block(mass, error):
    """The light punch radiates 93 % of its energy, the heavier one 73 %."""
    restitution, displacement, force = rebound_of_half_space(mass)
    found = elastic_impact(mass)
    assert -found["impactor_velocity_m_s"] == pytest.approx(restitution, rel=error)
    assert found["punch_peak_displacement_m"] == pytest.approx(displacement, rel=0.02)
    assert found["peak_force_N"] == pytest.approx(force, rel=0.06)
    assert found["dissipated_fraction"] == 0


@pytest.mark.validation
@pytest.mark.parametrize("mass", [0.00445, 0.02])
def test_viscosity_does_not_change_the_contact(mass):
    """Without viscosity and with twice as much the punch rebounds in the same way."""
    found = {
        factor: elastic_impact(mass, viscosity=factor, elements=8000) for factor in (0.0, 1.0, 2.0)
    }
    speeds = [values["impactor_velocity_m_s"] for values in found.values()]
    depths = [values["punch_peak_displacement_m"] for values in found.values()]
    assert np.ptp(speeds) < 0.015 * abs(np.mean(speeds))
    assert np.ptp(depths) < 1e-3 * np.mean(depths)
    losses = {factor: values["energy_viscous_J"] for factor, values in found.items()}
    assert losses[0.0] == 0
    assert losses[2.0] > losses[1.0]


def front_loss(n_elements, length=0.1):
    """Energy that the viscosity takes from a step front that crosses a confined column, by the
    solver and by theory, J.

    A front of velocity v in a medium of kinematic viscosity n has the width sqrt(n t), so that the
    loss per area is rho v^2 sqrt(n t/pi); here n = b1 c h with elements of the height h.
    """
    radius = 1e-3
    material = Elastoplastic(MODULUS, POISSON, DENSITY, math.inf)
    mesh = Mesh(np.linspace(0, radius, 2), np.linspace(0, length, n_elements + 1))
    # the shorter side of an element, on which the viscosity acts, is its height
    assert length / n_elements < radius
    solver = PunchSolver(
        mesh, material, gap=np.zeros(2), punch_mass=1e9, punch_velocity=1.0, sides="roller"
    )
    speed = material.longitudinal_speed
    while solver.time < 0.9 * length / speed:
        viscous = solver.advance(5)["viscous"]
        time = solver.time - 5 * solver.timestep
    kinematic = LINEAR_VISCOSITY * speed * length / n_elements
    return viscous, DENSITY * math.sqrt(kinematic * time / math.pi) * math.pi * radius**2


@pytest.mark.parametrize("n_elements", [400, 1600])
def test_viscosity_takes_the_energy_of_a_front(n_elements):
    """The loss decreases with the root of the element size: it is a property of the mesh."""
    found, theory = front_loss(n_elements)
    assert found == pytest.approx(theory, rel=0.1)
