"""Profile of a cluster: submission of jobs, for ``--profile`` and ``--submit``."""

from __future__ import annotations

import dataclasses
import math
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from granwave.lammps_inputs.case import schema
from granwave.lammps_inputs.case.schema import ErrorList, ValidationError, show, text
from granwave.lammps_inputs.errors import InputError, Mismatch
from granwave.lammps_inputs.files import read_toml
from granwave.workflows.cluster.scheduler import JobRequest, Scheduler
from granwave.workflows.cluster.schedulers import SCHEDULERS, scheduler
from granwave.workflows.run import mpi

CLUSTER = "cluster"  # table of a profile
SLURM = "slurm"  # the same for profiles of Slurm only
_LINES_FORM = "shell commands, a string or a list of strings"
_LEAST_MINUTES = 10  # shortest default time limit
_LEFT_ALONE = 30  # s for which ranks may continue after one has died
_BYTES_PER_MB = 1e6
_MARGIN = 1.3  # schedulers end jobs that need more memory than they requested


def _lines(lines: tuple[str, ...]) -> str:
    return "\n".join(lines)


def _options(value: str) -> str:
    """Check that options are one line that can be split into words as by a shell."""
    if len(value.splitlines()) > 1:  # the second line would be a command of the script
        raise ValidationError("options of jobs in one line")
    try:
        shlex.split(value)
    except ValueError:  # unbalanced quotation mark
        raise ValidationError("options of jobs, as in a shell") from None
    return value


def _name(value: str) -> str:
    """Check that a name is one word of a directive."""
    if len(value.split()) != 1 or value != value.strip():
        raise ValidationError(_NAME_FORM)
    return value


_LINES = schema.ListType(
    item=schema.TextType(expected=_LINES_FORM, may_be_empty=True),
    expected=_LINES_FORM,
    at_least=0,
    alone=True,
    finish=_lines,
)
_NAME_FORM = "a name without blanks"
_NAME = schema.TextType(expected=_NAME_FORM, finish=_name)
_OPTIONS = schema.TextType(expected="options of jobs, a string", may_be_empty=True, finish=_options)


