"""Continuum solver against theory: waves, yield, patch tests, contact, energy; then its input and output."""

from __future__ import annotations

import math

import numpy as np
import pytest
from skfem import LinearForm

from granwave.workflows.finite_elements.material import RR, ZZ, Elastoplastic
from granwave.workflows.finite_elements.punch import ContinuumCase, kernels
from granwave.workflows.finite_elements.punch.mesh import Mesh, block_mesh, contact_end, punch_gap
from granwave.workflows.finite_elements.punch.run import BlockRun
from granwave.workflows.finite_elements.punch.solver import Solver, library_basis
from tests.helpers.punch import values_of

BRASS = Elastoplastic(115e9, 0.30, 8500.0, 550e6)
ELASTIC = Elastoplastic(115e9, 0.30, 8500.0, math.inf)


def graded(n_r=7, n_z=9):
    rng = np.random.default_rng(5)
    lines = [np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, n))]) * 1e-3 for n in (n_r, n_z)]
    return Mesh(*lines)


def move(solver, radial, axial):
    """One step of a displacement field, from rest."""
    r, z = solver.mesh.nodes.T.reshape(2, *solver.motion.shape[1:])
    solver.motion[2], solver.motion[3] = radial(r, z) / solver.timestep, axial(r, z) / solver.timestep
    solver._mobility[:] = 0.0  # as prescribed
    solver.advance(1)


def column(material, velocity, *, sides, radius, length, n_r, n_z):
    """Cylinder whose whole top is driven at constant velocity."""
    mesh = Mesh(np.linspace(0, radius, n_r + 1), np.linspace(0, length, n_z + 1))
    return Solver(mesh, material, gap=np.zeros(n_r + 1), punch_mass=1e9, punch_velocity=velocity, sides=sides)


def go(solver, end):
    while solver.time < end:
        solver.advance(solver.every(2e-7))


