"""Trends of a scan in words: stated where a change exceeds the confidence intervals."""

from __future__ import annotations

import json
import math

import pytest

from granwave.analysis.scans.figures import drawings
from granwave.analysis.scans.headline import headline
from granwave.analysis.scans.means import means_of
from granwave.analysis.scans.result import ScanResult
from granwave.analysis.scans.trends import Trend, course_of
from tests.helpers.made_up.synthetic_scan import grid, write_json, write_scan

SCATTERS = [2e-6, 5e-6, 10e-6]
FORCE = "wall_peak_force_N"
PEAK = "peak_force_N"


@pytest.mark.parametrize(
    ("means", "half_widths", "course"),
    [
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0], Trend.RISES),
        ([3.0, 2.0, 1.0], [0.0, 0.0, 0.0], Trend.FALLS),
        ([1.0, 3.0, 2.0], [0.0, 0.0, 0.0], Trend.MIXED),
        ([1.0, 1.0 + 1e-9, 1.0], [0.0, 0.0, 0.0], Trend.CONSTANT),
        # forces of a packing with growing scatter, N: the first step is within its interval
        ([1427.1, 1428.0, 1050.0, 880.0], [0.0, 30.0, 90.0, 120.0], Trend.FALLS),
        ([696.8, 697.1, 698.7, 703.0], [0.0, 3.6, 9.3, 18.0], Trend.UNCLEAR),
        ([990.0, 880.0], [500.0, 120.0], Trend.UNCLEAR),
        ([10.0, 14.0], [3.0, 3.0], Trend.UNCLEAR),  # combined half-width 4.2
        ([10.0, 14.5], [3.0, 3.0], Trend.RISES),
        ([1.0, 2.0, 3.0], [math.nan, math.nan, math.nan], Trend.UNCLEAR),
    ],
)
def test_course(means, half_widths, course):
    assert course_of(means, half_widths) is course


def scan_of_forces(directory, points, force_of):
    """Write a scan whose forces on the bottom follow from the labels."""
    scan = write_scan(directory, points)
    for point in ScanResult(scan).points:
        path = point.directory / "summary.json"
        force = force_of(point.labels)
        write_json(path, json.loads(path.read_text()) | {FORCE: force})
    return means_of(ScanResult(scan)).sentence(FORCE)


def noisy(mean, labels, spread):
    """Return a mean with a deviation by seed: -spread, 0 and spread."""
    return mean + spread * (labels["packing.seed"] - 2)


def test_a_change_within_the_intervals_is_no_trend(tmp_path):
    sentence = scan_of_forces(
        tmp_path,
        grid(packing__diameter_scatter=SCATTERS, packing__seed=[1, 2, 3]),
        lambda labels: noisy(700 + 1e5 * labels["packing.diameter_scatter"], labels, 2.0),
    )
    assert "rises" not in sentence
    assert sentence.endswith("This difference is within the 95 % confidence intervals.")


def test_a_trend_names_the_settings_without_it(tmp_path):
    """Friction lowers the force; at the largest scatter the intervals are wider than the change."""

    def force_of(labels):
        mean = 2000 - 1e8 * labels["packing.diameter_scatter"] - 300 * labels["contact.friction"]
        return noisy(mean, labels, 200 if labels["packing.diameter_scatter"] == 10e-6 else 1)

    points = grid(
        packing__diameter_scatter=SCATTERS, contact__friction=[0.0, 0.3], packing__seed=[1, 2, 3]
    )
    sentence = scan_of_forces(tmp_path, points, force_of)
    assert (
        "It falls with diameter scatter and friction coefficient (within the 95 % confidence "
        "intervals at 1 of 3 settings of the other keys)." in sentence
    )


