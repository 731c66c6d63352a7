"""Readers of dumps, tables and data files: exact values, and clear error messages."""

from __future__ import annotations

import time

import numpy as np
import pytest

from granwave._number_reader import read_numbers
from granwave.analysis import MissingOutputError, OutputFormatError
from granwave.analysis.lammps_output.dumps import read_contacts, read_data, read_frames, read_wall_contacts
from granwave.analysis.lammps_output.time_series import read_energy, read_probes, read_walls
from granwave.lammps_inputs import build_packing
from tests.helpers import synthetic


@pytest.fixture
def run(tmp_path):
    return synthetic.write_run(tmp_path, synthetic.make_case())


def test_frames_are_sorted_and_exact(run):
    frames = list(read_frames(run))
    assert [frame.step for frame in frames] == [0, 250, 500, 1000]
    for m, frame in enumerate(frames):
        ids = np.arange(1, 145)
        assert np.array_equal(frame["id"], ids)
        assert np.array_equal(frame.displacement[:, 0], m * ids * 1e-9)  # 17 digits: exact to the last bit
        assert frame.values.dtype == np.float64


def test_positions_of_the_data_file_are_those_of_the_packing(run):
    assert np.array_equal(read_data(run).vector("x", "y", "z"), build_packing(synthetic.make_case()).positions)


@pytest.mark.parametrize("kept", [0.9, 0.999])
def test_frame_cut_short_is_dropped_with_a_warning(run, caplog, kept):
    path = run / "dumps" / "spheres.dump"
    text = path.read_text()
    last = text.rindex("ITEM: TIMESTEP")
    path.write_text(text[: last + int(kept * (len(text) - last))])
    assert [frame.step for frame in read_frames(run)] == [0, 250, 500]
    assert "snapshot 3 is cut short" in caplog.text


@pytest.mark.parametrize("end", ["ITEM: TIMESTEP", "ITEM: TIMESTEP\n10", "ITEM: TIMESTEP\n1000\nITEM: NUM"])
def test_header_cut_short_is_dropped(run, caplog, end):
    path = run / "dumps" / "spheres.dump"
    path.write_text(path.read_text() + end)
    assert len(list(read_frames(run))) == 4
    assert "cut short" in caplog.text


def test_number_cut_short_is_not_taken_for_another(run):
    """The last number of the last row loses its last digits and its newline."""
    path = run / "dumps" / "spheres.dump"
    path.write_text(path.read_text().rstrip()[:-3])
    assert len(list(read_frames(run))) == 3


def test_snapshot_written_again_by_a_resumed_run_counts_once(run):
    path = run / "dumps" / "spheres.dump"
    text = path.read_text()
    path.write_text(text + text[text.rindex("ITEM: TIMESTEP") :])
    assert [frame.step for frame in read_frames(run)] == [0, 250, 500, 1000]


def test_missing_files_are_named(tmp_path, run):
    for read, name in (
        (read_energy, "energy.txt"),
        (read_contacts, "contacts.dump"),
        (read_frames, "spheres.dump"),
    ):
        (run / "dumps" / name).unlink()
        with pytest.raises(MissingOutputError, match=name):
            list(read(run))
    (run / "dumps" / "walls.txt").unlink()
    assert read_walls(run) == {} and read_probes(run) == {}


def test_missing_column_is_named(run):
    path = run / "dumps" / "spheres.dump"
    path.write_text(path.read_text().replace(" uy ", " q "))
    with pytest.raises(OutputFormatError, match=r"spheres\.dump.*lacks the columns uy"):
        list(read_frames(run))


def test_damage_in_the_middle_is_an_error(run):
    path = run / "dumps" / "spheres.dump"
    lines = path.read_text().splitlines(keepends=True)
    lines[20] = "1 2 oops\n"
    path.write_text("".join(lines))
    with pytest.raises(OutputFormatError, match=r"spheres\.dump: line 21 \(snapshot 0\): found 3 values, expected 17"):
        list(read_frames(run))


def test_ledger_of_a_killed_and_resumed_run(run):
    path = run / "dumps" / "energy.txt"
    whole = read_energy(run)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines + lines[-20:] + [lines[-1][:40]]))
    again = read_energy(run)
    assert all(np.array_equal(whole[name], again[name]) for name in whole)


def test_wall_without_contacts(run):
    assert len(read_wall_contacts(run)["bottom"]) == 0


def test_reading_is_fast_enough(tmp_path):
    """Reading time for a fiftieth of 155 520 spheres in 20 snapshots, which take about 10 s, with all digits in use."""
    numbers = np.random.default_rng(1).standard_normal((62_208, 14)) * 1e-6
    n = len(numbers)
    rows = np.column_stack([np.arange(1, n + 1), np.ones(n), np.full(n, 0.005), numbers])
    (tmp_path / "dumps").mkdir()
    synthetic.write_custom(tmp_path / "dumps" / "spheres.dump", synthetic.FRAME_COLUMNS, rows, 0)
    start = time.perf_counter()
    (frame,) = read_frames(tmp_path)
    assert time.perf_counter() - start < 2.0  # 0.25 s on an idle core
    assert np.array_equal(frame.values, rows)


@pytest.mark.parametrize("form", ["%.17g", "%.9g", "%.10e", "%d"])
def test_numbers_in_text_are_those_of_python(form):
    random = np.random.default_rng(7)
    values = random.standard_normal(5000) * 10.0 ** random.integers(-300, 12, 5000)
    text = " \n".join(form % value for value in values)
    assert read_numbers(text).tolist() == [float(word) for word in text.split()]


@pytest.mark.parametrize("text", ["1 2 x", "1 nan", "1 inf", "1 2e400", "1-2", "0x10", "1,2", "1 2."[:-1] + "e"])
def test_text_that_is_not_all_numbers_is_not_read(text):
    assert read_numbers(text) is None


def test_empty_text_has_no_numbers():
    assert read_numbers(" \n").tolist() == [] and read_numbers("+1 -2\t3\r\n").tolist() == [1, -2, 3]
