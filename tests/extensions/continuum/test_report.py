"""Reports of runs of finite elements."""

from __future__ import annotations

import re

import h5py
import pytest

from granwave.analysis.figures.style import style
from granwave.analysis.quantities import readable
from granwave.analysis.reports.comparison.compare import compare_runs
from granwave.analysis.reports.comparison.figures.registry import FIGURES
from granwave.analysis.reports.inputs import read_inputs
from granwave.analysis.reports.report import write_report
from granwave.extensions.continuum.punch.case import ContinuumCase
from granwave.extensions.continuum.punch.run import run_continuum
from granwave.workflows import load_case, run_case
from tests.helpers.made_up.synthetic_report import build, notes, table, write_run
from tests.helpers.made_up.synthetic_scan import write_json


def test_continuum_run_with_other_keys_and_nulls(tmp_path):
    run = tmp_path / "block"
    run.mkdir()
    (run / "case.toml").write_text(
        "[punch]\ndiameter = 0.010\nvelocity = 10.0\n"
        "[material]\nyoungs_modulus = 115e9\nyield_strength = 550e6\n"
    )
    summary = {
        "name": "half-space",
        "n_elements": 62500,
        "energy_input_J": 5.0,
        "energy_input_normalised": 1.9012,
        "peak_force_N": None,
        "energy_balance_error": 4e-3,
        "plastic_zone_volume_ever_m3": 2e-6,
        "energy_hourglass_J": 1e-3,
        "versions": None,
    }
    write_json(run / "summary.json", summary)
    report = build([run, write_run(tmp_path / "grains", figures=False)], tmp_path, "sphere-contact")
    first = table(report, "inputs", "Contents of this report")[0]
    assert first["What"].text == "continuum run"
    row = table(report, "balance", "Energies at the end, and the error of the balance")[0]
    assert (row["Balance"].text, row["Hourglass energy"].value) == ("good", 1e-3)
    assert table(report, "results", "Runs")[0]["Peak contact force, excluding walls"].value is None
    for suffix in ("html", "pdf", "md"):
        write_report([run], tmp_path / f"r.{suffix}")


def test_a_continuum_balance_has_its_own_limits(tmp_path):
    run = write_run(tmp_path / "run", figures=False, n_elements=100, energy_balance_error=0.019)
    assert [note.tone for note in notes(build([run], tmp_path), "short")] == ["good"]
    worse = write_run(tmp_path / "worse", figures=False, n_elements=100, energy_balance_error=0.03)
    (note,) = [n for n in notes(build([run, worse], tmp_path), "short") if n.tone == "bad"]
    assert "(up to 0.03 of the input, more than 0.02): worse" in note.text


def test_a_block_and_a_packing_are_compared_by_fractions_of_the_input(tmp_path):
    """An input 100 times as large has a larger zone, which is no result; the inputs have masses and
    velocities, and the notes are one paragraph on definitions and one on limits.
    """
    run = tmp_path / "block"
    run.mkdir()
    (run / "case.toml").write_text("[punch]\ndiameter = 0.010\nmass = 0.1\nvelocity = 10.0\n")
    zone = {"zone_volume_90_m3": 2e-6, "zone_depth_90_m": 5e-3, "n_elements": 62500}
    summary = {"energy_input_J": 5.0, "dissipated_fraction": 0.1, "end_time_s": 1e-3}
    write_json(run / "summary.json", {"name": "block", "kind": "continuum"} | zone | summary)
    grains = write_run(
        tmp_path / "grains",
        figures=False,
        load__velocity=10.0,
        energy_input_J=0.05,
        dissipated_fraction=0.8,
        zone_volume_90_m3=2e-8,
        zone_depth_90_m=1e-3,
        zone_growing=["depth"],
        zone_cut=["bottom"],
        end_time_s=1e-3,
    )
    comparison = compare_runs(read_inputs([run, grains], tmp_path).runs)
    (lead,) = comparison.paragraphs
    assert lead.startswith("The main results differ most in dissipated fraction, 10 % (block)")
    assert ", a ratio of 8, with dissimilar inputs." in lead
    assert "zone" not in lead
    definitions, limits, *_ = comparison.grouped_notes
    assert "Inputs differ: 5 J (100 g at 10 m/s) in block, 50 mJ (1 g at 10 m/s) in" in definitions
    assert "from the loaded face in a block" in definitions
    assert "reaches a boundary" in limits and "still grows" in limits


