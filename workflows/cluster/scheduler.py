"""A scheduler of a cluster: its scripts, and the commands that submit, list and cancel jobs.

`pysqa` knows the commands and reads their answers. The missing parts are here: our templates, with
the units and the signal before the time limit that runs need, reasons why jobs wait or have ended,
and errors with the answer of a command.
"""

from __future__ import annotations

import dataclasses
import functools
import logging
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.run import mpi

logger = logging.getLogger(__name__)

PENDING = "pending"
JOB_VARIABLE = "GRANWAVE_JOB"  # environment variable of our jobs: their id
_TEMPLATES = Path(__file__).parent / "templates"
_ANSWER = 60.0  # s, time limit for an answer of a scheduler
_WARNING = 90  # s before the time limit at which runs write checkpoints
_MB_PER_GB = 1000


@dataclasses.dataclass(frozen=True, kw_only=True)
class JobRequest:
    """Resources and command of a job.

    Attributes
    ----------
    ranks
        Number of MPI ranks.
    nodes
        Number of nodes that they are spread over.
    minutes
        Time limit.
    memory
        Memory on each node, MB.
    logs
        Folder of the log, relative to the folder that the job is submitted from.
    before
        Shell commands that are executed first.
    words
        Command of the job.
    directory
        Working directory of the command.
    partition, account, parallel_environment, options
        As in the profile of the cluster.
    after
        Ids of jobs that must have ended before.
    is_step
        True: a command on one rank runs as a step of the job, with one core; False: it has all
        cores of the job, and starts steps itself.
    """

    name: str
    ranks: int
    nodes: int
    minutes: int
    memory: int
    logs: str
    words: Sequence[str]
    directory: Path
    before: str = ""
    partition: str | None = None
    account: str | None = None
    parallel_environment: str | None = None
    options: str = ""
    after: tuple[str, ...] = ()
    is_step: bool = True


