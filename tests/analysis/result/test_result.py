"""Contents and units of result.h5, and consistency of sums over it."""

from __future__ import annotations

import pickle
import signal
from pathlib import Path

import h5py
import MDAnalysis
import numpy as np
import pytest

from granwave.analysis import (
    MissingOutputError,
    OutputFormatError,
    Result,
    summarise,
    universe,
    write_result,
)
from granwave.analysis.lammps_output.dumps import contacts_at_end
from granwave.analysis.measures.waves import energy_of_spheres
from granwave.analysis.result import contacts
from granwave.analysis.result.contacts import (
    LISTED_FROM,
    list_contacts,
    merge_dents,
    pair_laws,
    touching_pairs,
)
from granwave.analysis.result.hdf5_file import new_hdf5
from granwave.analysis.result.trajectory import GROUP
from granwave.lammps_inputs import Lattice, build_packing, pair_contact
from granwave.lammps_inputs.packing.assembly import assemble
from tests.helpers.made_up import synthetic


def dissipation_mismatch(result: Result) -> float:
    """Largest difference of a sphere's dissipation between the last snapshot and ``/contacts``,
    / input.
    """
    from_contacts = result["spheres/dissipated_energy"] - result["spheres/dissipated_energy_wall"]
    from_snapshot = result.frame(result.n_frames - 1, "dissipated_energy")
    return float(np.max(np.abs(from_snapshot - from_contacts))) / (result.energy_input or 1.0)


@pytest.fixture
def run(tmp_path):
    return synthetic.write_run(tmp_path, synthetic.make_case())


@pytest.fixture
def result(run):
    write_result(run)
    with Result(run) as result:
        yield result


def test_every_data_set_has_a_unit(result):
    found = {}
    result.file.visititems(lambda name, item: found.__setitem__(name, item))
    data_sets = {name for name, item in found.items() if isinstance(item, h5py.Dataset)}
    assert {name for name in data_sets if "unit" not in found[name].attrs} == set()
    for name, unit in {
        "contacts/peak_force": "N",
        "contacts/i": "1",
        "spheres/position": "m",
        "energy/input": "J",
        "walls/bottom/force": "N",
        "particles/spheres/velocity/value": "m s-1",
    }.items():
        assert result.unit(name) == unit


def test_layout(result):
    for group, names in {
        "spheres": ("id", "position", "peak_force", "dissipated_energy"),
        "contacts": ("i", "j", "peak_overlap", "peak_force", "dissipated_energy"),
        "energy": ("time", "kinetic", "elastic", "dissipated", "input"),
        "walls/bottom": ("time", "force"),
    }.items():
        assert set(names) <= set(result.names(group))
    assert np.array_equal(result["spheres/id"], np.arange(1, 145))
    assert result.case == synthetic.make_case()
    assert result.versions["lammps"] == "1"
    first = result["contacts/i"]
    second = result["contacts/j"]
    assert np.all(first < second)
    assert np.all(np.diff(first * 1000 + second) > 0)


def test_contacts_are_the_touching_pairs(result):
    pairs = np.stack([result["contacts/i"], result["contacts/j"]], axis=1)
    assert np.array_equal(pairs, build_packing(synthetic.make_case()).contacts)
    assert result["contacts/touching"].all()


def test_spheres_sum_to_the_contacts(result):
    lost = result["contacts/dissipated_energy"].sum()
    assert result["spheres/dissipated_energy"].sum() == pytest.approx(lost, rel=1e-13)
    assert result["energy/dissipated"][-1] == pytest.approx(lost, rel=1e-13)
    assert dissipation_mismatch(result) < 1e-14
    assert result["spheres/peak_force"].max() == result["contacts/peak_force"].max()


def test_dissipation_at_a_rigid_wall_belongs_to_the_sphere(run):
    row = np.array([[144, 0, 0, 1e-5, 50.0, 2e-4, 1e-5, 2e-5, 1.5e-5]])
    synthetic.write_custom(
        run / "dumps" / "wall_bottom.dump", synthetic.WALL_COLUMNS, row, synthetic.STEPS
    )
    write_result(run)
    with Result(run) as result:
        total = result["contacts/dissipated_energy"].sum() + 2e-4
        assert result["spheres/dissipated_energy"].sum() == pytest.approx(total, rel=1e-13)
        assert result["spheres/dissipated_energy_wall"][143] == 2e-4
        assert result["wall_contacts/wall"].tolist() == ["bottom"]
        assert result["spheres/peak_force"][143] < 50.0  # contacts of spheres only
        assert result["spheres/peak_force_with_walls"][143] == 50.0
        others = np.arange(len(result["spheres/id"])) != 143
        pairs = result["spheres/peak_force"]
        assert np.array_equal(result["spheres/peak_force_with_walls"][others], pairs[others])
        assert result.unit("spheres/peak_force_with_walls") == "N"


