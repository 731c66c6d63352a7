"""The launcher, any number of ranks, and ranks that leave."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import textwrap

import pytest

from granwave.lammps_inputs.errors import InputError
from granwave.workflows.run import mpi
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
        InputError, match=r"--np 49: found 49 ranks on 2 cores, expected .* give --np 2"
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
    """They wait without use of the processor, get the result or the error, and lose no time in
    short work.
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
    """Several times, as a launcher that loses a rank does so now and then."""
    script = tmp_path / "leave.py"
    script.write_text(f"from granwave.workflows.run.mpi import leave\nleave({status})\n")
    command = [str(BIN / "mpiexec"), "-n", "2", sys.executable, "-m", "mpi4py", str(script)]
    for _ in range(3):
        ended = subprocess.run(command, timeout=120, env=PLAIN, capture_output=True, text=True)
        assert (ended.returncode, ended.stdout, ended.stderr) == (status, "", "")


def test_mpiexec_of_the_environment_or_of_the_path(tmp_path, monkeypatch):
    """A site's own is taken where the environment has none; without any, `--np` says what to do."""
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
    with pytest.raises(InputError, match=r"no mpiexec in .*env/bin or in PATH; pip install mpich"):
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