@dataclasses.dataclass(frozen=True, kw_only=True)
class SlurmProfile:
    """``[slurm]`` of a profile file: the keys of `Profile` for Slurm only."""

    partition: str | None = schema.typed("partition or queue of the jobs", _NAME, default=None)
    account: str | None = schema.typed("account or project to charge", _NAME, default=None)
    time: int | None = schema.count(
        "time limit of a job, minutes; default: three times the expected time", default=None
    )
    memory: int | None = schema.count(
        f"memory of a job on each node, MB; default: {_MARGIN:g} times the expected memory",
        default=None,
    )
    jobs: int = schema.count("number of simultaneous jobs, unless --jobs is given", default=100)
    nodes: int = schema.count("number of nodes for the ranks of a point", default=1)
    launcher: str | None = text(
        "command that starts the ranks of a point; default: srun --mpi=pmi2 with Slurm, flux run "
        "with Flux, otherwise mpiexec",
        default=None,
    )
    before: str = schema.typed(
        "shell commands before each job, such as module load ...", _LINES, default=""
    )
    options: str = schema.typed(
        "further options of jobs, such as --constraint=...", _OPTIONS, default=""
    )
    job_start: float = schema.number("start-up time of a job, s", above=0, default=15.0)
    status: Literal["squeue", "sacct"] = schema.choice(
        "command that returns the state of jobs with Slurm; sacct requires an accounting database",
        ("squeue", "sacct"),
        default="squeue",
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Profile(SlurmProfile):
    """``[cluster]`` of a profile file."""

    scheduler: str = schema.choice("scheduler of the cluster", tuple(SCHEDULERS), default="slurm")
    template: str | None = schema.path(
        "Jinja template for the job script of the site", default=None
    )
    cores: int | None = schema.count(
        "cores of a node: number of ranks of a run, unless --np is given", default=None
    )
    parallel_environment: str | None = schema.typed(
        "parallel environment of Grid Engine for several ranks (qconf -spl lists them)",
        _NAME,
        default=None,
    )

    @property
    def queue(self) -> Scheduler:
        """The scheduler with its commands."""
        return scheduler(self.scheduler, self.status)

    @property
    def ranks(self) -> int:
        """Usual number of ranks of a run: all cores of its nodes, or one if the number is
        unknown.
        """
        return self.nodes * self.cores if self.cores is not None else 1

    def nodes_of(self, ranks: int) -> int:
        """Return the number of nodes of a job with this number of ranks."""
        return min(self.nodes, ranks)

    def minutes(self, wall_time: float, longest: float) -> int:
        """Return the time limit of a job, minutes, from its expected and longest wall time (s)."""
        if self.time is not None:
            return self.time
        return max(_LEAST_MINUTES, math.ceil(max(3 * wall_time, longest) / 60))

    @property
    def launcher_command(self) -> list[str]:
        """Command that starts ranks, without options that depend on their number."""
        return shlex.split(self.launcher or self.queue.launcher)

    def launcher_words(self, ranks: int) -> list[str]:
        """Return the command that starts this number of ranks, without the number."""
        words = self.launcher_command
        if words == ["mpiexec"] and (own := mpi.find_mpiexec()) is not None:
            words = [own]
        if words[0] == "srun":
            words += [f"--wait={_LEFT_ALONE}", "-N", str(self.nodes_of(ranks))]
        return words

    def request(
        self,
        name: str,
        words: Sequence[str],
        *,
        ranks: int,
        minutes: int,
        memory: float,
        logs: str,
        directory: Path,
        after: tuple[str, ...] = (),
    ) -> JobRequest:
        """Return the request of a job; ``memory`` is the expected memory on a node, bytes; the
        other parameters are defined in `JobRequest`.
        """
        return JobRequest(
            name=name,
            words=words,
            ranks=ranks,
            nodes=self.nodes_of(ranks),
            minutes=minutes,
            memory=self.memory or math.ceil(_MARGIN * memory / _BYTES_PER_MB),
            logs=logs,
            directory=directory,
            before=self.before,
            partition=self.partition,
            account=self.account,
            parallel_environment=self.parallel_environment,
            options=self.options,
            after=after,
        )

    def script(self, request: JobRequest) -> str:
        """Return the script of a job; raise InputError as `Scheduler.script`."""
        template = None
        if self.template is not None:
            template = _text_of(Path(self.template))
        return self.queue.script(request, template)


def load_profile(path: str | Path) -> Profile:
    """Read a profile file.

    Raises
    ------
    InputError
        The file is invalid; the message lists all faults.
    """
    data = read_toml(path)
    errors = ErrorList(str(path))
    if set(data) not in ({CLUSTER}, {SLURM}):
        found = ", ".join(data) or "nothing"
        errors.add(CLUSTER, Mismatch(found, f"one table [{CLUSTER}], or [{SLURM}]"))
        raise InputError(errors.items)
    (table,) = data
    profile: Profile | None
    if table == SLURM:
        keys = schema.read_table(SlurmProfile, data[table], table, errors)
        profile = Profile(**dataclasses.asdict(keys)) if keys is not None else None
    else:
        profile = schema.read_table(Profile, data[table], table, errors)
    if profile is not None:
        _check(profile, table, errors)
        if profile.template is not None:
            place = Path(path).absolute().parent / profile.template
            profile = dataclasses.replace(profile, template=str(place))
            if not place.is_file():
                errors.add(f"{table}.template", Mismatch(f"no file {place}", "a script of jobs"))
    if profile is None or errors.items:
        raise InputError(errors.items)
    return profile


def check_executor(profile: Profile, executor: str, path: str | Path) -> None:
    """Raise InputError if the profile at a path is of another scheduler than the executor."""
    if profile.scheduler != executor:
        raise InputError(
            f"--executor: found {executor}, expected {profile.scheduler}, the scheduler of {path}"
        )


def _check(profile: Profile, table: str, errors: ErrorList) -> None:
    """Check keys that depend on the scheduler."""
    if profile.status == "sacct" and profile.scheduler != SLURM:
        errors.add(
            f"{table}.status",
            Mismatch(show(profile.status), remedy="remove it: sacct is a command of Slurm"),
        )
    kind = SCHEDULERS[profile.scheduler]
    for word in shlex.split(profile.options):
        name = word.partition("=")[0]
        key = f"{table}.options"
        if name in kind.keys:
            remedy = f"no {name}: it is the key {table}.{kind.keys[name]}"
            errors.add(key, Mismatch(show(profile.options), remedy))
        elif name in kind.own_options:
            remedy = f"no {name}: granwave sets it for each job"
            errors.add(key, Mismatch(show(profile.options), remedy))


def _text_of(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", "") or "not a text"
        raise InputError(f"{path}: cannot be read: {reason}") from None