def test_the_largest_force_at_a_wall_is_told_from_that_between_spheres(run):
    """A floor contact carries more than any pair: the description of each value states which
    contacts it includes.
    """
    row = np.array([[144, 0, 0, 1e-5, 1e6, 2e-4, 1e-5, 2e-5, 1.5e-5]])
    synthetic.write_custom(
        run / "dumps" / "wall_bottom.dump", synthetic.WALL_COLUMNS, row, synthetic.STEPS
    )
    write_result(run)
    summary = summarise(run)
    with Result(run) as result:
        assert summary["peak_force_N"] == result["contacts/peak_force"].max() < 1e6
        assert summary["peak_force_with_walls_N"] == 1e6
        assert result["spheres/peak_force_with_walls"].max() == 1e6


def test_dents_of_one_pair_are_merged(run):
    """A forgotten and a new indentation: largest peak, sum of the energies, earliest times."""
    dents = next(contacts_at_end(run).frames()).values
    old = dents[0].copy()
    new = dents[0].copy()
    old[2:] = [0, 0, 3e-6, 40.0, 0, 1e-5, 1e-6, 2e-6, 1.5e-6, 0]
    new[2:] = [1e-6, 8.0, 2e-6, 20.0, 3e-6, 5e-6, 7e-6, 8e-6, 7.5e-6, 1]
    synthetic.write_local(
        run / "dumps" / "contacts.dump", np.concatenate([[new], dents[1:], [old]])
    )
    merged = merge_dents(*contacts_at_end(run).frames())
    assert (merged["i"][0], merged["j"][0], merged["n_dents"][0]) == (old[0], old[1], 2)
    expected = {"peak_overlap": 3e-6, "peak_force": 40.0, "dissipated_energy": 1.5e-5, "force": 8.0}
    expected |= {
        "overlap": 1e-6,
        "elastic_energy": 3e-6,
        "time_first": 1e-6,
        "time_peak": 2e-6,
        "time_yield": 1.5e-6,
    }
    for name, value in expected.items():
        assert merged[name][0] == pytest.approx(value, rel=1e-14), name
    assert len(merged["i"]) == len(dents)


def test_pairs_that_met_later_are_listed_from_a_threshold(run):
    """Spheres 1 and 144 never touched at the start."""
    dents = next(contacts_at_end(run).frames()).values
    for factor, listed in ((0.5, False), (2.0, True)):
        met = dents[0].copy()
        met[:2] = (1, 144)
        met[4] = factor * LISTED_FROM * 1e-6
        synthetic.write_local(run / "dumps" / "contacts.dump", np.concatenate([dents, [met]]))
        table = list_contacts(
            merge_dents(*contacts_at_end(run).frames()), dents[:, :2].astype(int), 1e-6
        )
        assert len(table["i"]) == len(dents) + listed
        assert np.count_nonzero(table["touching"]) == len(dents)


def test_touching_pairs_that_were_never_loaded_are_listed(run):
    dents = next(contacts_at_end(run).frames()).values
    synthetic.write_local(run / "dumps" / "contacts.dump", dents[5:])
    write_result(run)
    with Result(run) as result:
        assert len(result["contacts/i"]) == len(dents)
        assert result["contacts/peak_force"][0] == 0 and np.isnan(result["contacts/time_first"][0])


def test_trajectory_is_h5md(result):
    file = result.file
    assert file["h5md"].attrs["version"].tolist() == [1, 1]
    assert file["h5md/creator"].attrs["name"] == "granwave" and "name" in file["h5md/author"].attrs
    spheres = file["particles/spheres"]
    assert spheres["box"].attrs["dimension"] == 3
    assert list(spheres["box"].attrs["boundary"]) == ["none"] * 3
    for name in ("position", "displacement", "velocity", "contact_force", "elastic_energy"):
        assert (
            len(spheres[name]["value"])
            == len(spheres[name]["step"])
            == len(spheres[name]["time"])
            == 4
        )
    assert np.allclose(
        spheres["position/time"], np.array([0, 250, 500, 1000]) * synthetic.TIMESTEP, rtol=1e-14
    )


