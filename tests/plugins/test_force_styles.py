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


@pytest.mark.parametrize("path", files("pair"), ids=lambda path: path.stem)
def test_pair_style(tester, path):
    one = tester(path)
    one.start()
    check(one, "init")
    check_sums(one)
    folder = one.folder
    one.commands(f"write_restart {folder}/restart\nwrite_data {folder}/data pair ii\nwrite_coeff {folder}/coeffs")
    one.go_on()
    check(one, "run", 5)
    check_sums(one)
    for modify in ("", "pair_modify nofdotr\n"):
        one.restart(f"{modify}run 0 post no")
        check(one, "init")
    one.data()
    check(one, "init")


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
