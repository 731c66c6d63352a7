"""Planes, rays, ranked dissipation and the growth of the plastic zone."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import stats

from granwave.analysis import Result, summarise, write_result
from granwave.analysis.measures import impact as dissipation
from granwave.analysis.measures import layer_peaks
from granwave.analysis.measures.force_decay import (
    ForceDecay,
    PowerDecay,
    exponential_of_depth,
    force_decay,
)
from granwave.analysis.measures.geometry import layers, planes, preferred_directions, section
from granwave.lammps_inputs import Lattice, struck_spheres
from granwave.lammps_inputs.packing.assembly import assemble
from tests.helpers.made_up import synthetic

SIZES = {
    "fcc": (9, 9, 7),
    "hcp": (9, 9, 7),
    "bcc": (9, 9, 9),
    "sc": (9, 9, 9),
    "square": (9, 9),
    "chain": (9,),
}
THREE_DIMENSIONAL = ("fcc", "hcp", "bcc", "sc")


def lattice_of(kind):
    lattice = Lattice(kind, SIZES[kind], 0.01)
    return lattice, lattice.positions(1, lattice.n_spheres), struck_spheres(lattice, 1)[0]


@pytest.mark.parametrize("kind", SIZES)
def test_preferred_directions_point_at_touching_spheres(kind):
    lattice, positions, struck = lattice_of(kind)
    neighbours = positions[[n - 1 for n in lattice.neighbours(struck)]] - positions[struck - 1]
    directions = preferred_directions(kind)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1, rtol=1e-14)
    below = neighbours[neighbours[:, 2] > 1e-6] / 0.01 if kind != "square" else neighbours / 0.01
    assert len(below) == len(directions)
    for direction in directions:
        assert np.min(np.linalg.norm(below - direction, axis=1)) < 1e-9


@pytest.mark.parametrize("kind", THREE_DIMENSIONAL)
def test_planes_have_orthonormal_axes_and_pass_the_struck_sphere(kind):
    _, positions, struck = lattice_of(kind)
    for plane in planes(kind):
        axes = np.stack([plane.across, plane.down, plane.normal])
        assert np.allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        cut = section(plane, positions, positions[struck - 1], 0.01)
        assert struck - 1 in cut.index
        assert len(cut.index) > 20
    assert [plane.name for plane in planes(kind)] == ["principal", "orthogonal"]


def test_principal_plane_of_fcc_is_close_packed_and_holds_two_preferred_directions():
    _, positions, struck = lattice_of("fcc")
    principal, orthogonal = planes("fcc")
    directions = preferred_directions("fcc")
    assert np.allclose(
        directions @ principal.normal, [0, 0, directions[2] @ principal.normal], atol=1e-14
    )
    assert np.allclose([directions[2] @ orthogonal.normal, orthogonal.normal[2]], 0, atol=1e-14)
    cut = section(principal, positions, positions[struck - 1], 0.01)
    place = np.stack([cut.across, cut.down], axis=1)
    distance = np.linalg.norm(place[:, None] - place[None], axis=-1)
    assert (np.abs(distance - 0.01) < 1e-9).sum(axis=1).max() == 6


def test_orthogonal_plane_of_fcc_is_a_mirror():
    """Away from the sides, the plane maps the neighbors of a sphere on it onto each other."""
    lattice, positions, struck = lattice_of("fcc")
    offset = positions[[n - 1 for n in lattice.neighbours(struck)]] - positions[struck - 1]
    mirrored = offset * [-1, 1, 1]
    assert all(np.min(np.linalg.norm(offset - image, axis=1)) < 1e-9 for image in mirrored)


@pytest.fixture
def result(tmp_path):
    synthetic.write_run(tmp_path, synthetic.make_case(size=(12, 12, 8)))
    write_result(tmp_path)
    with Result(tmp_path) as result:
        yield result


def test_rays_find_the_decay_and_are_equal(result):
    """Indentations, and thus forces, depend only on the distance from the impacted sphere."""
    rays = dissipation.rays(result)
    first_dent = synthetic.DENT * result.law.yield_overlap
    assert rays.peak_force.shape[1] == 3
    assert np.allclose(
        rays.peak_force[0], result.law.loading_force(np.array([first_dent]))[0], rtol=1e-12
    )
    second = first_dent * np.exp(-1 / synthetic.REACH)
    assert np.allclose(
        rays.peak_force[1], result.law.loading_force(np.array([second]))[0], rtol=1e-12
    )
    assert rays.difference.max(initial=0.0) < 1e-9
    assert len(rays.difference) >= 4


def test_a_difference_between_rays_shows(result):
    rays = dissipation.rays(result)
    changed = rays.peak_force.copy()
    changed[1, 2] *= 0.9
    changed_rays = dataclasses.replace(rays, peak_force=changed)
    assert changed_rays.difference.max(initial=0.0) == pytest.approx(0.1)


def test_ranked_and_cumulated(result):
    lost = result["spheres/dissipated_energy"]
    order = dissipation.ranked(lost)
    assert np.all(np.diff(lost[order]) <= 0) and np.all(lost[order] > 0)
    assert len(order) == np.count_nonzero(lost)
    fraction, volume = dissipation.cumulated(lost, result.energy_input)
    assert fraction[-1] == pytest.approx(0.75, rel=1e-12)
    assert volume[-1] == len(order) and np.all(np.diff(fraction, 2) <= 1e-15)


def test_zone_grows_to_that_of_the_summary(result):
    growth = dissipation.zone_growth(result)
    summary = summarise(result.path.parent)
    for values in (growth.time, growth.contacts, growth.spheres, growth.depth, growth.radius):
        assert np.all(np.diff(values) >= 0)
    assert growth.contacts[-1] == summary["n_plastic_contacts"]
    assert growth.spheres[-1] == summary["n_plastic_spheres"]
    assert growth.depth[-1] == pytest.approx(summary["plastic_zone_depth_m"], rel=1e-13)
    assert growth.radius[-1] == pytest.approx(summary["plastic_zone_radius_m"], rel=1e-13)


def test_peak_force_by_depth(result):
    depth, force = dissipation.peak_force_by_depth(result)
    assert len(depth) == 8
    assert np.allclose(np.diff(depth), 0.01 * np.sqrt(2 / 3), rtol=1e-5)
    assert force[0] == result["spheres/peak_force"].max() and np.all(np.diff(force) <= 0)


def test_decay_of_exponential_forces():
    """Rate and error are those of a linear regression of the logarithms."""
    depth = 0.008 * np.arange(1, 9)
    exact = exponential_of_depth(depth, 30.0 * np.exp(-55.0 * depth))
    assert (exact.rate, exact.force) == pytest.approx((55.0, 30.0), rel=1e-12)
    assert exact.error < 1e-10 and exact.misfit < 1e-12
    force = 30.0 * np.exp(-55.0 * depth + np.random.default_rng(1).normal(0.0, 0.2, 8))
    scattered = exponential_of_depth(depth, force)
    twin = stats.linregress(depth, np.log(force))
    assert (scattered.rate, scattered.error) == pytest.approx((-twin.slope, twin.stderr), rel=1e-10)
    assert scattered(depth) == pytest.approx(np.exp(twin.intercept + twin.slope * depth), rel=1e-10)


def test_decay_of_a_packing_is_the_better_law(result, monkeypatch):
    """The impacted layer, the deepest layer, and layers whose force still increases are excluded
    from the fit.
    """
    depth, force = dissipation.peak_force_by_depth(result)
    twins = {
        ForceDecay: stats.linregress(depth[1:-1], np.log(force[1:-1])),
        PowerDecay: stats.linregress(np.log(depth[1:-1]), np.log(force[1:-1])),
    }
    decay = force_decay(result)
    better = max(twins, key=lambda law: twins[law].rvalue ** 2)
    assert type(decay) is better
    slope = decay.rate if better is ForceDecay else decay.exponent
    assert (slope, decay.error) == pytest.approx(
        (-twins[better].slope, twins[better].stderr), rel=1e-9
    )
    rising = np.arange(len(depth)) > 3
    monkeypatch.setattr(layer_peaks, "still_rising", lambda *_: rising)
    assert force_decay(result) is None


def test_layers_of_a_packing_that_settled():
    """Layers settled by up to a twentieth of a diameter are unchanged; disordered ones are replaced
    by slices.
    """
    _, positions, _ = lattice_of("fcc")
    depth = positions[:, 2]
    radii = np.full(len(positions), 0.005)
    settled = depth + np.random.default_rng(1).uniform(-2.5e-4, 2.5e-4, len(depth))
    mean, layer = layers(settled, radii, 0.01)
    assert np.array_equal(layer, np.rint(depth / (0.01 * np.sqrt(2 / 3))).astype(int))
    assert np.allclose(mean, np.unique(depth.round(9)), atol=1e-4)
    mixed = np.random.default_rng(2).uniform(0, 0.06, len(depth))
    mean, layer = layers(mixed, radii, 0.01)
    assert len(mean) == 12 and np.all(np.abs(mixed - mean[layer]) < 0.005)


def test_beads_of_any_size_are_layers_of_their_own():
    radii = np.array([5.0, 5, 0.5, 0.5, 0.5, 5]) * 1e-3
    depth = np.concatenate([[0.0], np.cumsum(radii[1:] + radii[:-1])])
    assert np.allclose(layers(depth, radii, 0.01)[0], depth, rtol=1e-14)


def test_rays_pass_a_missing_sphere(tmp_path):
    """Ray whose third sphere is missing: so are two of its contacts, but not those below."""
    case = synthetic.make_case(size=(12, 12, 8))
    struck = struck_spheres(assemble(case).lattice, 1)[0]
    positions = assemble(case).lattice.positions(1, assemble(case).lattice.n_spheres)
    place = positions[struck - 1] + 2 * 0.01 * preferred_directions("fcc")[0]
    gone = 1 + int(np.argmin(np.linalg.norm(positions - place, axis=1)))
    synthetic.write_run(
        tmp_path, synthetic.make_case(size=(12, 12, 8), packing={"vacancies": [gone]})
    )
    with Result(write_result(tmp_path)) as result:
        found = dissipation.rays(result)
        assert (
            np.isnan(found.peak_force[1:3, 0]).all()
            and np.isfinite(found.peak_force[[0, 3], 0]).all()
        )
        assert np.isfinite(found.peak_force[:4, 1:]).all()
        assert found.difference.max(initial=0.0) < 1e-9
        growth = dissipation.zone_growth(result)
        summary = summarise(tmp_path)
        assert growth.contacts[-1] == summary["n_plastic_contacts"]
        assert growth.depth[-1] == pytest.approx(summary["plastic_zone_depth_m"], rel=1e-13)


def test_cumulated_volume_of_unlike_spheres():
    lost = np.array([1.0, 3.0, 0.0, 2.0])
    volume = np.array([1.0, 0.5, 1.0, 2.0])
    fraction, total = dissipation.cumulated(lost, 12.0, volume)
    assert np.allclose(fraction, [0.25, 5 / 12, 0.5]) and np.allclose(total, [0.5, 2.5, 3.5])
