"""The launcher, any number of ranks, and ranks that end."""

from __future__ import annotations

import json
import logging
import os
import re
import signal
import subprocess
import sys
import textwrap

import h5py
import numpy as np
import pytest

from granwave.lammps_inputs import write_deck
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.load_case import load_assembly, load_case
from granwave.workflows import library
from granwave.workflows.run import mpi
from granwave.workflows.run.directory import check_processors
from tests.conftest import BIN, PLAIN
from tests.helpers.programs.processes import alive, children, wait_for

LONG = [
    "fcc-small",
    "--set",
    "run.end_time=5e-3",
    "--set",
    "run.frames=2",
    "--no-figures",
    "--np",
    "2",
]


@pytest.mark.parametrize("victim", ["granwave", "mpiexec", "proxy"])
def test_ranks_end_with_their_launcher(tmp_path, victim):
    started = subprocess.Popen(
        [BIN / "granwave", "run", *LONG, "-o", "out"],
        cwd=tmp_path,
        env=PLAIN,
        stderr=subprocess.DEVNULL,
    )
    try:
        [launcher] = wait_for(lambda: children(started.pid))
        [proxy] = wait_for(lambda: children(launcher))
        ranks = wait_for(lambda: len(found := children(proxy)) == 2 and found)
        wait_for((tmp_path / "out" / "dumps" / "energy.txt").exists)
        os.kill(
            {"granwave": started.pid, "mpiexec": launcher, "proxy": proxy}[victim], signal.SIGKILL
        )
        wait_for(lambda: not any(map(alive, ranks)), 10)
    finally:
        started.kill()
        started.wait()


def test_more_ranks_than_cores(monkeypatch, caplog):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    with caplog.at_level(logging.WARNING):
        mpi.check_cores(2)
        assert not caplog.messages
        mpi.check_cores(3)
    assert caplog.messages == [
        "3 ranks on 2 cores: ranks that share a core wait for each other; --np 2 is faster"
    ]
    with pytest.raises(
        InputError, match=r"--np 49: found 49 ranks on 2 cores, expected .* use --np 2"
    ):
        mpi.check_cores(49)


@pytest.mark.parametrize("end", ["<&- >&- 2>&-", "2>&1 | true", "--np 2 <&- >&- 2>&-"])
def test_output_that_nobody_reads(tmp_path, end):
    command = ["granwave", "run", "two-spheres", "-o", "out", "--no-figures"]
    environment = PLAIN | {"PATH": f"{BIN}:{os.environ['PATH']}"}
    done = subprocess.run(
        ["bash", "-o", "pipefail", "-c", f"{' '.join(command)} {end}"],
        cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode in (0, 141) and "Traceback" not in done.stderr
    assert (tmp_path / "out" / "summary.json").is_file()


WORK = """
    import json, sys, time
    from pathlib import Path
    from mpi4py import MPI
    from granwave.workflows.run.mpi import on_first

    begin = time.process_time()
    found = on_first(MPI.COMM_WORLD, lambda: time.sleep(1.5) or 42)
    used = time.process_time() - begin
    quick = time.monotonic()
    for _ in range(100):
        on_first(MPI.COMM_WORLD, lambda: None)
    note = {"found": found, "used": used, "quick": time.monotonic() - quick}
    try:
        on_first(MPI.COMM_WORLD, lambda: {}["nothing"])
    except KeyError as error:
        note["error"] = str(error)
    Path(sys.argv[1], str(MPI.COMM_WORLD.rank)).write_text(json.dumps(note))
"""


def test_other_ranks_leave_their_cores_to_the_first(tmp_path):
    """Waiting ranks use no processor time, receive the result or the error, and cause no delay for
    short tasks.
    """
    script = tmp_path / "work.py"
    script.write_text(textwrap.dedent(WORK))
    command = [str(BIN / "mpiexec"), "-n", "2", sys.executable, str(script), str(tmp_path)]
    subprocess.run(command, check=True, timeout=120, env=PLAIN)
    notes = [json.loads((tmp_path / str(rank)).read_text()) for rank in range(2)]
    assert [note["found"] for note in notes] == [42, 42]
    assert [note["error"] for note in notes] == ["'nothing'", "'nothing'"]
    assert notes[1]["used"] < 0.5
    assert max(note["quick"] for note in notes) < 5


@pytest.mark.parametrize("status", [0, 2])
def test_ranks_that_leave_are_not_taken_for_killed_ones(tmp_path, status):
    """Repeated several times, because a launcher loses a rank only occasionally."""
    script = tmp_path / "leave.py"
    script.write_text(f"from granwave.workflows.run.mpi import leave\nleave({status})\n")
    command = [str(BIN / "mpiexec"), "-n", "2", sys.executable, "-m", "mpi4py", str(script)]
    for _ in range(3):
        ended = subprocess.run(command, timeout=120, env=PLAIN, capture_output=True, text=True)
        assert (ended.returncode, ended.stdout, ended.stderr) == (status, "", "")


def test_mpiexec_of_the_environment_or_of_the_path(tmp_path, monkeypatch):
    """The launcher of the site is used if the environment has none; without any, `--np` gives a
    remedy.
    """
    own = tmp_path / "env" / "bin" / "mpiexec"
    site = tmp_path / "site" / "mpiexec"
    for program in (own, site):
        program.parent.mkdir(parents=True)
        program.write_text("#!/bin/sh\n")
        program.chmod(0o755)
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "env"))
    monkeypatch.setenv("PATH", str(site.parent))
    assert mpi.find_mpiexec() == str(own)
    own.unlink()
    assert mpi.command(2, ["run", "fcc-small"])[:3] == [str(site), "-n", "2"]
    site.unlink()
    with pytest.raises(InputError, match=r"no mpiexec in .*env/bin or in PATH; install MPICH"):
        mpi.command(2, ["run", "fcc-small"])


