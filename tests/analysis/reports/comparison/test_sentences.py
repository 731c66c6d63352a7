"""Sentences on the values that differ most."""

from __future__ import annotations

import pytest

from granwave.analysis.reports.comparison.blocks import value_table
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.subjects import compared_runs
from granwave.analysis.reports.comparison.value_words import sentence
from granwave.analysis.reports.comparison.values import compared_values
from granwave.analysis.reports.inputs import read_inputs
from granwave.workflows.cli.compare import text_of
from tests.analysis.reports.comparison.runs import compared
from tests.helpers.made_up.synthetic_report import write_run

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


def test_zones_at_a_boundary_have_no_ratio(place):
    """Their sizes and counts are limited by the packing; forces and energies are compared."""
    comparison = compared(place, "fcc", "fast")
    limited = {name for name, word in comparison.without_ratio.items() if word == "limited"}
    assert {"plastic_zone_depth_m", "plastic_zone_radius_m", "n_plastic_spheres"} <= limited
    assert not {"peak_force_N", "wall_peak_force_N", "dissipated_fraction"} & limited
    assert "zone" not in comparison.sentence and "yielded" not in comparison.sentence
    assert any("their sizes and counts have no ratio" in note for note in comparison.notes)
    asked = compared(place, "fcc", "fast", quantities=["plastic_zone_depth_m"])
    ((*_, cell),) = value_table(asked).rows
    assert cell.text == "limited" and "limited" in text_of(asked)
    assert asked.paragraphs == [
        "No requested value is complete in fcc and fast: a boundary limits the plastic zone."
    ]


def test_energies_of_different_inputs_are_no_main_results(place):
    """The dissipated fraction describes them; the table has both, which still grow at 100 µs."""
    comparison = compared(place, "fcc", "fast")
    assert "dissipated energy" not in comparison.sentence
    assert "dissipated fraction" not in comparison.sentence
    for name in ("energy_dissipated_J", "dissipated_fraction"):
        assert comparison.without_ratio[name] == "still growing"
        assert name in comparison.table.index
    assert any("Still growing at the end of the run: diss" in note for note in comparison.notes)


def test_a_value_that_is_zero_everywhere_is_no_answer(tmp_path):
    runs = [
        write_run(tmp_path / name, figures=False, dissipated_fraction=0.0, peak_force_N=force)
        for name, force in (("soft", 10.0), ("hard", 25.0))
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    values = compared_values(subjects)
    assert "dissipated_fraction" not in [value.name for value in values]
    assert "10 N (soft) and 25 N (hard), a ratio of 2.5" in sentence(values, subjects)


def test_results_that_hardly_differ_have_no_ratio_of_one(tmp_path):
    runs = [
        write_run(tmp_path / name, figures=False, dissipated_fraction=0.5, peak_force_N=force)
        for name, force in (("one", 10.0), ("other", 10.0001))
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    text = sentence(compared_values(subjects), subjects)
    assert text == "Results differ by at most 0.001 % (peak contact force, excluding walls)."


def test_results_that_differ_by_less_than_a_millionth_agree_to_digits(tmp_path):
    forces = (10.0, 10.0 * (1 + 2.7e-7))
    runs = [
        write_run(tmp_path / f"run-{n}", figures=False, dissipated_fraction=0.5, peak_force_N=force)
        for n, force in enumerate(forces)
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    text = sentence(compared_values(subjects), subjects)
    assert text == (
        "Results agree to 6 digits or more (largest difference: peak contact force, excluding "
        "walls)."
    )


def test_a_requested_figure_limits_the_sentences(tmp_path):
    """A figure of the force on the bottom is described by values of this force."""
    runs = [
        write_run(
            tmp_path / f"run-{n}",
            figures=False,
            wall_peak_force_N=10.0 * n,
            zone_cut=["bottom"],
        )
        for n in (1, 2)
    ]
    compared = compare_runs(read_inputs(runs, tmp_path).runs, ["bottom_force"])
    assert compared.paragraphs == [
        "The requested values differ most in peak force on the bottom, 10 N (run-1) and 20 N "
        "(run-2), a ratio of 2."
    ]
    assert not any("zone" in note for note in compared.notes)


def test_boundaries_that_zones_reach_are_grouped(tmp_path):
    """Boundaries are listed once each, with the runs whose zones reach them."""
    reached = {"a": ["bottom"], "b": ["bottom", "sides"], "c": ["bottom"]}
    runs = [write_run(tmp_path / n, figures=False, zone_cut=cut) for n, cut in reached.items()]
    notes = " ".join(compare_runs(read_inputs(runs, tmp_path).runs).notes)
    assert "which limits its size: bottom in a, c; bottom and sides in b. The depths" in notes


def test_zeros_and_signs_come_first(tmp_path):
    """A value that is zero in one run, or has another sign, has no finite ratio; a fraction of a
    rounding error does not count.
    """
    values = {
        "first": {"dissipated_fraction": 0.0, "friction_fraction": 0.0, "wave_speed_m_s": -5.0},
        "second": {"dissipated_fraction": 0.6, "friction_fraction": 1e-5, "wave_speed_m_s": 1.0},
    }
    runs = [
        write_run(tmp_path / name, figures=False, peak_force_N=10.0 + n, **own)
        for n, (name, own) in enumerate(values.items())
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    compared_by_rank = compared_values(subjects)
    names = [value.name for value in compared_by_rank]
    assert {*names[:2]} == {"dissipated_fraction", "wave_speed_m_s"}
    assert names[-1] == "friction_fraction"
    assert "dissipated fraction, 0 % (first) and 60 % (second)" in sentence(
        compared_by_rank, subjects
    )


def test_energies_are_compared(place):
    """The fast run dissipates several times the energy, which the table lists."""
    comparison = compared(place, "fcc", "fast")
    assert {"energy_dissipated_J", "energy_kinetic_J"} <= {*comparison.table.index}


def test_a_value_that_several_runs_have_names_them(tmp_path):
    shares = (0.0, 0.0, 0.0, 0.273)
    runs = [
        write_run(tmp_path / name, figures=False, dissipated_fraction=share)
        for name, share in zip("abcd", shares, strict=True)
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    text = sentence(compared_values(subjects, ["dissipated_fraction"]), subjects)
    assert "dissipated fraction, 0 % (a, b, c) to 27.3 % (d)" in text


def test_a_number_is_stated_once(tmp_path):
    """The largest force of an elastic chain is the force on its bottom, with a table row and a
    clause of its own; the order by this force is in the first sentence.
    """
    forces = {"steel": 187.9, "brass": 11.55}
    runs = [
        write_run(
            tmp_path / name,
            figures=False,
            wall_peak_force_N=force,
            peak_force_with_walls_N=force,
            peak_force_N=force / 2,
            peak_reduction=500 / force,
            energy_input_J=1.0,
        )
        for name, force in forces.items()
    ]
    comparison = compare_runs(read_inputs(runs, tmp_path).runs)
    assert "wall_peak_force_N" in comparison.table.index
    assert "peak_force_with_walls_N" not in comparison.table.index
    first, second = comparison.paragraphs
    assert first.startswith("brass protects the bottom better: its peak force is 11.55 N")
    assert second.startswith("The other main results differ most in ")
    assert "187.9" not in second and "reduction" not in second
    assert "187.9 N (steel)" in comparison.sentence  # which stands alone
