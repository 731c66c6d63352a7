"""Fixture `slurm`, to be imported by test modules: a Slurm cluster of two virtual nodes on this
machine.

It is slurmctld, one slurmd a node (`slurmd -N n1`, `-N n2`) and a munged of its own, on local
ports, without accounting; it needs Linux as root (a container will do) and the packages of Debian
12: `apt-get install slurmctld slurmd slurm-client munge`. State and logs are in a temporary
directory. Only /etc/slurm/slurm.conf is outside of it, as job steps read no other file; its first
line marks it as ours and names the directory, and a file without that mark is not changed.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import signal
import socket
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.helpers.programs.processes import wait_for

CONF = Path("/etc/slurm/slurm.conf")
MARK = "# granwave test cluster, state in "
CLUSTER = "granwave-test"
NODES = ("n1", "n2")
CPUS = 2  # per node, independent of the machine
CONTROL_PORT = 16817
NODE_PORT = 17001  # and the subsequent ones
KILL_WAIT = 10  # s between SIGTERM and SIGKILL at a job's time limit
PATIENCE = 30.0  # s for any single step
PROGRAMS = ("slurmctld", "slurmd", "munged", "sinfo", "squeue", "scancel")
PACKAGES = "slurmctld slurmd slurm-client munge"
DAEMONS = ("slurmctld", *(f"slurmd-{node}" for node in NODES), "munged")
WORKING = {"idle", "mixed", "allocated", "completing"}  # states of a node


@pytest.fixture(scope="module")
def slurm() -> Iterator[tuple[str, ...]]:
    """Names of the nodes of a cluster, for the tests of one module at a time; skip if a cluster
    cannot be started on this machine.
    """
    with (Path(tempfile.gettempdir()) / "granwave-test-slurm.turn").open("w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        if reason := _missing():
            pytest.skip(reason)
        _remove()  # what a test that was killed has left
        state = Path(tempfile.mkdtemp(prefix="granwave-slurm-"))
        CONF.parent.mkdir(parents=True, exist_ok=True)
        CONF.write_text(_conf(state))
        try:
            _launch(state)
            wait_for(_is_up, PATIENCE)
            yield NODES
        except TimeoutError as error:
            logs = [
                path.read_text(errors="replace")[-1000:] for path in sorted(state.glob("*.log"))
            ]
            raise RuntimeError(
                "\n--- ".join([f"the nodes are not idle: {_ask('sinfo')}", *logs])
            ) from error
        finally:
            _remove()


def _missing() -> str:
    """Say why no cluster can be started on this machine; empty if one can."""
    if os.geteuid() != 0:
        return "a Slurm for tests has to be started as root"
    if missing := [
        name for name in PROGRAMS if shutil.which(name, path=_environment()["PATH"]) is None
    ]:
        return f"{', '.join(missing)} not found: apt-get install {PACKAGES}"
    if CONF.exists():
        return "" if _state() else f"{CONF} exists and is not of these tests: it stays as it is"
    try:
        socket.gethostbyname(socket.gethostname())
    except OSError:
        return f"the host name {socket.gethostname()!r} has no address: add it to /etc/hosts"
    for port in (CONTROL_PORT, *range(NODE_PORT, NODE_PORT + len(NODES))):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return f"port {port} is in use by another program"
    return ""


def _conf(state: Path) -> str:
    """Text of slurm.conf, with minimal values of all intervals that delay scheduling.

    Processes are tracked by their group: with tracking by parent (linuxproc), those whose parent
    ended at SIGTERM would outlive their job.
    """
    host = socket.gethostname().split(".")[0]
    names = f"{NODES[0][0]}[1-{len(NODES)}]"
    ports = f"[{NODE_PORT}-{NODE_PORT + len(NODES) - 1}]"
    return f"""{MARK}{state}
