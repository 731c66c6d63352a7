"""Walls of LAMMPS compared with the closed form of a grazing impact, as on the page of fix
wall/gran/hysteretic.
"""

from __future__ import annotations

import math

import pytest

ANGLE = math.radians(76)  # of the velocity, from the normal of the wall
FRICTION = 0.5
WALL = f"{FRICTION} 1"
CLASSIC = "wall/gran {} 1e-9 NULL " + WALL
# a sphere that slides throughout: the normal velocity is reversed, friction changes the others
SLIDING = 2 * FRICTION * math.cos(ANGLE)
CLOSED_FORM = (math.sin(ANGLE) - SLIDING) ** 2 + math.cos(ANGLE) ** 2 + 0.4 * (2.5 * SLIDING) ** 2
WALLS = {
    "hooke": (f"wall/gran hooke 1e5 NULL 1e-9 1e9 {WALL} zplane -0.02 NULL", CLOSED_FORM),
    "granular": (
        "wall/gran granular hertz/material 1e8 0 0.3 tangential mindlin NULL 0 0.5"
        " damping velocity zplane -0.02 NULL",
        CLOSED_FORM,
    ),
    "hysteretic": (
        f"wall/gran/hysteretic zplane -0.02 NULL hertz 1e8 0.3 friction {FRICTION}",
        CLOSED_FORM,
    ),
    # the release that granwave is built for; corrected in LAMMPS in 2026
    "hooke/history": (CLASSIC.format("hooke/history 1e5 2.857e4") + " zplane -0.02 NULL", 0.999),
    "hertz/history": (CLASSIC.format("hertz/history 1e8 NULL") + " zplane -0.02 NULL", 0.816),
}


@pytest.mark.parametrize("name", WALLS)
def test_grazing_impact(lammps, name: str):
    wall, expected = WALLS[name]
    script = [
        "units si\natom_style sphere\natom_modify map array\nnewton off\ncomm_modify vel yes",
        "boundary m m f\nregion b block -1 1 -1 1 -0.02 0.02\ncreate_box 1 b",
        "create_atoms 1 single 0 0 -0.0149\nset atom 1 diameter 0.01 density 2500",
        f"velocity all set {math.sin(ANGLE)} 0 {-math.cos(ANGLE)}",
        "pair_style gran/hysteretic 1e-3\npair_coeff * * hertz 1e8 0.3",
        "neighbor 0.002 bin\nfix motion all nve/sphere\ntimestep 5e-7",
        f"fix wall all {wall}",
        "compute translation all ke\ncompute rotation all erotate/sphere\nrun 0",
    ]
    instance = lammps("\n".join(script))
    start = instance.extract_compute("translation", 0, 0)
    instance.command("run 4000")
    end = sum(instance.extract_compute(kind, 0, 0) for kind in ("translation", "rotation"))
    assert end / start == pytest.approx(expected, abs=1e-3)
    assert instance.numpy.extract_atom("v")[0, 2] > 0.99 * math.cos(ANGLE)