@pytest.fixture(scope="module")
def block_and_packing(tmp_path_factory):
    """Comparison of a short run of a packing with a block, which is much shorter."""
    place = tmp_path_factory.mktemp("kinds")
    block = {"name": "block", "material": "brass", "run": {"elements": 500, "end_time": 1e-5}}
    block |= {"block": {"diameter": 0.1, "height": 0.1}, "punch": {"velocity": 10.0}}
    run_continuum(ContinuumCase.from_dict(block), place / "block", figures=False)
    packing = load_case("fcc-small", {"packing.size": [6, 6, 4], "run.end_time": 1e-4})
    run_case(packing, place / "packing", figures=False)
    return compare_runs(read_inputs([place / "packing", place / "block"], place).runs)


def test_dissipated_energy_of_a_block_is_that_of_the_table(block_and_packing):
    """Numerical energies are in no panel, and the caption gives them: all add up to the input."""
    block = block_and_packing.runs[1]
    curves = block_and_packing.data("energies").present[block]
    fraction = block.run.summary["dissipated_fraction"]
    assert curves["dissipated"].y[-1] == pytest.approx(fraction, rel=1e-9)
    names = {"viscous": "artificial viscosity", "contact": "contact", "hourglass": "hourglass"}
    caption = block_and_packing.caption("energies")
    with h5py.File(block.run.directory / "result.h5") as file:
        shares = {name: file[f"energy/{name}"][-1] / file["energy/input"][-1] for name in names}
    total = sum(curve.y[-1] for curve in curves.values()) + sum(shares.values())
    assert total == pytest.approx(1, abs=1e-2)
    assert f"artificial viscosity {100 * shares['viscous']:.3g} %" in caption
    assert "no contact and no element dissipates any more" in caption
    assert "no panel" not in _caption_of(block_and_packing.runs[0], "energies")


def _caption_of(run, name):
    """Return the caption of a figure of a comparison of a run with itself."""
    return compare_runs([run.run, run.run]).caption(name)


def test_inputs_of_a_block_and_a_packing_come_before_their_ratios(block_and_packing):
    """They are relative to the unit that both kinds have, and the ratio has a word on them."""
    packing, block = block_and_packing.runs
    first, *_ = block_and_packing.paragraphs
    unit = packing.run.case["material.yield_strength"] ** 2 / 115e9
    unit *= packing.run.case["packing.diameter"] ** 3
    relative = packing.run.summary["energy_input_J"] / unit
    normalised = block.run.summary["energy_input_normalised"]
    assert f"{relative:.3g} in packing, {normalised:.3g} in block" in first
    larger = max(relative / normalised, normalised / relative)
    assert f"a ratio of {larger:.3g} between" in first
    (alone,) = compare_runs([packing.run, packing.run]).paragraphs
    assert alone.startswith("Nothing differs: ")


def test_values_of_a_block_and_a_packing_side_by_side(block_and_packing, tmp_path):
    """No ratio of values in different units or with different contents, no verdict on a single
    value, no difference of settings, and one reason for all sizes of the zone.
    """
    places = [run.run.directory for run in block_and_packing.runs]
    report = build(places, tmp_path)
    rows = {
        row["Quantity"].text: row["Difference"].text
        for row in table(report, "results", "Values side by side")
    }
    assert rows["Energy input, normalised"] == "defined differently"
    assert rows["Kinetic energy"] == "defined differently"
    assert rows["Accepted balance error"] == ""
    assert rows["Volume that ever yielded"] == ""
    assert rows["Balance error"] != "-100 %"
    sizes = {text for label, text in rows.items() if re.search(r" \d\d % (depth|volume)", label)}
    assert len(sizes) == 1


