"""Viscous damping of contacts: restitution compared with closed forms and independent solvers,
energy, restarts, invalid words.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw, LineContact
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import BOX, PAIR, R, restitution, value
from tests.helpers.twins import viscous_twin

E = 115e9
NU = 0.3
STRENGTH = 550e6
DENSITY = 8500.0
MASS = DENSITY * 4 / 3 * np.pi * R**3
LAWS = {
    "hertz": f"hertz {E} {NU}",
    "elastoplastic": f"elastoplastic {E} {NU} {STRENGTH}",
    "bilinear": f"bilinear {E} {NU} {STRENGTH}",
    "thornton": f"thornton {E} {NU} {STRENGTH}",
    "power": f"power {E} {NU} constant 5e9 exponent 1.4",
}
LOSSES = {"time": 1e-6, "dashpot": 0.1}
ENERGY = "c_ke+c_en+c_en[1]+c_en[8]"


def law_of(name: str, **options) -> ContactLaw:
    two = {
        "youngs_modulus": (E, E),
        "poisson_ratio": (NU, NU),
        "yield_strength": (STRENGTH, STRENGTH),
    }
    options |= {"constant": 5e9, "exponent": 1.4} if name == "power" else {}
    return ContactLaw(name, radius=(R, R), **two, **options)


def spheres(lammps, words, speed=2.0, dt=1e-8, places=PAIR, extra="", **options):
    """A chain of spheres, the first two of which approach each other at a speed."""
    lmp = lammps()
    velocities = [(0, 0, speed / 2), (0, 0, -speed / 2)] + [(0, 0, 0)] * (len(places) - 2)
    text = script_of(places, style=words, velocities=velocities, box=BOX, **options)
    text = text.replace("newton off", "newton off\ncomm_modify vel yes")
    lmp.commands_string(
        f"{text}\ntimestep {dt}\ncompute en all gran/hysteretic/energy\ncompute pair all gran/hysteretic/contact 1 2\n"
        f"thermo_style custom step c_ke c_en c_en[*] c_pair[*]\n{extra}\nrun 0 post no"
    )
    return lmp


@pytest.mark.parametrize("loss", LOSSES)
@pytest.mark.parametrize("law", LAWS)
def test_every_law_collides_as_the_binding_does(lammps, law, loss):
    """Restitution and largest force of LAMMPS are those of the Runge-Kutta solution of the binding."""
    lmp = spheres(lammps, f"{LAWS[law]} loss {loss} {LOSSES[loss]}", dt=1e-8)
    lmp.command("run 7000 post no")
    expected = law_of(law).collide(MASS / 2, 2.0, **{f"loss_{loss}": LOSSES[loss]}, steps=5000)
    assert expected["restitution"] < law_of(law).collide(MASS / 2, 2.0)["restitution"] - 0.02
    assert restitution(lmp) == pytest.approx(expected["restitution"], abs=2e-5)
    assert value(lmp, "c_en[5]") == pytest.approx(expected["peak_force"], rel=1e-4)
    lost = 0.5 * MASS / 2 * 4 * (1 - expected["restitution"] ** 2)
    assert value(lmp, "c_en[1]+c_en[8]") == pytest.approx(lost, rel=1e-4)
    assert value(lmp, "c_pair[8]") == value(lmp, "c_en[8]") > 0


@pytest.mark.parametrize(
    ("loss", "size"), [("time", 2e-7), ("time", 5e-6), ("dashpot", 0.05), ("dashpot", 1.0)]
)
def test_hertz_against_another_solver(loss, size):
    """The collision of the binding agrees with scipy's solver and independent formulas."""
    expected = viscous_twin.collision(viscous_twin.hertz(E, NU, R), MASS, 2.0, **{loss: size})
    found = law_of("hertz").collide(MASS / 2, 2.0, **{f"loss_{loss}": size}, steps=4000)
    assert found["restitution"] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
def test_series_of_viscoelastic_spheres(speed):
    """e = 1 - 1.1534 b + 0.7983 b^2 + 0.2667 b^2.5, b = 3/2 A (K/m*)^(2/5) v^(1/5) (Schwager,
    Poeschel 2008).
    """
    constant = 4 / 3 * E / (2 * (1 - NU**2)) * np.sqrt(R / 2)
    for time in (2e-8, 2e-7):
        b = 1.5 * time * (constant / (MASS / 2)) ** 0.4 * speed**0.2
        series = 1 - 1.153449 * b + 0.798267 * b**2 + 0.266666 * b**2.5
        found = law_of("hertz").collide(MASS / 2, speed, loss_time=time, steps=20000)["restitution"]
        assert b > 0.001 and found == pytest.approx(series, abs=2 * b**3 + 1e-6)


