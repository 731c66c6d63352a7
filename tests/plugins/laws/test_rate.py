"""Yield strength that grows with the strain rate: closed forms, energy, passivity, walls,
processors, and no effect at zero rate sensitivity.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from granwave.analysis.contact_law.curves import law_table, restitution
from tests.conftest import script_of
from tests.helpers.bodies.rubbing import same, state
from tests.helpers.bodies.two_spheres import BOX, PAIR, R, collide, value
from tests.helpers.bodies.two_spheres import restitution as restitution_of

BODY = {
    "youngs_modulus": 200e9,
    "poisson_ratio": 0.29,
    "yield_strength": 792e6,
    "rate_sensitivity": 0.014,
}  # 4340 steel
LAWS = ["elastoplastic", "elastoplastic-fe", "thornton"]
STEEL = "elastoplastic 200e9 0.29 792e6"
RATE = "rate 0.014 1"
HEADS_ON = [(0, 0, 5.0), (0, 0, -5.0)]


def contact(name="elastoplastic", radius=(R, R), second=None, **changes):
    first = BODY | changes
    second = first if second is None else second
    return ContactLaw(
        name, radius=radius, **{key: (value, second.get(key, 1.0)) for key, value in first.items()}
    )


def work_of(overlap, force):
    return np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(overlap))])


@pytest.mark.parametrize(
    ("partner", "share"),
    [(None, 0.5), ({"youngs_modulus": math.inf, "yield_strength": math.inf}, 1.0)],
)
def test_factor_of_johnson_and_cook_at_the_strain_rate_of_tabor(partner, share):
    law = contact(
        second=partner and BODY | partner,
        radius=(R, math.inf) if partner else (R, R),
        reference_rate=3.0,
    )
    overlap = np.geomspace(1, 200, 9) * law.yield_overlap
    velocity = 10.0
    step = 1e-6 * overlap  # strain 0.2 a/R* with a^2 = 2 R* alpha, of each body its share
    strain = [
        0.2 * share * np.sqrt(2 * at * law.effective_radius) / law.effective_radius
        for at in (overlap - step, overlap + step)
    ]
    rate = (strain[1] - strain[0]) / (2 * step) * velocity
    np.testing.assert_allclose(
        law.rate_factor(overlap, velocity), 1 + 0.014 * np.log(rate / 3.0), rtol=1e-8
    )
    assert law.rate_factor(overlap[0], 1e-9) == law.rate_factor(overlap[0], -1.0) == 1.0


def test_the_softer_body_decides():
    soft = BODY
    hard = BODY | {"yield_strength": 2e9, "rate_sensitivity": 0.05}
    for first, second in ((soft, hard), (hard, soft)):
        law = contact(second=second, **first)
        assert law.rate_sensitivity == 0.014
    assert contact(rate_sensitivity=0.0, second=hard).rate_sensitivity == 0.0


@pytest.mark.parametrize("name", LAWS)
def test_loading_at_one_velocity_is_the_law_of_the_stronger_material(name):
    hardening = {"hardening": 0.02} if name == "elastoplastic-fe" else {}
    law = contact(name, **hardening)
    overlap = np.linspace(0, 150, 3001) * law.yield_overlap
    found = law.follow(overlap, overlap / 10.0)
    for at in (40, 300, 3000):
        factor = float(law.rate_factor(overlap[at], 10.0))
        assert found["rate_factor"][at] == pytest.approx(factor, rel=1e-12) and factor > 1.05
        plastic = factor * 0.02 / 0.98  # hardening modulus / E, which grows by the same factor
        harder = {"hardening": plastic / (1 + plastic)} if hardening else {}
        same_law = contact(name, yield_strength=factor * 792e6, rate_sensitivity=0.0, **harder)
        assert found["force"][at] == pytest.approx(
            float(same_law.loading_force(overlap[at])), rel=1e-9
        )


@pytest.mark.parametrize("name", LAWS)
def test_slow_contacts_and_no_sensitivity_are_the_law_without(name):
    law = contact(name)
    plain = contact(name, rate_sensitivity=0.0)
    overlap = (
        np.concatenate([np.linspace(0, 60, 2001), np.linspace(60, 0, 2001)[1:]]) * law.yield_overlap
    )
    time = np.arange(len(overlap)) * 1.0
    slow = law.follow(overlap, time)
    none = plain.follow(overlap, 1e-9 * time)
    most = none["dissipated_energy"].max()
    np.testing.assert_allclose(slow["force"], none["force"], rtol=1e-12)
    np.testing.assert_allclose(
        slow["dissipated_energy"], none["dissipated_energy"], atol=1e-6 * most
    )
    assert np.array_equal(none["force"][:2001], plain.loading_force(overlap[:2001]))
    np.testing.assert_array_equal(law.loading_force(overlap), plain.loading_force(overlap))


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("seed", range(3))
def test_no_history_gives_back_more_than_it_took(name, seed):
    """Random turns at random velocities: work = stored + dissipated, dissipation never falls, the
    force has no jumps.
    """
    law = contact(name, rate_sensitivity=0.05)
    rng = np.random.default_rng(seed)
    turns = rng.uniform(0, 120, 16) * law.yield_overlap
    turns[0] = 0.0
    overlap = [0.0]
    time = [0.0]
    speeds = 10 ** rng.uniform(-4, 2.5, 15)
    speeds[0] = 10.0
    for start, end, speed in zip(turns[:-1], turns[1:], speeds, strict=True):
        way = np.linspace(start, end, 3001)[1:]
        time += list(time[-1] + np.abs(way - start) / speed)
        overlap += list(way)
    found = law.follow(np.array(overlap), np.array(time))
    force = found["force"]
    lost = found["dissipated_energy"]
    stored = found["elastic_energy"]
    work = work_of(np.array(overlap), force)
    assert np.abs(work - stored - lost).max() < 1e-6 * work.max()
    assert np.all(np.diff(lost) >= 0) and np.all(stored >= 0)
    assert np.abs(np.diff(force)).max() < 0.02 * force.max()
    assert found["rate_factor"].max() > 1.1


def test_a_faster_blow_meets_the_faster_curve_and_a_slower_one_yields_at_the_old_force():
    law = contact()
    unit = contact().yield_overlap
    first = np.linspace(0, 40, 4001)[:-1] * unit
    second = np.linspace(40, 80, 4001) * unit
    for slow, fast in ((1e-3, 30.0), (30.0, 1e-3)):
        time = np.concatenate([first / slow, first[-1] / slow + (second - first[-1]) / fast])
        found = law.follow(np.concatenate([first, second]), time)
        alone = law.follow(second, np.concatenate([[0.0], (second[1:] - second[0]) / fast]))
        assert found["force"][-1] == pytest.approx(
            alone["force"][-1], rel=1e-6
        )  # the old rate is forgotten
        assert np.all(np.diff(found["force"]) >= -1e-9)
        after = found["force"][4000:4100] / found["force"][3999] - 1
        assert np.abs(after).max() < (1e-6 if fast < slow else 0.2)


@pytest.mark.parametrize("law", [STEEL, STEEL.replace("plastic", "plastic-fe")])
def test_balance_of_a_collision_and_its_restitution(lammps, law):
    """The run agrees with an integration of the law; at the same speed the bodies rebound faster
    than without rate dependence.
    """
    speed = 10.0
    lmp = lammps()
    before = 8500 * 4 / 3 * math.pi * R**3 * speed**2 / 4
    rebound = {}
    for words in ("", f" {RATE}"):
        collide(lmp, speed, 9000, style=law + words, extra="comm_modify vel yes")
        assert value(lmp, "c_ke+pe+c_ep[1]") == pytest.approx(before, rel=1e-6)
        rebound[words] = restitution_of(lmp, speed)
        lmp.command("clear")
    expected = contact(law.split()[0]).collide(8500 * 2 / 3 * math.pi * R**3, speed, steps=4000)
    assert rebound[f" {RATE}"] == pytest.approx(expected["restitution"], rel=1e-3)
    assert 1.02 < rebound[f" {RATE}"] / rebound[""] < 1.15


def test_a_wall_is_a_flat_face(lammps):
    """A sphere that hits a hard wall three times, and a sphere that hits the face of a heavy body."""
    hard = "400e9 0.3 INF"
    words = f"{STEEL} {hard} {RATE} 0 1"
    wall = f"fix floor all wall/gran/hysteretic zplane NULL {R:.17g} {words}"
    face = [
        f"pair_coeff 1 1 {STEEL} {RATE}",
        f"pair_coeff 2 2 {STEEL} {RATE}",
        f"pair_coeff 1 2 {words}",
    ]
    sphere = {"velocities": [(0, 0, 3.0)], "box": BOX}
    top = "comm_modify vel yes\n"
    one = lammps(
        script_of(
            [(0, 0, 0)],
            extra=f"{top}{wall}\nthermo_style custom step f_floor f_floor[*]",
            style=STEEL,
            **sphere,
        )
    )
    two = lammps(script_of([(0, 0, 0), (0, 0, R)], radius=[R, 0.0], types=[1, 2], coefficients=face,
                           extra=f"{top}group face type 2\nfix hold face setforce 0 0 0", **sphere))  # fmt: skip
    for speed in (1.0, 20.0, 30.0):
        for lmp in (one, two):
            lmp.commands_string(f"set atom 1 z 0 vz {speed}\nrun 3000")
        assert value(one, "vz[1]") == pytest.approx(value(two, "vz[1]"), rel=1e-9)
        assert value(one, "f_floor[5]") == pytest.approx(value(two, "c_ep[1]"), rel=1e-9)
        assert value(one, "vz[1]") < 0


def test_no_sensitivity_has_the_bits_of_none(lammps):
    """With 0 the law is the rate-independent law, whether the keyword is present or not; `newton
    on` for bonds has no effect.
    """
    runs = []
    for words, newton in (
        ("", "off"),
        (" rate 0 1", "off"),
        (f" {RATE}", "off"),
        (f" {RATE}", "off on"),
    ):
        text = script_of(
            PAIR, velocities=HEADS_ON, style=STEEL + words, extra="comm_modify vel yes"
        )
        runs.append(
            state(lammps(text.replace("newton off", f"newton {newton}") + "run 6000"), "x", "v")
        )
    same(runs[0], runs[1])
    same(runs[2], runs[3])
    assert not np.array_equal(runs[0]["v"], runs[2]["v"])


def test_a_dent_that_was_given_yields_on_at_the_rate(lammps, tmp_path):
    """An initial indentation has the force of a slow impact; the balance closes when a faster
    impact deepens it.
    """
    dent = 20 * contact().yield_overlap
    (tmp_path / "dents.txt").write_text(f"1 2 {dent:.17g}")
    reports = "compute en all gran/hysteretic/energy\nthermo_style custom step c_ke c_en c_en[*]"
    lmp = lammps(script_of([(0, 0, 0), (0, 0, 2 * R - 0.9 * dent)], velocities=HEADS_ON, style=f"{STEEL} {RATE}",
                           extra=f"comm_modify vel yes\n{reports}\ngran/dents read {tmp_path}/dents.txt"))  # fmt: skip
    lmp.command("run 0")
    start = value(lmp, "c_ke+c_en+c_en[1]")
    lmp.command("run 9000")
    assert value(lmp, "c_ke+c_en+c_en[1]") == pytest.approx(start, rel=2e-6)
    assert value(lmp, "c_en[1]") > 0.3 * start


def test_curves_at_a_velocity():
    law = contact()
    slow = law_table(law)
    fast = law_table(law, velocity=10.0)
    for table, expected in ((slow, law.loading_force), (fast, None)):
        rows = table["branch"] == "loading"
        if expected:
            np.testing.assert_array_equal(
                table["force_N"][rows], expected(table["overlap_m"][rows])
            )
        else:
            assert table["force_N"][rows][-1] > 1.05 * law.loading_force(
                table["overlap_m"][rows][-1]
            )
            down = table["force_N"][table["branch"] == "unloading_4"]
            assert (
                down[0] == table["force_N"][rows][-1]
                and down[-1] == 0
                and np.all(np.diff(down) <= 0)
            )
    velocity, faster = restitution(law, 0.002)
    gain = faster / np.interp(velocity, *restitution(contact(rate_sensitivity=0.0), 0.002))
    assert np.all(gain[velocity > 1] > 1) and gain[-1] > 1.03
