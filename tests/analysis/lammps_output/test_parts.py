"""Analysis in parts, and dumps in several files: the values equal those of one part and one
file.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import textwrap
import tracemalloc
from pathlib import Path

import h5py
import numpy as np
import pytest

from granwave.analysis import MissingOutputError, OutputFormatError, Result, analyse, pipeline
from granwave.analysis.exports.export import export
from granwave.analysis.figures import run_figures
from granwave.analysis.lammps_output.binary import binary_frames
from granwave.analysis.lammps_output.dumps import contacts_at_end, read_frames
from granwave.analysis.result.writer import write_result
from granwave.analysis.summary import summarise
from granwave.lammps_inputs import plan, write_deck
from granwave.lammps_inputs.deck import deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import case_from_dict
from granwave.lammps_inputs.packing.assembly import assemble
from granwave.lammps_inputs.packing.motion import written_in_parts
from granwave.lammps_inputs.processes import ALONE, Processes
from granwave.workflows import run_case
from granwave.workflows.cli.tables.plan_table import plan_table
from granwave.workflows.cli.terminal import in_shell
from granwave.workflows.run import driver
from tests.conftest import BIN, PLAIN
from tests.helpers.made_up import synthetic
from tests.helpers.made_up.run_files import without_checksums
from tests.helpers.programs.several_processes import SeveralProcesses

pytestmark = [
    pytest.mark.xdist_group("parts"),
    pytest.mark.validation,
]  # its fixtures are made once

RUN = {"end_time": 6e-5, "frames": 3}
IN_PARTS = {"parts": True, "dump_format": "binary"}
#: Each with something that spheres of different parts share: contacts, periods, vacancies, strikers, walls, bars.
CASES = {
    "hcp, walls": {"kind": "hcp", "boundary": {"bottom": "wall"}, "contact": {"friction": 0.3}},
    "periodic": {"boundary": {"sides": "periodic"}, "size": (4, 4, 5)},
    "vacancies and scatter": {"packing": {"vacancies": 0.1, "diameter_scatter": 2e-6, "seed": 3}},
    "unlike": {
        "replace": [
            {"index": [1, 60], "diameter": 0.0099},
            {"index": [20, 77], "material": "steel"},
        ]
    },
    "striker": {
        "load": {"kind": "striker"},
        "striker": [{"touches": [15], "velocity": [0.0, 0.0, 5.0], "diameter": 0.02}],
    },
    "dents": {"contact": {"initial_overlap": 2e-6}},
    "static stage": {
        "precompression": {"kind": "uniform", "pressure": 1e4},
        "boundary": {"bottom": "wall"},
    },
    "bar": {"kind": "chain", "size": 12, "bar": {"length": 0.1, "area": 1e-4, "elements": 40}},
}


def case_of(kind="fcc", size=(6, 6, 4), output=None, **tables):
    return synthetic.make_case(
        kind, size, run=RUN, output={"history": 0} | (output or {}), **tables
    )


def values_in(directory: Path) -> dict[str, object]:
    """All data sets, with their types, and all attributes of a result, as bytes."""
    found: dict[str, object] = {}

    def note(name: str, item: h5py.Group | h5py.Dataset) -> None:
        found[name] = sorted((key, str(value)) for key, value in item.attrs.items())
        if isinstance(item, h5py.Dataset):
            values = item[()]
            found[f"{name}:"] = (
                values.tolist()
                if values.dtype == object
                else (values.dtype, values.shape, values.tobytes())
            )

    with h5py.File(directory / "result.h5") as file:
        file.visititems(note)
        found["/"] = [file.attrs[name] for name in ("name", "case", "versions")]
    return found


def in_parts(
    directory: Path, at_once: int, processes: Processes = ALONE
) -> tuple[dict[str, object], dict[str, object]]:
    """Analyse a run in parts of a number of spheres; return the values of result.h5 and the
    summary.
    """
    write_result(directory, at_once=at_once, processes=processes)
    return values_in(directory), summarise(directory, at_once=at_once, processes=processes)


LONG = ("periodic", "striker", "dents", "static stage")  # validations


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.validation] if name in LONG else []) for name in CASES],
)
def test_parts_give_the_same_bits_as_the_whole(tmp_path, name):
    run_case(case_of(**CASES[name]), tmp_path, figures=False)
    whole = values_in(tmp_path), json.loads((tmp_path / "summary.json").read_text())
    assert len(whole[0]["contacts/i:"][2]) and whole[1]["n_plastic_spheres"] > 1
    values, summary = in_parts(tmp_path, 1 + whole[1]["n_spheres"] // 5)
    assert values.keys() == whole[0].keys()
    assert [key for key in values if values[key] != whole[0][key]] == []
    assert summary == whole[1]
    with SeveralProcesses(3) as three:
        for at_once in (1 + whole[1]["n_spheres"] // 5, whole[1]["n_spheres"]):
            values, summary = in_parts(tmp_path, at_once, three)
            assert [key for key in whole[0] if values[key] != whole[0][key]] == []
            assert summary == whole[1]
    assert not list(tmp_path.glob(".result.h5.*"))


# ---------------------------------------------------------------------- files of each node


BOTH = """
    from granwave.lammps_inputs.load_case import load_case
    from granwave.workflows import run_case
    from granwave.workflows.run import driver
    for name in ("node", "one", "parts"):
        if name == "parts":
            driver.nodes = lambda comm: ["first", "second"][: comm.size]
        run_case(load_case(f"{name}.toml"), name, figures=False)
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs on two ranks: as if on two nodes with a file from each; with a common file; and with
    only the files of this node.
    """
    place = tmp_path_factory.mktemp("runs")
    for name, parts in (("node", True), ("one", False), ("parts", True)):
        case = case_of(boundary={"bottom": "wall"}, output=IN_PARTS | {"parts": parts})
        (place / f"{name}.toml").write_text(case.to_toml())
    (place / "both.py").write_text(textwrap.dedent(BOTH))
    command = [str(BIN / "mpiexec"), "-n", "2", sys.executable, "-m", "mpi4py", "both.py"]
    subprocess.run(command, cwd=place, check=True, env=PLAIN, capture_output=True, timeout=240)
    return {name: place / name for name in ("node", "one", "parts")}


@pytest.fixture
def run(runs, tmp_path):
    shutil.copytree(runs["parts"], tmp_path / "run")
    return without_checksums(tmp_path / "run")


def test_each_node_writes_its_own(runs):
    names = {path.name for path in (runs["parts"] / "dumps").iterdir()}
    assert {
        "spheres.0.bin",
        "spheres.1.bin",
        "contacts.0.dump",
        "contacts.1.dump",
        "contacts.txt",
    } <= names
    assert not names & {"spheres.bin", "contacts.dump"}
    ids = [
        next(binary_frames(runs["parts"] / "dumps" / f"spheres.{part}.bin")).read()["id"]
        for part in (0, 1)
    ]
    assert ids[0].max() > ids[1].min() and ids[1].max() > ids[0].min()  # they need to be sorted


def test_one_node_writes_one_file(runs):
    names = {path.name for path in (runs["node"] / "dumps").iterdir()}
    assert {"spheres.0.bin", "contacts.0.dump", "contacts.txt"} <= names
    assert not names & {"spheres.1.bin", "contacts.1.dump", "spheres.bin", "contacts.dump"}


@pytest.mark.parametrize("name", ["parts", "node"])
def test_results_are_those_of_one_file(runs, name):
    one, parts = (values_in(runs[form]) for form in ("one", name))
    del one["/"], parts["/"]  # the case and the wall time
    assert [key for key in one if one[key] != parts.get(key)] == []
    summaries = [json.loads((runs[form] / "summary.json").read_text()) for form in ("one", name)]
    timed = ("wall_time_s", "sphere_steps_per_s")
    one, parts = (
        {key: value for key, value in found.items() if key not in timed} for found in summaries
    )
    assert one == parts


def test_analysis_once_more(run):
    before = values_in(run)
    analyse(run, figures=False, at_once=50)
    assert values_in(run) == before


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "spheres.0.bin",
            r"spheres\.0\.bin is missing: the dump has 2 files",
        ),
        ("spheres.1.bin", r"spheres\.1\.bin is missing"),
        ("contacts.0.dump", r"contacts\.0\.dump is missing"),
        ("contacts.1.dump", r"contacts\.1\.dump is missing"),
        ("contacts.txt", r"contacts\.txt is missing"),
    ],
)
def test_missing_part(run, name, message):
    before = (run / "result.h5").read_bytes()
    (run / "dumps" / name).unlink()
    with pytest.raises(MissingOutputError, match=message) as error:
        analyse(run, figures=False)
    assert "\n" not in str(error.value) and "force=True" in str(error.value)
    assert (run / "result.h5").read_bytes() == before


def test_last_part_of_a_run_that_did_not_finish(run):
    """Only the ids show that there were more ranks."""
    for name in ("spheres.1.bin", "contacts.1.dump"):
        (run / "dumps" / name).unlink()
    with pytest.raises(
        OutputFormatError,
        match=r"spheres\.N\.bin \(N = 0, 1, \.\.\.\): snapshot 0 .* holds 75 spheres .* 144",
    ):
        analyse(run, figures=False)


@pytest.mark.parametrize("at_once", [20, 1000])
def test_sphere_that_is_there_twice(run, at_once):
    path = run / "dumps" / "spheres.0.bin"
    frame = next(binary_frames(path))
    begin, _ = frame.values.pieces[0]
    row = 8 * len(frame.columns)
    content = bytearray(path.read_bytes())
    content[begin + row : begin + 2 * row] = content[begin : begin + row]
    path.write_bytes(content)
    with pytest.raises(OutputFormatError, match=r"snapshot 0 .* spheres that are not the 144"):
        analyse(run, figures=False, at_once=at_once)


@pytest.mark.parametrize(
    "name", ["spheres.0.bin", "spheres.1.bin", "contacts.0.dump", "contacts.1.dump"]
)
@pytest.mark.parametrize("kept", [0.3, 0.999])
def test_part_that_was_cut(run, name, kept):
    path = run / "dumps" / name
    os.truncate(path, int(kept * path.stat().st_size))
    with pytest.raises(OutputFormatError, match=r"cut|contacts, contacts\.txt says") as error:
        analyse(run, figures=False)
    assert str(path.parent) in str(error.value) and "force=True" in str(error.value)


def test_contacts_cut_at_the_end_of_a_row(run):
    path = run / "dumps" / "contacts.1.dump"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(
        OutputFormatError,
        match=r"contacts\.N\.dump \(N = 0, 1, \.\.\.\): found \d+ contacts, contacts\.txt says",
    ):
        analyse(run, figures=False)


def test_parts_of_another_run(run):
    """Files as from LAMMPS run by hand, first on three ranks and then on two."""
    shutil.copy(run / "dumps" / "spheres.1.bin", run / "dumps" / "spheres.2.bin")
    with pytest.raises(OutputFormatError, match="holds 213 spheres that are not the 144"):
        analyse(run, figures=False)


@pytest.mark.parametrize("form", ["binary", "text"])
def test_resumed_run(tmp_path, monkeypatch, caplog, form):
    """The continued run may have another number of ranks, and writes separate files."""
    case = case_of(
        output=IN_PARTS | {"dump_format": form}, boundary={"bottom": "wall"}, size=(4, 4, 3)
    )
    run_case(case, tmp_path / "whole", figures=False)
    monkeypatch.setattr(driver, "_PIECE", 1e-3)
    with monkeypatch.context() as patched:
        looks = iter(range(1000))
        patched.setattr(driver.StopRequest, "wanted", lambda _: next(looks) == 1)
        assert run_case(case, tmp_path / "cut", figures=False).state == "interrupted"
    assert [
        path.name.split(".")[1] for path in sorted((tmp_path / "cut").glob("checkpoint-*"))
    ] == ["0", "base"]
    shutil.copytree(tmp_path / "cut", tmp_path / "killed")
    next((tmp_path / "killed").glob("checkpoint-*.0.restart")).unlink()
    assert run_case(case, tmp_path / "killed", figures=False, resume=True).state == "finished"
    assert ".0.restart: is missing; the checkpoint is unusable" in caplog.text
    assert run_case(case, tmp_path / "cut", figures=False, resume=True).state == "finished"
    assert "read_restart" in (tmp_path / "cut" / "log.lammps").read_text()
    assert not list((tmp_path / "cut").glob("checkpoint-*"))
    suffix = {"binary": "bin", "text": "dump"}[form]
    assert len(list((tmp_path / "cut" / "dumps").glob(f"spheres-*.0.{suffix}"))) == 1
    whole, cut = (list(read_frames(tmp_path / name)) for name in ("whole", "cut"))
    assert len(whole) == 3 and [frame.step for frame in whole] == [frame.step for frame in cut]
    assert all(
        np.array_equal(one.values, other.values) for one, other in zip(whole, cut, strict=True)
    )
    assert len(next(contacts_at_end(tmp_path / "cut").frames())) == len(
        next(contacts_at_end(tmp_path / "whole").frames())
    )
    again = run_case(
        case_of(output={"parts": False}, size=(4, 4, 3)),
        tmp_path / "cut",
        figures=False,
        force=True,
    )
    assert again.state == "finished"
    assert not list((tmp_path / "cut" / "dumps").glob("*.0.*")) + list(
        (tmp_path / "cut" / "dumps").glob("spheres-*")
    )


# ---------------------------------------------------------------------- analysis on several ranks


ON_RANKS = """
    import os, sys
    from granwave.analysis import pipeline
    from granwave.analysis.result import sphere_tables
    from granwave.workflows.cli.main import main
    from granwave.workflows.run import mpi
    pipeline.analyse.__kwdefaults__["at_once"] = 20
    if sys.argv[2:] == ["killed"] and not mpi.is_first():
        sphere_tables._tables = lambda *_: os.kill(os.getpid(), 9)
    mpi.leave(main(["analyse", sys.argv[1], "--no-figures"]))
