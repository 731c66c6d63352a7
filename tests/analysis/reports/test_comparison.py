"""Comparison of runs: small runs, synthetic curves with known results, measured curves."""

from __future__ import annotations

import dataclasses
import json
import shutil

import numpy as np
import pytest

import granwave as gw
from granwave.analysis.figures.style import Drawing, style
from granwave.analysis.measures.force_decay import (
    ForceDecay,
    PowerDecay,
    exponential_of_depth,
    power_decay,
)
from granwave.analysis.reports.answer import in_words
from granwave.analysis.reports.comparison.blocks import misfit_cells, value_table
from granwave.analysis.reports.comparison.cases import ids_in_words
from granwave.analysis.reports.comparison.comparison import Comparison, compare_runs
from granwave.analysis.reports.comparison.curves import (
    PeaksByDepth,
    SampledCurve,
    energy_shares,
    force_at_bottom,
    front,
)
from granwave.analysis.reports.comparison.energy_inputs import have_same_input
from granwave.analysis.reports.comparison.figures import common_fits, decay_notes, draw_peaks
from granwave.analysis.reports.comparison.measured import (
    closest_sentence,
    coverage_notes,
    deviation,
    range_notes,
    read_measured,
    relative_text,
    unit_notes,
    unranked_reasons,
)
from granwave.analysis.reports.comparison.page import figure_folder, write_comparison
from granwave.analysis.reports.comparison.protection import protection_sentences
from granwave.analysis.reports.comparison.subjects import compared_runs, value_text
from granwave.analysis.reports.comparison.values import compared_values, sentence
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.kinds import ReportKind
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.run_directory import MARKER
from granwave.workflows import load_case, run_case
from granwave.workflows.cli.compare import text_of
from granwave.workflows.cli.main import main
from tests.helpers.made_up.synthetic_report import write_run

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixtures are made once

SMALL = {"packing.size": [6, 6, 4], "run.end_time": 1e-4}
CHAIN = {"packing.size": 8, "run.end_time": 1e-4}
STEEL_BEAD = {"index": [3, 4], "material": "aluminium"}
CASES = {
    "fcc": ("fcc-small", SMALL),
    "hcp": ("hcp-small", SMALL),
    "fast": ("fcc-small", SMALL | {"load.velocity": 10}),
    "chain": ("elastic-impact", CHAIN),
    "mixed": ("elastic-impact", CHAIN | {"replace": [STEEL_BEAD], "run.end_time": 2e-4}),
}


class BlockKind(ReportKind):
    """Runs of a block, as provided by an extension."""

    result_kind = "block"
    noun = "continuum run"


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """Small runs of packings and chains, without figures."""
    folder = tmp_path_factory.mktemp("compared")
    for name, (case, changes) in CASES.items():
        run_case(load_case(case, changes), folder / name, figures=False)
    return folder


def compared(place, *names: str, **options) -> Comparison:
    inputs = read_inputs([place / name for name in names], place, repeated=True)
    return compare_runs(list(inputs.results()), **options)


def drawn(comparison: Comparison) -> dict[str, Drawing]:
    with style():
        names = comparison.figures
        return {name: comparison.drawing(name) for name in names}


def test_lattices(place):
    comparison = compared(place, "fcc", "hcp")
    assert comparison.sentence.startswith("The main results differ most in ")
    assert comparison.differences.to_dict("index") == {"packing.kind": {"fcc": "fcc", "hcp": "hcp"}}
    names = [
        "bottom_force",
        "peak_force_depth",
        "energies",
        "dissipation_depth",
        "zone_growth",
        "fronts",
        "peak_force_field",
    ]
    assert list(drawn(comparison)) == names  # without runs whose grains correspond no difference
    legend = comparison.drawing("energies").figure.legends[0]
    assert [text.get_text() for text in legend.get_texts()] == ["fcc", "hcp"]


def test_values_are_those_of_the_summaries(place):
    """The table includes ratios, and begins with the largest difference."""
    comparison = compared(place, "fcc", "fast")
    table = comparison.table
    summaries = [
        json.loads((place / name / "summary.json").read_text()) for name in ("fcc", "fast")
    ]
    for name in table.index:
        first, second = (summary[name] for summary in summaries)
        assert table.loc[name, "fcc"] == pytest.approx(first, rel=1e-12, abs=1e-300)
        if name in comparison.without_ratio:
            assert np.isnan(table.loc[name, "ratio"])
        elif first and second:
            assert table.loc[name, "ratio"] == pytest.approx(second / first)
    spread = np.abs(np.log(np.abs(table["ratio"].dropna())))
    assert (np.diff(spread) <= 1e-12).all()
    assert table.attrs["units"]["peak_force_N"] == "N"


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


