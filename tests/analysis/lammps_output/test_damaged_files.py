"""Files of a run that are damaged, truncated or of another run: a one-line message with file, line
and remedy.
"""

from __future__ import annotations

import json
import logging
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from granwave.analysis import MissingOutputError, OutputFormatError, Result, analyse
from granwave.analysis.exports.export import export
from granwave.analysis.exports.names import export_names
from granwave.analysis.reports.report import write_report
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.result_directory import ResultDirectory
from granwave.workflows import run_case
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.export_inputs import write_walled_run
from tests.helpers.made_up.run_files import without_checksums
from tests.helpers.made_up.small_cases import PULSE, case_of

Damage = Callable[[Path], object]
DUMPS = ("spheres.dump", "contacts.dump", "wall_bottom.dump", "history.dump", "forces.dump")
TABLES = ("energy.txt", "walls.txt", "probes.txt")


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """A packing on a wall, with a probe."""
    directory = tmp_path_factory.mktemp("plate")
    case = synthetic.make_case("fcc", (4, 4, 2), output={"probes": [{"sphere": 5}], "dump_format": "text"}, boundary={"bottom": "wall"},
                               run={"end_time": 8e-5, "frames": 3})  # fmt: skip
    run_case(case, directory, figures=False)
    return without_checksums(directory)


@pytest.fixture(scope="module")
def chain(tmp_path_factory):
    """A chain with a history."""
    directory = tmp_path_factory.mktemp("chain")
    bar = {"length": 0.4, "area": 127e-6, "elements": 20, "material": "steel"}
    run_case(
        case_of(6, load=PULSE, bar=bar, run={"end_time": 8e-5, "frames": 3}),
        directory,
        figures=False,
    )
    return without_checksums(directory)


def edited(line: int, edit: Callable[[list[str]], list[str]]) -> Damage:
    """Replace the words of a line."""

    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        lines[line] = " ".join(edit(lines[line].split()))
        path.write_text("\n".join(lines) + "\n")

    return damage


def word(line: int, n: int, text: str) -> Damage:
    return edited(
        line, lambda words: [*words[: n % len(words)], text, *words[n % len(words) + 1 :]]
    )


def bytes_in_the_middle(path: Path) -> None:
    content = path.read_bytes()
    middle = len(content) // 2
    path.write_bytes(content[:middle] + b"\xff\x00\xfe\x80" + content[middle + 4 :])


def cut(share: float) -> Damage:
    return lambda path: path.write_bytes(path.read_bytes()[: int(share * path.stat().st_size)])


def without_last_but_one(path: Path) -> None:
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([*lines[:-2], lines[-1]]))


#: Change of a file, and the message in addition to the name of the file.
OF_ROWS: dict[str, tuple[Damage, str]] = {
    "text": (word(-1, -1, "abc"), r"line \d+.*: found 'abc' for \w+, expected a number"),
    "nan": (word(-1, -1, "nan"), r"line \d+.*: found nan for \w+, expected a finite number"),
    "inf": (word(-1, 1, "-inf"), r"line \d+.*: found -inf for \w+, expected a finite number"),
    "half an id": (word(-1, 0, "1.5"), r"line \d+.*: found 1.5 for \w+, expected a whole number"),
    "one too many": (
        edited(-1, lambda words: [*words, "7"]),
        r"line \d+.*: found \d+ values, expected \d+ \(",
    ),
    "one missing": (
        edited(-1, lambda words: words[:-1]),
        r"line \d+.*: found \d+ values, expected \d+ \(",
    ),
    "bytes": (bytes_in_the_middle, r""),
    "empty": (cut(0), r"holds no"),
    "other text": (lambda path: path.write_text("hello\nworld\n"), r"line 1|no names of columns"),
}
OF_DUMPS: dict[str, tuple[Damage, str]] = {
    "cut": (cut(0.6), r"line \d+: snapshot \d+ is truncated; the file is truncated"),
    "cut in a header": (lambda path: path.write_text(path.read_text() + "ITEM: TIMES"), r"line \d+: snapshot \d+ is truncated"),
    "a row missing": (without_last_but_one, r"snapshot \d+ is truncated"),
    "unknown id": (word(-1, 0, "99999"), r"99999|that are not the"),
    "timestep": (word(1, 0, "abc"), r"line 2: found 'abc', expected the timestep, a whole number"),
    "number of rows": (word(3, 0, "-3"), r"line 4: found '-3', expected the number of rows"),
    "too few rows announced": (lambda path: word(3, 0, str(max(0, int(path.read_text().split("\n")[3]) - 1)))(path),
                               r"expected the header of snapshot|that are not the|lacks|found"),
    "box": (word(5, 0, "abc"), r"box of snapshot 0: found 'abc'"),
    "title": (edited(0, lambda _: ["ITEM:", "STEP"]), r"lacks its TIMESTEP"),
    "no columns": (edited(8, lambda words: words[:2]), r"has no columns|found \d+ values, expected 0"),
}  # fmt: skip
OF_TABLES: dict[str, tuple[Damage, str]] = {
    "cut": (cut(0.6), r"ends at step \d+, the (run|energy balance) at step \d+: the file is truncated|found \d+ values"),
    "a row missing": (without_last_but_one, r"has no rows between the steps \d+ and \d+"),
    "beyond the end": (word(-1, 0, "99999"), r"has no rows between"),
    "column": (lambda path: path.write_text(re.sub(r"\b(dissipated|bottom|sphere_5_ux)\b", "other", path.read_text())),
               r"has no columns"),
}  # fmt: skip