ClusterName={CLUSTER}
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={CONTROL_PORT}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={state}/munge.socket
CredType=cred/munge
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=pmi2
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
PropagateResourceLimits=NONE
ReturnToService=2
MinJobAge=86400
KillWait={KILL_WAIT}
StateSaveLocation={state}/slurmctld
SlurmdSpoolDir={state}/slurmd-%n
SlurmctldPidFile={state}/slurmctld.pid
SlurmdPidFile={state}/slurmd-%n.pid
SlurmctldLogFile={state}/slurmctld.log
SlurmdLogFile={state}/slurmd-%n.log
NodeName={names} NodeHostname={host} NodeAddr=127.0.0.1 Port={ports} CPUs={CPUS} RealMemory=4000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def _launch(state: Path) -> None:
    key = state / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(os.urandom(1024))
    files = {"key": "munge.key", "pid": "munged.pid", "log": "munged.log", "seed": "munged.seed"}
    own = [f"--{name}-file={state}/{file}" for name, file in files.items()]
    _run("munged", "--force", f"--socket={state}/munge.socket", *own)
    wait_for((state / "munge.socket").exists, PATIENCE)
    _run("slurmctld", "-i")
    for node in NODES:
        _run("slurmd", "-N", node)


def _run(*command: str) -> None:
    """Run a program that detaches itself to the background."""
    with tempfile.TemporaryFile("w+") as said:  # not a pipe: the daemon would keep it open
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=said,
            timeout=PATIENCE,
            env=_environment(),
            cwd="/",
        )
        said.seek(0)
        assert done.returncode == 0, f"{' '.join(command)}: {said.read().strip()}"


def _ask(*command: str) -> str:
    """Output of a Slurm client, "" if it fails."""
    with contextlib.suppress(subprocess.SubprocessError):
        return subprocess.run(
            command,
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            env=_environment(),
            check=True,
        ).stdout
    return ""


def _is_up() -> bool:
    return [
        state in WORKING for state in _ask("sinfo", "--noheader", "--Node", "--format=%T").split()
    ] == [True] * 2


def _remove() -> None:
    """Undo a complete or incomplete start."""
    state = _state()
    if state is None:
        return
    _ask("scancel", "--partition=main")
    with contextlib.suppress(TimeoutError):
        wait_for(lambda: not _ask("squeue", "--noheader").strip(), 2.0 * KILL_WAIT)
    for number in (signal.SIGTERM, signal.SIGKILL):
        for process in filter(None, (_process(state, name) for name in DAEMONS)):
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, number)
        with contextlib.suppress(TimeoutError):
            wait_for(lambda: not any(_process(state, name) for name in DAEMONS), 10.0)
            break
    mark = f"SLURM_CLUSTER_NAME={CLUSTER}".encode()
    for process in Path("/proc").glob(
        "[0-9]*"
    ):  # jobs, and their steps, which would try to reach slurmctld for minutes
        with contextlib.suppress(OSError):
            step = (process / "exe").readlink().name.startswith("slurmstepd") and (
                process / "cwd"
            ).readlink() == state
            if step or mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)
    CONF.unlink()
    shutil.rmtree(state, ignore_errors=True)


def _process(state: Path, name: str) -> int | None:
    """Process of one of our daemons, None if it has ended: the number in the pid file must still
    belong to that program.
    """
    try:
        number = int((state / f"{name}.pid").read_text())
        program = (
            Path(f"/proc/{number}/cmdline").read_bytes().partition(b"\0")[0].decode()
        )  # empty for a zombie
    except (OSError, ValueError):
        return None
    return number if Path(program).name == name.split("-")[0] else None


def _state() -> Path | None:
    """State directory of the cluster that slurm.conf describes, None without a slurm.conf that
    these tests wrote.
    """
    with contextlib.suppress(OSError):
        first = CONF.read_text().partition("\n")[0]
        return Path(first.removeprefix(MARK)) if first.startswith(MARK) else None
    return None


def _environment() -> dict[str, str]:
    """Environment of this process without variables that select another cluster or output format of
    Slurm.
    """
    theirs = ("SLURM_", "SLURMD_", "SLURMCTLD_", "SINFO_", "SQUEUE_", "SCANCEL_")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(theirs)}
    return kept | {
        "PATH": os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])
    }
