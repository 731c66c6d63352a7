"""Faces of regions of LAMMPS as walls: equal to planes and tubes, closed forms, rejected input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from granwave._contact_laws import elliptic_radius
from tests.helpers.bodies.thrown_sphere import R, state, thrown
from tests.helpers.bodies.two_spheres import value

MASS = 8500 * 4 / 3 * np.pi * R**3
MODULUS = 115e9 / (1 - 0.3**2)
HERTZ = "hertz 115e9 0.3"
YIELDS = "elastoplastic 115e9 0.3 550e6 friction 0.3"
FRICTION = "hertz 115e9 0.3 friction 0.3"


def wall(region: str, face: str, law: str = HERTZ) -> str:
    fix = f"fix wall all wall/gran/hysteretic region shape {face} {law}"
    return f"region shape {region} units box\n{fix}"


@pytest.mark.parametrize("law", [HERTZ, FRICTION, YIELDS])
def test_a_plane_of_a_region_is_a_plane(lammps: Any, law: str) -> None:
    place = (0.0, 0.0, 0.0069)
    velocity = (0.5, 0.3, 2.0)
    plane = f"fix wall all wall/gran/hysteretic zplane NULL 0.01 {law}"
    ends = []
    for walls in (plane, wall("plane 0 0 0.01 0 0 -1", "all", law)):
        lmp = lammps()
        thrown(lmp, place, velocity, 4000, walls)
        ends.append([*state(lmp), value(lmp, "f_wall[5]"), value(lmp, "f_wall[9]")])
    assert ends[0] == pytest.approx(ends[1], rel=1e-9, abs=1e-14)
    assert ends[0][5] < 0


@pytest.mark.parametrize("law", [HERTZ, YIELDS])
def test_the_side_of_a_cylinder_is_a_tube(lammps: Any, law: str) -> None:
    ends = []
    tube = f"fix wall all wall/gran/hysteretic tube 0.0077 {law}"
    for walls in (tube, wall("cylinder z 0 0 0.0077 INF INF", "side", law)):
        lmp = lammps()
        thrown(lmp, (0.003, 0.0035, 0.001), (3.0, 0.5, 1.0), 9000, walls)
        ends.append([*state(lmp), value(lmp, "f_wall[5]"), value(lmp, "f_wall[9]")])
    assert ends[0] == pytest.approx(ends[1], rel=1e-7, abs=1e-12)


@pytest.mark.parametrize(
    ("region", "face", "place", "towards", "effective"),
    [
        ("sphere 0 0 0 0.02", "all", (0, 0, 0.0169), (0, 0, 1), 1 / (1 / R - 1 / 0.02)),
        ("sphere 0 0 0 0.02 side out", "all", (0, 0.0231, 0), (0, -1, 0), 1 / (1 / R + 1 / 0.02)),
        (
            "cylinder x 0 0 0.02 INF INF side out", "all", (0, 0.0231, 0), (0, -1, 0),
            elliptic_radius(1 / R, 1 / R + 1 / 0.02),
        ),
        ("cone z 0 0 0.01 0.02 -0.02 0.02", "lo", (0, 0, -0.0169), (0, 0, -1), R),
    ],
)  # fmt: skip
def test_stiffness_follows_from_the_curvature(
    lammps: Any, region: str, face: str, place: Any, towards: Any, effective: float
) -> None:
    lmp = lammps()
    thrown(lmp, place, tuple(2.0 * one for one in towards), 2700, wall(region, face))
    x = lmp.numpy.extract_atom("x")[0]
    overlap = (x - place) @ np.array(towards) - 1e-4
    assert overlap > 1e-6
    force = 4 / 3 * MODULUS * np.sqrt(effective) * overlap**1.5
    assert value(lmp, "f_wall[1]") == pytest.approx(force, rel=1e-7)
    assert lmp.numpy.extract_atom("f")[0] @ np.array(towards) == pytest.approx(-force, rel=1e-7)
    lmp.command("run 8000")
    assert lmp.numpy.extract_atom("v")[0] @ np.array(towards) == pytest.approx(-2.0, rel=1e-5)


BLOCK = "block -0.01 0.02 -0.01 0.02 -0.01 0.02"
ROUND = "cylinder y 0 0 0.02 -0.01 0.02"
CONE = "cone z 0 0 0.01 0.02 -0.01 0.02"
SLOPE = np.arctan2(0.01, 0.03)


@pytest.mark.parametrize(
    ("region", "face", "normal", "distance"),
    [
        *((BLOCK, f"{axis}lo", -np.eye(3)[n], 0.01) for n, axis in enumerate("xyz")),
        *((BLOCK, f"{axis}hi", np.eye(3)[n], 0.02) for n, axis in enumerate("xyz")),
        (ROUND, "lo", -np.eye(3)[1], 0.01),
        (ROUND, "hi", np.eye(3)[1], 0.02),
        (ROUND, "side", np.array([0.6, 0, 0.8]), 0.02),
        (CONE, "lo", -np.eye(3)[2], 0.01),
        (CONE, "hi", np.eye(3)[2], 0.02),
        (
            CONE, "side", np.array([np.cos(SLOPE), 0, -np.sin(SLOPE)]),
            (0.01 + 0.01 / 3) * np.cos(SLOPE),
        ),
        ("plane 0.01 0 0 -0.6 0.8 0", "all", np.array([0.6, -0.8, 0]), 0.006),
    ],
)  # fmt: skip
def test_every_face_reflects(
    lammps: Any, region: str, face: str, normal: np.ndarray, distance: float
) -> None:
    """A sphere that hits a face along its normal rebounds; only the wall acts on it."""
    lmp = lammps()
    flight = distance - R - 1e-5
    velocity = 2.0 * normal
    thrown(lmp, tuple(flight * normal), tuple(velocity), 5000, wall(region, face))
    x = lmp.numpy.extract_atom("x")[0]
    v = lmp.numpy.extract_atom("v")[0]
    assert v == pytest.approx(-velocity, abs=2e-5)
    assert x @ normal < flight
    assert value(lmp, "f_wall") == 0


def test_a_sphere_leaves_a_hopper_over_its_rim(lammps: Any) -> None:
    """Beyond an open end the rim still pushes: the energy balance closes for a sphere that is
    squeezed past it.
    """
    lmp = lammps()
    hopper = "cone z 0 0 0.005 0.02 0.0 0.02 open 1 open 2"
    thrown(lmp, (0.00202, 0.0, 1e-6), (0.0, 0.0, -1.0), 0, wall(hopper, "side"))
    whole = value(lmp, "c_ke+f_wall")
    beyond = []
    for _ in range(40):
        lmp.command("run 10")
        if lmp.numpy.extract_atom("x")[0][2] < 0:
            beyond.append(value(lmp, "f_wall"))
        assert value(lmp, "c_ke+f_wall") == pytest.approx(whole, rel=1e-4)
    assert max(beyond) > 0.01 * whole
    lmp.command("run 20000")
    assert value(lmp, "c_ke") == pytest.approx(whole, rel=1e-4)


@pytest.mark.parametrize(
    ("region", "face", "message"),
    [
        ("sphere 0 0 0 0.02", "side", "a face of the sphere is one of all, found side"),
        (BLOCK, "top", "a face of the block is one of xlo, xhi, ylo, yhi, zlo, zhi, found top"),
        (f"{ROUND} open 1", "lo", "face lo of region shape is open"),
        (
            "prism 0 1 0 1 0 1 0 0 0",
            "all",
            "a region is of style plane, sphere, block, cylinder or",
        ),
        ("cylinder z 0 0 0.02 0 1 side out", "all", "give it the bounds INF INF"),
        ("sphere v_a 0 0 0.02", "all", "moves or changes its shape, expected one at rest"),
    ],
)
def test_what_is_refused(lammps: Any, region: str, face: str, message: str) -> None:
    lmp = lammps()
    with pytest.raises(Exception, match=message):
        thrown(lmp, (0, 0, 0), (0, 0, 0), 0, "variable a equal 0\n" + wall(region, face))


def test_a_support_and_a_region_that_is_not_there_are_refused(lammps: Any) -> None:
    with pytest.raises(Exception, match="support moves a plane, found a region"):
        thrown(lammps(), (0, 0, 0), (0, 0, 0), 0, wall(BLOCK, "zhi", f"{HERTZ} support 1 1 1"))
    missing = f"fix wall all wall/gran/hysteretic region none all {HERTZ}"
    with pytest.raises(Exception, match="there is no region none"):
        thrown(lammps(), (0, 0, 0), (0, 0, 0), 0, missing)
