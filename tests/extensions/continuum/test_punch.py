"""Continuum solver compared with theory: waves, yield, patch tests, contact, energy; then its input
and output.
"""

from __future__ import annotations

import json
import math

import h5py
import numpy as np
import pytest
import tomli_w
from skfem import LinearForm

from granwave.extensions.continuum.material import RR, ZZ, Elastoplastic
from granwave.extensions.continuum.punch import ContinuumCase, kernels
from granwave.extensions.continuum.punch.mesh import Mesh, block_mesh, contact_end, punch_gap
from granwave.extensions.continuum.punch.run import BlockRun, run_continuum
from granwave.extensions.continuum.punch.solver import PunchSolver, library_basis
from granwave.extensions.continuum.runner import advance, digits_of
from granwave.lammps_inputs import InputError, RunError
from granwave.workflows.cli.main import main

BRASS = Elastoplastic(115e9, 0.30, 8500.0, 550e6)
ELASTIC = Elastoplastic(115e9, 0.30, 8500.0, math.inf)


def values_of(changes=None, **run):
    """Summary of a case from its tables, without writing files."""
    tables = {"name": "case", "material": "brass"} | (changes or {})
    run = BlockRun(ContinuumCase.from_dict(tables | {"run": tables.get("run", {}) | run}))
    run.integrate()
    return run.summarise(1.0)


@pytest.mark.parametrize(
    ("mass", "taper", "elements"),
    [
        (0.1, 1e-4, 4000),
        pytest.param(0.00445, 1e-4, 4000, marks=pytest.mark.validation),
        pytest.param(0.1, 5e-4, 8000, marks=pytest.mark.validation),
    ],
)
def test_velocity_of_first_yield(mass, taper, elements):
    """Nothing yields at 0.75 of the estimate, and something at 1.3 times it."""
    tables = {"punch": {"mass": mass, "taper": taper, "velocity": 1.0}}
    tables["run"] = {"elements": elements, "end_time": 1.1e-3 * math.sqrt(mass)}
    first = ContinuumCase.from_dict({"name": "case", "material": "brass"} | tables).yield_velocity
    volumes = []
    for factor in (0.75, 1.3):
        tables["punch"]["velocity"] = factor * first
        volumes.append(values_of(tables)["plastic_zone_volume_ever_m3"])
    assert volumes[0] == 0
    assert volumes[1] > 0


def graded(n_r=7, n_z=9):
    rng = np.random.default_rng(5)
    lines = [
        np.concatenate([[0.0], np.cumsum(rng.uniform(0.5, 1.5, n))]) * 1e-3 for n in (n_r, n_z)
    ]
    return Mesh(*lines)


def move(solver, radial, axial):
    """One step of a displacement field, from rest."""
    r, z = solver.mesh.nodes.T.reshape(2, *solver.motion.shape[1:])
    solver.motion[2] = radial(r, z) / solver.timestep
    solver.motion[3] = axial(r, z) / solver.timestep
    solver._mobility[:] = 0.0  # as prescribed
    solver.advance(1)


def column(material, velocity, *, sides, radius, length, n_r, n_z):
    """Cylinder whose whole top is driven at constant velocity."""
    mesh = Mesh(np.linspace(0, radius, n_r + 1), np.linspace(0, length, n_z + 1))
    return PunchSolver(
        mesh, material, gap=np.zeros(n_r + 1), punch_mass=1e9, punch_velocity=velocity, sides=sides
    )


def go(solver, end):
    while solver.time < end:
        solver.advance(solver.every(2e-7))