def test_velocities(place):
    """Grains correspond, so that their forces are subtracted; labels state the differences."""
    comparison = compared(place, "fcc", "fast")
    columns = drawn(comparison)["peak_force_difference"].columns
    runs = [gw.load(place / name) for name in ("fcc", "fast")]
    force = [run.spheres["peak_force"] for run in runs]
    ids = columns["fast_10_m_s_id"]
    expected = (force[1] - force[0]).loc[ids]
    assert columns["fast_10_m_s_peak_force_difference_N"] == pytest.approx(expected.to_numpy())
    assert [run.label for run in comparison.runs] == ["fcc: 5 m/s", "fast: 10 m/s"]


def test_a_run_and_itself(place):
    comparison = compared(place, "fcc", "fcc")
    assert comparison.sentence == (
        "Nothing differs: cases and results of fcc and fcc (2) are equal."
    )
    assert not len(comparison.differences)
    assert (comparison.table["ratio"].dropna() == 1).all()
    assert "peak_force_difference" not in drawn(comparison)


def test_a_run_given_three_times_has_three_names(place):
    comparison = compared(place, "fcc", "fcc", "fcc")
    assert [run.name for run in comparison.runs] == ["fcc", "fcc (2)", "fcc (3)"]
    assert list(comparison.table.columns) == ["fcc", "fcc (2)", "fcc (3)", "ratio"]


def test_energies_of_different_inputs_are_no_main_results(place):
    """The dissipated fraction describes them; the table has both."""
    comparison = compared(place, "fcc", "fast")
    assert "dissipated energy" not in comparison.sentence
    assert comparison.table.index[0] == "energy_dissipated_J"


def test_chains_to_the_bead(place):
    comparison = compared(place, "chain", "mixed")
    differences = comparison.differences
    assert "material of grains 3 to 4" in differences.index and "replace" not in differences.index
    assert differences.loc["material of grains 3 to 4", "mixed"] == "aluminium"
    assert any("end at different times" in note for note in comparison.notes)
    figures = drawn(comparison)
    axes = figures["energies"].figure.axes
    assert [panel.get_ylabel() for panel in axes] == ["Kinetic", "Elastic"]  # nothing dissipates
    assert len(figures["peak_force_depth"].figure.axes) == 1  # a layer is a bead
    assert "fronts" in figures and "bottom_force" not in figures


def test_nothing_is_left_out_without_a_name(place):
    """Packing and chain: each figure names the run that is missing, with the reason."""
    comparison = compared(place, "fcc", "chain")
    caption = comparison.caption("bottom_force")
    assert "Not drawn: chain (the force on its bottom is not recorded)." in caption
    assert "Not drawn: chain (" in comparison.caption("peak_force_field")
    for name in comparison.wanted_figures:
        data = comparison.data(name)
        assert {*data.present, *data.lacking} == set(comparison.runs)


def test_energies_close(place):
    """The three forms add up to the input."""
    (run, *_) = compared(place, "fcc", "hcp").runs
    shares = energy_shares(run)
    total = sum(curve.y for curve in shares.values())
    time = shares["kinetic"].x
    assert total[time > time[-1] / 2] == pytest.approx(1, abs=1e-4)


def test_decay_of_a_power():
    """The fit recovers an exact power, with zero error."""
    depth = np.arange(9) * 0.008
    force = 40.0 * (np.maximum(depth, 1e-9) / 0.01) ** -1.5
    fit = power_decay(depth, force, 0.01)
    assert fit.exponent == pytest.approx(1.5) and fit.force == pytest.approx(40.0)
    assert fit.error < 1e-9 and fit.n_layers == 7
    assert power_decay(depth[:5], force[:5], 0.01) is None


def test_error_of_the_decay():
    """Its standard error is the scatter of the exponent over many noisy forces."""
    rng = np.random.default_rng(3)
    depth = np.arange(1, 14) * 0.008
    force = 40.0 * (depth / 0.01) ** -2.0
    noise = np.exp(0.1 * rng.standard_normal((300, len(depth))))
    fits = [power_decay(depth, force * factors, 0.01) for factors in noise]
    exponents = np.array([fit.exponent for fit in fits])
    errors = np.array([fit.error for fit in fits])
    assert exponents.mean() == pytest.approx(2.0, abs=4 * exponents.std() / np.sqrt(300))
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(exponents.std(), rel=0.15)


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
    assert "which limits its size: bottom in a, c; bottom and sides in b. Limited" in notes


