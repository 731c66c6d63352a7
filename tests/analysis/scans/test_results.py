"""Table and figures of a scan, and the wave speed, against known values."""

from __future__ import annotations

import csv
import json
import math
import os
import time

import h5py
import numpy as np
import pytest

from granwave.analysis import summarise, write_result
from granwave.analysis.document.model import Beside, Note
from granwave.analysis.measures.waves import front_arrivals, wave_speed
from granwave.analysis.result.reader import Result
from granwave.analysis.scans.figures import draw_scan_figures, drawings
from granwave.analysis.scans.keys import key_of
from granwave.analysis.scans.means import means_of
from granwave.analysis.scans.result import ScanResult, protects
from granwave.analysis.scans.table import (
    column_unit,
    independent_keys,
    physical,
    read_scan,
    scan_statistics,
    scan_table,
    write_scan_table,
)
from granwave.lammps_inputs import load_case, write_deck
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import library
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.synthetic_report import build
from tests.helpers.made_up.synthetic_scan import (
    case_of,
    grid,
    point_id,
    summary_of,
    write_json,
    write_scan,
)

QUANTITIES = {
    "dissipated_fraction",
    "plastic_zone_depth",
    "plastic_spheres",
    "peak_force",
    "wave_speed",
}


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    """Three velocities of two materials: point 2 failed, point 5 was never started."""
    points = grid(load__velocity=[1, 5, 20], material=["brass", "steel"])
    reason = 'ERROR: "lost atoms",\nrank 0: \udcff\0µ'
    return write_scan(tmp_path_factory.mktemp("scan"), points, failed={2: reason}, missing=[5])


