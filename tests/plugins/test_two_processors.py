"""Bitwise identical results on one and on two processors, between which spheres, springs and dents
migrate.
"""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.conftest import printed, script_of
from tests.helpers.bodies.rubbing import BRASS, HERTZ, MU, rubbing
from tests.helpers.bodies.two_spheres import DRIVEN, LAW, PAIR, REPORT, R
from tests.helpers.selection import with_every_test
from tests.plugins.fixes.test_holder_and_damping import bar
from tests.plugins.test_packings import ROLLS, SLIPS, text_of

pytestmark = pytest.mark.xdist_group("two processors")  # else four of theirs share two cores
SUMS = "compute sums all reduce sum c_dents[13] c_dents[15] inputs local\nthermo_style custom step c_en c_en[*] c_sums[*]\n"
ENERGIES = ["c_en", "c_en[1]", "c_en[6]", "c_en[7]", "c_sums[1]", "c_sums[2]"]


def sliders() -> str:
    """Pressed spheres that slide across the boundary between processors and the periodic
    boundary.
    """
    extra = f"fix floor all wall/gran/hysteretic zplane {-R} NULL {BRASS} friction {MU}\nfix press all addforce 0 0 -400\n"
    return rubbing(
        [(-0.0101, 0, 0), (0.0299, 0.011, 0)], BRASS, velocities=[(20, 1, 0), (25, 0, 0)], spins=[(0, 0, 200)] * 2,
        box=[-0.03, 0.03, -0.03, 0.03, -0.02, 0.02],
        extra=f"{extra}neighbor 2e-4 bin\ntimestep 2e-7\nthermo_style custom step f_floor[*]\n",
    ).replace("boundary m m m", "boundary p p f")  # fmt: skip


def sheet() -> str:
    """Layer of spheres that hits a plate on a spring and a damper."""
    places = 0.0101 * np.array([(x, y, 0) for y in range(-5, 6) for x in range(-5, 6)])
    speeds = [
        (0.5 * np.sin(700 * x + 300 * y), 0, 2 + np.sin(900 * x - 500 * y)) for x, y, _ in places
    ]
    wall = f"fix plate all wall/gran/hysteretic zplane NULL {R} {BRASS} friction 0.2 support 0.5 1e9 2000\ntimestep 5e-8\n"
    return rubbing(
        places, BRASS, velocities=speeds, extra=f"{wall}thermo_style custom step f_plate[*]\n"
    )


def row_with_dents(folder) -> str:
    """Chain with dents in every second contact and in a wall, and `begin` after a run."""
    n = 12
    dent = LAW.yield_overlap
    dents = (
        "".join(f"{k + 1} {k} {(20 + k) * dent:.17g}\n" for k in range(2, n, 2))
        + f"end {n} {30 * dent:.17g}\n"
    )
    (folder / "dents").write_text(dents)
    extra = f"fix end all wall/gran/hysteretic xplane NULL {(2 * n - 1) * R:.17g} {BRASS}\n"
    extra += "compute en all gran/hysteretic/energy\nthermo_style custom step c_en[*] f_end[*]\n"
    extra += "gran/dents read dents\nrun 3000\ngran/dents begin\nset atom 1 vx 6.0"
    return script_of([(2 * R * k, 0, 0) for k in range(n)], velocities=[(3.0, 0, 0)], extra=extra)


def driven() -> str:
    """Driven sphere that crosses between processors, in contact, at z = 1e-5."""
    text = script_of(PAIR, box=[-0.02, 0.02, -0.02, 0.02, -0.02, 0.02002], extra=DRIVEN)
    fix = f"fix push driven gran/load z displacement harmonic 2e-5 8e3{REPORT}neigh_modify check no every 10\n"
    return text.replace("boundary m m m", "boundary p p p\nprocessors 1 1 *") + fix


def drifting(law: str, tilt: float = 0.0, flow: str = "") -> str:
    """Periodic FCC packing in random motion that drifts across all borders of its box, which may be
    tilted and deformed.
    """
    cell = 0.01412
    cells = np.array([(i, j, k) for k in range(2) for j in range(2) for i in range(2)])
    basis = 0.5 * np.array([(0, 0, 0), (1, 1, 0), (1, 0, 1), (0, 1, 1)])
    places = cell * (cells[:, None] + basis + 0.25).reshape(-1, 3)
    side = 2 * cell
    shift = places[:, 1] * tilt / side
    places[:, 0] = shift + (places[:, 0] - shift) % side
    rng = np.random.default_rng(1)
    speeds = np.array([100, 60, 35]) + rng.uniform(-2, 2, places.shape)
    spins = rng.uniform(-100, 100, places.shape)
    extra = f"timestep 5e-8\nneighbor 2e-4 bin\n{flow}"
    text = rubbing(places, law, velocities=speeds, spins=spins, box=[0, side] * 3, extra=extra)
    text = text.replace("boundary m m m", "boundary p p p")
    if not tilt:
        return text
    return text.replace("block", "prism").replace(
        "units box\ncreate_box", f"{tilt} 0 0 units box\ncreate_box"
    )


