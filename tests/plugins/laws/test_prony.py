"""Viscoelastic contacts: relaxation, limits of slow and fast motion, collisions, energy, words."""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw, LineContact
from tests.conftest import script_of
from tests.helpers.bodies.two_spheres import BOX, PAIR, R, restitution, value
from tests.helpers.twins import prony_twin

E = 2.4e9
NU = 0.38
DENSITY = 1200.0
MASS = DENSITY * 4 / 3 * np.pi * R**3
HERTZ = f"hertz {E} {NU}"
CONSTANT = 4 / 3 * E / (2 * (1 - NU**2)) * np.sqrt(R / 2)
SERIES = {
    "one branch": [(0.4, 3e-5)],
    "two branches": [(0.3, 1e-5), (0.2, 2e-4)],
    "four branches": [(0.2, 2e-6), (0.15, 2e-5), (0.1, 2e-4), (0.3, 5e-3)],
}
ENERGY = "c_ke+c_en+c_en[8]"
ELASTIC = {"hertz": HERTZ, "power": f"power {E} {NU} constant 1e8 exponent 1.3"}


def words_of(series) -> str:
    return "loss prony " + " ".join(f"{float(weight)!r} {float(time)!r}" for weight, time in series)


def law_of(name="hertz", **options) -> ContactLaw:
    two = {"youngs_modulus": (E, E), "poisson_ratio": (NU, NU), "yield_strength": (np.inf, np.inf)}
    options |= {"constant": 1e8, "exponent": 1.3} if name == "power" else {}
    return ContactLaw(name, radius=(R, R), **two, **options)


def spheres(lammps, words, speed=1.0, dt=1e-7, places=PAIR, extra=""):
    """Spheres in a row, of which the first two approach each other with a speed."""
    lmp = lammps()
    velocities = [(0, 0, speed / 2), (0, 0, -speed / 2)] + [(0, 0, 0)] * (len(places) - 2)
    text = script_of(places, style=words, velocities=velocities, box=BOX, density=DENSITY)
    lmp.commands_string(
        f"{text}\ntimestep {dt}\ncompute en all gran/hysteretic/energy\n"
        "compute pair all gran/hysteretic/contact 1 2\n"
        f"thermo_style custom step c_ke c_en c_en[*] c_pair[*]\n{extra}\nrun 0 post no"
    )
    return lmp


@pytest.mark.parametrize("name", SERIES)
def test_a_held_contact_relaxes_as_its_modulus(name):
    """F(t)/F(0) is E(t)/E, and the energy of the branches decays twice as fast as their stress."""
    series = SERIES[name]
    time = np.linspace(0, 1e-3, 300)
    found = law_of().relax(np.full(300, 1e-5), time, series)
    work = float(law_of().loading_work(1e-5))
    force = float(law_of().loading_force(1e-5))
    assert found["force"] == pytest.approx(force * prony_twin.relaxation(series, time), rel=1e-12)
    halved = [(weight, constant / 2) for weight, constant in series]
    assert found["elastic_energy"] == pytest.approx(
        work * prony_twin.relaxation(halved, time), rel=1e-12
    )
    total = found["elastic_energy"] + found["dissipated_energy"]
    assert total == pytest.approx(np.full(300, work), rel=1e-12)


@pytest.mark.parametrize("steps", [1, 40])
def test_force_in_a_packing_relaxes(lammps, steps):
    """Spheres that are held relax in LAMMPS by the same formula, in long timesteps and in short
    ones.
    """
    series = SERIES["two branches"]
    lmp = spheres(
        lammps, f"{HERTZ} {words_of(series)}", 0.0, dt=2e-4 / steps,
        places=[(0, 0, 0), (0, 0, 2 * R - 1e-5)], extra="fix hold all setforce 0 0 0",
    )  # fmt: skip
    first = value(lmp, "c_pair[2]")
    assert first == pytest.approx(CONSTANT * 1e-5**1.5, rel=1e-6)
    lmp.command(f"run {steps} post no")
    left = prony_twin.relaxation(series, np.array([2e-4]))[0]
    assert value(lmp, "c_pair[2]") == pytest.approx(first * left, rel=1e-9)


def test_surfaces_that_have_parted_recover():
    """Free surfaces of one branch recover with the time tau/(1 - g), in P; LAMMPS accounts for all
    stored energy.
    """
    held = np.linspace(0, 1e-3, 101)
    free = 1e-3 + np.linspace(0, 5e-4, 2001)[1:]
    found = law_of().relax(
        np.r_[np.full(101, 1e-5), np.zeros(2000)], np.r_[held, free], SERIES["one branch"]
    )
    law = found["surface_overlap"][101:] ** 1.5
    slower = np.exp(-(1 - 0.4) * (free - free[0]) / 3e-5)
    early = free - free[0] < 2e-4
    assert (law / law[0])[early] == pytest.approx(slower[early], rel=1e-5)
    assert np.all(found["force"][101:] == 0)
    assert np.all(np.diff(found["dissipated_energy"]) >= 0)
    assert found["elastic_energy"][-1] < 1e-6 * found["elastic_energy"][0]


