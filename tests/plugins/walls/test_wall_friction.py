"""Friction of walls: oblique impact compared with closed forms, theory and the Hertz-Mindlin wall
of LAMMPS; energy balance; migration.

The benchmarks are those of Chung and Ooi, Granular Matter 13 (2011) 643: in tests 4 and 5 a sphere
hits a rigid plane, at a constant speed and varying angle, and at a constant normal speed and
varying spin. In test 6 two equal spheres with equal spins collide: the plane between them is the
wall here, and the results must agree.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import value

# test 4: aluminium oxide; tests 5 and 6: aluminium alloy
OXIDE = {"modulus": 380e9, "poisson": 0.23, "density": 4000.0, "radius": 0.0025, "friction": 0.092}
ALLOY = {"modulus": 70e9, "poisson": 0.33, "density": 2700.0, "radius": 0.1, "friction": 0.4}
BRASS = {"modulus": 115e9, "poisson": 0.30, "density": 8500.0, "radius": 0.005, "friction": 0.3}
ENERGY = "c_ke+c_spin+f_floor[4]+f_floor[5]+f_floor[8]+f_floor[9]"


def mass_of(body):
    return body["density"] * 4 / 3 * np.pi * body["radius"] ** 3


def contact_time(body, speed):
    """Hertz: 3.218 (m^2/(k^2 v))^(1/5) with F = k alpha^1.5."""
    stiffness = 4 / 3 * body["modulus"] / (1 - body["poisson"] ** 2) * np.sqrt(body["radius"])
    return 3.218 * (mass_of(body) ** 2 / (stiffness**2 * speed)) ** 0.2


def thrown(
    lmp,
    body,
    normal,
    across=0.0,
    spin=0.0,
    *,
    law="hertz",
    steps=1000,
    wall=None,
    run=True,
    extra="",
):
    """Rebound of a sphere from a plane above it: normal and tangential velocity, spin (rad/s);
    `steps` per contact time.
    """
    timestep = contact_time(body, normal) / steps
    strength = {"hertz": ""}.get(law, "550e6")
    wall = (
        wall
        or f"wall/gran/hysteretic zplane NULL {body['radius']:.17g} {law} {body['modulus']} {body['poisson']} {strength} friction {body['friction']}"
    )
    size = {name: body[name] for name in ("radius", "density")}
    extra = (
        f"set atom 1 omega 0 {spin:.17g} 0\nfix floor all {wall}\ncompute spin all erotate/sphere\nthermo_style custom step c_ke c_spin "
        f"{'f_floor f_floor[*]' if 'hysteretic' in wall else ''}\ntimestep {timestep:.17g}\n{extra}"
    )
    text = script_of([(0, 0, 0)], **size, velocities=[(across, 0, normal)], box=[-10 * body["radius"], 10 * body["radius"]] * 3, extra=extra)  # fmt: skip
    lmp.commands_string(text.replace("fix motion all nve\n", "fix motion all nve/sphere\n"))
    if run:
        lmp.command(f"run {int((2.2 if law == 'elastoplastic' else 1.2) * steps)}")
    return outcome(lmp)


def outcome(lmp, sphere=0):
    v = lmp.numpy.extract_atom("v")[sphere]
    omega = lmp.numpy.extract_atom("omega")[sphere]
    return np.array([-v[2], v[0], omega[1]])


def own_wall(body):
    """Wall of LAMMPS with the same constants: F = k_n a alpha, k_t = 8 G* a."""
    normal = 4 / 3 * body["modulus"] / (1 - body["poisson"] ** 2)
    tangential = 8 * body["modulus"] / (2 * (1 + body["poisson"]) * (2 - body["poisson"]))
    return (
        f"wall/gran granular hertz {normal:.17g} 0 tangential mindlin_rescale/force {tangential:.17g} 0 {body['friction']} "
        f"zplane NULL {body['radius']:.17g}"
    )


@pytest.mark.parametrize("angle", [5, 15, 25, 35, 45, 60, 75])
def test_oblique_impact_at_constant_speed(lammps, angle):
    """Test 4: 3.9 m/s. Beyond about 33 degrees sliding throughout: impulse mu times the normal one."""
    normal = 3.9 * np.cos(np.radians(angle))
    across = 3.9 * np.sin(np.radians(angle))
    lmp = lammps()
    found = thrown(lmp, OXIDE, normal, across)
    theirs = thrown(lammps(), OXIDE, normal, across, wall=own_wall(OXIDE))
    assert found[0] == pytest.approx(normal, rel=1e-5)
    # theirs has R for the slip and R - alpha/2 for the torque, a visible difference at this overlap
    # of 0.3 % of R
    assert found[1] == pytest.approx(theirs[1], rel=3e-3)
    assert found[2] == pytest.approx(theirs[2], rel=1e-2)
    slow, same = (
        thrown(lammps(), OXIDE, normal / 10, across / 10, wall=wall)
        for wall in (None, own_wall(OXIDE))
    )
    assert slow[1:] == pytest.approx(same[1:], rel=2e-3)
    assert value(lmp, ENERGY) == pytest.approx(0.5 * mass_of(OXIDE) * 3.9**2, rel=1e-6)
    if angle >= 35:
        change = 2 * OXIDE["friction"] * normal
        assert found[1] == pytest.approx(across - change, rel=1e-5)
        assert -found[2] == pytest.approx(2.5 * change / OXIDE["radius"], rel=2e-3)
        assert value(lmp, "f_floor[9]") == pytest.approx(
            0.5 * mass_of(OXIDE) * (3.9**2 - found @ (found * [1, 1, 0.4 * OXIDE["radius"] ** 2])),
            rel=1e-3,
        )


@pytest.mark.parametrize("spin", [0.5, 2.0, 5.0, 8.0, 15.0])
def test_spinning_impact_at_constant_normal_speed(lammps, spin):
    """Test 5: 0.2 m/s; from about 14 rad/s on sliding throughout."""
    found = thrown(lammps(), ALLOY, 0.2, spin=spin)
    theirs = thrown(lammps(), ALLOY, 0.2, spin=spin, wall=own_wall(ALLOY))
    assert found == pytest.approx(theirs, rel=5e-3)
    if spin >= 15:
        change = 2 * ALLOY["friction"] * 0.2
        assert found[1:] == pytest.approx(
            [-change, spin - 2.5 * change / ALLOY["radius"]], rel=1e-3
        )


@pytest.mark.parametrize("spin", [2.0, 15.0])
def test_two_spheres_of_equal_spin_are_a_sphere_and_a_wall(lammps, spin):
    """Test 6: the slip of two spheres is twice as large, with two compliances in series.

    Their lever arms are R - alpha_wall, that of a sphere at a wall R - alpha_wall/2, at an overlap
    of 0.05 % of R.
    """
    lmp = lammps()
    r = ALLOY["radius"]
    law = f"hertz {ALLOY['modulus']} {ALLOY['poisson']}"
    spheres = {
        "radius": r,
        "density": ALLOY["density"],
        "style": f"{law} friction {ALLOY['friction']}",
        "gap": 1e-2,
    }
    extra = f"comm_modify vel yes\nset group all omega 0 {spin} 0\ntimestep {contact_time(ALLOY, 0.2) / 1000:.17g}"
    speeds = [(0, 0, 0.2), (0, 0, -0.2)]
    text = script_of(
        [(0, 0, 0), (0, 0, 2 * r)],
        **spheres,
        velocities=speeds,
        box=[-10 * r, 10 * r] * 3,
        extra=extra,
    )
    lmp.commands_string(
        text.replace("fix motion all nve\n", "fix motion all nve/sphere\n") + "run 1200"
    )
    wall = thrown(lammps(), ALLOY, 0.2, spin=spin)
    assert outcome(lmp) == pytest.approx(wall, rel=2e-3)
    assert outcome(lmp, 1) * [-1, -1, 1] == pytest.approx(outcome(lmp), rel=1e-9)


def test_sticking_impact_follows_hertz_and_mindlin(lammps):
    """Sticking contact by scipy: m v' = F, F' = -k_t (v + w R), plus F a'/a while the circle
    shrinks.
    """
    body = BRASS | {"friction": 1000.0}
    normal = 0.5
    across = 0.02
    mass = mass_of(body)
    radius = body["radius"]
    nu = body["poisson"]
    stiffness = 4 / 3 * body["modulus"] / (1 - nu**2) * np.sqrt(radius)
    mindlin = 8 * body["modulus"] / (2 * (1 + nu) * (2 - nu))

    def rate(_, y):
        overlap, speed, force, surface = max(y[0], 1e-30), *y[1:]
        grip = force * 0.5 * speed / overlap if speed < 0 else 0.0
        return [
            speed,
            -stiffness * overlap**1.5 / mass,
            -mindlin * np.sqrt(radius * overlap) * surface + grip,
            3.5 * force / mass,
        ]

    def parted(_, y):
        return y[0] - 1e-4 * normal * contact_time(body, normal)

    parted.terminal = True
    parted.direction = -1
    done = solve_ivp(
        rate,
        (0, 1),
        [1e-16, normal, 0.0, across],
        rtol=1e-10,
        atol=1e-18,
        events=parted,
        max_step=1e-7,
    )
    surface = done.y[3, -1]
    lmp = lammps()
    found = thrown(lmp, body, normal, across, steps=4000)
    assert found[1] + found[2] * radius == pytest.approx(surface, abs=3e-3 * across)
    assert found[1] == pytest.approx(across + (surface - across) / 3.5, abs=1e-3 * across)
    assert value(lmp, "f_floor[8]") == 0.0


@pytest.mark.parametrize(
    ("across", "spin"), [(0.1, 0), (1.0, 0), (4.0, 0), (1.0, -900.0), (0.0, 300.0)]
)
def test_plastic_impact_balances_and_loss_never_falls(lammps, across, spin):
    lmp = lammps()
    thrown(lmp, BRASS, 2.0, across, spin, law="elastoplastic", steps=2000, run=False)
    lmp.command("run 0")
    given = value(lmp, "c_ke+c_spin")
    losses = [0.0]
    for _ in range(90):
        lmp.command("run 50 pre no post no")
        losses.append(value(lmp, "f_floor[9]"))
        assert value(lmp, ENERGY) == pytest.approx(given, rel=1e-6)
    assert np.diff(losses).min() >= 0 and losses[-1] > 0
    atom = lmp.numpy.extract_fix("floor", 1, 2)[0]
    assert atom[9] == pytest.approx(losses[-1], rel=1e-12)
    assert atom[8] == 0 and atom[10] == 0 and value(lmp, "f_floor[8]") == 0


def test_sliding_does_not_depend_on_the_normal_law(lammps):
    """The tangential impulse is mu times the normal one, mu (1 + e) m v_n, with the restitution of
    the yielding contact.
    """
    lmp = lammps()
    found = thrown(lmp, BRASS, 2.0, 4.0, law="elastoplastic", steps=2000)
    assert found[0] < 0.7 * 2.0
    assert found[1] == pytest.approx(4.0 - 0.3 * (2.0 + found[0]), rel=1e-6)
    assert -found[2] == pytest.approx(2.5 * (4.0 - found[1]) / BRASS["radius"], rel=5e-3)


def test_two_walls_have_a_spring_each(lammps):
    """Both planes exert friction on a sphere squeezed between them, and their torques cancel."""
    lmp = lammps()
    reach = BRASS["radius"] - 1e-6
    words = f"{-reach:.17g} {reach:.17g} hertz 115e9 0.3 friction 0.3"
    thrown(lmp, BRASS, 1e-9, 0.02, wall=f"wall/gran/hysteretic zplane {words}", run=False)
    lmp.commands_string("timestep 1e-8\nrun 0")
    given = value(lmp, ENERGY)
    lmp.command("run 300")
    force = value(lmp, "f_floor[1]")
    assert (
        force == pytest.approx(2 * lmp.numpy.extract_fix("floor", 1, 2)[0, 8], rel=1e-6)
        and force > 1
    )
    assert abs(outcome(lmp)[2]) < 1e-9 * force
    lmp.command("run 5000")
    assert value(lmp, ENERGY) == pytest.approx(given, rel=1e-6)
    assert value(lmp, "f_floor[8]") > 0


def test_the_error_of_the_balance_falls_with_the_timestep(lammps):
    errors = []
    for steps in (100, 400):
        lmp = lammps()
        thrown(lmp, BRASS, 2.0, 0.5, law="elastoplastic", steps=steps)
        errors.append(abs(value(lmp, ENERGY) / (0.5 * mass_of(BRASS) * 4.25) - 1))
    assert errors[1] < errors[0] / 8 or errors[0] < 1e-7


def test_a_sliding_sphere_reports_its_limit(lammps):
    lmp = lammps()
    thrown(lmp, BRASS, 2.0, 5.0, law="elastoplastic", run=False)
    lmp.command("run 400")
    force = value(lmp, "f_floor[3]")
    assert value(lmp, "f_floor[1]") == pytest.approx(
        0.3 * force, rel=1e-12
    )  # friction force on the wall
    assert value(lmp, "fx[1]") == pytest.approx(-0.3 * force, rel=1e-12)
    overlap, _, *_, tangential, _, _, _ = lmp.numpy.extract_fix("floor", 1, 2)[0]
    assert tangential == pytest.approx(0.3 * force, rel=1e-12)
    torque = lmp.numpy.extract_atom("torque")[0]
    assert torque == pytest.approx([0, -(BRASS["radius"] - overlap / 2) * tangential, 0], rel=1e-12)


def test_the_circle_of_a_dent_sets_the_stiffness(lammps):
    """Force of a small slip while the sphere unloads, compared with k_t from the contact circle of
    the law.
    """
    lmp = lammps()
    thrown(lmp, BRASS, 2.0, law="elastoplastic", run=False)
    lmp.command("run 900")
    assert value(lmp, "vz[1]") < 0
    lmp.command("set atom 1 vx 1e-4")
    lmp.command("run 1")
    overlap, _, peak, *_ = lmp.numpy.extract_fix("floor", 1, 2)[0]
    law = ContactLaw(
        youngs_modulus=(115e9, np.inf),
        poisson_ratio=(0.3, 0.0),
        yield_strength=(550e6, np.inf),
        radius=(0.005, np.inf),
    )
    residual = law.residual_overlap(peak)
    circle = law.contact_radius(peak) * np.sqrt((overlap - residual) / (peak - residual))
    shear = 115e9 / (2 * 1.3 * 1.7)
    assert value(lmp, "-fx[1]") == pytest.approx(
        8 * shear * circle * 1e-4 * value(lmp, "dt"), rel=1e-6
    )


def test_without_friction_nothing_turns(lammps):
    lmp = lammps()
    found = thrown(lmp, BRASS | {"friction": 0.0}, 2.0, 3.0, 100.0, law="elastoplastic")
    assert found[1:] == pytest.approx([3.0, 100.0], abs=0)
    assert value(lmp, "f_floor[8]") == value(lmp, "f_floor[9]") == 0


def test_a_minimisation_winds_no_spring_up(lammps):
    lmp = lammps()
    press = "fix press all addforce 5 0 50\nfix hold all setforce 0 NULL NULL\nmin_style fire\nmin_modify norm max"
    thrown(lmp, BRASS, 1e-9, run=False, extra=press)
    lmp.command("minimize 0 1e-6 5000 5000")
    assert value(lmp, "f_floor[3]") == pytest.approx(50, rel=1e-6)
    assert value(lmp, "f_floor[8]") == value(lmp, "f_floor[9]") == 0