def test_a_killed_run_without_summary_is_left_out_by_name(place, tmp_path, capsys):
    killed = tmp_path / "killed"
    killed.mkdir()
    (killed / "case.toml").write_bytes((place / "fcc" / "case.toml").read_bytes())
    (killed / "run.json").write_text('{"state": "running", "end_time_s": 0.0015}')
    output = tmp_path / "page.html"
    words = [str(place / "fcc"), str(killed), str(place / "hcp"), "-o", str(output)]
    assert main(["compare", *words]) == 0
    shown = capsys.readouterr().out
    assert (
        "Left out: " in shown and "reached 1.5 ms; the run is not finished (state running)" in shown
    )
    assert "Left out: " in output.read_text()
    assert len(gw.compare([place / "fcc", killed, place / "hcp"]).runs) == 2
    assert main(["compare", str(place / "fcc"), str(killed), "-o", str(output)]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert "is not finished" in first and "resume with  granwave run" in first
    assert "found 1 run with results (fcc), expected two or more to compare" in second


def test_a_run_killed_before_its_first_output_is_resumed(place, tmp_path, capsys):
    """It has no record yet; report, compare and analyse advise the same."""
    killed = tmp_path / "killed"
    killed.mkdir()
    for name in ("case.toml", MARKER):
        (killed / name).write_bytes((place / "fcc" / name).read_bytes())
    for words in (["compare", str(place / "fcc"), str(killed)], ["analyse", str(killed)]):
        assert main(words) == 2
        assert f"granwave run {killed}/case.toml -o {killed} --resume" in capsys.readouterr().err


def test_a_killed_run_with_part_of_its_output_is_resumed(place, tmp_path, capsys):
    """The first output is written later than the record; report and analyse advise the same."""
    killed = tmp_path / "killed"
    shutil.copytree(place / "fcc", killed)
    (killed / "run.json").write_text('{"state": "running", "end_time_s": 1e-05}')
    for name in ("summary.json", "result.h5", "dumps/wall_bottom.dump"):
        (killed / name).unlink()
    advice = f"resume with  granwave run {killed}/case.toml -o {killed} --resume"
    for words in (["report", str(killed)], ["analyse", str(killed)], ["figures", str(killed)]):
        assert main(words) == 2
        (line,) = capsys.readouterr().err.splitlines()
        assert line.endswith(advice) and "--force" not in line
    assert run_case(load_case(killed / "case.toml"), killed, resume=True, figures=False).summary


def test_labels_show_the_diameter(tmp_path):
    """Lattice, size and diameter differ; a fourth difference is an ellipsis."""
    changes = {
        "a": {"packing__kind": "fcc", "packing__size": "[8, 8, 5]"},
        "b": {"packing__kind": "hcp", "packing__size": "[9, 9, 6]", "packing__diameter": 0.006},
    }
    runs = [write_run(tmp_path / name, figures=False, **own) for name, own in changes.items()]
    assert compared_runs(read_inputs(runs, tmp_path).runs)[1].label == "b: hcp, 9 × 9 × 6, 6 mm"
    fast = changes["b"] | {"load__velocity": 9}
    runs[1] = write_run(tmp_path / "c", figures=False, **fast)
    assert compared_runs(read_inputs(runs, tmp_path).runs)[1].label == "c: hcp, 9 × 9 × 6, 6 mm, …"


def test_runs_without_a_fitted_decay_are_named(place):
    runs = compared(place, "fcc", "chain").runs
    depth = np.arange(1.0, 6.0)
    fits = exponential_of_depth(depth, depth**-1.5), power_decay(depth, depth**-1.5, 1.0)
    peaks = {
        run: PeaksByDepth(depth, depth, depth, decays, no_decay=reason)
        for run, decays, reason in zip(runs, (None, fits), ("only 2 layers", ""), strict=True)
    }
    assert decay_notes(peaks).endswith("Without a fit: fcc (only 2 layers).")
    assert decay_notes({runs[0]: peaks[runs[0]]}) == "Without a fit: fcc (only 2 layers)."


def test_laws_that_do_not_describe_the_forces_are_refused(place):
    """A step is no decay, nor is a constant force; the run that a law describes has its fit."""
    runs = compared(place, "fcc", "hcp", "chain").runs
    depth = np.arange(1.0, 21.0)
    step = np.where(depth < 10, 1.0, 0.05)
    constant = np.full(20, 3.0) + 0.5 * np.exp(-depth)
    peaks = {}
    for run, force in zip(runs, (step, depth**-1.5, constant), strict=True):
        fits = (
            exponential_of_depth(depth, force),
            power_decay(np.append(depth, 21), np.append(force, 1), 1.0),
        )
        peaks[run] = PeaksByDepth(depth, force, force, fits)
    assert list(common_fits(peaks)) == [runs[1]]
    text = decay_notes(peaks)
    assert "1.5" in text and "hcp, 20 layers" in text
    misfit = min(fit.misfit for fit in peaks[runs[0]].decays)
    assert misfit > 0.3 and f"fcc (no decay fits: rms {100 * misfit:.2g} %)" in text
    assert "chain (the peak force is constant within 0.1 % in the deeper half)" in text


def test_one_scale_for_all_panels(place):
    """The median of a layer spans less than a decade, the largest force more."""
    figure = drawn(compared(place, "fcc", "hcp"))["peak_force_depth"].figure
    assert len({axes.get_yscale() for axes in figure.axes}) == 1
    depth = np.arange(1.0, 9.0)
    runs = compared(place, "fcc", "hcp").runs
    peaks = {run: PeaksByDepth(depth, depth**-3.0, depth**-0.1, None) for run in runs}
    with style():
        axes = draw_peaks(peaks, []).figure.axes
    assert [panel.get_yscale() for panel in axes] == ["log", "log"]
    assert axes[0].get_ylim() == axes[1].get_ylim()


def test_fronts_begin_below_the_impacted_sphere(place):
    """Its first contact is the first one of the next bead: two equal times are no speed."""
    run, other = compared(place, "chain", "fcc").runs
    curve = front(run)
    assert curve.x[0] == pytest.approx(9.52e-3)
    assert (np.diff(curve.y) > 0).all()
    assert front(other).x[0] > 0


def test_two_spheres_have_no_course_of_forces(place, tmp_path):
    two = tmp_path / "two"
    run_case(load_case("elastic-impact", {"packing.size": 2, "run.end_time": 1e-4}), two)
    caption = compared(place, "chain", str(two)).caption("peak_force_depth")
    assert "Not drawn: two (a single contact carries a force" in caption
    assert not (two / "figures" / "along_chain.png").exists()
    assert not (two / "figures" / "peak_force_depth.png").exists()


def test_all_runs_have_the_law_that_fits_them_better():
    depth = np.arange(1.0, 9.0)
    laws = {"exponential": np.exp(-0.7 * depth), "power": depth**-1.5}
    for law, force in laws.items():
        fits = exponential_of_depth(depth, force), power_decay(depth, force, 1.0)
        other = exponential_of_depth(depth, depth**-1.2), power_decay(depth, depth**-1.2, 1.0)
        peaks = {
            "a": PeaksByDepth(depth, force, force, fits),
            "b": PeaksByDepth(depth, force, force, fits if law == "exponential" else other),
        }
        chosen = common_fits(peaks)
        kind = ForceDecay if law == "exponential" else PowerDecay
        assert all(isinstance(fit, kind) for fit in chosen.values())
    assert chosen["a"].exponent == pytest.approx(1.5)


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


def test_a_value_that_several_runs_have_names_them(tmp_path):
    shares = (0.0, 0.0, 0.0, 0.273)
    runs = [
        write_run(tmp_path / name, figures=False, dissipated_fraction=share)
        for name, share in zip("abcd", shares, strict=True)
    ]
    subjects = compared_runs(read_inputs(runs, tmp_path).runs)
    text = sentence(compared_values(subjects, ["dissipated_fraction"]), subjects)
    assert "dissipated fraction, 0 % (a, b, c) to 27.3 % (d)" in text


def test_keys_that_a_law_does_not_use_are_no_difference(tmp_path):
    """Elastic contacts have neither a yield strength nor a yield factor."""
    laws = {"soft": "hertz", "strong": "hertz", "yielding": "elastoplastic"}
    strengths = {"soft": 1e8, "strong": 5e8, "yielding": 5e8}
    runs = {
        name: write_run(
            tmp_path / name,
            figures=False,
            contact__law=law,
            contact__yield_factor=1.6 if name == "soft" else 1.7,
            material__yield_strength=strengths[name],
        )
        for name, law in laws.items()
    }
    inputs = read_inputs([runs["soft"], runs["strong"]], tmp_path)
    assert compare_runs(inputs.runs).case_rows == []
    inputs = read_inputs([runs["soft"], runs["yielding"]], tmp_path)
    rows = {row.what: row.values for row in compare_runs(inputs.runs).case_rows}
    assert rows["contact.law"] == ("hertz", "elastoplastic")
    assert rows["material.yield_strength"] == ("none", "500 MPa")
    assert rows["contact.yield_factor"] == ("none", "1.7")


def test_no_initial_indentation_is_none():
    assert value_text("contact.initial_overlap", {"contact.initial_overlap": 0.0}) == "none"
    assert value_text("contact.initial_overlap", {"contact.initial_overlap": 2e-6}) == "2 µm"
    assert value_text("load.velocity", {"load.velocity": 0.0}) == "0 m/s"


def test_an_unfinished_run_is_named(tmp_path):
    runs = [write_run(tmp_path / name, figures=False) for name in ("whole", "part")]
    (runs[1] / "run.json").write_text(json.dumps({"state": "interrupted", "attempts": []}))
    comparison = compare_runs(read_inputs(runs, tmp_path).runs)
    assert any(note.startswith("Unfinished") and "part (" in note for note in comparison.notes)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "cp1252"])