def test_nodal_forces_are_those_that_scikit_fem_assembles():
    mesh = graded()
    solver = Solver(mesh, ELASTIC, bottom="free")
    rng = np.random.default_rng(1)
    field = rng.normal(size=(2, *solver.motion.shape[1:])) * 1e-7
    solver.operators.hourglass[:] = 0.0
    solver._constants = (*solver._constants[:3], 0.0, 0.0)  # no bulk viscosity
    move(solver, lambda r, z: field[0], lambda r, z: field[1])
    rr, zz, tt, rz = np.moveaxis(solver.state[:, :, :4], 2, 0).reshape(4, -1, 1)
    basis = library_basis(mesh)
    u, w = (basis.interpolate(part.ravel()) for part in field)
    radius = np.asarray(basis.global_coordinates())[0]
    strain = np.stack([u.grad[0], w.grad[1], np.asarray(u) / radius, u.grad[1] + w.grad[0]])
    assert np.allclose(np.einsum("kl,leq->keq", BRASS.stiffness, strain), [rr, zz, tt, rz], rtol=1e-9, atol=1e-2)
    f_r = LinearForm(lambda v, x: 2 * np.pi * (x.x[0] * (v.grad[0] * rr + v.grad[1] * rz) + v * tt)).assemble(basis)
    f_z = LinearForm(lambda v, x: 2 * np.pi * x.x[0] * (v.grad[0] * rz + v.grad[1] * zz)).assemble(basis)
    for found, expected in zip(solver.motion[4:], (f_r, f_z), strict=True):
        assert np.allclose(found.ravel(), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_mass_is_that_of_the_block():
    solver = Solver(block_mesh(0.05, 0.1, 0.005, 2000), BRASS)
    assert solver.operators.mass.sum() == pytest.approx(8500 * math.pi * 0.05**2 * 0.1, rel=1e-12)
    assert solver.operators.volume.sum() == pytest.approx(math.pi * 0.05**2 * 0.1, rel=1e-12)


def test_rigid_motion_gives_no_stress():
    solver = Solver(graded(), BRASS, bottom="free")
    solver.set_velocity(np.zeros(solver.motion.shape[1:]), np.full(solver.motion.shape[1:], 7.0))
    for _ in range(20):
        instant = solver.advance(5)
    assert np.abs(solver.state[:, :, :4]).max() < 1e-3  # Pa
    assert instant["kinetic"] == pytest.approx(0.5 * solver.operators.mass.sum() * 49, rel=1e-12)
    assert solver.motion[1] == pytest.approx(7.0 * solver.time, rel=1e-12)


@pytest.mark.parametrize(("radial", "axial"), [(1e-4, 0.0), (0.0, 1e-4), (2e-4, -1e-4)])
def test_patch(radial, axial):
    """A homogeneous strain on a graded mesh that includes the axis gives uniform stress and no force on any inner node."""
    solver = Solver(graded(), ELASTIC, bottom="free")
    solver._constants = (*solver._constants[:3], 0.0, 0.0)
    move(solver, lambda r, z: radial * r, lambda r, z: axial * z)
    expected = ELASTIC.stiffness @ [radial, axial, radial, 0.0]
    assert solver.state[:, :, :4] == pytest.approx(np.broadcast_to(expected, (9, 7, 4)), rel=1e-9, abs=1e-2)
    scale = np.abs(solver.motion[4:]).max()
    assert np.abs(solver.motion[4, 1:-1, :-1]).max() < 1e-9 * scale  # nodes on the axis are inner nodes
    assert np.abs(solver.motion[5, 1:-1]).max() < 1e-9 * scale


@pytest.mark.parametrize("elements", [400, 4000])
def test_timestep_is_just_below_the_limit(elements):
    """Random motion of an elastic block conserves energy at the chosen timestep, and is unstable at 1.4 times that."""
    for factor, stable in ((1.0, True), (1.4, False)):
        solver = Solver(block_mesh(0.05, 0.1, 0.005, elements), ELASTIC)
        solver.timestep *= factor
        shape = solver.motion.shape[1:]
        rng = np.random.default_rng(0)
        solver.set_velocity(rng.normal(size=shape), rng.normal(size=shape))
        first = solver.advance(1500)["total"]
        total = solver.look()["total"]
        assert bool(total < 1.01 * first) is stable


def test_confined_column_carries_the_longitudinal_wave():
    solver = column(ELASTIC, 1.0, sides="roller", radius=1e-3, length=0.05, n_r=4, n_z=200)
    speed = ELASTIC.longitudinal_speed
    assert speed == pytest.approx(math.sqrt(115e9 * 0.7 / (1.3 * 0.4 * 8500)))
    go(solver, 0.04 / speed)
    stress = -solver.state[:, 2, ZZ]
    depth = solver.mesh.centres[1]
    front = np.interp(-0.5, -stress / stress[0], depth)
    assert front == pytest.approx(speed * solver.time, rel=5e-3)
    behind = depth < 0.8 * speed * solver.time
    assert stress[behind].mean() == pytest.approx(8500 * speed * 1.0, rel=2e-3)
    assert stress[behind] == pytest.approx(8500 * speed * 1.0, rel=0.02)  # ringing
    lateral = -solver.state[behind, 2, RR]
    assert lateral == pytest.approx(0.3 / 0.7 * stress[behind], rel=1e-3)


def test_slender_bar_carries_the_bar_wave():
    solver = column(ELASTIC, 1.0, sides="free", radius=1e-3, length=0.1, n_r=4, n_z=400)
    speed = math.sqrt(115e9 / 8500)
    go(solver, 0.08 / speed)
    volume = solver.operators.volume
    stress = -np.average(solver.state[:, :, ZZ], axis=1, weights=volume[0])
    depth = solver.mesh.centres[1]
    front = np.interp(-0.5, -stress[100:] / (8500 * speed), depth[100:])
    assert front == pytest.approx(speed * solver.time, rel=0.01)
    behind = (depth > 0.01) & (depth < 0.06)
    assert stress[behind].mean() == pytest.approx(8500 * speed * 1.0, rel=5e-3)


def test_plane_impact_has_an_elastic_precursor():
    """Uniaxial strain beyond yield: precursor of sigma_y (1-nu)/(1-2 nu) at c_L, plastic wave at sqrt(K/rho)."""
    velocity, length = 60.0, 0.05
    solver = column(BRASS, velocity, sides="roller", radius=5e-4, length=length, n_r=2, n_z=800)
    speed, plastic_speed = BRASS.longitudinal_speed, math.sqrt(115e9 / (3 * 0.4) / 8500)
    limit = 550e6 * 0.7 / 0.4
    step = limit / (8500 * speed)  # particle velocity behind the precursor
    top = limit + 8500 * plastic_speed * (velocity - step)
    go(solver, 0.9 * length / speed)
    depth, stress = solver.mesh.centres[1], -solver.state[:, 1, ZZ]
    between = (depth > 1.05 * plastic_speed * solver.time) & (depth < 0.96 * speed * solver.time)
    assert stress[between].mean() == pytest.approx(limit, rel=0.01)
    behind = (depth > 0.1 * length) & (depth < 0.9 * plastic_speed * solver.time)
    assert stress[behind] == pytest.approx(top, rel=0.01)
    assert np.interp(-(limit + top) / 2, -stress, depth) == pytest.approx(plastic_speed * solver.time, rel=0.01)
    assert np.interp(-limit / 2, -stress, depth) == pytest.approx(speed * solver.time, rel=0.01)
    assert solver.von_mises.max() <= 550e6 * (1 + 1e-12)


def test_plastic_flow_does_not_lock():
    """A punch pressed in at constant velocity reaches the limit load; with a locking mesh the load continues to grow.

    Smooth circular punch on Tresca's material: 5.69 k (Shield 1955). Von Mises' surface lies between Tresca's with
    k = sigma_y/2 and with k = sigma_y/sqrt 3, and so does, by the limit theorems, its load.
    """
    soft = Elastoplastic(115e9, 0.30, 8500.0, 50e6)
    mesh = block_mesh(0.02, 0.02, 0.005, 2500)
    solver = Solver(mesh, soft, gap=punch_gap(mesh, 0.005, 1e-4), punch_mass=1e6, punch_velocity=1.0)
    pressures = [solver.advance(20)["contact_force"] / (math.pi * 0.005**2) / 50e6 for _ in range(200)]
    late = np.array(pressures[-60:])
    print(f"mean pressure {late.mean():.3f} sigma_y")
    assert 5.69 / 2 < late.mean() < 5.69 / math.sqrt(3)
    assert late[30:].mean() == pytest.approx(late[:30].mean(), rel=0.02)


def test_contact_keeps_momentum_and_never_pulls():
    case = ContinuumCase.from_dict({"material": "brass", "run": {"elements": 1500}})
    solver = BlockRun(case).solver
    solver._mobility[1, -1] = 1 / solver.operators.mass[-1]  # release the bottom
    for _ in range(150):
        instant = solver.advance(5)
        assert instant["contact_force"] >= 0
        gap = solver._gap + solver.motion[1, 0, : len(solver._gap)] - solver._tally[kernels.PUNCH_Z]
        assert gap.min() > -1e-15
    momentum = np.sum(solver.operators.mass * solver.motion[3]) + 0.1 * solver._tally[kernels.PUNCH_V]
    assert momentum == pytest.approx(0.1 * 10.0, rel=1e-9)
    assert instant["contact_force"] == 0.0  # the punch has left


@pytest.mark.parametrize("taper", [0.0, 1e-4])
def test_nodes_lie_where_the_contact_ends(taper):
    end = contact_end(0.005, taper, BRASS.yield_strength / BRASS.youngs_modulus)
    assert 0.005 - taper <= end <= 0.005
    mesh = block_mesh(0.05, 0.1, end, 4000)
    inside = np.searchsorted(mesh.r, end)
    assert (mesh.r[inside] + mesh.r[inside - 1]) / 2 == pytest.approx(end, rel=2e-3)
    assert mesh.n_elements == pytest.approx(4000, rel=0.02)
    for line, length in ((mesh.r, 0.05), (mesh.z, 0.1)):
        assert line[0] == 0 and line[-1] == length and np.all(np.diff(line) > 0)
    gap = punch_gap(mesh, 0.005, taper)
    assert len(gap) >= inside and gap[0] == 0 and np.all(np.diff(gap) >= 0) and gap[-1] <= taper


@pytest.mark.parametrize("edge_size", [2e-5, 1e-4, 3e-4])
def test_edge_size_is_met(edge_size):
    mesh = block_mesh(0.05, 0.1, 0.005, 16_000, edge_size=edge_size)
    assert np.diff(mesh.r).min() == pytest.approx(edge_size, rel=0.05)
    assert mesh.n_elements == pytest.approx(16_000, rel=0.02)


@pytest.mark.parametrize(("mass", "velocity"), [(0.01, 50.0), (0.1, 10.0), (0.2, 16.0)])
def test_energy_closes(mass, velocity):
    found = values_of({"punch": {"mass": mass, "velocity": velocity}}, elements=1500)
    assert found["energy_balance_error"] < 5e-3
    assert found["energy_hourglass_J"] < 0.02 * found["energy_input_J"]
    assert found["end_reason"] == "settled"
    assert 0 < found["dissipated_fraction"] < 1
    assert found["plastic_zone_volume_m3"] <= found["plastic_zone_volume_ever_m3"]


@pytest.mark.parametrize("taper", [0.0, 5e-5])
def test_materials_collapse(taper):
    """The thesis' materials (Fig. 5.10) at one normalised energy, time and mass (thesis 5.20 to 5.30).

    Displacements scale with sigma_y/E, the punch does not. With a sharp punch the dimensionless problem is the same, except
    for the quadratic bulk viscosity; a rounded edge requires a radius proportional to E/sigma_y, with the same flat part.
    """
    found = []
    for modulus, limit in ((115e9, 550e6), (230e9, 550e6), (115e9, 1100e6), (230e9, 1100e6), (460e9, 1100e6)):
        velocity = 10.0 * (limit / 550e6) * math.sqrt(115e9 / modulus)
        radius = taper * (1100e6 / limit) * (modulus / 115e9)  # of the edge
        material = {"youngs_modulus": modulus, "poisson_ratio": 0.3, "density": 8500.0, "yield_strength": limit}
        punch = {"velocity": velocity, "taper": radius, "diameter": 9.8e-3 + 2 * radius}
        found.append(values_of({"material": material, "punch": punch}, elements=4000))
    base = found[0]
    for values in found[1:]:
        fraction = pytest.approx(base["dissipated_fraction"], rel=0.01 if taper else 1e-4)
        assert values["dissipated_fraction"] == fraction
        assert values["plastic_zone_volume_m3"] == pytest.approx(base["plastic_zone_volume_m3"], rel=0.02)


def test_contact_spreads_less_over_the_edge_of_a_stiffer_block():
    """Effect of the edge as (taper sigma_y/E)^(2/3): materials of another sigma_y/E differ by it (see `contact_end`)."""
    ends = [contact_end(0.005, 1e-4, strain) - 0.0049 for strain in (1e-3, 8e-3)]
    assert ends[1] == pytest.approx(4 * ends[0])
    assert contact_end(0.005, 0.0, 1e-3) == 0.005
