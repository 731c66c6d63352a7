"""Measured curves: reading, differences from runs, runs that are not ranked."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from granwave.analysis.reports.comparison.blocks import misfit_cells, misfit_tables
from granwave.analysis.reports.comparison.curves import SampledCurve, force_at_bottom, front
from granwave.analysis.reports.comparison.deviations import deviation, unranked_reasons
from granwave.analysis.reports.comparison.measured_curve import MeasuredCurve, read_measured
from granwave.analysis.reports.comparison.measured_words import (
    closest_sentence,
    coverage_notes,
    range_notes,
    relative_text,
    unit_notes,
)
from granwave.lammps_inputs.errors import InputError
from tests.analysis.reports.comparison.runs import compared

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


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


def test_falling_times_are_named(tmp_path):
    """Equal times, which rounded time stamps have, and depths in any order are accepted."""
    file = tmp_path / "measured.csv"
    file.write_text("time_us,force_N\n0,0\n1,5\n1,6\n3,2\n2,1\n")
    with pytest.raises(InputError) as caught:
        read_measured(file, ("s", "N"))
    assert "column time_us: found 2 µs after 3 µs (values 4 and 5)" in str(caught.value)
    assert "sort the rows by time" in str(caught.value)
    file.write_text("time_us,force_N\n0,0\n1,5\n1,6\n2,1\n")
    assert len(read_measured(file, ("s", "N")).x) == 4
    file.write_text("depth_mm,force_N\n10,5\n30,2\n20,3\n")
    assert read_measured(file, ("m", "N")).y == pytest.approx([5, 3, 2])


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


def test_runs_that_do_not_resemble_the_curve_are_not_ranked(tmp_path):
    """Their rms difference exceeds the measured peak."""
    file = tmp_path / "measured.csv"
    file.write_text("time_ms,force_N\n0,0\n1,4\n2,10\n3,2\n")
    measured = read_measured(file, ("s", "N"))
    time = np.arange(4) * 1e-3
    pulse = np.array([0.0, 4.0, 10.0, 2.0])
    differences = {
        "four times": deviation(measured, SampledCurve(time, 4.0 * pulse)),
        "five times": deviation(measured, SampledCurve(time, 5.0 * pulse)),
    }
    text = closest_sentence(measured, differences, ("s", "N"), alone=False)
    size = 3.0 * np.sqrt(np.mean(pulse**2))
    assert text.startswith("No run resembles ")
    assert f"the smallest difference, of four times, is {size:.4g} N rms, 164 % of" in text
    assert coverage_notes(measured, differences) == []
    one = closest_sentence(measured, {"a": differences["four times"]}, ("s", "N"), alone=True)
    assert one.startswith("a does not resemble ")
    differences["near"] = deviation(measured, SampledCurve(time, 1.1 * pulse))
    assert closest_sentence(measured, differences, ("s", "N"), alone=False).startswith("Only near")
    (note,) = coverage_notes(measured, differences)
    assert "exceeds the measured peak: four times, five times." in note


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


def test_a_measured_front_has_no_peak(place, tmp_path):
    """The last arrival is the largest value of every front; it is no peak, and a curve that ends
    1 % before a layer needs no shift.
    """
    run = compared(place, "chain", "mixed").runs[0]
    curve = front(run)
    file = tmp_path / "front.csv"
    rows = [f"{1e3 * x},{1.02e6 * t}" for x, t in zip(curve.x, curve.y, strict=True)]
    last = f"{0.999e3 * curve.x[-1]},{1.02e6 * curve.y[-1]}"
    file.write_text("\n".join(["depth_mm,t_us", *rows[:-1], last]))
    comparison = compared(place, "chain", "mixed", measured=file, measured_as="fronts")
    (table,) = misfit_tables(comparison)
    heads = [column.heading for column in table.columns]
    assert heads == ["Run", "rms", "rms / largest measured value", "Points"]
    assert comparison.misfits["peak_difference"].isna().all()
    words = " ".join([*comparison.paragraphs, *comparison.notes])
    assert "Closest to" in words and "peak in the measured range" not in words
    assert "Shift the measured curve" not in words


def test_the_largest_value_in_a_range_is_interpolated_at_its_ends():
    """A decaying curve from 0 to 30 mm, measured from 10 mm on: not the next layer, but the value
    at 10 mm is its largest value there, as in the rms difference.
    """
    depth = np.array([0.0, 8e-3, 16e-3, 24e-3, 32e-3])
    force = np.array([1000.0, 800.0, 400.0, 200.0, 100.0])
    places = np.array([10e-3, 20e-3, 30e-3])
    values = np.array([700.0, 300.0, 125.0])
    measured = MeasuredCurve("depths.csv", ("z_mm", "F_N"), places, values)
    difference = deviation(measured, SampledCurve(depth, force))
    assert difference.peak == pytest.approx(700.0)
    assert difference.peak_at == 10e-3
    assert difference.peak_difference == pytest.approx(0.0, abs=1e-12)
    assert difference.relative_rms == pytest.approx(0.0, abs=1e-12)