def test_the_kinetic_energy_of_a_block_includes_the_punch_in_the_figure(block_and_packing):
    """The panel says so, and its caption gives the parts, which add up to the end of the curve."""
    block = block_and_packing.runs[1]
    curve = block_and_packing.data("energies").present[block]["kinetic"]
    summary = block.run.summary
    parts = summary["energy_kinetic_J"] + summary["energy_punch_J"]
    assert curve.y[-1] * summary["energy_input_J"] == pytest.approx(parts, rel=1e-9)
    with style():
        first = block_and_packing.drawing("energies").figure.axes[0]
    assert first.get_ylabel() == "Kinetic,\nwith punch"
    caption = block_and_packing.caption("energies")
    assert "in the block and" in caption and "in the punch at the end (block)" in caption


def test_curves_on_a_logarithmic_axis_start_at_their_first_record(block_and_packing):
    """A point at time zero would be drawn as a flat line from the edge of the panel; a mark at the
    edge has its value.
    """
    with style():
        panels = block_and_packing.drawing("energies").figure.axes
    for axes in panels:
        assert axes.get_xscale() == "log"
        curves = [line for line in axes.lines if len(line.get_xdata()) > 1]
        marks = [line for line in axes.lines if len(line.get_xdata()) == 1]
        for line in curves:
            time = line.get_xdata()
            assert time[0] == 0 and time[1] > 0
            shown = axes.transData.transform(line.get_xydata())
            assert not (abs(shown[0]) < float("inf")).all()
            assert (abs(shown[1:]) < float("inf")).all()
        left = axes.get_xlim()[0]
        assert {mark.get_xdata()[0] for mark in marks} == {left}
        values = [curve.get_ydata()[0] for curve in curves]
        assert sorted(mark.get_ydata()[0] for mark in marks) == pytest.approx(sorted(values))


def test_force_on_the_bottom_of_a_block_is_not_recorded(block_and_packing):
    """A block has a bottom: that it has no grains is a reason for other figures only."""
    assert "block (the force on its bottom is not recorded)" in block_and_packing.caption(
        "bottom_force"
    )
    assert "block (it is a continuum run, without grains)" in block_and_packing.caption("fronts")


def test_forces_of_a_punch_and_of_a_contact_have_no_ratio(block_and_packing):
    """A rigid punch carries far more than a contact of two spheres, which is no result."""
    words = "defined differently"
    assert block_and_packing.without_ratio["peak_force_N"] == words
    note = "in a packing, and the force on the punch of a block, so that it has no ratio"
    assert any(note in text for text in block_and_packing.notes)
    asked = compare_runs([run.run for run in block_and_packing.runs], ["peak_force_N"])
    (value,) = asked.values
    assert value.ratio is None and value.without_ratio == words
    assert "packings and blocks define it differently" in asked.sentence
    packing = block_and_packing.runs[0].run
    assert "peak_force_N" not in compare_runs([packing, packing]).without_ratio
    page = build([run.run.directory for run in block_and_packing.runs], packing.directory)
    row = {row["Quantity"].text: row for row in table(page, "results", "Values side by side")}
    assert row["Peak contact force, excluding walls"]["Difference"].text == words


def test_figures_that_only_the_packing_has_are_drawn_on_request(block_and_packing):
    """They compare nothing; the note names each of them."""
    assert block_and_packing.figures == ("energies",)
    (note,) = [text for text in block_and_packing.notes if "only on request" in text]
    packing, block = (run.run for run in block_and_packing.runs)
    left_out = [name for name in FIGURES if f" {name}" in note]
    assert "bottom_force" in left_out and "peak_force_difference" not in left_out
    assert "(packing)" in note and "(block)" not in note
    for name in left_out:
        assert compare_runs([packing, block], [name]).figures == (name,)
    assert "bottom_force" in compare_runs([packing, packing, block]).figures


def test_names_of_persons_keep_their_capitals():
    assert readable("von_mises") == "von Mises"
    assert readable("plastic_zone") == "Plastic zone"
    assert readable("largest_von_mises") == "Largest von Mises"