def test_runs_from_before_elastic_energy_was_recorded(run):
    path = run / "dumps" / "spheres.dump"
    lines = path.read_text().splitlines()
    shorter = [line.rsplit(maxsplit=1)[0] if len(line.split()) >= 17 else line for line in lines]
    path.write_text("\n".join(shorter) + "\n")
    with Result(write_result(run)) as result:
        assert np.isnan(result.frame(1, "elastic_energy")).all()
        assert np.isfinite(energy_of_spheres(result, 1)).all()
    with h5py.File(run / "result.h5", "a") as file:
        del file["particles/spheres/elastic_energy"]
    with Result(run) as result:
        assert "elastic_energy" not in result.quantities and "velocity" in result.quantities
        assert np.isfinite(energy_of_spheres(result, 1)).all()


def test_displacements_keep_every_bit(result):
    ids = np.arange(1, 145)
    for m in range(4):
        assert np.array_equal(result.frame(m, "displacement")[:, 0], m * ids * 1e-9)
    assert np.array_equal(result.frame(0, "position"), result["spheres/position"])


def test_failure_leaves_the_old_file(run):
    path = write_result(run)
    before = path.read_bytes()
    (run / "dumps" / "contacts.dump").unlink()
    with pytest.raises(MissingOutputError, match=r"contacts\.dump is missing.*--resume"):
        write_result(run)
    assert path.read_bytes() == before
    assert not list(run.glob(".result*"))


def test_frames_of_another_run_are_refused(run, tmp_path_factory):
    other = synthetic.write_run(
        tmp_path_factory.mktemp("other"), synthetic.make_case(size=(5, 5, 4))
    )
    (other / "dumps" / "spheres.dump").replace(run / "dumps" / "spheres.dump")
    with pytest.raises(OutputFormatError, match="100 spheres"):
        write_result(run)


def test_reader_refuses_other_files(tmp_path):
    with pytest.raises(MissingOutputError, match="is no run: it is empty"):
        Result(tmp_path)
    (tmp_path / "result.h5").write_text("no")
    with pytest.raises(OutputFormatError):
        Result(tmp_path)
    with h5py.File(tmp_path / "other.h5", "w"):
        pass
    with pytest.raises(OutputFormatError, match="expected the result"):
        Result(tmp_path / "other.h5")


# ----------------------------------------------------------------------------- packings as they are built

MISSING = (5, 70, 144)


def test_rows_are_found_where_spheres_are_missing(tmp_path):
    """IDs are those of the lattice; values of spheres do not depend on missing ones."""
    case = synthetic.make_case(packing={"vacancies": MISSING})
    with Result(write_result(synthetic.write_run(tmp_path, case))) as result:
        ids = result["spheres/id"]
        assert ids.tolist() == [one for one in range(1, 145) if one not in MISSING]
        assert np.array_equal(ids[result.rows(ids)], ids)
        with pytest.raises(KeyError, match="no sphere 70"):
            result.rows([4, 70])
        assert np.array_equal(result[f"{GROUP}/id"], ids)
        pairs = np.stack([result["contacts/i"], result["contacts/j"]], axis=1)
        assert (
            np.array_equal(pairs, build_packing(case).contacts)
            and not np.isin(pairs, MISSING).any()
        )
        forces = np.zeros(145)
        np.maximum.at(forces, pairs, result["contacts/peak_force"][:, None])
        assert np.array_equal(result["spheres/peak_force"], forces[ids])
        assert np.array_equal(
            result["spheres/coordination"], np.bincount(pairs.ravel(), minlength=145)[ids]
        )
        lost = result["contacts/dissipated_energy"].sum()
        assert result["spheres/dissipated_energy"].sum() == pytest.approx(lost, rel=1e-13)
        assert dissipation_mismatch(result) < 1e-14
        assert np.array_equal(
            result.origin, assemble(case).lattice.positions(1, 144)[result.struck[0] - 1]
        )


