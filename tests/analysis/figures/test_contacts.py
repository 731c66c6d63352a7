"""Figures of contacts, and of a line in position and time: their content, and the runs that have
them.
"""

from __future__ import annotations

import csv
from dataclasses import replace
from types import SimpleNamespace

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import LineCollection, QuadMesh

from granwave.analysis import Result, write_result
from granwave.analysis.figures import contacts, lines, peak_force_depth, plastic_zone, regions
from granwave.analysis.figures.run_figures import draw_figures, run_figures
from granwave.analysis.figures.side_by_side import PROCESSES
from granwave.analysis.measures.contact_forces import contact_forces, exponential_tail
from granwave.analysis.measures.force_decay import power_decay
from granwave.analysis.measures.fronts import LineMotion
from granwave.analysis.summary import summary_of
from granwave.lammps_inputs.case.figures import Figures, usual_figure_names
from tests.helpers.made_up import synthetic

DIAMETER = synthetic.DIAMETER

OF_CONTACTS = ("contact_network", "force_distribution", "line_diagram")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Directory of an analysed synthetic run of FCC."""
    directory = tmp_path_factory.mktemp("run")
    write_result(synthetic.write_run(directory, synthetic.make_case(size=(6, 6, 4))))
    return directory


def drawn(directory, name):
    """The drawing of a figure of a run."""
    with Result(directory) as result:
        return run_figures()[name].draw(result)


def lines_of(drawing):
    """Lines of contacts in the first panel, their widths in points, and their ends in mm."""
    (lines,) = [
        artist
        for artist in drawing.figure.axes[0].collections
        if isinstance(artist, LineCollection)
    ]
    return np.array(lines.get_linewidths()), np.array(lines.get_segments())


def test_figures_drawn_by_name_stay(tmp_path, monkeypatch):
    """Figures on request are drawn again together with the default figures, until ``figures.only``
    names others.
    """
    monkeypatch.setenv(PROCESSES, "1")
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("chain", 3)))
    folder = tmp_path / "figures"
    png_only = Figures(formats=())
    draw_figures(tmp_path, names=("line_diagram",), options=png_only)
    assert {path.name for path in folder.iterdir()} == {"line_diagram.png", "line_diagram.csv"}
    assert not set(usual_figure_names()) & set(OF_CONTACTS)
    (folder / "line_diagram.png").write_bytes(b"")
    draw_figures(tmp_path, options=png_only)
    usual = {"bottom_force", "energies", "peak_force_depth", "plastic_zone_size"}
    assert {path.stem for path in folder.iterdir()} == {*usual, "line_diagram"}
    assert (folder / "line_diagram.png").stat().st_size > 0
    draw_figures(tmp_path, options=replace(png_only, only=("energies",)))
    assert {path.stem for path in folder.iterdir()} == {"energies"}


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        *(({"kind": kind, "size": (5, 5, 4)}, set(OF_CONTACTS)) for kind in ("hcp", "bcc")),
        ({"kind": "chain", "size": 2}, {"line_diagram"}),
        ({"kind": "chain", "size": 12}, {"line_diagram"}),
        ({"kind": "square", "size": (5, 5)}, {"contact_network", "force_distribution"}),
        ({"size": (1, 1, 1)}, set()),
    ],
)
def test_figures_that_apply(tmp_path, options, expected):
    """A lone sphere has no contacts; less than ten loaded contacts have no distribution, and a
    layer that is hit from the side has no line. The network of a chain is a line of contacts.
    """
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(**options)))
    assert {name for name in OF_CONTACTS if drawn(tmp_path, name) is not None} == expected


def test_lines_are_as_thick_as_forces(run):
    """Lines go from centre to centre."""
    drawing = drawn(run, "contact_network")
    widths, ends = lines_of(drawing)
    force = drawing.columns["peak_force_N"]
    assert widths / widths.max() == pytest.approx(force / force.max())
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(1e3 * DIAMETER)
    with Result(run) as result:
        pairs = zip(drawing.columns["peak_i"], drawing.columns["peak_j"], strict=True)
        known = dict(
            zip(
                zip(result["contacts/i"], result["contacts/j"], strict=True),
                result["contacts/peak_force"],
                strict=True,
            )
        )
    assert force.tolist() == [known[pair] for pair in pairs]
    assert f"{force.max():.3g} N" in drawing.figure.axes[0].get_title()


def test_a_contact_across_periodic_sides_is_two_lines(tmp_path):
    """A contact across a boundary has a line of one diameter from each grain; no line crosses the
    packing.
    """
    case = synthetic.make_case(size=(6, 6, 4), boundary={"sides": "periodic"})
    write_result(synthetic.write_run(tmp_path, case))
    drawing = drawn(tmp_path, "contact_network")
    widths, ends = lines_of(drawing)
    across = drawing.columns["peak_across_j_m"] - drawing.columns["peak_across_i_m"]
    n_images = len(ends) - len(drawing.columns["peak_i"])
    assert np.abs(across).max() < 1.01 * DIAMETER
    assert n_images > 0
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) == pytest.approx(1e3 * DIAMETER)
    assert len(widths) == len(ends)


def test_a_tall_packing_lies(tmp_path, monkeypatch):
    """The depth of a tall packing increases from left to right, up to 30 diameters."""
    monkeypatch.setattr(contacts, "_TALL", 0.5)  # the loaded part of the packing is not tall
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(size=(3, 3, 50))))
    axes = drawn(tmp_path, "contact_network").figure.axes[0]
    left, right = axes.get_xlim()
    assert axes.get_xlabel() == "Depth along the plane (mm)"
    assert left < 0 < right < 1e3 * 31 * DIAMETER


def test_a_large_network_is_a_picture(run, monkeypatch):
    """A PDF with very many lines is slow to display, so that they become a bitmap."""
    monkeypatch.setattr(contacts, "_MOST_VECTORS", 5)
    artists = drawn(run, "contact_network").figure.axes[0].collections
    assert all(artist.get_rasterized() for artist in artists)


def test_distribution_of_exponential_forces(run, monkeypatch):
    """The densities agree with the exponential distribution, and the decay with the fitted tail."""
    force = np.random.default_rng(3).exponential(7.0, 5000)
    state = contacts.ContactForces("peak", None, np.arange(5000), np.arange(5000), force)
    monkeypatch.setattr(contacts, "contact_forces", lambda result: [state])
    drawing = drawn(run, "force_distribution")
    columns = drawing.columns
    tail = exponential_tail(force / force.mean(), 1.0)
    assert columns["peak_tail_decay"] == [tail.decay]
    assert abs(tail.decay - 1) < 3 * tail.error
    assert columns["peak_contacts"].sum() == 5000
    many = columns["peak_contacts"] > 100
    expected = np.exp(-columns["peak_force_over_mean"][many])
    assert columns["peak_density"][many] == pytest.approx(expected, rel=0.2)
    text = drawing.figure.axes[0].get_legend().get_texts()[0].get_text()
    assert "5000 contacts" in text
    assert f"{tail.decay:.3f} ± {tail.error:.3f}" in text
    assert "not exponential" not in text


@pytest.mark.parametrize(
    ("spread", "text"),
    [(1e-9, "12 contacts, all with 20 N"), (0.01, "12 contacts, 20 N to 22.2 N")],
)
def test_forces_that_are_alike_are_a_band(run, monkeypatch, spread, text):
    """The figure states that nearly equal forces have no distribution."""
    ids = np.arange(12)
    state = contacts.ContactForces("static", 0.0, ids, ids, 20.0 * (1 + spread * ids))
    monkeypatch.setattr(contacts, "contact_forces", lambda result: [state])
    drawing = drawn(run, "force_distribution")
    mean = 20.0 * (1 + 5.5 * spread)
    assert drawing.columns == {
        "static_mean_force_N": [pytest.approx(mean)],
        "static_smallest_force_N": [pytest.approx(20.0)],
        "static_largest_force_N": [pytest.approx(20.0 * (1 + 11 * spread))],
    }
    axes = drawing.figure.axes[0]
    assert [line.get_text() for line in axes.get_legend().get_texts()] == [f"static state: {text}"]
    assert "no distribution" in axes.texts[0].get_text()
    assert not len(axes.get_yticks())


def test_forces_without_an_exponential_tail_have_no_decay(run, monkeypatch):
    """The forces of a power law, 5000 of 5100 loaded contacts."""
    force = np.random.default_rng(3).pareto(1.5, 5000) + 1.0
    ids = np.arange(5000)
    state = contacts.ContactForces("peak", None, ids, ids, force, n_left_out=100)
    monkeypatch.setattr(contacts, "contact_forces", lambda result: [state])
    text = drawn(run, "force_distribution").figure.axes[0].get_legend().get_texts()[0].get_text()
    first, second, third = text.split("\n")
    assert first.endswith("5000 of 5100 loaded contacts")
    assert second == "(with at least $10^{-4}$ of the largest force);"
    assert third.endswith("above the mean force: not exponential") and "±" not in text


def test_an_exponential_tail_is_a_straight_line(run, monkeypatch):
    """The axis of the forces is linear, also of wide distributions, whose largest forces are in a
    second panel.
    """
    ids = np.arange(5000)
    force = np.random.default_rng(3).exponential(7.0, 5000)
    force[0] = 30.0 * force.mean()
    state = contacts.ContactForces("peak", None, ids, ids, force)
    monkeypatch.setattr(contacts, "contact_forces", lambda result: [state])
    drawing = drawn(run, "force_distribution")
    axes = drawing.figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")
    assert axes.get_xlim() == (0, 20)
    of_all = drawing.figure.axes[1]
    assert (of_all.get_xscale(), of_all.get_yscale()) == ("log", "log")
    assert of_all.lines[0].get_xdata().max() > 20
    count = drawing.columns["peak_contacts"]
    assert count.sum() == 5000
    x = drawing.columns["peak_force_over_mean"][count > 100]
    density = drawing.columns["peak_density"][count > 100]
    slope, _ = np.polyfit(x, np.log(density), 1)
    assert slope == pytest.approx(-1.0, abs=0.05)


def test_the_bins_of_wide_forces_have_all_contacts(run):
    drawing = drawn(run, "force_distribution")
    columns = drawing.columns
    with Result(run) as result:
        force = result["contacts/peak_force"]
    carries = force >= 1e-4 * force.max()
    assert columns["peak_contacts"].sum() == carries.sum()
    axes = drawing.figure.axes[0]
    assert (axes.get_xscale(), axes.get_yscale()) == ("linear", "log")


def test_the_loaded_contacts_are_those_of_the_summary(tmp_path):
    """One definition: contacts that overlap by rounding are loaded neither in the legend nor in the
    summary.
    """
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(size=(6, 6, 4))))
    with h5py.File(tmp_path / "result.h5", "r+") as file:
        loaded = np.flatnonzero(file["contacts/peak_force"][()] > 0)[:5]
        overlap = file["contacts/peak_overlap"][()]
        force = file["contacts/peak_force"][()]
        overlap[loaded] = 0.5e-6 * file["contacts/yield_overlap"][()][loaded]
        force[loaded] = 1e-9
        file["contacts/peak_overlap"][...] = overlap
        file["contacts/peak_force"][...] = force
    with Result(tmp_path) as result:
        (peak,) = contact_forces(result)
        counted = summary_of(result)["n_loaded_contacts"]
        assert np.count_nonzero(result["contacts/peak_force"] > 0) == counted + 5
        assert len(peak.force) + peak.n_left_out == counted


def test_the_legend_has_the_number_of_fitted_layers():
    """The fit of the peak force omits the impacted and the last layer, as its caption says."""
    depth = np.arange(12) * 8.0e-3
    decay = power_decay(depth, 100.0 * np.exp(-50.0 * depth), 8.0e-3)
    assert decay is not None
    figure, axes = plt.subplots()
    peak_force_depth._draw_decay(axes, decay, 1.0)
    (line,) = axes.lines
    plt.close(figure)
    n_layers = decay.n_layers
    assert n_layers == 10
    assert line.get_label().endswith(f" %, {n_layers} layers")


def test_captions_explain_what_is_drawn():
    """White cells, pale spheres, the end of an axis, a panel that rigid targets lack."""
    looks = {name: figure.look for name, figure in run_figures().items()}
    assert "White: slower" in looks["line_diagram"]
    assert pytest.approx(1e-3) == 10**-lines._DECADES_OF_SPEED  # "one thousandth"
    assert "one thousandth of the largest speed" in looks["line_diagram"]
    for name in ("peak_force_orthogonal", "dissipation_orthogonal"):
        assert "Pale spheres" in looks[name]
    assert f"{plastic_zone._LEAST:.0e}".replace("-0", "-") in looks["plastic_zone_size"]
    assert "work" not in run_figures()["target"].caption
    assert "curve" not in looks["directions"]


@pytest.mark.parametrize(("kind", "n_series"), [("fcc", 1), ("hcp", 0)])
def test_only_lattices_with_straight_lines_of_grains_show_preferred_directions(
    tmp_path, kind, n_series
):
    """In hcp the contacts of the impacted sphere do not continue in straight lines."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case(kind, (6, 6, 6))))
    axes = drawn(tmp_path, "peak_force_depth").figure.axes[0]
    assert len(axes.containers) == n_series


