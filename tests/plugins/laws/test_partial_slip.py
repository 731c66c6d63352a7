"""Partial slip: Mindlin's curve and loops, Mindlin and Deresiewicz's loading, energy, impacts
compared with an independent solver.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, NU, TOTAL, E, R, oblique, rubbing, state
from tests.helpers.bodies.two_spheres import value
from tests.helpers.twins.slip_twin import forces, rebound

LAW = ContactLaw(
    "hertz",
    youngs_modulus=(E, np.inf),
    poisson_ratio=(NU, 0),
    yield_strength=(np.inf,) * 2,
    radius=(R, np.inf),
)
PARTIAL = f"friction {MU} tangential partial_slip"
OVERLAPS = [
    1e-7,
    3.3e-7,
    1e-6,
    2.1e-6,
    4.5e-6,
    1e-5,
    1e-4,
]  # circles fill their reach to different parts


def path(overlap, slip, friction=MU, **options):
    """Force, stored energy and dissipation along a path in the tangent plane; one-component slips
    are along its first axis.
    """
    slip = np.asarray(slip)
    slip = np.column_stack([slip, 0 * slip]) if slip.ndim == 1 else slip
    overlap = np.broadcast_to(overlap, len(slip))
    return LAW.friction_path(overlap, slip, friction=friction, tangential="partial_slip", **options)


def constants(overlap):
    """Largest tangential force, stiffness without slip, and displacement at which all slips."""
    limit = MU * LAW.loading_force(overlap)
    stiffness = LAW.tangential_stiffness(overlap, overlap)
    return limit, stiffness, 1.5 * limit / stiffness


@pytest.mark.parametrize("overlap", OVERLAPS)
def test_mindlins_curve(overlap):
    """T = mu N (1 - (1 - d/d_max)^(3/2)), with the initial slope 8 G* a, to 0.35 % of mu N; and
    sliding.
    """
    limit, stiffness, whole = constants(overlap)
    moved = np.linspace(0, 1.2 * whole, 1200)[1:]
    found = -path(overlap, np.full(len(moved), moved[0]))["force"][:, 0]
    exact = limit * (1 - np.maximum(1 - moved / whole, 0) ** 1.5)
    assert found[0] == pytest.approx(
        stiffness * moved[0], rel=1e-3
    )  # the outermost cell may slip already
    assert found[-1] == pytest.approx(limit, rel=1e-12)
    assert np.abs(found - exact).max() < 3.5e-3 * limit


def test_more_cells_follow_the_curve_better():
    """Twice as many cells give a quarter of the error."""
    limit, _, whole = constants(1e-6)
    moved = np.linspace(0, whole, 4000)[1:]
    exact = limit * (1 - np.maximum(1 - moved / whole, 0) ** 1.5)
    errors = [
        np.abs(-path(1e-6, np.full(len(moved), moved[0]), cells=n)["force"][:, 0] - exact).max()
        for n in (8, 16, 32)
    ]
    assert errors[0] / errors[1] == pytest.approx(4, abs=1)
    assert errors[1] / errors[2] == pytest.approx(4, abs=1)


@pytest.mark.parametrize(("part", "margin"), [(0.2, 0.4), (0.4, 0.08), (0.6, 0.04), (0.8, 0.01)])
def test_loss_of_a_cycle(part, margin):
    """Mindlin and Deresiewicz's loop between -T and T at a constant normal force; for small T it is
    2/9 T^3/(mu N k).
    """
    for overlap in OVERLAPS:
        assert cycle(part, overlap) == pytest.approx(1, abs=margin)


def cycle(part, overlap):
    """Dissipation of a cycle / exact dissipation."""
    limit, _, whole = constants(overlap)
    reach = whole * (1 - (1 - part) ** (2 / 3))
    step = reach / 300
    moves = np.concatenate([np.full(300, step), np.tile(np.repeat([-step, step], 600), 2)])
    found = path(overlap, moves)
    loss = found["loss"][-1] - found["loss"][-1201]
    assert found["force"][-1] == pytest.approx(
        found["force"][-1201], abs=1e-9 * limit
    )  # the loop closes
    return loss / (
        4
        * whole
        * limit
        * (1.2 * (1 - (1 - part) ** (5 / 3)) - part - part * (1 - part) ** (2 / 3))
    )


@pytest.mark.parametrize("part", [0.3, 0.9])
def test_in_proportion_to_the_normal_force_nothing_slips(part):
    """T/N constant below mu: elastic, T = (2/3) k d on the way up and down, as Mindlin and
    Deresiewicz derived.
    """
    up = np.linspace(0, 1e-5, 2001)[1:]
    overlap = np.concatenate([up, up[::-1][1:]])
    per_overlap = (
        part * MU * 2 * LAW.effective_modulus / (8 * LAW.shear_modulus)
    )  # slip over overlap
    found = path(overlap, np.diff(overlap, prepend=0.0) * per_overlap)
    force = -found["force"][:, 0]
    exact = part * MU * LAW.loading_force(overlap)
    assert np.abs(force - exact).max() < 5e-3 * exact.max()
    assert found["loss"][-1] < 5e-3 * found["stored_energy"].max()
    assert found["stored_energy"].max() == pytest.approx(
        0.4 * exact.max() * up[-1] * per_overlap, rel=5e-3
    )


def test_beyond_the_coefficient_all_slips():
    overlap = np.linspace(0, 1e-5, 2001)[1:]
    found = path(
        overlap,
        np.full(2000, 1.5 * MU * 2 * LAW.effective_modulus / (8 * LAW.shear_modulus) * overlap[0]),
    )
    assert -found["force"][:, 0] == pytest.approx(MU * LAW.loading_force(overlap), rel=1e-6)


@pytest.mark.parametrize("law", ["hertz", "elastoplastic"])
@pytest.mark.parametrize("seed", range(4))
def test_random_cycles_are_passive(law, seed):
    """Random overlaps and slips, with separations: no dissipation is negative, and the energy
    balance closes.
    """
    rng = np.random.default_rng(seed)
    n = 20000
    steps = np.repeat(rng.normal(size=(n // 100, 3)), 100, axis=0) + 0.3 * rng.normal(size=(n, 3))
    overlap = 4e-6 * np.sin(np.cumsum(steps[:, 2]) / 60) + 2e-6
    slip = steps[:, :2] * constants(2e-6)[2] / 50
    contact = LAW if law == "hertz" else ContactLaw(
        youngs_modulus=(E, np.inf), poisson_ratio=(NU, 0), yield_strength=(550e6, np.inf), radius=(R, np.inf)
    )  # fmt: skip
    found = contact.friction_path(overlap, slip, friction=MU, tangential="partial_slip")
    force = found["force"]
    loss = found["loss"]
    stored = found["stored_energy"]
    peak = np.maximum.accumulate(overlap)
    normal = contact.force(np.maximum(overlap, 0), np.maximum(peak, 1e-12)) * (overlap > 0)
    assert np.all(np.linalg.norm(force, axis=1) <= MU * normal * (1 + 1e-12) + 1e-12)
    before = np.vstack([[0, 0], force[:-1]])
    work = -np.cumsum(np.where(normal > 0, 0.5 * np.sum((before + force) * slip, axis=1), 0.0))
    assert np.all(np.diff(loss, prepend=0) >= 0)
    assert np.all(stored >= 0) and stored.max() > 0
    assert stored + loss == pytest.approx(work, rel=1e-6, abs=1e-7 * loss[-1])
    assert (overlap < 0).any()


@pytest.mark.parametrize("seed", range(4))
def test_any_path_is_that_of_many_springs(seed):
    """Both forces vary, and slips rotate in the plane; the steps are so small that both solvers
    agree.
    """
    rng = np.random.default_rng(seed)
    steps = np.repeat(rng.normal(size=(40, 3)), 100, axis=0)
    overlap = 2e-6 + 2.5e-6 * np.sin(np.cumsum(steps[:, 2]) / 80)
    slip = steps[:, :2] * constants(2e-6)[2] / 60
    ours = path(overlap, slip)["force"]
    theirs = forces(
        overlap,
        slip,
        modulus=LAW.effective_modulus,
        shear=4 * LAW.shear_modulus,
        radius=R,
        friction=MU,
    )
    size = MU * LAW.loading_force(overlap.max())
    assert np.abs(ours - theirs).max() < 0.015 * size
    assert np.sqrt(np.mean((ours - theirs) ** 2)) < 0.003 * size
    assert np.abs(theirs).max() > 0.5 * size


# ---------------------------------------------------------------------- impacts


def impact(lammps, degrees, law=f"{HERTZ} {PARTIAL}", speed=1.0, wall=True, steps=3000):
    """Spin and rebound angle of the surface, for a sphere that hits a rigid wall or an equal
    sphere.
    """
    normal = speed * np.cos(np.radians(degrees))
    across = speed * np.sin(np.radians(degrees))
    floor = f"fix floor all wall/gran/hysteretic zplane NULL {R:.17g} {law}\n" if wall else ""
    places = [(0, 0, 0), (0, 0, 2 * R)]
    velocities = [(across, 0, normal), (-across, 0, -normal)]
    box = [-0.1, 0.1] * 3
    n = 2 - wall
    lmp = lammps(
        rubbing(places[:n], law, velocities=velocities[:n], box=box, extra=floor + "timestep 2e-8")
    )
    lmp.command(f"run {steps} post no")
    after = state(lmp, "v", "omega")
    vx, _, vz = after["v"][0]
    spin = after["omega"][0, 1]
    return spin, np.degrees(np.arctan2(vx + R * spin, -vz))


def twin(degrees, speed=1.0):
    normal = speed * np.cos(np.radians(degrees))
    across = speed * np.sin(np.radians(degrees))
    normal, across, spin = rebound(
        modulus=E, poisson=NU, density=8500.0, radius=R, friction=MU, normal=normal, across=across
    )
    return spin, np.degrees(np.arctan2(across + R * spin, normal))


@pytest.mark.parametrize("degrees", [2, 5, 10, 20, 30, 40, 50, 60])
def test_oblique_impacts(lammps, degrees):
    """Spin and angle of rebound from a wall and between equal spheres agree with the theory of Maw,
    Barber and Fawcett.
    """
    for speed, wall in ((1.0, True), (0.1, True), (0.1, False)):
        spin, angle = impact(
            lammps, degrees, speed=speed, wall=wall, steps=3000 if speed == 1 else 5000
        )
        expected, rebounds_at = twin(degrees, speed)
        assert spin == pytest.approx(expected, rel=0.012)
        assert angle == pytest.approx(
            rebounds_at, abs=0.12 if wall else 0.25
        )  # equal spheres also pass each other


def test_all_directions_are_alike(lammps):
    """Impacts on walls across x, y and z, sideways at an angle between the axes: the same spin."""
    found = []
    for axis in range(3):
        velocity = np.roll([0.1, 0.1, 1.0], axis + 1)
        at = "xyz"[axis]
        law = f"{HERTZ} {PARTIAL}"
        floor = f"fix floor all wall/gran/hysteretic {at}plane NULL {R:.17g} {law}\ntimestep 2e-8"
        lmp = lammps(
            rubbing([(0, 0, 0)], law, velocities=[velocity], box=[-0.1, 0.1] * 3, extra=floor)
        )
        lmp.command("run 3000 post no")
        found.append(np.roll(state(lmp, "omega")["omega"][0], -axis - 1))
    assert found[1] == pytest.approx(found[0], rel=1e-9, abs=1e-9)
    assert found[2] == pytest.approx(found[0], rel=1e-9, abs=1e-9)
    assert np.linalg.norm(found[0]) == pytest.approx(
        -twin(np.degrees(np.arctan(0.1 * np.sqrt(2))), np.sqrt(1.02))[0], rel=0.01
    )


def test_a_single_spring_turns_half_as_much(lammps):
    """At 5 degrees partial slip and the independent solver agree; a single Mindlin spring gives 59
    % of their spin.
    """
    single = impact(lammps, 5, f"{HERTZ} friction {MU}")[0]
    assert single / twin(5)[0] == pytest.approx(0.589, abs=0.005)


@pytest.mark.parametrize("law", [HERTZ, BRASS, f"{HERTZ} loss dashpot 0.1"])
@pytest.mark.parametrize("tangential", [0.1, 1.0, 4.0])
def test_energy_of_an_oblique_impact(lammps, law, tangential):
    lmp = oblique(lammps, tangential, law=f"{law} {PARTIAL}", steps=20000)
    assert value(lmp, "c_en") == 0 and value(lmp, "c_en[6]") == 0 and value(lmp, "c_en[7]") > 0
    assert abs(value(lmp, f"({TOTAL}+c_en[8])/v_start-1")) < 1e-6


def test_pairs_of_either_model_in_one_run(lammps):
    """Two distant collisions, of types with and without partial slip, are independent."""
    places = [(0, 0, 0), (0, 0, 2 * R), (0.05, 0, 0), (0.05, 0, 2 * R)]
    speeds = [(0.2, 0, 1), (0, 0, 0)] * 2
    single = f"{HERTZ} friction {MU}"
    found = []
    for laws in ((f"{HERTZ} {PARTIAL}", single), (single, single), (f"{HERTZ} {PARTIAL}",) * 2):
        text = rubbing(places, laws[0], velocities=speeds, types=[1, 1, 2, 2], box=[-0.1, 0.1] * 3)
        text = text.replace(
            f"pair_coeff * * {laws[0]}",
            f"pair_coeff 1 1 {laws[0]}\npair_coeff 2 2 {laws[1]}\npair_coeff 1 2 {single}",
        )
        assert "pair_coeff 2 2" in text
        lmp = lammps(text)
        lmp.command("run 8000 post no")
        found.append(state(lmp, "omega")["omega"])
    assert np.array_equal(found[0][:2], found[2][:2]) and np.array_equal(found[0][2:], found[1][2:])
    assert abs(found[0][0, 1] / found[0][2, 1] - 1) > 0.05
