"""Further fixes: friction of the guide of a chain, damping layers and ends, elastic bars with a
load and their flat faces.
"""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.conftest import printed, script_of
from tests.helpers.bodies.two_spheres import BOX, MASS, R, value

MU = 0.3
G = 9.81
DENSITY = 8500.0
LAW = "hertz 115e9 0.3"
HOLDER = f"fix holder all gran/holder z {MU} {G}"


def beads(lammps, n=1, speed=0.0, extra=HOLDER, dt=1e-6, gap=0.0):
    """A chain of beads, the first with a speed; energies of the contacts, of the motion and of the
    guide.
    """
    lmp = lammps()
    places = [(0, 0, k * (0.01 + gap)) for k in range(n)]
    speeds = [(0, 0, speed)] + [(0, 0, 0)] * (n - 1)
    text = script_of(places, style=LAW, velocities=speeds, box=[-0.1, 0.1] * 3, density=DENSITY)
    lmp.commands_string(f"{text}\ntimestep {dt}\n{extra}\n")
    return lmp


@pytest.mark.parametrize("dt", [1e-6, 7e-6, 1e-4])
def test_a_sliding_bead_stops_where_it_must(lammps, dt):
    """While a bead slides, the guide dissipates its kinetic energy; after the path v^2/(2 mu g) all
    of it is dissipated, and the bead is exactly at rest.
    """
    speed = 0.05
    lmp = beads(lammps, speed=speed, dt=dt)
    sliding = round(0.01 / dt)
    lmp.command(f"run {sliding} post no")
    mass = value(lmp, "mass[1]")
    left = speed - MU * G * sliding * dt
    assert value(lmp, "vz[1]") == pytest.approx(left, rel=1e-12)
    assert value(lmp, "f_holder") == pytest.approx(0.5 * mass * (speed**2 - left**2), rel=1e-11)
    lmp.command(f"run {round(1.2 * speed / (MU * G) / dt) - sliding} post no")
    assert value(lmp, "z[1]") == pytest.approx(
        speed**2 / (2 * MU * G), rel=2 * (dt * MU * G / speed) ** 2 + 1e-12
    )
    assert value(lmp, "vz[1]") == 0.0
    assert value(lmp, "f_holder") == pytest.approx(0.5 * mass * speed**2, rel=(dt * MU * G / speed))


@pytest.mark.parametrize("share", [0.0, 0.5, 0.999, 1.5])
def test_a_pulled_bead_is_held_or_slides(lammps, share):
    """Below the limit the bead stays exactly at rest without dissipation; above, the difference
    accelerates it.
    """
    pull = "variable pull equal {share}*{MU}*{G}*mass(all)\nfix pull all addforce 0 0 v_pull\n"
    lmp = beads(lammps, extra=pull.format(share=share, MU=MU, G=G) + HOLDER)
    lmp.command("run 5000 post no")
    way = 0.5 * max(share - 1, 0) * MU * G * 5e-3**2
    assert value(lmp, "z[1]") == pytest.approx(way, rel=1e-9)
    assert value(lmp, "f_holder") == pytest.approx(MU * G * value(lmp, "mass[1]") * way, rel=1e-6)
    if share < 1:
        assert value(lmp, "z[1]") == value(lmp, "vz[1]") == value(lmp, "f_holder") == 0.0


def test_the_energy_of_a_collision_closes(lammps):
    """Three beads, one of which hits the others after a flight: kinetic energy + stored energy +
    dissipation of the guide = input.
    """
    lmp = beads(lammps, 3, speed=0.2, dt=1e-7, gap=1e-5)
    lmp.command("run 0 post no")
    for _ in range(20):
        lmp.command("run 1000 post no")
        total = value(lmp, "c_ke+pe+f_holder") / (0.5 * value(lmp, "mass[1]") * 0.2**2)
        assert total == pytest.approx(1, abs=3e-6)
    assert value(lmp, "f_holder") > 0 and value(lmp, "vz[3]") > 0.1