def test_energy_is_that_of_a_foundation_of_springs():
    """Force and stored energy of a growing contact are those of springs that relax one by one."""
    series = SERIES["two branches"]
    time = np.linspace(0, 1e-4, 1001)
    overlap = 1e-5 * np.sin(0.5 * np.pi * time / 1e-4)
    found = law_of().relax(overlap, time, series)
    force, energy = prony_twin.foundation(CONSTANT, overlap, time, series, 2000)
    assert found["force"][100:] == pytest.approx(force[100:], rel=3e-4)
    assert found["elastic_energy"][100:] == pytest.approx(energy[100:], rel=3e-4)
    assert found["elastic_energy"][-1] < 0.9 * float(law_of().loading_work(overlap[-1]))


@pytest.mark.parametrize("speed", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("name", SERIES)
def test_restitution_against_another_solver(name, speed):
    """The binding's collision is that of scipy's solver with formulas of the tests."""
    expected = prony_twin.collision(
        lambda a: CONSTANT * a**1.5, MASS / 2, speed, SERIES[name], 1e-6
    )
    found = law_of().collide(MASS / 2, speed, loss_prony=SERIES[name], steps=20000)
    assert expected < 0.98
    assert found["restitution"] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("speed", "expected"), [(1.0, 0.9643), (6.0, 0.9678)])
def test_cylinders_of_polyurethane(lammps, speed, expected):
    """Equation 7 of the paper on lateral constraints, with its time constants in ms; in s, as
    printed, nothing is dissipated. The numbers agree with the page on damping.
    """
    instantaneous = (15.7 + 253.1 + 1320.4) * 1e6
    series = [(1320.4e6 / instantaneous, 0.55e-3), (253.1e6 / instantaneous, 2.64e-3)]
    radius = 6.35e-3
    length = 0.0254
    density = 1130.0
    two = {
        "youngs_modulus": (instantaneous,) * 2,
        "poisson_ratio": (0.48,) * 2,
        "radius": (radius,) * 2,
    }
    line = LineContact.plane_strain(**two, length=length)
    law = ContactLaw("hertz", yield_strength=(np.inf, np.inf), line=line, **two)
    mass = density * np.pi * radius**2 * length
    found = law.collide(mass / 2, speed, loss_prony=series, steps=8000)["restitution"]
    solved = prony_twin.collision(
        lambda a: float(law.loading_force(a)), mass / 2, speed, series, 2e-7
    )
    assert found == pytest.approx(solved, abs=2e-6)
    assert found == pytest.approx(expected, abs=5e-5)
    printed = [(weight, 1e3 * time) for weight, time in series]
    assert law.collide(mass / 2, speed, loss_prony=printed)["restitution"] > 0.9999
    lmp = lammps()
    text = script_of(
        [(0, 0, 0), (0, 0, 2 * radius)], style=f"hertz {instantaneous} 0.48 {words_of(series)}",
        velocities=[(0, 0, speed / 2), (0, 0, -speed / 2)], box=BOX, radius=radius,
        density=mass / (4 / 3 * np.pi * radius**3),
    )  # fmt: skip
    lmp.commands_string(
        f"{text}\nfix shape all gran/cylinder 1 {length} 0 1 0 line plane-strain\ntimestep 2e-8\n"
        "compute en all gran/hysteretic/energy\nthermo_style custom step c_ke c_en c_en[*]\n"
        "run 0 post no"
    )
    start = value(lmp, ENERGY)
    lmp.command("run 4000 post no")
    assert restitution(lmp, speed) == pytest.approx(found, abs=2e-5)
    assert value(lmp, ENERGY) == pytest.approx(start, rel=1e-5)


def test_slow_and_fast_collisions_are_elastic():
    """With times far below the duration, the law is elastic with the relaxed modulus; far above,
    with the instantaneous one.
    """
    law = law_of()
    alone = law.collide(MASS / 2, 1.0, steps=4000)
    relaxed = law.collide(MASS / 2, 1.0, loss_prony=[(0.4, 1e-9)], steps=4000)
    fresh = law.collide(MASS / 2, 1.0, loss_prony=[(0.4, 10.0)], steps=4000)
    assert relaxed["duration"] == pytest.approx(alone["duration"] / 0.6**0.4, rel=1e-3)
    assert relaxed["peak_force"] == pytest.approx(alone["peak_force"] * 0.6**0.4, rel=1e-3)
    assert fresh["peak_force"] == pytest.approx(alone["peak_force"], rel=1e-4)
    assert relaxed["restitution"] == pytest.approx(1.0, abs=1e-3)
    assert fresh["restitution"] == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("law", ELASTIC)
