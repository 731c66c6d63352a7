"""A run in parts, and a run continued from a restart file, equal the uninterrupted run; damaged
restart files give an error.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import script_of
from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, packing, rubbing, same, state
from tests.helpers.bodies.two_spheres import BOX, PAIR, R, value
from tests.helpers.selection import with_every_test

HEADS_ON = [(0, 0, 1.0), (0, 0, -1.0)]
LINE = [(0, 0, 0), (0, 0, 2 * R + 1e-5), (0, 0, 4 * R + 2e-5)]
SKEW = "set atom 1 vx 0.7 omega 10 50 -30\nunfix motion\nfix motion all nve/sphere\n"
DRIVEN = "group driven id 1\ngroup rest id 2\nunfix motion\nfix motion rest nve\n"
BAR = "bar 400 0.3082 6.283185e10"  # of steel


def alone(extra: str, law: str = HERTZ, velocity=(0, 0, 2.0), **options) -> str:
    return script_of([(0, 0, 0)], style=law, velocities=[velocity], box=BOX, extra=extra, **options)


def supported(support: str) -> str:
    wall = f"fix plate all wall/gran/hysteretic zplane NULL {R:.17g} {BRASS} friction 0.3 support {support}"
    return alone(f"{wall}\n{SKEW}thermo_style custom step c_ke f_plate f_plate[*]")


def loaded(load: str, extra: str) -> str:
    fix = f"{extra}fix push driven gran/load z {load}\nthermo_style custom step pe c_ep[1] f_push f_push[*]"
    return script_of(PAIR, box=BOX, extra=fix)


def rubbed() -> str:
    places, speeds, spins = packing(2)
    return rubbing(places, f"{BRASS} friction {MU}", velocities=3 * speeds, spins=spins)


def jkr() -> str:
    places, speeds, spins = packing(2)
    law = f"{HERTZ} friction {MU} rolling sds mindlin 1.0 0.05 loss time 1e-7 cohesion jkr 100.0"
    return rubbing(places, law, velocities=0.1 * speeds, spins=0.1 * spins)


HOLDER = (
    "fix holder all gran/holder z 0.3 9.81\nthermo_style custom step pe f_holder\ntimestep 1e-7"
)
LOSSES = (
    f"comm_modify vel yes\nfix wall all wall/gran/hysteretic zplane NULL {5.0001 * R:.17g} {HERTZ} loss dashpot 0.2\n"
    "compute en all gran/hysteretic/energy\nthermo_style custom step c_en[*] f_wall[*]"
)
SERIES = "0.1 1e-5 0.1 1e-4 0.1 1e-3 0.1 1e-2"
FACE = "set atom 2 density 1e12\nthermo_style custom step pe c_ep[1]"
TICKS = (
    "timestep 5e-9\ncompute contact all gran/hysteretic/energy\nvariable given equal 0.0556\n"
    "fix step all gran/timestep 32 3e-6 v_given first 4\nthermo_style custom step f_step[3]"
)
PLATE = [f"f_plate[{n}]" for n in range(1, 16)]
RESISTS = "rolling sds mindlin 1.0 0.05 twisting marshall"
# script, steps of the run, values that must be equal beside places, velocities and spins
RUNS = {
    "friction in a packing": (rubbed(), 3000, ["c_en[7]", "c_en[1]", "c_en[6]"]),
    "partial slip": (
        rubbed().replace("friction 0.3", f"friction 0.3 tangential partial_slip {RESISTS}"), 3000,
        [f"c_en[{n}]" for n in (1, 6, 7, 9, 10, 11, 12)],
    ),
    "partial slip on a wall, with losses": (
        alone(f"{SKEW}fix floor all wall/gran/hysteretic zplane NULL {R} {BRASS} friction 0.3 tangential partial_slip {RESISTS} "
              "loss time 1e-7\nthermo_style custom step f_floor[*]"), 2400, [f"f_floor[{n}]" for n in (4, 8, 9, 16, 17, 18, 19, 20)],
    ),
    "necks of JKR, with friction, rolling and losses": (
        jkr(), 6000, [f"c_en[{n}]" for n in (6, 7, 8, 10, 13)] + ["c_en"],
    ),
    "pull of DMT": (
        script_of([(0, 0, -2e-8), (0, 0, 2 * R)], style=f"{BRASS} cohesion dmt 50.0", velocities=HEADS_ON, box=BOX,
                  extra="comm_modify vel yes"), 2400, ["c_ep[1]"],
    ),
    "neck at a wall": (
        alone(f"{SKEW}comm_modify vel yes\nfix floor all wall/gran/hysteretic zplane NULL {R} {HERTZ} friction 0.3 cohesion jkr 900.0\n"
              "timestep 3e-8\nthermo_style custom step f_floor f_floor[*]", velocity=(0, 0, 0.1)), 2400,
        ["f_floor", "f_floor[9]", "f_floor[21]"],
    ),
    "holder": (script_of(LINE, style=HERTZ, velocities=[(0, 0, 0.2)], box=BOX, extra=HOLDER), 6000, ["f_holder"]),
    "damping": (
        alone(f"{SKEW}fix calm all gran/absorb rate 2e3\ntimestep 1e-6\nthermo_style custom step f_calm"), 600, ["f_calm"],
    ),
    "force": (loaded("force half-sine 5000 3e-5", "group driven id 1\n"), 3000, ["c_ep[1]", "f_push", "f_push[2]", "f_push[3]"]),
    "displacement": (loaded("displacement harmonic 2e-5 8e3", DRIVEN), 3000, ["c_ep[1]", "f_push", "f_push[2]", "f_push[3]"]),
    "plate": (supported("0.02 1e9 500"), 3000, PLATE),
    "massless plate": (supported("0 5e7 2000"), 3000, PLATE),
    "bar behind a plate": (supported(f"{BAR} fixed"), 3000, PLATE),
    "viscous losses": (
        script_of([*PAIR, (0, 0, 4 * R)], style=f"{BRASS} loss time 1e-6", velocities=[*HEADS_ON, (0, 0, 3)], box=BOX,
                  extra=LOSSES), 4500, ["c_en[1]", "c_en[8]", "f_wall[16]"],
    ),
    "viscoelastic contacts": (
        script_of([*PAIR, (0, 0, 4 * R)], style=f"{HERTZ} loss prony 0.3 2e-6 0.2 3e-4",
                  velocities=[*HEADS_ON, (0, 0, 3)], box=BOX,
                  extra=LOSSES.replace("dashpot 0.2", f"prony {SERIES}")), 9000,
        ["c_en", "c_en[8]", "f_wall", "f_wall[16]"],
    ),
    "viscoelastic contacts with friction": (
        rubbed().replace(BRASS, f"{HERTZ} loss prony 0.4 1e-5"), 3000,
        ["c_en", *(f"c_en[{n}]" for n in (6, 7, 8))],
    ),
    "damping along the surface": (
        rubbed().replace("friction 0.3", "friction 0.3 loss time 1e-7 loss_tangential 1"), 3000,
        [f"c_en[{n}]" for n in (1, 6, 7, 8)],
    ),
    "damping of partial slip on a wall": (
        alone(f"{SKEW}fix floor all wall/gran/hysteretic zplane NULL {R} {BRASS} friction 0.3 "
              f"tangential partial_slip {RESISTS} loss dashpot 0.2 loss_tangential 0.7\n"
              "thermo_style custom step f_floor[*]"), 2400,
        [f"f_floor[{n}]" for n in (4, 8, 9, 16, 17, 18, 19, 20)],
    ),
    "rate of yielding": (
        script_of([*PAIR, (0, 0, 4 * R)], style=f"{BRASS} rate 0.02 1", velocities=[*HEADS_ON, (0, 0, -20)], box=BOX,
                  extra=LOSSES.replace(f"{HERTZ} loss dashpot 0.2", f"{BRASS} rate 0.05 10 friction 0.2")), 4500,
        ["c_en[1]", "c_en[2]", "f_wall[4]", "f_wall[5]"],
    ),
    "flat face": (
        script_of([(0, 0, 0), (0, 0, R)], radius=[R, 0.0], types=[1, 2], velocities=[(0, 0, 2.0)], box=BOX, extra=FACE,
                  coefficients=[f"pair_coeff 1 1 {HERTZ}", f"pair_coeff 2 2 {HERTZ}", f"pair_coeff 1 2 {BRASS} 210e9 0.3 INF"]),
        2400, ["c_ep[1]"],
    ),
    "timestep that follows the error": (
        script_of([(0, 0, 2 * R * k + 2e-5 * (k > 0)) for k in range(6)], velocities=[(0, 0, 5.0)], extra=TICKS), 9600,
        ["f_step[3]"],
    ),
    "friction of a wall": (
        alone(f"{SKEW}fix floor all wall/gran/hysteretic zplane NULL {R} {BRASS} friction 0.3\nthermo_style custom step f_floor[*]"),
        2400, ["f_floor[4]", "f_floor[8]", "f_floor[9]"],
    ),
}  # fmt: skip


def resumed(script: str, restart: Path) -> str:
    """Script that continues from a restart file, which contains spheres, groups and pair style."""
    words = ("neigh", "fix", "unfix", "compute", "thermo", "timestep", "variable")
    rest = [line for line in script.splitlines() if line.startswith(words)]
    head = [
        "newton off",
        "atom_modify map yes",
        *re.findall("comm_modify vel yes", script),
        f"read_restart {restart}",
    ]
    return "\n".join([*head, *rest]) + "\n"


@pytest.mark.parametrize("how", ["", " post no", " pre no", "restart"])
@pytest.mark.parametrize("name", RUNS)
def test_a_run_that_goes_on_is_the_run(lammps, tmp_path, name, how):
    script, steps, values = RUNS[name]
    first = steps // 3 // 32 * 32
    whole = lammps(f"{script}run {steps} post no")
    cut = lammps(f"{script}run {first}{' post no' if 'post' in how else ''}")
    if how == "restart":
        cut.command(f"write_restart {tmp_path}/r")
        cut = lammps(f"{resumed(script, tmp_path / 'r')}run {steps - first}")
    else:
        for piece in (0, 640, steps - first - 640) if steps > 1000 else (0, steps - first):
            cut.command(f"run {piece}{how if piece else ''}")
    same(*(state(lmp, "x", "v", "omega") for lmp in (whole, cut)))
    for formula in values:
        assert value(cut, formula) == pytest.approx(value(whole, formula), rel=1e-12), formula
    assert any(value(whole, formula) for formula in values)


@pytest.mark.parametrize("name", ["whole.restart", "part.%.restart"])
def test_restart_of_ranks_with_unlike_histories(log_of, lammps, tmp_path, name):
    """The first rank has a sphere alone, the second one with six contacts: LAMMPS asks for the size
    of the largest.
    """
    places = [(-0.1, 0.0, 0.0)] + [(0.1, 0.0, 0.0)] * 7
    for k, (axis, side) in enumerate(((a, s) for a in range(3) for s in (-1, 1)), start=2):
        places[k] = tuple(x + side * (2 * R - 2e-5) * (a == axis) for a, x in enumerate(places[1]))
    script = script_of(places)
    log_of(f"processors 2 1 1\n{script}run 400\nwrite_restart {tmp_path}/{name}\n", ranks=2)
    again = lammps(f"{resumed(script, tmp_path / name)}run 400")
    whole = lammps(f"{script}run 800")
    same(*(state(lmp, "x", "v") for lmp in (whole, again)))


LAWS = {
    "cohesion, then loss": (f"{HERTZ} cohesion dmt 10", f"{HERTZ} loss time 0.3", False),
    "cohesion, then both": (f"{HERTZ} cohesion dmt 10", f"{HERTZ} cohesion dmt 10 loss time 1e-7", False),
    "loss, then rolling": (f"{HERTZ} friction 0.3 loss dashpot 0.1", f"{HERTZ} friction 0.3 rolling sds 1e3 0.1 0.1", False),
    "loss, then damping": (
        f"{HERTZ} friction 0.3 loss dashpot 0.1",
        f"{HERTZ} friction 0.3 loss dashpot 0.1 loss_tangential 1", False,
    ),
    "loss, then relaxation": (f"{HERTZ} loss time 1e-7", f"{HERTZ} loss prony 0.1 1e-5", False),
    "the same series": (f"{HERTZ} loss prony 0.1 1e-5", f"{HERTZ} loss prony 0.1 1e-5", True),
    "the same laws": (f"{HERTZ} friction 0.3 loss time 1e-7", f"{HERTZ} friction 0.3 loss time 1e-7", True),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", with_every_test(LAWS, ("loss, then rolling", "cohesion, then loss", "the same series"))
)
def test_other_laws_after_a_restart_beside_a_processor_without_spheres(lmp, log_of, tmp_path, name):
    """Both processors stop, or both continue, although only one of them knows the content of the
    file.
    """
    before, after, allowed = LAWS[name]
    places = [(-0.05, 0, 0), (-0.05, 0, 1.999 * R)]
    script = rubbing(places, before, box=[-0.1, 0.1, -0.02, 0.02, -0.02, 0.03])
    log_of(f"processors 2 1 1\n{script}run 10\nwrite_restart {tmp_path}/r\n", ranks=2)
    again = resumed(script, tmp_path / "r").replace(
        f"read_restart {tmp_path}/r", f"read_restart {tmp_path}/r\npair_coeff * * {after}"
    )
    text = f"processors 2 1 1\n{again}run 10\n"
    if allowed:
        log_of(text, ranks=2)
        return
    (tmp_path / "in.again").write_text(text, encoding="utf-8")
    done = lmp(tmp_path / "in.again", ranks=2, timeout=60)
    assert done.returncode != 0
    assert (
        "Restart file contains pair style gran/hysteretic" in (tmp_path / "log.lammps").read_text()
    )


def test_a_wall_without_friction_ignores_springs_of_a_restart(lammps, tmp_path):
    script, *_ = RUNS["friction of a wall"]
    lmp = lammps(f"{script}run 800\nwrite_restart {tmp_path}/r\nrun 1000")
    again = lammps(resumed(script, tmp_path / "r").replace(" friction 0.3", "") + "run 1000")
    assert value(again, "vz[1]") == pytest.approx(value(lmp, "vz[1]"), rel=1e-3)
    assert value(again, "vx[1]") != value(lmp, "vx[1]")


WALL = f"fix wall all wall/gran/hysteretic zplane {-R:.17g} NULL hertz 115e9 0.3 support 1e-3 1e6 0"
PUSH = "fix push all gran/load z force half-sine 10 1e-3"
ATOM_STATE = struct.pack("<d", 0.8660254037844386)


def resume(lmp, path, *fixes: str) -> None:
    """Read a restart file and run no step."""
    lmp.commands_string(
        f"newton off\natom_modify map yes\ncomm_modify vel yes\nread_restart {path}\n"
        + "\n".join([*fixes, "fix motion all nve/sphere", "timestep 1e-8"])
        + "\ncompute en all gran/hysteretic/energy\nthermo_style custom step c_en[*]\nrun 0 post no"
    )


def laws(data: bytes) -> int:
    """Place of the state with the laws: behind format and settings, each state behind its size in
    bytes.
    """
    at = data.index(b"gran/hysteretic\0") + len(b"gran/hysteretic\0") + 4
    return at + 4 + struct.unpack("<i", data[at : at + 4])[0] + 4


def ours(data: bytes) -> list[int]:
    """Places of our own bytes in a restart file: settings and laws, states of fixes, states with
    atoms.
    """
    at = data.index(b"gran/hysteretic\0") + len(b"gran/hysteretic\0")
    places = [*range(at, laws(data) + struct.unpack("<i", data[laws(data) - 4 : laws(data)])[0])]
    for style in (b"gran/hysteretic/history\0", b"wall/gran/hysteretic\0", b"gran/load\0"):
        at = data.index(style) + len(style)
        (size,) = struct.unpack("<i", data[at : at + 4])
        places += range(at + 4, at + 4 + size)
    at = data.find(ATOM_STATE)
    while at >= 0:
        size = int(struct.unpack("<d", data[at - 8 : at])[0])
        places += range(at - 8, at - 8 + 8 * size)
        at = data.find(ATOM_STATE, at + 1)
    return places


def test_a_damaged_byte_is_an_error(lammps, tmp_path):
    """Damage of any byte of settings, laws, contacts, forgotten contacts, walls and loads gives an
    error, and no signal or different result.
    """
    lmp = lammps()
    places = [(0, 0, 0), (0, 0, 2 * R), (0, 0, 4 * R)]
    text = rubbing(
        places,
        f"{BRASS} friction {MU} loss time 1e-8",
        velocities=[(1, 0, 1), (0, 0, 0), (0, 0, -1)],
        gap=2e-5,
    )
    lmp.commands_string(
        f"{text}{WALL}\n{PUSH}\nrun 9000 post no\nwrite_restart {tmp_path}/good.restart"
    )
    data = (tmp_path / "good.restart").read_bytes()
    chosen = ours(data)
    assert len(chosen) > 1500
    resume(lammps(), tmp_path / "good.restart", WALL, PUSH)
    rng = np.random.default_rng(5)
    for at in rng.choice(chosen, 80, replace=False):
        damaged = bytearray(data)
        damaged[at] ^= 1 << rng.integers(8)
        (tmp_path / "bad.restart").write_bytes(damaged)
        lmp = lammps()
        with pytest.raises(Exception, match=r"damaged|format|define it again|law number"):
            resume(lmp, tmp_path / "bad.restart", WALL, PUSH)
        lmp.close()


def test_contacts_that_are_missing_are_an_error(lammps, tmp_path):
    """The name of the fix that stores the contacts is damaged: LAMMPS by itself would continue
    without them.
    """
    lmp = lammps(
        rubbing([(0, 0, 0), (0, 0, 2 * R)], velocities=[(0, 0, 1), (0, 0, 0)]) + "run 300 post no"
    )
    lmp.command(f"write_restart {tmp_path}/a.restart")
    data = (tmp_path / "a.restart").read_bytes()
    (tmp_path / "a.restart").write_bytes(
        data.replace(b"GRAN_HYSTERETIC_HISTORY", b"GRAN_HYSTERETIC_HISTORx")
    )
    with pytest.raises(Exception, match="damaged: it contains no contacts"):
        resume(lammps(), tmp_path / "a.restart")