STEEL = "hertz 210e9 0.3"
RATE = 2e3
BEAD = 8500 * np.pi / 6 * 0.01**3


def lone(lammps, words, dt=1e-6):
    """One sphere that moves and rotates; `words` are the arguments of the fix."""
    lmp = lammps()
    text = script_of([(0, 0, 0)], style=STEEL, velocities=[(1.0, -2.0, 3.0)], box=[-0.1, 0.1] * 3)
    turning = "unfix motion\nfix motion all nve/sphere\nset atom 1 omega 100.0 0.0 -300.0"
    lmp.commands_string(
        f"{text}\n{turning}\ntimestep {dt}\nfix calm all gran/absorb {words}\ncompute turn all erotate/sphere"
    )
    return lmp


@pytest.mark.parametrize("dt", [1e-6, 4e-6])
def test_a_damped_sphere_slows_down_exponentially(lammps, dt):
    lmp = lone(lammps, f"rate {RATE}", dt)
    lmp.command("run 0 post no")
    before = value(lmp, "c_ke+c_turn")
    lmp.command(f"run {round(1e-3 / dt)} post no")
    left = np.exp(-RATE * 1e-3)
    near = 2 * (RATE * dt) ** 2
    assert value(lmp, "vz[1]") == pytest.approx(3 * left, rel=near)
    assert value(lmp, "c_turn") == pytest.approx(0.2 * BEAD * 0.005**2 * 1e5 * left**2, rel=near)
    assert value(lmp, "c_ke+c_turn+f_calm") == pytest.approx(before, rel=near)


def test_a_rate_rises_as_the_square_and_an_impedance_acts_along_its_axis(lammps):
    lmp = lone(lammps, f"rate {RATE} x -2 2")  # the sphere at 0 feels a quarter of it
    lmp.command("run 100 post no")
    assert value(lmp, "vy[1]") == pytest.approx(-2 * np.exp(-RATE / 4 * 1e-4), rel=2e-4)
    lmp = lone(lammps, f"impedance {BEAD * RATE} z")
    lmp.command("run 1000 post no")
    assert value(lmp, "vx[1]") == 1.0
    assert value(lmp, "vz[1]") == pytest.approx(3 * np.exp(-RATE * 1e-3), rel=1e-5)


def test_any_rate_is_stable(lammps):
    lmp = lone(lammps, "rate 1e9")
    lmp.command("run 50 post no")
    assert abs(value(lmp, "vz[1]")) < 3 and value(lmp, "f_calm") > 0


def bar(n, *, beads=0, load="half-sine 1000 60e-6", courant=0.05) -> tuple[str, float]:
    """Input script of a steel bar of n nodes, behind a few beads of brass, and its wave speed."""
    modulus = 200e9
    density = 7850.0
    area = 1e-4
    h = 5e-3
    mass = density * area * h
    speed = np.sqrt(modulus / density)
    top = n * h + 0.02  # the subdomains of two processors meet between beads and bar
    lines = [
        "units si\natom_style hybrid sphere bond\natom_modify map yes\nnewton off\nboundary f f f",
        f"region box block -0.02 0.02 -0.02 0.02 {-top} {top} units box\nprocessors 1 1 *",
        "create_box 2 box bond/types 1 extra/bond/per/atom 2 extra/special/per/atom 4",
        *(f"create_atoms 2 single 0 0 {k * h:.17g} units box" for k in range(n)),
        *(f"create_atoms 1 single 0 0 {-R - 2 * R * k:.17g} units box" for k in range(beads)),
        f"set type 2 diameter 0 density {mass:.17g}\nset atom 1 density {mass / 2:.17g}",
        f"set atom {n} density {mass / 2:.17g}\nset type 1 diameter {2 * R} density 8500"
        if beads
        else f"set atom {n} density {mass / 2:.17g}",
        f"group bar type 2\ngroup first id {n + beads if beads else 1}\nneighbor 1e-3 bin\ncomm_modify cutoff 0.02",
        "pair_style gran/hysteretic 5e-3\npair_coeff 1 1 elastoplastic 115e9 0.3 550e6",
        "pair_coeff 2 2 hertz 200e9 0.3\npair_coeff 1 2 elastoplastic 115e9 0.3 550e6 200e9 0.3 INF",
        f"bond_style harmonic\nbond_coeff 1 {modulus * area / h / 2:.17g} {h}",
        f"create_bonds many bar bar 1 {0.9 * h} {1.1 * h}",
        "neigh_modify exclude type 2 2 delay 0 every 1 check yes\nfix motion all nve",
        f"fix push first gran/load z force {load}\ntimestep {courant * h / speed:.17g}",
        "compute ke all ke\ncompute ep all gran/hysteretic/energy",
        "thermo_style custom step c_ke ebond c_ep c_ep[1] f_push f_push[2]\nthermo_modify norm no",
    ]
    return "\n".join(lines) + "\n", speed