def test_encodings_of_measured_curves(tmp_path, encoding):
    file = tmp_path / "measured.csv"
    file.write_bytes("t (µs);F (N)\n0;0\n1;5\n2;0\n".encode(encoding))
    assert read_measured(file, ("s", "N")).x == pytest.approx([0.0, 1e-6, 2e-6])


@pytest.mark.parametrize("head", ["time_us,force_kN", "t (µs); F (kN)", "t [us]\tF [kN]"])
def test_a_measured_curve(place, tmp_path, head):
    """The curve of the run itself, in other units and multiplied by 1.1: rms and peak differ by a
    tenth.
    """
    run = compared(place, "fcc", "hcp").runs[0]
    curve = force_at_bottom(run)
    sign = next(letter for letter in (";", "\t", ",") if letter in head)
    rows = [f"{1e6 * x:.17g}{sign}{1.1e-3 * y:.17g}" for x, y in zip(curve.x, curve.y, strict=True)]
    file = tmp_path / "measured.csv"
    file.write_text("\n".join([head, *rows]), encoding="utf-8")
    measured = read_measured(file, ("s", "N"))
    difference = deviation(measured, curve)
    assert difference.peak_difference == pytest.approx(1 / 1.1 - 1, rel=1e-6)
    assert difference.rms == pytest.approx(0.1 * np.sqrt(np.mean(curve.y**2)), rel=1e-6)