def refused(source: Path, tmp_path: Path, file: str, damage: Damage, message: str) -> None:
    directory = tmp_path / "run"
    shutil.copytree(source, directory)
    damage(directory / file)
    before = {path: path.stat().st_mtime_ns for path in directory.rglob("*")}
    with pytest.raises((OutputFormatError, MissingOutputError)) as error:
        analyse(directory, figures=False)
    assert "\n" not in str(error.value)
    assert re.search(rf"{re.escape(str(directory / file))}.*({message})", str(error.value)), (
        error.value
    )
    assert "force=True" in str(error.value) or "delete it" in str(error.value)
    after = {path: path.stat().st_mtime_ns for path in directory.rglob("*")}
    assert {path for path in before if path.is_file()} == {path for path in after if path.is_file()}


def runs_of(file: str) -> str:
    return "chain" if file in ("history.dump", "forces.dump") else "plate"


#: All damages of one file of each format; of the others the rows, which have columns of their own, and a cut.
WRITTEN = [
    *(("contacts.dump", name) for name in (*OF_ROWS, *OF_DUMPS)),
    *(("energy.txt", name) for name in (*OF_ROWS, *OF_TABLES)),
    *(
        (file, name)
        for file in DUMPS
        if file != "contacts.dump"
        for name in ("nan", "one missing", "cut", "unknown id")
    ),
    *(
        (file, name)
        for file in TABLES
        if file != "energy.txt"
        for name in ("nan", "one missing", "cut", "column")
    ),
]


@pytest.mark.parametrize("file, name", WRITTEN)
def test_what_lammps_wrote(plate, chain, tmp_path, file, name):
    damage, message = (OF_ROWS | (OF_DUMPS if file in DUMPS else OF_TABLES))[name]
    refused(
        {"plate": plate, "chain": chain}[runs_of(file)], tmp_path, f"dumps/{file}", damage, message
    )


@pytest.mark.parametrize("name", ["text", "one too many", "empty", "other text"])
def test_the_data_file(plate, tmp_path, name):
    damage, message = OF_ROWS[name]
    message = {"empty": "does not state", "other text": "does not state"}.get(name, message)
    refused(plate, tmp_path, "data.granwave", damage, message)


@pytest.mark.parametrize(
    "content", ["", "{", "[1]", '{"n_steps": "many"}', '{"n_steps": 10, "versions": []}']
)
def test_the_record(plate, tmp_path, content):
    refused(
        plate,
        tmp_path,
        "run.json",
        lambda path: path.write_text(content),
        "cannot be read: delete it",
    )


@pytest.mark.parametrize("file", [*DUMPS, *TABLES])
def test_a_lost_file(plate, chain, tmp_path, file):
    directory = tmp_path / "run"
    shutil.copytree({"plate": plate, "chain": chain}[runs_of(file)], directory)
    (directory / "dumps" / file).unlink()
    with pytest.raises(MissingOutputError, match=rf"{file} is missing"):
        analyse(directory, figures=False)


def test_snapshots_that_end_before_the_run(plate, tmp_path):
    """Truncate exactly between two snapshots."""
    refused(
        plate, tmp_path, "dumps/spheres.dump",
        lambda path: path.write_text(path.read_text()[: path.read_text().rindex("ITEM: TIMESTEP")]),
        r"ends with the snapshot of step \d+, the run at step \d+: the file is truncated",
    )  # fmt: skip


