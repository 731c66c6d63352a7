"""LAMMPS's own unit tests of pair styles, fixes and computes, on all of ours: the files of plugins/unittest."""

from __future__ import annotations

import numpy as np
import pytest

from tests.helpers.force_styles import StyleTester, differ, files, stored


@pytest.fixture
def tester(lammps, tmp_path):
    """StyleTester of a file, not begun yet."""
    return lambda path: StyleTester(lammps(), path, tmp_path)


def check(one: StyleTester, when: str, factor: float = 1.0) -> None:
    """Assert that the values are those of the file."""
    limit = factor * float(one.config["epsilon"])
    for name, value in one.measured(when).items():
        assert differ(value, stored(one.config, name)) <= limit, f"{name}, {when}"


def check_sums(one: StyleTester) -> None:
    """Energies and virials of the atoms sum to those of all; LAMMPS's stress/atom is the negative virial."""
    energy, virial = one.lmp.get_thermo("evdwl"), one.virial()
    assert one.lmp.extract_compute("sum_of_pe", 0, 0) == pytest.approx(energy, rel=1e-12)
    assert -one.compute("sum_of_stress") == pytest.approx(
        virial, rel=1e-11, abs=1e-13 * np.abs(virial).max(initial=0.0)
    )


SINGLES = """compute ids all property/local patom1 patom2
compute singles all pair/local eng force p1 p2 p4
compute dents all gran/hysteretic/local
group few id 1:5
group rest subtract all few
compute across few group/group rest
run 0 post no"""


def check_contacts(one: StyleTester) -> None:
    """Values of `single()` and of the compute of contacts, which sum to the forces and energies of the run."""
    n, x = one.lmp.get_natoms(), one.atoms("x")
    one.commands(SINGLES)
    ids, singles, dents = (one.lmp.numpy.extract_compute(name, 2, 2).copy() for name in ("ids", "singles", "dents"))
    pairs = np.sort(ids.astype(int)) - 1
    forces, across = np.zeros((n, n, 3)), np.arange(n) < 5
    normal = x[pairs[:, 0]] - x[pairs[:, 1]]
    normal[:, 0] -= 60000 * np.round(normal[:, 0] / 60000)  # the periodic length
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    forces[pairs[:, 0], pairs[:, 1]] = singles[:, 1, None] * normal
    pressed = (forces - forces.transpose(1, 0, 2))[across][:, ~across].sum(axis=(0, 1))
    assert one.compute("across") == pytest.approx(pressed, rel=1e-10), "compute group/group has the normal forces"
    forces[tuple(dents[:, :2].astype(int).T - 1)] += dents[:, 17:20]
    assert forces.sum(axis=1) - forces.sum(axis=0) == pytest.approx(one.atoms("f"), rel=1e-10)
    assert singles[:, 0].sum() == pytest.approx(one.lmp.get_thermo("evdwl"), rel=1e-11)
    touched = singles[singles[:, 3] > 0]
    assert sorted(touched[:, 2]) == pytest.approx(sorted(dents[:, 2]), rel=1e-12)
    assert touched[:, [3, 4]].sum(axis=0) == pytest.approx(dents[:, [4, 7]].sum(axis=0), rel=1e-12)


@pytest.mark.parametrize("path", files("pair"), ids=lambda path: path.stem)
def test_pair_style(tester, path):
    """Forces at first and after 4 steps, and after restart and data files in between: as LAMMPS's tester does it."""
    one = tester(path)
    folder, hybrid = one.folder, "hybrid" in one.config["pair_style"]
    one.start()
    check(one, "init")
    check_sums(one)
    one.commands(f"write_restart {folder}/restart\nwrite_data {folder}/data pair ii\nwrite_coeff {folder}/coeffs")
    one.go_on()
    check(one, "run", 5)
    check_sums(one)
    whole = one.atoms("f"), one.atoms("torque")
    one.restart(steps="pair_modify nofdotr\nrun 0 post no")
    check(one, "init")
    one.restart(coefficients=hybrid)
    check(one, "init")
    jumps = "cohesion" in path.stem  # the force has an addition in the steps in which surfaces meet or part, as the 2nd
    along = not hybrid and "fix" not in one.config["prerequisites"]  # cylinders are pressed along other lines
    if along and jumps:
        check_contacts(one)
    one.go_on(2)
    one.commands(f"write_restart {folder}/half")
    if along and not jumps:
        check_contacts(one)
    one.restart("half", coefficients=hybrid, dents=False)
    one.go_on(2)
    for found, before in zip((one.atoms("f"), one.atoms("torque")), whole, strict=True):
        assert differ(found, before) <= (1e-13 if "lj/cut" in one.config["pair_style"] else 0)  # its sums take any order
    one.data()
    check(one, "init")
    assert "Pair Coeffs" not in (folder / "data").read_text() and "pair_coeff" not in (folder / "coeffs").read_text()


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