"""


def on_ranks(
    run: Path, number: int, *words: str, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Analyse a run on a number of ranks, with 20 spheres per part."""
    script = run.parent / "on_ranks.py"
    script.write_text(textwrap.dedent(ON_RANKS))
    command = [
        str(BIN / "mpiexec"),
        "-n",
        str(number),
        sys.executable,
        "-m",
        "mpi4py",
        str(script),
        str(run),
        *words,
    ]
    return subprocess.run(
        command, env=PLAIN | variables, capture_output=True, text=True, timeout=240, check=False
    )


@pytest.mark.parametrize(
    "number", [2, *(pytest.param(number, marks=pytest.mark.validation) for number in (3, 10))]
)
def test_ranks_give_the_same_bits(run, number):
    """With ten ranks the first rank only collects the results of the others."""
    before = values_in(run), (run / "summary.json").read_text()
    done = on_ranks(run, number)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("balance error") == 1
    warnings = [line for line in done.stderr.splitlines() if line.startswith("granwave: warning")]
    assert 0 < len(warnings) == len(set(warnings))
    assert (values_in(run), (run / "summary.json").read_text()) == before
    assert not list(run.glob(".result.h5.*"))


@pytest.mark.parametrize("name", ["contacts.1.dump", "spheres.1.bin", "contacts.txt"])
def test_damage_is_told_once_as_by_one_process(run, name):
    before = (run / "result.h5").read_bytes()
    path = run / "dumps" / name
    content = path.read_bytes()
    if name == "contacts.1.dump":
        path.write_bytes(content[:-40] + b"nan" + content[-37:])
    elif name == "spheres.1.bin":
        path.write_bytes(content[:-16] + np.float64(np.nan).tobytes() + content[-8:])
    else:
        path.write_text("7\n")
    with pytest.raises(OutputFormatError) as alone:
        analyse(run, figures=False, at_once=20)
    done = on_ranks(run, 2)
    assert done.returncode == 2
    assert done.stderr == f"granwave: {in_shell(str(alone.value))}\n"
    assert (run / "result.h5").read_bytes() == before and not list(run.glob(".result.h5.*"))