def test_status_and_one_line(granwave, plate, tmp_path):
    shutil.copytree(plate, tmp_path / "run")
    word(-1, -1, "abc")(tmp_path / "run" / "dumps" / "spheres.dump")
    done = granwave("analyse", "run", "--no-figures", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith("granwave: run/dumps/spheres.dump: line ")


# ---------------------------------------------------------------------- result.h5 and summary.json


def changed(change: Callable[[h5py.File], object]) -> Damage:
    def damage(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            change(file)

    return damage


def replaced(name: str, make: Callable[[np.ndarray], Any]) -> Damage:
    def change(file: h5py.File) -> None:
        values = file[name][()]
        unit = file[name].attrs["unit"]
        del file[name]
        file.create_dataset(name, data=make(values)).attrs["unit"] = unit

    return changed(change)


OF_RESULTS: dict[str, tuple[Damage, str]] = {
    "cut": (cut(0.9), r"is damaged \(it was cut\)"),
    "empty": (cut(0), r"is damaged \(it is not an HDF5 file\)"),
    "text": (lambda path: path.write_text("no"), r"is damaged \(it is not an HDF5 file\)"),
    "no contacts": (changed(lambda file: file.pop("contacts")), r"is damaged \(it has no contacts/i\)"),
    "no trajectory": (changed(lambda file: file.pop("particles")), "is damaged"),
    "no spheres": (changed(lambda file: file.pop("spheres")), "has no /spheres"),
    "case": (changed(lambda file: file.attrs.modify("case", "hello")), "is damaged"),
    "record": (changed(lambda file: file.attrs.modify("run", "[1]")), "is damaged"),
    "rows": (replaced("contacts/peak_force", lambda values: values[:-2]), r"is damaged \(contacts/\w+ has \d+ rows"),
    "words": (replaced("spheres/peak_force", lambda values: np.full(len(values), b"a")), "does not hold numbers"),
    "no instant": (changed(lambda file: [file["energy"].pop(name) for name in list(file["energy"])]), "it has no energy/step"),
    "flat": (replaced("spheres/position", lambda values: values[:, 0]), "does not hold vectors"),
}  # fmt: skip


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    return write_walled_run(tmp_path_factory.mktemp("analysed"))


@pytest.mark.parametrize("name", OF_RESULTS)
def test_result_file(analysed, tmp_path, name):
    run = tmp_path / "run"
    shutil.copytree(analysed, run)
    damage, message = OF_RESULTS[name]
    damage(run / "result.h5")
    with pytest.raises(OutputFormatError, match=message) as error:
        Result(run)
    assert str(run / "result.h5") in str(error.value) and "\n" not in str(error.value)
    for form in set(export_names()) - {"ovito"}:
        with pytest.raises(InputError, match=message):
            export(run, form, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    (run / "summary.json").write_text(json.dumps({"name": "a", "end_reason": "end_time"}))
    text = write_report([run], tmp_path / "r.md").read_text()
    assert re.search(r"The result\.h5 of run is damaged.*granwave analyse run", text)


def test_values_that_cannot_be_read(analysed, tmp_path):
    """The structure is intact; the compressed data are damaged."""
    run = tmp_path / "run"
    shutil.copytree(analysed, run)
    with h5py.File(run / "result.h5") as file:
        chunk = file["particles/spheres/displacement/value"].id.get_chunk_info(0)
    with (run / "result.h5").open("r+b") as stream:
        stream.seek(chunk.byte_offset)
        stream.write(b"\x55" * chunk.size)
    with (
        Result(run) as result,
        pytest.raises(OutputFormatError, match=r"is damaged \(displacement of snapshot 0"),
    ):
        result.frame(0, "displacement")
    for form in set(export_names()) - {"ovito"}:
        with pytest.raises((InputError, OutputFormatError), match=r"result\.h5 is damaged"):
            export(run, form, tmp_path / "out")


@pytest.mark.parametrize("value", ['"x"', "[1]", "true", "1" + "0" * 400, '{"a": 1}'])
def test_summary_of_what_is_no_number(analysed, tmp_path, value):
    run = tmp_path / "run"
    shutil.copytree(analysed, run)
    (run / "summary.json").write_text(f'{{"name": "a", "energy_input_J": {value}}}')
    with pytest.raises(
        InputError,
        match=r"summary\.json: energy_input_J: found .*, expected a number; recreate it",
    ):
        write_report([run], tmp_path / "r.md")


# ---------------------------------------------------------------------- what is no run


@pytest.mark.needs_extension("continuum")
def test_results_of_what_is_no_run(analysed, tmp_path):
    def said(path: Path) -> str:
        with pytest.raises((MissingOutputError, OutputFormatError)) as error:
            Result(path)
        return str(error.value)

    shutil.copytree(analysed, tmp_path / "first")
    (tmp_path / "empty").mkdir()
    assert re.search(r"frist: no such directory; did you mean .*/first\?", said(tmp_path / "frist"))
    assert "there is no directory" in said(tmp_path / "nowhere" / "first")
    assert "is no run, but contains some (first); use these directories" in said(tmp_path)
    assert "is no run: it is empty" in said(tmp_path / "empty")
    assert re.search(
        r"case\.toml: is a file, expected the directory of a run; did you mean .*first\?",
        said(tmp_path / "first" / "case.toml"),
    )
    assert re.search(
        r"dumps: is no run: it holds contacts\.dump.*did you mean .*first\?",
        said(tmp_path / "first" / "dumps"),
    )
    (tmp_path / "first" / "result.h5").unlink()
    assert f"make it with  granwave analyse {tmp_path / 'first'}" in said(tmp_path / "first")
    (tmp_path / "first" / "run.json").write_text('{"state": "interrupted"}')
    assert "is not finished (state interrupted); resume with  granwave run" in said(
        tmp_path / "first"
    )
    (tmp_path / "first" / ".granwave").unlink()  # which says that it is a run
    (tmp_path / "first" / "case.toml").write_text("[block]\n[punch]\n")
    assert "is a continuum run" in said(tmp_path / "first")
    (tmp_path / "first" / "case.toml").unlink()
    assert "case.toml is missing" in said(tmp_path / "first")


def test_result_of_a_scan(analysed, tmp_path):
    (tmp_path / "scan.json").write_text("{}")
    with pytest.raises(MissingOutputError, match="is a scan of which no point is done"):
        Result(tmp_path)
    shutil.copytree(analysed, tmp_path / "points" / "abc")
    with pytest.raises(
        MissingOutputError, match=r"is a scan.*such as .*points/abc \(scan\.csv lists"
    ):
        Result(tmp_path)
    with pytest.raises(MissingOutputError, match="is a scan"):
        analyse(tmp_path)


@pytest.mark.parametrize(
    "content",
    ["{", "[]", '{"name": "a", "case": "b", "varied": [], "points": [{"number": 1, "id": "x"}]}',
     '{"name": "a", "case": "b", "varied": [], "points": [{"number": 1, "id": "x", "labels": 3}]}'],
)  # fmt: skip
def test_index_of_a_scan(tmp_path, content):
    (tmp_path / "scan").mkdir()
    (tmp_path / "scan" / "scan.json").write_text(content)
    for refuses in (
        lambda: export(tmp_path / "scan", "csv"),
        lambda: write_report([tmp_path / "scan"], tmp_path / "r.md"),
    ):
        with pytest.raises(
            InputError,
            match=r"scan\.json (lacks|cannot be read).*run the scan again with resume=True",
        ):
            refuses()


DATA = "data.granwave"
SCRIPT = "in.granwave"


@pytest.fixture
def by_hand(tmp_path):
    """A deck of a chain that contains a manual LAMMPS run."""
    synthetic.write_run(tmp_path, synthetic.make_case("chain", 6))
    (tmp_path / "run.json").unlink()
    return tmp_path


def test_a_deck_as_written_gives_no_warning(by_hand, caplog):
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] is None
    assert not caplog.records


def test_an_edited_script_is_told(by_hand, caplog):
    path = by_hand / SCRIPT
    path.write_text(path.read_text().replace("elastoplastic", "hertz"))
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] == [SCRIPT]
    (message,) = (record.getMessage() for record in caplog.records)
    assert f"{path}: was changed after granwave wrote it" in message
    assert "material, law, load, walls, timestep and lattice are read from case.toml" in message


def test_positions_of_an_edited_data_file_are_used(by_hand, caplog):
    path = by_hand / DATA
    lines = path.read_text().splitlines()
    last = lines[-1].split()
    lines[-1] = " ".join([*last[:-1], "0.0501"])
    path.write_text("\n".join(lines) + "\n")
    with caplog.at_level(logging.WARNING, "granwave"):
        assert analyse(by_hand, figures=False)["deck_changed"] == [DATA]
    assert "positions, diameters and densities are read from the file" in caplog.text
    assert "it is newer than the output of LAMMPS" in caplog.text
    with Result(by_hand) as result:
        assert np.max(result["spheres/position"][:, 2]) == 0.0501


def test_data_changed_after_a_run_is_refused(by_hand):
    (by_hand / "run.json").write_text("{}")
    analyse(by_hand, figures=False)
    before = (by_hand / "result.h5").read_bytes()
    with (by_hand / DATA).open("a") as stream:
        stream.write("\n")
    with pytest.raises(
        InputError, match=r"data\.granwave: was changed after the run, and the positions"
    ):
        analyse(by_hand, figures=False)
    assert (by_hand / "result.h5").read_bytes() == before


def test_script_changed_after_a_run_is_told(by_hand, caplog):
    (by_hand / "run.json").write_text("{}")
    with (by_hand / SCRIPT).open("a") as stream:
        stream.write("# a note\n")
    with caplog.at_level(logging.WARNING, "granwave"):
        analyse(by_hand, figures=False)
    assert "was changed after the run; the results belong to the original file" in caplog.text


def test_directories_without_digests(by_hand):
    """Directories of earlier versions contain no checksums."""
    marker = by_hand / ".granwave"
    marker.write_text(marker.read_text().replace('"digests"', '"other"'))
    (by_hand / SCRIPT).write_text("")
    assert ResultDirectory(by_hand).changed_deck() == []