def test_shift_and_scale(tmp_path):
    """Shift and scale have the requested values, and are stated in the caption."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,0\n1,5\n2,0\n")
    measured = read_measured(file, ("s", "N"), shift=1e-3, scale=2.0)
    assert measured.x == pytest.approx([1e-3, 2e-3, 3e-3]) and measured.peak == 10
    line = SampledCurve(np.array([0.0, 1.5e-3]), np.array([0.0, 15.0]))
    assert deviation(measured, line).n_points == 1
    far = SampledCurve(np.array([5.0, 6.0]), np.zeros(2))
    assert deviation(measured, far) is None


def test_units_below_the_names(tmp_path):
    """The tables have the format of an oscilloscope."""
    file = tmp_path / "scope.csv"
    file.write_text('# scope\n"Time","Ch1"\n"ms","kN"\n0,0\n1,5\n2,0\n')
    measured = read_measured(file, ("s", "N"))
    assert measured.x == pytest.approx([0, 1e-3, 2e-3])
    assert (measured.peak, measured.peak_at) == (5e3, 1e-3)
    assert measured.columns == ("Time (ms)", "Ch1 (kN)")


def test_a_measured_curve_in_words(tmp_path):
    """The misfit, both peaks with their times, and a peak outside the measured range."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,0\n1,10\n2,0\n")
    measured = read_measured(file, ("s", "N"))
    late = SampledCurve(np.array([0.0, 1e-3, 2e-3, 4e-3]), np.array([0.0, 9.0, 0.0, 80.0]))
    difference = deviation(measured, late)
    assert (difference.peak, difference.peak_at, difference.outside_at) == (9.0, 1e-3, 4e-3)
    text = closest_sentence(measured, {"a": difference}, ("s", "N"), alone=True)
    assert "577.4 mN rms, 5.77 % of the measured peak" in text
    assert text.endswith("is 9 N at 1 ms, the measured peak 10 N at 1 ms.")
    (note,) = range_notes(measured, {"a": difference}, ("s", "N"))
    assert "0 s to 2 ms: a at 4 ms." in note
    assert relative_text(27.2) == "27.2 times"


