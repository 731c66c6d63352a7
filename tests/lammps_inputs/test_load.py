"""Fix gran/load, flat faces and elastic bodies: impulses, work, bars, ranks, restart, messages."""

from __future__ import annotations

import re

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw, load_at
from tests.conftest import script_of
from tests.helpers.manual import PAGES, Log
from tests.helpers.two_spheres import BOX, R, value

MASS = 8500 * 4 / 3 * np.pi * R**3
REPORT = "\nthermo_style custom step c_ke pe c_ep[1] f_push f_push[1] f_push[2] f_push[3]\n"
T, A = 1.0007e-5, 100.0  # 1000.7 timesteps


def table(path, times, values):
    path.write_text(
        "# time force\n\n" + "".join(f"{t:.17g} {v:.17g}  # a row\n" for t, v in zip(times, values, strict=True))
    )
    return path


def pushed(lmp, load, positions=((0, 0, 0),), extra="", **options):
    """Free spheres with a load on all of them, or on the group in `load`."""
    group, _, rest = load.rpartition("|")
    fix = f"{extra}\nfix push {group or 'all'} gran/load z {rest}{REPORT}"
    lmp.commands_string(script_of(list(positions), box=BOX, extra=fix, **options))
    return lmp


def balance(lmp) -> float:
    """Ratio of kinetic, stored and dissipated energy to the work."""
    return value(lmp, "(c_ke+pe+c_ep[1])/f_push")


SMOOTH = {
    "harmonic": f"harmonic {A} 2e5 2e-5",
    "burst": f"burst {A} 2e5 4",
    "up-and-down": f"up-and-down {A} 2e5 3e-5",
    "sweep": f"sweep {A} 1e5 4e5 3e-5 6e-6",
    "noise": f"noise {A} 1e5 6e5 3e-5 6e-6 7",
}


def smooth_force(shape: str, time):
    """The smooth shapes, once more; noise has the same phases in any program that uses splitmix64."""
    at = np.asarray(time)
    rise = lambda since, ramp: np.where(since < ramp, np.sin(np.pi * since / (2 * ramp)) ** 2, 1.0)  # noqa: E731
    if shape == "harmonic":
        return A * rise(at, 2e-5) * np.sin(2 * np.pi * 2e5 * at)
    if shape == "burst":
        return np.where(at < 2e-5, A * np.sin(np.pi * at / 2e-5) ** 2 * np.sin(2 * np.pi * 2e5 * at), 0.0)
    inside = at < 3e-5
    if shape == "up-and-down":
        return np.where(inside, A * (1 - np.abs(2 * at / 3e-5 - 1)) * np.sin(2 * np.pi * 2e5 * at), 0.0)
    window = rise(at, 6e-6) * rise(3e-5 - at, 6e-6)
    if shape == "sweep":
        return np.where(inside, A * window * np.sin(2 * np.pi * (1e5 * at + 3e5 * at**2 / 6e-5)), 0.0)
    state, phases, mask = 7, [], 2**64 - 1
    for _ in range(3, 19):
        state = (state + 0x9E3779B97F4A7C15) & mask
        z = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
        phases.append(2 * np.pi * ((z ^ (z >> 31)) >> 11) / 2**53)
    waves = sum(np.sin(2 * np.pi * k / 3e-5 * at + phase) for k, phase in zip(range(3, 19), phases, strict=True))
    return np.where(inside, A * np.sqrt(2 / 16) * window * waves, 0.0)


