"""Order of runs by the force on the bottom and by the depth of the plastic zone."""

from __future__ import annotations

import pytest

from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.curves import force_at_bottom
from granwave.analysis.reports.comparison.energy_inputs import have_same_input
from granwave.analysis.reports.comparison.protection import protection_sentences
from granwave.analysis.reports.comparison.subjects import compared_runs
from granwave.analysis.reports.inputs import read_inputs
from granwave.workflows import load_case, run_case
from tests.analysis.reports.comparison.runs import SMALL, compared
from tests.helpers.made_up.synthetic_report import write_run

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


def protected(tmp_path, **values) -> list[str]:
    """Sentences on protection for synthetic runs, whose values are in lists by key."""
    numbers = dict.fromkeys(
        ("peak_reduction", "energy_input_J", "wall_peak_force_N", "zone_depth_90_interpolated_m")
    )
    folder = tmp_path / str(len(list(tmp_path.iterdir())))
    runs = []
    for n in range(len(next(iter(values.values())))):
        own = numbers | {key: column[n] for key, column in values.items()}
        runs.append(write_run(folder / f"run-{n + 1}", figures=False, **own))
    subjects = compared_runs(read_inputs(runs, folder).runs)
    return protection_sentences(subjects, [run.name for run in subjects])


def test_which_of_two_runs_protects_better(tmp_path):
    sentences = protected(
        tmp_path,
        energy_input_J=[0.05, 0.05],
        wall_peak_force_N=[1500.0, 1200.0],
        zone_depth_90_interpolated_m=[0.02, 0.05],
    )
    assert sentences == [
        "run-2 protects the bottom better: its peak force is 1.2 kN, compared with 1.5 kN in "
        "run-1 (1.25 times as high).",
        "run-1 has the shallower plastic zone: its 90 % depth, interpolated between layers, is "
        "20 mm, compared with 50 mm in run-2 (2.5 times as deep).",
    ]


@pytest.mark.parametrize(
    "limits",
    [
        {"zone_cut": [["bottom", "sides"], []]},
        {"zone_growing": [["depth"], []]},
        {"n_spheres": [2, 40]},
    ],
)
def test_limited_zones_are_not_ranked(tmp_path, limits):
    """A zone that a boundary cuts, or that still grows, and the zone of two spheres."""
    depths = [0.02, 0.05]
    assert protected(tmp_path, zone_depth_90_interpolated_m=depths)
    assert not protected(tmp_path, zone_depth_90_interpolated_m=depths, **limits)


def test_a_force_that_still_rises_is_not_ranked(place, tmp_path):
    """The same packing, stopped before the peak of the force on the bottom."""
    times = {"early": 4e-5, "late": 1e-4}
    for name, end in times.items():
        case = load_case("fcc-small", SMALL | {"run.end_time": end})
        run_case(case, tmp_path / name, figures=False)
    comparison = compared(tmp_path, "early", "late")
    forces = [force_at_bottom(run).y for run in comparison.runs]
    assert [int(force.argmax()) == len(force) - 1 for force in forces] == [True, False]
    assert not any("protects" in text for text in comparison.protection)
    (note,) = [note for note in comparison.notes if "may rise further" in note]
    assert "at 40 µs in early" in note and "late" not in note
    (run, *_) = read_inputs([tmp_path / "early"], tmp_path).runs
    assert "; it is largest at the end of the run, and may rise further." in in_words(run)


def test_runs_without_a_rank_are_named(tmp_path):
    """A single sphere, and a packing whose force on the bottom is not recorded."""
    changes = {
        "one": {"n_spheres": 1, "wall_peak_force_N": 3.0},
        "many": {"n_spheres": 40, "wall_peak_force_N": 2.0},
        "free": {"n_spheres": 40, "wall_peak_force_N": None},
    }
    runs = [write_run(tmp_path / name, figures=False, **own) for name, own in changes.items()]
    notes = " ".join(compare_runs(read_inputs(runs, tmp_path).runs).notes)
    assert "a single sphere is the impact without a packing: one." in notes
    assert "the force on the bottom, which is not recorded: free." in notes


def test_runs_of_other_impacts_are_compared_with_the_impact_without_the_packing(tmp_path):
    """The harder impact has the larger force and the better protection."""
    (sentence,) = protected(
        tmp_path,
        energy_input_J=[0.05, 0.2],
        wall_peak_force_N=[1500.0, 2000.0],
        peak_reduction=[1.25, 2.5],
    )
    assert sentence == (
        "Inputs differ; the peak force on the bottom relative to the same impact without the "
        "packing is lower, 0.4, in run-2, compared with 0.8 in run-1 (2 times as high)."
    )