def test_a_step_within_the_intervals_does_not_hide_a_trend(tmp_path):
    means = {0.0: 1427.1, 2e-6: 1428.0, 5e-6: 1100.0, 10e-6: 880.0}
    regular = [{"packing.diameter_scatter": 0.0, "packing.seed": 1}]
    sentence = scan_of_forces(
        tmp_path,
        regular + grid(packing__diameter_scatter=SCATTERS, packing__seed=[1, 2, 3]),
        lambda labels: noisy(
            means[labels["packing.diameter_scatter"]],
            labels,
            20 if labels["packing.diameter_scatter"] else 0,
        ),
    )
    assert "It falls with diameter scatter." in sentence


def test_single_random_packings_have_no_trend_with_their_scatter(tmp_path):
    """Each packing is another one; at different velocities the packing is the same."""
    points = grid(packing__diameter_scatter=SCATTERS, load__velocity=[1.0, 5.0])
    sentence = scan_of_forces(
        tmp_path,
        points,
        lambda labels: 100 * labels["load.velocity"] + 1e6 * labels["packing.diameter_scatter"],
    )
    assert "It rises with impact velocity. Each random packing was run once" in sentence
    assert "replicates" in sentence


def test_exact_points_have_strict_trends(tmp_path):
    sentence = scan_of_forces(
        tmp_path,
        grid(load__velocity=[1.0, 2.0, 4.0]),
        lambda labels: 100 + 0.001 * labels["load.velocity"],
    )
    assert sentence.endswith("It rises with impact velocity.")


def test_an_unfinished_collision_does_not_hide_the_restitution(tmp_path):
    """The figure shows the known values; the sentence names the missing one and the reason."""
    scan = write_scan(tmp_path, grid(load__velocity=[0.05, 1.0, 5.0, 20.0]))
    for point in ScanResult(scan).points:
        path = point.directory / "summary.json"
        velocity = point.labels["load.velocity"]
        touches = velocity == 0.05
        write_json(
            path,
            json.loads(path.read_text())
            | {
                "n_spheres": 2,
                "end_time_s": 5e-5,
                "energy_elastic_J": 1e-6 if touches else 0.0,
                "restitution": None if touches else 0.8 - 0.02 * velocity,
            },
        )
    means = means_of(ScanResult(scan))
    assert means.quantities()[0] == ("restitution", "restitution")
    sentence = means.sentence("restitution")
    assert sentence.startswith("Restitution: from 0.4 (impact velocity 20 m/s) to 0.78 ")
    assert (
        "It is unknown at 1 of 4 points (impact velocity 0.05 m/s), because the bodies still "
        "touch at the end of the run (50 µs)" in sentence
    )
    columns = drawings(ScanResult(scan))["restitution_vs_load_velocity"].columns
    assert list(columns["load.velocity_m_s"]) == [1.0, 5.0, 20.0]


def means_with(directory, points, values_of):
    """Return the means of a scan with values of the summaries that follow from the labels."""
    scan = write_scan(directory, points)
    for point in ScanResult(scan).points:
        path = point.directory / "summary.json"
        write_json(path, json.loads(path.read_text()) | values_of(point.labels))
    return means_of(ScanResult(scan))


def test_values_that_the_end_limits_have_no_trend(tmp_path):
    """At the largest scatter the force is lower since the run ends before the larger pulse."""

    def values_of(labels):
        scatter = labels["packing.diameter_scatter"]
        incomplete = [FORCE] if scatter == 10e-6 else []
        return {FORCE: 100 - 5e6 * scatter, "incomplete_values": incomplete}

    points = grid(packing__diameter_scatter=SCATTERS, packing__seed=[1, 2])
    means = means_with(tmp_path / "scan", points, values_of)
    sentence = means.sentence(FORCE)
    assert "falls" not in sentence
    assert "It is not final at 1 of 3 points" in sentence
    assert sentence.endswith("(diameter scatter 10 µm): increase run.end_time.")
    assert means.range_in_words(FORCE).endswith("; not final at the end of the run at 1 of 3")
    assert means.text(FORCE, 2).endswith(" †") and "†" not in means.text(FORCE, 0)
    assert means.remark([FORCE]) == "† still changes at the end of the run"
    assert not means.remark(["dissipated_fraction"])
    marks = drawings(ScanResult(tmp_path / "scan"))
    data = marks["bottom_peak_force_vs_packing_diameter_scatter"].columns
    assert list(data["not_final_at_the_end_of_the_run"]) == [0, 0, 1]