@pytest.mark.parametrize("shape", SMOOTH)
def test_smooth_shapes_give_the_impulse_of_their_closed_form(lammps, shape):
    end, dt = 4e-5, 2e-8
    lmp = pushed(lammps(), f"force {SMOOTH[shape]}", extra=f"timestep {dt}")
    at = np.linspace(0.0, end, 400_001)
    due = np.trapezoid(smooth_force(shape, at), at)
    lmp.command(f"run {round(end / dt)}")
    near = {"rel": 1e-4} if shape == "harmonic" else {"rel": 1e-6, "abs": 1e-9 * A * end}  # the first goes on
    assert value(lmp, "f_push[2]") == pytest.approx(due, **near)
    assert MASS * value(lmp, "vz[1]") == pytest.approx(due, **near)
    words = SMOOTH[shape].split()
    at = np.linspace(0, 3.5e-5, 57)
    assert load_at(words[0], [float(word) for word in words[1:]], at) == pytest.approx(
        smooth_force(shape, at), abs=1e-9 * A
    )


@pytest.mark.parametrize("shape", SMOOTH)
def test_work_of_smooth_shapes(lammps, shape):
    force = pushed(lammps(), f"force {SMOOTH[shape]}", extra="timestep 1e-8")
    force.command("run 1100")
    assert balance(force) == pytest.approx(1, rel=1e-4)
    drive = f"driven|displacement {SMOOTH[shape].replace(f'{A}', '1e-6')}"
    moved = pushed(lammps(), drive, PAIR, extra=f"{DRIVEN}timestep 1e-8\n")
    moved.command("run 1700")
    assert value(moved, "z[1]") == pytest.approx(1e-6 / A * float(smooth_force(shape, 1.7e-5)), abs=1e-13)
    assert balance(moved) == pytest.approx(1, rel=1e-4)