def test_bar_carries_the_pulse_at_its_speed_and_keeps_the_energy(lammps):
    script, speed = bar(300)
    lmp = lammps(script)
    dt = 0.05 * 5e-3 / speed
    centres = []
    for steps in (2400, 2400):
        lmp.command(f"run {steps}")
        order = np.argsort(lmp.numpy.extract_atom("id")[:300])
        v = lmp.numpy.extract_atom("v")[order, 2]
        z = lmp.numpy.extract_atom("x")[order, 2]
        centres.append(np.sum(v**2 * z) / np.sum(v**2))
        assert value(lmp, "(c_ke+ebond)/f_push") == pytest.approx(1, rel=2e-6)
    assert (centres[1] - centres[0]) / (2400 * dt) == pytest.approx(speed, rel=0.01)
    impedance = np.sqrt(200e9 * 7850) * 1e-4
    assert v.max() == pytest.approx(1000 / impedance, rel=0.01)
    assert value(lmp, "f_push") == pytest.approx(
        1000**2 * 60e-6 / 2 / impedance, rel=0.01
    )  # integral of F^2/Z


def test_bar_goes_on_from_a_restart_on_other_processors(log_of, tmp_path):
    """Bonds, indentations, work and impulse are written by one processor during the pulse and read
    by two.
    """
    script = bar(60, beads=5, load="half-sine 5000 4e-5")[0].replace(
        "timestep", "timestep 2.4e-8\n# was"
    )
    script += "run 800\nwrite_restart r\nrun 1000\nwrite_dump all custom all.dump id x y z vx vy vz modify format float %.17g sort id\n"
    goes_on = (
        "newton off\natom_modify map yes\nprocessors 1 1 2\nread_restart r\ncomm_modify cutoff 0.02\n"
        "neigh_modify exclude type 2 2 delay 0 every 1 check yes\nfix motion all nve\n"
        "fix push first gran/load z force half-sine 5000 4e-5\nthermo_style custom step f_push f_push[2]\n"
        "run 1000\nwrite_dump all custom all.dump id x y z vx vy vz modify format float %.17g sort id\n"
    )
    found = []
    for ranks, text in ((1, script), (2, goes_on)):
        text += 'print "result $(f_push:%.15g) $(f_push[2]:%.15g) $(f_push[3]:%.15g)"\n'
        result = [float(word) for word in printed(log_of(text, ranks), "result")]
        found.append(((tmp_path / "all.dump").read_text(), result))
    assert found[0][0] == found[1][0]
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-13)