def rows_of(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_columns_in_order_and_values(scan):
    table = scan_table(ScanResult(scan))
    names = list(table)
    assert names[:6] == ["load.velocity", "material", "status", "reason", "directory", "attempts"]
    assert names[6:8] == ["name", "n_spheres"] and names[-2:] == [
        "versions.granwave",
        "versions.lammps",
    ]
    assert table["status"] == ["done", "failed", "done", "done", "missing", "done"]
    assert table["attempts"] == [1, 2, 1, 1, 0, 1]
    labels = {"load.velocity": 5, "material": "brass"}
    assert table["directory"][2] == f"points/{point_id(labels)}"
    assert table["directory"][1].startswith("unfinished/") and table["directory"][4] == ""
    assert table["peak_force_N"][2] == summary_of(case_of(labels))["peak_force_N"]
    assert table["peak_force_N"][1] is None and table["peak_force_N"][4] is None


def test_csv_gives_every_number_back(scan):
    path = write_scan_table(scan)
    assert path == scan / "scan.csv" and not (scan / "scan_mean.csv").exists()
    assert b"\r" not in path.read_bytes()
    rows = rows_of(path)
    table = scan_table(ScanResult(scan))
    assert list(rows[0]) == list(table) and len(rows) == 6
    assert [row["peak_force_N"] and float(row["peak_force_N"]) for row in rows] == [
        "" if value is None else value for value in table["peak_force_N"]
    ]
    assert rows[1]["reason"] == 'ERROR: "lost atoms",\nrank 0: ?µ'
    assert [path.name for path in scan.iterdir() if path.name.startswith(".")] == [
        ".granwave"
    ]  # no temporary file


def test_hdf5_has_types_and_units(scan):
    write_scan_table(scan)
    with h5py.File(scan / "scan.h5") as file:
        assert (file.attrs["name"], file.attrs["case"]) == ("synthetic", "fcc-small")
        assert set(file) == set(scan_table(ScanResult(scan)))
        assert (
            file["load.velocity"].dtype == np.int64 and file["load.velocity"].attrs["unit"] == "m/s"
        )
        assert file["n_spheres"].dtype == np.float64 and math.isnan(
            file["n_spheres"][1]
        )  # missing in two rows
        assert file["material"].asstr()[1] == "steel" and file["status"].asstr()[4] == "missing"
        assert all("unit" in column.attrs for column in file.values())


def test_units():
    for unit, names in {
        "J": "energy_input_J", "N": "peak_force_N peak_force_N.std", "m": "peak_overlap_m packing.diameter",
        "m^3": "plastic_zone_volume_m3", "m/s": "wave_speed_m_s", "N s": "wall_impulse_Ns", "s": "wall_time_s",
        "1/s": "sphere_steps_per_s", "Pa": "material.youngs_modulus", "1": "n_steps versions.plugin_s dissipated_fraction",
    }.items():  # fmt: skip
        assert {name: column_unit(name, {}) for name in names.split()} == dict.fromkeys(
            names.split(), unit
        )


def test_a_scan_without_a_finished_point(tmp_path):
    """Keys keep their names if a summary has values of the same name."""
    write_scan(tmp_path, [{"name": "one"}, {"name": "two"}])
    table = scan_table(ScanResult(tmp_path))
    assert table["name"] == table["summary.name"] == ["one", "two"]
    write_scan(tmp_path / "none", grid(load__velocity=[1, 2]), missing=[1, 2])
    assert [row["status"] for row in rows_of(write_scan_table(tmp_path / "none"))] == [
        "missing",
        "missing",
    ]
    assert (
        draw_scan_figures(tmp_path / "none") == []
        and read_scan(tmp_path / "none").where("done").n_points == 0
    )


def test_replicates_have_means_and_deviations(tmp_path):
    points = grid(load__velocity=[1, 5], packing__seed=[1, 2, 3])
    write_scan(tmp_path, points, missing=[3, 5, 6])
    statistics = scan_statistics(ScanResult(tmp_path))
    forces = [summary_of(case_of(point))["peak_force_N"] for point in points]
    assert statistics["load.velocity"] == [1, 5] and statistics["n"] == [2, 1]
    assert "packing.seed" not in statistics and "name.mean" not in statistics
    assert statistics["peak_force_N.mean"] == pytest.approx(
        [sum(forces[:2]) / 2, forces[3]], rel=1e-14
    )
    assert statistics["peak_force_N.std"][0] == pytest.approx(
        abs(forces[0] - forces[1]) / math.sqrt(2), rel=1e-12
    )
    assert statistics["peak_force_N.std"][1] is None and statistics["peak_force_N.ci95"][1] is None
    half = 12.7062 * statistics["peak_force_N.std"][0] / math.sqrt(2)  # of two values, by tables
    assert statistics["peak_force_N.ci95"][0] == pytest.approx(half, rel=1e-5)
    write_scan_table(tmp_path)
    assert rows_of(tmp_path / "scan_mean.csv")[1]["peak_force_N.std"] == ""
    with h5py.File(tmp_path / "scan.h5") as file:
        assert file["mean/n"][()].tolist() == [2, 1] and math.isnan(
            file["mean/peak_force_N.std"][1]
        )
        assert (
            file["mean/peak_force_N.mean"].attrs["unit"]
            == file["mean/peak_force_N.ci95"].attrs["unit"]
            == "N"
        )


def test_two_thousand_points_are_quick(tmp_path):
    """Summaries are read once; the table is then rewritten within a second."""
    points = [{"load.velocity": 1 + n / 1000} for n in range(2000)]
    summary = summary_of(case_of({}))
    for labels in points:
        folder = tmp_path / "points" / point_id(labels)
        folder.mkdir(parents=True)
        write_json(folder / "summary.json", summary)
    index = [
        {"number": n, "id": point_id(labels), "labels": labels}
        for n, labels in enumerate(points, start=1)
    ]
    write_json(
        tmp_path / "scan.json",
        {"name": "many", "case": "c", "varied": ["load.velocity"], "points": index},
    )
    result = ScanResult(tmp_path)
    write_scan_table(result)
    start = time.process_time()
    write_scan_table(result)
    assert time.process_time() - start < 1.0


def test_reader(scan):
    data = read_scan(scan)
    assert data.n_points == 6 and data.varied == ("load.velocity", "material")
    assert data["load.velocity"].tolist() == [1, 1, 5, 5, 20, 20]
    brass = data.where("done", material="brass")
    assert brass["load.velocity"].tolist() == [1, 5] and brass.unit("peak_force_N") == "N"
    assert np.all(np.isfinite(brass["peak_force_N"]))
    with pytest.raises(KeyError, match=r"no column peak; it has load\.velocity"):
        data["peak"]
    frame = data.to_pandas()
    assert frame.groupby("status").size().to_dict() == {"done": 4, "failed": 1, "missing": 1}
    assert (
        frame.attrs["units"]["peak_force_N"] == "N"
        and frame.attrs["units"]["load.velocity"] == "m/s"
    )


def test_reader_for_xarray(tmp_path):
    """Zipped keys share a dimension, and the order of the points does not matter."""
    points = [
        {"load.velocity": v, "material": m, "run.end_time": t}
        for m in ("steel", "brass")
        for v, t in ((1, 2e-3), (5, 1e-3))
    ]
    write_scan(tmp_path, [points[2], *points[:2], points[3]])
    data = read_scan(tmp_path).to_xarray()
    assert dict(data.sizes) == {"load.velocity": 2, "material": 2}
    assert data["run.end_time"].dims == ("load.velocity",)
    found = data["peak_force_N"].sel({"load.velocity": 5, "material": "steel"})
    assert found == summary_of(case_of({"load.velocity": 5, "material": "steel"}))["peak_force_N"]
    assert data["peak_force_N"].attrs["units"] == "N"
    write_scan(
        tmp_path / "bad", [*points, {"load.velocity": 9, "material": "brass", "run.end_time": 1.0}]
    )
    with pytest.raises(ValueError, match="found 5 points at 5 positions of a grid of 3 × 2"):
        read_scan(tmp_path / "bad").to_xarray()


def test_independent_keys():
    labels = {
        "run.end_time": [2, 1, 2, 1],
        "load.velocity": [1, 5, 1, 5],
        "material": ["a", "a", "b", "b"],
        "c": [0] * 4,
    }
    assert independent_keys(labels) == ["load.velocity", "material"]


def test_sizes_are_numbers():
    key = key_of("packing.size", ["[24, 24, 6]", "[24, 24, 12]"])
    assert key.numeric and key.values == (6, 12) and key.naming.label == "Layers"
    assert key_of("packing.size", ["[4, 4, 6]", "[5, 5, 6]"]).values == (96, 150)
    assert key_of("packing.size", [20, 40]).values == (20, 40)
    for sizes, label, values in (
        ([[6, 24], [6, 32]], "Rows", (24, 32)),
        ([[6, 24], [8, 24]], "Grains along x", (6, 8)),
        (
            [[6, 24], [8, 32]],
            "Grains along x times rows",
            (144, 256),
        ),  # rows of n and n - 1 have fewer
    ):
        key = key_of("packing.size", [str(size) for size in sizes])
        assert (key.naming.label, key.values) == (label, values)
    assert not key_of("run.end_time", [1e-3, "auto"]).numeric


def stems(paths):
    return {path.stem for path in paths}


def test_figures_of_velocity_and_material(scan):
    written = draw_scan_figures(scan)
    expected = {f"{name}_vs_load_velocity" for name in QUANTITIES}
    assert stems(written) == expected | {"collapse_dissipated_fraction", "collapse_plastic_volume"}
    for path in written:
        assert all(
            path.with_suffix(suffix).stat().st_size > 0 for suffix in (".png", ".pdf", ".csv")
        )
    rows = rows_of(scan / "figures" / "peak_force_vs_load_velocity.csv")
    labels = [
        {"load.velocity": v, "material": m}
        for m, v in (("brass", 1), ("brass", 5), ("steel", 5), ("steel", 20))
    ]
    for row, point in zip(rows, labels, strict=True):
        case = case_of(point)
        assert (float(row["load.velocity_m_s"]), row["material"]) == (
            point["load.velocity"],
            point["material"],
        )
        force = summary_of(case)["peak_force_N"]  # both materials have their own yield force
        assert float(row["peak_force_N"]) == pytest.approx(force, rel=1e-9)


def test_categories_as_bars(tmp_path):
    write_scan(tmp_path, grid(packing__kind=["fcc", "hcp", "bcc"], material=["brass", "steel"]))
    assert stems(draw_scan_figures(tmp_path, pdf=False)) == {
        f"{name}_vs_packing_kind" for name in QUANTITIES
    }
    rows = rows_of(tmp_path / "figures" / "plastic_spheres_vs_packing_kind.csv")
    assert [(row["packing.kind"], row["material"]) for row in rows[2:4]] == [
        ("bcc", "brass"),
        ("fcc", "steel"),
    ]
    expected = summary_of(case_of({"packing.kind": "fcc", "material": "steel"}))[
        "n_plastic_spheres"
    ]
    assert float(rows[3]["n_plastic_spheres"]) == expected


def test_keys_varied_together_and_text_with_commas(tmp_path):
    """Size and kind vary together: curves against one, bars by the other, no legend; the size is
    quoted in a CSV file.
    """
    zipped = [
        {"packing.kind": kind, "packing.size": f"[12, 12, {n}]"}
        for kind, n in (("fcc", 10), ("hcp", 12))
    ]
    write_scan(tmp_path / "zip", zipped)
    names = stems(draw_scan_figures(tmp_path / "zip", pdf=False))
    assert names == {f"{name}_vs_packing_{key}" for name in QUANTITIES for key in ("size", "kind")}
    assert len(rows_of(tmp_path / "zip" / "figures" / "peak_force_vs_packing_size.csv")[0]) == 2
    write_scan(
        tmp_path / "grid",
        grid(load__velocity=[1, 2], packing__size=["[12, 12, 10]", "[24, 24, 12]"]),
    )
    draw_scan_figures(tmp_path / "grid", pdf=False)
    rows = rows_of(tmp_path / "grid" / "figures" / "peak_force_vs_load_velocity.csv")
    assert [row["packing.size"] for row in rows] == ["[12, 12, 10]"] * 2 + ["[24, 24, 12]"] * 2


def test_figures_of_a_grid_with_replicates(tmp_path):
    grid_of_three = {"load__velocity": [1, 3, 10], "packing__diameter": [0.005, 0.01, 0.02]}
    points = grid(**grid_of_three, packing__seed=[1, 2])
    write_scan(tmp_path, points)
    names = stems(draw_scan_figures(tmp_path, pdf=False))
    assert {"dissipated_fraction_map", "wave_speed_vs_load_velocity"} <= names
    assert not any("seed" in name for name in names)
    rows = rows_of(tmp_path / "figures" / "wave_speed_vs_load_velocity.csv")
    assert [float(row["packing.diameter_m"]) for row in rows[::3]] == [0.005, 0.01, 0.02]
    speeds = [summary_of(case_of(point))["wave_speed_m_s"] for point in points[:2]]
    assert float(rows[0]["wave_speed_m_s"]) == pytest.approx(np.mean(speeds), rel=1e-9)
    assert float(rows[0]["standard_deviation"]) == pytest.approx(np.std(speeds, ddof=1), rel=1e-9)
    assert rows[0]["n"] == "2"


def test_figures_that_make_no_sense_any_more_go(tmp_path):
    write_scan(tmp_path, grid(load__velocity=[1, 2], contact__law=["hertz"]))
    folder = tmp_path / "figures"
    folder.mkdir()
    ResultDirectory(tmp_path).claim(["figures/plastic_spheres_vs_load_velocity.png"])
    for name in ("plastic_spheres_vs_load_velocity.png", "mine_vs_theirs.png", "own.png"):
        (folder / name).touch()
    assert stems(draw_scan_figures(tmp_path, pdf=False)) == {
        "peak_force_vs_load_velocity",
        "wave_speed_vs_load_velocity",
    }
    assert (folder / "own.png").exists() and not (
        folder / "plastic_spheres_vs_load_velocity.png"
    ).exists()
    header = (folder / "peak_force_vs_load_velocity.csv").read_text().splitlines()[0]
    assert header.endswith("peak_force_N")  # no yield force to divide by
    os.remove(
        tmp_path
        / "points"
        / point_id({"load.velocity": 1, "contact.law": "hertz"})
        / "summary.json"
    )
    assert draw_scan_figures(tmp_path) == []
    assert sorted(path.name for path in folder.iterdir()) == ["mine_vs_theirs.png", "own.png"]


def test_wave_speed_takes_the_arrivals_of_deep_layers(tmp_path):
    """The upper layers, and layers that were not reached, are ignored."""
    depth = np.arange(16) * 0.01
    arrival = depth / 500.0
    arrival[:6] = 1e-9
    arrival[-2:] = np.inf
    assert wave_speed(depth, arrival, 0.01) == pytest.approx(500.0, rel=1e-6)
    # eight layers: three below the upper five
    assert wave_speed(depth[:8], arrival[:8], 0.01) is None
    assert wave_speed(depth, np.full(16, 1e-6), 0.01) is None
    # contacts of the synthetic chain are first loaded at their distance divided by 1000 m/s
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("chain", 20)))
    assert summarise(tmp_path)["wave_speed_m_s"] == pytest.approx(1000.0, rel=1e-9)


