"""Readers of text and binary dumps."""

from __future__ import annotations

import re
import shutil
import struct
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from granwave._number_reader import read_numbers
from granwave.analysis import OutputFormatError, Result, analyse
from granwave.analysis.lammps_output.dumps import read_data, read_frames, read_wall_contacts
from granwave.analysis.lammps_output.time_series import read_energy
from granwave.lammps_inputs import build_packing
from granwave.workflows import run_case
from granwave.workflows.run import driver
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.run_files import without_checksums


@pytest.fixture
def run(tmp_path):
    return synthetic.write_run(tmp_path, synthetic.make_case())


def test_frames_are_sorted_and_exact(run):
    frames = list(read_frames(run))
    assert [frame.step for frame in frames] == [0, 250, 500, 1000]
    for m, frame in enumerate(frames):
        ids = np.arange(1, 145)
        assert np.array_equal(frame["id"], ids)
        assert np.array_equal(frame["ux"], m * ids * 1e-9)  # 17 digits: exact to the last bit
        assert frame.values.dtype == np.float64


def test_positions_of_the_data_file_are_those_of_the_packing(run):
    assert np.array_equal(
        next(read_data(run)).vector("x", "y", "z"), build_packing(synthetic.make_case()).positions
    )


@pytest.mark.parametrize("kept", [0.9, 0.999])
def test_frame_cut_short_is_dropped_with_a_warning(run, caplog, kept):
    path = run / "dumps" / "spheres.dump"
    text = path.read_text()
    last = text.rindex("ITEM: TIMESTEP")
    path.write_text(text[: last + int(kept * (len(text) - last))])
    assert [frame.step for frame in read_frames(run)] == [0, 250, 500]
    assert "snapshot 3 is truncated" in caplog.text


@pytest.mark.parametrize(
    "end", ["ITEM: TIMESTEP", "ITEM: TIMESTEP\n10", "ITEM: TIMESTEP\n1000\nITEM: NUM"]
)
def test_header_cut_short_is_dropped(run, caplog, end):
    path = run / "dumps" / "spheres.dump"
    path.write_text(path.read_text() + end)
    assert len(list(read_frames(run))) == 4
    assert "truncated" in caplog.text


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


def test_missing_column_is_named(run):
    path = run / "dumps" / "spheres.dump"
    path.write_text(path.read_text().replace(" uy ", " q "))
    with pytest.raises(OutputFormatError, match=r"spheres\.dump.*has no columns uy"):
        list(read_frames(run))


def test_damage_in_the_middle_is_an_error(run):
    path = run / "dumps" / "spheres.dump"
    lines = path.read_text().splitlines(keepends=True)
    lines[20] = "1 2 oops\n"
    path.write_text("".join(lines))
    with pytest.raises(
        OutputFormatError,
        match=r"spheres\.dump: line 21 \(snapshot 0\): found 3 values, expected 17",
    ):
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
    """Reading time for a fiftieth of 155 520 spheres in 20 snapshots, which take about 10 s, with
    all digits in use.
    """
    numbers = np.random.default_rng(1).standard_normal((62_208, 14)) * 1e-6
    n = len(numbers)
    rows = np.column_stack([np.arange(1, n + 1), np.ones(n), np.full(n, 0.005), numbers])
    (tmp_path / "dumps").mkdir()
    synthetic.write_custom(tmp_path / "dumps" / "spheres.dump", synthetic.FRAME_COLUMNS, rows, 0)
    start = time.process_time()
    (frame,) = read_frames(tmp_path)
    assert time.process_time() - start < 2.0  # 0.25 s on an idle core
    assert np.array_equal(frame.values, rows)


@pytest.mark.parametrize("form", ["%.17g", "%.9g", "%.10e", "%d"])
def test_numbers_in_text_are_those_of_python(form):
    random = np.random.default_rng(7)
    values = random.standard_normal(5000) * 10.0 ** random.integers(-300, 12, 5000)
    text = " \n".join(form % value for value in values)
    assert read_numbers(text).tolist() == [float(word) for word in text.split()]


