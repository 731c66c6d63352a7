"""Friction and rotation of pair style gran/hysteretic: closed forms of oblique impact, LAMMPS's own
styles, energy.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.helpers.bodies.rubbing import (
    BRASS,
    HERTZ,
    LAMMPS_OWN,
    MU,
    NU,
    RATIO,
    TOTAL,
    E,
    R,
    balance,
    oblique,
    rubbing,
    state,
)
from tests.helpers.bodies.two_spheres import value

# ---------------------------------------------------------------------- closed forms


@pytest.mark.parametrize("law", [HERTZ, BRASS])
@pytest.mark.parametrize("radii", [(R, R), (R, 2 * R)])
def test_gross_sliding(lammps, law, radii):
    """Tangential impulse of sliding throughout: mu (1 + e) m v_n, and equal spins. The contact
    rotates slightly, so the tangential impulse is determined from the spins and the normal one from
    the remaining momentum.
    """
    lmp = oblique(lammps, 4.0, law=f"{law} friction 0.1", radii=radii, steps=25000)
    after = state(lmp, "v", "omega")
    mass = state(lmp, "rmass")["rmass"]
    inertia = 0.4 * mass * np.square(radii)
    impulse = inertia * -after["omega"][:, 1] / radii
    assert impulse[0] == pytest.approx(
        impulse[1], rel=5e-3
    )  # the lever arms are shorter by half the overlap
    tangential = impulse.mean()
    total = mass[1] * np.linalg.norm(after["v"][1])
    normal = np.sqrt(total**2 - tangential**2)
    assert tangential == pytest.approx(0.1 * normal, rel=5e-3)
    restitution = normal * mass.sum() / mass.prod() - 1.0
    if law == HERTZ:
        assert restitution == pytest.approx(
            1.0, abs=0.07
        )  # 0.937 also without friction: the spheres pass each other
    else:
        assert restitution < 0.95
    assert abs(balance(lmp)) < 1e-6


@pytest.mark.parametrize("angle", [0.5, 1.0, 2.0, 3.0, 5.0, 8.0])
def test_tangential_restitution_against_mindlin_by_quadrature(lammps, angle):
    """Rebound of the surfaces against the angle of incidence, psi = 2 (1 - nu)/(mu (2 - nu))
    v_t/v_n, as in Maw, Barber and Fawcett (1976): sliding throughout above 4 chi - 1 = 4.76,
    reversal below; compared with the same spring in two degrees of freedom, integrated without
    LAMMPS.
    """
    chi = 3.5 * RATIO / 2
    tangential = angle * MU / RATIO
    lmp = oblique(lammps, 0.1 * tangential, 0.1, steps=16000)
    after = state(lmp, "v", "omega")
    surface = (
        after["v"][0, 0] - after["v"][1, 0] + R * (after["omega"][0, 1] + after["omega"][1, 1])
    )
    found = surface / 0.1 * RATIO / MU
    assert abs(balance(lmp)) < 1e-6 and value(lmp, "c_en[7]") > 0
    assert found == pytest.approx(_surface_rebound(angle), abs=0.01 * max(angle, 1.0))
    if angle > 4 * chi - 1:
        assert found == pytest.approx(
            angle - 4 * chi, abs=0.01 * angle
        )  # sliding: v_t minus 7/2 mu (1 + e) v_n


def _surface_rebound(angle: float) -> float:
    """Rebound angle psi from that of the approach; Hertz and a Mindlin-Coulomb spring, in units of
    the largest overlap.
    """
    steps = 40000
    x = 0.0
    v = 1.0
    u = angle * MU / RATIO
    force = 0.0
    a_before = 0.0
    dt = 3.2 / steps
    fn = 0.0
    for _ in range(steps):
        v -= 0.5 * dt * fn
        u += 0.5 * dt * 3.5 * force
        x += dt * v
        if x <= 0:
            break
        fn = 1.25 * x**1.5  # so that 1/2 v^2 = 1/2 x^2.5 at the peak
        a = np.sqrt(x)
        stiffness = RATIO * 1.875 * a  # k_n = dF/dx
        if a < a_before:
            force *= a / a_before
        force -= stiffness * u * dt
        a_before = a
        force = float(np.clip(force, -MU * fn, MU * fn))
        v -= 0.5 * dt * fn
        u += 0.5 * dt * 3.5 * force
    return u * RATIO / MU


# After tests 7 and 8 of Chung and Ooi (2011): aluminium, radius 0.1 m, each at 0.2 m/s towards the
# other, friction 0.4, both with the same spin about one axis. Their restitution is 0.5 by damping;
# here it is 1. Above 4.6 rad/s the sphere slides throughout.
@pytest.mark.parametrize("spin", [1.0, 3.0, 6.0, 14.0, 21.0])
@pytest.mark.parametrize("second", [0.1, 0.2])
def test_spheres_of_equal_and_unequal_size_with_spin(lammps, spin, second):
    modulus = 70e9
    ratio = 0.33
    mu = 0.4
    density = 2700.0
    speed = 0.2
    radii = np.array([0.1, second])
    signs = np.array([1.0, -1.0])
    spheres = {
        "radius": radii.tolist(),
        "density": density,
        "velocities": [(0, 0, speed), (0, 0, -speed)],
        "gap": 0.01,
    }
    law = f"hertz {modulus} {ratio} friction {mu}"
    lmp = lammps(
        rubbing([(0, 0, 0), (0, 0, radii.sum())], law, spins=[(0, spin, 0)] * 2, **spheres)
    )
    lmp.commands_string(
        f"timestep 5e-7\nrun 0 post no\nvariable start equal $({TOTAL}:%.17g)\nrun 3000 post no"
    )
    assert value(lmp, "c_en") == 0 and abs(balance(lmp)) < 1e-6
    after = state(lmp, "v", "omega")
    mass = state(lmp, "rmass")["rmass"]
    impulse = mass * after["v"][:, 0] * signs
    assert impulse[0] == pytest.approx(impulse[1], rel=1e-9)
    change = 0.4 * mass * radii * (after["omega"][:, 1] - spin)
    assert change == pytest.approx(np.full(2, change.mean()), rel=1e-3)
    assert abs(change.mean()) == pytest.approx(abs(impulse[0]), rel=4e-3)
    closing = 2 * speed
    reduced = mass.prod() / mass.sum()
    bound = 2 * mu * closing * reduced  # mu (1 + e) m* v_n
    stick = 2 * (1 - ratio) / (2 - ratio) * radii.sum() * spin / closing / mu  # psi
    if stick > 7 * (1 - ratio) / (2 - ratio) * 2 - 1:
        assert abs(impulse[0]) == pytest.approx(bound, rel=5e-3)
    else:
        assert abs(impulse[0]) < bound


def test_stiffness_is_mindlins(lammps):
    """The force of compressed spheres after a small shift is k_t times the shift, k_t/k_n = 2 (1 -
    nu)/(2 - nu).
    """
    law = ContactLaw(
        "hertz",
        youngs_modulus=(E, E),
        poisson_ratio=(NU, NU),
        yield_strength=(np.inf,) * 2,
        radius=(R, R),
    )
    overlap = 1e-5
    slip = 1e-9
    lmp = lammps(
        rubbing(
            [(0, 0, 0), (0, 0, 2 * R - overlap)],
            extra="unfix motion\nfix motion all move linear 0 0 0",
        )
    )
    lmp.commands_string(
        "unfix motion\nvelocity all set 0 0 0\nset atom 1 vx 0.1\nfix motion all nve/noforce\nrun 1 post no"
    )
    force = -value(lmp, "fx[1]")
    assert value(lmp, "x[1]") == pytest.approx(slip, rel=1e-9)
    k_n = 1.5 * law.loading_force(overlap) / overlap
    assert law.tangential_stiffness(overlap, overlap) == pytest.approx(RATIO * k_n, rel=1e-12)
    shift = (
        0.1 * slip / overlap / (2 * R) * law.loading_force(overlap)
    )  # the rotation of the normal force is much smaller
    assert force == pytest.approx(RATIO * k_n * slip, abs=1e-3 * RATIO * k_n * slip + shift)


# ---------------------------------------------------------------------- LAMMPS's own


@pytest.mark.parametrize("model", ["mindlin_rescale", "mindlin"])
@pytest.mark.parametrize("tangential", [0.3, 2.0, 4.0])
def test_against_mindlin_of_lammps_through_a_collision(lammps, tangential, model):
    """Elastic spheres: forces during contact, and velocities and spins after it, agree within 0.5
    %.
    """
    own = LAMMPS_OWN.format(E=E, nu=NU, mu=MU, model=f"{model}/force")
    law = f"{HERTZ} friction {MU} tangential {model}"
    ours, theirs = (
        oblique(lammps, tangential, steps=0, **options) for options in ({"law": law}, {"own": own})
    )
    limit = 0.0
    forces = []
    torques = []
    for _ in range(40):
        for lmp in (ours, theirs):
            lmp.command("run 100 pre no post no")
        a = state(ours, "f", "torque")
        b = state(theirs, "f", "torque")
        limit = max(limit, abs(b["f"]).max())
        forces.append(abs(a["f"] - b["f"]).max())
        torques.append(abs(a["torque"] - b["torque"]).max())
    assert max(forces) < 5e-3 * limit and max(torques) < 5e-3 * limit * R * MU
    for lmp in (ours, theirs):
        lmp.command("run 4000 pre no post no")
    a = state(ours, "v", "omega")
    b = state(theirs, "v", "omega")
    assert a["v"] == pytest.approx(b["v"], abs=5e-3 * tangential)
    # LAMMPS uses the full radius as the lever arm of the slip: a difference of overlap/radius, more
    # if slip often reverses
    margin = 7e-3 if model == "mindlin" else 5e-3
    assert a["omega"] == pytest.approx(b["omega"], abs=margin * abs(b["omega"]).max())


# ---------------------------------------------------------------------- energy


def test_unloading_creates_no_energy(lammps):
    """A spring stretched while the circle is large and released while it is small would return more
    energy than it absorbed without rescaling. A sphere is pressed in, shifted, withdrawn by one
    half, and shifted back.
    """
    held = "unfix motion\nfix motion all nve/noforce"
    lmp = lammps(rubbing([(0, 0, 0), (0, 0, 2 * R - 1e-5)], f"{HERTZ} friction 10", extra=held))
    work = 0.0
    before = value(lmp, "0")
    for velocity in ((0.1, 0, 0), (0, 0, -0.7), (-0.1, 0, 0), (0, 0, 0.7)):
        lmp.command(
            "set atom 1 " + " ".join(f"v{a} {v}" for a, v in zip("xyz", velocity, strict=True))
        )
        for _ in range(100):
            lmp.command("run 10 post no")
            force = -np.dot(state(lmp, "f")["f"][0], velocity)
            work += 0.5 * (before + force) * 10 * 1e-8
            before = force
    assert value(lmp, "c_en[7]") > 0
    assert work > 0 and value(lmp, "c_en+c_en[6]+c_en[7]") > 0


@pytest.mark.parametrize(("friction", "swapped"), [(0.3, False), (0.3, True), (0.0, False)])
def test_commands_of_lammps_find_the_tangential_force(lammps, friction, swapped):
    """The fabric of one contact along z is 10/3 T/N; the first columns are those of gran/hooke."""
    law = f"{BRASS} friction {friction} tangential mindlin" if friction else BRASS
    places = [(0, 0, 2 * R), (0, 0, 0)] if swapped else [(0, 0, 0), (0, 0, 2 * R)]
    side = -1.0 if swapped else 1.0
    extra = "compute fabric all fabric radius force/tangential\n"
    extra += "compute single all pair/local force p1 p2 p3 p4 p5 p6 p7 p8 p9 p10\n"
    extra += "compute one all gran/hysteretic/contact 1 2\n"
    extra += "compute ids all property/local patom1 patom2\n"
    speeds = [(0.5 * side, 0.25, side), (0, 0, 0)]
    lmp = lammps(rubbing(places, law, velocities=speeds, extra=extra))
    lmp.command("run 1500 post no")
    normal = value(lmp, "c_one[2]")
    tangential = value(lmp, "c_one[6]")
    assert normal > 0
    assert (tangential > 0) == (friction > 0)
    assert value(lmp, "c_fabric[3]") == pytest.approx(10 / 3 * tangential / normal, rel=1e-5)
    lmp.command("run 0 post no")
    ids = lmp.numpy.extract_compute("ids", 2, 2)[0].astype(int)
    row = lmp.numpy.extract_compute("single", 2, 2)[0]
    now = state(lmp, "x", "v", "f")
    first, second = ids - 1
    apart = now["x"][first] - now["x"][second]
    apart /= np.linalg.norm(apart)
    force = now["f"][first]
    along = (force @ apart) * apart
    velocity = now["v"][first] - now["v"][second]
    approach = (velocity @ apart) * apart
    assert row[0] == pytest.approx(force @ apart, rel=1e-12)
    assert row[1:4] == pytest.approx(force - along, rel=1e-9, abs=1e-9)
    assert row[4] == pytest.approx(tangential, rel=1e-12, abs=1e-12)
    assert row[5:8] == pytest.approx(approach, rel=1e-9, abs=1e-12)
    assert row[8:11] == pytest.approx(velocity - approach, rel=1e-9, abs=1e-12)