def test_wave_arrives_at_a_layer_with_its_first_contact(tmp_path):
    """Two spheres per layer: contacts of the sphere beside the axis are loaded later."""
    write_result(synthetic.write_run(tmp_path, synthetic.make_case("sc", (2, 1, 16))))
    with Result(tmp_path) as result:
        depth, arrival = front_arrivals(result)
        first = result["contacts/time_first"]
        beside = first[np.isin(result["contacts/i"], result["spheres/id"][2:4])]
    assert beside.max() > 1.5 * beside.min()
    assert np.isfinite(arrival[:8]).all()  # the run ends before the deeper layers
    assert arrival[1:8] == pytest.approx((depth[1:8] - 0.005) / 1000.0, rel=1e-9)


def test_wave_speed_of_a_hertz_chain(granwave, tmp_path):
    """Nesterenko's speed of a solitary wave with the peak force of the chain."""
    settings = [
        "contact.law=hertz",
        "packing.kind=chain",
        "packing.size=40",
        "run.end_time=5.5e-4",
        "run.frames=2",
    ]
    options = [word for setting in settings for word in ("--set", setting)]
    assert granwave("run", "fcc-small", "-o", tmp_path / "r", *options).returncode == 0
    found = json.loads((tmp_path / "r" / "summary.json").read_text())["wave_speed_m_s"]
    with Result(tmp_path / "r") as result:
        force = float(np.median(result["contacts/peak_force"][20:35]))
        material = result.case.material
        diameter = result.case.packing.diameter
    stiffness = (
        2
        * material.youngs_modulus
        / (diameter * material.density**1.5 * (1 - material.poisson_ratio**2))
    )
    assert found == pytest.approx(0.6802 * stiffness ** (1 / 3) * force ** (1 / 6), rel=0.02)