def test_nodal_forces_are_those_that_scikit_fem_assembles():
    mesh = graded()
    solver = PunchSolver(mesh, ELASTIC, bottom="free")
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
    assert np.allclose(
        np.einsum("kl,leq->keq", BRASS.stiffness, strain), [rr, zz, tt, rz], rtol=1e-9, atol=1e-2
    )
    f_r = LinearForm(
        lambda v, x: 2 * np.pi * (x.x[0] * (v.grad[0] * rr + v.grad[1] * rz) + v * tt)
    ).assemble(basis)
    f_z = LinearForm(lambda v, x: 2 * np.pi * x.x[0] * (v.grad[0] * rz + v.grad[1] * zz)).assemble(
        basis
    )
    for found, expected in zip(solver.motion[4:], (f_r, f_z), strict=True):
        assert np.allclose(found.ravel(), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


def test_mass_is_that_of_the_block():
    solver = PunchSolver(block_mesh(0.05, 0.1, 0.005, 2000), BRASS)
    assert solver.operators.mass.sum() == pytest.approx(8500 * math.pi * 0.05**2 * 0.1, rel=1e-12)
    assert solver.operators.volume.sum() == pytest.approx(math.pi * 0.05**2 * 0.1, rel=1e-12)


def test_rigid_motion_gives_no_stress():
    solver = PunchSolver(graded(), BRASS, bottom="free")
    solver.set_velocity(np.zeros(solver.motion.shape[1:]), np.full(solver.motion.shape[1:], 7.0))
    for _ in range(20):
        instant = solver.advance(5)
    assert np.abs(solver.state[:, :, :4]).max() < 1e-3  # Pa
    assert instant["kinetic"] == pytest.approx(0.5 * solver.operators.mass.sum() * 49, rel=1e-12)
    assert solver.motion[1] == pytest.approx(7.0 * solver.time, rel=1e-12)


@pytest.mark.parametrize(("radial", "axial"), [(1e-4, 0.0), (0.0, 1e-4), (2e-4, -1e-4)])
def test_patch(radial, axial):
    """A homogeneous strain on a graded mesh that includes the axis gives uniform stress and no
    force on any inner node.
    """
    solver = PunchSolver(graded(), ELASTIC, bottom="free")
    solver._constants = (*solver._constants[:3], 0.0, 0.0)
    move(solver, lambda r, z: radial * r, lambda r, z: axial * z)
    expected = ELASTIC.stiffness @ [radial, axial, radial, 0.0]
    assert solver.state[:, :, :4] == pytest.approx(
        np.broadcast_to(expected, (9, 7, 4)), rel=1e-9, abs=1e-2
    )
    scale = np.abs(solver.motion[4:]).max()
    assert (
        np.abs(solver.motion[4, 1:-1, :-1]).max() < 1e-9 * scale
    )  # nodes on the axis are inner nodes
    assert np.abs(solver.motion[5, 1:-1]).max() < 1e-9 * scale


@pytest.mark.parametrize("elements", [400, 4000])
def test_timestep_is_just_below_the_limit(elements):
    """Random motion of an elastic block conserves energy at the chosen timestep, and is unstable at
    1.4 times that.
    """
    for factor, stable in ((1.0, True), (1.4, False)):
        solver = PunchSolver(block_mesh(0.05, 0.1, 0.005, elements), ELASTIC)
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
    """Uniaxial strain beyond yield: precursor of sigma_y (1-nu)/(1-2 nu) at c_L, plastic wave at
    sqrt(K/rho).
    """
    velocity = 60.0
    length = 0.05
    solver = column(BRASS, velocity, sides="roller", radius=5e-4, length=length, n_r=2, n_z=800)
    speed = BRASS.longitudinal_speed
    plastic_speed = math.sqrt(115e9 / (3 * 0.4) / 8500)
    limit = 550e6 * 0.7 / 0.4
    step = limit / (8500 * speed)  # particle velocity behind the precursor
    top = limit + 8500 * plastic_speed * (velocity - step)
    go(solver, 0.9 * length / speed)
    depth = solver.mesh.centres[1]
    stress = -solver.state[:, 1, ZZ]
    between = (depth > 1.05 * plastic_speed * solver.time) & (depth < 0.96 * speed * solver.time)
    assert stress[between].mean() == pytest.approx(limit, rel=0.01)
    behind = (depth > 0.1 * length) & (depth < 0.9 * plastic_speed * solver.time)
    assert stress[behind] == pytest.approx(top, rel=0.01)
    assert np.interp(-(limit + top) / 2, -stress, depth) == pytest.approx(
        plastic_speed * solver.time, rel=0.01
    )
    assert np.interp(-limit / 2, -stress, depth) == pytest.approx(speed * solver.time, rel=0.01)
    assert solver.von_mises.max() <= 550e6 * (1 + 1e-12)


def test_plastic_flow_does_not_lock():
    """A punch pressed in at constant velocity reaches the limit load; with a locking mesh the load
    continues to grow.

    Smooth circular punch on Tresca's material: 5.69 k (Shield 1955). Von Mises' surface lies
    between Tresca's with k = sigma_y/2 and with k = sigma_y/sqrt 3, and so does, by the limit
    theorems, its load.
    """
    soft = Elastoplastic(115e9, 0.30, 8500.0, 50e6)
    mesh = block_mesh(0.02, 0.02, 0.005, 2500)
    solver = PunchSolver(
        mesh, soft, gap=punch_gap(mesh, 0.005, 1e-4), punch_mass=1e6, punch_velocity=1.0
    )
    pressures = [
        solver.advance(20)["contact_force"] / (math.pi * 0.005**2) / 50e6 for _ in range(200)
    ]
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
    momentum = (
        np.sum(solver.operators.mass * solver.motion[3]) + 0.1 * solver._tally[kernels.PUNCH_V]
    )
    assert momentum == pytest.approx(0.1 * 10.0, rel=1e-9)
    assert instant["contact_force"] == 0.0  # the punch has left


@pytest.mark.parametrize("taper", [0.0, 1e-4])
def test_nodes_lie_where_the_contact_ends(taper):
    """The contact spreads over the edge as (taper sigma_y/E)^(2/3)."""
    end = contact_end(0.005, taper, BRASS.yield_strength / BRASS.youngs_modulus)
    assert 0.005 - taper <= end <= 0.005
    ends = [contact_end(0.005, taper, strain) - 0.005 + taper for strain in (1e-3, 8e-3)]
    assert ends[1] == pytest.approx(4 * ends[0])
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
    """The thesis' materials (Fig. 5.10) at one normalised energy, time and mass (thesis 5.20 to
    5.30).

    Displacements scale with sigma_y/E, the punch does not. With a sharp punch the dimensionless
    problem is the same, except for the quadratic bulk viscosity; a rounded edge requires a radius
    proportional to E/sigma_y, with the same flat part.
    """
    found = []
    for modulus, limit in (
        (115e9, 550e6),
        (230e9, 550e6),
        (115e9, 1100e6),
        (230e9, 1100e6),
        (460e9, 1100e6),
    ):
        velocity = 10.0 * (limit / 550e6) * math.sqrt(115e9 / modulus)
        radius = taper * (1100e6 / limit) * (modulus / 115e9)  # of the edge
        material = {
            "youngs_modulus": modulus,
            "poisson_ratio": 0.3,
            "density": 8500.0,
            "yield_strength": limit,
        }
        punch = {"velocity": velocity, "taper": radius, "diameter": 9.8e-3 + 2 * radius}
        found.append(values_of({"material": material, "punch": punch}, elements=4000))
    base = found[0]
    for values in found[1:]:
        fraction = pytest.approx(base["dissipated_fraction"], rel=0.01 if taper else 1e-4)
        assert values["dissipated_fraction"] == fraction
        assert values["plastic_zone_volume_m3"] == pytest.approx(
            base["plastic_zone_volume_m3"], rel=0.02
        )


SMALL = {"name": "small", "material": "brass", "run": {"elements": 1500}}


def test_defaults_are_those_of_the_interface():
    case = ContinuumCase.from_dict({"material": "brass"}, "half-space.toml")
    assert (case.name, case.block.diameter, case.block.height) == ("half-space", 0.1, 0.1)
    assert (case.punch.diameter, case.punch.mass, case.punch.velocity, case.punch.taper) == (
        0.01,
        0.1,
        10.0,
        1e-4,
    )
    assert (case.run.end_time, case.run.elements) == ("auto", 62_500)
    assert case.energy_unit == pytest.approx(2.630, abs=5e-4)
    assert ContinuumCase.from_dict(case.to_dict()) == case


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"punch": {"width": 1}, "run": {"elements": 5}, "material": {"preset": "brass", "yield_strength": -1}},
         ("punch.width: unknown", "material.yield_strength", "run.elements", "run.end_time")),
        ({"punch": {"diameter": 0.2}}, ("punch.diameter: found 0.2 m, expected less than block.diameter",)),
        ({"punch": {"taper": 0.006}}, ("punch.taper",)),
        ({"run": {"edge_size": 0.006}}, ("run.edge_size",)),
        ({"run": {"end_time": 1e-5, "timestep": 1e-4}}, ("run.timestep",)),
        ({"material": {"preset": "brass", "hardening": 0.1, "rate_sensitivity": 0.1}},
         ("material.hardening", "material.rate_sensitivity")),
    ],
)  # fmt: skip
def test_every_fault_is_named(tmp_path, tables, words):
    path = tmp_path / "bad.toml"
    path.write_text(tomli_w.dumps({"material": "brass"} | tables))
    with pytest.raises(InputError) as caught:
        ContinuumCase.load(path, ["run.end_time=soon"] if len(words) > 3 else [])
    assert len(caught.value.errors) == len(words)
    assert all(any(word in line for line in caught.value.errors) for word in words), (
        caught.value.errors
    )


