"""LAMMPS's own unit tests of pair styles, fixes and computes, on all of ours: the files of
plugins/unittest.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from granwave._contact_laws import LAWS, PARAMETERS
from granwave.plugins import lammps_release
from tests.helpers.force_styles import FOLDER, StyleTester, differ, files, load, stored
from tests.helpers.twins.twin import LawTwin

pytestmark = pytest.mark.skipif(
    lammps_release() < "2025.7", reason="files and testers are of 22 Jul 2025"
)


@pytest.fixture
def tester(lammps, tmp_path):
    """StyleTester of a file, before its first step."""
    return lambda path: StyleTester(lammps(), path, tmp_path)


def check(one: StyleTester, when: str, factor: float = 1.0) -> None:
    """Assert that the values agree with the file."""
    limit = factor * float(one.config["epsilon"])
    measured = one.measured(when)
    assert set(measured) == {
        name for name in one.config if name.startswith((f"{when}_", "global", "peratom", "local"))
    }
    for name, value in measured.items():
        assert differ(value, stored(one.config, name)) <= limit, f"{name}, {when}"


def check_sums(one: StyleTester) -> None:
    """Energies and virials of the atoms sum to those of all; LAMMPS's stress/atom is the negative
    virial.
    """
    energy = one.lmp.get_thermo("evdwl")
    virial = one.virial()
    assert one.lmp.extract_compute("sum_of_pe", 0, 0) == pytest.approx(energy, rel=1e-12)
    assert -one.compute("sum_of_stress") == pytest.approx(
        virial, rel=1e-11, abs=1e-13 * np.abs(virial).max(initial=0.0)
    )


SINGLES = """compute ids all property/local patom1 patom2
compute singles all pair/local eng force p11 p12 p14
compute dents all gran/hysteretic/local
group few id 1:5
group rest subtract all few
compute across few group/group rest
run 0 post no"""


def check_contacts(one: StyleTester) -> None:
    """Values of `single()` and of the compute of contacts, which sum to the forces and energies of
    the run.
    """
    n = one.lmp.get_natoms()
    x = one.atoms("x")
    one.commands(SINGLES)
    ids, singles, dents = (
        one.lmp.numpy.extract_compute(name, 2, 2).copy() for name in ("ids", "singles", "dents")
    )
    pairs = np.sort(ids.astype(int)) - 1
    forces = np.zeros((n, n, 3))
    across = np.arange(n) < 5
    normal = x[pairs[:, 0]] - x[pairs[:, 1]]
    normal[:, 0] -= 60000 * np.round(normal[:, 0] / 60000)  # the periodic length
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    forces[pairs[:, 0], pairs[:, 1]] = singles[:, 1, None] * normal
    pressed = (forces - forces.transpose(1, 0, 2))[across][:, ~across].sum(axis=(0, 1))
    assert one.compute("across") == pytest.approx(pressed, rel=1e-10), (
        "compute group/group has the normal forces"
    )
    forces[tuple(dents[:, :2].astype(int).T - 1)] += dents[:, 17:20]
    assert forces.sum(axis=1) - forces.sum(axis=0) == pytest.approx(one.atoms("f"), rel=1e-10)
    assert singles[:, 0].sum() == pytest.approx(one.lmp.get_thermo("evdwl"), rel=1e-11)
    touched = singles[singles[:, 3] > 0]
    assert sorted(touched[:, 2]) == pytest.approx(sorted(dents[:, 2]), rel=1e-12)
    assert touched[:, [3, 4]].sum(axis=0) == pytest.approx(dents[:, [4, 7]].sum(axis=0), rel=1e-12)


@pytest.mark.parametrize("path", files("pair"), ids=lambda path: path.stem)
def test_pair_style(tester, path):
    """Forces at first and after 4 steps, and after restart and data files in between: as in
    LAMMPS's tester.
    """
    one = tester(path)
    folder = one.folder
    hybrid = "hybrid" in one.config["pair_style"]
    one.start()
    check(one, "init")
    check_sums(one)
    one.commands(
        f"write_restart {folder}/restart\nwrite_data {folder}/data pair ii\nwrite_coeff {folder}/coeffs"
    )
    one.go_on()
    check(one, "run", 5)
    check_sums(one)
    whole = one.atoms("f"), one.atoms("torque")
    one.restart(steps="pair_modify nofdotr\nrun 0 post no")
    check(one, "init")
    one.restart(coefficients=hybrid)
    check(one, "init")
    jumps = (
        "cohesion" in path.stem
    )  # the force has an addition in the steps in which surfaces meet or part, as the 2nd
    along = (
        not hybrid and "fix" not in one.config["prerequisites"]
    )  # cylinders are pressed along other lines
    if along and jumps:
        check_contacts(one)
    one.go_on(2)
    one.commands(f"write_restart {folder}/half")
    if along and not jumps:
        check_contacts(one)
    one.restart("half", coefficients=hybrid, dents=False)
    one.go_on(2)
    for found, before in zip((one.atoms("f"), one.atoms("torque")), whole, strict=True):
        assert differ(found, before) <= (
            1e-13 if "lj/cut" in one.config["pair_style"] else 0
        )  # its sums take any order
    one.data()
    check(one, "init")
    assert (
        "Pair Coeffs" not in (folder / "data").read_text()
        and "pair_coeff" not in (folder / "coeffs").read_text()
    )


@pytest.mark.parametrize("path", files("fix"), ids=lambda path: path.stem)
def test_fix(tester, path):
    one = tester(path)
    one.start()
    one.commands(f"write_restart {one.folder}/restart")
    one.go_on()
    check(one, "run")
    one.restart()
    one.go_on()
    check(one, "run")


@pytest.mark.parametrize("path", files("compute"), ids=lambda path: path.stem)
def test_compute(tester, path):
    one = tester(path)
    one.start()
    check(one, "run")


# Forces at the overlap d, the peak p, with E*, R* and closing speed: written from the equations of
# the manual, not from the headers.
E = 1.15e8
NU = 0.3
YIELD = 5.5e5


def hertz(d, p, e, r, speed):
    return 4 / 3 * e * r**0.5 * d**1.5


def scaled(curve, factor=1.6):
    """Law by its curve in units of the overlap and the force at first yield."""

    def force(d, p, e, r, speed):
        first = np.pi**2 / 4 * (factor * YIELD / e) ** 2 * r
        return hertz(first, 0, e, r, 0) * curve(d / first, max(d, p) / first)

    return force


def thornton(a, peak):
    """With C = 1: r is the effective radius of the flattened contact / R*."""
    top = peak**1.5 if peak <= 1 else 1.5 * peak - 0.5
    r = ((2 * top + 1) / 3) ** 1.5 / top if peak > 1 else 1.0
    left = peak - (top / r**0.5) ** (2 / 3)
    return top if a == peak else top * (max(a - left, 0) / (peak - left)) ** 1.5


def bilinear(d, p, e, r, speed):
    slope = 18.5 * YIELD * r
    peak = max(d, p)
    return slope * peak if d == peak else max(slope / 0.3 * (d - 0.7 * peak), 0)


def jkr(d, p, e, r, speed):
    work = 1e6
    least = (np.pi * work * r**2 / (8 * e)) ** (1 / 3)
    a = brentq(lambda a: a**2 / r - (2 * np.pi * work * a / e) ** 0.5 - d, least, r, xtol=1e-9)
    return 4 * e * a**3 / (3 * r) - (8 * np.pi * work * e * a**3) ** 0.5


def lossy(d, p, e, r, speed):
    return max(hertz(d, p, e, r, 0) + 0.3 * 2 * e * (r * d) ** 0.5 * speed, 0)


BRASS = scaled(LawTwin().force)
CHANGED = {"pressure_limit": 2.9, "residual_slope": 0.93, "unloading_exponent": 1.42}
CLOSED = {
    "hertz": hertz, "hertz_mixed": hertz, "friction": hertz, "rolling": hertz, "none": lambda *_: 0.0,
    "power": lambda d, *_: 3e9 * d**1.2, "elastoplastic": BRASS, "elastoplastic_dents": BRASS, "forgotten_list": BRASS,
    "friction_dents": BRASS, "friction_mindlin": BRASS, "friction_partial_slip": BRASS, "rolling_marshall": BRASS, "molecular": BRASS,
    "elastoplastic_published": scaled(LawTwin("published").force),
    "elastoplastic_constants": scaled(LawTwin(factor=1.7, **CHANGED).force, 1.7),
    "thornton": scaled(thornton, 1.0), "bilinear": bilinear, "cohesion_jkr": jkr, "loss_time": lossy, "loss_prony": hertz, "hybrid_overlay": BRASS,
}  # fmt: skip


@pytest.mark.parametrize("name", CLOSED)
def test_stored_forces_are_those_of_the_equations(name):
    """First forces of the files, computed from their geometry: contacts with and without dents,
    also across the boundary.
    """
    config = load(FOLDER / f"atomic-pair-gran_hysteretic_{name}.yaml")
    data = (
        (FOLDER / "data.granwave-spheres")
        .read_text()
        .partition("Atoms # sphere")[2]
        .split("Velocities")
    )
    atoms, moving = (
        np.array([line.split() for line in part.strip().splitlines()], dtype=float) for part in data
    )
    x = atoms[:, 4:7]
    radius = atoms[:, 2] / 2
    types = atoms[:, 1]
    v = moving[:, 1:4]
    dents = np.zeros((13, 13))
    if "gran/dents" in config["post_commands"]:
        for i, j, peak in np.loadtxt(FOLDER / "dents.granwave"):
            dents[int(i) - 1, int(j) - 1] = peak
    forces = np.zeros((13, 3))
    for i in range(13):
        for j in range(i + 1, 13):
            apart = x[i] - x[j]
            apart[0] -= 60000 * np.round(apart[0] / 60000)
            length = np.linalg.norm(apart)
            plane = [
                (1 - 0.29**2) / 2.1e8 if name == "hertz_mixed" and t == 2 else (1 - NU**2) / E
                for t in types[[i, j]]
            ]
            r = radius[i] * radius[j] / (radius[i] + radius[j])
            overlap = radius[i] + radius[j] - length
            speed = (v[j] - v[i]) @ apart / length
            force = (
                CLOSED[name](overlap, dents[i, j], 1 / sum(plane), r, speed) if overlap > 0 else 0.0
            )
            if name == "hybrid_overlay" and length < 11000:
                force += 24e14 / length * (2 * (9000 / length) ** 12 - (9000 / length) ** 6)
            forces[i] += force * apart / length
            forces[j] -= force * apart / length
    assert stored(config, "init_forces") == pytest.approx(
        forces, rel=1e-9, abs=1e-9 * np.abs(forces).max()
    )


FRICTION = FOLDER / "atomic-pair-gran_hysteretic_friction_dents.yaml"


@pytest.mark.parametrize(
    "again",
    [
        "pair_style gran/hysteretic 300.0",
        "pair_modify shift yes",
        "pair_modify tail yes mix geometric",
        "special_bonds lj 0.0 0.5 1.0",
    ],
)
def test_commands_that_change_nothing(tester, again):
    """A repeated pair_style keeps its contacts, and extract returns nothing: fix adapt cannot
    change a parameter.
    """
    one = tester(FRICTION)
    one.start()
    one.commands(again)
    one.coefficients()
    one.commands("run 0 post no")
    check(one, "init")
    assert one.lmp.extract_pair("gap") is None and one.lmp.extract_pair_dimension("gap") is None
    one.go_on()
    check(one, "run", 5)


@pytest.mark.parametrize("how", ["neigh_modify exclude type 2 2", "pair_coeff 2 2 none 1.15e8 0.3"])
def test_pairs_that_exert_no_force(tester, how):
    """Excluded pairs, and pairs of law none, behave like pairs that a hybrid style assigns to
    another style.
    """
    law = "elastoplastic 1.15e8 0.3 5.5e5 friction 0.3"
    one = tester(FRICTION)
    hybrid = tester(FRICTION)
    one.config["pair_coeff"] = f"1 * {law}\n2 2 {law}"
    one.config["post_commands"] = f"{how}\n{one.config['post_commands']}"
    hybrid.config["pair_style"] = "hybrid gran/hysteretic 300.0 zero 8600.0"
    hybrid.config["pair_coeff"] = f"1 * gran/hysteretic {law}\n2 2 zero"
    for tested in (one, hybrid):
        tested.start()
        tested.go_on()
    assert np.array_equal(one.atoms("f"), hybrid.atoms("f")) and np.array_equal(
        one.atoms("torque"), hybrid.atoms("torque")
    )
    assert differ(one.atoms("f"), stored(hybrid.config, "run_forces")) > 1e-3


WORDS = "friction tangential rolling twisting loss loss_tangential cohesion"


def test_every_style_law_and_option_has_a_file():
    """As LAMMPS's own check_tests.py: styles by their manual pages, laws and parameters by their
    table.
    """
    texts = {
        kind: "\n".join(path.read_text() for path in files(kind))
        for kind in ("pair", "fix", "compute")
    }
    for page in (FOLDER.parent / "doc").glob("*_*.md"):
        kind, _, name = page.read_text().partition("\n")[0].removeprefix("# ").partition(" ")
        if kind in texts:
            assert f"  {kind} {name.removesuffix(' command')}\n" in texts[kind], page.name
    words = set(texts["pair"].split())
    parameters = PARAMETERS.values()
    keywords = {p.keyword for p in parameters if p.of_material or not p.optional}
    assert set(LAWS) | keywords | set(WORDS.split()) <= words
    assert {
        "mindlin",
        "partial_slip",
        "marshall",
        "time",
        "dashpot",
        "jkr",
        "dmt",
        "published",
        "INF",
    } <= words


@pytest.mark.validation
@pytest.mark.parametrize("path", files("pair"), ids=lambda path: path.stem)
def test_two_processors(log_of, tmp_path, path):
    """The same values on two processors, with ghost atoms of both between them."""
    config = load(path)
    coefficients = "\n".join(f"pair_coeff {line}" for line in config["pair_coeff"].splitlines())
    log_of(
        f"variable input_dir index {FOLDER}\n{config['pre_commands']}\nprocessors 2 1 1\ninclude {FOLDER}/{config['input_file']}\n"
        f"pair_style {config['pair_style']}\n{coefficients}\n{config['post_commands']}\nthermo_style custom step evdwl\n"
        "fix 1 all nve\ndump end all custom 4 forces id fx fy fz\ndump_modify end sort id format float %.17g\nrun 4\n",
        ranks=2,
    )
    n = int(config["natoms"])
    rows = [
        line.split()
        for line in (tmp_path / "forces").read_text().splitlines()
        if len(line.split()) == 4 and line[0] != "I"
    ]
    found = np.array(rows, dtype=float)[:, 1:].reshape(2, n, 3)
    limit = float(config["epsilon"])
    assert differ(found[0], stored(config, "init_forces")) <= limit
    assert differ(found[1], stored(config, "run_forces")) <= 5 * limit