def test_friction_is_part_of_the_dissipation_and_stands_apart(tmp_path):
    case = synthetic.make_case(contact={"law": "elastoplastic", "friction": 0.2})
    run = synthetic.write_run(tmp_path, case)
    row = np.array([[143, 0, 0, 1e-5, 50.0, 2e-4, 1e-5, 2e-5, 1.5e-5, 3.0, 1e-4]])
    columns = synthetic.WALL_COLUMNS + " tangential_force friction"
    synthetic.write_custom(run / "dumps" / "wall_bottom.dump", columns, row, synthetic.STEPS)
    with Result(write_result(run)) as result:
        rubbed = result["contacts/friction_energy"]
        lost = result["contacts/dissipated_energy"]
        assert np.allclose(rubbed, synthetic.RUBBED * (lost - rubbed), rtol=1e-14)
        assert result["wall_contacts/dissipated_energy"][0] == pytest.approx(3e-4)
        assert result["spheres/dissipated_energy_wall"][142] == pytest.approx(3e-4)
        assert result["spheres/friction_energy"].sum() == pytest.approx(
            rubbed.sum() + 1e-4, rel=1e-13
        )
        assert result["spheres/dissipated_energy"].sum() == pytest.approx(
            lost.sum() + 3e-4, rel=1e-13
        )
        assert dissipation_mismatch(result) < 1e-14
        assert "friction_energy" in result.quantities
        expected = result["spheres/friction_energy"] - np.where(
            result["spheres/id"] == 143, 1e-4, 0
        )
        assert np.allclose(result.frame(3, "friction_energy"), expected, rtol=1e-13)
        assert result.unit("spheres/friction_energy") == result.unit("energy/friction") == "J"


def test_a_run_without_friction_has_none(result):
    assert not result["energy/friction"].any() and not result["contacts/friction_energy"].any()
    assert "friction_energy" not in result.quantities


def test_only_dents_that_grew_have_yielded(tmp_path):
    """Initial indentations near the impact have become deeper, the others are unchanged."""
    before = 8e-6
    case = synthetic.make_case(contact={"law": "elastoplastic", "initial_overlap": before})
    with Result(write_result(synthetic.write_run(tmp_path, case))) as result:
        grown = result["contacts/peak_overlap"] > before
        assert 0 < grown.sum() < len(grown)
        assert np.array_equal(result["contacts/yielded"], grown)
        assert np.all(result["contacts/initial_overlap"] == before)
        assert result["contacts/peak_overlap"].min() == before > result.law.yield_overlap
        assert result["contacts/dissipated_energy"][~grown].max() == 0


def test_radii_of_their_own_change_the_laws():
    """Since alpha_y is proportional to R*, every pair has the alpha_y of its own law."""
    replaced = [{"index": [40, 41], "diameter": 0.008, "material": "steel"}]
    case = synthetic.make_case(packing={"diameter_scatter": 4e-6}, replace=replaced)
    assembly = assemble(case)
    pairs = np.concatenate(list(assemble(case).lattice.pairs()))
    types = np.array(
        [[assembly.type_of(assembly.material_of(one)) for one in pair] for pair in pairs.tolist()]
    )
    radii = np.array([[assembly.diameter_of(one) / 2 for one in pair] for pair in pairs.tolist()])
    found = pair_laws(assemble(case), types, radii)
    laws = [pair_contact(case, *pair) for pair in pairs.tolist()]
    assert len({law.yield_overlap for law in laws}) > 100
    assert np.allclose(
        found["effective_radius"], [law.effective_radius for law in laws], rtol=1e-14
    )
    assert np.allclose(found["yield_overlap"], [law.yield_overlap for law in laws], rtol=1e-13)
    assert np.allclose(found["share"], [law.share_of_first for law in laws])


@pytest.fixture(params=["by a tree", "all pairs"])
def search(request, monkeypatch):
    """Both search methods, for any number of spheres."""
    monkeypatch.setattr(contacts, "_FEW", 0 if request.param == "by a tree" else 1000)


@pytest.mark.usefixtures("search")
@pytest.mark.parametrize("kind", ["fcc", "hcp", "bcc", "sc"])
@pytest.mark.parametrize("sides", ["free", "periodic"])
def test_search_finds_the_contacts_of_a_lattice(kind, sides):
    lattice = Lattice(kind, (6, 6, 5), 0.01, sides == "periodic")
    expected = np.concatenate(list(lattice.pairs()))
    expected = expected[np.lexsort((expected[:, 1], expected[:, 0]))]
    periods = (*lattice.lengths, 0.0) if lattice.periodic else (0.0, 0.0, 0.0)
    ids = np.arange(1, lattice.n_spheres + 1)
    radii = np.full(len(ids), 0.005)
    found = touching_pairs(ids, lattice.positions(1, len(ids)) - 0.003, radii, 1e-8, periods)
    assert np.array_equal(found, expected)


