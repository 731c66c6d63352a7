"""Flat faces of bars: the plane of the law, dents, strengths without end, messages."""

from __future__ import annotations

import numpy as np
import pytest

from granwave._contact_laws import ContactLaw
from tests.conftest import script_of
from tests.helpers.pushed import MASS
from tests.helpers.two_spheres import BOX, R, value


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


def test_forgotten_dent_in_a_face_stays_in_the_account(lammps):
    lmp = on_a_face(lammps(), steps=1000)
    lmp.command("run 19000")
    lost = value(lmp, "c_ep[1]")
    lmp.command("run 200000")  # far beyond the gap
    assert value(lmp, "z[2]-z[1]") > R + 1e-3
    assert value(lmp, "c_ep[1]") == pytest.approx(lost, rel=1e-12)


def test_faces_never_touch_and_fall_through_no_wall(lammps):
    lmp = lammps(
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
