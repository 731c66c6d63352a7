"""Fixture `grid_engine`, to be imported by test modules: a Grid Engine of one node on this machine.

It is sge_qmaster and sge_execd on local ports, with their files in a temporary directory; it needs
Linux as root and the packages of Debian 12: `apt-get install gridengine-master gridengine-exec
gridengine-client`.
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

INSTALLED = Path("/var/lib/gridengine")
SHARED = Path("/usr/share/gridengine")
PROGRAMS = ("sge_qmaster", "sge_execd", "qconf", "qsub", "qstat", "qdel", "qacct")
PACKAGES = "gridengine-master gridengine-exec gridengine-client"
PORTS = {"SGE_QMASTER_PORT": "16444", "SGE_EXECD_PORT": "16445"}
SLOTS = 4
PARALLEL = "mpi"  # parallel environment
PATIENCE = 30.0  # s for any single step
BOOTSTRAP = """Version: 6.2
admin_user none
default_domain none
ignore_fqdn false
spooling_method berkeleydb
spooling_lib libspoolb
spooling_params {root}/spool
binary_path /usr/sbin
qmaster_spool_dir {root}/qmaster
security_mode none
listener_threads 2
worker_threads 2
scheduler_threads 1
"""
ENVIRONMENT = f"""pe_name {PARALLEL}
slots {SLOTS}
user_lists NONE
xuser_lists NONE
start_proc_args NONE
stop_proc_args NONE
allocation_rule $fill_up
control_slaves TRUE
job_is_first_task FALSE
urgency_slots min
accounting_summary FALSE
qsort_args NONE
"""
QUEUE = {
    "qname": "main.q",
    "hostlist": "@allhosts",
    "slots": SLOTS,
    "pe_list": PARALLEL,
    "shell": "/bin/bash",
    "load_thresholds": "NONE",
}
SCHEDULE = {"schedule_interval": "0:0:1", "flush_submit_sec": "1", "flush_finish_sec": "1"}


@pytest.fixture(scope="module")
def grid_engine() -> Iterator[dict[str, str]]:
    """Environment of the commands of a cluster; skip if a cluster cannot be started on this
    machine.
    """
    with (Path(tempfile.gettempdir()) / "granwave-test-gridengine.turn").open("w") as turn:
        fcntl.flock(turn, fcntl.LOCK_EX)
        if reason := _missing():
            pytest.skip(reason)
        root = Path(tempfile.mkdtemp(prefix="granwave-sge-"))
        environment = {**os.environ, "SGE_ROOT": str(root), "SGE_CELL": "default", **PORTS}
        try:
            _launch(root, environment)
            yield environment
        finally:
            _remove(root, environment)


def _missing() -> str:
    """Say why no cluster can be started on this machine; empty if one can."""
    if os.geteuid() != 0:
        return "a Grid Engine for tests has to be started as root"
    if missing := [name for name in PROGRAMS if shutil.which(name) is None]:
        return f"{', '.join(missing)} not found: apt-get install {PACKAGES}"
    for port in PORTS.values():
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", int(port))) == 0:
                return f"port {port} is in use by another program"
    return ""


def _launch(root: Path, environment: dict[str, str]) -> None:
    for name in ("bin", "lib", "util", "utilbin"):
        shutil.copytree(INSTALLED / name, root / name, symlinks=True)
    common = root / "default" / "common"
    for folder in (common, root / "spool", root / "qmaster", root / "execd"):
        folder.mkdir(parents=True)
    host = socket.gethostname()
    (common / "bootstrap").write_text(BOOTSTRAP.format(root=root))
    (common / "act_qmaster").write_text(f"{host}\n")
    (common / "host_aliases").write_text(f"{host} localhost\n")
    _initialise(root, environment)
    run = _runner(root, environment)
    run("sge_qmaster")
    wait_for(lambda: run("qconf", "-sh", check=False).returncode == 0, PATIENCE)
    run("qconf", "-as", host)
    run("sge_execd")
    wait_for(lambda: host in run("qconf", "-sel", check=False).stdout, PATIENCE)
    schedule = _with(run("qconf", "-ssconf").stdout, SCHEDULE)
    run("qconf", "-Msconf", _file(root / "schedule", schedule))
    run("qconf", "-Ap", _file(root / "pe", ENVIRONMENT))
    hosts = f"group_name @allhosts\nhostlist {host}\n"
    run("qconf", "-Ahgrp", _file(root / "hosts", hosts))
    run("qconf", "-Aq", _file(root / "queue", _with(run("qconf", "-sq").stdout, QUEUE)))


def _initialise(root: Path, environment: dict[str, str]) -> None:
    """Make the data base of the qmaster: root may submit jobs, which keep their files here."""
    own = {"execd_spool_dir": root / "execd", "min_uid": 0, "min_gid": 0}
    usual = (SHARED / "default-configuration").read_text()
    configuration = _file(root / "configuration", _with(usual, own))
    run = _runner(root, environment)
    programs = "/usr/lib/gridengine"
    run(f"{programs}/spoolinit", "berkeleydb", "libspoolb", f"{root}/spool", "init")
    resources = SHARED / "util" / "resources"
    for what, source in (
        ("configuration", configuration),
        ("complexes", f"{resources}/centry"),
        ("usersets", f"{resources}/usersets"),
        ("managers", "root"),
    ):
        run(f"{programs}/spooldefaults", what, source)


def _runner(root, environment):
    """Function that runs a program in the environment of the cluster."""

    def run(*command: str, check: bool = True) -> subprocess.CompletedProcess[str]:
        with tempfile.TemporaryFile("w+") as said:  # not a pipe: a daemon would keep it open
            done = subprocess.run(
                command, env=environment, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                timeout=PATIENCE, cwd=root,
            )  # fmt: skip
            said.seek(0)
            text = said.read()
        assert not check or done.returncode == 0, f"{' '.join(command)}: {text}"
        return subprocess.CompletedProcess(command, done.returncode, text)

    return run


def _with(text: str, values: dict[str, object]) -> str:
    """Return the text of a configuration with some values replaced."""
    rows = []
    for line in text.splitlines():
        key = line.partition(" ")[0].strip()
        rows.append(f"{key} {values[key]}" if key in values else line)
    return "\n".join(rows) + "\n"


def _file(path: Path, text: str) -> str:
    path.write_text(text)
    return str(path)


def _remove(root: Path, environment: dict[str, str]) -> None:
    """Cancel all jobs and end the daemons of this cluster."""
    with contextlib.suppress(subprocess.SubprocessError, OSError):
        subprocess.run(
            ["qdel", "-f", "-u", "*"], env=environment, capture_output=True, timeout=PATIENCE
        )
    for process in _daemons(root):
        with contextlib.suppress(ProcessLookupError):
            os.kill(process, signal.SIGTERM)
    with contextlib.suppress(TimeoutError):
        wait_for(lambda: not _daemons(root), 10.0)
    shutil.rmtree(root, ignore_errors=True)


def _daemons(root: Path) -> list[int]:
    """Processes of the daemons of this cluster."""
    mark = f"SGE_ROOT={root}".encode()
    processes = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            name = (process / "comm").read_text().strip()
            if name.startswith("sge_") and mark in (process / "environ").read_bytes().split(b"\0"):
                processes.append(int(process.name))
    return processes