def test_ranks_that_are_asked_to_stop(run, tmp_path):
    before = (run / "result.h5").read_bytes()
    (tmp_path / "stop").touch()
    done = on_ranks(run, 2, GRANWAVE_STOP_FILE=str(tmp_path / "stop"))
    assert (done.returncode, done.stderr) == (130, "granwave: stopped\n")
    assert (run / "result.h5").read_bytes() == before and not list(run.glob(".result.h5.*"))


def test_rank_that_is_killed_ends_the_others(run):
    before = (run / "result.h5").read_bytes()
    assert on_ranks(run, 2, "killed").returncode not in (0, 2)
    assert (run / "result.h5").read_bytes() == before
    assert list(run.glob(".result.h5.*"))
    done = on_ranks(run, 2)
    assert done.returncode == 0, done.stderr
    assert not list(run.glob(".result.h5.*"))


def test_ranks_of_the_command(run, granwave):
    before = values_in(run)
    done = granwave("analyse", run, "--no-figures", "--np", 2)
    assert done.returncode == 0, done.stderr
    assert values_in(run) == before
    missing = granwave("analyse", run / "nowhere", "--np", 2)
    assert missing.returncode == 2 and missing.stderr.count("no such directory") == 1


def test_files_of_others_are_not_overwritten(tmp_path):
    (tmp_path / "dumps").mkdir()
    (tmp_path / "dumps" / "spheres.12.bin").write_text("mine")
    with pytest.raises(InputError, match=r"dumps/spheres\.12\.bin would be overwritten"):
        write_deck(case_of(output=IN_PARTS), tmp_path)


