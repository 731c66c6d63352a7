"""Cohesion after JKR and DMT: closed forms, an independent curve, rebound, LAMMPS's own style,
energy, processors, walls.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of
from tests.helpers.bodies.rubbing import HERTZ, MU, NU, TOTAL, E, R, oblique, rubbing, state
from tests.helpers.bodies.two_spheres import value

W = 100.0  # J/m^2: large, so that it counts in impacts of spheres of 10 mm
WHOLE = f"{TOTAL}+c_en[9]+c_en[10]+c_en[11]+c_en[12]+c_en[8]+c_en[13]"
MASS = 8500 * 4 / 3 * np.pi * R**3
JKR = f"{HERTZ} cohesion jkr {W}"
DMT = f"{HERTZ} cohesion dmt {W}"
LAWS = ("hertz", "elastoplastic", "elastoplastic-fe", "bilinear", "thornton")


def law(name="hertz", kind="jkr", radius=(R, R), energy=W, **others) -> ContactLaw:
    return ContactLaw(name, youngs_modulus=(E, E), poisson_ratio=(NU, NU), yield_strength=(550e6, 550e6), radius=radius,
                      cohesion=(kind, energy), **others)  # fmt: skip


def jkr_twin(contact: ContactLaw, overlap: float) -> tuple[float, float]:
    """Force and radius of the contact circle on the stable branch, by bisection of the overlap as a
    function of the radius.
    """
    radius = contact.effective_radius
    modulus = contact.effective_modulus
    least = (np.pi * W * radius**2 / (8 * modulus)) ** (1 / 3)
    a = brentq(
        lambda a: a**2 / radius - np.sqrt(2 * np.pi * W * a / modulus) - overlap,
        least,
        radius,
        xtol=1e-18,
    )
    return 4 * modulus * a**3 / (3 * radius) - np.sqrt(8 * np.pi * W * modulus) * a**1.5, a


def lost_in_a_cycle(contact: ContactLaw) -> float:
    """Energy dissipated when surfaces touch and separate, after Thornton and Ning: 7.09 (w^5
    R*^4/E*^2)^(1/3).
    """
    factor = (4.8 * 4 ** (4 / 3) + 3.2) * (np.pi / 8) ** (5 / 3)
    return factor * (W**5 * contact.effective_radius**4 / contact.effective_modulus**2) ** (1 / 3)


@pytest.mark.parametrize("radius", [(R, R), (R, 0.3 * R), (R, np.inf)])
def test_pull_off_balance_and_curve_of_jkr(radius):
    contact = law(radius=radius)
    rs = contact.effective_radius
    es = contact.effective_modulus
    circle = (9 * np.pi * W * rs**2 / (2 * es)) ** (1 / 3)  # without force
    least = (np.pi * W * rs**2 / (8 * es)) ** (1 / 3)
    assert contact.pull_off_force == pytest.approx(1.5 * np.pi * W * rs)
    assert contact.balanced_overlap == pytest.approx(circle**2 / (3 * rs), rel=1e-12)
    assert contact.contact_radius(contact.balanced_overlap, 1e-6) == pytest.approx(
        circle, rel=1e-12
    )
    assert contact.neck_length == pytest.approx(3 * least**2 / rs, rel=1e-12)
    overlap = np.linspace(-0.999999 * contact.neck_length, 4 * contact.balanced_overlap, 301)
    expected = np.array([jkr_twin(contact, one) for one in overlap])
    force = contact.force(overlap, overlap[-1])
    assert force == pytest.approx(expected[:, 0], abs=1e-9 * contact.pull_off_force)
    assert contact.contact_radius(overlap, overlap[-1]) == pytest.approx(expected[:, 1], rel=1e-9)
    assert force.min() == pytest.approx(-contact.pull_off_force, rel=1e-4)
    assert force[0] == pytest.approx(-5 / 9 * contact.pull_off_force, rel=1e-2)
    assert contact.force(0.0, 1e-6) == pytest.approx(-8 / 9 * contact.pull_off_force)
    assert contact.force(-1.001 * contact.neck_length, 1e-6) == 0.0
    assert contact.force(-0.5 * contact.neck_length, 0.0) == 0.0  # surfaces that have not met
    step = 1e-6 * contact.balanced_overlap
    inside = overlap[1:]
    energy = [contact.elastic_energy(inside + sign * step, 1e-6) for sign in (-1, 1)]
    assert (energy[1] - energy[0]) / (2 * step) == pytest.approx(
        force[1:], abs=2e-3 * contact.pull_off_force
    )
    slope = (
        contact.force(overlap[60:] + step, 1e-5) - contact.force(overlap[60:] - step, 1e-5)
    ) / (2 * step)
    assert contact.tangent_stiffness(overlap[60:], 1e-5) == pytest.approx(
        slope, rel=1e-5, abs=1e-5 * abs(slope).max()
    )


@pytest.mark.parametrize("name", LAWS)
def test_pull_off_and_balance_of_dmt(name):
    contact = law(name, "dmt")
    bare = law(name, "dmt", energy=0.0)
    pull = 2 * np.pi * W * contact.effective_radius
    assert contact.pull_off_force == pytest.approx(pull)
    small = 0.5 * min(contact.balanced_overlap, contact.yield_overlap)
    assert contact.force(small, small) == pytest.approx(bare.force(small, small) - pull, rel=1e-9)
    balanced = contact.balanced_overlap
    assert contact.force(balanced, balanced) == pytest.approx(0.0, abs=1e-9 * pull)
    if name == "hertz":
        assert balanced == pytest.approx(
            (pull / (4 / 3 * contact.effective_modulus * contact.effective_radius**0.5)) ** (2 / 3)
        )


@pytest.mark.parametrize("name", LAWS)
def test_the_pull_of_a_dent_is_that_of_its_radius(name):
    """Below the peak the pull is 2 pi w R_p, R_p = a^2 / elastic part of the overlap."""
    contact = law(name, "dmt")
    bare = law(name, "dmt", energy=0.0)
    peak = 30 * contact.yield_overlap
    residual = float(bare.residual_overlap(peak))
    overlap = residual + (peak - residual) * np.array([0.01, 0.3, 0.99])
    radius = float(bare.contact_radius(peak, peak)) ** 2 / (peak - residual)
    assert bare.force(overlap, peak) - contact.force(overlap, peak) == pytest.approx(
        2 * np.pi * W * radius, rel=1e-9
    )
    assert contact.force(0.999 * residual, peak) == 0.0


@pytest.mark.parametrize(("name", "kind"), [(name, "dmt") for name in LAWS] + [("hertz", "jkr")])
def test_no_cycle_gives_energy(name, kind):
    """On random paths work minus stored energy is the dissipation of the law, and with JKR of the
    jumps.
    """
    contact = law(name, kind)
    bare = law(name, "dmt", energy=0.0)
    rng = np.random.default_rng(5)
    largest = 8 * (contact.yield_overlap if kind == "dmt" else contact.balanced_overlap)
    turns = np.concatenate([[0.0], rng.uniform(0.05 * (kind == "dmt"), 1, 12) * largest, [0.0]])
    peak = 0.0
    work = 0.0
    lost = 0.0
    for first, last in itertools.pairwise(turns):
        path = first + (last - first) * np.linspace(0, 1, 4001)
        peaks = np.maximum(np.maximum.accumulate(path), peak)
        middle = (path[1:] + path[:-1]) / 2
        force = contact.force(middle, np.maximum(peaks[:-1], middle))
        work += float((force * np.diff(path)).sum())
        peak = float(peaks[-1])
        start = float(contact.elastic_energy(0.0, 1e-30)) if kind == "jkr" else 0.0
        stored = float(contact.elastic_energy(path[-1], peak)) - start
        now = float(bare.dissipated_energy(peak)) if name != "hertz" else 0.0
        scale = abs(stored) + float(bare.loading_work(peak))
        assert work - stored == pytest.approx(now, abs=2e-4 * scale)
        assert now >= lost - 1e-12 * scale
        lost = now


def head_on(lammps, text: str, speed: float, step=1e-8, gap=1e-7, time=2e-4):
    """Two spheres that approach each other; returns LAMMPS and the largest error of the ledger /
    input.
    """
    lmp = lammps(
        rubbing(
            [(0, 0, -gap), (0, 0, 2 * R + gap)],
            text,
            velocities=[(0, 0, speed / 2), (0, 0, -speed / 2)],
        )
    )
    lmp.command(f"timestep {step}")
    lmp.command("run 0 post no")
    start = value(lmp, WHOLE)
    worst = 0.0
    for _ in range(10):
        lmp.command(f"run {round(time / 10 / step)} post no")
        worst = max(worst, abs(value(lmp, WHOLE) / start - 1))
    return lmp, worst


def rebound(lmp) -> float:
    return value(lmp, "vz[2]") - value(lmp, "vz[1]")


@pytest.mark.parametrize("factor", [0.9, 1.05, 1.5, 4.0])
def test_spheres_stick_below_a_velocity(lammps, factor):
    """The energy m* v_s^2/2 is dissipated when spheres touch and separate: they stick below v_s,
    and above it e^2 = 1 - (v_s/v)^2.
    """
    contact = law()
    loss = lost_in_a_cycle(contact)
    speed = factor * np.sqrt(2 * loss / (MASS / 2))
    lmp, worst = head_on(lammps, JKR, speed)
    assert worst < 1e-6
    found = contact.collide(MASS / 2, speed)["restitution"]
    if factor < 1:
        assert value(lmp, "c_en") < 0 and found == 0.0
        meets = -float(contact.elastic_energy(0.0, 1e-30))
        assert value(lmp, "c_en[13]") == pytest.approx(meets, rel=1e-4)
        return
    assert rebound(lmp) / speed == pytest.approx(np.sqrt(1 - factor**-2), abs=1e-4)
    assert found == pytest.approx(np.sqrt(1 - factor**-2), abs=1e-3)
    assert value(lmp, "c_en[13]") == pytest.approx(loss, rel=1e-4)
    assert value(lmp, "c_en") == 0.0


def test_dmt_gives_all_back(lammps):
    lmp, worst = head_on(lammps, DMT, 0.02)
    assert worst < 1e-6
    assert rebound(lmp) / 0.02 == pytest.approx(1.0, abs=1e-6)
    assert value(lmp, "c_en[13]") == 0.0


def test_the_jumps_are_of_second_order(lammps):
    """A tenth of the timestep gives a hundredth of the errors of the energy balance and of the
    adhesive dissipation.
    """
    for text in (JKR, DMT):
        coarse, fine = (head_on(lammps, text, 0.03, step=step)[1] for step in (1e-7, 1e-8))
        assert fine < 0.04 * coarse


@pytest.mark.parametrize(
    ("words", "name"), [("dmt", "elastoplastic"), ("dmt", "elastoplastic-fe"), ("dmt", "thornton")]
)
def test_yielding_spheres_lose_what_their_law_loses(lammps, words, name):
    lmp, worst = head_on(
        lammps, f"{name} {E} {NU} 550e6 cohesion {words} 1.0", 2.0, step=5e-9, time=8e-5
    )
    assert worst < 1e-6
    contact = law(name, "dmt", energy=1.0)
    assert rebound(lmp) / 2.0 == pytest.approx(
        contact.collide(MASS / 2, 2.0)["restitution"], abs=1e-3
    )
    assert rebound(lmp) / 2.0 == pytest.approx(
        law(name, "dmt", energy=0.0).collide(MASS / 2, 2.0)["restitution"], abs=0.01
    )


@pytest.mark.parametrize("kind", ["jkr", "dmt"])
def test_as_the_style_of_lammps(lammps, kind):
    """LAMMPS's own style follows the same path for the same input; its coefficient is the energy of
    one surface. Its JKR necks break at the largest pull.
    """
    own = f"pair_style granular\npair_coeff * * {kind} {E} 0.0 {NU} {W / 2} tangential mindlin_rescale NULL 0.0 {MU} damping velocity"
    text = f"{HERTZ} cohesion {kind} {W} friction {MU}"
    options = {"normal": 0.05, "spins": [(0, 300.0, 0), (0, 0, 0)]}
    for steps in (2000, 6000):
        one = state(oblique(lammps, 0.02, steps=steps, own=own, **options), "x", "v", "omega")
        other = state(oblique(lammps, 0.02, steps=steps, law=text, **options), "x", "v", "omega")
        assert other["v"] == pytest.approx(one["v"], abs=2e-3 * 0.05)
        assert other["omega"] == pytest.approx(one["omega"], abs=3e-3 * 300.0)


@pytest.mark.parametrize("kind", ["jkr", "dmt"])
def test_friction_counts_from_the_force_and_twice_the_pull(lammps, kind):
    """A sphere in equilibrium on a plate, which slides: mu (F + 2 F_pull) decelerates it, with F =
    0.
    """
    contact = law(kind=kind, radius=(R, np.inf), energy=10.0)
    rigid = ContactLaw("hertz", youngs_modulus=(E, np.inf), poisson_ratio=(NU, 0.0), yield_strength=(1e9, 1e9),
                       radius=(R, np.inf), cohesion=(kind, 10.0))  # fmt: skip
    text = script_of(
        [(0, 0, rigid.balanced_overlap)], velocities=[(0.5, 0, 0)], box=[-0.05, 0.05] * 3,
        extra=f"comm_modify vel yes\nfix floor all wall/gran/hysteretic zplane NULL {R} {HERTZ} cohesion {kind} 10.0 friction {MU}\n"
        "fix still all setforce NULL NULL NULL\ntimestep 1e-8\nthermo_style custom step f_floor[*]\n",
    )  # fmt: skip
    lmp = lammps(text)
    lmp.command("run 2000")
    limit = MU * (2 * contact.pull_off_force)
    assert value(lmp, "-fx[1]") == pytest.approx(limit, rel=1e-6)
    assert abs(value(lmp, "fz[1]")) < 1e-6 * contact.pull_off_force


@pytest.mark.parametrize("kind", ["jkr", "dmt"])
def test_walls(lammps, kind):
    """Rebound from a rigid wall agrees with the closed form, and the energies of the wall balance."""
    contact = ContactLaw("hertz", youngs_modulus=(E, np.inf), poisson_ratio=(NU, 0.0), yield_strength=(1e9, 1e9),
                         radius=(R, np.inf), cohesion=(kind, W))  # fmt: skip
    lost = lost_in_a_cycle(contact) if kind == "jkr" else 0.0
    speed = 0.05
    text = script_of(
        [(0, 0, -1e-7)], velocities=[(0, 0, speed)], box=[-0.05, 0.05] * 3,
        extra=f"fix floor all wall/gran/hysteretic zplane NULL {R} {HERTZ} cohesion {kind} {W}\n"
        "thermo_style custom step c_ke f_floor f_floor[*]\ntimestep 1e-8\n",
    )  # fmt: skip
    lmp = lammps(text)
    lmp.command("run 0 post no")
    start = value(lmp, "c_ke")
    for _ in range(6):
        lmp.command("run 2000 post no")
        assert value(lmp, "c_ke+f_floor+f_floor[5]+f_floor[21]") == pytest.approx(start, rel=1e-6)
    assert value(lmp, "-vz[1]") == pytest.approx(np.sqrt(speed**2 - 2 * lost / MASS), rel=1e-5)
    assert value(lmp, "f_floor[21]") == pytest.approx(lost, rel=1e-4)
    assert value(lmp, "f_floor") == 0.0


def test_a_wall_is_a_sphere_of_large_radius(lammps):
    """A frozen sphere of 200 R acts like a wall of the same material: the rebounds agree to the
    ratio of the effective radii.
    """
    big = 200 * R
    speed = 0.04
    pair = lammps(
        rubbing([(0, 0, -1e-7), (0, 0, R + big)], JKR, radius=[R, big], velocities=[(0, 0, speed), (0, 0, 0)],
                extra="group big id 2\ngroup small id 1\nunfix motion\nfix motion small nve\n", box=[-2.2, 2.2] * 3)
    )  # fmt: skip
    wall = lammps(
        script_of([(0, 0, -1e-7)], velocities=[(0, 0, speed)], box=[-0.05, 0.05] * 3,
                  extra=f"fix floor all wall/gran/hysteretic zplane NULL {R} hertz {E} {NU} {E} {NU} cohesion jkr {W}\n")
    )  # fmt: skip
    for lmp in (pair, wall):
        lmp.command("run 12000 post no")
    found = [value(lmp, "vz[1]") for lmp in (pair, wall)]
    assert found[0] == pytest.approx(found[1], rel=0.01)
    assert found[0] < 0