def test_the_run_that_stops_before_the_peak_is_not_closest(tmp_path):
    """The short run agrees exactly as far as it goes; the long run differs by a tenth."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,0\n0.5,2\n1,4\n2,10\n3,2\n")
    measured = read_measured(file, ("s", "N"))
    time = np.array([0.0, 0.5, 1.0, 2.0, 3.0]) * 1e-3
    force = np.array([0.0, 2.0, 4.0, 10.0, 2.0])
    differences = {
        "short": deviation(measured, SampledCurve(time[:3], force[:3])),
        "long": deviation(measured, SampledCurve(time, 1.1 * force)),
    }
    assert differences["short"].rms == 0 and np.isnan(differences["short"].peak_difference)
    assert differences["long"].peak_difference == pytest.approx(0.1)
    text = closest_sentence(measured, differences, ("s", "N"), alone=False)
    assert text.startswith("Only long is compared with") and "the measured peak 10 N" in text
    (note,) = coverage_notes(measured, differences)
    assert note.endswith("of which they cover only a part: short (3 of 5 points).")
    only = closest_sentence(measured, {"short": differences["short"]}, ("s", "N"), alone=True)
    assert "at 3 of 5 measured points; the run does not cover the measured peak, 10 N at" in only
    cells = misfit_cells(differences["short"], ("s", "N"), measured.peak)
    assert cells[4] == ""
    (reason,) = unranked_reasons(differences).values()
    cells = misfit_cells(differences["short"], ("s", "N"), measured.peak, reason)
    assert cells[1] == "not ranked: fewer points than other runs"
    assert not any("%" in cell for cell in cells)


def test_a_run_that_still_rises_at_its_end_has_no_percentage(tmp_path):
    """It covers the measured peak and as many points as the other run."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n" + "\n".join(f"{n},{10 - n / 200}" for n in range(200)))
    measured = read_measured(file, ("s", "N"))
    time = np.arange(199) * 1e-3
    rising = deviation(measured, SampledCurve(time, time * 40.0))
    falling = deviation(measured, SampledCurve(time, 9.0 - time))
    assert rising.rises_at_end and np.isnan(rising.peak_difference)
    assert falling.peak_difference == pytest.approx(-0.1)
    differences = {"rising": rising, "falling": falling}
    assert unranked_reasons(differences) == {"rising": "still rises at its end"}
    text = closest_sentence(measured, differences, ("s", "N"), alone=False)
    assert text.startswith("Only falling is compared")
    assert "at their end: rising." in coverage_notes(measured, differences)[0]
    alone = closest_sentence(measured, {"rising": rising}, ("s", "N"), alone=True)
    assert "the curve of the run still rises at its end, 7.92 N at 198 ms" in alone