@pytest.mark.parametrize("name", SERIES)
def test_spheres_collide_as_the_binding_does(lammps, law, name):
    lmp = spheres(lammps, f"{ELASTIC[law]} {words_of(SERIES[name])}")
    lmp.command("run 2500 post no")
    expected = law_of(law).collide(MASS / 2, 1.0, loss_prony=SERIES[name], steps=8000)
    assert restitution(lmp, 1.0) == pytest.approx(expected["restitution"], abs=2e-5)
    assert value(lmp, "c_en[5]") == pytest.approx(expected["peak_force"], rel=1e-4)
    lost = 0.25 * MASS * (1 - expected["restitution"] ** 2)
    assert value(lmp, "c_en[8]") == pytest.approx(lost, rel=1e-4)
    assert value(lmp, "c_pair[8]") == value(lmp, "c_en[8]")


@pytest.mark.parametrize("apart", [400, 4000])
def test_a_second_contact_finds_the_surface_that_recovers(lammps, apart):
    """Driven spheres are pressed, held, separated and pressed again: in every step the force agrees
    with the path in the binding, and depends on the time between.
    """
    series = SERIES["two branches"]
    dt = 1e-7
    pieces = [(0.1, 100), (0.0, 2000), (-0.1, 200), (0.0, apart), (0.1, 200)]
    lmp = spheres(lammps, f"{HERTZ} {words_of(series)}", 0.0, extra="fix hold all setforce 0 0 0")
    speeds = np.concatenate([np.full(n, speed) for speed, n in pieces])
    for speed, n in pieces:
        lmp.command(f"set atom 1 vz {speed}")
        lmp.command(f"run {n} post no")
    overlap = dt * np.r_[0.0, np.cumsum(speeds)]
    found = law_of().relax(overlap, dt * np.arange(len(overlap)), series)
    fresh = law_of().relax(overlap[-201:], dt * np.arange(201), series)
    assert value(lmp, "c_pair[1]") == pytest.approx(overlap[-1], rel=1e-6)
    assert value(lmp, "c_pair[2]") == pytest.approx(found["force"][-1], rel=2e-5)
    assert fresh["force"][-1] > 1.02 * found["force"][-1]
    stored = value(lmp, "c_en")
    assert stored == pytest.approx(found["elastic_energy"][-1], rel=2e-5)
    assert value(lmp, "c_en[8]") == pytest.approx(found["dissipated_energy"][-1], rel=2e-4)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_a_pressed_pair_vibrates_with_the_complex_modulus(lammps, ratio):
    """Small vibration of two spheres that are held by a force: (i w)^2 m* + k E*(w)/E = 0, with k
    the slope at the static overlap and E* = E (1 - g + g i w tau/(1 + i w tau)).
    """
    weight = 0.2
    overlap = 1e-5
    slope = 1.5 * CONSTANT * np.sqrt(overlap)
    time = ratio * np.sqrt(MASS / 2 / slope)
    force = (1 - weight) * CONSTANT * overlap**1.5
    roots = np.roots([time * MASS / 2, MASS / 2, slope * time, slope * (1 - weight)])
    root = roots[np.argmax(roots.imag)]
    series = [(weight, time)]
    lmp = spheres(lammps, f"{HERTZ} {words_of(series)}", 0.0, dt=5e-8,
                  places=[(0, 0, 0), (0, 0, 2 * R - overlap)])  # fmt: skip
    lmp.commands_string(
        "group low id 1\ngroup high id 2\nfix hold all setforce 0 0 0\n"
        f"timestep {float(time) / 10!r}\nrun 500 post no\nunfix hold\n"
        f"fix up low addforce 0 0 {float(force)!r}\nfix down high addforce 0 0 {-float(force)!r}\n"
        "velocity low set 0 0 1e-4\nvelocity high set 0 0 -1e-4\ntimestep 5e-8"
    )
    period = 2 * np.pi / root.imag
    steps = round(4 * period / 5e-8 / 200)
    path = []
    for _ in range(200):
        lmp.command(f"run {steps} pre no post no" if path else f"run {steps} post no")
        path.append(value(lmp, "c_pair[1]"))
    path = np.array(path) - overlap
    at = 5e-8 * steps * np.arange(1, 201)
    real = roots[np.abs(roots.imag) < 1e-9 * np.abs(root)].real
    columns = [np.exp(root.real * at) * np.cos(root.imag * at),
               np.exp(root.real * at) * np.sin(root.imag * at),
               *(np.exp(one * at) for one in real)]  # fmt: skip
    basis = np.stack(columns, axis=1)
    amplitudes, *_ = np.linalg.lstsq(basis, path, rcond=None)
    left = path - basis @ amplitudes
    assert np.abs(left).max() < 5e-3 * np.abs(path).max()
    assert np.hypot(*amplitudes[:2]) > 0.5 * np.abs(path).max()


