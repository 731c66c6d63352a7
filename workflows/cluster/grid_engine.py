"""Grid Engine: SGE and its successors."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping, Sequence
from typing import ClassVar

from granwave.lammps_inputs.errors import InputError, RunError
from granwave.workflows.cluster.scheduler import JobRequest, Scheduler, ask


class GridEngine(Scheduler):
    """Grid Engine: SGE and its successors."""

    name = "sge"
    title = "Grid Engine"
    queue_type = "SGE"
    job_id = "$JOB_ID"
    log_name = "$JOB_ID.log"
    programs = ("qsub", "qstat", "qdel")
    variables = "SGE_JOB_"
    keys: ClassVar[Mapping[str, str]] = {
        "-q": "partition",
        "-P": "account",
        "-pe": "parallel_environment",
    }
    own_options = ("-N", "-o", "-e", "-j", "-V", "-cwd", "-wd", "-S", "-hold_jid", "-terse")
    remedies: ClassVar[Mapping[str, str]] = {
        "h_rt.*h_vmem": "give a longer time in the profile, or more memory"
    }

    _EMPTY = "<JB_job_number>"

    def script(self, request: JobRequest, template: str | None = None) -> str:
        """Return the script of a job; raise as `Scheduler.script`."""
        if request.ranks > 1 and template is None and request.parallel_environment is None:
            raise InputError(
                "cluster.parallel_environment: missing; Grid Engine needs it for several MPI "
                "ranks: qconf -spl lists the available environments"
            )
        return super().script(request, template)

    def states_in(self, answer: str) -> dict[str, str]:
        """Return the states of jobs; an empty queue has no columns."""
        return super().states_in(answer) if self._EMPTY in answer else {}

    def ended_as(self, job: str, log: Sequence[str]) -> str:
        """Return why Grid Engine ended a job, by its accounting; empty without it."""
        with contextlib.suppress(RunError):
            answer = ask(["qacct", "-j", job])
            if match := re.search(r"^failed\s+[1-9]\d*\s*:\s*(.+?)\s*$", answer, re.MULTILINE):
                return match[1]
        return ""