def test_wave_speed_in_a_packing_that_yields(lmp, tmp_path):
    """The front precedes the peak force, increasingly so because the wave spreads: in the deeper
    half it is less than 10 % faster.
    """
    settings = [
        "packing.size=[14,14,14]",
        "run.end_time=3e-4",
        "run.frames=2",
        "boundary.bottom=free",
    ]
    written = write_deck(load_case(library.find("fcc-small"), settings), tmp_path)
    assert lmp(written.script).returncode == 0
    write_result(tmp_path)
    found = summarise(tmp_path)["wave_speed_m_s"]
    with Result(tmp_path) as result:
        depth = result["spheres/position"][:, 2] - result.origin[2]
        first = result["contacts/i"] - 1
        second = result["contacts/j"] - 1
        force = result["contacts/peak_force"]
        peak = result["contacts/time_peak"]
        mean, arrived = front_arrivals(result)
    spacing = written.case.packing.diameter * math.sqrt(2 / 3)
    layer = np.rint(depth / spacing).astype(int)
    gap = np.where(
        layer[first] != layer[second], np.minimum(layer[first], layer[second]), -1
    )  # below this layer
    above = range(6, 13)
    passed = np.array([peak[gap == k][np.argmax(force[gap == k])] for k in above])
    ahead = passed - arrived[7:]
    assert mean == pytest.approx(spacing * np.arange(14), abs=1e-9)
    assert np.all(ahead > 0) and ahead[-1] > ahead[0]
    of_peak = np.polyfit(passed, np.arange(7) * spacing, 1)[0]
    assert 1.0 < found / of_peak < 1.1


