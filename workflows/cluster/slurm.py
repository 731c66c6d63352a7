"""Slurm, with or without its accounting."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from granwave.lammps_inputs.errors import RunError
from granwave.workflows.cluster.scheduler import JobRequest, Scheduler, ask


class Slurm(Scheduler):
    """Slurm; it sends the signal before the time limit itself."""

    name = "slurm"
    title = "Slurm"
    queue_type = "SLURM"
    job_id = "$SLURM_JOB_ID"
    log_name = "%j.log"
    programs: ClassVar[tuple[str, ...]] = ("sbatch", "squeue", "scancel", "srun")
    launcher = "srun --mpi=pmi2"
    variables = "SLURM_"
    keys: ClassVar[Mapping[str, str]] = {
        "--partition": "partition", "-p": "partition", "--account": "account", "-A": "account",
        "--time": "time", "-t": "time", "--mem": "memory", "--mem-per-cpu": "memory",
        "--nodes": "nodes", "-N": "nodes",
    }  # fmt: skip
    own_options = (
        "--job-name", "-J", "--output", "-o", "--error", "-e", "--parsable", "--export",
        "--workdir", "--chdir", "-D", "--ntasks", "-n", "--ntasks-per-node", "--cpus-per-task",
        "-c", "--signal", "--wrap",
    )  # fmt: skip
    signs_in_log = re.compile(r"slurmstepd[^:]*: error: (.+)")

    _WITH_STATE = 3  # columns of the list of jobs: id, user and state
    _ENDED = ("ca", "cd", "f", "to", "nf", "oom", "bf", "dl", "pr", "rh", "se")
    _USUAL = ("None", "Resources", "Priority", "BeginTime", "Cleaning", "Prolog", "Dependency")
    _OF_ITSELF = (
        "", "COMPLETED", "COMPLETING", "RUNNING", "PENDING", "CONFIGURING", "SUSPENDED",
    )  # fmt: skip

    def starter(self, request: JobRequest) -> list[str]:
        """Return the words before the command of a job.

        The signal is sent to the steps of the job and not to its shell, which would end
        immediately: a single rank is a step, and several ranks are started as a step by the command
        itself.
        """
        if not request.is_step:
            return super().starter(request)
        return [] if request.ranks > 1 else ["srun", "--ntasks=1", "--cpu-bind=q"]

    def id_in(self, answer: str) -> str:
        """Return the id of a job, without the name of the cluster."""
        return super().id_in(answer.strip().partition(";")[0])

    def queue_command(self) -> list[str]:
        """Return the command that lists the jobs of this user."""
        return [*super().queue_command(), "--me"]

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs that have not ended; names and folders may hold a bar."""
        rows = [line.split("|")[: self._WITH_STATE] for line in answer.splitlines()]
        states = super().states_in("\n".join("|".join([*row, "", ""]) for row in rows))
        return {job: state for job, state in states.items() if state not in self._ENDED}

    def reasons(self) -> dict[str, str]:
        """Return unusual reasons why pending jobs wait, by id; raise as `queue`."""
        answer = ask(["squeue", "--me", "--noheader", "--states=PENDING", "--format=%A|%r"])
        rows = (line.partition("|") for line in answer.splitlines())
        return {job: reason.strip("()") for job, _, reason in rows if reason not in self._USUAL}

    def refusal(self, error: RunError) -> str:
        """Return the objection of Slurm to a job, without the names of its commands."""
        lines = super().refusal(error).split("sbatch: error: ")
        return "; ".join(dict.fromkeys(filter(None, (line.strip(" .") for line in lines))))

    def ended_as(self, job: str, log: Sequence[str]) -> str:
        """Return state, reason and messages of a job that Slurm ended."""
        state, why, code = self._record(job)
        if state in self._OF_ITSELF or (state == "FAILED" and code.endswith(":0")):
            return ""
        if why not in ("None", ""):
            state = f"{state} ({why})"
        errors = "; ".join(self._signs(log))
        return f"{state}: {errors}" if errors else state

    def _record(self, job: str) -> tuple[str, str, str]:
        """Return state, reason and exit code of a job; empty without a record of it."""
        with contextlib.suppress(RunError):  # it has no record of old jobs
            answer = ask(["scontrol", "--oneliner", "show", "job", job])
            matches = [
                re.search(rf"\b{key}=(\S+)", answer) for key in ("JobState", "Reason", "ExitCode")
            ]
            state, why, code = (match[1] if match else "" for match in matches)
            return state, why, code
        with contextlib.suppress(RunError):  # there is no accounting
            answer = ask(["sacct", "-X", "-n", "-P", "-j", job, "-o", "State,Reason,ExitCode"])
            if rows := answer.splitlines():
                state, why, code = rows[-1].split("|")
                return state, why, code
        return "", "", ""


class SlurmAccounting(Slurm):
    """Slurm with an accounting database for the state of jobs."""

    programs = (*Slurm.programs, "sacct")
    listed_after = 60.0

    _UNENDED = (
        "PENDING", "RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING",
        "STOPPED",
    )  # fmt: skip
    _RECENT = "now-30days"

    def queue_command(self) -> list[str]:
        """Return the command that lists the jobs of this user."""
        return ["sacct", "-X", "-n", "-P", f"--starttime={self._RECENT}", "-o", "JobID,State"]

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs that have not ended."""
        rows = (line.partition("|") for line in answer.splitlines())
        states = {job: state for job, _, state in rows if state in self._UNENDED}
        return {job: state.lower() for job, state in states.items()}