@pytest.mark.parametrize(
    "text", ["1 2 x", "1 nan", "1 inf", "1 2e400", "1-2", "0x10", "1,2", "1 2."[:-1] + "e"]
)
def test_text_that_is_not_all_numbers_is_not_read(text):
    assert read_numbers(text) is None


def test_empty_text_has_no_numbers():
    assert read_numbers(" \n").tolist() == [] and read_numbers("+1 -2\t3\r\n").tolist() == [
        1,
        -2,
        3,
    ]


MAGIC = b"DUMPCUSTOM"
# places in the header: 8 + 10 bytes of the name, byte order, revision
STEP = 26
ROWS = 34
BOX = 70
N_COLUMNS = 118
SMALL = {"run": {"end_time": 8e-5, "frames": 3}, "boundary": {"bottom": "wall"}}


def case_with(form: str):
    return synthetic.make_case(
        "fcc", (4, 4, 2), output={"dump_format": form}, contact={"friction": 0.3}, **SMALL
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run with binary snapshots, and the same with text."""
    places = {}
    for form in ("binary", "text"):
        places[form] = tmp_path_factory.mktemp(form)
        run_case(case_with(form), places[form], figures=False)
    return places


@pytest.fixture
def binary(runs, tmp_path):
    shutil.copytree(runs["binary"], tmp_path / "run")
    return without_checksums(tmp_path / "run")


def test_one_dump_of_snapshots_in_the_form_asked_for(runs):
    assert (runs["binary"] / "dumps" / "spheres.bin").exists() and (
        runs["text"] / "dumps" / "spheres.dump"
    ).exists()
    assert not (runs["binary"] / "dumps" / "spheres.dump").exists()
    assert not (runs["text"] / "dumps" / "spheres.bin").exists()


def test_values_are_those_of_text(runs):
    one, other = (list(read_frames(runs[form])) for form in ("binary", "text"))
    assert [frame.step for frame in one] == [frame.step for frame in other] and len(one) == 3
    for binary, text in zip(one, other, strict=True):
        assert binary.columns == text.columns and "elastic_tangential" in binary.columns
        assert np.array_equal(binary.box, text.box)
        assert np.array_equal(binary["id"], text["id"]) and np.array_equal(binary["ux"], text["ux"])
        assert np.allclose(
            binary.values, text.values, rtol=1e-8, atol=0
        )  # text has 9 digits of the others


def test_result_has_all_digits(runs):
    with Result(runs["binary"]) as result:
        (frame,) = list(read_frames(runs["binary"]))[-1:]
        assert np.array_equal(result.frame(2, "velocity"), frame.vector("vx", "vy", "vz"))
        assert np.array_equal(result.frame(2, "peak_force"), frame["peak_force"])


@pytest.mark.parametrize("kept", [0.4, 0.9, 0.999])
def test_snapshot_cut_short(binary, caplog, kept):
    path = binary / "dumps" / "spheres.bin"
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: int((2 + kept) / 3 * size)])
    assert len(list(read_frames(binary))) == 2
    assert "spheres.bin: snapshot 2 is truncated" in caplog.text
    with pytest.raises(
        OutputFormatError,
        match=r"byte \d+ \(snapshot 2\): snapshot 2 is truncated; the file is truncated",
    ):
        analyse(binary, figures=False)


@pytest.mark.parametrize("n_bytes", [1, 7, 8, 17, 30, 100, 140, 300])
def test_every_place_of_a_header_cut(binary, n_bytes):
    path = binary / "dumps" / "spheres.bin"
    path.write_bytes(path.read_bytes() + path.read_bytes()[:n_bytes])
    assert len(list(read_frames(binary))) == 3


def test_snapshot_written_again_counts_once(binary):
    path = binary / "dumps" / "spheres.bin"
    content = path.read_bytes()
    path.write_bytes(content + content[content.rindex(MAGIC) - 8 :])
    assert len(list(read_frames(binary))) == 3


def put(place: int, form: str, *values: float) -> Callable[[bytearray], object]:
    return lambda content: struct.pack_into(f"={form}", content, place, *values)


def value(column: str, put_in: float) -> Callable[[bytearray], object]:
    """Change a value in the last row."""
    names = [*synthetic.FRAME_COLUMNS.split(), "elastic_tangential", "friction"]
    return lambda content: struct.pack_into(
        "=d", content, len(content) - 8 * (len(names) - names.index(column)), put_in
    )


DAMAGES: dict[str, tuple[Callable[[bytearray], object], str]] = {
    "name": (put(8, "3s", b"XYZ"), r"expected the header of a binary dump of LAMMPS"),
    "byte order": (
        put(18, "i", 1 << 24),
        r"found byte order 16777216 and revision 2, expected 1 and 2",
    ),
    "revision": (put(22, "i", 1), r"found byte order 1 and revision 1"),
    "step": (put(STEP, "q", -5), r"found step -5"),
    "rows": (put(ROWS, "q", -1), r"-1 rows"),
    "more rows": (put(ROWS, "q", 1 << 60), r"is truncated"),
    "fewer rows": (put(ROWS, "q", 1), r"found more than 1 rows"),
    "box": (put(BOX, "d", float("nan")), r"the box is not finite"),
    "columns": (put(N_COLUMNS, "i", 3), r"3 columns \(id type"),
    "nan": (
        value("force", float("nan")),
        r"row \d+: found nan for force, expected a finite number",
    ),
    "inf": (value("ux", float("-inf")), r"row \d+: found -inf for ux, expected a finite number"),
    "half an id": (value("id", 1.5), r"row \d+: found 1.5 for id, expected a whole number"),
    "unknown id": (value("id", 99999), r"that are not the"),
    "empty": (lambda content: content.clear(), r"holds no complete snapshot"),
    "other content": (
        lambda content: content.__setitem__(slice(None), b"hello world\n" * 9),
        r"expected the header",
    ),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage(binary, name):
    damage, message = DAMAGES[name]
    path: Path = binary / "dumps" / "spheres.bin"
    content = bytearray(path.read_bytes())
    damage(content)
    path.write_bytes(content)
    with pytest.raises(OutputFormatError) as error:
        analyse(binary, figures=False)
    assert "\n" not in str(error.value) and "force=True" in str(error.value)
    assert re.search(rf"{re.escape(str(path))}.*{message}", str(error.value)), error.value


def test_column_that_is_missing(binary):
    path = binary / "dumps" / "spheres.bin"
    path.write_bytes(path.read_bytes().replace(b" uy ", b" uq "))
    with pytest.raises(OutputFormatError, match=r"spheres\.bin: snapshot 0 has no columns uy"):
        list(read_frames(binary))


@pytest.mark.parametrize("stops", [(1,), (0, 2)])
def test_resumed_run_has_all_snapshots(runs, tmp_path, monkeypatch, stops):
    """LAMMPS does not append to binary dumps: each part of a run that was stopped writes its own."""
    many = synthetic.make_case(
        "fcc", (4, 4, 2), output={"dump_format": "binary"}, boundary={"bottom": "wall"},
        run={"end_time": 8e-5, "frames": 40, "timestep": 3e-8},
    )  # fmt: skip
    run_case(many, tmp_path / "whole", figures=False)
    monkeypatch.setattr(driver, "_PIECE", 1e-3)
    for stop in stops:
        looks = iter(range(1000))
        with monkeypatch.context() as patched:
            patched.setattr(
                driver.StopRequest, "wanted", lambda _, looks=looks, stop=stop: next(looks) == stop
            )
            outcome = run_case(many, tmp_path / "cut", figures=False, resume=True)
        assert outcome.state == "interrupted"
    outcome = run_case(many, tmp_path / "cut", figures=False, resume=True)
    assert outcome.state == "finished"
    assert len(list((tmp_path / "cut" / "dumps").glob("spheres*.bin"))) == 1 + len(stops)
    whole, cut = (list(read_frames(tmp_path / name)) for name in ("whole", "cut"))
    assert [frame.step for frame in cut] == [frame.step for frame in whole] and len(whole) == 40
    assert all(
        np.array_equal(one.values, other.values) for one, other in zip(whole, cut, strict=True)
    )
    run_case(many, tmp_path / "cut", figures=False, force=True)
    assert len(list((tmp_path / "cut" / "dumps").glob("spheres*.bin"))) == 1