@pytest.fixture
def driven(tmp_path, request):
    directory = write_scan(
        tmp_path / "scan", grid(load__velocity=[1, 4], contact__friction=[0.3, 0.5])
    )
    index = json.loads((directory / "scan.json").read_text())
    index["varied"] = ["load.amplitude", "load.frequency"]
    for point in index["points"]:
        velocity, friction = point["labels"].values()
        point["labels"] = {"load.amplitude": 1e-8 * velocity, "load.frequency": 1e4 * friction}
    (directory / "scan.json").write_text(json.dumps(index))
    for point in ScanResult(directory).points:
        folder = directory / "points" / point.id
        (folder / "case.toml").write_text(f'[load]\nkind = "{request.param}"\n')
        path = folder / "summary.json"
        more = {"transmission": 1 - 1e6 * point.labels["load.amplitude"]}
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    return ScanResult(directory)


@pytest.mark.parametrize(
    ("driven", "unit", "setting"),
    [
        ("displacement", "m", "amplitude of the load 40 nm"),
        ("force", "N", "amplitude of the load 4e-8 N"),
    ],
    indirect=["driven"],
)
def test_amplitude_and_transmission(driven, unit, setting):
    assert (
        driven.units["load.amplitude"] == unit
        and read_scan(driven.directory).unit("load.amplitude") == unit
    )
    means = means_of(driven)
    assert means.quantities()[0] == ("transmission", "transmission")
    assert setting in means.sentence("transmission") and "falls with amplitude" in means.sentence(
        "transmission"
    )
    columns = drawings(driven)["transmission_vs_load_amplitude"].columns
    assert f"load.amplitude_{unit}" in columns