def test_points_beyond_the_law_are_marked(tmp_path):
    """The largest force is at contacts beyond the law; the force on the bottom is not of them."""

    def values_of(labels):
        velocity = labels["load.velocity"]
        beyond = 5 if velocity == 150 else 0
        return {PEAK: velocity, FORCE: velocity, "contacts_beyond_law": beyond}

    means = means_with(tmp_path / "scan", grid(load__velocity=[20, 60, 150]), values_of)
    assert means.sentence(PEAK).endswith(
        "At 1 of 3 points (impact velocity 150 m/s) it is extrapolated: overlaps of contacts "
        "exceed 0.2 R*, the limit of the law."
    )
    assert means.range_in_words(PEAK).endswith("; extrapolated beyond the law at 1 of 3")
    assert [means.marks(PEAK, row) for row in range(3)] == ["", "", "‡"]
    assert means.text(PEAK, 2) == "150 ‡"
    assert means.remark([PEAK]) == "‡ with contacts beyond the range of the law (0.2 R*)"
    assert not means.remark([FORCE]) and "extrapolated" not in means.sentence(FORCE)
    drawn = drawings(ScanResult(tmp_path / "scan"))
    data = drawn["peak_force_vs_load_velocity"].columns
    assert list(data["contacts_beyond_the_law"]) == [0, 0, 1]
    assert "contacts_beyond_the_law" not in drawn["bottom_peak_force_vs_load_velocity"].columns


def test_the_headline_is_about_the_quantity_that_answers(tmp_path):
    """The force on the bottom of different lattices varies by a factor of 11, the dissipated
    fraction by 7 %.
    """
    forces = {"fcc": 92.5, "sc": 8.74}
    heights = {"fcc": 15e-3, "sc": 18e-3}
    fractions = {"fcc": 0.96, "sc": 0.897}

    def values_of(labels):
        kind = labels["packing.kind"]
        return {
            FORCE: forces[kind], "dissipated_fraction": fractions[kind], PEAK: 50.0,
            "packing_height_m": heights[kind],
        }  # fmt: skip

    means = means_with(tmp_path / "kinds", grid(packing__kind=["fcc", "sc"]), values_of)
    assert means.quantities()[0][1] == FORCE
    assert headline(means) == (
        "Peak force on the bottom: from 8.74 N (packing sc) to 92.5 N (packing fcc). Dissipated "
        "fraction: 0.897 to 0.96. Packings differ in height: 15 mm to 18 mm. Forces on the bottom "
        "and arrival times depend on it."
    )
    fractions["sc"] = 0.5
    means = means_with(tmp_path / "strong", grid(packing__kind=["fcc", "sc"]), values_of)
    assert headline(means).startswith("Dissipated fraction: from 0.5 (packing sc) to 0.96 ")
    assert " Peak force on the bottom: 8.74 N to 92.5 N. Packings differ" in headline(means)


def test_values_that_are_not_final_do_not_lead(tmp_path):
    def values_of(labels):
        velocity = labels["load.velocity"]
        incomplete = [FORCE] if velocity == 3 else []
        fraction = 0.5 + 0.1 * velocity
        return {FORCE: 10 * velocity, PEAK: 9 + velocity, "dissipated_fraction": fraction,
                "incomplete_values": incomplete}  # fmt: skip

    means = means_with(tmp_path, grid(load__velocity=[1, 2, 3]), values_of)
    assert [key for _, key in means.quantities()][:3] == ["dissipated_fraction", PEAK, FORCE]