@pytest.mark.parametrize("time", [1e-7, 1e-6, 3e-6])
def test_linear_spring_with_a_damper(time):
    """Without an indentation the bilinear law is linear: e = exp(-(b/w)(pi - atan(2 b w/(w^2 -
    b^2)))), b = A w0^2/2.
    """
    k = 18.5 * STRENGTH * R / 2
    b = time * k / MASS  # c/(2 m*) with c = A k
    w = np.sqrt(k / (MASS / 2) - b**2)
    closed = np.exp(-b / w * (np.pi - np.arctan2(2 * b * w, w**2 - b**2)))
    for speed in (0.5, 5.0):
        found = law_of("bilinear", beta=0.0).collide(MASS / 2, speed, loss_time=time, steps=20000)[
            "restitution"
        ]
        assert found == pytest.approx(closed, abs=1e-5)


def test_a_dashpot_has_one_restitution():
    """The restitution of Tsuji's dashpot does not depend on speed or mass; if tension is allowed it
    is known in closed form.
    """
    found = [
        law_of("hertz").collide(mass, speed, loss_dashpot=0.1, steps=2000)["restitution"]
        for mass in (MASS / 2, 10 * MASS)
        for speed in (0.01, 1.0, 100.0)
    ]
    assert np.ptp(found) < 1e-9
    share = 0.1 / np.sqrt(
        5
    )  # Antypov, Elliott 2011, from which leaving out what pulls differs to the second order
    assert found[0] == pytest.approx(
        np.exp(-np.pi * share / np.sqrt(1 - share**2)), abs=share**2 * 2
    )
    assert found[0] > np.exp(-np.pi * share / np.sqrt(1 - share**2))


@pytest.mark.parametrize(("speed", "expected"), [(1.0, 0.7468), (6.0, 0.7141)])
def test_discs_of_polyurethane(lammps, speed, expected):
    """Restitution of two cylinders with a relaxation time of 12 us, from an earlier program, LAMMPS
    and the binding.
    """
    modulus = 70e6
    ratio = 0.48
    radius = 6.35e-3
    density = 1130.0
    length = 0.0254
    two = {
        "youngs_modulus": (modulus, modulus),
        "poisson_ratio": (ratio, ratio),
        "radius": (radius, radius),
    }
    line = LineContact.plane_strain(**two, length=length)
    mass = density * np.pi * radius**2 * length
    law = ContactLaw("hertz", yield_strength=(np.inf, np.inf), line=line, **two)
    found = law.collide(mass / 2, speed, loss_time=12e-6, steps=4000)["restitution"]
    assert found == pytest.approx(expected, abs=1e-4)
    lmp = spheres(
        lammps, f"hertz {modulus} {ratio} loss time 12e-6", speed, dt=1e-7, places=[(0, 0, 0), (0, 0, 2 * radius)],
        radius=radius, density=mass / (4 / 3 * np.pi * radius**3), extra=f"fix shape all gran/cylinder 1 {length} 0 1 0 line plane-strain",
    )  # fmt: skip
    start = value(lmp, ENERGY)
    lmp.command("run 20000 post no")
    assert restitution(lmp, speed) == pytest.approx(found, abs=1e-4)
    assert value(lmp, ENERGY) == pytest.approx(start, rel=1e-5)


@pytest.mark.parametrize("law", ["hertz", "elastoplastic", "bilinear"])
@pytest.mark.parametrize("loss", LOSSES)
def test_the_ledger_closes_to_the_second_order(lammps, law, loss):
    """Half the timestep gives about a quarter of the error at any instant; no force is tensile."""
    errors = []
    for steps in (500, 1000):  # of 8e-5 s
        place = [(0, 0, 0), (0, 0, 2 * R + 3.3e-7)]
        lmp = spheres(
            lammps, f"{LAWS[law]} loss {loss} {LOSSES[loss]}", dt=8e-5 / steps, places=place
        )
        start = value(lmp, ENERGY)
        worst = 0.0
        for _ in range(100):
            lmp.command(f"run {steps // 100} pre no post no")
            worst = max(worst, abs(value(lmp, ENERGY) / start - 1))
            assert value(lmp, "c_pair[2]") >= 0
        assert value(lmp, "c_pair[1]") < 0
        errors.append(worst)
    assert errors[0] < 1e-4
    assert errors[1] < 0.36 * errors[0]


def test_the_wave_of_a_chain_decays_as_in_another_solver(lammps):
    """Largest forces along a chain, with damping that reduces them by a third over the first
    contacts.
    """
    n = 12
    loss = 5e-7
    places = [(0, 0, 2 * R * k) for k in range(n)]
    expected = viscous_twin.chain(viscous_twin.hertz(E, NU, R), MASS, n, 1.0, 2.5e-4, time=loss)[
        "force"
    ].max(axis=1)
    lmp = spheres(lammps, f"{LAWS['hertz']} loss time {loss}", 0.0, dt=2e-8, places=places)
    lmp.commands_string(
        "set atom 1 vz 1.0\ncompute all_pairs all gran/hysteretic/local\nrun 12500 post no"
    )
    rows = lmp.numpy.extract_compute("all_pairs", 2, 2)
    found = rows[np.argsort(rows[:, 0]), 5]
    assert len(found) >= 8  # ahead of a wave there is no contact
    assert found[:8] == pytest.approx(expected[:8], rel=1e-3)
    assert found[7] < 0.75 * found[0]