def test_a_zone_on_the_axis_has_no_radius(tmp_path):
    """All yielded spheres of a chain are on its axis: only the depth is drawn."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("chain", 12)))
    drawing = drawn(tmp_path, "plastic_zone_growth")
    lower = drawing.figure.axes[1]
    assert len(lower.lines) == 1 and lower.get_ylabel() == "Depth of plastic zone (mm)"
    assert not drawing.columns["radius_m"].any()


def test_energy_that_is_not_dissipated_has_its_own_panel(run, monkeypatch):
    """Its fractions add up to 1 at each instant; parts below a thousandth are not drawn."""
    time = np.linspace(0.0, 1e-4, 5)
    lost = np.array([0.0, 0.5, 0.7, 0.8, 0.8])
    walls = np.full(5, 5e-4)
    share = {"dissipated": lost, "walls": walls, "0 to 20 mm deep": 1 - lost - walls}
    energy = SimpleNamespace(time=time, share=share, kinetic_only=False)
    monkeypatch.setattr(regions, "energy_of_regions", lambda result, parts: energy)
    monkeypatch.setattr(regions, "usual_regions", lambda result, along: {"0 to 20 mm deep": 0})
    drawing = drawn(run, "energy_by_region")
    upper, lower = drawing.figure.axes
    names = [text.get_text() for text in upper.get_legend().get_texts()]
    assert names == ["0 to 20 mm deep", "dissipated"]
    (area,) = lower.collections
    assert area.get_paths()[0].vertices[:, 1].max() == pytest.approx(1.0, abs=5e-3)
    assert drawing.columns["walls_over_input"] == pytest.approx(walls)
    share["dissipated"] = 0.4 * lost
    share["0 to 20 mm deep"] = 1 - 0.4 * lost - walls
    assert len(drawn(run, "energy_by_region").figure.axes) == 1


def test_slow_grains_behind_the_front_are_no_gaps(tmp_path):
    """Behind the front a grain that is slow for an instant has the lowest colour."""
    axes = plt.figure().add_subplot()
    velocity = np.array([[1.0, 0.0], [1e-9, 0.5], [0.3, 1e-9]])
    time = np.array([0.0, 1.0, 2.0])
    place = np.array([0.0, 1.0])
    arrival = np.array([0.0, 1.0])
    motion = LineMotion("axis", np.array([1, 2]), time, place, velocity, arrival, None)
    image = lines._draw_motion(axes, motion, "viridis")
    plt.close(axes.figure)
    assert image.get_array().filled(0.0).tolist() == [[1.0, 0.0], [1e-3, 0.5], [0.3, 1e-3]]


def test_a_chain_has_no_distribution(tmp_path):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("chain", 50)))
    with Result(tmp_path) as result:
        assert contacts.force_distribution(result) is None


def test_diagram_of_a_line(run):
    """Colours are the speeds of the snapshots; the data have each grain at each instant."""
    drawing = drawn(run, "line_diagram")
    axes = drawing.figure.axes[0]
    (mesh,) = [artist for artist in axes.collections if isinstance(artist, QuadMesh)]
    columns = drawing.columns
    shape = mesh.get_array().shape
    velocity = columns["axis_velocity_m_s"].reshape(shape)
    assert np.array_equal(mesh.get_array().filled(0.0), np.abs(velocity) * (velocity > 0))
    dots = axes.lines[0].get_xydata()
    arrival = columns["axis_arrival_s"]
    place = columns["axis_place_m"].reshape(shape)[0]
    reached = np.isfinite(arrival)
    assert dots == pytest.approx(1e3 * np.stack([place, 1e3 * arrival], axis=1)[reached])


def test_the_front_of_a_chain_lies_on_the_fitted_line(tmp_path):
    """In the synthetic run, contacts are first loaded by a front with 1000 m/s."""
    draw = synthetic.write_run(tmp_path, synthetic.make_case("chain", 20))
    write_result(draw)
    drawing = drawn(tmp_path, "line_diagram")
    dots, line = (curve.get_xydata() for curve in drawing.figure.axes[0].lines)
    assert drawing.columns["axis_front_speed_m_s"] == [pytest.approx(1000.0)]
    expected = np.interp(dots[-3:, 0], *line.T)
    assert dots[-3:, 1] == pytest.approx(expected, rel=1e-9)
    texts = drawing.figure.axes[0].get_legend().get_texts()
    assert [text.get_text() for text in texts] == ["front at a grain", "fitted: 1000 m/s"]


def test_rows_of_the_csv_file(run):
    draw_figures(run, names=("contact_network",))
    with open(run / "figures" / "contact_network.csv") as file:
        row = next(csv.DictReader(file))
    assert list(row) == [
        *("peak_i", "peak_j", "peak_force_N"),
        *("peak_across_i_m", "peak_down_i_m", "peak_across_j_m", "peak_down_j_m"),
    ]