class Scheduler:
    """Base class of the schedulers.

    Attributes
    ----------
    name
        Word of profiles.
    title
        Name in messages.
    queue_type
        Name in pysqa.
    job_id
        Id of a job in its own shell.
    log_name
        Name of the log of a job, as the scheduler expands it; empty: the scheduler names it.
    log_patterns
        Patterns of that name with the id of the job, for `pathlib.Path.glob`.
    programs
        Commands that must be on a login node.
    launcher
        Usual command that starts MPI ranks in a job.
    listed_after
        Time in which a new job may be missing from the list of jobs, s.
    longest_name
        Largest number of characters in the name of a job.
    variables
        Beginning of the environment variables of a job.
    keys
        Options of the submitting command that are keys of a profile.
    own_options
        Options that granwave gives to each job.
    remedies
        Advice by a pattern in the reason why a job has ended.
    signs_in_log
        Pattern of the lines that the scheduler writes into the log of a job that it ends.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    queue_type: ClassVar[str]
    job_id: ClassVar[str]
    log_name: ClassVar[str] = ""
    log_patterns: ClassVar[tuple[str, ...]] = ("{job}.log",)
    programs: ClassVar[tuple[str, ...]]
    launcher: ClassVar[str] = "mpiexec"
    listed_after: ClassVar[float] = 0.0
    longest_name: ClassVar[int] = 100
    variables: ClassVar[str]
    keys: ClassVar[Mapping[str, str]] = {}
    own_options: ClassVar[tuple[str, ...]] = ()
    remedies: ClassVar[Mapping[str, str]] = {
        r"OUT_OF_MEMORY|MEMLIMIT|oom|memory|mem \d": "give more memory in the profile",
        r"TIMEOUT|TIME LIMIT|RUNLIMIT|walltime": "give a longer time in the profile",
    }
    signs_in_log: ClassVar[re.Pattern[str] | None] = None

    # ------------------------------------------------------------------ scripts

    def script(self, request: JobRequest, template: str | None = None) -> str:
        """Return the script of a job.

        Parameters
        ----------
        template
            Text of a site's own template (Jinja); by default ours.

        Raises
        ------
        InputError
            The template cannot be read, or the job needs a key of the profile that is not set.
        """
        from jinja2 import TemplateError
        from pysqa.wrapper.abstract import SchedulerCommands

        if template is None:
            template = (_TEMPLATES / f"{self.name}.sh").read_text(encoding="utf-8")
        tasks = -(-request.ranks // request.nodes)
        seconds = request.minutes * 60
        hours, minutes = divmod(request.minutes, 60)
        try:
            return SchedulerCommands.render_submission_template(
                command=self.commands_of_job(request),
                submission_template=template,
                job_name=_plain(request.name)[: self.longest_name],
                working_directory=str(request.directory),
                cores=request.ranks,
                memory_max=-(-request.memory // _MB_PER_GB),
                run_time_max=seconds,
                dependency_list=list(request.after),
                nodes=request.nodes,
                tasks_per_node=tasks,
                minutes=request.minutes,
                walltime=f"{hours:02d}:{minutes:02d}:00",
                memory_mb=request.memory,
                total_memory_mb=request.memory * request.nodes,
                warning=before_limit(seconds),
                log=f"{request.logs}/{self.log_name}",
                partition=request.partition,
                account=request.account,
                parallel_environment=request.parallel_environment,
                options=request.options,
            ).rstrip("\n") + "\n"  # fmt: skip
        except TemplateError as error:
            raise InputError(f"template of jobs: {error}") from None

    def commands_of_job(self, request: JobRequest) -> str:
        """Return the shell commands of a job: first the options of the profile, then the commands
        of the job.
        """
        lines = [
            "set -euo pipefail",
            f"cd {shlex.quote(str(request.directory))}",
            f"export {JOB_VARIABLE}={self.job_id}",
        ]
        if request.before:
            lines.append(request.before)
        lines.append(f"exec {shlex.join([*self.starter(request), *request.words])}")
        return "\n".join(lines)

    def starter(self, request: JobRequest) -> list[str]:
        """Return the words before the command of a job: it gets SIGTERM before the time limit."""
        seconds = request.minutes * 60
        words = ["timeout", "--foreground", "--preserve-status", "--signal=TERM"]
        return [*words, str(seconds - before_limit(seconds))]

    # ------------------------------------------------------------------ the queue

    @functools.cached_property
    def commands(self) -> Any:
        """Commands of the scheduler, of pysqa.

        Raises
        ------
        RunError
            A module of the scheduler is missing.
        """
        from pysqa.base.core import get_queue_commands

        try:
            return get_queue_commands(self.queue_type)
        except ImportError as error:
            raise RunError(
                f"{self.title}: the Python module {error.name} is missing; "
                "install the version of the cluster"
            ) from None

    def check(self, option: str, otherwise: str = "") -> None:
        """Check that this is a login node: all programs are there, and the queue answers.

        Raises
        ------
        InputError
            It is not; ``option`` is named in the message, and ``otherwise`` is advice at its end.
        """
        for program in self.programs:
            if shutil.which(program) is None:
                raise InputError(
                    f"{option}: there is no {program} here; run it on a login node of the "
                    f"cluster{otherwise}"
                )
        try:
            self.queue()
        except RunError as error:
            raise InputError(f"{option}: {error}") from None

    def submit(self, script: str, directory: Path) -> str:
        """Submit a script from a directory; return the id of the job.

        Raises
        ------
        RunError
            The scheduler rejects it.
        """
        kept = {
            name: value
            for name, value in mpi.alone().items()
            if not name.startswith(self.variables)
        }
        command = self.commands.submit_job_command
        answer = ask(command, input=script, env=kept, cwd=directory)
        try:
            return self.id_in(answer)
        except (ValueError, IndexError):
            raise RunError(
                f"{command[0]}: found {' '.join(answer.split())!r}, expected the id of a job"
            ) from None

    def id_in(self, answer: str) -> str:
        """Return the id of a job from the answer to its submission."""
        return str(int(self.commands.get_job_id_from_output(answer)))

    def queue(self) -> dict[str, str]:
        """Return the states of all jobs that have not ended, by id.

        Raises
        ------
        RunError
            The scheduler does not answer.
        """
        command = self.queue_command()
        answer = ask(command)
        try:
            return self.states_in(answer)
        except (LookupError, TypeError, ValueError, SyntaxError, AttributeError) as error:
            raise RunError(f"the answer of {' '.join(command)} cannot be read: {error}") from None

    def queue_command(self) -> list[str]:
        """Return the command that lists the jobs."""
        return list(self.commands.get_queue_status_command)

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs, by id, from the answer of the `queue_command`."""
        table = self.commands.convert_queue_status(answer)
        ids = (str(int(name)) for name in table["jobid"])
        return dict(zip(ids, table["status"], strict=True))

    def cancel(self, jobs: Iterable[str]) -> None:
        """Cancel jobs; log a warning if the scheduler rejects this, for instance because they have
        ended.
        """
        for job in jobs:
            try:
                ask([*self.commands.delete_job_command, job])
            except RunError as error:
                logger.warning("job %s was not cancelled: %s", job, error)

    def reasons(self) -> dict[str, str]:
        """Return unusual reasons why pending jobs wait, by id; raise as `queue`."""
        return {}

    def refusal(self, error: RunError) -> str:
        """Return the objection of the scheduler to a job, without the name of the command."""
        return str(error).removeprefix(f"{self.commands.submit_job_command[0]} failed: ")

    # ------------------------------------------------------------------ how jobs end

    def end_of(self, job: str, log: Sequence[str]) -> str:
        """Return why the scheduler ended a job, with a remedy; empty if it did not, or has no
        record of the job.

        An example is ``TIMEOUT (TimeLimit): JOB 17 ON n1 CANCELLED AT ... DUE TO TIME LIMIT; give
        a longer time in the profile``.

        Parameters
        ----------
        log
            Lines of the log of the job.
        """
        reason = self.ended_as(job, log)
        if not reason:
            return ""
        remedies = (
            remedy
            for sign, remedy in self.remedies.items()
            if re.search(sign, reason, re.IGNORECASE)
        )
        remedy = next(remedies, "")
        return f"{self.title} ended job {job}: {reason}{f'; {remedy}' if remedy else ''}"

    def ended_as(self, job: str, log: Sequence[str]) -> str:
        """Return the words of the scheduler for the end of a job; empty if it did not end it."""
        return "; ".join(self._signs(log))

    def _signs(self, log: Sequence[str]) -> list[str]:
        """Return the messages of the scheduler in the log of a job, each line once."""
        if self.signs_in_log is None:
            return []
        matches = (self.signs_in_log.match(line) for line in log)
        return list(dict.fromkeys(match[1].strip("* ") for match in matches if match))


def ask(command: Sequence[str], **options: Any) -> str:
    """Return the output of a command of a scheduler, run with options of `subprocess.run`; raise
    RunError on failure.
    """
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_ANSWER, check=False, **options
        )
    except OSError as error:
        raise RunError(f"{command[0]} cannot be run: {error.strerror}") from None
    except subprocess.TimeoutExpired:
        raise RunError(f"{command[0]} does not answer; is the scheduler up?") from None
    if done.returncode:
        raise RunError(f"{command[0]} failed: {' '.join(done.stderr.split())}")
    return done.stdout


def before_limit(seconds: int) -> int:
    """Return how long before a time limit runs write checkpoints, s."""
    return min(_WARNING, seconds // 3)


def _plain(name: str) -> str:
    """Return a name of letters, digits and hyphens."""
    return re.sub(r"[^A-Za-z0-9-]", "", name)
