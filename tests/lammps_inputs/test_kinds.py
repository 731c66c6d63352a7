"""Kinds of static loads, bottoms and sides: each has its classes, and consistent flags."""

from __future__ import annotations

import pytest

from granwave.lammps_inputs.case.boundary import SUPPORTS, Boundary
from granwave.lammps_inputs.case.bounds import BOTTOMS, SIDES, is_target
from granwave.lammps_inputs.case.material import presets
from granwave.lammps_inputs.case.precompression import STATIC_LOADS, Precompression
from granwave.lammps_inputs.contact.static_load import DEAD_LOADS


def test_every_static_load_has_its_forces() -> None:
    assert set(DEAD_LOADS) == set(STATIC_LOADS)


@pytest.mark.parametrize(
    ("flag", "kinds"),
    [
        ("is_even", {"uniaxial", "uniform"}),
        ("on_top", {"uniaxial"}),
        ("on_all_faces", {"uniform"}),
        ("grows_with_depth", {"gravity"}),
        ("moves_walls", {"walls", "overlaps"}),
        ("across_alone", {"walls"}),
        ("from_overlaps", {"overlaps"}),
    ],
)
def test_flags_of_static_loads(flag: str, kinds: set[str]) -> None:
    assert {name for name, load in STATIC_LOADS.items() if getattr(load, flag)} == kinds


def test_sizes_of_static_loads() -> None:
    pressure = Precompression(kind="uniform", pressure=1e5)
    assert pressure.rule.size_of(pressure) == ("pressure", "Pa")
    force = Precompression(kind="uniaxial", force=2.0)
    assert force.rule.size_of(force) == ("force", "N")
    weight = Precompression(kind="gravity")
    assert weight.rule.size_of(weight) == ("acceleration", "m/s^2")
    assert weight.rule.words(weight) == ["weight at 9.81 m/s^2"]


@pytest.mark.parametrize(
    ("flag", "kinds"),
    [
        ("has_plane", {"wall"}),
        ("holds_layer", {"fixed"}),
        ("bears", {"wall", "fixed", "periodic"}),
        ("repeats", {"periodic"}),
        ("stops", {"wall", "fixed"}),
    ],
)
def test_flags_of_bottoms(flag: str, kinds: set[str]) -> None:
    assert {name for name, bottom in BOTTOMS.items() if getattr(bottom, flag)} == kinds


@pytest.mark.parametrize(
    ("flag", "kinds"),
    [("has_planes", {"wall"}), ("repeats", {"periodic"}), ("is_free", {"free"})],
)
def test_flags_of_sides(flag: str, kinds: set[str]) -> None:
    assert {name for name, sides in SIDES.items() if getattr(sides, flag)} == kinds


def test_a_boundary_has_the_rules_of_its_kinds() -> None:
    boundary = Boundary(bottom="fixed", sides="periodic")
    assert boundary.bottom_rule.holds_layer
    assert boundary.periodic
    assert not Boundary().periodic


@pytest.mark.parametrize(
    ("bottom", "expected"),
    [
        ("wall", True),
        ("fixed", True),
        ("free", False),
        ("periodic", False),
        ({"material": "steel"}, True),
    ],
)
def test_targets(bottom: object, expected: bool) -> None:
    assert is_target(bottom) is expected


def test_surfaces_without_an_echo() -> None:
    """Half-spaces with a radius, and infinite bars: sqrt(E rho) A."""
    steel = presets()["steel"]
    bar = SUPPORTS["bar"](length=1.0, area=1e-4)
    impedance = 1e-4 * (steel.youngs_modulus * steel.density) ** 0.5
    assert bar.absorber(steel) == (0.0, pytest.approx(impedance))
    assert SUPPORTS["bar"](length=1.0, area=1e-4, end="fixed").absorber(steel) is None
    assert SUPPORTS["half_space"]().absorber(steel) is None
    disc = SUPPORTS["half_space"](radius=0.05)
    behind = disc.backing(steel, 0.05)
    assert disc.absorber(steel) == (behind.stiffness, behind.damping)
    assert SUPPORTS["plate"](mass=1.0, stiffness=1e6).absorber(None) is None


def test_a_damper_alone_is_one() -> None:
    assert SUPPORTS["damper"](damping=200.0).backing(None, 0.0).is_damper
    assert not SUPPORTS["plate"](mass=1.0, stiffness=1e6).backing(None, 0.0).is_damper