@pytest.mark.parametrize(
    ("labels", "expected"),
    [
        ([2e-3], ("mm", 2.0)),
        ([5e-6], ("µm", 5.0)),
        ([5e-9, 2e-6], ("µm", 0.005)),
        ([3e-10], ("nm", 0.3)),
    ],
)
def test_unit_by_size(labels, expected):
    key = key_of("load.amplitude", labels, "m")
    assert (key.naming.unit, key.values[0]) == expected


def test_vectors_along_one_axis_are_numbers():
    key = key_of("striker.2.velocity", ["[0.5, 0, 0]", "[2, 0, 0]", "[0, 0, 0]"])
    assert key.numeric and key.values == (0.5, 2.0, 0.0)
    assert key.naming.label == "Velocity of the striker along x" and key.naming.unit == "m/s"
    assert key.labels == ("[0.5, 0, 0]", "[2, 0, 0]", "[0, 0, 0]")  # tables of data keep them
    for labels in (["[0, 0, 1]", "[0, 1, 0]"], ["[0, 0, 0]"], ["[0, 1]", "[0, 2]"], ["a", "b"]):
        assert not key_of("striker.2.velocity", labels).numeric


def test_names_of_replaced_spheres():
    density = key_of("replace.1.material.density", [4000.0, 8000.0]).naming
    assert (density.label, density.unit) == ("Density of replaced spheres", "kg/m³")
    diameter = key_of("replace.2.diameter", [0.01, 0.02])
    assert diameter.naming.label == "Diameter of replaced spheres" and diameter.values == (
        10.0,
        20.0,
    )
    assert key_of("replace.1.index", [3, 4]).naming.label == "Position of replaced spheres"
    assert key_of("replace.first", [1]).naming.label == "replace.first"


def test_run_times_that_follow_are_left_out():
    times = {"run.end_time": [1e-3, 5e-4, 5e-4]}
    assert list(physical({"load.velocity": [1, 2, 3], **times})) == ["load.velocity"]
    assert list(physical({"load.velocity": [1, 2, 2], "run.end_time": [1, 2, 3]})) == [
        "load.velocity",
        "run.end_time",
    ]
    assert list(physical(times)) == ["run.end_time"]


PLATE = {"target_peak_displacement_m": 1e-6}