def test_a_sensor_of_the_opposite_sign(tmp_path):
    """Peaks of opposite signs have no ratio; a note names the factor, which agrees."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,1e-9\n1,-4\n2,-10\n3,-2\n")
    curve = SampledCurve(np.arange(4) * 1e-3, np.array([0.0, 4.0, 10.0, 2.0]))
    measured = read_measured(file, ("s", "N"))
    assert measured.peak == -10 and np.isnan(deviation(measured, curve).peak_difference)
    (note,) = coverage_notes(measured, {"a": deviation(measured, curve)})
    assert "--scale -1, or scale=-1 in Python" in note
    turned = read_measured(file, ("s", "N"), scale=-1.0)
    assert deviation(turned, curve).peak_difference == pytest.approx(0)
    assert coverage_notes(turned, {"a": deviation(turned, curve)}) == []
    for runs in (("a",), ("a", "b")):
        differences = dict.fromkeys(runs, deviation(measured, curve))
        text = closest_sentence(measured, differences, ("s", "N"), alone=len(runs) == 1)
        assert text.startswith("No run is ranked" if len(runs) > 1 else "a is not compared")
        assert ": opposite sign" in text and "rms" not in text
    reversed_twice = dataclasses.replace(measured, scale=-1.0)
    (note,) = coverage_notes(reversed_twice, {"a": deviation(reversed_twice, curve)})
    assert "The scale -1 reverses them" in note


def test_a_wrong_unit_of_time_gives_no_agreement(tmp_path):
    """Only the first of 5 points, which is zero in all curves, is within the runs."""
    file = tmp_path / "measured.csv"
    file.write_text("time_s,force_N\n0,0\n50,10\n60,900\n70,1500\n80,1200\n")
    measured = read_measured(file, ("s", "N"))
    time = np.linspace(0.0, 2e-4, 50)
    curves = {"a": SampledCurve(time, 1500.0 * np.sin(np.pi * time / 2e-4))}
    curves["b"] = SampledCurve(time, 0.5 * curves["a"].y)
    differences = {name: deviation(measured, curve) for name, curve in curves.items()}
    assert differences["a"].rms == 0 and differences["a"].n_points == 1
    assert set(unranked_reasons(differences).values()) == {"fewer than 3 common points"}
    text = closest_sentence(measured, differences, ("s", "N"), alone=False)
    assert text.endswith("measured.csv: fewer than 3 common points (a, b).")
    assert text.startswith("No run is ranked") and "Closest" not in text
    assert coverage_notes(measured, differences) == []
    (note,) = unit_notes(measured, curves, ("s", "N"))
    assert note.endswith("lasts 80 s, the runs 200 µs; check the unit.")
    small = read_measured(file, ("s", "N"), scale=1e-3)
    assert len(unit_notes(small, curves, ("s", "N"))) == 2
    fits = {"a": SampledCurve(time * 4e5, curves["a"].y)}
    assert unit_notes(measured, fits, ("s", "N")) == []


@pytest.mark.parametrize(("unit", "time"), [("kN", 1.0), ("N", 1e-3)])
def test_a_curve_of_another_size_is_not_compared(place, tmp_path, unit, time):
    """Newtons in a column of kN, or seconds in a column of ms: the note on the unit comes first,
    and no run is ranked.
    """
    fcc = force_at_bottom(compared(place, "fcc", "hcp").runs[0])
    rows = zip(time * 1e3 * fcc.x, fcc.y, strict=True)
    file = tmp_path / "measured.csv"
    lines = [f"{x},{y}" for x, y in rows]
    file.write_text("\n".join([f"time_ms,force_{unit}", *lines]))
    comparison = compared(place, "fcc", "hcp", measured=file)
    first, second, *_ = comparison.paragraphs
    assert first.endswith("check the unit.")
    assert second.startswith("No run is ranked by its difference from ")
    assert second.endswith(": the unit of the curve is doubtful (fcc, hcp).")
    assert "Closest" not in comparison.sentence
    assert set(comparison.misfits["not_ranked"]) == {"the unit of the curve is doubtful"}
    assert not any("check the unit" in note for note in comparison.notes)
    (alone,) = compared(place, "fcc", measured=file).measured_sentences[1:]
    assert alone.startswith("fcc is not compared with ")


def test_a_record_that_is_much_longer_than_the_runs_is_compared(place, tmp_path):
    """An oscilloscope records for seconds; the note on its unit comes before the result."""
    fcc = force_at_bottom(compared(place, "fcc", "hcp").runs[0])
    file = tmp_path / "measured.csv"
    lines = [f"{x},{y}" for x, y in zip(fcc.x, fcc.y, strict=True)]
    file.write_text("\n".join(["time_s,force_N", *lines, "1,0"]))
    first, second, *_ = compared(place, "fcc", "hcp", measured=file).paragraphs
    assert "lasts 1 s, the runs 100 µs; check the unit." in first
    assert second.startswith(f"Closest to {file} is fcc")


def test_runs_that_end_before_the_peak_or_tie_are_not_ranked(tmp_path):
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,0\n1,4\n2,6\n3,10\n4,2\n")
    measured = read_measured(file, ("s", "N"))
    time = np.arange(5) * 1e-3
    force = np.array([0.0, 4.0, 6.0, 10.0, 2.0])
    early = deviation(measured, SampledCurve(time[:3], force[:3]))
    text = closest_sentence(measured, {"a": early, "b": early}, ("s", "N"), alone=False)
    assert text.endswith("ends before the measured peak (a, b).")
    high = deviation(measured, SampledCurve(time, 1.1 * force))
    low = deviation(measured, SampledCurve(time, 0.9 * force))
    text = closest_sentence(measured, {"a": high, "b": low}, ("s", "N"), alone=False)
    assert text.startswith("Equally close to") and ": a, b, with" in text


def test_a_rounded_depth_beyond_the_last_layer_is_compared(tmp_path):
    """32.70 mm with the last layer at 32.66 mm; 33 mm is beyond 1 % of the spacing."""
    depth = 8.165e-3 * np.arange(1, 5)
    curve = SampledCurve(depth, np.array([400.0, 190.0, 90.0, 60.0]))
    counts = {}
    for last in (32.70, 33.0):
        file = tmp_path / "measured.csv"
        file.write_text(f"depth_mm,force_N\n8.17,400\n16.33,190\n24.5,90\n{last},60\n")
        measured = read_measured(file, ("m", "N"))
        difference = deviation(measured, curve)
        counts[last] = (difference.n_points, difference.n_near_end)
        # the first layer is at 8.165 mm, measured 8.17 mm
        assert (difference.peak, difference.outside_at) == (400.0, None)
        assert difference.peak_difference == 0.0
        notes = range_notes(measured, {"a": difference}, ("m", "N"))
        assert len(notes) == difference.n_near_end
    assert counts == {32.70: (4, 1), 33.0: (3, 0)}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n2,3\n", "found the columns a, b, expected one in s, ms, us, ns"),
        ("time_s,mass_kg\n1,2\n2,3\n", "expected one in N, mN, kN, MN"),
        ("1,2\n2,3\n", "found no names of columns, expected time_us, force_N"),
        ("time_s,force_N\n1,x\n2,3\n", 'line 2: found "x" for force_N'),
        ("time_s,force_N\n1,2\n", "found 1 row, expected at least 2"),
        ("time_s,force_N\n1,2\n2,inf\n3,4\n", 'line 3: found "inf" for force_N'),
        ("time_s;force_N\n1,5;2\n-INF;5\n3;4\n", 'line 3: found "-INF" for time_s'),
        ("time_s,force_N\n1,2\n2,1e999\n3,4\n", 'line 3: found "1e999" for force_N'),
    ],
)
def test_wrong_measured_curves(tmp_path, text, message):
    file = tmp_path / "measured.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=message):
        read_measured(file, ("s", "N"))


def test_page_and_figures(place, tmp_path, monkeypatch, capsys):
    """Sentence and table at the terminal, the page, and each figure as PNG, PDF and CSV."""
    monkeypatch.chdir(tmp_path)
    names = ["--quantity", "wall_peak_force_N", "bottom_force"]
    assert main(["compare", str(place / "fcc"), str(place / "hcp"), *names]) == 0
    printed = capsys.readouterr().out
    assert "peak force on the bottom" in printed and "wall_peak_force_N" in printed
    assert printed.splitlines()[-1] == "compare.html"
    figures = sorted(path.name for path in (tmp_path / "compare_figures").iterdir())
    assert figures == ["bottom_force.csv", "bottom_force.pdf", "bottom_force.png"]
    page = (tmp_path / "compare.html").read_text()
    assert "<title>Comparison: fcc, hcp" in page and "data:image/png" in page


def test_files_of_others_stay(place, tmp_path):
    output = tmp_path / "compare.html"
    folder = figure_folder(output)
    folder.mkdir()
    (folder / "energies.png").write_text("mine")
    (folder / "fronts.csv").write_text("mine")
    with pytest.raises(InputError) as error:
        write_comparison([place / "fcc", place / "hcp"], output)
    assert len(error.value.items) == 2
    assert not output.exists() and (folder / "energies.png").read_text() == "mine"


def test_wrong_words_are_listed_together(place, capsys):
    words = ["--quantity", "peak_forc_N", "nothing", "--as", "zone_growth", "--measured", "x.csv"]
    assert main(["compare", str(place / "fcc"), str(place / "hcp"), *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert "did you mean peak_force_N?" in lines[0]
    assert "expected a name of summary.json, or of bottom_force" in lines[1]
    assert "--as: found zone_growth" in lines[2]
    assert main(["compare", str(place / "fcc")]) == 2
    assert "found 1 run (fcc), expected two or more" in capsys.readouterr().err


def test_in_python(place):
    runs = [gw.load(place / "fcc"), str(place / "hcp")]
    comparison = gw.compare(runs, quantities="peak_force_N")
    assert isinstance(comparison, gw.Comparison)
    assert list(comparison.table.index) == ["peak_force_N"]
    whole = gw.compare(runs)
    axes = whole.figure("bottom_force")
    assert axes.get_ylabel().startswith("Force on the bottom")
    with pytest.raises(KeyError, match="did you mean fronts"):
        whole.figure("front")
    with pytest.raises(InputError, match="quantities: found nothing"):
        gw.compare(runs, quantities=["nothing"])
    assert "packing.kind" in repr(whole) and "<table" in whole._repr_html_()


@pytest.mark.parametrize(
    ("ids", "words"),
    [
        ([4], "grain 4"),
        ([3, 4, 5], "grains 3 to 5"),
        ([1, 2, 7], "grains 1 to 2, 7"),
        ([2, 4, 6, 8, 10], "grains 2, 4, … 10 (every 2nd)"),
        ([1, 4, 7, 10, 13], "grains 1, 4, … 13 (every 3rd)"),
        ([1, 3, 7, 12, 20], "5 grains (1, 3, 7, 12, …)"),
    ],
)
def test_ids_in_words(ids, words):
    assert ids_in_words(ids) == words


def test_unlike_kinds_say_what_they_are(place):
    """Keys that only one of packing and block has are not compared."""
    runs = list(read_inputs([place / "fcc", place / "hcp"], place).results())
    case = {"punch.mass": 1.0}
    other = dataclasses.replace(runs[1], label="block", kind=BlockKind(), case=case)
    comparison = compare_runs([runs[0], other])
    assert list(comparison.differences.index) == ["kind of run", "setting"]
    assert "Not drawn: block (it is a continuum run, without grains)." in comparison.caption(
        "bottom_force"
    )
