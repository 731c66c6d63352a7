"""Snakemake as a subprocess: runs the jobs of a scan locally or on a cluster, and retries killed jobs once."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Sequence
from importlib import util
from pathlib import Path
from typing import Any

from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import available_memory, replace_text
from granwave.lammps_inputs.run_directory import SCAN_WORK
from granwave.workflows.run import mpi
from granwave.workflows.scanning import layout
from granwave.workflows.scanning.batches import Batch
from granwave.workflows.scanning.slurm import Profile

LOCAL, SLURM = "local", "slurm"
EXECUTORS = (LOCAL, SLURM)
_REFUSALS = (  # in the log of Snakemake
    re.compile(r"(SLURM-job '\d+' failed, SLURM status is: '\w+')"),
    re.compile(r"Job submission failed with exception: (.*?)(?:For further error details|$)", re.MULTILINE),
    re.compile(r"sbatch failed\. The error message was '(.*?)'\.?$", re.MULTILINE | re.DOTALL),
)
#: Options of sbatch that Snakemake takes as resources, with their names.
_RESOURCES = {"--constraint": "constraint", "-C": "constraint", "--qos": "qos", "-q": "qos", "--gres": "gres"}
_LEAST_MINUTES = 10  # shortest default time limit
_WARNING = 90  # s before the time limit at which points write checkpoints
_SNAKEFILE = Path(__file__).with_name("Snakefile")


def check_installed(executor: str) -> None:
    """Raise InputError if Snakemake, or its plugin for an executor, is missing."""
    if util.find_spec("snakemake") is None:
        raise InputError("granwave scan: Snakemake is not installed; pip install 'granwave[scan]'")
    if executor == SLURM and util.find_spec("snakemake_executor_plugin_slurm") is None:
        raise InputError("--executor slurm: Snakemake's plugin is not installed; pip install 'granwave[scan]'")


class Engine:
    """One round of jobs.

    Parameters
    ----------
    name, directory
        Name and directory of the scan.
    batches
        Batches of points, the longest first.
    jobs
        Number of simultaneous jobs (local: cores).
    profile
        Profile of the cluster; None for this machine.
    """

    def __init__(
        self, name: str, directory: Path, batches: Sequence[Batch], *, jobs: int, profile: Profile | None
    ) -> None:
        self.name, self.directory, self.profile = name, directory, profile
        round_name = batches[0].id.split("x")[0]
        plan = directory / SCAN_WORK / f"jobs-{round_name}.json"
        replace_text(plan, json.dumps(self._plan(batches)))
        self.log = directory / layout.LOGS / f"snakemake-{round_name}.log"
        command = [
            *mpi.PYTHON, "-m", "snakemake", "--workflow-profile", "none",
            "--snakefile", str(_SNAKEFILE), "--directory", str(directory),
            "--config", f"jobs={plan.relative_to(directory)}",
            "--keep-going", "--retries", "1", "--nolock", "--rerun-incomplete",
            "--rerun-triggers", "mtime", "--scheduler", "greedy",
            "--nocolor", "--latency-wait", "30",
            # prioritise the longest, so that no worker waits long for the last one
            "--prioritize", *(f"{layout.DONE}/{batch.id}" for batch in batches[: min(len(batches) // 2 + 1, 500)]),
            *self._executor(jobs, batches),
        ]  # fmt: skip
        environment = {**mpi.alone(), "OMP_NUM_THREADS": "1", mpi.SAFE_PATH: "1"}  # of its jobs too
        environment.pop("SNAKEMAKE_PROFILE", None)
        if profile is None:
            environment[layout.DRIVER] = str(os.getpid())
        with self.log.open("ab") as log:
            # a new session: Ctrl-C reaches only the driver, which stops the jobs with checkpoints
            self._process = subprocess.Popen(
                command, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True
            )

    def refusal(self) -> str:
        """Return why a job could not be submitted, from sbatch or Snakemake; empty if all were."""
        text = self.log.read_text(encoding="utf-8", errors="replace")
        found = [match[1] for pattern in _REFUSALS for match in pattern.finditer(text)]
        lines = [line.removeprefix("sbatch: error: ").strip(" .'") for line in found[-1].splitlines()] if found else []
        return "; ".join(dict.fromkeys(filter(None, lines)))

    def running(self) -> bool:
        """Return True while jobs are running or pending."""
        return self._process.poll() is None

    def drain(self) -> None:
        """Start no further job; Snakemake ends after the running ones."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(self._process.pid, signal.SIGTERM)

    def kill(self) -> None:
        """Kill Snakemake; jobs on a cluster continue."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()

    def _plan(self, batches: Sequence[Batch]) -> dict[str, object]:
        jobs = {
            batch.id: {
                "threads": batch.ranks,
                "resources": {
                    "mem_mb": int(batch.memory / 1e6) + 1,
                    **(resources_of(self.profile, batch) if self.profile else {}),
                },
            }
            for batch in batches
        }
        before = self.profile.before.replace("{", "{{").replace("}", "}}") + "\n" if self.profile else ""
        return {"python": sys.executable, "before": before, "jobs": jobs}

    def _executor(self, jobs: int, batches: Sequence[Batch]) -> list[str]:
        if self.profile is not None:
            return ["--executor", "slurm", "--jobs", str(jobs), *_snakemake_options(self.profile, self.name)]
        memory = max(available_memory(), max(batch.memory for batch in batches))
        return ["--cores", str(jobs), "--resources", f"mem_mb={int(memory / 1e6) + 1}"]


def resources_of(profile: Profile, batch: Batch) -> dict[str, Any]:
    """Return the resources of a job for Snakemake's Slurm plugin."""
    minutes = profile.time or max(_LEAST_MINUTES, math.ceil(max(3 * batch.wall_time, batch.longest) / 60))
    # signal before the limit, to the job steps and not to the shell, which would end at once
    warning = min(_WARNING, minutes * 60 // 3)
    resources, options = _split(profile.options)
    found: dict[str, Any] = {
        "runtime": minutes,
        "mem_mb": profile.memory or math.ceil(batch.memory / 1e6),
        "slurm_extra": " ".join([f"--signal=TERM@{warning}", *map(shlex.quote, options)]),
        **resources,
    }
    if batch.ranks > 1:
        found |= {"mpi": "srun", "tasks": batch.ranks, "nodes": _nodes_of(profile, batch)}
    return found


def _nodes_of(profile: Profile, batch: Batch) -> int:
    """Return the number of nodes for the ranks of a batch."""
    return min(profile.nodes, batch.ranks)


def launcher_of(profile: Profile, batch: Batch) -> list[str]:
    """Return the command that starts the ranks of a point."""
    words = profile.launcher.split()
    return [*words, "-N", str(_nodes_of(profile, batch))] if words[0] == "srun" else words


def _snakemake_options(profile: Profile, name: str) -> list[str]:
    """Return the options of Snakemake for this cluster and the scan ``name``."""
    defaults = [
        *([f"slurm_partition={profile.partition}"] if profile.partition else []),
        *([f"slurm_account={profile.account}"] if profile.account else []),
    ]
    return [
        "--slurm-status-command", profile.status,
        "--slurm-init-seconds-before-status-checks", "5",
        "--seconds-between-status-checks", "5",
        "--slurm-jobname-prefix", "granwave-" + re.sub(r"[^A-Za-z0-9]", "", name),
        "--slurm-logdir", str(layout.LOGS),
        "--slurm-delete-logfiles-older-than", "0",
        *(["--default-resources", *defaults] if defaults else []),
    ]  # fmt: skip


def _split(options: str) -> tuple[dict[str, str], list[str]]:
    """Separate options that Snakemake takes as resources from the others."""
    resources, others = {}, []
    words = iter(shlex.split(options))
    for word in words:
        name, _, value = word.partition("=")
        if name in _RESOURCES:
            resources[_RESOURCES[name]] = value or next(words, "")
        else:
            others.append(word)
    return resources, others