def test_figures_of_a_large_packing_are_left_out(run, monkeypatch, caplog):
    """Only figures against time are drawn, which do not read values of all spheres or contacts."""
    drawn = []
    read = []
    monkeypatch.setattr(pipeline, "MOST_DRAWN", 100)
    monkeypatch.setattr(
        run_figures, "draw_figures", lambda _, report, names, **others: drawn.extend(names)
    )
    analyse(run, at_once=50)
    assert "figures of the packing are omitted" in caplog.text and "granwave figures" in caplog.text
    assert "energies" in drawn and not [
        name for name in drawn if "principal" in name or "3d" in name
    ]
    monkeypatch.setattr(
        Result,
        "read",
        lambda self, name, *rows, old=Result.read: read.append(name) or old(self, name, *rows),
    )
    with Result(run, at_once=50) as result:
        drawings = [run_figures.run_figures()[name].draw(result) for name in drawn]
    assert sum(drawing is not None for drawing in drawings) >= 2
    assert not [name for name in read if name.startswith(("spheres/", "contacts/"))]


@pytest.mark.needs_extension("pictures")
def test_ovito_does_not_join_parts(run, tmp_path):
    with pytest.raises(InputError, match=r"the dumps have several parts .*--to vtp"):
        export(run, "ovito", tmp_path / "out")


