"""Figures: the drawn set, and the data files."""

from __future__ import annotations

import csv
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.figure import Figure

from granwave.analysis import Result, analyse, write_result
from granwave.analysis.figures import histories, sections
from granwave.analysis.figures.colouring import Colouring
from granwave.analysis.figures.grain_discs import draw_discs
from granwave.analysis.figures.run_figures import run_figures
from granwave.analysis.measures.target import unprotected
from granwave.lammps_inputs import struck_spheres
from granwave.lammps_inputs.case.figures import (
    FIGURES_AFTER_ADDED,
    FIGURES_BEFORE_ADDED,
    usual_figure_names,
)
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic

MOVING = {"energies", "bottom_force", "target", "impactor_velocity"}
PLANES = {"peak_force_principal", "peak_force_orthogonal", "wave_front", "directions"}
PRESSED = {"peak_force_depth"}  # of packings with contacts
LOST = {"dissipation_ranked", "dissipation_cumulated", "plastic_zone_growth", "plastic_zone_size"}
# have tests of their own
TESTED_ELSEWHERE = {
    "contact_network", "force_distribution", "line_diagram", "force_at_depths", "energy_by_region",
}  # fmt: skip
OWN = tuple(
    name for name in (*FIGURES_BEFORE_ADDED, *FIGURES_AFTER_ADDED) if name not in TESTED_ELSEWHERE
)
KINDS = ("fcc", "hcp", "bcc", "sc")
LOST_PLANES = {"dissipation_principal", "dissipation_orthogonal"}


def makes_sense(directory, case):
    """Names of the core's figures of a run, drawn but not saved."""
    write_result(synthetic.write_run(directory, case))
    with Result(directory) as result:
        return {name for name in OWN if run_figures()[name].draw(result) is not None}


@pytest.mark.parametrize("end_time", [1.5e-4, 6e-4])
def test_wave_front_is_shown_over_the_passage_of_the_wave(tmp_path, end_time):
    """The result does not depend on the number of snapshots or the duration of the run."""
    run = {"end_time": end_time, "frames": 121}
    case = synthetic.make_case("fcc", (8, 8, 6), load={"velocity": 5.0}, run=run)
    run_case(case, tmp_path, figures=False)
    with Result(tmp_path) as result:
        drawing = run_figures()["wave_front"].draw(result)
        arrival = result["walls/bottom/time"][np.argmax(result["walls/bottom/force"] > 0.1)]
        times = np.unique(drawing.columns["time_s"])
    assert times == pytest.approx(times[-1] * np.arange(1, 5) / 4, abs=end_time / 120)
    assert 0.8 < times[-1] / arrival < 1.2


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        *(
            ({"kind": kind, "size": (6, 6, 4)}, MOVING | PLANES | PRESSED | LOST | LOST_PLANES)
            for kind in KINDS
        ),
        ({"law": "hertz"}, MOVING | PLANES | PRESSED),
        ({"kind": "chain", "size": 2}, MOVING | LOST),  # a single contact
        ({"kind": "chain", "size": 12}, MOVING | PRESSED | LOST),
        ({"size": (1, 1, 1)}, MOVING),
    ],
)
def test_figures_of_runs(tmp_path, options, expected):
    assert makes_sense(tmp_path, synthetic.make_case(**options)) == expected


def test_figures_of_a_square_packing(tmp_path):
    names = makes_sense(tmp_path, synthetic.make_case("square", (5, 5)))
    assert {"peak_force_principal", "dissipation_principal"} <= names
    assert "peak_force_orthogonal" not in names


@pytest.mark.parametrize(("last", "right"), [(0.088, 96.0), (0.120, 88.0)])
def test_a_section_shows_the_last_column_whole_or_is_cut_well_before_it(last, right):
    cut = SimpleNamespace(across=np.arange(0.0, last + 1e-9, 0.008))
    cut.down = np.zeros_like(cut.across)
    window = sections.window_around(cut, cut.across < 0.073, 0.008)
    assert window[:2] == pytest.approx((-8.0, right))


@pytest.mark.parametrize(("last", "left"), [(0.110, -128.0), (0.150, -106.0)])
def test_a_section_is_cut_on_both_sides_or_not_at_all(last, left):
    """A crystal is not symmetrical about the impact axis."""
    cut = SimpleNamespace(across=np.arange(-0.120, last + 1e-9, 0.010))
    cut.down = np.zeros_like(cut.across)
    window = sections.window_around(cut, np.abs(cut.across) < 0.093, 0.008)
    assert window[0] == pytest.approx(left)


