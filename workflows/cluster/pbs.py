"""PBS and related schedulers: Torque, and Moab, which runs jobs in the same environment."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import ClassVar

from granwave.workflows.cluster.scheduler import PENDING, Scheduler


class Pbs(Scheduler):
    """PBS Professional and OpenPBS.

    pysqa cannot read lists with array jobs. It treats ended jobs, which are listed for some time,
    as pending jobs.
    """

    name = "pbs"
    title = "PBS"
    queue_type = "TORQUE"
    job_id = "${PBS_JOBID%%.*}"
    programs = ("qsub", "qstat", "qdel")
    variables = "PBS_"
    longest_name = 15
    log_patterns = ("{job}.*.OU", "*.o{job}")  # PBS: of a log in a folder; Torque
    keys: ClassVar[Mapping[str, str]] = {"-q": "partition", "-A": "account"}
    own_options = ("-N", "-o", "-e", "-j", "-V", "-S")
    signs_in_log = re.compile(r"=>> PBS: (?:job killed: )?(.+)")

    _JOB = re.compile(r"^Job Id: (\d+)\b(?!\[)(?:(?!^Job Id:).)*?job_state = (\w)", re.M | re.S)
    _STATES: ClassVar[Mapping[str, str]] = {
        "R": "running", "E": "running", "B": "running", "C": "", "F": "", "X": "",
    }  # fmt: skip

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs that have not ended."""
        jobs = {job: self._STATES.get(word, PENDING) for job, word in self._JOB.findall(answer)}
        return {job: state for job, state in jobs.items() if state}


class Torque(Pbs):
    """Torque."""

    name = "torque"
    title = "Torque"


class Moab(Pbs):
    """Moab, whose answers pysqa cannot read."""

    name = "moab"
    title = "Moab"
    queue_type = "MOAB"
    programs = ("msub", "mjobctl", "showq")

    _JOB = re.compile(r'<job [^>]*?JobID="([^"]+)"[^>]*?State="(\w+)"')

    def id_in(self, answer: str) -> str:
        """Return the id of a job: the last word."""
        return answer.split()[-1]

    def queue_command(self) -> list[str]:
        """Return the command that lists the jobs."""
        return ["showq", "--xml"]

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs that have not ended."""
        return {
            job: "running" if state == "Running" else PENDING
            for job, state in self._JOB.findall(answer)
        }
