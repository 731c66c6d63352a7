"""Reader of binary snapshots: the same values as text, and errors that name file, place and remedy."""

from __future__ import annotations

import re
import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from granwave.analysis import OutputFormatError, Result, analyse
from granwave.analysis.lammps_output.dumps import read_frames
from granwave.workflows import run_case
from granwave.workflows.run import driver
from tests.helpers import synthetic
from tests.helpers.checksums import without_checksums

MAGIC = b"DUMPCUSTOM"
STEP, ROWS, BOX, N_COLUMNS = 26, 34, 70, 118  # places in the header: 8 + 10 bytes of the name, byte order, revision
SMALL = {"run": {"end_time": 8e-5, "frames": 3}, "boundary": {"bottom": "wall"}}


def case_with(form: str):
    return synthetic.make_case("fcc", (4, 4, 2), output={"dump_format": form}, contact={"friction": 0.3}, **SMALL)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """A run with binary snapshots, and the same with text."""
    places = {}
    for form in ("binary", "text"):
        places[form] = tmp_path_factory.mktemp(form)
        run_case(case_with(form), places[form], figures=False)
    return places


@pytest.fixture
def run(runs, tmp_path):
    shutil.copytree(runs["binary"], tmp_path / "run")
    return without_checksums(tmp_path / "run")


def test_one_dump_of_snapshots_in_the_form_asked_for(runs):
    assert (runs["binary"] / "dumps" / "spheres.bin").exists() and (runs["text"] / "dumps" / "spheres.dump").exists()
    assert not (runs["binary"] / "dumps" / "spheres.dump").exists()
    assert not (runs["text"] / "dumps" / "spheres.bin").exists()


def test_values_are_those_of_text(runs):
    one, other = (list(read_frames(runs[form])) for form in ("binary", "text"))
    assert [frame.step for frame in one] == [frame.step for frame in other] and len(one) == 3
    for binary, text in zip(one, other, strict=True):
        assert binary.columns == text.columns and "elastic_tangential" in binary.columns
        assert np.array_equal(binary.box, text.box)
        assert np.array_equal(binary["id"], text["id"]) and np.array_equal(binary.displacement, text.displacement)
        assert np.allclose(binary.values, text.values, rtol=1e-8, atol=0)  # text has 9 digits of the others


def test_result_has_all_digits(runs):
    with Result(runs["binary"]) as result:
        (frame,) = list(read_frames(runs["binary"]))[-1:]
        assert np.array_equal(result.frame(2, "velocity"), frame.velocity)
        assert np.array_equal(result.frame(2, "peak_force"), frame["peak_force"])


def test_case_run_again_in_the_other_form_leaves_no_old_dump(run):
    run_case(case_with("text"), run, figures=False, force=True)
    assert not (run / "dumps" / "spheres.bin").exists()
    assert len(list(read_frames(run))) == 3


@pytest.mark.parametrize("kept", [0.4, 0.9, 0.999])
def test_snapshot_cut_short(run, caplog, kept):
    path = run / "dumps" / "spheres.bin"
    size = path.stat().st_size
    path.write_bytes(path.read_bytes()[: int((2 + kept) / 3 * size)])
    assert len(list(read_frames(run))) == 2
    assert "spheres.bin: snapshot 2 is cut short" in caplog.text
    with pytest.raises(OutputFormatError, match=r"byte \d+ \(snapshot 2\): snapshot 2 is cut short; the file was cut"):
        analyse(run, figures=False)


@pytest.mark.parametrize("n_bytes", [1, 7, 8, 17, 30, 100, 140, 300])
def test_every_place_of_a_header_cut(run, n_bytes):
    path = run / "dumps" / "spheres.bin"
    path.write_bytes(path.read_bytes() + path.read_bytes()[:n_bytes])
    assert len(list(read_frames(run))) == 3


def test_snapshot_written_again_counts_once(run):
    path = run / "dumps" / "spheres.bin"
    content = path.read_bytes()
    path.write_bytes(content + content[content.rindex(MAGIC) - 8 :])
    assert len(list(read_frames(run))) == 3


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
    "byte order": (put(18, "i", 1 << 24), r"found byte order 16777216 and revision 2, expected 1 and 2"),
    "revision": (put(22, "i", 1), r"found byte order 1 and revision 1"),
    "step": (put(STEP, "q", -5), r"found step -5"),
    "rows": (put(ROWS, "q", -1), r"-1 rows"),
    "more rows": (put(ROWS, "q", 1 << 60), r"is cut short"),
    "fewer rows": (put(ROWS, "q", 1), r"found more than 1 rows"),
    "box": (put(BOX, "d", float("nan")), r"the box is not finite"),
    "columns": (put(N_COLUMNS, "i", 3), r"3 columns \(id type"),
    "nan": (value("force", float("nan")), r"row \d+: found nan for force, expected a finite number"),
    "inf": (value("ux", float("-inf")), r"row \d+: found -inf for ux, expected a finite number"),
    "half an id": (value("id", 1.5), r"row \d+: found 1.5 for id, expected a whole number"),
    "unknown id": (value("id", 99999), r"that are not the"),
    "empty": (lambda content: content.clear(), r"holds no complete snapshot"),
    "other content": (lambda content: content.__setitem__(slice(None), b"hello world\n" * 9), r"expected the header"),
}


@pytest.mark.parametrize("name", DAMAGES)
def test_damage(run, name):
    damage, message = DAMAGES[name]
    path: Path = run / "dumps" / "spheres.bin"
    content = bytearray(path.read_bytes())
    damage(content)
    path.write_bytes(content)
    with pytest.raises(OutputFormatError) as error:
        analyse(run, figures=False)
    assert "\n" not in str(error.value) and "--force" in str(error.value)
    assert re.search(rf"{re.escape(str(path))}.*{message}", str(error.value)), error.value


def test_column_that_is_missing(run):
    path = run / "dumps" / "spheres.bin"
    path.write_bytes(path.read_bytes().replace(b" uy ", b" uq "))
    with pytest.raises(OutputFormatError, match=r"spheres\.bin: snapshot 0 lacks the columns uy"):
        list(read_frames(run))


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
            patched.setattr(driver.StopRequest, "wanted", lambda _, looks=looks, stop=stop: next(looks) == stop)
            outcome = run_case(many, tmp_path / "cut", figures=False, resume=True)
        assert outcome.state == "interrupted"
    outcome = run_case(many, tmp_path / "cut", figures=False, resume=True)
    assert outcome.state == "finished"
    assert len(list((tmp_path / "cut" / "dumps").glob("spheres*.bin"))) == 1 + len(stops)
    whole, cut = (list(read_frames(tmp_path / name)) for name in ("whole", "cut"))
    assert [frame.step for frame in cut] == [frame.step for frame in whole] and len(whole) == 40
    assert all(np.array_equal(one.values, other.values) for one, other in zip(whole, cut, strict=True))
    run_case(many, tmp_path / "cut", figures=False, force=True)
    assert len(list((tmp_path / "cut" / "dumps").glob("spheres*.bin"))) == 1
