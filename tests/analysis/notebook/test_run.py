"""Runs and scans in notebooks."""

from __future__ import annotations

import json
import pickle
from dataclasses import replace

import h5py
import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.axes import Axes

from granwave.analysis import analyse, read_scan
from granwave.analysis.errors import MissingDataError, MissingOutputError, OutputFormatError
from granwave.analysis.notebook import datasets
from granwave.analysis.notebook.load import load
from granwave.analysis.notebook.run import Run
from granwave.analysis.summary_table import summary_table
from granwave.lammps_inputs.errors import InputError
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.export_inputs import equal, write_chain_run
from tests.helpers.made_up.synthetic_scan import grid, write_scan

NAME = '<i>a & "b"'  # a case may be called so


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    place = tmp_path_factory.mktemp("run")
    synthetic.write_run(place, replace(synthetic.make_case(), name=NAME))
    analyse(place, figures=False)
    return place


@pytest.fixture
def run(directory):
    return load(directory)


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    place = tmp_path_factory.mktemp("chain")
    write_chain_run(place)
    (place / "summary.json").write_text(json.dumps({"name": "chain"}))
    return Run(place)


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    pyplot.close("all")


def test_values(run, directory):
    summary = json.loads((directory / "summary.json").read_text())
    assert (
        dict(run) == summary == run.summary
        and list(run) == list(run.keys())
        and len(run) == len(summary)
    )
    assert run["peak_force_N"] == summary["peak_force_N"] and "peak_force" not in run
    assert run.unit("peak_force_N") == "N" and run.unit("n_spheres") == "1"
    assert run.name == run.case.name == NAME and run.directory == directory


def test_text(run, directory):
    assert repr(run) == f"{summary_table(run)}\n\nresults in {directory}"


def test_html_is_escaped_and_explains(run):
    page = run._repr_html_()
    assert "&lt;i&gt;a &amp; &quot;b&quot;" in page and "<i>" not in page
    assert (
        'title="n_plastic_contacts: Yielded contacts. Contacts between two spheres whose overlap'
        in page
    )
    assert page.count("<tr") == page.count("</tr>") == len(repr(run).splitlines()) - 2


@pytest.mark.parametrize("group", ["spheres", "contacts"])
def test_tables_are_those_of_the_file(run, directory, group):
    table = run.table(group).reset_index()
    with h5py.File(directory / "result.h5") as file:
        for name, source in file[group].items():
            parts = [name] if source.ndim == 1 else [f"{name}_{axis}" for axis in "xyz"]
            if group == "contacts" or name != "id":
                assert table[parts[0]].dtype == source.dtype, name
            assert equal(table[parts].to_numpy(source.dtype).reshape(source.shape), source[()]), (
                name
            )
            assert {table.attrs["units"][part] for part in parts} == {source.attrs["unit"]}
    assert set(table.attrs["units"]) >= set(run.table(group).columns)


def test_rows_are_named(run, directory):
    with h5py.File(directory / "result.h5") as file:
        row = file["spheres/id"][()].tolist().index(7)
        assert run.spheres.loc[7, "peak_force"] == file["spheres/peak_force"][row]
        assert equal(run.energies.index.to_numpy(), file["energy/time"][()])
        assert equal(run.energies["kinetic"].to_numpy(), file["energy/kinetic"][()])
        assert equal(run.walls["force"].to_numpy(), file["walls/bottom/force"][()])
    assert (
        run.energies.attrs["units"]["kinetic"] == "J" and run.energies.attrs["units"]["time"] == "s"
    )
    assert set(run.walls["wall"]) == {"bottom"} and run.walls.attrs["units"] == {
        "wall": "1", "time": "s", "force": "N", "impulse": "N s"
    }  # fmt: skip
    assert run.wall_contacts.empty and "wall" in run.wall_contacts
    assert run.tables == ("spheres", "contacts", "wall_contacts", "energy")


def test_fields_are_those_of_the_file(run, directory):
    fields = run.fields
    assert dict(fields.sizes) == {"time": 4, "id": run["n_spheres"], "axis": 3}
    with h5py.File(directory / "result.h5") as file:
        for name in fields:
            source = file[f"particles/spheres/{name}/value"]
            assert (
                equal(fields[name].to_numpy(), source[()])
                and fields[name].attrs["units"] == source.attrs["unit"]
            )
        moved = file["particles/spheres/displacement/value"][()]
        ids = file["spheres/id"][()]
        assert equal(fields.time.to_numpy(), file["particles/spheres/position/time"][()])
    assert equal(
        fields.displacement.isel(time=-1).sel(id=[7, 3], axis="z").to_numpy(),
        moved[-1, np.array([6, 2]), 2],
    )
    assert ids[6] == 7
    again = load(directory).fields.displacement  # nothing of it has been read
    assert equal(again[::-1, 5:2:-1, 0].to_numpy(), moved[::-1, 5:2:-1, 0])
    assert equal(again.where(again.id < 5, drop=True).to_numpy(), moved[:, :4])


