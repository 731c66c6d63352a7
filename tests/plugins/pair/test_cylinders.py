"""Cylinders: laws compared with closed forms and published values, motion compared with independent
equations, friction, ranks, restart.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from granwave._contact_laws import CylinderPair, LineContact
from tests.conftest import refuses, script_of
from tests.helpers.bodies.two_spheres import value
from tests.plugins.walls.test_tubes_and_lines import radius_by_scipy

X = (1.0, 0.0, 0.0)


def as_sphere(density: float, radius: float, length: float) -> float:
    """Density of a sphere with the mass of a cylinder."""
    return density * 0.75 * length / radius


@pytest.mark.parametrize("degrees", [90, 60, 10])
def test_crossed_cylinders(degrees):
    """Equal cylinders at 90 degrees are equivalent to a sphere of their radius on a plane; others
    follow from both curvatures.
    """
    t = math.radians(degrees)
    pair = CylinderPair(
        length=(0.01, 0.02), first_axis=X, second_axis=(math.cos(t), math.sin(t), 0.0)
    )
    one = 0.002
    other = 0.003
    assert (
        not pair.parallel and pair.effective_radius(one, one) == pytest.approx(one, rel=1e-15)
    ) or degrees != 90
    difference = math.sqrt(
        one**-2 + other**-2 + 2 / (one * other) * math.cos(2 * t)
    )  # Johnson, 4.2
    low = (1 / one + 1 / other - difference) / 2
    high = (1 / one + 1 / other + difference) / 2
    assert pair.effective_radius(one, other) == pytest.approx(
        radius_by_scipy(low, high / low), rel=1e-9
    )


def johnson(force: float, moduli: tuple[float, ...], radii: tuple[float, ...]) -> float:
    """Overlap at a force per length, N/m: sum over the bodies; ``moduli``: E/(1 - nu^2)."""
    modulus = 1 / sum(1 / e for e in moduli)
    radius = 1 / sum(1 / r for r in radii)
    half_width = math.sqrt(4 * force * radius / (math.pi * modulus))
    return sum(force / (math.pi * e) * (2 * math.log(4 * r / half_width) - 1)
               for e, r in zip(moduli, radii, strict=True) if math.isfinite(e))  # fmt: skip


@pytest.mark.parametrize("radii", [(0.003, 0.003), (0.003, 0.007), (0.003, np.inf)])
def test_plane_strain(radii):
    rigid = math.isinf(radii[1])
    second = (np.inf, 0.0) if rigid else (210e9, 0.3)
    line = LineContact.plane_strain(youngs_modulus=(70e9, second[0]), poisson_ratio=(0.33, second[1]), radius=radii,
                                    length=0.02)  # fmt: skip
    moduli = 70e9 / (1 - 0.33**2), second[0] / (1 - second[1] ** 2)
    for overlap in (1e-12, 1e-8, 1e-6, 3e-5):
        force = float(line.force(overlap))
        assert johnson(force / 0.02, moduli, radii) == pytest.approx(overlap, rel=1e-12)
        work = quad(lambda a: float(line.force(a)), 0, overlap, epsabs=0, epsrel=1e-12)[0]
        assert line.energy(overlap) == pytest.approx(work, rel=1e-10)
        h = 1e-4 * overlap
        slope = (line.force(overlap + h) - line.force(overlap - h)) / (2 * h)
        assert line.stiffness(overlap) == pytest.approx(slope, rel=1e-7)


def test_parallel_cylinders_collide_as_their_equations_say(lammps):
    """Mixed radii, materials and lengths, along a line that is oblique to all axes of the box."""
    radii = [0.004, 0.007]
    densities = (2700.0, 7800.0)
    lengths = (0.01, 0.03)
    axis = np.array([0.0, 3.0, 4.0]) / 5
    n = np.array([0.6, 0.64, -0.48])  # normal to the axis
    places = [np.zeros(3), -0.0110001 * n + 0.002 * axis]
    mass = [
        rho * math.pi * r**2 * one for rho, r, one in zip(densities, radii, lengths, strict=True)
    ]
    moduli = 70e9 / (1 - 0.33**2), 210e9 / (1 - 0.3**2)

    def rate(_, state):
        overlap, speed = state
        if overlap <= 0:
            return [speed, 0.0]
        force = brentq(
            lambda f: johnson(f, moduli, tuple(radii)) - overlap, 1e-12, 1e9, xtol=1e-12, rtol=1e-13
        )
        return [speed, -0.01 * force * (1 / mass[0] + 1 / mass[1])]

    end = solve_ivp(rate, (0, 3e-5), [-1e-7, 1.5], rtol=1e-10, atol=1e-18, max_step=2e-7).y[:, -1]
    lmp = lammps()
    fix = "fix round all gran/cylinder 1 0.01 0 0.6 0.8 2 0.03 0 3 4 line plane-strain"
    lmp.commands_string(
        script_of(places, radius=radii, types=[1, 2], velocities=[tuple(-0.5 * n), tuple(1.0 * n)],
                  coefficients=["pair_coeff 1 1 hertz 70e9 0.33", "pair_coeff 2 2 hertz 210e9 0.3"],
                  extra=fix + "\n" + "\n".join(
                      f"set atom {k} density {as_sphere(rho, r, one):.17g}"
                      for k, (rho, r, one) in enumerate(zip(densities, radii, lengths, strict=True), 1)))
        + "timestep 5e-9\nrun 600\n"
    )  # fmt: skip
    stored = value(lmp, "pe")
    assert stored > 0 and value(lmp, "c_ke+pe") == pytest.approx(
        sum(m * v * v / 2 for m, v in zip(mass, (0.5, 1), strict=True)), rel=1e-6
    )
    lmp.command("run 5400")
    x = lmp.numpy.extract_atom("x")
    v = lmp.numpy.extract_atom("v")
    assert 0.011 - (x[0] - x[1]) @ n == pytest.approx(end[0], abs=2e-10)
    assert -(v[0] - v[1]) @ n == pytest.approx(end[1], rel=1e-5)
    assert np.abs(np.cross(v[0], n)).max() < 1e-12


def between_cylinders(extra: str = "", friction: str = "") -> str:
    """A steel sphere that hits two crossed cylinders of brass."""
    coefficients = [f"pair_coeff 1 1 hertz 210e9 0.3{friction}", f"pair_coeff 2 2 hertz 115e9 0.3{friction}",
                    f"pair_coeff 3 3 hertz 115e9 0.3{friction}"]  # fmt: skip
    return script_of(
        [(0, 0, 0), (0.0045, 0.002, 0.006), (-0.006, 0.001, 0.0061)], radius=[0.005, 0.0024, 0.0035], types=[1, 2, 3],
        velocities=[(0.3, 0.2, 5.0), (0, 0, 0), (0, 0, 0)], coefficients=coefficients,
        extra="fix round all gran/cylinder 2 0.02 0 1 0 3 0.03 0.3 1 0\n"
        f"set type 2 density {as_sphere(8500, 0.0024, 0.02):.17g}\nset type 3 density {as_sphere(8500, 0.0035, 0.03):.17g}\n"
        f"{extra}\ntimestep 1e-8",
    )  # fmt: skip


def test_sphere_between_cylinders(lammps):
    radii = (0.005, 0.0024, 0.0035)
    mass = [
        8500 * 4 / 3 * math.pi * 0.005**3,
        8500 * math.pi * 0.0024**2 * 0.02,
        8500 * math.pi * 0.0035**2 * 0.03,
    ]
    axes = {1: np.array([0.0, 1, 0]), 2: np.array([0.3, 1, 0]) / math.sqrt(1.09)}
    modulus = {k: 1 / ((1 - 0.09) / 210e9 + (1 - 0.09) / 115e9) for k in axes}
    stiffness = {
        k: 4
        / 3
        * modulus[k]
        * math.sqrt(radius_by_scipy(1 / radii[0], (1 / radii[0] + 1 / radii[k]) * radii[0]))
        for k in axes
    }

    def rate(_, state):
        x = state[:9].reshape(3, 3)
        v = state[9:].reshape(3, 3)
        force = np.zeros((3, 3))
        for k, axis in axes.items():
            across = x[0] - x[k] - (x[0] - x[k]) @ axis * axis
            overlap = radii[0] + radii[k] - np.linalg.norm(across)
            push = stiffness[k] * max(overlap, 0.0) ** 1.5 * across / np.linalg.norm(across)
            force[0] += push
            force[k] -= push
        return np.concatenate([v.ravel(), (force / np.array(mass)[:, None]).ravel()])

    lmp = lammps(between_cylinders() + "run 0\n")
    start = np.concatenate([lmp.numpy.extract_atom(name).ravel() for name in "xv"])
    lmp.command("run 20000")
    found = np.concatenate([lmp.numpy.extract_atom(name).ravel() for name in "xv"])
    wanted = solve_ivp(rate, (0, 2e-4), start, rtol=1e-11, atol=1e-15, max_step=1e-6).y[:, -1]
    assert np.abs(found[9:] - wanted[9:]).max() < 2e-5 < 0.1 < np.abs(wanted[12:]).max()
    assert np.abs(found[:9] - wanted[:9]).max() < 1e-9


@pytest.mark.validation
def test_ranks_and_restart_alike(log_of, tmp_path):
    """With friction, bitwise identical: one and two processors, and a run in two parts."""
    comm = "comm_modify vel yes\n"
    motion = "unfix motion\nfix motion all nve/sphere\n"
    text = between_cylinders(friction=" friction 0.3") + comm + motion
    dump = "write_dump all custom {} id x y z vx vy vz omegax omegay omegaz modify sort id format float %.17g\n"
    texts = {
        "one": text + "run 16000\n",
        "cut": text
        + f"run 8000\nwrite_restart {tmp_path}/half\nclear\nnewton off\natom_modify map yes\n"
        f"read_restart {tmp_path}/half\nfix round all gran/cylinder 2 0.02 0 1 0 3 0.03 0.3 1 0\n{comm}"
        "fix motion all nve/sphere\ntimestep 1e-8\nneighbor 1e-3 bin\nneigh_modify delay 0 every 1 check yes\nrun 8000\n",
    }
    for name, ranks in (("one", 1), ("one", 2), ("cut", 1)):
        log_of(texts[name] + dump.format(tmp_path / f"{name}{ranks}"), ranks)
    one, two, cut = ((tmp_path / name).read_text() for name in ("one1", "one2", "cut1"))
    assert one == two == cut
    spin = np.loadtxt((tmp_path / "one1").read_text().splitlines()[9:])[:, 7:]
    assert (
        np.abs(spin).max() > 1
        and spin[1, 0] == spin[1, 2] == 0
        and spin[2, 0] == pytest.approx(0.3 * spin[2, 1])
    )


@pytest.mark.parametrize("line", ["half-space", "plane-strain"])
def test_cylinder_on_a_plane(lammps, line):
    """The rebound of a cylinder agrees with the law, and a sliding cylinder finally rolls at 2/3 of
    its speed (inertia m R^2/2).
    """
    radius = 0.003
    length = 0.01
    density = 8500.0
    lmp = lammps()
    law = (LineContact.plane_strain(youngs_modulus=(115e9, np.inf), poisson_ratio=(0.3, 0.0), radius=(radius, np.inf),
                                    length=length)
           if line == "plane-strain"
           else LineContact(youngs_modulus=(115e9, np.inf), poisson_ratio=(0.3, 0.0), diameter=2 * radius, length=length))  # fmt: skip
    lmp.commands_string(
        script_of([(0, 0, radius - 1e-6)], radius=radius, density=as_sphere(density, radius, length), velocities=[(1.0, 0, 0)],
                  box=[-0.1, 0.1] * 3,
                  extra=f"fix floor all wall/gran/hysteretic zplane 0 NULL hertz 115e9 0.3 friction 0.2 line {line}\n"
                  f"fix round all gran/cylinder 1 {length} 0 -1 0\nfix weight all addforce 0 0 {-float(law.force(1e-6)):.17g}\n"
                  "unfix motion\nfix motion all nve/sphere\ncompute spin all erotate/sphere\n"
                  "thermo_style custom step c_ke c_spin f_round f_floor f_floor[*]\ntimestep 2e-8")
        + "run 0\n"
    )  # fmt: skip
    assert value(lmp, "f_floor[3]") == pytest.approx(-float(law.force(1e-6)), rel=1e-8)
    assert value(lmp, "f_floor") == pytest.approx(float(law.energy(1e-6)), rel=1e-8)
    energy = "c_ke+c_spin+f_round+f_floor[8]+f_floor[9]"
    before = value(lmp, energy)
    lmp.command("run 20000")
    turning = lmp.numpy.extract_atom("omega")[0, 1]
    assert value(lmp, "vx[1]") + 0.5 * radius * turning == pytest.approx(
        1.0, rel=5e-4
    )  # about the line of contact
    assert value(lmp, "vx[1]") == pytest.approx(2 / 3, rel=0.08)  # it swings on its spring
    assert value(lmp, energy) == pytest.approx(before, rel=2e-5)


def test_the_end_of_a_cylinder(lammps):
    """A sphere that slides over the end stops the run; a sphere that passes the end has no
    contact.
    """
    lmp = lammps()
    scripts = [
        script_of([(0, y, 0.0), (0, 0, 0.0079999)], radius=[0.005, 0.003], types=[1, 2], velocities=[(0, 50.0, 0), (0, 0, 0)],
                  style="hertz 1e9 0.3", extra="fix round all gran/cylinder 2 0.01 0 1 0")
        for y in (0.0049, 0.0058)
    ]  # fmt: skip
    lmp.commands_string(scripts[0])
    refuses(lmp, "run 1000", "beyond the end of a cylinder")
    other = lammps(scripts[1] + "run 100\n")
    assert value(other, "pe") == 0 and value(other, "vz[2]") == 0