def test_what_a_process_that_is_no_rank_keeps(monkeypatch):
    monkeypatch.setattr(
        os, "environ", {"OMPI_COMM_WORLD_RANK": "1", "PMI_RANK": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1"}
    )
    assert mpi.alone() == {"OMPI_ALLOW_RUN_AS_ROOT": "1"}


def test_runs_in_a_process_that_has_forked_others(tmp_path):
    """A search of designs loads the MPI library without starting it; a run after it starts it."""
    script = tmp_path / "both.py"
    script.write_text(
        textwrap.dedent(
            """
            import granwave as gw
            from granwave.workflows.run import forks, mpi

            forks.load()
            assert mpi.this_process().size == 1
            gw.run("two-spheres", directory="out", figures=False)
            """
        )
    )
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=PLAIN, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "summary.json").is_file()


def test_a_grid_needs_a_brick_for_each_rank():
    case = load_assembly(library.find("fcc-small"), {"run.processors": [2, 1, 4]}).case
    check_processors(case, 8)
    with pytest.raises(
        InputError, match=r"run\.processors: found \[2, 1, 4\], 8 ranks; expected a grid of 2, "
    ):
        check_processors(case, 2)


def granwave(*words) -> None:
    command = [BIN / "granwave", "run", "fcc-small", *words, "--np", "2", "--no-figures"]
    done = subprocess.run(command, env=PLAIN, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.validation
def test_the_division_changes_no_result(tmp_path):
    """Two bricks side by side according to the model, and stacked, when divided again."""
    small = ["--set", "packing.size=[8,8,4]", "--set", "run.end_time=2e-5"]
    small += ["--set", "load.spheres=7"]
    other = ["--set", "run.processors=[1,1,2]", "--set", "run.balance=true"]
    contacts = []
    for name, words in (("one", small), ("other", [*small, *other])):
        out = tmp_path / name
        granwave(*words, "-o", out)
        log = (out / "log.lammps").read_text()
        assert ("1 by 1 by 2 MPI processor grid" in log) == (name == "other")
        with h5py.File(out / "result.h5") as file:
            contacts.append({key: values[...] for key, values in file["contacts"].items()})
    assert contacts[0].keys() == contacts[1].keys()
    for key, values in contacts[0].items():
        np.testing.assert_array_equal(values, contacts[1][key], err_msg=key)
    granwave(*small, "-o", tmp_path / "other", "--resume")


def test_the_box_is_divided_again_on_request(tmp_path):
    for balance in (False, True):
        case = load_case(library.find("fcc-small"), {"run.balance": balance})
        script = write_deck(case, tmp_path / str(balance)).script.read_text()
        assert ("comm_style      tiled" in script) == balance
        assert bool(re.search(r"(?m)^fix +balance all balance 5\d\d 1\.1 rcb", script)) == balance


@pytest.mark.parametrize("is_lost", [False, True])
def test_message_of_an_abort_is_never_lost(capfd, tmp_path, is_lost):
    """Launchers may end before they have passed on the last output of the ranks."""
    message = "granwave: LAMMPS: ERROR on proc 0: spheres overlap"
    shown = "" if is_lost else f"echo '{message}' >&2; "
    launcher = tmp_path / "launcher"
    launcher.write_text(
        f"#!/bin/sh\n{shown}echo '{message}' > \"$GRANWAVE_LAST_WORDS_FILE\"; exit 1\n"
    )
    launcher.chmod(0o755)
    assert mpi.launch(2, ["run", "fcc-small"], [str(launcher)]) == 1
    assert capfd.readouterr().err == f"{message}\n"