def test_snapshots_are_read_when_they_are_asked_for(run, monkeypatch):
    read = []
    original = datasets._OnDemand._read
    monkeypatch.setattr(
        datasets._OnDemand, "_read", lambda self, key: read.append(key) or original(self, key)
    )
    last = run.fields.velocity.isel(time=-1)
    repr(run.fields)
    assert read == []
    assert last.to_numpy().shape == (run["n_spheres"], 3) and len(read) == 1 and read[0][0] == 3


def test_runs_and_fields_can_be_sent_to_other_processes(run):
    run.labels["load.velocity"] = 5.0
    _ = run.result
    again = pickle.loads(pickle.dumps(run))
    assert again == run and again.labels == run.labels and again.directory == run.directory
    fields = pickle.loads(pickle.dumps(run.fields))
    assert fields.identical(run.fields.copy(deep=True))


def test_history_of_a_chain(chain):
    found = chain.chain
    file = chain.result.file
    assert found.contact_force.dims == ("time", "contact") and found.velocity.dims == (
        "time",
        "bead",
    )
    assert found.bar_velocity.dims == ("time", "bar_node") and found.bar_force.dims == (
        "time",
        "bar_element",
    )
    for name in ("contact_force", "displacement", "contact_i", "position", "time"):
        assert equal(found[name].to_numpy(), file[f"chain/{name}"][()]), name
    assert equal(found.bead.to_numpy(), file["chain/id"][()]) and equal(
        found.bar_force, file["bars/bar/force"][()]
    )
    assert found.bar_force.attrs["units"] == "N" and found.bar_position.attrs["units"] == "m"
    assert set(chain.walls["wall"]) == set(chain.result.names("walls"))


def test_figures_are_handed_over(run, directory):
    before = dict(mpl.rcParams)
    axes = run.figure("peak_force_principal")
    assert isinstance(axes, Axes)  # without its colour bar
    assert pyplot.gcf() is axes.figure and axes.get_xlabel().startswith(
        "Distance from the impact axis"
    )
    energy, residual = run.figure("energies")
    assert {
        line.get_markersize() for line in energy.xaxis.get_ticklines()
    } and residual.get_xlabel()
    assert energy.xaxis.get_major_ticks()[0].get_tickdir() == "in"  # the style lasts
    assert len(pyplot.get_fignums()) == 2 and not (directory / "figures").exists()
    assert dict(mpl.rcParams) == before


def test_figures_that_apply_are_listed(run):
    """All figures of a packing are drawn."""
    assert {"energies", "peak_force_principal"} <= set(run.figures)
    assert not {"bars", "force_map", "transmission"} & set(run.figures)
    assert all(
        run.figure(name) is not None for name in run.figures if not name.startswith("packing_3d")
    )
    pyplot.close("all")


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run: run["peak_force"], "has no value peak_force; did you mean peak_force_N"),
        (lambda run: run.unit("x"), r"has no value x; keys\(\) lists them"),
        (
            lambda run: run.table("energies"),
            "has no table energies; did you mean energy[?] it has spheres",
        ),
        (
            lambda run: run.table("probes"),
            "has no table probes; it has spheres, contacts, wall_contacts, energy",
        ),
        (
            lambda run: run.figure("energy"),
            "has no figure energy; did you mean energies.*, energies, ",
        ),
        (lambda run: run.figure("bars"), "figure bars does not apply to this run"),
        (lambda run: run.chain, "has no history of a chain; .*output.history"),
    ],
)
def test_what_a_run_lacks(run, ask, message):
    with pytest.raises(MissingDataError, match=message) as caught:
        ask(run)
    assert isinstance(caught.value, KeyError) and "\n" not in str(caught.value)


def test_a_run_without_its_fields_still_has_values(directory, tmp_path):
    for name in ("summary.json", "case.toml"):
        (tmp_path / name).write_text((directory / name).read_text())
    run = load(tmp_path)
    assert run["n_spheres"] == 144
    with pytest.raises(
        MissingOutputError, match=r"result\.h5 is missing: make it with  granwave analyse"
    ):
        _ = run.spheres