ACROSS = f"{BRASS} friction {MU} loss time 1e-8"
# script, of the folder of the test, steps, values that are equal to rounding, further columns of
# the spheres
RUNS = {
    "friction": (lambda _: text_of("dents and friction") + SUMS, 4000, ENERGIES, ""),
    "partial slip, rolling": (lambda _: text_of("partial slip, rolling, losses") + SUMS, 400, [*ENERGIES, "c_en[8]", "c_en[10]"], ""),
    "necks": (lambda _: text_of("JKR with losses") + SUMS, 2000, ["c_en", "c_en[13]"], ""),
    "rate": (lambda _: text_of("yielding by rate") + SUMS, 400, ENERGIES, ""),
    "sliders": (lambda _: sliders(), 6000, ["f_floor[8]", "f_floor[9]"], "f_floor[10]"),
    "plate": (lambda _: sheet(), 300, ["f_plate[10]", "f_plate[11]", "f_plate[13]", "f_plate[15]"], ""),
    "initial dents": (row_with_dents, 3000, ["c_en[1]"], "f_end[*]"),
    "beads and bar": (lambda _: bar(60, beads=5, load="half-sine 5000 4e-5")[0], 2400, ["f_push", "c_ep[1]", "c_ep[2]", "ebond"], ""),
    "across the border": (lambda _: drifting(ACROSS), 800, [*ENERGIES[:4], "c_en[8]"], ""),
    "relaxation across the border": (
        lambda _: drifting(f"{HERTZ} friction {MU} loss prony 0.3 1e-6 0.2 1e-4"), 800,
        ["c_en", *ENERGIES[2:4], "c_en[8]"], "",
    ),
    "damping across the border": (
        lambda _: drifting(f"{ACROSS} loss_tangential 1"), 800, [*ENERGIES[:4], "c_en[8]"], "",
    ),
    "slip across the border": (lambda _: drifting(f"{HERTZ} {SLIPS} {ROLLS}"), 800, ["c_en", "c_en[6]", "c_en[7]"], ""),
    "necks across the border": (lambda _: drifting(f"{HERTZ} friction 0.3 cohesion jkr 100"), 800, ["c_en", "c_en[6]"], ""),
    "rate across the border": (lambda _: drifting(f"{BRASS} friction 0.3 rate 0.05 1"), 800, ENERGIES[:4], ""),
    "flow": (lambda _: drifting(ACROSS, flow="fix flow all deform 1 x erate 20 remap v\n"), 800, [*ENERGIES[:4], "c_en[8]"], ""),
    "tilted box": (lambda _: drifting(ACROSS, tilt=0.008), 800, [*ENERGIES[:4], "c_en[8]"], ""),
    "shear": (lambda _: drifting(ACROSS, tilt=0.002, flow="fix flow all deform 1 xy erate 200 remap v\n"), 800, [*ENERGIES[:4], "c_en[8]"], ""),
    "driven sphere": (lambda _: driven(), 2000, ["f_push", "f_push[2]", "f_push[3]", "z[1]"], ""),
}  # fmt: skip


#: Runs of every test; the others are validations.
SHORT = (
    "friction", "partial slip, rolling", "plate", "across the border", "tilted box",
    "driven sphere",
)  # fmt: skip
ALSO_EMPTY = ("friction",)
SENT_BY_LAMMPS = "comm_modify vel yes\n"
MIDDLE = 0.5
ABOVE_ALL = 0.95  # spheres: the second of two processors has none


def divided_at(script: str, height: float) -> str:
    """Divide the box across z, at a fraction of its height."""
    divided, number = re.subn("\nfix ", f"\nbalance 1.0 z {height}\nfix ", script, count=1)
    assert number == 1
    return f"processors 1 1 2\n{divided}"


@pytest.mark.parametrize("name", with_every_test(RUNS, SHORT))
def test_the_same_bits(log_of, tmp_path, name):
    """On one processor, where LAMMPS sends velocities of ghosts across periodic boundaries, and on
    two, where the pair style does.
    """
    compare(log_of, tmp_path, name, one_is_empty=False)


@pytest.mark.parametrize("name", with_every_test(RUNS, ALSO_EMPTY))
def test_the_same_bits_where_one_is_empty(log_of, tmp_path, name):
    """On two processors, of which one has no spheres or both have some. The command that divides a
    tilted box rounds the coordinates.
    """
    compare(log_of, tmp_path, name, one_is_empty=True)


def compare(log_of, tmp_path, name, *, one_is_empty):
    """Compare two runs of a script: all spheres bitwise, and values to rounding."""
    script, steps, values, further = RUNS[name]
    columns = f"id x y z vx vy vz omegax omegay omegaz tqx {further}"
    end = f"run {steps}\nwrite_dump all custom out {columns} modify sort id format float %.17g\n"
    end += f'print "result {" ".join(f"$({value}:%.15g)" for value in values)}"\n'
    found = []
    for ranks in (1, 2):
        text = script(tmp_path) + end
        if one_is_empty:
            text = divided_at(text, MIDDLE if ranks == 1 else ABOVE_ALL)
            ranks = 2
        elif ranks == 2:
            text = text.replace(SENT_BY_LAMMPS, "")
        result = np.array(printed(log_of(text, ranks), "result"), float)
        found.append((result, (tmp_path / "out").read_text()))
    assert found[0][1] == found[1][1]
    assert found[0][0] == pytest.approx(found[1][0], rel=1e-12) and found[0][0].all()