def test_mesh_beyond_memory_is_refused(tmp_path):
    case = ContinuumCase.from_dict({"material": "brass", "run": {"elements": 10**9}})
    with pytest.raises(InputError, match=r"run\.elements: 1000000000 elements require"):
        run_continuum(case, tmp_path / "r")
    assert not (tmp_path / "r").exists()


def test_run_leaves_its_results(tmp_path):
    case = ContinuumCase.from_dict(SMALL)
    summary = run_continuum(case, tmp_path / "r")
    assert json.loads((tmp_path / "r" / "summary.json").read_text()) == summary
    assert summary["kind"] == "continuum" and summary["energy_input_J"] == 5.0
    parts = ("kinetic", "elastic", "dissipated", "punch", "hourglass", "viscous", "contact")
    assert sum(summary[f"energy_{name}_J"] for name in parts) == pytest.approx(5.0, rel=5e-3)
    assert summary["dissipated_fraction"] == pytest.approx(summary["energy_dissipated_J"] / 5.0)
    with h5py.File(tmp_path / "r" / "result.h5") as file:
        sets = []
        file.visititems(
            lambda name, item: sets.append((name, item)) if isinstance(item, h5py.Dataset) else None
        )
        assert all("unit" in item.attrs for _, item in sets)
        assert {"nodes", "elements", "fields/von_mises", "energy/plastic"} <= {
            name for name, _ in sets
        }
        assert np.diff(file["energy/time"][:]).max() <= 2e-7
        assert file["energy/time"][-1] == pytest.approx(file["fields/time"][-1])
        assert file["fields/von_mises"].shape[1] == len(file["elements"]) == summary["n_elements"]
        energy = np.sum(file["fields/plastic_energy"][:] * file["element_volume"][:])
        assert energy == pytest.approx(summary["energy_dissipated_J"], rel=1e-9)
        assert "brass" in file.attrs["case"] and "numba" in json.loads(file.attrs["versions"])
    assert summary["zone_volume_99_m3"] < summary["plastic_zone_volume_ever_m3"]
    assert (summary["zone_cut"], summary["wave_returned"]) == ([], ["sides"])
    for name in (
        "energies",
        "plastic_zone",
        "plastic_zone_volume",
        "plastic_zone_size",
        "von_mises",
    ):
        for suffix in ("png", "pdf", "csv"):
            assert (tmp_path / "r" / "figures" / f"{name}.{suffix}").stat().st_size > 0
    # and further commands in that directory
    with pytest.raises(InputError, match="already holds results"):
        run_continuum(case, tmp_path / "r")
    assert run_continuum(case, tmp_path / "r", resume=True) == summary
    other = ContinuumCase.from_dict(SMALL | {"punch": {"velocity": 4.0}})
    with pytest.raises(InputError, match=r"another case \(different: punch\)"):
        run_continuum(other, tmp_path / "r", resume=True)
    replaced = run_continuum(other, tmp_path / "r", force=True, figures=False)
    assert replaced["energy_input_J"] == pytest.approx(0.8)
    assert not (tmp_path / "r" / "figures").exists()