@pytest.mark.parametrize(
    ("varied", "summaries", "expected"),
    [
        (
            ["contact.friction"],
            [{"peak_reduction": 1.4}],
            False,
        ),  # a wall is only what holds the packing
        (
            ["contact.friction"],
            [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2} | PLATE],
            True,
        ),
        (["contact.friction"], [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2}], False),
        (["boundary.bottom"], [{"peak_reduction": 1.4} | PLATE, {"peak_reduction": 1.2}], True),
        (["boundary.bottom.plate.mass"], [{"peak_reduction": 0.7}], True),
        (["boundary.bottom"], [{"peak_reduction": 1.00004}], False),  # one sphere
        (["boundary.bottom"], [{"peak_reduction": None}, {}], False),
        (["boundary.bottom"], [], False),
    ],
)
def test_which_scans(varied, summaries, expected):
    assert protects(varied, summaries) is expected


@pytest.mark.parametrize("plate", [True, False])
def test_main_figure(tmp_path, plate):
    scan = write_scan(
        tmp_path / "scan", grid(contact__friction=[0, 0.1, 0.2], load__velocity=[1, 5])
    )
    for point in ScanResult(scan).points:
        path = scan / "points" / point.id / "summary.json"
        reduction = 2 + 10 * point.labels["contact.friction"] - 0.1 * point.labels["load.velocity"]
        more = {"peak_reduction": reduction} | (PLATE if plate else {})
        path.write_text(json.dumps(json.loads(path.read_text()) | more))
    draw_scan_figures(scan, pdf=False)
    assert (scan / "figures" / "peak_reduction_vs_contact_friction.png").exists() is plate
    means = means_of(ScanResult(scan))
    assert (means.quantities()[0][1] == "peak_reduction") is plate
    answer = build([scan], tmp_path).sections[0].blocks
    (sentence,) = [
        block.text for block in answer if isinstance(block, Note) and block.tone == "lead"
    ]
    (shown,) = [block for block in answer if isinstance(block, Beside)]
    if plate:
        assert sentence.startswith(
            "Peak reduction: from 1.5 (friction coefficient 0, impact velocity 5 m/s) to 3.9 "
        )
        assert "It rises with friction coefficient, falls with impact velocity." in sentence
        assert shown.gallery.figures[0].name.endswith("peak-reduction-vs-contact-friction")
        assert shown.table.columns[2].heading == "Peak reduction"
    else:
        assert sentence.startswith("Dissipated fraction") and "Peak reduction" not in str(
            shown.table
        )


def test_values_of_limited_zones_come_last(tmp_path):
    """The force on the bottom is the main result if the zone of a point reaches a boundary; values
    of zones follow values without a limit.
    """
    scan = write_scan(tmp_path, grid(packing__diameter_scatter=[0, 2e-6, 5e-6]))
    wall_forces = [1869.0, 1200.0, 940.0]
    for number, point in enumerate(ScanResult(scan).points):
        path = point.directory / "summary.json"
        summary = json.loads(path.read_text()) | {
            "dissipated_fraction": 0.7 + 0.001 * number,
            "peak_force_N": 700.0 + number,
            "n_plastic_spheres": 426 + 55 * number,
            "plastic_zone_depth_m": 0.04 + 0.01 * number,
            "wall_peak_force_N": wall_forces[number],
            "zone_cut": [],
        }
        write_json(path, summary)
    keys = [key for _, key in means_of(ScanResult(scan)).quantities()]
    assert keys[:2] == ["wall_peak_force_N", "n_plastic_spheres"]
    path = ScanResult(scan).points[2].directory / "summary.json"
    write_json(path, json.loads(path.read_text()) | {"zone_cut": ["bottom"]})
    means = means_of(ScanResult(scan))
    keys = [key for _, key in means.quantities() if means.varies(key)]
    assert keys[:3] == ["wall_peak_force_N", "dissipated_fraction", "peak_force_N"]
    assert set(keys[-2:]) == {"n_plastic_spheres", "plastic_zone_depth_m"}
    assert means.sentence(keys[0]).startswith("Peak force on the bottom: from 940 N")
