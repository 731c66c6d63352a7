"""Compatibility of the styles with other LAMMPS commands: suffixes, frozen groups, several runs, data files, units."""

from __future__ import annotations

import pytest

from tests.conftest import script_of
from tests.helpers.two_spheres import R, collide, value


def test_omp_suffix_falls_back_to_the_plain_style(lammps):
    plain, suffixed = lammps(), lammps(options=("-sf", "omp", "-pk", "omp", "1"))
    collide(plain)
    collide(suffixed)
    assert value(suffixed, "vz[1]") == pytest.approx(value(plain, "vz[1]"), rel=1e-13)
    assert value(suffixed, "c_ep[1]") == pytest.approx(value(plain, "c_ep[1]"), rel=1e-13)


@pytest.mark.parametrize(
    "every", ["every 1 delay 0 check no", "every 7 delay 0 check yes", "every 1 delay 10 check yes"]
)
def test_any_neighbour_settings(lammps, every):
    usual, other = lammps(), lammps()
    collide(usual)
    collide(other, extra=f"neigh_modify {every}")
    assert value(other, "c_ep[1]") == pytest.approx(value(usual, "c_ep[1]"), rel=1e-12)


def test_frozen_sphere(lammps):
    """A fixed sphere acts as a wall of the same material: it absorbs momentum but no energy."""
    lmp = lammps()
    collide(lmp, speed=0.0, steps=0, extra="group held id 2\nfix hold held freeze\nset atom 1 vz 1.0")
    lmp.command("run 20000")
    assert value(lmp, "vz[2]") == 0
    mass = value(lmp, "mass[1]")
    assert value(lmp, "c_ke+pe+c_ep[1]") == pytest.approx(0.5 * mass, rel=1e-6)


def test_dents_do_not_go_into_data_files(lammps, tmp_path):
    """Data files contain positions and velocities, but no dents, for which LAMMPS has no section."""
    lmp = lammps()
    collide(lmp)
    lmp.command(f"write_data {tmp_path}/all.data nocoeff")
    again = lammps(
        f"units si\natom_style sphere\natom_modify map yes\nnewton off\nboundary m m m\nread_data {tmp_path}/all.data\n"
        "pair_style gran/hysteretic 1e-3\npair_coeff * * elastoplastic 115e9 0.3 550e6\ncompute ep all pair gran/hysteretic\n"
        "thermo_style custom step c_ep[1]\nrun 0"
    )
    assert value(again, "vz[1]") == pytest.approx(value(lmp, "vz[1]"), rel=1e-12)
    assert value(again, "c_ep[1]") == 0


def test_any_consistent_units(lammps):
    """Collision in centimeters, grams and seconds agrees with that in SI units."""
    si, cgs = lammps(), lammps()
    collide(si)
    text = script_of(
        [(0, 0, 0), (0, 0, 200 * R)],
        radius=100 * R,
        density=8.5,
        velocities=[(0, 0, 100.0), (0, 0, -100.0)],
        style="elastoplastic 115e10 0.3 550e7",
        gap=0.1,
    ).replace("units si", "units cgs")
    cgs.commands_string(text)
    cgs.command("run 20000")
    assert value(cgs, "vz[1]") == pytest.approx(100 * value(si, "vz[1]"), rel=1e-9)
    assert value(cgs, "c_ep[1]") == pytest.approx(1e7 * value(si, "c_ep[1]"), rel=1e-9)


def test_only_the_group_is_reported(lammps):
    lmp = lammps(
        script_of(
            [(0, 0, 0), (0, 0, 2 * R), (0.05, 0, 0), (0.05, 0, 2 * R)],
            velocities=[(0, 0, 1.0), (0, 0, -1.0)] * 2,
            extra="group some id 1 2\ncompute dents some gran/hysteretic/local\n"
            "compute sum some reduce sum c_dents[8] inputs local\nthermo_style custom step c_sum c_ep[1]",
        )
    )
    lmp.command("run 20000")
    assert value(lmp, "c_sum") == pytest.approx(0.5 * value(lmp, "c_ep[1]"), rel=1e-12)