@pytest.mark.usefixtures("search")
def test_search_finds_what_touches_a_large_sphere():
    """All pairs in contact, by comparing all spheres with all others."""
    random = np.random.default_rng(5)
    radii = np.where(np.arange(300) < 5, 0.03, random.uniform(0.004, 0.006, 300))
    places = random.uniform(0, 0.15, (300, 3))
    ids = np.arange(1, 301) * 3
    gaps = np.linalg.norm(places[:, None] - places[None], axis=-1) - radii[:, None] - radii
    i, j = np.nonzero(np.triu(gaps <= 1e-4, 1))
    assert len(i) > 50
    assert np.array_equal(
        touching_pairs(ids, places, radii, 1e-4), np.stack([ids[i], ids[j]], axis=1)
    )


def test_ctrl_c_waits_for_the_file_and_keeps_the_old_one(tmp_path: Path) -> None:
    """An exception that leaves a write function within HDF5 ends the program by a signal."""
    path = tmp_path / "x.h5"
    written = False
    with new_hdf5(path) as file:
        file["a"] = 1
    with pytest.raises(KeyboardInterrupt), new_hdf5(path) as file:
        signal.raise_signal(signal.SIGINT)
        file["b"] = 2
        written = True
    assert written and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    with h5py.File(path) as file:
        assert list(file) == ["a"]
    assert [one.name for one in tmp_path.iterdir()] == ["x.h5"]


@pytest.fixture
def written(tmp_path):
    synthetic.write_run(tmp_path, synthetic.make_case())
    write_result(tmp_path)
    return tmp_path


def test_universe_of_a_directory_and_of_a_file(written):
    for source in (written, written / "result.h5"):
        u = universe(source)
        assert u.atoms.n_atoms == 144 and u.trajectory.n_frames == 4
        assert np.array_equal(u.atoms.ids, np.arange(1, 145))
        assert np.allclose(u.atoms.radii, 0.005)
        assert u.atoms.masses.sum() == pytest.approx(144 * 8500 * np.pi / 6 * 1e-6, rel=1e-12)


def test_frames_in_any_order(written):
    u = universe(written)
    ids = np.arange(1, 145)
    start = build_packing(synthetic.make_case()).positions
    for m in (2, 0, 3, 1):
        ts = u.trajectory[m]
        assert (ts.frame, ts.time) == (m, pytest.approx([0, 2.5e-5, 5e-5, 1e-4][m]))
        assert ts.data["displacement"].dtype == np.float64
        assert np.array_equal(ts.data["displacement"][:, 0], m * ids * 1e-9)
        assert np.allclose(u.atoms.positions, start, atol=1e-6)  # metres, single precision
        assert np.allclose(u.atoms.velocities[:, 0], m * ids * 1e-3, rtol=1e-6)
    assert [ts.frame for ts in u.trajectory] == [0, 1, 2, 3]
    assert [ts.frame for ts in u.trajectory[1::2]] == [1, 3]


def test_selections_work_in_metres(written):
    u = universe(written)
    layer = u.select_atoms("prop z < 0.004")
    assert layer.n_atoms == 36
    assert u.select_atoms("around 0.0101 id 15").n_atoms == len(
        assemble(synthetic.make_case()).lattice.neighbours(15)
    )


def test_universe_can_be_copied_and_pickled(written):
    u = universe(written)
    u.trajectory[2]
    for other in (u.copy(), pickle.loads(pickle.dumps(u))):
        assert np.array_equal(
            other.trajectory[2].data["displacement"], u.trajectory[2].data["displacement"]
        )


def test_periodic_sides_give_dimensions(tmp_path):
    case = synthetic.make_case(size=(6, 6, 4), boundary={"sides": "periodic", "bottom": "fixed"})
    write_result(synthetic.write_run(tmp_path, case))
    assert universe(tmp_path).dimensions[:2] == pytest.approx(
        assemble(case).lattice.lengths, rel=1e-6
    )


@pytest.mark.filterwarnings("ignore")
def test_text_dump_opens_as_it_is(written):
    u = MDAnalysis.Universe(
        str(written / "dumps" / "spheres.dump"), format="LAMMPSDUMP", topology_format="LAMMPSDUMP",
        additional_columns=["ux", "peak_force"],
    )  # fmt: skip
    assert u.trajectory.n_frames == 4 and u.atoms.n_atoms == 144
    assert np.allclose(u.trajectory[3].data["ux"], 3e-9 * np.arange(1, 145), rtol=1e-14)
