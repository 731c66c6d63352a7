"""Statistics of packings: closed forms of lattices, of a random medium, and of an exponential."""

import json
import math

import numpy as np
import pytest

from granwave.extensions.packings.bed_statistics import statistics_rows, statistics_values
from granwave.extensions.packings.statistics import (
    PackingStatistics,
    anisotropy,
    coordination,
    depth_profile,
    exponential_tail,
    fabric,
    force_distribution,
    force_over_mean_at_depth,
    solid_fraction,
    without_rattlers,
)
from granwave.lammps_inputs.lattices import Lattice

FCC = math.pi / (3 * math.sqrt(2))


def fcc(n=6):
    """Return positions, pairs and periods of a periodic block of fcc with layers along z."""
    lattice = Lattice("fcc", (n, n, 9), 1.0, periodic=True)
    pairs = np.concatenate(list(lattice.pairs())) - 1
    return lattice.positions(1, lattice.n_spheres), pairs, lattice.lengths


def test_solid_fraction_of_fcc():
    places, _, period = fcc()
    spacing = math.sqrt(2 / 3)
    low = np.array([0.0, 0.0, 2 * spacing])
    high = np.array([*period, 5 * spacing])  # a whole period of three layers
    found = solid_fraction(places, np.ones(len(places)), low, high, period)
    assert found == pytest.approx(FCC, abs=2e-3)


def test_depth_profile_is_exact():
    diameter = np.array([0.2])
    whole = depth_profile(np.array([[0.0, 0.0, 0.5]]), diameter, 1.0, np.array([0.0, 0.5, 1.0]))
    half = math.pi / 12 * 0.2**3 / 0.5
    np.testing.assert_allclose(whole, [half, half], rtol=1e-12)


def test_coordination_and_fabric_of_fcc():
    places, pairs, period = fcc()
    inside = (places[:, 2] > 1.0) & (places[:, 2] < 5.0)
    assert (coordination(len(places), pairs)[inside] == 12).all()
    of_inner = pairs[inside[pairs].any(axis=1)]
    apart = places[of_inner[:, 1]] - places[of_inner[:, 0]]
    apart[:, :2] -= np.round(apart[:, :2] / period) * period
    weights = inside[of_inner].sum(axis=1)  # contacts of inner spheres, counted from each side
    directions = np.repeat(apart, weights, axis=0)
    tensor = fabric(directions)
    np.testing.assert_allclose(tensor, np.eye(3) / 3, atol=1e-12)
    assert anisotropy(tensor) < 1e-12


def test_anisotropy_of_parallel_contacts_is_one():
    assert anisotropy(fabric(np.tile([0.0, 0.0, 1.0], (5, 1)))) == pytest.approx(1.0)


def test_walls_hold_grains_too():
    """A pyramid of four grains on a floor: the top grain rests on three grains, each in contact
    with the floor and the top grain.
    """
    pairs = np.array([[0, 3], [1, 3], [2, 3], [0, 1], [0, 2], [1, 2]])
    floor = np.array([1, 1, 1, 0])
    assert without_rattlers(4, pairs, least=3).all()
    assert not without_rattlers(4, pairs, least=4).any()
    pairs = pairs[:3]
    assert not without_rattlers(4, pairs, least=2).any()
    assert without_rattlers(4, pairs, least=2, at_walls=floor).all()


def test_rattlers_are_removed_one_after_the_other():
    # a ring of four, with a tail of two grains and a free one
    pairs = np.array([[0, 1], [1, 2], [2, 3], [3, 0], [3, 4], [4, 5]])
    assert without_rattlers(7, pairs).tolist() == [True] * 4 + [False] * 3
    assert not without_rattlers(7, pairs, least=4).any()


def test_tail_of_exponential_forces():
    force = np.random.default_rng(1).exponential(3.0, 100_000)
    assert exponential_tail(force) == pytest.approx(1.0, rel=0.02)
    middle, density = force_distribution(force)
    assert (density * np.diff(middle)[0]).sum() == pytest.approx(1.0)


def test_force_over_the_mean_at_its_depth_does_not_grow_with_depth():
    random = np.random.default_rng(2)
    depth = random.uniform(0, 1, 6000)
    force = depth * random.exponential(1.0, 6000)
    relative = force_over_mean_at_depth(force, depth)
    upper = relative[depth < 0.5].mean()
    assert upper == pytest.approx(1.0, rel=0.02)
    assert exponential_tail(relative) == pytest.approx(1.0, rel=0.1)


def test_a_shallow_bed_says_why_a_value_is_missing():
    none = math.nan
    found = PackingStatistics(
        n_grains=12, n_contacts=9, solid_fraction=none, coordination=none,
        coordination_without_rattlers=none, rattlers=none, anisotropy=0.1, fabric=np.eye(3) / 3,
        force_tail=none, mean_force=0.1, largest_force=0.2, pressure=none,
    )  # fmt: skip
    rows = dict(statistics_rows(found, friction=True))
    assert rows["grains"] == "12"
    assert "less than one diameter deep" in rows["solid fraction"]
    assert "no grain is one diameter away" in rows["coordination"]
    assert "too few contacts" in rows["tail of the forces"]
    assert not any("nan" in text for text in rows.values())
    json.dumps(statistics_values(found), allow_nan=False)
