"""Comparison of runs: small runs, their tables and figures, the page and its files."""

from __future__ import annotations

import json

import numpy as np
import pytest
from matplotlib import pyplot

import granwave as gw
from granwave.analysis.reports.comparison.curves import energy_shares
from granwave.analysis.reports.comparison.page import figure_folder, write_comparison
from granwave.analysis.result.reader import Result
from granwave.lammps_inputs.errors import InputError
from granwave.workflows.cli.main import main
from tests.analysis.reports.comparison.runs import compared, drawn

pytestmark = pytest.mark.xdist_group("comparison of runs")  # its fixture is made once


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


def test_caption_of_dissipation_by_layer_gives_the_part_at_walls(place):
    caption = compared(place, "fcc", "hcp").caption("dissipation_depth")
    with Result(place / "fcc") as result:
        last = result.assembly.lattice.last_layer
        at_wall = result["wall_contacts/dissipated_energy"].sum()
        whole = result["spheres/dissipated_energy"][result.rows(last)].sum()
    assert at_wall > 0.1 * whole
    assert "The contacts of a layer with walls are included (" in caption
    assert f"{100 * at_wall / whole:.3g} % at " in caption and "in fcc" in caption


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


def test_nothing_is_left_out_without_a_name(place):
    """Packing and chain: each figure names the run that is missing, with the reason."""
    comparison = compared(place, "fcc", "chain")
    caption = comparison.caption("bottom_force")
    assert "Not drawn: chain (it has no bottom)." in caption
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


def test_titles_of_sections_in_own_axes_have_the_size_of_the_user(place):
    """Titles of the runs, and the common titles of the axes."""
    figure, axes = pyplot.subplots(1, 2, layout="constrained")
    gw.compare([place / "fcc", place / "hcp"]).figure("peak_force_field", ax=list(axes))
    size = axes[0].xaxis.label.get_fontsize()
    texts = [*(one.title for one in axes), *figure.texts]
    assert {text.get_fontsize() for text in texts} == {size}
    pyplot.close(figure)