def on_a_face(
    lmp, face_mass=1e12, law="elastoplastic 115e9 0.3 550e6 210e9 0.3 INF", speed=2.0, steps=20000
):
    """A sphere that hits a particle of radius 0."""
    laws = ["pair_coeff 1 1 hertz 1e9 0.3", "pair_coeff 2 2 hertz 1e9 0.3", f"pair_coeff 1 2 {law}"]
    extra = f"set atom 2 density {face_mass}\ncompute end all gran/hysteretic/contact 1 2\ncompute atoms all gran/hysteretic/atom\n"
    extra += "thermo_style custom step c_ke pe c_ep[1] c_ep[2] c_ep[4] c_end[3]\n"
    spheres = {"radius": [R, 0.0], "types": [1, 2], "velocities": [(0, 0, speed)]}
    lmp.commands_string(
        script_of([(0, 0, 0), (0, 0, R)], **spheres, coefficients=laws, box=BOX, extra=extra)
    )
    lmp.command(f"run {steps}")
    return lmp


@pytest.mark.parametrize("law", ["elastoplastic", "thornton", "bilinear"])
@pytest.mark.parametrize("strengths", [(550e6, np.inf), (np.inf, 550e6), (550e6, 700e6)])
def test_face_and_wall_are_the_plane_of_the_law(lammps, law, strengths):
    """Heavy face of radius 0, wall of the same material and closed form for R2 = infinity agree."""
    first, second = ("INF" if np.isinf(s) else f"{s}" for s in strengths)
    words = f"{law} 115e9 0.3 {first} 210e9 0.3 {second}"
    face = on_a_face(lammps(), law=words)
    wall = lammps()
    fix = f"fix floor all wall/gran/hysteretic zplane NULL {R} {words}\nthermo_style custom step f_floor[5] c_ke\n"
    wall.commands_string(script_of([(0, 0, 0)], velocities=[(0, 0, 2.0)], box=BOX, extra=fix))
    wall.command("run 20000")
    closed = ContactLaw(
        law,
        youngs_modulus=(115e9, 210e9),
        poisson_ratio=(0.3, 0.3),
        yield_strength=strengths,
        radius=(R, np.inf),
    )
    peak = wall.numpy.extract_fix("floor", 1, 2)[0, 2]
    assert closed.loading_work(peak) == pytest.approx(0.5 * MASS * 4, rel=1e-5)
    assert value(wall, "f_floor[5]") == pytest.approx(closed.dissipated_energy(peak), rel=1e-12)
    assert value(face, "c_end[3]") == pytest.approx(peak, rel=1e-9)
    assert value(face, "c_ep[1]") == pytest.approx(closed.dissipated_energy(peak), rel=1e-9)
    assert value(face, "vz[1]") == pytest.approx(value(wall, "vz[1]"), rel=1e-9)
    assert face.numpy.extract_compute("atoms", 1, 2)[:2, 3] == pytest.approx(
        np.array([closed.share_of_first, 1 - closed.share_of_first]) * value(face, "c_ep[1]")
    )


def test_forgotten_dent_in_a_face_stays_in_the_account(lammps):
    lmp = on_a_face(lammps(), steps=1000)
    lmp.command("run 19000")
    lost = value(lmp, "c_ep[1]")
    lmp.command("run 200000")  # far beyond the gap
    assert value(lmp, "z[2]-z[1]") > R + 1e-3
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)


def test_faces_never_touch_and_fall_through_no_wall(lammps):
    bodies = {
        "radius": [0.0, 0.0, R],
        "types": [1, 1, 2],
        "velocities": [(0, 0, 50.0), (0, 0, -50.0)],
        "box": BOX,
    }
    floor = "fix floor all wall/gran/hysteretic zplane -1e-6 NULL hertz 1e9 0.3"
    lmp = lammps(script_of([(0, 0, 0), (0, 0, 1e-4), (0, 0, 0.02)], **bodies, extra=floor))
    lmp.command("run 2000")
    assert value(lmp, "vz[1]") == 50 and value(lmp, "vz[2]") == -50 and value(lmp, "c_ep[5]") == 0