def test_inputs_that_differ_are_named_and_depths_are_not_ranked(tmp_path):
    """A faster impact has a deeper zone, which is not the merit of a packing."""
    depths = [0.02, 0.05]
    same = protected(tmp_path, energy_input_J=[1.0, 1.0], zone_depth_90_interpolated_m=depths)
    assert "has the shallower plastic zone" in same[0]
    assert not protected(tmp_path, energy_input_J=[1.0, 4.0], zone_depth_90_interpolated_m=depths)
    changes = {"slow": (0.01, 5.0), "fast": (0.04, 10.0), "heavy": (0.04, 5.0)}
    runs = [
        write_run(tmp_path / name, figures=False, energy_input_J=energy, load__velocity=velocity)
        for name, (energy, velocity) in changes.items()
    ]
    compared_runs_of = compare_runs(read_inputs(runs, tmp_path).runs)
    (note,) = [note for note in compared_runs_of.notes if note.startswith("Inputs differ")]
    assert "10 mJ (0.8 g at 5 m/s) in slow, 40 mJ (0.8 g at 10 m/s) in fast" in note
    assert "40 mJ (3.2 g at 5 m/s) in heavy" in note
    equal_energy = compared_runs_of.runs[1:]
    assert not have_same_input(equal_energy)  # another velocity
    assert have_same_input(equal_energy[:1])


def test_protection_of_many_runs_and_of_equal_ones(tmp_path):
    forces = [5.0, 1.0, 2.0, 4.0, 3.0]
    (sentence,) = protected(tmp_path, energy_input_J=[1.0] * 5, wall_peak_force_N=forces)
    assert sentence == (
        "run-2 protects the bottom best: its peak force is 1 N. The largest value of the 5 runs is "
        "5 N in run-1 (5 times as high)."
    )
    with_single = {"n_spheres": [9, 9, 9, 9, 9, 1], "wall_peak_force_N": [*forces, 9.0]}
    (sentence,) = protected(tmp_path, energy_input_J=[1.0] * 6, **with_single)
    assert sentence.endswith(
        "The largest value of the 5 ranked runs is 5 N in run-1 (5 times as high); not ranked: "
        "run-6."
    )
    (sentence,) = protected(tmp_path, energy_input_J=[1, 1], wall_peak_force_N=[1000.0, 1001.0])
    assert sentence == (
        "The peak force on the bottom is 1 kN in run-1 and 1.001 kN in run-2, 0.1 % apart."
    )
    (sentence,) = protected(tmp_path, energy_input_J=[1, 1], wall_peak_force_N=[1000.0, 1000.1])
    assert sentence == "The peak force on the bottom is 1 kN in both runs, within 0.01 %."
    forces = [1000.0, 1001.0, 1002.0]
    (sentence,) = protected(tmp_path, energy_input_J=[1] * 3, wall_peak_force_N=forces)
    assert sentence == (
        "The peak force on the bottom is between 1 kN (run-1) and 1.002 kN (run-3) in all 3 runs, "
        "at most 0.2 % apart."
    )
    assert protected(tmp_path, energy_input_J=[1, 1], wall_peak_force_N=[1.0, None]) == []


def test_protection_by_runs_that_hardly_differ(tmp_path):
    """Differences of rounding are no percentages; equal runs share a rank and a value."""
    forces = [1000.0, 1000.0 * (1 + 9e-8)]
    (sentence,) = protected(tmp_path, energy_input_J=[1, 1], wall_peak_force_N=forces)
    assert sentence == (
        "The peak force on the bottom is 1 kN in both runs, equal to 7 digits or more."
    )
    (sentence,) = protected(tmp_path, energy_input_J=[1, 1], wall_peak_force_N=[1000.0, 1000.0])
    assert (
        sentence == "The peak force on the bottom is 1 kN in both runs, equal to within rounding."
    )
    forces = [1000.0, 3000.0, 1000.01, 3000.01]
    (sentence,) = protected(tmp_path, energy_input_J=[1] * 4, wall_peak_force_N=forces)
    assert sentence == (
        "run-1 and run-3 protect the bottom best: their peak force is 1 kN, compared with 3 kN in "
        "run-2 and run-4 (3 times as high)."
    )
