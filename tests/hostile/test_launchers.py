"""MPI in surroundings that stop it: batch systems without their commands, launchers that hang,
variables and limits with which the library cannot start.
"""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from granwave.workflows.run.launchers import of_this_machine, start_fault
from tests.conftest import BIN, PLAIN
from tests.helpers.programs.processes import wait_for
from tests.hostile.rows import faults_in

TINY = ["fcc-small", "--set", "packing.size=[4,4,3]", "--set", "run.end_time=2e-5"]
TINY += ["--set", "run.frames=5", "--no-figures"]
JOB = {
    "SLURM_JOB_ID": "5",
    "SLURM_JOBID": "5",
    "SLURM_NODELIST": os.uname().nodename,
    "SLURM_NNODES": "1",
    "SLURM_TASKS_PER_NODE": "2",
}
LAUNCH = """
import sys
from granwave.workflows.run import launchers, mpi
launchers._PATIENCE = 1.0  # s, in place of 5
sys.exit(mpi.launch(2, ['cases'], sys.argv[1:]))
"""
YIELD = "MPIR_CVAR_POLLS_BEFORE_YIELD"
DEAF = "#!/bin/sh\ntrap '' TERM INT\ntouch $0.started\nwhile true; do sleep 0.1; done\n"


def run(*words: str, timeout: float = 60, **how: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [BIN / "granwave", *words], capture_output=True, text=True, timeout=timeout, **how
    )


@pytest.mark.parametrize(
    "bootstrap",
    [
        pytest.param({}, marks=pytest.mark.validation),
        pytest.param({"HYDRA_LAUNCHER": "ssh"}, marks=pytest.mark.validation),
        {"HYDRA_BOOTSTRAP": "slurm"},
    ],
)
def test_ranks_inside_a_job_without_srun(tmp_path: Path, bootstrap: dict[str, str]) -> None:
    environment = {**PLAIN, **JOB, **bootstrap, "PATH": f"{BIN}:/usr/bin:/bin"}
    done = run("run", *TINY, "--np", "2", "-o", str(tmp_path / "run"), env=environment)
    assert done.returncode == 0, done.stderr


def test_doctor_inside_a_job_without_srun() -> None:
    done = run("doctor", env={**PLAIN, **JOB})
    assert "ok    MPI ranks" in done.stdout


def test_environment_of_ranks_of_this_machine() -> None:
    found = of_this_machine({**JOB, "SLURMD_NODENAME": "n1", "HYDRA_LAUNCHER": "slurm", "A": "b"})
    assert found == {
        "SLURMD_NODENAME": "n1",
        "A": "b",
        "HYDRA_LAUNCHER": "fork",
        "HYDRA_BOOTSTRAP": "fork",
        "HYDRA_RMK": "user",
        YIELD: "1",
    }
    assert of_this_machine({YIELD: "1000"})[YIELD] == "1000"


@pytest.fixture
def deaf(tmp_path: Path) -> Path:
    """Launcher that starts no ranks, and that no signal but SIGKILL ends."""
    path = tmp_path / "mpiexec"
    path.write_text(DEAF)
    path.chmod(0o755)
    return path


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize(("times", "longest"), [(1, 5.0), (2, 2.0)])
def test_launcher_that_hangs(deaf: Path, number: int, times: int, longest: float) -> None:
    command = [sys.executable, "-c", LAUNCH, str(deaf)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=PLAIN) as process:
        wait_for(Path(f"{deaf}.started").exists, 60)
        time.sleep(0.2)
        begin = time.monotonic()
        for _ in range(times):
            process.send_signal(number)
            time.sleep(0.3)
        _, errors = process.communicate(timeout=20)
    assert time.monotonic() - begin < longest
    assert process.returncode == 130
    assert faults_in(errors) == [f"granwave: stopped; the launcher {deaf} was ended"]
    assert not subprocess.run(["pgrep", "-f", str(deaf)], capture_output=True, check=False).stdout


NO_SETTINGS_OF_MPI = {key: value for key, value in PLAIN.items() if not key.startswith("MPIR_")}


def small_files() -> None:
    resource.setrlimit(resource.RLIMIT_FSIZE, (2**20, 2**20))


@pytest.mark.parametrize(
    ("variables", "limit", "expected"),
    [
        ({"PMIX_RANK": "0"}, None, "PMIX_RANK=0 is set, as by srun --mpi=pmix"),
        ({"PMI_FD": "77"}, None, "PMI_FD=77 is not (or no longer) a connection to a launcher"),
        (
            {"PMI_FD": "77", "PMI_RANK": "0", "PMI_SIZE": "2"},
            None,
            "PMI_FD=77 is not (or no longer) a connection to a launcher",
        ),
        (
            {"PMI_PORT": "127.0.0.1:1", "PMI_ID": "0"},
            None,
            "no launcher answers at PMI_PORT=127.0.0.1:1",
        ),
        ({"UCX_TLS": "none-such"}, None, "UCX_TLS=none-such may be the reason; unset it"),
        ({}, small_files, "the size of files is limited to 1024 kB"),
    ],
)
def test_library_that_cannot_start(
    tmp_path: Path, variables: dict[str, str], limit: Any, expected: str
) -> None:
    environment = NO_SETTINGS_OF_MPI | variables
    done = run("run", *TINY, "-o", str(tmp_path / "run"), env=environment, preexec_fn=limit)
    faults = faults_in(done.stderr)
    assert done.returncode == 1, done.stderr
    assert len(faults) == 1
    assert faults[0].startswith(f"granwave: MPI cannot be started: {expected}")


def test_several_ranks_that_cannot_start(tmp_path: Path) -> None:
    environment = NO_SETTINGS_OF_MPI | {"UCX_TLS": "none-such"}
    done = run("run", *TINY, "--np", "2", "-o", str(tmp_path / "run"), env=environment)
    faults = faults_in(done.stderr)
    assert done.returncode == 1, done.stderr
    assert len(faults) == 1
    assert "UCX_TLS=none-such may be the reason; unset it" in faults[0]


def test_start_fault_without_a_suspect() -> None:
    assert start_fault({}).endswith("granwave doctor checks the installation")
    assert start_fault(of_this_machine({})) == start_fault({})