def test_figures_of_friction_dents_and_missing_spheres(tmp_path):
    case = synthetic.make_case(
        contact={"friction": 0.2, "initial_overlap": 4e-6}, packing={"vacancies": [3, 80]}
    )
    names = makes_sense(tmp_path, case)
    own = {
        f"{what}_{plane}"
        for what in ("dissipation_parts", "dents")
        for plane in ("principal", "orthogonal")
    }
    assert names == MOVING | PLANES | PRESSED | LOST | LOST_PLANES | own
    with Result(tmp_path) as result:
        columns = run_figures()["energies"].draw(result).columns
        total = sum(
            columns[f"{part}_J"]
            for part in ("kinetic", "rotation", "elastic", "yielding", "friction")
        )
        assert np.allclose(total, columns["input_J"], rtol=1e-6)
        columns = run_figures()["dissipation_parts_principal"].draw(result).columns
        assert 3 not in columns["id"] and np.isin(columns["id"], result["spheres/id"]).all()
        whole = (
            result["spheres/dissipated_energy"][result.rows(columns["id"])] / result.energy_input
        )
        assert np.allclose(
            columns["yielding_over_input"] + columns["friction_over_input"], whole, rtol=1e-12
        )
        force = run_figures()["target"].draw(result).columns["without_packing_force_N"]
        assert force.max() == pytest.approx(unprotected(assemble(case), 1.0).peak_force, rel=1e-6)


def test_figures_that_make_no_sense_any_more_are_removed(tmp_path):
    parts: list[str] = []
    synthetic.write_run(tmp_path, synthetic.make_case("chain", 3))
    analyse(tmp_path, parts.append)
    usual = [name for name in usual_figure_names() if name != "target"]  # the bottom is at rest
    assert parts == ["result.h5", "summary.json", *usual]
    assert (tmp_path / "figures" / "bottom_force.png").exists()
    synthetic.write_run(tmp_path, synthetic.make_case("chain", 3, boundary={"bottom": "free"}))
    (tmp_path / "dumps" / "walls.txt").unlink(missing_ok=True)
    analyse(tmp_path)
    assert not list((tmp_path / "figures").glob("bottom_force.*"))


def test_data_beside_a_figure(tmp_path):
    """The largest peak force of the plane is at the impacted sphere, where the range of the law was
    exceeded.
    """
    case = synthetic.make_case()
    analyse(synthetic.write_run(tmp_path, case, dent=450.0))
    folder = tmp_path / "figures"
    names = {path.stem for path in folder.glob("*.png")}
    assert all(
        {path.stem for path in folder.glob(f"*.{suffix}")} == names for suffix in ("pdf", "csv")
    )
    assert all(path.stat().st_size > 0 for path in folder.iterdir())
    with open(folder / "peak_force_principal.csv") as file:
        rows = list(csv.DictReader(file))
    struck = struck_spheres(assemble(case).lattice, 1)[0]
    top = max(rows, key=lambda row: float(row["peak_force_over_yield_force"]))
    row = next(row for row in rows if int(row["id"]) == struck)
    assert float(row["across_m"]) == float(row["down_m"]) == 0
    assert float(top["peak_force_over_yield_force"]) == float(row["peak_force_over_yield_force"])
    assert row["beyond_law"] == "1"
    with Result(tmp_path) as result:
        expected = result["spheres/peak_force"][struck - 1] / result.law.yield_force
    assert float(row["peak_force_over_yield_force"]) == pytest.approx(expected, rel=1e-9)


def test_a_sphere_struck_across_has_no_figure_of_its_velocity():
    time = np.linspace(0, 1e-3, 9)
    assert (
        histories.impactor_velocity({"energy/time": time, "energy/struck_velocity": np.zeros(9)})
        is None
    )


def test_the_legend_of_the_energies_lies_on_no_curve(tmp_path):
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("chain", 20)))
    with Result(tmp_path) as result:
        figure = run_figures()["energies"].draw(result).figure
    figure.draw_without_rendering()
    axes = figure.axes[0]
    assert (
        not axes.get_legend()
        .get_window_extent()
        .overlaps(axes.get_window_extent().shrunk(0.99, 0.99))
    )


def test_spheres_beyond_the_law_keep_their_colour():
    """Spheres beyond the range of the law have a black ring."""
    place = np.array([0.0, 0.01])
    cut = SimpleNamespace(across=place, down=place)
    colouring = Colouring(np.array([1.0, 5.0]), "", "", "viridis", 1.0, 10.0)
    shown = {}
    for beyond in (False, True):
        axes = Figure().subplots()
        draw_discs(
            axes, cut, colouring.values, colouring, np.full(2, 0.005), np.array([False, beyond])
        )
        (shown[beyond],) = axes.collections
    assert np.array_equal(shown[True].get_facecolors(), shown[False].get_facecolors())
    assert np.array_equal(shown[True].get_edgecolors()[1], [0, 0, 0, 1])
    assert shown[True].get_linewidths()[1] > 2 * shown[True].get_linewidths()[0]


def test_captions_say_what_to_look_for():
    """The caption has two lines in a report."""
    for name, figure in run_figures().items():
        assert figure.look.endswith("."), name
        assert 20 < len(figure.look) <= 130, name