@pytest.mark.parametrize("name", SERIES)
def test_the_ledger_closes_to_the_second_order(lammps, name):
    """Half of the timestep leaves about a quarter of the error at any instant; no force is tensile,
    and the dissipation never decreases.
    """
    errors = []
    for steps in (500, 1000):  # of 2e-4 s
        place = [(0, 0, 0), (0, 0, 2 * R + 3.3e-7)]
        lmp = spheres(lammps, f"{HERTZ} {words_of(SERIES[name])}", dt=2e-4 / steps, places=place)
        start = value(lmp, ENERGY)
        worst = 0.0
        lost = 0.0
        for _ in range(100):
            lmp.command(f"run {steps // 100} pre no post no")
            worst = max(worst, abs(value(lmp, ENERGY) / start - 1))
            assert value(lmp, "c_pair[2]") >= 0
            assert value(lmp, "c_en[8]") >= lost
            lost = value(lmp, "c_en[8]")
        assert value(lmp, "c_pair[1]") < 0
        errors.append(worst)
    assert errors[0] < 1e-4
    assert errors[1] < 0.36 * errors[0]


def test_the_wave_of_a_chain_decays_as_in_another_solver(lammps):
    """Largest forces along a chain, which decrease strongly over the first contacts."""
    n = 12
    series = SERIES["two branches"]
    places = [(0, 0, 2 * R * k) for k in range(n)]
    expected = prony_twin.chain(CONSTANT, MASS, n, 1.0, 6e-4, series)
    lmp = spheres(lammps, f"{HERTZ} {words_of(series)}", 0.0, places=places)
    lmp.commands_string(
        "set atom 1 vz 1.0\ncompute all_pairs all gran/hysteretic/local\nrun 6000 post no"
    )
    rows = lmp.numpy.extract_compute("all_pairs", 2, 2)
    found = rows[np.argsort(rows[:, 0]), 5]
    assert len(found) >= 8  # ahead of a wave there is no contact
    assert found[:8] == pytest.approx(expected[:8], rel=1e-3)
    assert found[7] < 0.8 * found[0]


def test_a_wall_relaxes_as_a_heavy_sphere(lammps):
    """The rebound of a sphere from a rigid wall agrees with the binding; the wall has dissipated
    energy.
    """
    series = SERIES["two branches"]
    lmp = lammps()
    text = script_of([(0, 0, 0)], velocities=[(0, 0, 1.0)], box=BOX, density=DENSITY)
    lmp.commands_string(
        f"{text}\nfix wall all wall/gran/hysteretic zplane NULL {R:.17g} {HERTZ} "
        f"{words_of(series)}\n"
        "thermo_style custom step c_ke f_wall f_wall[*]\ntimestep 1e-7\nrun 0 post no"
    )
    energy = "c_ke+f_wall+f_wall[16]"
    start = value(lmp, energy)
    for _ in range(30):
        lmp.command("run 100 pre no post no")
        assert value(lmp, energy) == pytest.approx(start, rel=2e-5)
    two = {"youngs_modulus": (E, np.inf), "poisson_ratio": (NU, 0)}
    law = ContactLaw("hertz", radius=(R, np.inf), yield_strength=(np.inf, np.inf), **two)
    expected = law.collide(MASS, 1.0, loss_prony=series, steps=8000)
    assert -value(lmp, "vz[1]") == pytest.approx(expected["restitution"], abs=2e-5)
    assert value(lmp, "f_wall[16]") > 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (f"{HERTZ} loss prony 0.3", "needs a weight and a time .* found 1 number"),
        (f"{HERTZ} loss prony 0.1 1 0.1 2 0.1 3 0.1 4 0.1 5", "1 to 4 branches, found 10 numbers"),
        (f"{HERTZ} loss prony 0.6 1e-4 0.4 1e-3", "must sum to less than 1"),
        (f"{HERTZ} loss prony -0.1 1e-4", "weight of loss prony must lie in"),
        (f"{HERTZ} loss prony 0.1 0", "time of loss prony must be positive"),
        (f"elastoplastic {E} {NU} 60e6 loss prony 0.1 1", "requires an elastic law"),
        (f"{HERTZ} loss prony 0.1 1 cohesion jkr 1", "without cohesion"),
        (f"{HERTZ} friction 0.3 loss prony 0.1 1 loss_tangential 1", "does not have"),
        (f"{HERTZ} loss prony 0.1 1 loss time 1e-6", "given twice"),
    ],
)  # fmt: skip
def test_wrong_words(lammps, words, message):
    with pytest.raises(Exception, match=message):
        spheres(lammps, words)
