"""Sizes of the plastic zone between layers, the impact axis, and yielding without dissipation."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from granwave.analysis import Result, summarise, write_result
from granwave.analysis.figures.sections import cut_of
from granwave.analysis.measures.impact import zone_growth
from granwave.analysis.measures.zone_size import (
    extent_holding,
    interpolated_extent,
    packing_zone,
)
from granwave.analysis.quantities import SHARES
from granwave.lammps_inputs import sphere_contact
from granwave.lammps_inputs.packing.motion import impacted_of
from tests.helpers.made_up import synthetic

D = synthetic.DIAMETER
LAYER = D * math.sqrt(2 / 3)  # spacing of the layers of fcc
FIRST_LOSS = 1.083  # alpha_y up to which the default law dissipates nothing, as the pages say


def analysed(directory, **options):
    synthetic.write_run(directory, synthetic.make_case(**options))
    write_result(directory)
    return summarise(directory)


# ---------------------------------------------------------------------- between layers


def test_straight_between_layers():
    """Half the energy in the first layer, half in the second: the 75 % depth is half-way between
    them.
    """
    depth = np.array([0.0, 0.0, 1.0])
    energy = np.array([1.0, 1.0, 2.0])
    assert interpolated_extent(depth, energy, 0.75) == pytest.approx(0.5)
    assert interpolated_extent(depth, energy, 0.5) == 0.0
    assert interpolated_extent(depth, energy, 0.4) == 0.0
    assert interpolated_extent(depth, energy, 1.0) == 1.0
    assert extent_holding(depth, energy, 0.75) == 1.0


def test_a_shell_with_little_energy_is_crossed_by_a_small_change():
    """The interpolated radius is continuous, but steep: a change of the dissipation by 1 % moves it
    across a shell that dissipates 0.2 %. The values are of `fcc-small` with 10 x 10 x 6 spheres.
    """
    radius = np.array([15.3, 17.3, 20.0, 20.8, 50.0])
    regular = np.diff([0.0, 0.8643, 0.9004, 0.9023, 0.9310, 1.0])
    scattered = np.diff([0.0, 0.8529, 0.8910, 0.8927, 0.9213, 1.0])
    sizes = [
        interpolated_extent(radius, regular + part * (scattered - regular), 0.9)
        for part in np.linspace(0, 1, 1001)
    ]
    assert sizes[0] < 17.3
    assert sizes[-1] > 20.0
    assert np.abs(np.diff(sizes)).max() < 0.05


def test_parts_without_energy_and_the_order_of_the_rows_do_not_matter():
    depth = np.array([0.0, 1.0, 2.0, 5.0])
    energy = np.array([1.0, 0.0, 1.0, 0.0])
    assert interpolated_extent(depth, energy, 0.75) == pytest.approx(1.0)
    assert interpolated_extent(depth[::-1], energy[::-1], 0.75) == pytest.approx(1.0)
    assert interpolated_extent(depth, np.zeros(4), 0.9) == 0.0
    assert interpolated_extent(np.empty(0), np.empty(0), 0.9) == 0.0


def test_exponential_decay_in_layers_has_its_closed_form():
    """Layer k contains r^k: all layers down to k contain 1 - r^(k + 1), with linear interpolation
    between them.
    """
    ratio = 0.5
    layers = np.arange(60)
    energy = ratio**layers * (1 - ratio)
    for share in np.linspace(0.55, 0.99, 23):
        before = math.ceil(math.log(1 - share) / math.log(ratio) - 1) - 1
        within = 1 - ratio ** (before + 1)
        expected = before + (share - within) / (ratio ** (before + 1) * (1 - ratio))
        assert interpolated_extent(layers, energy, share) == pytest.approx(expected, rel=1e-9)


def test_the_size_rises_with_the_load_where_that_of_layers_stands():
    """A zone that grows in small steps: its size increases in every step, by less than a layer."""
    depth = np.arange(30.0)
    lengths = np.linspace(1.5, 1.9, 21)
    energies = [np.exp(-depth / length) for length in lengths]
    between = np.array([interpolated_extent(depth, energy, 0.9) for energy in energies])
    by_layers = np.array([extent_holding(depth, energy, 0.9) for energy in energies])
    assert len(np.unique(by_layers)) <= 3
    assert np.all(np.diff(between) > 0)
    assert np.all(between <= by_layers)
    assert np.all(between > by_layers - 1)


def test_parts_that_are_fine_give_the_same_size():
    depth = (np.arange(200_000) + 0.5) * 1e-4
    for share in (0.5, 0.9, 0.99):
        found = interpolated_extent(depth, np.exp(-depth), share)
        assert found == pytest.approx(-math.log(1 - share), abs=1e-4)


def test_summaries_have_both(tmp_path):
    summary = analysed(tmp_path, size=(9, 9, 5))
    for percent in SHARES:
        between = summary[f"zone_depth_{percent}_interpolated_m"]
        by_layers = summary[f"zone_depth_{percent}_m"]
        assert by_layers - LAYER < between <= by_layers
        assert (
            summary[f"zone_radius_{percent}_interpolated_m"] <= summary[f"zone_radius_{percent}_m"]
        )
    elastic = analysed(tmp_path / "elastic", law="hertz")
    assert elastic["zone_depth_90_interpolated_m"] is None


# ---------------------------------------------------------------------- the impact axis


@pytest.mark.parametrize("spheres", [1, 3, 7])
def test_the_axis_goes_through_the_centroid_of_the_impacted_spheres(tmp_path, spheres):
    summary = analysed(tmp_path, size=(9, 9, 5), load={"spheres": spheres})
    with Result(tmp_path) as result:
        positions = result["spheres/position"]
        hit = [positions[sphere - 1] for sphere in impacted_of(result.assembly)]
        assert len(hit) == spheres
        middle = np.mean(hit, axis=0)[:2]
        offset = np.linalg.norm(middle - hit[0][:2])
        assert offset == pytest.approx(D / math.sqrt(3) if spheres == 3 else 0.0, abs=1e-12)
        assert result.impact_axis == pytest.approx(middle, abs=1e-12)
        distance = np.linalg.norm(positions[:, :2] - middle, axis=1)
        assert packing_zone(result)["radius"] == pytest.approx(distance, abs=1e-12)
        yielded = result["spheres/contacts_yielded"] > 0
        assert summary["plastic_zone_radius_m"] == pytest.approx(distance[yielded].max())
        assert zone_growth(result).radius[-1] == pytest.approx(distance[yielded].max())


def test_the_axis_of_spheres_across_a_periodic_side(tmp_path):
    """The centre of two impacted spheres that touch across a periodic side is at the side, not
    inside.
    """
    size = (6, 6, 4)
    summary = analysed(
        tmp_path,
        size=size,
        load={"index": [1, 6]},
        boundary={"sides": "periodic"},
    )
    with Result(tmp_path) as result:
        first = result["spheres/position"][0]
        assert result.impact_axis == pytest.approx([first[0] - D / 2, first[1]], abs=1e-12)
    half = math.hypot(3 * D, 3 * D * math.sqrt(3) / 2)
    assert summary["plastic_zone_radius_m"] <= half + 1e-12


def test_strikers_in_a_hollow_hit_the_spheres_that_they_touch(tmp_path):
    touched = [1, 2, 7]
    analysed(
        tmp_path,
        size=(6, 6, 4),
        striker=[{"touches": touched, "velocity": [0.0, 0.0, 5.0]}],
    )
    with Result(tmp_path) as result:
        assert sorted(impacted_of(result.assembly)) == touched
        middle = result["spheres/position"][[sphere - 1 for sphere in touched], :2].mean(axis=0)
        assert result.impact_axis == pytest.approx(middle, abs=1e-12)


# ---------------------------------------------------------------------- what yields and loses nothing


def test_the_default_law_dissipates_nothing_just_beyond_first_yield():
    """Up to the overlap given on the pages a contact has an indentation, but unloading returns all
    energy.
    """
    law = sphere_contact(synthetic.make_case())
    scaled = np.linspace(1.0, 1.2, 2001)
    lost = np.array([law.dissipated_energy(peak * law.yield_overlap) for peak in scaled])
    first = scaled[np.flatnonzero(lost > 0)[0]]
    assert first == pytest.approx(FIRST_LOSS, abs=1e-3)
    assert np.all(lost[scaled > first] > 0)


def test_yielded_contacts_and_those_that_dissipate_are_counted_apart(tmp_path):
    """Contacts at 1.05 alpha_y have yielded and dissipated nothing; figures count the others."""
    synthetic.write_run(tmp_path, synthetic.make_case())
    write_result(tmp_path)
    summary = summarise(tmp_path)
    with Result(tmp_path) as result:
        yielded = result["contacts/yielded"] > 0
        dissipated = result["contacts/dissipated_energy"] > 0
        assert summary["n_plastic_contacts"] == np.count_nonzero(yielded)
        assert summary["n_dissipating_contacts"] == np.count_nonzero(yielded & dissipated)
        n_spheres = np.count_nonzero(result["spheres/dissipated_energy"] > 0)
        assert summary["n_dissipating_spheres"] == n_spheres
    assert json.loads((tmp_path / "summary.json").read_text())["n_dissipating_spheres"] == n_spheres


@pytest.mark.parametrize(("spheres", "zero"), [(1, "impact axis"), (3, "impacted sphere")])
def test_sections_say_from_where_distances_count(tmp_path, spheres, zero):
    analysed(tmp_path, size=(9, 9, 5), load={"spheres": spheres})
    with Result(tmp_path) as result:
        cut = cut_of(result, "principal")
        assert cut is not None
        assert cut.plane.across_label == f"Distance from the {zero}"
        row = np.flatnonzero(cut.index == result.rows(result.struck[0]))
        assert cut.across[row] == pytest.approx([0.0], abs=1e-12)