def test_wrong_directories(tmp_path, directory):
    with pytest.raises(
        MissingOutputError, match=r"no such directory.*; expected the directory of a run"
    ):
        load(tmp_path / "none")
    with pytest.raises(MissingOutputError, match="it is empty"):
        load(tmp_path)
    with pytest.raises(MissingOutputError, match="is a file, expected the directory of a run"):
        load(directory / "result.h5")
    (tmp_path / "suite.json").write_text("{}")
    with pytest.raises(InputError, match="is a suite of scans"):
        load(tmp_path)
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "result.h5").write_bytes(b"")
    with pytest.raises(MissingOutputError, match=r"summary\.json is missing: make it with"):
        load(broken)
    (broken / "summary.json").write_text("{")
    with pytest.raises(OutputFormatError, match=r"summary\.json: is damaged: recreate it with"):
        load(broken)


def test_contact_forces_that_were_not_recorded(run):
    with pytest.raises(
        MissingDataError, match=r"run the case again with output\.contact_forces = true"
    ):
        _ = run.contact_forces


@pytest.fixture(scope="module")
def points(tmp_path_factory):
    points = grid(load__velocity=[1.0, 5.0, 20.0], material=["brass", "steel"])
    return write_scan(
        tmp_path_factory.mktemp("scan"), points, failed={3: "a <b>rank</b> died"}, missing=[6]
    )


@pytest.fixture
def three(points):
    return load(points)


def test_table(three, points):
    table = three.table
    data = read_scan(points)
    assert table.index.tolist() == [1, 2, 3, 4, 5, 6] and table.index.name == "point"
    for name in ("load.velocity", "peak_force_N"):
        np.testing.assert_array_equal(table[name], data[name])
        assert table.attrs["units"][name] == data.unit(name)
    assert set(table.attrs["units"]) == {"point", *table.columns}
    assert table.groupby("status").size().to_dict() == {"done": 4, "failed": 1, "missing": 1}
    assert table.loc[3, "reason"] == "a <b>rank</b> died" and table.loc[1, "material"] == "brass"
    assert three.means is None and three.varied == ("load.velocity", "material")


def test_points_are_runs(three):
    runs = list(three)
    assert len(runs) == len(three) == 4
    assert [run.labels["load.velocity"] for run in runs] == [1.0, 1.0, 5.0, 20.0]
    assert three[4]["peak_force_N"] == three.table.loc[4, "peak_force_N"] == runs[2]["peak_force_N"]
    assert three[4].labels == {"load.velocity": 5.0, "material": "steel"}
    for number, message in (
        (0, "has no point 0; it has 1 to 6"),
        (3, "point 3 is failed: a <b>"),
        (6, "is missing$"),
    ):
        with pytest.raises(MissingDataError, match=message):
            three[number]


def test_text_and_html(three, points):
    text = repr(three)
    assert text.startswith("scan synthetic: 6 points, 4 done") and "dissipated_fraction" in text
    assert (
        f"{three[1]['plastic_zone_volume_m3']:.5g}" in text and "NaN" not in text
    )  # small values have their digits
    assert text.endswith(f"results in {points}")
    page = three._repr_html_()
    assert "<th>dissipated_fraction</th>" in page and "failed" in page


def test_html_is_escaped(tmp_path):
    write_scan(tmp_path, [{"name": "<u>1"}, {"name": "<u>2"}])
    page = load(tmp_path)._repr_html_()
    assert "&lt;u&gt;1" in page and "<u>" not in page


def test_figures(three):
    assert "peak_force_vs_load_velocity" in three.figures
    axes = three.figure("peak_force_vs_load_velocity")
    assert isinstance(axes, Axes) and pyplot.gcf() is axes.figure and len(pyplot.get_fignums()) == 1
    pyplot.close("all")
    with pytest.raises(
        MissingDataError, match=r"has no figure x; figures are .*peak_force_vs_load_velocity"
    ):
        three.figure("x")


def test_means_over_seeds(tmp_path):
    write_scan(
        tmp_path,
        grid(load__velocity=[1.0, 5.0], packing__diameter_scatter=[1e-5], packing__seed=[1, 2, 3]),
    )
    scan = load(tmp_path)
    means = scan.means.set_index("load.velocity")
    found = scan.table.groupby("load.velocity")["peak_force_N"].mean()
    np.testing.assert_allclose(means["peak_force_N.mean"], found, rtol=1e-12)
    assert means["n"].tolist() == [3, 3] and scan.means.attrs["units"]["peak_force_N.ci95"] == "N"


def test_grid(tmp_path):
    write_scan(tmp_path, grid(load__velocity=[1.0, 5.0], material=["brass", "steel"]))
    assert dict(load(tmp_path).to_xarray().sizes) == {"load.velocity": 2, "material": 2}


def test_damaged_index(tmp_path):
    (tmp_path / "scan.json").write_text("[")
    with pytest.raises(OutputFormatError, match=r"scan\.json cannot be read"):
        load(tmp_path)
