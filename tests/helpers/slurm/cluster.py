"""Slurm cluster of two virtual nodes for tests of scans: `python tests/helpers/slurm/cluster.py start|status|stop`.

It consists of slurmctld, one slurmd per node (`slurmd -N n1`, `-N n2`) and a separate munged, on local ports, without accounting. It
requires Linux as root (a container is sufficient) and the packages of Debian 12: `apt-get install slurmctld slurmd slurm-client munge`.
State and logs are in one directory: the one given with `--state`, or a new temporary one. Only /etc/slurm/slurm.conf is outside of it,
as job steps read no other file; its first line marks it as ours and contains the directory, and a file without that mark is not changed.

Exit codes: 0 success (`status`: up), 1 failure, 3 (`status`) down, 77 the cluster is not possible on this machine.
"""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

CONF = Path("/etc/slurm/slurm.conf")
LOCK = Path("/run/granwave-test-slurm.lock")
MARK = "# granwave test cluster, state in "
CLUSTER = "granwave-test"
PARTITION = "main"
NODES = ("n1", "n2")
CPUS = 2  # per node, independent of the machine
CONTROL_PORT = 16817
NODE_PORT = 17001  # and the subsequent ones
KILL_WAIT = 10  # s between SIGTERM and SIGKILL at a job's time limit
PATIENCE = 30.0  # s for any single step
PROGRAMS = ("slurmctld", "slurmd", "munged", "sinfo", "squeue", "scancel")
PACKAGES = "slurmctld slurmd slurm-client munge"
DAEMONS = ("slurmctld", *(f"slurmd-{node}" for node in NODES), "munged")
CANNOT, DOWN = 77, 3


class CannotError(RuntimeError):
    """Cluster that is not possible on this machine; nothing was changed."""


def start(state: Path | None = None) -> Path:
    """Start the cluster and wait until all nodes are idle.

    Parameters
    ----------
    state
        Directory for state and logs, created if missing; None creates a temporary one.

    Returns
    -------
    Path
        Directory in use: that of a cluster of ours that is already running, if any.

    Raises
    ------
    CannotError
        Not root, missing programs, another slurm.conf or Slurm, or a host name that does not resolve.
    RuntimeError
        A daemon failed or the nodes did not become idle in time; the message contains the last lines of the logs.
    """
    _check_machine()
    with _lock():
        if is_up():
            return _state()
        _remove()
        state = Path(tempfile.mkdtemp(prefix="granwave-slurm-")) if state is None else state.resolve()
        state.mkdir(parents=True, exist_ok=True)
        CONF.parent.mkdir(parents=True, exist_ok=True)
        CONF.write_text(_conf(state))
        try:
            _launch(state)
            _wait(is_up, f"nodes {', '.join(NODES)} to be idle; sinfo says:\n{_nodes()}")
        except RuntimeError as error:
            logs = _logs(state)
            _remove()
            raise RuntimeError(f"{error}\n{logs}") from error
        return state


def stop() -> bool:
    """Cancel all jobs, stop the daemons, and remove slurm.conf and their files; False if there was nothing to stop."""
    with _lock():
        return _remove()


def is_up() -> bool:
    """True if our cluster responds and all of its nodes accept jobs."""
    state = _state()
    if state is None or not all(_pid(state, name) for name in DAEMONS):
        return False
    states = [line.split()[1] for line in _nodes().splitlines() if len(line.split()) == 2]
    return len(states) == len(NODES) and all(state in ("idle", "mixed", "allocated", "completing") for state in states)


def _check_machine() -> None:
    if os.geteuid() != 0:
        raise CannotError("a Slurm for tests has to be started as root")
    missing = [name for name in PROGRAMS if shutil.which(name, path=_path()) is None]
    if missing:
        raise CannotError(f"{', '.join(missing)} not found: apt-get install {PACKAGES}")
    if CONF.exists() and _state() is None:
        raise CannotError(f"{CONF} exists and is not of these tests: it stays as it is")
    try:
        socket.gethostbyname(socket.gethostname())
    except OSError:
        raise CannotError(f"the host name {socket.gethostname()!r} has no address: add it to /etc/hosts") from None
    if _state() is None:
        for port in (CONTROL_PORT, *(NODE_PORT + i for i in range(len(NODES)))):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", port)) == 0:
                    raise CannotError(f"port {port} is in use by another program")