def test_check_tells_what_a_rank_holds():
    large = {"packing": {"vacancies": 0.01}, "size": (100, 100, 60), "output": {"parts": True}}
    case = case_of(**large)
    table = plan_table(assemble(case), plan(case, n_ranks=8))
    assert "one file per node (output.parts)" in table
    assert "all sites at once, for dissimilar or missing spheres" in table
    sizes = [
        plan(case_of(size=(100, 100, n), output={"parts": "auto"}), n_ranks=10_000)
        for n in (200, 2000)
    ]
    assert sizes[0].first_rank == pytest.approx(
        sizes[1].first_rank, rel=0.01
    )  # the analysis does not grow
    assert not written_in_parts(assemble(case_of(size=(100, 100, 999))))
    assert written_in_parts(assemble(case_of(size=(100, 100, 1000))))


def test_deck_of_any_size_is_written_in_bounded_memory(tmp_path, monkeypatch):
    monkeypatch.setattr(deck, "_BATCH", 500)
    peaks = []
    for layers in (20, 80):
        assembly = assemble(case_of(size=(10, 10, layers)))
        tracemalloc.start()
        deck.write_data(assembly, tmp_path / "data")
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.1 * peaks[0]  # the first also holds what is cached at the first call


@pytest.mark.parametrize("name", ["hcp, walls", "vacancies and scatter", "striker", "bar"])
def test_deck_of_several_processes_is_the_same(tmp_path, monkeypatch, name):
    monkeypatch.setattr(deck, "_BATCH", 50)
    assembly = assemble(case_of(**CASES[name]))
    deck.write_data(assembly, tmp_path / "one")
    with SeveralProcesses(3) as three:
        deck.write_data(assembly, tmp_path / "three", three)
    assert (tmp_path / "three").read_bytes() == (tmp_path / "one").read_bytes()


def test_case_key(tmp_path):
    assert case_of().output.parts == "auto"
    with pytest.raises(InputError, match=r'output\.parts: .*true, false or "auto"'):
        case_from_dict(case_of().to_dict() | {"output": {"parts": "yes"}})