SHAPES = {
    f"half-sine {A} {T}": 2 * A * T / np.pi,
    f"rectangle {A} {T}": A * T,
    "table {table}": 0.5 * A * T,
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("dt", [1e-8, 3.7e-7])
def test_impulse_and_work_are_exact_for_any_timestep(lammps, tmp_path, shape, dt):
    rows = table(tmp_path / "force.txt", [0, 0.3 * T, T], [0, A, 0])
    lmp = pushed(lammps(), f"force {shape.format(table=rows)}", extra=f"timestep {dt}")
    lmp.command(f"run {int(1.1 * T / dt)}")
    assert value(lmp, "f_push[1]") == 0
    assert value(lmp, "f_push[2]") == pytest.approx(SHAPES[shape], rel=1e-12)
    assert MASS * value(lmp, "vz[1]") == pytest.approx(SHAPES[shape], rel=1e-12)
    assert value(lmp, "f_push[3]") == pytest.approx(value(lmp, "z[1]"), rel=1e-12)
    assert balance(lmp) == pytest.approx(1, rel=(dt / T) ** 2)


def test_harmonic_force_in_mid_run(lammps):
    lmp = pushed(lammps(), "force harmonic 100 8e3")
    lmp.command("run 4321")
    angle = 2 * np.pi * 8e3 * 4321e-8
    assert value(lmp, "f_push[1]") == pytest.approx(100 * np.sin(angle), rel=1e-6)
    assert value(lmp, "f_push[2]") == pytest.approx(100 / (2 * np.pi * 8e3) * (1 - np.cos(angle)), rel=1e-6)
    assert balance(lmp) == pytest.approx(1, rel=1e-7)


def test_group_shares_the_force(lammps):
    two = [(0, 0, 0), (0.02, 0, 0)]
    lmp = pushed(lammps(), f"force half-sine {A} {T}", two)
    lmp.command("run 1100")
    assert value(lmp, "vz[1]") == value(lmp, "vz[2]") == pytest.approx(A * T / np.pi / MASS, rel=1e-12)
    assert balance(lmp) == pytest.approx(1, rel=1e-9)


def test_table_of_a_half_sine_is_the_half_sine(lammps, tmp_path):
    times = np.linspace(0, T, 400)
    rows = table(tmp_path / "sine.txt", times, A * np.sin(np.pi * times / T))
    sine, sampled = (pushed(lammps(), f"force {s}") for s in (f"half-sine {A} {T}", f"table {rows}"))
    for steps in (300, 900):
        for lmp in (sine, sampled):
            lmp.command(f"run {steps}")
        for what in ("f_push", "f_push[2]", "vz[1]", "z[1]"):
            assert value(sampled, what) == pytest.approx(value(sine, what), rel=2e-5), what


PAIR = [(0, 0, 0), (0, 0, 2 * R)]
DRIVEN = "group driven id 1\ngroup rest id 2\nunfix motion\nfix motion rest nve\n"
LOADS = {
    "force": ("group driven id 1\n", "driven|force half-sine 5000 3e-5"),
    "displacement": (DRIVEN, "driven|displacement harmonic 2e-5 8e3"),
}


@pytest.mark.parametrize("kind", LOADS)
def test_energy_balance_with_a_contact_that_yields(lammps, kind):
    extra, load = LOADS[kind]
    lmp = pushed(lammps(), load, PAIR, extra=extra)
    for _ in range(4):
        lmp.command("run 1500")
        assert balance(lmp) == pytest.approx(1, abs=1e-6)
        assert value(lmp, "mass(all)*vcm(all,z)/f_push[2]") == pytest.approx(1, rel=1e-10)
    assert value(lmp, "c_ep[1]") > 0.1 * value(lmp, "f_push")
    if kind == "displacement":
        angle = 2 * np.pi * 8e3 * 6e-5
        assert value(lmp, "z[1]") == pytest.approx(2e-5 * np.sin(angle), rel=1e-10)
        assert value(lmp, "vz[1]") == pytest.approx(2e-5 * 2 * np.pi * 8e3 * np.cos(angle), rel=1e-10)


def test_displacement_by_a_table_stays_at_its_last_value(lammps, tmp_path):
    rows = table(tmp_path / "place.txt", [1e-6, 2.1e-5], [0, 2e-5])
    lmp = pushed(lammps(), f"driven|displacement table {rows}", PAIR, extra=DRIVEN)
    lmp.command("run 1000")
    assert value(lmp, "z[1]") == pytest.approx(9e-6, rel=1e-10) and value(lmp, "vz[1]") == pytest.approx(1, rel=1e-10)
    assert balance(lmp) == pytest.approx(1, abs=1e-6)
    lmp.command("run 4000")
    assert value(lmp, "z[1]") == pytest.approx(2e-5, rel=1e-10) and value(lmp, "vz[1]") == 0
    assert balance(lmp) == pytest.approx(1, abs=1e-5)


def test_velocity_before_the_drive_is_not_its_work(lammps):
    lmp = pushed(lammps(), "driven|displacement harmonic 2e-5 8e3", PAIR, extra=DRIVEN + "set atom 1 vx 2.0 vz 1.0")
    lmp.command("run 3000")
    before = 0.5 * MASS * 5
    assert value(lmp, "c_ke+pe+c_ep[1]-f_push") == pytest.approx(before, rel=1e-6)
    assert value(lmp, "mass(all)*vcm(all,z)-f_push[2]") == pytest.approx(MASS, rel=1e-10)


STATE = ("vz[1]", "vz[2]", "z[1]", "c_ep[1]", "f_push", "f_push[1]", "f_push[2]", "f_push[3]")


@pytest.mark.parametrize("kind", LOADS)
@pytest.mark.parametrize(
    "pieces", [["0", "1000", "2000 pre no"], ["700 post no", "300 pre no", "0", "2000"], "restart"]
)
def test_pieces_and_restarts_are_the_run(lammps, tmp_path, kind, pieces):
    extra, load = LOADS[kind]
    whole, cut = (pushed(lammps(), load, PAIR, extra=extra) for _ in range(2))
    whole.command("run 3000")
    for piece in pieces if pieces != "restart" else []:
        cut.command(f"run {piece}")
    if pieces == "restart":
        cut.command("run 1000")
        cut.command(f"write_restart {tmp_path}/r")
        cut = lammps()
        moving = "all" if kind == "force" else "rest"
        cut.commands_string(
            f"newton off\natom_modify map yes\nread_restart {tmp_path}/r\nfix motion {moving} nve\ntimestep 1e-8\n"
            f"compute ke all ke\ncompute ep all pair gran/hysteretic\n"
            f"fix push driven gran/load z {load.partition('|')[2]}{REPORT}run 2000"
        )
    for what in STATE:
        assert value(cut, what) == pytest.approx(value(whole, what), rel=1e-13), what


def test_restart_of_another_kind_is_refused(lammps, tmp_path):
    lmp = pushed(lammps(), f"force half-sine {A} {T}")
    lmp.commands_string(f"run 5\nwrite_restart {tmp_path}/r")
    again = lammps()
    again.commands_string(f"newton off\nread_restart {tmp_path}/r")
    with pytest.raises(Exception, match="with a force"):
        again.command("fix push all gran/load z displacement harmonic 1 1")


# ---------------------------------------------------------------------- flat faces


def on_a_face(lmp, face_mass=1e12, law="elastoplastic 115e9 0.3 550e6 210e9 0.3 INF", speed=2.0, steps=20000):
    """A sphere thrown at a particle of radius 0."""
    lmp.commands_string(
        script_of(
            [(0, 0, 0), (0, 0, R)],
            radius=[R, 0.0],
            types=[1, 2],
            velocities=[(0, 0, speed)],
            coefficients=["pair_coeff 1 1 hertz 1e9 0.3", "pair_coeff 2 2 hertz 1e9 0.3", f"pair_coeff 1 2 {law}"],
            box=BOX,
            extra=f"set atom 2 density {face_mass}\ncompute end all gran/hysteretic/contact 1 2\n"
            "compute atoms all gran/hysteretic/atom\nthermo_style custom step c_ke pe c_ep[1] c_ep[2] c_ep[4] c_end[3]\n",
        )
    )
    lmp.command(f"run {steps}")
    return lmp


@pytest.mark.parametrize("law", ["elastoplastic", "thornton", "bilinear"])
@pytest.mark.parametrize("strengths", [(550e6, np.inf), (np.inf, 550e6), (550e6, 700e6)])
def test_face_and_wall_are_the_plane_of_the_law(lammps, law, strengths):
    """Heavy face of radius 0, wall of the same material and closed form for R2 = infinity agree."""
    first, second = ("INF" if np.isinf(s) else f"{s}" for s in strengths)
    words = f"{law} 115e9 0.3 {first} 210e9 0.3 {second}"
    face, wall = on_a_face(lammps(), law=words), lammps()
    fix = f"fix floor all wall/gran/hysteretic zplane NULL {R} {words}\nthermo_style custom step f_floor[5] c_ke\n"
    wall.commands_string(script_of([(0, 0, 0)], velocities=[(0, 0, 2.0)], box=BOX, extra=fix))
    wall.command("run 20000")
    closed = ContactLaw(
        law, youngs_modulus=(115e9, 210e9), poisson_ratio=(0.3, 0.3), yield_strength=strengths, radius=(R, np.inf)
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


def test_strength_without_end_survives_a_restart(lammps, tmp_path):
    lmp = on_a_face(lammps(), steps=800)
    lmp.command(f"write_restart {tmp_path}/r")
    again = lammps()
    again.commands_string(
        f"newton off\natom_modify map yes\nread_restart {tmp_path}/r\nfix motion all nve\ntimestep 1e-8\n"
        "compute ep all pair gran/hysteretic\nthermo_style custom step pe c_ep[1]\nrun 19200"
    )
    lmp.command("run 19200")
    for what in ("vz[1]", "c_ep[1]", "z[1]"):
        assert value(again, what) == value(lmp, what)


def test_forgotten_dent_in_a_face_stays_in_the_account(lammps):
    lmp = on_a_face(lammps(), steps=1000)
    lmp.command("run 19000")
    lost = value(lmp, "c_ep[1]")
    lmp.command("run 200000")  # far beyond the gap
    assert value(lmp, "z[2]-z[1]") > R + 1e-3
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)


def test_faces_never_touch_and_fall_through_no_wall(lammps):
    lmp = lammps()
    lmp.commands_string(
        script_of(
            [(0, 0, 0), (0, 0, 1e-4), (0, 0, 0.02)],
            radius=[0.0, 0.0, R],
            types=[1, 1, 2],
            velocities=[(0, 0, 50.0), (0, 0, -50.0)],
            box=BOX,
            extra="fix floor all wall/gran/hysteretic zplane -1e-6 NULL hertz 1e9 0.3",
        )
    )
    lmp.command("run 2000")
    assert value(lmp, "vz[1]") == 50 and value(lmp, "vz[2]") == -50 and value(lmp, "c_ep[5]") == 0


@pytest.mark.parametrize(("speed", "message"), [(1e4, "overlap by .* flat face"), (1e6, "moves by .* of its radius")])
def test_hostile_states_at_a_face_get_a_message(lammps, speed, message):
    with pytest.raises(Exception, match=message):
        on_a_face(lammps(), speed=speed)


# ---------------------------------------------------------------------- bars


def bar(n, *, beads=0, load="half-sine 1000 60e-6", courant=0.05, ranks=1) -> tuple[str, float]:
    """Input script of a steel bar of n nodes, behind a few beads of brass, and its wave speed."""
    modulus, density, area, h = 200e9, 7850.0, 1e-4, 5e-3
    mass, speed = density * area * h, np.sqrt(modulus / density)
    top = n * h + 0.02  # the subdomains of two processors meet between beads and bar
    lines = [
        "units si\natom_style hybrid sphere bond\natom_modify map yes\nnewton off\nboundary f f f",
        f"region box block -0.02 0.02 -0.02 0.02 {-top} {top} units box\nprocessors 1 1 {ranks}",
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
    lmp = lammps()
    lmp.commands_string(script)
    dt = 0.05 * 5e-3 / speed
    centres = []
    for steps in (2400, 2400):
        lmp.command(f"run {steps}")
        order = np.argsort(lmp.numpy.extract_atom("id")[:300])
        v, z = lmp.numpy.extract_atom("v")[order, 2], lmp.numpy.extract_atom("x")[order, 2]
        centres.append(np.sum(v**2 * z) / np.sum(v**2))
        assert value(lmp, "(c_ke+ebond)/f_push") == pytest.approx(1, rel=2e-6)
    assert (centres[1] - centres[0]) / (2400 * dt) == pytest.approx(speed, rel=0.01)
    impedance = np.sqrt(200e9 * 7850) * 1e-4
    assert v.max() == pytest.approx(1000 / impedance, rel=0.01)
    assert value(lmp, "f_push") == pytest.approx(1000**2 * 60e-6 / 2 / impedance, rel=0.01)  # integral of F^2/Z


def test_beads_and_bar_on_two_processors_give_the_same_bits(lmp, tmp_path):
    found = []
    for ranks in (1, 2):
        script = bar(60, beads=5, load="half-sine 5000 4e-5", ranks=ranks)[0]
        script += "dump all all custom 800 all.dump id x y z vx vy vz\ndump_modify all format float %.17g sort id\n"
        script += "compute dents all gran/hysteretic/local\nthermo 600\nthermo_modify format float %.15g\nrun 2400\n"
        script += (
            'print "result $(c_ke+ebond+c_ep+c_ep[1]:%.15g) $(f_push:%.15g) $(c_ep[1]:%.15g) $(c_ep[2]) $(ebond)"\n'
        )
        (tmp_path / "in.bar").write_text(script)
        done = lmp(tmp_path / "in.bar", ranks=ranks)
        log = (tmp_path / "log.lammps").read_text()
        assert done.returncode == 0, log[-1000:]
        result = [float(w) for w in log.rpartition("\nresult ")[2].split("\n")[0].split()]
        found.append(((tmp_path / "all.dump").read_text(), result))
    assert found[0][0] == found[1][0]
    assert found[1][1] == pytest.approx(found[0][1], rel=1e-12)
    energy, work, lost, yielded, in_bar = found[0][1]
    assert energy == pytest.approx(work, rel=1e-4) and lost > 0 and yielded == 5 and in_bar > 0.01 * work


def test_bar_goes_on_from_a_restart_on_other_processors(lmp, tmp_path):
    """Bonds, dents, work and impulse are written by one processor during the pulse and read by two."""
    script = bar(60, beads=5, load="half-sine 5000 4e-5")[0].replace("timestep", "timestep 2.4e-8\n# was")
    script += "run 800\nwrite_restart r\nrun 2000\nwrite_dump all custom all.dump id x y z vx vy vz modify format float %.17g sort id\n"
    goes_on = (
        "newton off\natom_modify map yes\nprocessors 1 1 2\nread_restart r\ncomm_modify cutoff 0.02\n"
        "neigh_modify exclude type 2 2 delay 0 every 1 check yes\nfix motion all nve\n"
        "fix push first gran/load z force half-sine 5000 4e-5\nthermo_style custom step f_push f_push[2]\n"
        "run 2000\nwrite_dump all custom all.dump id x y z vx vy vz modify format float %.17g sort id\n"
    )
    found = []
    for ranks, text in ((1, script), (2, goes_on)):
        text += 'print "result $(f_push:%.15g) $(f_push[2]:%.15g) $(f_push[3]:%.15g)"\n'
        (tmp_path / "in.bar").write_text(text)
        done = lmp(tmp_path / "in.bar", ranks=ranks)
        log = (tmp_path / "log.lammps").read_text()
        assert done.returncode == 0, log[-1000:]
        found.append(((tmp_path / "all.dump").read_text(), log.rpartition("\nresult ")[2].split("\n")[0].split()))
    assert found[0][0] == found[1][0]
    assert [float(w) for w in found[1][1]] == pytest.approx([float(w) for w in found[0][1]], rel=1e-13)


def test_driven_sphere_crosses_between_processors(lmp, tmp_path):
    found = []
    for ranks in (1, 2):
        script = script_of(PAIR, box=[-0.02, 0.02, -0.02, 0.02, -0.02, 0.02002], extra=DRIVEN)
        script = script.replace("boundary m m m", f"boundary p p p\nprocessors 1 1 {ranks}")  # in contact at z = 1e-5
        script += f"fix push driven gran/load z displacement harmonic 2e-5 8e3{REPORT}neigh_modify check no every 10\nrun 6000\n"
        script += 'print "result $(z[1]:%.17g) $(z[2]:%.17g) $(f_push:%.15g) $(f_push[2]:%.15g) $(f_push[3]:%.15g)"\n'
        (tmp_path / "in.two").write_text(script)
        done = lmp(tmp_path / "in.two", ranks=ranks)
        log = (tmp_path / "log.lammps").read_text()
        assert done.returncode == 0, log[-1000:]
        found.append(log.rpartition("\nresult ")[2].split("\n")[0].split())
    assert found[0][:2] == found[1][:2]
    assert [float(w) for w in found[1]] == pytest.approx([float(w) for w in found[0]], rel=1e-12)


def test_example_of_the_manual(lmp, tmp_path):
    """Example of a bar in the manual page of the pair style; LAMMPS warns of two kinds of masses in hybrid atom styles."""
    page = (PAGES / "pair_gran_hysteretic.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"^```LAMMPS\n(# Example of a bar.*?)^```$", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "in.bar").write_text(script)
    done = lmp(tmp_path / "in.bar")
    log = (tmp_path / "log.lammps").read_text()
    assert done.returncode == 0 and log.count("WARNING") == log.count("WARNING: Atom style hybrid defines both"), log
    run = Log(tmp_path / "log.lammps").runs[0]
    assert np.abs(run["v_balance"]).max() < 1e-6
    assert run["c_end[5]"][-1] > 0.5 * run["f_push"][-1]
    assert run["c_barkinetic"][-1] == pytest.approx(run["E_bond"][-1], rel=1e-3)  # a wave that travels one way


# ---------------------------------------------------------------------- messages


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("q force half-sine 1 1", "'q' is no direction"),
        ("z push half-sine 1 1", "neither force nor displacement"),
        ("z force sawtooth 1 1", "'sawtooth' is no shape of a force"),
        ("z displacement half-sine 1 1", "'half-sine' is no shape of a displacement"),
        ("z force half-sine 0 1", "amplitude must be positive, found 0"),
        ("z force half-sine 1 0", "duration must be positive, found 0"),
        ("z force rectangle 1 -1e-5", "duration must be positive"),
        ("z force harmonic 1 0", "frequency must be positive"),
        ("z force half-sine 1", "words after 'half-sine'"),
        ("z force harmonic 1 1 1 1", "4 words after 'harmonic'"),
        ("z force burst 1 1e5 0", "number of cycles must be positive, found 0"),
        ("z force sweep 1 1e5 2e5 1e-4 6e-5", "ramp must be at most half the duration"),
        ("z force noise 1 1e3 2e3 1e-4 0 1", "noise cannot be used: no multiple of 1/T lies between its frequencies"),
        ("z force half-sine", "expected x|y|z"),
        ("z force table {}/none.txt", "cannot read the table"),
        ("z force table {}/falls.txt", "row 3 does not"),
        ("z force table {}/early.txt", "first time is negative"),
        ("z force table {}/short.txt", "at least two rows, found 1"),
        ("z force table {}/words.txt", "line 3 of table .* must be two numbers, found '1 one'"),
    ],
)
def test_wrong_loads_get_a_message(lammps, tmp_path, words, message):
    for name, rows in {
        "falls": "0 0\n1 1\n1 2\n",
        "early": "-1 0\n1 1\n",
        "short": "0 1\n",
        "words": "# t F\n0 0\n1 one\n",
    }.items():
        (tmp_path / f"{name}.txt").write_text(rows)
    lmp = lammps()
    lmp.commands_string(script_of([(0, 0, 0)]))
    with pytest.raises(Exception, match=message):
        lmp.command(f"fix push all gran/load {words.format(tmp_path)}")


@pytest.mark.parametrize(
    ("commands", "message"),
    [
        ("minimize 0 0 1 1", "does not work with minimize"),
        ("run_style respa 2 2\nunfix motion\nrun 1", "does not work with run_style respa"),
        ("group none subtract all all\nfix more none gran/load z force harmonic 1 1\nrun 0", "has no atoms"),
        ("fix more all gran/load z displacement harmonic 1 1\nrun 0", "that fix nve motion integrates"),
    ],
)
def test_wrong_runs_get_a_message(lammps, commands, message):
    lmp = lammps()
    script = script_of([(0, 0, 0)], extra="fix push all gran/load z force harmonic 1 1")
    if "respa" in commands:  # an error of the pair style, too
        script = script.replace(
            "pair_style gran/hysteretic 0.001\npair_coeff * * elastoplastic 115e9 0.3 550e6",
            "pair_style zero 1e-3\npair_coeff * *",
        )
        script = script.replace("compute ep all pair gran/hysteretic\n", "").replace(" c_ep[1] c_ep[2]", "")
    lmp.commands_string(script)
    with pytest.raises(Exception, match=message):
        lmp.commands_string(commands)


@pytest.mark.parametrize("law", ["elastoplastic", "thornton", "bilinear"])
@pytest.mark.parametrize("words", ["115e9 0.3 INF", "115e9 0.3 INF 1e9 0.3 INF"])
def test_one_of_two_bodies_must_yield(lammps, law, words):
    lmp = lammps()
    lmp.commands_string(script_of([(0, 0, 0), (0, 0, 0.03)], types=[1, 2]))
    for command in (f"pair_coeff 1 2 {law} {words}", f"fix w all wall/gran/hysteretic zplane NULL 1 {law} {words}"):
        with pytest.raises(Exception, match="needs a yield strength for one of the two bodies"):
            lmp.command(command)