def _conf(state: Path) -> str:
    """Text of slurm.conf, with minimal values of all intervals that delay scheduling.

    Processes are tracked by their group: with tracking by parent (linuxproc), those whose parent ended at SIGTERM would outlive
    their job.
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
PartitionName={PARTITION} Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def _launch(state: Path) -> None:
    key = state / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(os.urandom(1024))
    own = [f"--{name}={state}/{file}" for name, file in (("key-file", key.name), ("socket", "munge.socket"))]
    own += [
        f"--{name}={state}/munged.{end}"
        for name, end in (("pid-file", "pid"), ("log-file", "log"), ("seed-file", "seed"))
    ]
    _run("munged", "--force", *own)
    _wait((state / "munge.socket").exists, "munged's socket")
    _run("slurmctld", "-i")
    for node in NODES:
        _run("slurmd", "-N", node)


def _run(*command: str) -> None:
    """Run a program that detaches itself to the background."""
    with tempfile.TemporaryFile("w+") as said:  # not a pipe: the daemon would keep it open
        code = subprocess.run(
            command, stdin=subprocess.DEVNULL, stdout=said, stderr=said, timeout=PATIENCE, env=_environment(), cwd="/"
        ).returncode
        said.seek(0)
        if code != 0:
            raise RuntimeError(f"{' '.join(command)} ended with exit code {code}: {said.read().strip()}")


def _ask(*command: str) -> str:
    """Output of a Slurm client, "" if it fails."""
    try:
        run = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, env=_environment())
    except subprocess.TimeoutExpired:
        return ""
    return run.stdout if run.returncode == 0 else ""


def _nodes() -> str:
    """One line "name state" per node."""
    return _ask("sinfo", "--noheader", "--Node", "--format=%N %T")


def _remove() -> bool:
    """Undo a complete or partial `start`."""
    state = _state()
    if state is None:
        return False
    if all(_pid(state, name) for name in DAEMONS):
        _ask("scancel", f"--partition={PARTITION}")
        _kill_jobs()
        with contextlib.suppress(RuntimeError):
            _wait(lambda: not _ask("squeue", "--noheader", "--format=%i").strip(), "jobs to end")
    for sign in (signal.SIGTERM, signal.SIGKILL):
        for name in DAEMONS:
            if pid := _pid(state, name):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, sign)
        with contextlib.suppress(RuntimeError):
            _wait(lambda: not any(_pid(state, name) for name in DAEMONS), "the daemons to end", patience=10.0)
            break
    _kill_jobs()  # jobs that slurmctld could not cancel because it had ended
    _kill_steps(state)
    for daemon in ("slurmctld", *(f"slurmd-{node}" for node in NODES)):
        shutil.rmtree(state / daemon, ignore_errors=True)
    for pattern in ("*.pid", "munge.*", "munged.seed"):
        for path in state.glob(pattern):
            path.unlink(missing_ok=True)
    CONF.unlink()
    if state.name.startswith("granwave-slurm-"):  # the temporary directory of `start`
        shutil.rmtree(state, ignore_errors=True)
    return True


def _pid(state: Path, name: str) -> int | None:
    """Process of a daemon of ours, None if it has ended: the number in the pid file must still belong to that program."""
    try:
        pid = int((state / f"{name}.pid").read_text())
        program = Path(f"/proc/{pid}/cmdline").read_bytes().partition(b"\0")[0].decode()  # empty for a zombie
    except (OSError, ValueError):
        return None
    return pid if Path(program).name == name.split("-")[0] else None


def _kill_jobs() -> None:
    """Send SIGKILL to processes started by jobs of ours, identified by the name of the cluster in their environment."""
    mark = f"SLURM_CLUSTER_NAME={CLUSTER}".encode()
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if mark in (process / "environ").read_bytes().split(b"\0"):
                os.kill(int(process.name), signal.SIGKILL)


def _kill_steps(state: Path) -> None:
    """Send SIGKILL to slurmstepd processes in our directory, which would otherwise try to reach slurmctld for minutes."""
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if (process / "exe").readlink().name.startswith("slurmstepd") and (process / "cwd").readlink() == state:
                os.kill(int(process.name), signal.SIGKILL)


def _state() -> Path | None:
    """State directory of the cluster that slurm.conf describes, None without a slurm.conf of ours."""
    try:
        first = CONF.read_text().partition("\n")[0]
    except OSError:
        return None
    return Path(first.removeprefix(MARK)) if first.startswith(MARK) else None


def _logs(state: Path, lines: int = 8) -> str:
    ends = []
    for path in sorted(state.glob("*.log")):
        ends += [f"--- {path.name}", *path.read_text(errors="replace").splitlines()[-lines:]]
    return "\n".join(ends)


def _wait(condition: Callable[[], bool], what: str, patience: float = PATIENCE) -> None:
    end = time.monotonic() + patience
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError(f"waited {patience:g} s for {what}")
        time.sleep(0.1)


def _path() -> str:
    return os.pathsep.join([os.environ.get("PATH", os.defpath), "/usr/sbin", "/sbin"])


def _environment() -> dict[str, str]:
    """Environment of this process without variables that select another cluster or output format of Slurm."""
    ours = ("SLURM_", "SLURMD_", "SLURMCTLD_", "SINFO_", "SQUEUE_", "SCANCEL_")
    return {name: value for name, value in os.environ.items() if not name.startswith(ours)} | {"PATH": _path()}


@contextlib.contextmanager
def _lock() -> Iterator[None]:
    """Lock that allows one start or stop at a time on this machine."""
    try:
        file = LOCK.open("w")
    except OSError as error:
        raise CannotError(f"cannot write {LOCK}: {error.strerror}") from error
    with file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description="A Slurm of two virtual nodes on this machine, for tests.")
    parser.add_argument("action", choices=("start", "status", "stop"))
    parser.add_argument(
        "--state", type=Path, metavar="DIR", help="directory for state and logs (default: a temporary one)"
    )
    options = parser.parse_args(arguments)
    try:
        if options.action == "start":
            was_up = is_up()
            print(f"{'already up' if was_up else 'up'}, state in {start(options.state)}")
        elif options.action == "stop":
            print("stopped" if stop() else "nothing to stop")
        elif is_up():
            print(f"up, state in {_state()}\n{_nodes()}", end="")
        else:
            print("down")
            return DOWN
    except CannotError as error:
        print(error, file=sys.stderr)
        return CANNOT
    except (RuntimeError, OSError, subprocess.SubprocessError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