@pytest.mark.parametrize("law", ["hertz", "elastoplastic"])
def test_a_wall_loses_as_a_heavy_sphere(lammps, law):
    """The rebound of a sphere from a rigid wall agrees with the binding, and the column of the wall
    has the dissipation.
    """
    lmp = lammps()
    text = script_of([(0, 0, 0)], velocities=[(0, 0, 2.0)], box=BOX)
    lmp.commands_string(
        f"{text}\nfix wall all wall/gran/hysteretic zplane NULL {R:.17g} {LAWS[law]} loss time 1e-6\n"
        "thermo_style custom step c_ke f_wall f_wall[*]\ntimestep 2e-8\nrun 0 post no"
    )
    energy = "c_ke+f_wall+f_wall[5]+f_wall[16]"
    start = value(lmp, energy)
    lmp.command("run 10000 post no")
    two = {
        "youngs_modulus": (E, np.inf),
        "poisson_ratio": (NU, 0),
        "yield_strength": (STRENGTH, np.inf),
    }
    expected = ContactLaw(law, radius=(R, np.inf), **two).collide(
        MASS, 2.0, loss_time=1e-6, steps=4000
    )["restitution"]
    assert -value(lmp, "vz[1]") / 2 == pytest.approx(expected, abs=2e-5)
    assert value(lmp, energy) == pytest.approx(start, rel=1e-5)
    assert value(lmp, "f_wall[16]") > 0


def test_friction_goes_with_the_whole_normal_force(lammps):
    """Spheres that slide past each other dissipate energy by friction and damping, and the energy
    balance closes.
    """
    lmp = spheres(lammps, f"{LAWS['hertz']} friction 0.3 loss dashpot 0.3", dt=1e-8)
    lmp.commands_string(
        "unfix motion\nfix motion all nve/sphere\nset atom 1 vx 1.5\ncompute turn all erotate/sphere\nrun 0 post no"
    )
    total = f"{ENERGY}+c_en[6]+c_en[7]+c_turn"
    start = value(lmp, total)
    lmp.command("run 6000 post no")
    assert value(lmp, total) == pytest.approx(start, rel=1e-5)
    assert value(lmp, "c_en[7]") > 0.01 * start and value(lmp, "c_en[8]") > 0.01 * start


@pytest.mark.parametrize(
    ("fixes", "mass"),
    [
        ("fix hold other freeze", MASS),
        ("unfix motion\nfix motion first nve\nfix body other rigid single", 2 / 3 * MASS),
        ("unfix motion\nfix motion first nve\nfix body other rigid/small molecule", 2 / 3 * MASS),
    ],
)
def test_a_dashpot_knows_what_is_frozen_and_what_is_rigid(lammps, fixes, mass):
    """A frozen sphere is immovable, and two spheres of a rigid body have its mass, as in pair style
    granular of LAMMPS.
    """
    lmp = lammps()
    if fixes.endswith("molecule"):
        fixes = fixes.replace("rigid/small molecule", "rigid/small custom i_body")
        fixes = f"fix names all property/atom i_body\nset group other i_body 1\n{fixes}"
    text = script_of(
        [*PAIR, (0, 0, 4.1 * R)],
        style=f"{LAWS['hertz']} loss dashpot 0.3",
        velocities=[(0, 0, 1.0)],
        box=BOX,
    ).replace("newton off", "newton off\ncomm_modify vel yes")
    lmp.commands_string(f"{text}\ngroup first id 1\ngroup other id 2 3\n{fixes}\nrun 12000 post no")
    expected = law_of("hertz").collide(mass, 1.0, loss_dashpot=0.3, steps=4000)
    assert expected["restitution"] < 0.7
    assert value(lmp, "vz[2]-vz[1]") == pytest.approx(expected["restitution"], abs=1e-4)


def test_a_wall_knows_rigid_bodies(lammps):
    lmp = lammps()
    text = script_of([(0, 0, 0), (0, 0, -2.1 * R)], velocities=[(0, 0, 1.0)] * 2, box=BOX)
    lmp.commands_string(
        f"{text}\nfix wall all wall/gran/hysteretic zplane NULL {R:.17g} {LAWS['hertz']} loss dashpot 0.3\n"
        "unfix motion\nfix body all rigid single\nrun 12000 post no"
    )
    two = {
        "youngs_modulus": (E, np.inf),
        "poisson_ratio": (NU, 0),
        "yield_strength": (np.inf, np.inf),
    }
    expected = ContactLaw("hertz", radius=(R, np.inf), **two).collide(
        2 * MASS, 1.0, loss_dashpot=0.3, steps=4000
    )
    assert -value(lmp, "vz[1]") == pytest.approx(expected["restitution"], abs=1e-4)