def test_given_end_time_is_met():
    found = values_of(elements=500, end_time=1.03e-5)
    assert found["end_reason"] == "end_time"
    assert found["end_time_s"] == pytest.approx(1.03e-5, abs=found["timestep_s"])


def test_unstable_run_stops_and_keeps_what_it_has(tmp_path):
    case = ContinuumCase.from_dict(
        {"name": "u", "material": "brass", "run": {"elements": 500, "timestep": 5e-7}}
    )
    with pytest.raises(RunError, match="energy balance error too large"):
        run_continuum(case, tmp_path, figures=False)
    assert json.loads((tmp_path / "summary.json").read_text())["end_reason"] == "refused"
    assert (tmp_path / "result.h5").exists()


def test_large_strains_are_named(tmp_path, caplog):
    case = ContinuumCase.from_dict(
        {"material": "brass", "run": {"elements": 500}, "punch": {"velocity": 100.0}}
    )
    summary = run_continuum(case, tmp_path, figures=False)
    assert (
        "strains are not small" in caplog.text and f"{summary['largest_strain']:.2f}" in caplog.text
    )


@pytest.mark.validation
@pytest.mark.parametrize(
    "punch", [{"velocity": 6.0}, {"velocity": 16.0}, {"mass": 0.01, "velocity": 40.0}]
)
def test_results_converge_with_the_mesh(punch):
    found = [values_of({"punch": punch}, elements=elements) for elements in (4000, 16_000, 62_500)]
    fractions, volumes = (
        [values[name] for values in found]
        for name in ("dissipated_fraction", "plastic_zone_volume_m3")
    )
    print(f"\n{punch}: fraction {fractions}, volume {volumes}")
    assert fractions[1] == pytest.approx(fractions[2], rel=0.02)
    assert volumes[1] == pytest.approx(volumes[2], rel=0.07)  # 6 m/s: 5.5 %, the others less
    assert fractions[0] == pytest.approx(fractions[2], rel=0.03)
    assert volumes[0] == pytest.approx(volumes[2], rel=0.20)  # 6 m/s: 17 %
    assert abs(volumes[1] - volumes[2]) < abs(volumes[0] - volumes[2])
    half = values_of({"punch": punch}, elements=16_000, timestep=found[1]["timestep_s"] / 2)
    assert half["dissipated_fraction"] == pytest.approx(fractions[1], rel=2e-3)
    assert half["plastic_zone_volume_m3"] == pytest.approx(volumes[1], rel=0.02)


