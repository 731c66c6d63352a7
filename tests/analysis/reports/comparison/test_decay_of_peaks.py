"""Peak forces by depth and fronts in comparisons: fits of the decay, scales, missing layers."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from granwave.analysis.figures.style import style
from granwave.analysis.measures.force_decay import (
    ForceDecay,
    PowerDecay,
    _power,
    exponential_of_depth,
    power_decay,
)
from granwave.analysis.reports.comparison.curves import PeaksByDepth, _after_gap, front
from granwave.analysis.reports.comparison.fields import _tick_label, _ticks
from granwave.analysis.reports.comparison.figures.peak_force_depth import (
    PEAK_FORCE_DEPTH,
    common_fits,
    decay_notes,
    decay_table,
    draw_peaks,
    wave_notes,
)
from granwave.analysis.reports.comparison.subjects import ComparedRun
from granwave.workflows import load_case, run_case
from tests.analysis.reports.comparison.runs import compared, drawn

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


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


def test_lines_have_gaps_where_beads_are_left_out(place):
    """No line joins the beads before and behind those whose force is not known."""
    run = compared(place, "chain", "mixed").runs[0]
    depth = np.array([0.0, 1.0, 4.0, 5.0])
    is_after = _after_gap(np.array([True, True, False, False, True, True]))
    assert is_after.tolist() == [False, False, True, False]
    peaks = PeaksByDepth(depth, 9.0 - depth, 9.0 - depth, None, no_decay="none", after_gap=is_after)
    with style():
        line = draw_peaks({run: peaks}, []).figure.axes[0].lines[0]
    assert np.isnan(line.get_ydata()).tolist() == [False, False, True, False, False]
    assert line.get_ydata()[3:].tolist() == [5.0, 4.0]


def test_ends_of_the_scale_of_differences_have_labels():
    ticks = _ticks(740.0)
    assert ticks == [-740.0, -100.0, -10.0, 0.0, 10.0, 100.0, 740.0]
    minus = "\N{MINUS SIGN}"
    labels = [_tick_label(tick, 740.0) for tick in ticks]
    assert labels == [f"{minus}740", f"{minus}100", f"{minus}10", "0", "10", "100", "740"]
    assert _ticks(110.0) == [-110.0, -10.0, 0.0, 10.0, 110.0]


def test_runs_without_a_fitted_decay_are_named(place):
    runs = compared(place, "fcc", "chain").runs
    depth = np.arange(1.0, 6.0)
    fits = exponential_of_depth(depth, depth**-1.5), power_decay(depth, depth**-1.5, 1.0)
    peaks = {
        run: PeaksByDepth(depth, depth, depth, decays, no_decay=reason)
        for run, decays, reason in zip(runs, (None, fits), ("only 2 layers", ""), strict=True)
    }
    assert _rows(peaks)[0][:2] == ["fcc", "none: only 2 layers"]
    assert decay_notes(peaks) == "Dotted: power law, F ~ z^-n, see the table of the decay."
    alone = {runs[0]: peaks[runs[0]]}
    assert _rows(alone)[0][:2] == ["fcc", "none: only 2 layers"]
    assert decay_notes(alone) == "No run has a fit, see the table of the decay."


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
    without, fitted, level = _rows(peaks)
    assert fitted[0] == "hcp" and "1.5" in fitted[2] and fitted[4] == "20"
    misfit = min(fit.misfit for fit in peaks[runs[0]].decays)
    assert misfit > 0.1
    assert without[1] == f"none: neither law describes the decay, rms {100 * misfit:.2g} %"
    assert level[1] == "none: the peak force is constant within 0.1 % in the deeper half"


def test_one_kind_of_scale_for_all_panels(place):
    """The median of a layer spans less than a decade, the largest force more; each panel has limits
    of its own, so that medians are not squashed into a small part of their panel.
    """
    figure = drawn(compared(place, "fcc", "hcp"))["peak_force_depth"].figure
    assert len({axes.get_yscale() for axes in figure.axes}) == 1
    depth = np.arange(1.0, 9.0)
    runs = compared(place, "fcc", "hcp").runs
    peaks = {run: PeaksByDepth(depth, depth**-3.0, depth**-0.1, None) for run in runs}
    with style():
        axes = draw_peaks(peaks, []).figure.axes
    assert [panel.get_yscale() for panel in axes] == ["log", "log"]
    assert axes[0].get_ylim()[0] < 8**-3.0 < 0.5 < axes[1].get_ylim()[0] < 8**-0.1


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


def test_table_gives_the_law_of_a_run_that_the_common_law_describes_less_well(place):
    """Figure of the run and comparison have two laws: the table gives both."""
    runs = compared(place, "fcc", "hcp").runs
    depth = np.arange(4.0, 13.0)
    forces = (np.exp(-0.2 * depth), depth**-1.7)
    peaks = {
        run: PeaksByDepth(
            depth,
            force,
            force,
            (exponential_of_depth(depth, force), _power(depth, force, 1.0)),
        )
        for run, force in zip(runs, forces, strict=True)
    }
    exponentials = [one.decays[0] for one in peaks.values()]
    powers = [one.decays[1] for one in peaks.values()]
    assert exponentials[0].misfit < powers[0].misfit < 0.1
    assert powers[1].misfit < exponentials[1].misfit < 0.1
    common, better, other = sorted(_rows(peaks), key=lambda row: (row[0], "not drawn" in row[1]))
    assert common[1] == "power law, F ~ z^-n" and other[1] == "power law, F ~ z^-n"
    assert better[:2] == ["fcc", "exponential, F ~ exp(-bz), not drawn"]
    assert better[2].startswith("b = 0.2")
    assert decay_notes(peaks).startswith("Dotted: power law, F ~ z^-n, one law for all runs")
    alone = {runs[0]: peaks[runs[0]]}
    assert decay_notes(alone) == "Dotted: exponential, F ~ exp(-bz), see the table of the decay."
    assert len(_rows(alone)) == 1


def test_runs_are_fitted_at_the_depths_that_all_have(place):
    """Equal forces in the layers of both runs give equal constants, although the forces of the
    deeper run follow no law: an exponential is followed by a plateau.
    """
    runs = compared(place, "fcc", "hcp").runs
    peaks = {}
    for run, n_layers in zip(runs, (6, 12), strict=True):
        depth = 0.01 * np.arange(1.0, n_layers + 1)
        force = np.maximum(np.exp(-60 * depth), np.exp(-0.36 - 2 * depth) * 0.04)
        fits = exponential_of_depth(depth, force), _power(depth, force, 0.01)
        peaks[run] = PeaksByDepth(depth, force, force, fits)
    deep = peaks[runs[1]].decays
    assert min(fit.misfit for fit in deep) > 0.1
    first, second = common_fits(peaks).values()
    assert first.rate == second.rate and first.n_layers == second.n_layers == 6
    table = decay_table(peaks)
    assert table.caption == (
        "Decay of the largest peak force, fitted at the depths that all fitted runs have, "
        "1 to 6 diameters"
    )
    one, other = runs
    peaks[one] = dataclasses.replace(peaks[one], decays=_fits_of(0.01 * np.arange(5.0, 13.0)))
    peaks[other] = dataclasses.replace(peaks[other], decays=_fits_of(0.01 * np.arange(1.0, 8.0)))
    rows = _rows(peaks)
    assert rows[1][1] == "none: only 3 layers at the depths that all fitted runs have"


def _fits_of(depth):
    """Return fits to an exponential at depths."""
    force = np.exp(-60 * depth)
    return exponential_of_depth(depth, force), _power(depth, force, 0.01)


def _rows(peaks):
    """Return the texts of the rows of the table of fits."""
    rows = []
    for row in decay_table(peaks).rows:
        rows.append([cell.text for cell in row])
    return rows


def test_equal_values_do_not_hide_curves_that_differ(place, tmp_path):
    """Chains of two lengths have the same largest force, and different curves and fits."""
    for n_beads in (15, 25):
        chain = {"packing.size": n_beads, "run.end_time": 4e-4, "load.velocity": 0.8}
        case = load_case("homogeneous-chain", chain | {"material": "steel"})
        run_case(case, tmp_path / str(n_beads), figures=False)
    comparison = compared(tmp_path, "15", "25", quantities=["peak_force_depth"])
    assert comparison.difference_sentence == (
        "Equal in 15 and 25: peak contact force, excluding walls. The curves and fits of the "
        "requested figures may differ."
    )
    different = compared(place, "fcc", "fast", quantities=["peak_force_depth"])
    assert different.difference_sentence.startswith("The requested values differ most in")


def _six_runs():
    """Peaks of six runs with exponential decays of different rates, of two whose last layers the
    reflection hides.
    """
    depth = np.arange(1.0, 21.0)
    peaks = {}
    for n in range(6):
        force = np.exp(-(n + 1) * depth / 10) + 1e-3 * np.sin(depth) * np.exp(-(n + 1) * depth / 10)
        fits = exponential_of_depth(depth, force), power_decay(depth, force, 1.0)
        run = ComparedRun(SimpleNamespace(label=f"r{n}", case={}), f"r{n}", n, look=n)
        hidden = 2 if n > 3 else 0
        peaks[run] = PeaksByDepth(depth, force, force, fits, of_first_wave=True, n_hidden=hidden)
    return peaks


def test_captions_of_many_runs_name_no_run():
    """All constants are in the table, and in the data of the figure."""
    peaks = _six_runs()
    assert "(r" not in decay_notes(peaks)
    assert [row[0] for row in _rows(peaks)] == [f"r{n}" for n in range(6)]
    assert "(" not in wave_notes(peaks)
    drawing = draw_peaks(peaks, [])
    for n in range(6):
        assert drawing.columns[f"r{n}_decay_per_m"] == pytest.approx((n + 1) / 10, rel=1e-2)
    of_first = dict(list(peaks.items())[:3])
    assert wave_notes(of_first) == "Largest forces of the first wave, before the reflection."
    run = next(iter(of_first))
    whole = of_first | {run: dataclasses.replace(of_first[run], of_first_wave=False)}
    assert "(r1, r2)" in wave_notes(whole) and "(r0)" in wave_notes(whole)


def test_panels_of_many_runs_are_side_by_side():
    """Four and more runs fill a row; of fewer runs the panels are below each other."""
    peaks = _six_runs()
    run, first = next(iter(peaks.items()))
    peaks[run] = dataclasses.replace(first, median=first.largest / 2)
    upper, lower = draw_peaks(peaks, []).figure.axes
    assert upper.get_position().y0 == pytest.approx(lower.get_position().y0)
    assert upper.get_xlabel() == lower.get_xlabel() == "Depth (mm)"
    few = draw_peaks(dict(list(peaks.items())[:3]), [])
    upper, lower = few.figure.axes
    assert upper.get_position().y0 > lower.get_position().y0
    assert (upper.get_xlabel(), lower.get_xlabel()) == ("", "Depth (mm)")


def test_layers_that_the_reflection_hides_are_not_called_awaited():
    text = PEAK_FORCE_DEPTH.notes(_six_runs())
    assert "at which the reflection hides the peak of the first wave: 2 (r4), 2 (r5)." in text
    assert "larger pulse" not in text