def test_a_change_beyond_the_intervals_comes_first(tmp_path):
    """The dissipated fraction scatters; the force on the bottom falls by more than its scatter."""

    def values_of(labels):
        force = noisy(100 - 5e6 * labels["packing.diameter_scatter"], labels, 1.0)
        lost = noisy(0.5 + 1e3 * labels["packing.diameter_scatter"], labels, 0.2)
        return {FORCE: force, "dissipated_fraction": lost}

    points = grid(packing__diameter_scatter=SCATTERS, packing__seed=[1, 2, 3])
    names = [key for _, key in means_with(tmp_path, points, values_of).quantities()]
    assert names.index(FORCE) < names.index("dissipated_fraction")


def test_nothing_yields_with_hertzian_contacts(tmp_path):
    def values_of(labels):
        if labels["contact.law"] == "hertz":
            return {"zone_volume_90_m3": None, "n_plastic_spheres": 0}
        return {"zone_volume_90_m3": 1e-9 * labels["load.velocity"], "n_plastic_spheres": 3}

    points = grid(contact__law=["hertz", "elastoplastic"], load__velocity=[1.0, 2.0])
    means = means_with(tmp_path, points, values_of)
    assert means.range_in_words("zone_volume_90_m3").endswith("no plastic zone at 2 of 4 points")
    assert "There is no plastic zone at 2 of 4 points" in means.sentence("zone_volume_90_m3")


def sentence_of(directory, points, force_of):
    """Return the sentence on a force that follows from the labels."""
    return means_with(directory, points, lambda labels: {FORCE: force_of(labels)}).sentence(FORCE)


def test_a_key_without_numbers_has_its_order(tmp_path):
    """The force of steel is larger by a factor that falls with the velocity; with a third material
    the order is named.
    """
    factors = {"brass": 1.0, "steel": 1.25, "aluminium": 0.5}

    def force_of(labels):
        velocity = labels["load.velocity"]
        return 10 * velocity * (1 + (factors[labels["material"]] - 1) / velocity)

    points = grid(load__velocity=[1, 2.5], material=["steel", "brass"])
    assert sentence_of(tmp_path / "pair", points, force_of).endswith(
        " It rises with impact velocity, and is 1.1 to 1.25 times as large for steel as for brass "
        "at both values of impact velocity."
    )
    points = grid(load__velocity=[1, 2.5], material=["steel", "brass", "aluminium"])
    assert sentence_of(tmp_path / "three", points, force_of).endswith(
        ", and rises in the order aluminium, brass, steel at both values of impact velocity."
    )


def test_an_order_that_changes_states_where_it_holds(tmp_path):
    def force_of(labels):
        sign = 1 if labels["load.velocity"] < 4 else -1
        larger = 0.1 * sign if labels["material"] == "steel" else 0.0
        return labels["load.velocity"] + larger

    points = grid(load__velocity=[1, 2, 4], material=["brass", "steel"])
    sentence = sentence_of(tmp_path, points, force_of)
    assert "is 1.05 to 1.1 times as large for steel as for brass at 2 of 3 values" in sentence
    points = grid(load__velocity=[2, 4], material=["brass", "steel"])
    sentence = sentence_of(tmp_path / "half", points, force_of)
    assert "varies with material in an order that depends on impact velocity." in sentence


def test_a_key_without_effect_is_named(tmp_path):
    """It is not in the settings of the ends either; the lattices differ as their range shows."""
    forces = {"fcc": 90.0, "hcp": 80.0}
    points = grid(packing__kind=["fcc", "hcp"], boundary__forget_gap=[0.1, 0.3, 1.0])
    assert sentence_of(tmp_path, points, lambda labels: forces[labels["packing.kind"]]) == (
        "Peak force on the bottom: from 80 N (packing hcp) to 90 N (packing fcc). It does not "
        "depend on forgetting gap."
    )


def test_a_course_that_turns_is_no_trend(tmp_path):
    def force_of(labels):
        return 10 - (labels["load.velocity"] - 2) ** 2 * labels["contact.friction"]

    points = grid(load__velocity=[1, 2, 4], contact__friction=[0.1, 0.2])
    sentence = sentence_of(tmp_path, points, force_of)
    assert "rises and falls with impact velocity" in sentence