@pytest.mark.validation
def test_taper_does_not_matter():
    """Two elements across each taper, well above the onset of yield."""
    tapers = (5e-5, 1e-4, 2e-4)
    found = [
        values_of(
            {"punch": {"velocity": 16.0, "taper": taper}}, elements=16_000, edge_size=taper / 2
        )
        for taper in tapers
    ]
    fractions = [values["dissipated_fraction"] for values in found]
    volumes = [values["plastic_zone_volume_m3"] for values in found]
    print(f"\ntapers: fraction {fractions}, volume {volumes}")
    assert np.ptp(fractions) < 0.03 * np.mean(fractions)
    assert np.ptp(volumes) < 0.05 * np.mean(volumes)


def test_command_line(granwave, tmp_path, monkeypatch, capfd):
    words = ["continuum", "half-space", "-o", "out", "--set", "run.elements=500"]
    done = granwave(*words, cwd=tmp_path)
    assert done.returncode == 0 and "plastically" in done.stdout, done.stderr
    monkeypatch.chdir(tmp_path)
    wrong = ["check", "half-space", "--set", "punch.velocity=-1"]
    for refused in (words, ["continuum", "fcc-small"], ["run", "half-space"], wrong):
        assert main(refused) == 2
    assert main([*words, "--resume"]) == main(["report", "out", "-o", "page.md"]) == 0
    capfd.readouterr()
    assert (
        main(["check", "half-space", "--set", "run.elements=500"]) == 0
        and "elements" in capfd.readouterr().out
    )
    assert (
        sorted(path.name for path in tmp_path.iterdir()) == ["out", "page.md"]
        or (tmp_path / "page_files").is_dir()
    )


@pytest.mark.parametrize("total", [6.5, 0.8, 0.0123, 2e-5, None])
def test_a_bar_ends_at_its_total(total):
    """The bar works for any total, also if the last position is beyond it, and without a total."""
    digits = digits_of(total)
    shown = 0.0
    end = None if total is None else round(total, digits)
    for place in (total or 1.0) * np.array([0.1, 0.5, 0.4, 1.0, 1.4]):
        step = advance(shown, place, end, digits)
        assert step >= 0
        shown += step
    assert shown == pytest.approx(1.4 if total is None else total, rel=0.01) and (
        end is None or shown <= end * (1 + 1e-9)
    )
