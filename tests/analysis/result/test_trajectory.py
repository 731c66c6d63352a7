"""MDAnalysis reads our result file and our dumps."""

from __future__ import annotations

import pickle
import warnings

import MDAnalysis
import numpy as np
import pytest

from granwave.analysis import universe, write_result
from granwave.lammps_inputs import build_packing
from granwave.lammps_inputs.packing.assembly import assemble
from tests.helpers import synthetic


@pytest.fixture
def run(tmp_path):
    synthetic.write_run(tmp_path, synthetic.make_case())
    write_result(tmp_path)
    return tmp_path


def test_universe_of_a_directory_and_of_a_file(run):
    for source in (run, run / "result.h5"):
        u = universe(source)
        assert u.atoms.n_atoms == 144 and u.trajectory.n_frames == 4
        assert np.array_equal(u.atoms.ids, np.arange(1, 145))
        assert np.allclose(u.atoms.radii, 0.005)
        assert u.atoms.masses.sum() == pytest.approx(144 * 8500 * np.pi / 6 * 1e-6, rel=1e-12)


def test_frames_in_any_order(run):
    u = universe(run)
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


def test_selections_work_in_metres(run):
    u = universe(run)
    layer = u.select_atoms("prop z < 0.004")
    assert layer.n_atoms == 36
    assert u.select_atoms("around 0.0101 id 15").n_atoms == len(assemble(synthetic.make_case()).lattice.neighbours(15))


def test_universe_can_be_copied_and_pickled(run):
    u = universe(run)
    u.trajectory[2]
    for other in (u.copy(), pickle.loads(pickle.dumps(u))):
        assert np.array_equal(other.trajectory[2].data["displacement"], u.trajectory[2].data["displacement"])


def test_periodic_sides_give_dimensions(tmp_path):
    case = synthetic.make_case(size=(6, 6, 4), boundary={"sides": "periodic", "bottom": "fixed"})
    write_result(synthetic.write_run(tmp_path, case))
    assert universe(tmp_path).dimensions[:2] == pytest.approx(assemble(case).lattice.lengths, rel=1e-6)


def test_text_dump_opens_as_it_is(run):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        u = MDAnalysis.Universe(
            str(run / "dumps" / "spheres.dump"), format="LAMMPSDUMP", topology_format="LAMMPSDUMP",
            additional_columns=["ux", "peak_force"],
        )  # fmt: skip
    assert u.trajectory.n_frames == 4 and u.atoms.n_atoms == 144
    assert np.allclose(u.trajectory[3].data["ux"], 3e-9 * np.arange(1, 145), rtol=1e-14)
