"""Profile of a cluster: the file of ``granwave scan --executor slurm --profile FILE``."""

from __future__ import annotations

import dataclasses
import math
import re
import shlex
from pathlib import Path
from typing import Any, Literal, Protocol

from granwave.lammps_inputs.case.schema import (
    ErrorList,
    ValidationError,
    choice,
    custom,
    number,
    read_table,
    text,
    whole,
)
from granwave.lammps_inputs.errors import InputError
from granwave.lammps_inputs.files import read_toml
from granwave.workflows.scanning import layout

_LEAST_MINUTES = 10  # shortest default time limit
_WARNING = 90  # s before the time limit at which points write checkpoints


def _positive(value: Any) -> int:
    return whole(value, "a whole number from 1 up")


def _lines(value: Any) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, list) and all(isinstance(line, str) for line in value):
        return "\n".join(value)
    raise ValidationError("shell commands, a string or a list of strings")


#: Options of sbatch that Snakemake takes as resources, with their names.
_RESOURCES = {"--constraint": "constraint", "-C": "constraint", "--qos": "qos", "-q": "qos", "--gres": "gres"}
#: Options that are keys of the profile, and options that granwave sets.
_KEYS = {
    "--partition": "partition", "-p": "partition", "--account": "account", "-A": "account", "--time": "time",
    "-t": "time", "--mem": "memory", "--mem-per-cpu": "memory", "--nodes": "nodes", "-N": "nodes",
}  # fmt: skip
_OURS = (
    "--job-name", "-J", "--output", "-o", "--error", "-e", "--parsable", "--export", "--comment", "--workdir",
    "--chdir", "-D", "--ntasks", "-n", "--cpus-per-task", "-c", "--signal", "--wrap",
)  # fmt: skip


def _options(value: Any) -> str:
    """Parse options of sbatch; refuse those of `_KEYS` and `_OURS`."""
    if not isinstance(value, str):
        raise ValidationError("options of sbatch, a string")
    try:
        words = shlex.split(value)
    except ValueError:  # unbalanced quotation mark
        raise ValidationError("options of sbatch, as in a shell") from None
    for name in (word.partition("=")[0] for word in words):
        if name in _KEYS:
            raise ValidationError(f"no {name}: it is the key slurm.{_KEYS[name]}")
        if name in _OURS:
            raise ValidationError(f"no {name}: granwave gives it to each job")
    return value


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


class Job(Protocol):
    """Size and cost of a job; memory in bytes, times in s."""

    @property
    def ranks(self) -> int:
        """MPI ranks of each point."""

    @property
    def memory(self) -> float:
        """Memory, bytes."""

    @property
    def wall_time(self) -> float:
        """Expected wall time, s."""

    @property
    def longest(self) -> float:
        """Expected wall time if no point ends early, s."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Profile:
    """``[slurm]`` of a profile file."""

    partition: str | None = text("partition to submit to", default=None)
    account: str | None = text("account to charge", default=None)
    time: int | None = custom(
        "time limit of a job, minutes; default: thrice the expected time", _positive, default=None
    )
    memory: int | None = custom("memory of a job, MB; default: what its points need", _positive, default=None)
    jobs: int = custom("jobs at once, where --jobs is not given", _positive, default=100)
    nodes: int = custom("nodes that the ranks of a point are spread over", _positive, default=1)
    launcher: str = text("starts the ranks of a point", default="srun --mpi=pmi2")
    before: str = custom("shell commands before each job, such as module load ...", _lines, default="")
    options: str = custom("further options for sbatch, such as --constraint=...", _options, default="")
    job_start: float = number("time that it takes to start a job, s", above=0, default=15.0)
    status: Literal["squeue", "sacct"] = choice(
        "how the state of jobs is asked for; sacct needs an accounting database", ("squeue", "sacct"), default="squeue"
    )

    def resources(self, batch: Job) -> dict[str, Any]:
        """Return the resources of a job for Snakemake's Slurm plugin."""
        minutes = self.time or max(_LEAST_MINUTES, math.ceil(max(3 * batch.wall_time, batch.longest) / 60))
        # signal before the limit, to the job steps and not to the shell, which would end at once
        warning = min(_WARNING, minutes * 60 // 3)
        resources, options = _split(self.options)
        found: dict[str, Any] = {
            "runtime": minutes,
            "mem_mb": self.memory or math.ceil(batch.memory / 1e6),
            "slurm_extra": " ".join([f"--signal=TERM@{warning}", *map(shlex.quote, options)]),
            **resources,
        }
        if batch.ranks > 1:
            found |= {"mpi": "srun", "tasks": batch.ranks, "nodes": self.nodes_of(batch)}
        return found

    def nodes_of(self, batch: Job) -> int:
        """Return the number of nodes for the ranks of a batch."""
        return min(self.nodes, batch.ranks)

    def launcher_of(self, batch: Job) -> list[str]:
        """Return the command that starts the ranks of a point."""
        words = self.launcher.split()
        return [*words, "-N", str(self.nodes_of(batch))] if words[0] == "srun" else words

    def to_snakemake(self, name: str) -> list[str]:
        """Return the options of Snakemake for this cluster and the scan ``name``."""
        defaults = [
            *([f"slurm_partition={self.partition}"] if self.partition else []),
            *([f"slurm_account={self.account}"] if self.account else []),
        ]
        return [
            "--slurm-status-command", self.status,
            "--slurm-init-seconds-before-status-checks", "5",
            "--seconds-between-status-checks", "5",
            "--slurm-jobname-prefix", "granwave-" + re.sub(r"[^A-Za-z0-9]", "", name),
            "--slurm-logdir", str(layout.LOGS),
            "--slurm-delete-logfiles-older-than", "0",
            *(["--default-resources", *defaults] if defaults else []),
        ]  # fmt: skip


def load_profile(path: str | Path) -> Profile:
    """Read a profile file.

    Raises
    ------
    InputError
        The file is wrong; the message lists all faults.
    """
    data = read_toml(path)
    errors = ErrorList(str(path))
    if set(data) != {"slurm"}:
        errors.add("slurm", f"found {', '.join(data) or 'nothing'}, expected one table [slurm]")
        raise InputError(errors.lines)
    profile = read_table(Profile, data["slurm"], "slurm", errors)
    if profile is None:
        raise InputError(errors.lines)
    return profile
